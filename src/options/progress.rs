//! The team's progress on every option.

use super::passage::{Crossing, Passage};
use super::path_option::PathOption;
use crate::geometry::Point;
use serde::{Deserialize, Serialize};

/// The team's position and its progress on every option.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// Position of the team, m, world frame.
    pub position: Point,
    /// The crossing in progress: the team is beyond the gap and has not left the straight part yet. Once left,
    /// it is behind the team until the team crosses back.
    pub(super) inside: Option<Crossing>,
    pub(super) rests: Vec<Rest>,
    /// The value of `rests` after the team leaves the straight part; meaningful while `inside` is set.
    pub(super) rests_outside: Vec<Rest>,
}

/// The remainder of one option.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Rest {
    /// Number of the option's crossings behind the team, or behind the point where the team returns to the
    /// option.
    pub place: usize,
    /// Crossings that lead back to the option, the first one last.
    pub back: Vec<Crossing>,
    /// Whether the option no longer follows the straight part that the team is in. An option that once leaves
    /// it does not return into it, or its path could get longer as the team walks it.
    #[serde(default)]
    pub has_left: bool,
}

impl Rest {
    /// The crossings still to be made.
    pub fn ahead<'a>(&'a self, option: &'a PathOption) -> impl Iterator<Item = Crossing> + 'a {
        self.back.iter().rev().chain(&option.crossings[self.place..]).copied()
    }

    /// Records that the team made `crossing` into `region`.
    fn cross(&mut self, option: &PathOption, crossing: Crossing, region: usize) {
        if self.back.is_empty() && option.crossings.get(self.place) == Some(&crossing) {
            self.place += 1;
        } else if let Some(place) = visit(option, self.place, region) {
            self.place = place;
            self.back.clear();
        } else if self.back.last() == Some(&crossing) {
            self.back.pop();
        } else {
            self.back.push(crossing.back());
        }
    }
}

/// The index at which an option visits a region: the first at or after the present place, else the last
/// before it.
fn visit(option: &PathOption, place: usize, region: usize) -> Option<usize> {
    let later = option.regions[place..].iter().position(|&r| r == region).map(|i| place + i);
    later.or_else(|| option.regions[..place].iter().rposition(|&r| r == region))
}

/// The crossings that a straight step makes, in order along the step.
pub(super) fn crossings(passages: &[Passage], from: Point, to: Point) -> impl Iterator<Item = Crossing> + '_ {
    let mut walked = -1.0;
    std::iter::from_fn(move || {
        let (t, crossing) = passages
            .iter()
            .enumerate()
            .filter_map(|(opening, p)| p.crossed(from, to).map(|(t, into)| (t, Crossing { opening, into })))
            .filter(|(t, _)| *t > walked)
            .min_by(|a, b| a.0.total_cmp(&b.0))?;
        walked = t;
        Some(crossing)
    })
}

impl Progress {
    pub(super) fn new(position: Point, options: usize) -> Self {
        // capacity for what may happen on the way, so that steps do not allocate; cloning a vector would not
        // keep it
        let rest = || Rest { back: Vec::with_capacity(8), ..Rest::default() };
        let rests = || (0..options).map(|_| rest()).collect();
        Self { position, inside: None, rests_outside: rests(), rests: rests() }
    }

    /// The remainder of an option once the team has left the straight part that it is in.
    pub(super) fn rest(&self, option: usize) -> &Rest {
        let rests = if self.inside.is_some() { &self.rests_outside } else { &self.rests };
        &rests[option]
    }

    /// Appends everything that the options' remainders depend on: no two that differ have the same words.
    pub(crate) fn write_words(&self, words: &mut Vec<u64>) {
        let word = |crossing: &Crossing| (crossing.opening << 1 | crossing.into) as u64;
        words.extend([self.position.x.to_bits(), self.position.y.to_bits()]);
        words.push(self.inside.as_ref().map_or(0, |crossing| word(crossing) + 1));
        for option in 0..self.rests.len() {
            let Rest { place, back, has_left } = self.rest(option);
            words.push((*place as u64) << 32 | (back.len() as u64) << 1 | u64::from(*has_left));
            words.extend(back.iter().map(word));
        }
    }

    /// Whether the progress fits these passages and options.
    pub(super) fn is_among(&self, passages: &[Passage], options: &[PathOption]) -> bool {
        let is_crossing = |c: &Crossing| c.opening < passages.len() && c.into < 2;
        let are_rests = |rests: &[Rest]| {
            let is_rest = |(rest, option): (&Rest, &PathOption)| {
                rest.place <= option.crossings.len() && rest.back.iter().all(is_crossing)
            };
            rests.len() == options.len() && rests.iter().zip(options).all(is_rest)
        };
        let crossings = self.inside.iter().all(is_crossing);
        let position = self.position.iter().all(|c| c.is_finite());
        position && crossings && are_rests(&self.rests) && are_rests(&self.rests_outside)
    }

    pub(super) fn advance(
        &mut self,
        to: Point,
        passages: &[Passage],
        options: &[PathOption],
        region_after: impl Fn(Crossing) -> usize,
        exit: impl Fn(Crossing, &Rest, &PathOption) -> f64,
    ) {
        let from = std::mem::replace(&mut self.position, to);
        for crossing in crossings(passages, from, to) {
            if self.inside.take_if(|c| c.back() == crossing).is_none() {
                self.leave();
                self.enter(crossing, options, region_after(crossing));
            }
        }
        let Some(inside) = self.inside else { return };
        let passage = &passages[inside.opening];
        if !passage.keeps(to, inside.into) {
            return self.leave();
        }
        for (rest, option) in self.rests_outside.iter_mut().zip(options) {
            let reach = exit(inside, rest, option);
            rest.has_left |= passage.exit(to, inside.into, reach).is_none();
        }
    }

    fn enter(&mut self, crossing: Crossing, options: &[PathOption], region: usize) {
        self.inside = Some(crossing);
        self.rests_outside.clone_from(&self.rests);
        for (rest, option) in self.rests_outside.iter_mut().zip(options) {
            rest.cross(option, crossing, region);
            rest.has_left = false;
        }
    }

    fn leave(&mut self) {
        if self.inside.take().is_some() {
            std::mem::swap(&mut self.rests, &mut self.rests_outside);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::options::{OptionSet, Remaining};
    use crate::world::{BUILT_IN_WORLDS, World};
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use std::collections::HashMap;

    #[test]
    fn property_equal_words_have_equal_remainders() {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        for built_in in BUILT_IN_WORLDS {
            let world = World::parse(built_in.name, built_in.text).unwrap();
            let set = OptionSet::new(&world, 10.0).unwrap();
            let mut seen: HashMap<Vec<u64>, Vec<Remaining>> = HashMap::new();
            for _ in 0..40 {
                let mut progress = set.begin();
                // a few metres on one option, then on another, also back
                for _ in 0..8 {
                    let option = rng.random_range(0..set.options().len());
                    let Some(path) = set.path(&progress, option) else { break };
                    for step in 1..=12 {
                        // on a grid, so that teams with other pasts come to the same place
                        let at = path.point_at((f64::from(step) * 0.5).min(path.length())).unwrap();
                        set.advance(&mut progress, at.map(|c| (c * 4.0).round() / 4.0));
                        let mut words = Vec::new();
                        progress.write_words(&mut words);
                        let all: Vec<Remaining> = set.all_remaining(&progress).collect();
                        assert_eq!(
                            seen.entry(words).or_insert_with(|| all.clone()),
                            &all,
                            "{}",
                            built_in.name
                        );
                    }
                }
            }
        }
    }
}
