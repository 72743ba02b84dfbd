//! The regions R_o of the (alpha, gamma) plane, in each of which one option is preferred.

use super::{Perception, Prospect, Ways, human_choice};

/// Numbers of rows in gamma and of columns in alpha that are evaluated first; borders are searched for
/// between neighbours that differ.
const ROWS: usize = 160;
const COLUMNS: usize = 160;
/// Accuracy of borders.
const BORDER_TOLERANCE: f64 = 1e-9;

/// The plane of perceptions, cut into regions of one preferred option each (Sec. IV-A).
#[derive(Clone, Debug, PartialEq)]
pub struct Regions {
    /// The range of alpha.
    pub alpha: [f64; 2],
    /// The range of gamma.
    pub gamma: [f64; 2],
    /// Parts of regions. They do not overlap and fill the ranges.
    pub parts: Vec<Region>,
    /// The lines along which parts of two different options meet.
    pub borders: Vec<Vec<Perception>>,
}

/// A part of the plane in which one option is preferred.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// The option's index.
    pub option: usize,
    /// The corners of its outline.
    pub outline: Vec<Perception>,
}

/// Options from low to high alpha at one gamma, each with the alpha at which its part begins.
#[derive(Clone)]
struct GammaRow {
    gamma: f64,
    parts: Vec<(usize, f64)>,
}

impl Regions {
    /// The regions over these ranges, by eq. (3) itself. Borders are accurate to 1e-9 on the rows and
    /// straight between rows. A region narrower than 1/160 of a range may be missed.
    pub fn new(prospects: &[Prospect], risk_weight: f64, alpha: [f64; 2], gamma: [f64; 2]) -> Self {
        Self::of_ways(prospects, &Ways::default(), risk_weight, alpha, gamma)
    }

    /// [`Regions::new`] during an episode, in which several options may have become one way. They are one
    /// choice: the region is that of the option that represents them.
    pub fn of_ways(
        prospects: &[Prospect],
        ways: &Ways,
        risk_weight: f64,
        alpha: [f64; 2],
        gamma: [f64; 2],
    ) -> Self {
        let row = |gamma: f64| {
            let choice = |alpha: f64| human_choice(prospects, risk_weight, Perception { alpha, gamma }, None);
            let preferred = |alpha: f64| ways.representative(choice(alpha));
            GammaRow { gamma, parts: along(alpha, &preferred) }
        };
        let mut regions = Self { alpha, gamma, parts: Vec::new(), borders: Vec::new() };
        let mut band = vec![row(gamma[0])];
        for i in 1..=ROWS {
            let next = row(gamma[0] + (gamma[1] - gamma[0]) * i as f64 / ROWS as f64);
            // options may appear and disappear between two rows: one band ends just before the change, and
            // the next begins just after it
            while let Some(last) = band.last().filter(|last| !last.is_like(&next)) {
                let (mut before, mut behind) = (last.clone(), next.clone());
                while behind.gamma - before.gamma > BORDER_TOLERANCE {
                    let middle = row(0.5 * (before.gamma + behind.gamma));
                    if middle.is_like(&before) { before = middle } else { behind = middle }
                }
                band.push(before);
                regions.add(&std::mem::replace(&mut band, vec![behind]));
            }
            band.push(next);
        }
        regions.add(&band);
        regions
    }

    /// Adds the rows of one band, which have the same options in the same order.
    fn add(&mut self, rows: &[GammaRow]) {
        let Some(first) = rows.first() else { return };
        let border = |part: usize| {
            let start = |row: &GammaRow| row.parts.get(part).map_or(self.alpha[1], |p| p.1);
            rows.iter().map(|row| Perception { alpha: start(row), gamma: row.gamma }).collect::<Vec<_>>()
        };
        let borders: Vec<_> = (0..=first.parts.len()).map(border).collect();
        for (sides, (option, _)) in borders.windows(2).zip(&first.parts) {
            let outline = sides[0].iter().chain(sides[1].iter().rev()).copied().collect();
            self.parts.push(Region { option: *option, outline });
        }
        self.borders.extend(borders.into_iter().skip(1).take(first.parts.len() - 1));
    }
}

impl GammaRow {
    fn is_like(&self, other: &Self) -> bool {
        self.parts.iter().map(|p| p.0).eq(other.parts.iter().map(|p| p.0))
    }
}

/// The options preferred along a range, each with the value at which its part begins.
fn along([low, high]: [f64; 2], preferred: &dyn Fn(f64) -> usize) -> Vec<(usize, f64)> {
    let mut last = (low, preferred(low));
    let mut parts = vec![(last.1, low)];
    for i in 1..=COLUMNS {
        let at = low + (high - low) * i as f64 / COLUMNS as f64;
        let here = (at, preferred(at));
        search(last, here, preferred, &mut parts);
        last = here;
    }
    parts
}

/// Adds every change of the preferred option between two values.
fn search(
    from: (f64, usize),
    to: (f64, usize),
    preferred: &dyn Fn(f64) -> usize,
    parts: &mut Vec<(usize, f64)>,
) {
    if from.1 == to.1 {
        return;
    }
    if to.0 - from.0 < BORDER_TOLERANCE {
        parts.push((to.1, to.0));
        return;
    }
    let middle = 0.5 * (from.0 + to.0);
    let middle = (middle, preferred(middle));
    search(from, middle, preferred, parts);
    search(middle, to, preferred, parts);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preference::{Belief, ChoiceDistribution, Predictor};

    /// Area of an outline over that of the ranges.
    fn share(regions: &Regions, outline: &[Perception]) -> f64 {
        let next = outline.iter().cycle().skip(1);
        let doubled: f64 = outline.iter().zip(next).map(|(a, b)| a.alpha * b.gamma - b.alpha * a.gamma).sum();
        let all = (regions.alpha[1] - regions.alpha[0]) * (regions.gamma[1] - regions.gamma[0]);
        doubled.abs() / 2.0 / all
    }

    #[test]
    fn property_areas_of_regions_are_the_probabilities() {
        // crossing borders, a region that ends inside, lengths below 1 m, an option that is never preferred
        let sets: [&[(f64, f64)]; 4] = [
            &[(41.86, 0.66), (17.4, 0.363), (14.33, 0.547), (21.36, 0.247)],
            &[(18.07, 0.456), (28.54, 0.202), (13.34, 0.689), (18.06, 0.457)],
            &[(0.2, 0.9), (0.9, 0.4), (3.0, 0.2)],
            &[(5.0, 0.5)],
        ];
        for set in sets {
            let prospects: Vec<Prospect> = set.iter().map(|(d, s)| Prospect::new(*d, *s)).collect();
            let regions = Regions::new(&prospects, 10.0, [0.55, 0.95], [0.5, 1.1]);
            let mut shares = vec![0.0; prospects.len()];
            for part in &regions.parts {
                shares[part.option] += share(&regions, &part.outline);
            }
            let mut choice = ChoiceDistribution::default();
            Predictor::new(Belief::default(), 10.0).unwrap().predict(&prospects, &mut choice);
            for (share, probability) in shares.iter().zip(choice.probabilities()) {
                assert!((share - probability).abs() < 1e-4, "{shares:?} and {choice:?}");
            }
        }
    }
}
