//! Probabilities of a noisy-rational (Boltzmann) human's choices: the mean of exp(-beta J^_o) / sum_p
//! exp(-beta J^_p) over independent alpha and gamma.
//!
//! The range of (alpha, gamma) is cut into cells until, in each, the costs of the options that matter there
//! move by little relative to each other. The choice is then a smooth function on the cell, which a product
//! of two Gauss rules integrates to about 1e-11. Costs are a sum of a part by alpha and one by gamma, so a
//! cell takes a few exponentials for each option.

use super::curve::Curve;
use super::rule::{NODES, Rule, Samples};
use super::strips::Domain;
use super::ties::Ties;
use super::{Marginal, Prospect, WeightedSample, subjective_cost};
use crate::math;

/// The largest change, over a cell, of the exponent of an option that matters there, relative to the best
/// one's.
const MAX_CHANGE: f64 = 2.0;

/// Exponents below that of the best option by which an option does not matter: exp(-36) is a rounding error.
const NEGLIGIBLE: f64 = 36.0;

/// The largest number of cells. It is far beyond any real set of options and ends every loop.
const MAX_CELLS: usize = 1_000_000;

/// The integrator, with its memory.
#[derive(Debug, Clone)]
pub(super) struct Softmax {
    rule: Rule,
    cells: Vec<Cell>,
    parts: Vec<Parts>,
    terms: Vec<Term>,
}

#[derive(Debug, Clone, Copy)]
struct Cell {
    alpha: [f64; 2],
    gamma: [f64; 2],
}

/// beta times the cost of an option's length, and of its risk, at the low end, the middle and the high end of a
/// cell.
#[derive(Debug, Clone, Copy)]
struct Parts {
    by_alpha: [f64; 3],
    by_gamma: [f64; 3],
}

/// An option that matters in a cell, relative to the best one in its middle: factors of its weight at the
/// nodes.
#[derive(Debug, Clone, Copy)]
struct Term {
    choice: usize,
    by_alpha: Samples,
    by_gamma: Samples,
}

/// A choice: an option's curve, and the number of tied ways that it stands for.
pub(super) type Choice = (Curve, f64);

/// Adds to `masses` the probability of each choice of one sample's humans.
pub(super) fn add_sample(
    sample: &WeightedSample,
    ties: &Ties,
    risk_weight: f64,
    rationality: f64,
    masses: &mut [f64],
) {
    let cost = |prospect: Prospect| subjective_cost(prospect, risk_weight, sample.perception);
    let least = ties.leaders().map(|(_, prospect)| cost(prospect)).fold(f64::INFINITY, f64::min);
    let weight = |(leader, prospect): (usize, Prospect)| {
        ties.ways(leader) * math::exp(rationality * (least - cost(prospect)))
    };
    let total: f64 = ties.leaders().map(weight).sum();
    for leader in ties.leaders() {
        masses[leader.0] += sample.weight * weight(leader) / total;
    }
}

impl Parts {
    fn in_middle(&self) -> f64 {
        self.by_alpha[1] + self.by_gamma[1]
    }

    /// How far the difference to another option's parts moves with alpha, and with gamma.
    fn changes(&self, other: &Self) -> [f64; 2] {
        [(&self.by_alpha, &other.by_alpha), (&self.by_gamma, &other.by_gamma)].map(|(mine, others)| {
            let differences = mine.iter().zip(others).map(|(a, b)| a - b);
            let (low, high) = differences
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), difference| {
                    (low.min(difference), high.max(difference))
                });
            high - low
        })
    }
}

impl Softmax {
    pub fn new() -> Self {
        Self { rule: Rule::new(), cells: Vec::new(), parts: Vec::new(), terms: Vec::new() }
    }

