//! The steps of the team in; the place that it has on every option out.

use super::PathOption;
use super::passage::{Crossing, Passage};
use crate::geometry::Point;

/// Where the team is, and where that is on every option.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress {
    /// Position of the team, m, world frame.
    pub position: Point,
    /// The crossing whose straight part, beyond the gap, the team has not left yet.
    pub(super) inside: Option<Crossing>,
    pub(super) rests: Vec<Rest>,
}

/// What is left of one option.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Rest {
    /// How many of the option's crossings are behind the team (or behind the point that it comes back to).
    pub place: usize,
    /// Crossings that lead back to the option, the first one last.
    pub back: Vec<Crossing>,
}

impl Rest {
    /// The crossings still to be made.
    pub fn ahead<'a>(&'a self, option: &'a PathOption) -> impl Iterator<Item = Crossing> + 'a {
        self.back.iter().rev().chain(&option.crossings[self.place..]).copied()
    }

    /// Takes note that the team went through `crossing` into `region`.
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

/// The place at which an option visits a region: the first at or after the present place, else the last before it.
fn visit(option: &PathOption, place: usize, region: usize) -> Option<usize> {
    let later = option.regions[place..].iter().position(|&r| r == region).map(|i| place + i);
    later.or_else(|| option.regions[..place].iter().rposition(|&r| r == region))
}

impl Progress {
    pub(super) fn new(position: Point, options: usize) -> Self {
        Self { position, inside: None, rests: vec![Rest::default(); options] }
    }

    pub(super) fn advance(
        &mut self,
        to: Point,
        passages: &[Passage],
        options: &[PathOption],
        region_after: impl Fn(Crossing) -> usize,
    ) {
        let from = std::mem::replace(&mut self.position, to);
        let mut walked = -1.0;
        // one step may go through several openings: take them in the order of the way
        while let Some((t, crossing)) = passages
            .iter()
            .enumerate()
            .filter_map(|(opening, p)| p.crossed(from, to).map(|(t, into)| (t, Crossing { opening, into })))
            .filter(|(t, _)| *t > walked)
            .min_by(|a, b| a.0.total_cmp(&b.0))
        {
            walked = t;
            self.inside = Some(crossing);
            for (rest, option) in self.rests.iter_mut().zip(options) {
                rest.cross(option, crossing, region_after(crossing));
            }
        }
        self.inside = self.inside.filter(|c| {
            let passage = &passages[c.opening];
            passage.holds(to, c.into) && passage.depth(to, c.into) < passage.reach[c.into]
        });
    }
}
