//! The belief about one human's perception after observations of the options that the human chose.

mod independent;
mod line;
mod moments;
mod plane;

use super::strips::Extent;
use super::ties::Ties;
use super::{
    Belief, ChoiceDistribution, Perception, Prospect, SampleSet, Ways, check_rate, human_choice,
    subjective_cost,
};
use crate::error::Error;
use independent::Independent;
use line::GammaLine;
pub use moments::Estimate;
use moments::Moments;
use plane::{Plane, SAME, Segment};
use serde::{Deserialize, Serialize};

/// A belief over `(alpha, gamma)` that learns from choices, by Bayes' rule.
///
/// Each observation multiplies the prior density, on the region R_o of every option, by the likelihood of what
/// was seen if the human prefers o. The product is constant between the borders of all regions seen so far.
/// The borders and the steps across them are kept, so probabilities are exact up to about 1e-8, nearly like
/// those of the [`Predictor`](super::Predictor), without a grid or particles. Steps that change no probability
/// by more than 1e-12 are dropped, and beyond 2048 steps the least ones. Once warm, only
/// [`Posterior::estimate`] and errors allocate.
///
/// ```
/// use cocarry::preference::{Belief, ChoiceDistribution, Posterior, Prospect, Ways};
///
/// let options = [Prospect::new(17.4, 0.36), Prospect::new(14.3, 0.55), Prospect::new(21.4, 0.25)];
/// let mut posterior = Posterior::new(Belief::default(), 10.0)?;
/// // the human took option 1: other options are 50 times less likely to look like that
/// posterior.observe(&options, &Ways::default(), &[0.02, 1.0, 0.02])?;
/// let mut choice = ChoiceDistribution::default();
/// posterior.predict_from(&options, &Ways::default(), &mut choice);
/// assert!(choice.probabilities()[1] > 0.9);
/// # Ok::<(), cocarry::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Posterior {
    belief: Belief,
    risk_weight: f64,
    model: PosteriorModel,
    ties: Ties,
    masses: Vec<f64>,
    /// The last observation, as likelihoods of the leaders of ties.
    likelihoods: Vec<f64>,
    moments: Moments,
    /// Whether the moments are up to date.
    is_filled: bool,
}

#[derive(Debug, Clone)]
enum PosteriorModel {
    Independent(Box<Independent>),
    Samples { set: SampleSet, weights: Vec<f64> },
}

/// The state of a posterior, to be restored.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Learned(Contents);

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
enum Contents {
    Plane { lines: Vec<GammaLine>, segments: Vec<Segment> },
    Samples { weights: Vec<f64> },
}

impl Posterior {
    /// The prior `belief`, with the weight `c_r` of risk in eq. 2.
    ///
    /// # Errors
    /// The weight is negative or not finite.
    pub fn new(belief: Belief, risk_weight: f64) -> Result<Self, Error> {
        super::predictor::check(risk_weight)?;
        let model = match &belief {
            Belief::Independent { alpha, gamma } => {
                PosteriorModel::Independent(Box::new(Independent::new(*alpha, *gamma)))
            }
            Belief::Samples(set) => {
                let weights = set.samples().iter().map(|sample| sample.weight).collect();
                PosteriorModel::Samples { set: set.clone(), weights }
            }
        };
        let (ties, moments) = (Ties::default(), Moments::default());
        let (masses, likelihoods) = (Vec::new(), Vec::new());
        Ok(Self { belief, risk_weight, model, ties, masses, likelihoods, moments, is_filled: false })
    }

    /// The prior.
    pub fn prior(&self) -> &Belief {
        &self.belief
    }