    /// Adds to `masses` the probability of each choice, of finite length. `scales` are the factors of the
    /// perceived length and of the perceived risk in the exponent.
    pub fn integrate(&mut self, choices: &[Choice], scales: [f64; 2], domain: &Domain, masses: &mut [f64]) {
        self.cells.clear();
        for alpha in pieces(&domain.alpha, &domain.alpha_panels) {
            let gammas = pieces(&domain.gamma, &domain.gamma_panels);
            self.cells.extend(gammas.map(|gamma| Cell { alpha, gamma }));
        }
        let mut done = 0;
        while let Some(cell) = self.cells.pop() {
            done += 1;
            self.set_parts(choices, scales, cell);
            let change = self.contenders();
            let widest = if change[0] >= change[1] { 0 } else { 1 };
            if change[widest] > MAX_CHANGE && done < MAX_CELLS {
                self.cells.extend(cell.halves(widest));
            } else {
                self.add(choices, scales, cell, domain, masses);
            }
        }
    }

    fn set_parts(&mut self, choices: &[Choice], [length, risk]: [f64; 2], cell: Cell) {
        let at = |[low, high]: [f64; 2]| [low, 0.5 * (low + high), high];
        self.parts.clear();
        self.parts.extend(choices.iter().map(|(curve, _)| Parts {
            by_alpha: at(cell.alpha).map(|alpha| length * curve.perceived_length(alpha)),
            by_gamma: at(cell.gamma).map(|gamma| risk * curve.perceived_risk(gamma)),
        }));
    }

    /// Finds the choices that matter in the cell, the best one in its middle first, and the largest changes of
    /// their exponents with alpha and gamma.
    fn contenders(&mut self) -> [f64; 2] {
        let best = (0..self.parts.len())
            .min_by(|&a, &b| self.parts[a].in_middle().total_cmp(&self.parts[b].in_middle()));
        self.terms.clear();
        let Some(best) = best else { return [0.0; 2] };
        let of_best = self.parts[best];
        let mut largest = [0.0f64; 2];
        let term = |choice| Term { choice, by_alpha: [0.0; NODES], by_gamma: [0.0; NODES] };
        self.terms.push(term(best));
        for (choice, parts) in self.parts.iter().enumerate().filter(|(choice, _)| *choice != best) {
            let changes = parts.changes(&of_best);
            // between the three places the difference may move further
            let nearest = parts.in_middle() - of_best.in_middle() - 1.5 * (changes[0] + changes[1]);
            if nearest <= NEGLIGIBLE {
                largest = [largest[0].max(changes[0]), largest[1].max(changes[1])];
                self.terms.push(term(choice));
            }
        }
        largest
    }

    /// Adds a cell's probabilities.
    fn add(&mut self, choices: &[Choice], scales: [f64; 2], cell: Cell, domain: &Domain, masses: &mut [f64]) {
        let Self { rule, parts, terms, .. } = self;
        let [best, others @ ..] = terms.as_mut_slice() else { return };
        let (best_curve, best_ways) = &choices[best.choice];
        let share = |[low, high]: [f64; 2], marginal: &Marginal| marginal.cdf(high) - marginal.cdf(low);
        let mut rest = share(cell.alpha, &domain.alpha) * share(cell.gamma, &domain.gamma);
        if !others.is_empty() {
            let [alphas, gammas] = [cell.alpha, cell.gamma]
                .map(|[low, high]| rule.nodes.map(|node| 0.5 * (low + high) + 0.5 * (high - low) * node));
            let of_best = parts[best.choice];
            for term in others.iter_mut() {
                let ((curve, ways), mine) = (&choices[term.choice], parts[term.choice]);
                let middle = [mine.by_alpha[1] - of_best.by_alpha[1], mine.by_gamma[1] - of_best.by_gamma[1]];
                let in_middle = math::exp(-(middle[0] + middle[1])) * ways / best_ways;
                term.by_alpha = alphas.map(|alpha| {
                    let longer = curve.perceived_length(alpha) - best_curve.perceived_length(alpha);
                    in_middle * math::exp(middle[0] - scales[0] * longer)
                });
                term.by_gamma = gammas.map(|gamma| {
                    let riskier = curve.perceived_risk(gamma) - best_curve.perceived_risk(gamma);
                    math::exp(middle[1] - scales[1] * riskier)
                });
            }
            let quarter = 0.25 * (cell.alpha[1] - cell.alpha[0]) * (cell.gamma[1] - cell.gamma[0]);
            for (a, alpha) in alphas.iter().enumerate() {
                let weight = quarter * rule.weights[a] * domain.alpha.density(*alpha);
                for (g, gamma) in gammas.iter().enumerate() {
                    let weight = weight * rule.weights[g] * domain.gamma.density(*gamma);
                    let total = 1.0 + others.iter().map(|t| t.by_alpha[a] * t.by_gamma[g]).sum::<f64>();
                    for term in others.iter() {
                        let share = weight * term.by_alpha[a] * term.by_gamma[g] / total;
                        masses[choices[term.choice].0.option] += share;
                        rest -= share;
                    }
                }
            }
        }
        masses[best_curve.option] += rest;
    }
}