    /// Learns from one observation: `likelihoods` is the probability of what was seen if the human prefers
    /// each option. A human to whom several ways are tied prefers each of them equally often, and options
    /// that have become one of the `ways` are one choice. Returns the probability of what was seen under the
    /// belief so far.
    ///
    /// # Errors
    /// The likelihoods are not one finite number of at least 0 for every option, or that probability is 0.
    /// The belief is then as before.
    pub fn observe(
        &mut self,
        prospects: &[Prospect],
        ways: &Ways,
        likelihoods: &[f64],
    ) -> Result<f64, Error> {
        let bad = likelihoods.iter().copied().find(|l| !(l.is_finite() && *l >= 0.0));
        if likelihoods.len() != prospects.len() || bad.is_some() || prospects.is_empty() {
            let (options, given, bad) = (prospects.len(), likelihoods.len(), bad.unwrap_or(f64::NAN));
            return Err(Error::new(format!(
                "an observation of {options} options has {given} likelihoods, the first bad one {bad}: every option needs a finite one of at least 0"
            )));
        }
        let risk_weight = self.risk_weight;
        self.ties.find(prospects, ways, risk_weight > 0.0);
        self.ties.means(likelihoods, &mut self.likelihoods);
        let (ties, likelihoods) = (&self.ties, self.likelihoods.as_slice());
        let evidence = match &mut self.model {
            PosteriorModel::Samples { set, weights } => {
                let likelihood =
                    |perception| likelihoods[human_choice(prospects, risk_weight, perception, None)];
                let pairs = || set.samples().iter().zip(weights.iter());
                let total: f64 = pairs().map(|(s, weight)| weight * likelihood(s.perception)).sum();
                if total > 1e-250 {
                    for (sample, weight) in set.samples().iter().zip(weights.iter_mut()) {
                        *weight *= likelihood(sample.perception) / total;
                    }
                }
                (total > 1e-250).then_some(total)
            }
            PosteriorModel::Independent(model) => {
                if model.outline(prospects, ties, risk_weight) {
                    let Independent { domain, rule, plane, strips, .. } = model.as_mut();
                    let outline = strips.outline.get_or_insert_default();
                    plane.multiply(outline, likelihoods, rule, domain)
                } else {
                    let only = model.front.first().map_or(0.0, |curve| likelihoods[curve.option]);
                    (only > 0.0).then_some(only)
                }
            }
        };
        self.is_filled = false;
        evidence.ok_or_else(|| {
            Error::new(
                "the observation is impossible under the belief: set a lapse rate above 0, or check the participant's name",
            )
        })
    }

    /// Allows for a change of the human: with probability `rate`, alpha and gamma are drawn from the prior
    /// anew. A rate of at least 1e-4 before every observation also keeps the belief exact however often what
    /// is seen contradicts it.
    ///
    /// # Errors
    /// The rate is not from 0 to 1.
    pub fn mix_with_prior(&mut self, rate: f64) -> Result<(), Error> {
        check_rate("change rate", rate, 1.0)?;
        match &mut self.model {
            PosteriorModel::Independent(model) => model.plane.mix(rate),
            PosteriorModel::Samples { set, weights } => {
                for (sample, weight) in set.samples().iter().zip(weights) {
                    *weight = (1.0 - rate) * *weight + rate * sample.weight;
                }
            }
        }
        self.is_filled = false;
        Ok(())
    }

    /// Probability `P_o` that each option has the lowest subjective cost (eq. 4 over what was learned), as
    /// [`Predictor::predict_from`](super::Predictor::predict_from).
    pub fn predict_from(&mut self, prospects: &[Prospect], ways: &Ways, choice: &mut ChoiceDistribution) {
        self.masses.clear();
        self.masses.resize(prospects.len(), 0.0);
        self.ties.find(prospects, ways, self.risk_weight > 0.0);
        let (masses, ties) = (&mut self.masses, &self.ties);
        match &mut self.model {
            PosteriorModel::Samples { set, weights } => {
                for (sample, weight) in set.samples().iter().zip(weights).filter(|_| !prospects.is_empty()) {
                    let chosen = human_choice(prospects, self.risk_weight, sample.perception, None);
                    masses[ties.leader(chosen)] += *weight;
                }
            }
            PosteriorModel::Independent(model) => {
                if model.outline(prospects, ties, self.risk_weight) {
                    let Independent { domain, rule, plane, strips, .. } = model.as_ref();
                    let outline = strips.outline.as_ref();
                    for border in outline.iter().flat_map(|outline| &outline.borders) {
                        let line = GammaLine::of(border, rule);
                        let mass = plane.mass_below(&line, |gamma| line.mass_to(gamma), border.gamma);
                        masses[border.options[0]] += mass;
                        masses[border.options[1]] -= mass;
                    }
                    let last = |extent: &&Extent| outline.is_some_and(|o| extent.range + 1 == o.ranges);
                    for extent in outline.iter().flat_map(|outline| &outline.extents).filter(last) {
                        let [from, to] = extent.gamma;
                        masses[extent.options[1]] += plane.mass_between(from, to, domain);
                    }
                } else if let Some(only) = model.front.first() {
                    masses[only.option] = 1.0;
                }
            }
        }
        ties.share(masses);
        if !choice.set_masses(masses) && !prospects.is_empty() {
            // only for lengths whose powers overflow
            let [alpha, gamma] = self.belief.ranges().map(|[low, high]| 0.5 * (low + high));
            let chosen = human_choice(prospects, self.risk_weight, Perception { alpha, gamma }, None);
            choice.set_certain(prospects.len(), ways.representative(chosen));
        }
    }

    /// Expected subjective cost of each option (eq. 6 over what was learned), as
    /// [`Predictor::expected_costs`](super::Predictor::expected_costs).
    pub fn expected_costs(&mut self, prospects: &[Prospect], costs: &mut Vec<f64>) {
        costs.clear();
        let risk_weight = self.risk_weight;
        if let PosteriorModel::Samples { set, weights } = &self.model {
            costs.extend(prospects.iter().map(|prospect| -> f64 {
                let cost = |perception| subjective_cost(*prospect, risk_weight, perception);
                set.samples().iter().zip(weights).map(|(s, weight)| weight * cost(s.perception)).sum()
            }));
            return;
        }
        let Some(moments) = self.moments() else { return };
        costs.extend(prospects.iter().map(|prospect| moments.expected_cost(*prospect, risk_weight)));
    }

    fn moments(&mut self) -> Option<&Moments> {
        let PosteriorModel::Independent(model) = &self.model else { return None };
        if !std::mem::replace(&mut self.is_filled, true) {
            self.moments.fill(&model.plane, &model.domain, &model.rule);
        }
        Some(&self.moments)
    }

    /// The density at a perception relative to the prior's: 1 where nothing was learned, 0 outside the prior.
    /// For samples, the factor of the nearest one.
    pub fn density(&self, Perception { alpha, gamma }: Perception) -> f64 {
        match &self.model {
            PosteriorModel::Independent(model) => {
                let in_range = |range: [f64; 2], value: f64| (range[0]..=range[1]).contains(&value);
                let [alphas, gammas] = self.belief.ranges();
                let is_inside = in_range(alphas, alpha) && in_range(gammas, gamma);
                if is_inside { model.plane.density(alpha, gamma) } else { 0.0 }
            }
            PosteriorModel::Samples { set, weights } => {
                let distance = |p: Perception| (p.alpha - alpha).abs() + (p.gamma - gamma).abs();
                let pairs = set.samples().iter().zip(weights);
                let nearest =
                    pairs.min_by(|(a, _), (b, _)| distance(a.perception).total_cmp(&distance(b.perception)));
                nearest.map_or(0.0, |(sample, weight)| weight / sample.weight)
            }
        }
    }

    /// The density at one gamma relative to the prior's, as a step function of alpha: every alpha at which it
    /// steps, ascending, and the step. The first alpha is the least of the prior. Empty for samples.
    pub fn steps_at(&self, gamma: f64) -> Vec<(f64, f64)> {
        match &self.model {
            PosteriorModel::Independent(model) => model.plane.steps_at(gamma),
            PosteriorModel::Samples { .. } => Vec::new(),
        }
    }

    /// The probability of an alpha up to `alpha`, and of a gamma up to `gamma`.
    pub fn marginals(&self, Perception { alpha, gamma }: Perception) -> [f64; 2] {
        match &self.model {
            PosteriorModel::Independent(model) => [model.marginal(0, alpha), model.marginal(1, gamma)],
            PosteriorModel::Samples { set, weights } => {
                let up_to = |is_low: &dyn Fn(&Perception) -> bool| -> f64 {
                    let pairs = set.samples().iter().zip(weights);
                    pairs.filter(|(s, _)| is_low(&s.perception)).map(|(_, weight)| weight).sum()
                };
                [up_to(&|p| p.alpha <= alpha), up_to(&|p| p.gamma <= gamma)]
            }
        }
    }