/// A marginal's panels, in pieces of at most two standard deviations where a normal has its probability.
fn pieces<'a>(marginal: &'a Marginal, panels: &'a [f64]) -> impl Iterator<Item = [f64; 2]> + 'a {
    panels.windows(2).flat_map(move |panel| {
        let width = panel[1] - panel[0];
        let deviations = marginal.normal_shape().map_or(0.0, |(_, std)| width / std);
        let count = if deviations < 6.5 { (0.5 * deviations).ceil().max(1.0) } else { 1.0 };
        let end = move |piece: f64| if piece == count { panel[1] } else { panel[0] + width * piece / count };
        (0..count as u32).map(move |piece| [end(f64::from(piece)), end(f64::from(piece) + 1.0)])
    })
}

impl Cell {
    /// Its halves by alpha (0) or gamma (1).
    fn halves(self, which: usize) -> [Self; 2] {
        let cut = |[low, high]: [f64; 2]| [[low, 0.5 * (low + high)], [0.5 * (low + high), high]];
        match which {
            0 => cut(self.alpha).map(|alpha| Self { alpha, ..self }),
            _ => cut(self.gamma).map(|gamma| Self { gamma, ..self }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preference::{Belief, ChoiceDistribution, Perception, Predictor};

    fn predicted(options: &[Prospect], belief: &Belief, rationality: f64) -> Vec<f64> {
        let mut predictor = Predictor::new(belief.clone(), 10.0).unwrap();
        predictor.set_rationality(Some(rationality)).unwrap();
        let mut choice = ChoiceDistribution::default();
        predictor.predict(options, &mut choice);
        choice.probabilities().to_vec()
    }

    /// Boltzmann's probabilities at one alpha and gamma.
    fn softmax(options: &[Prospect], rationality: f64, perception: Perception) -> Vec<f64> {
        let costs: Vec<f64> = options.iter().map(|o| subjective_cost(*o, 10.0, perception)).collect();
        let least = costs.iter().copied().fold(f64::INFINITY, f64::min);
        let weights: Vec<f64> = costs.iter().map(|cost| math::exp(rationality * (least - cost))).collect();
        let total: f64 = weights.iter().sum();
        weights.iter().map(|weight| weight / total).collect()
    }

    /// The mean over the belief by Simpson's rule.
    fn slowly(options: &[Prospect], belief: &Belief, rationality: f64, panels: usize) -> Vec<f64> {
        let Belief::Independent { alpha, gamma } = belief else { panic!("independent") };
        let nodes = |m: &Marginal| -> Vec<(f64, f64)> {
            let step = (m.upper() - m.lower()) / panels as f64;
            let factor = |k: usize| match k {
                0 => 1.0,
                k if k == panels => 1.0,
                k => [2.0, 4.0][k % 2],
            };
            let at = |k: usize| m.lower() + step * k as f64;
            (0..=panels).map(|k| (at(k), factor(k) * step / 3.0 * m.density(at(k).min(m.upper())))).collect()
        };
        let mut sums = vec![0.0; options.len()];
        for (alpha, weight_alpha) in nodes(alpha) {
            for (gamma, weight_gamma) in nodes(gamma) {
                let here = softmax(options, rationality, Perception { alpha, gamma });
                sums.iter_mut().zip(here).for_each(|(sum, p)| *sum += weight_alpha * weight_gamma * p);
            }
        }
        sums
    }

    fn options_of(pairs: &[(f64, f64)]) -> Vec<Prospect> {
        pairs.iter().map(|(length, risk)| Prospect::new(*length, *risk)).collect()
    }

    const SETS: [&[(f64, f64)]; 5] = [
        &[(41.8638, 0.6598), (17.4006, 0.3626), (14.3308, 0.5474), (21.3552, 0.2474)],
        &[(12.7239, 0.9737), (14.2601, 0.9332), (23.0, 0.9131), (19.3294, 0.7824)],
        &[(0.2, 0.9), (0.9, 0.4), (3.0, 0.2)],
        &[(4.92, 0.29), (5.2, 0.29)],
        &[(0.0, 0.1), (25.0, 0.0), (25.0, 1.0)],
    ];

    #[test]
    fn property_brute_force_of_simpsons_rule() {
        let normal = Belief::Independent {
            alpha: Marginal::truncated_normal(0.7, 0.06, 0.55, 0.95).unwrap(),
            gamma: Marginal::truncated_normal(0.9, 0.1, 0.5, 1.1).unwrap(),
        };
        for options in SETS.map(options_of) {
            for (belief, rationality) in
                [(Belief::default(), 0.3), (Belief::default(), 2.0), (normal.clone(), 5.0)]
            {
                let found = predicted(&options, &belief, rationality);
                for (found, wanted) in found.iter().zip(slowly(&options, &belief, rationality, 400)) {
                    assert!((found - wanted).abs() < 1e-9, "{options:?}, {rationality}: {found} {wanted}");
                }
            }
        }
    }

    #[test]
    fn closed_form_it_is_chance_without_rationality_and_eq_4_with_much_of_it() {
        for options in SETS.map(options_of) {
            let even = 1.0 / options.len() as f64;
            let by_chance = predicted(&options, &Belief::default(), 1e-9);
            assert!(by_chance.iter().all(|p| (p - even).abs() < 1e-6), "{by_chance:?}");
            let (mut exact, mut choice) = (Predictor::default(), ChoiceDistribution::default());
            exact.predict(&options, &mut choice);
            let rational = predicted(&options, &Belief::default(), 1000.0);
            for (found, wanted) in rational.iter().zip(choice.probabilities()) {
                assert!((found - wanted).abs() < 2e-3, "{rational:?} {choice:?}");
            }
        }
    }

    #[test]
    fn closed_form_it_is_continuous_where_two_ways_are_tied() {
        let apart = |difference: f64| {
            predicted(&options_of(&[(4.92, 0.29), (4.92 + difference, 0.29)]), &Belief::default(), 2.0)[1]
        };
        assert_eq!(apart(0.0), 0.5);
        for difference in [1e-9, 1e-6, 1e-4, -1e-4] {
            // the slope is beta / 4 times the mean of alpha D^(alpha - 1), which is below 1
            assert!((apart(difference) - 0.5).abs() < 0.5 * difference.abs(), "{difference}");
        }
        assert!(apart(1.0) < 0.4 && apart(-1.0) > 0.6);
    }

    #[test]
    fn closed_form_samples_and_tied_ways() {
        let perception = Perception { alpha: 0.7, gamma: 0.8 };
        let sample = WeightedSample { perception, weight: 3.0 };
        let belief = Belief::samples(vec![sample]).unwrap();
        let options = options_of(&[(17.4, 0.36), (14.3, 0.55), (17.4, 0.36), (f64::INFINITY, 0.0)]);
        let wanted = softmax(&options, 1.5, perception);
        for (found, wanted) in predicted(&options, &belief, 1.5).iter().zip(wanted) {
            assert!((found - wanted).abs() < 1e-12, "{found} {wanted}");
        }
        let shared = predicted(&options, &Belief::default(), 1.5);
        assert!(shared[0] == shared[2] && shared[3] == 0.0, "{shared:?}");
        assert!((shared.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let endless = options_of(&[(f64::INFINITY, 0.2), (f64::INFINITY, 0.1)]);
        for belief in [&belief, &Belief::default()] {
            assert_eq!(predicted(&endless, belief, 1.5).iter().sum::<f64>(), 1.0);
        }
        for bad in [0.0, -1.0, 1001.0, f64::NAN] {
            assert!(Predictor::default().set_rationality(Some(bad)).is_err(), "{bad}");
        }
    }
}