    /// The alpha (0) or gamma (1) up to which there is this probability.
    pub fn quantile(&self, which: usize, probability: f64) -> f64 {
        match &self.model {
            PosteriorModel::Independent(model) => model.quantile(which, probability),
            PosteriorModel::Samples { set, weights } => {
                moments::sample_quantile(set, weights, which, probability)
            }
        }
    }

    /// The probability of all perceptions with a density above `density`, and with at least it.
    pub fn credibility(&self, density: f64) -> [f64; 2] {
        let near = SAME * density;
        match &self.model {
            PosteriorModel::Independent(model) => [density + near, density - near]
                .map(|least| model.plane.integral_of(|w| if w >= least { w } else { 0.0 })),
            PosteriorModel::Samples { set, weights } => [density + near, density - near].map(|least| {
                let pairs = set.samples().iter().zip(weights);
                pairs.filter(|(s, weight)| *weight / s.weight >= least).map(|(_, weight)| weight).sum()
            }),
        }
    }

    /// Number of steps of the density that are kept; the number of samples for an empirical prior.
    pub fn size(&self) -> usize {
        match &self.model {
            PosteriorModel::Independent(model) => model.plane.segments.len(),
            PosteriorModel::Samples { weights, .. } => weights.len(),
        }
    }

    /// Mean, covariance, 95 % intervals and region, and information.
    pub fn estimate(&mut self) -> Estimate {
        self.moments();
        match &self.model {
            PosteriorModel::Independent(model) => model.estimate(&self.moments),
            PosteriorModel::Samples { set, weights } => moments::of_samples(set, weights),
        }
    }

    /// Mean of alpha and gamma.
    pub fn mean(&mut self) -> [f64; 2] {
        if let PosteriorModel::Samples { set, weights } = &self.model {
            return moments::of_samples(set, weights).mean;
        }
        self.moments().map_or([0.0; 2], Moments::mean)
    }

    /// The state, for [`Posterior::restore`].
    pub fn learned(&self) -> Learned {
        Learned(match &self.model {
            PosteriorModel::Independent(model) => {
                let Plane { lines, segments, .. } = &model.plane;
                Contents::Plane { lines: lines.clone(), segments: segments.clone() }
            }
            PosteriorModel::Samples { weights, .. } => Contents::Samples { weights: weights.clone() },
        })
    }

    /// Takes over what a posterior with the same prior has learned. False, and no change, if it does not
    /// belong to this prior.
    pub fn restore(&mut self, learned: &Learned) -> bool {
        let is_restored = match (&mut self.model, &learned.0) {
            (PosteriorModel::Independent(model), Contents::Plane { lines, segments }) => {
                let is_known = |segment: &Segment| {
                    (segment.line as usize) < lines.len()
                        && [segment.from, segment.to, segment.below, segment.step]
                            .iter()
                            .all(|x| x.is_finite())
                };
                let in_order = segments.is_sorted_by(|a, b| (a.line, a.from) < (b.line, b.from));
                let fits = lines.first() == model.plane.lines.first()
                    && segments.iter().all(is_known)
                    && in_order
                    && segments.first().is_some_and(|first| first.line == 0);
                if fits {
                    let Independent { plane, domain, .. } = model.as_mut();
                    plane.lines.clone_from(lines);
                    plane.segments.clear();
                    let line = |segment: &Segment| &lines[segment.line as usize];
                    plane.segments.extend(segments.iter().map(|s| s.weighed(line(s), domain)));
                }
                fits
            }
            (PosteriorModel::Samples { weights, .. }, Contents::Samples { weights: saved }) => {
                let fits = saved.len() == weights.len() && saved.iter().all(|w| w.is_finite() && *w >= 0.0);
                if fits {
                    weights.clone_from(saved);
                }
                fits
            }
            _ => false,
        };
        self.is_filled = false;
        is_restored
    }
}

#[cfg(test)]
mod tests;
