//! The belief about one human's tolerance eta, from when the human took over and when not.

use super::LearningError;
use crate::math;
use gauss_quad::GaussLegendre;
use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};
use std::num::NonZeroUsize;

/// ln(1 / phi(0)): the human takes over when g(k) exceeds eta times this (eq. 5).
pub fn discomfort_limit(initial_stubbornness: f64) -> f64 {
    -math::ln(initial_stubbornness)
}

/// The eta of humans who do not take over at discomfort `kept`, and do at discomfort `reached`, if there is one
/// (eq. 5). `limit` is the [`discomfort_limit`].
pub fn eta_interval(kept: f64, reached: Option<f64>, limit: f64) -> [f64; 2] {
    [kept / limit, reached.map_or(f64::INFINITY, |reached| reached / limit)]
}

/// A log-normal distribution of eta.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TolerancePrior {
    /// Its median.
    pub median: f64,
    /// Standard deviation of its logarithm.
    pub log_std: f64,
}

impl Default for TolerancePrior {
    /// The paper's medium participant, and a spread that has its sensitive (5) and its patient one (15) within
    /// one and a half standard deviations.
    fn default() -> Self {
        Self { median: 10.5, log_std: 0.5 }
    }
}

impl TolerancePrior {
    fn z(&self, eta: f64) -> f64 {
        math::ln(eta / self.median) / self.log_std
    }

    /// The integral of eta^power over an interval.
    fn partial(&self, [low, high]: [f64; 2], power: f64) -> f64 {
        let shift = power * self.log_std;
        let scale = math::pow(self.median, power) * math::exp(0.5 * shift * shift);
        scale * normal_between(self.z(low) - shift, self.z(high) - shift)
    }

    /// An eta drawn from it.
    pub fn sample<R: Rng + ?Sized>(&self, rng: &mut R) -> f64 {
        self.median * math::exp(self.log_std * standard_normal(rng))
    }

    /// The probability of an interval.
    pub fn probability(&self, interval: [f64; 2]) -> f64 {
        self.partial(interval, 0.0)
    }
}

/// A draw from the standard normal distribution (Box and Muller 1958).
pub fn standard_normal<R: Rng + ?Sized>(rng: &mut R) -> f64 {
    let radius = (-2.0 * math::ln(rng.random_range(f64::MIN_POSITIVE..1.0))).sqrt();
    let angle = 2.0 * std::f64::consts::PI * rng.random::<f64>();
    radius * math::cos(angle)
}

/// The probability of a standard normal between two values, accurate in both tails.
fn normal_between(from: f64, to: f64) -> f64 {
    let half_erfc = |z: f64| 0.5 * math::erfc(z * std::f64::consts::FRAC_1_SQRT_2);
    if from > 0.0 { half_erfc(from) - half_erfc(to) } else { half_erfc(-to) - half_erfc(-from) }
}

/// The most tasks that are remembered; beyond them the first are forgotten.
pub const MAX_TASKS: usize = 256;

/// Deviations beyond which the prior is not integrated.
const MAX_DEVIATIONS: f64 = 9.0;

/// Nodes of the rule for a step.
const POINTS: usize = 24;

/// The belief over eta.
///
/// A task shows that eta lies in an interval. With the lapse rate as probability it is uninformative: the
/// human then acts in this task like another human, drawn from the prior. The density relative to the prior
/// is a step function, so all figures are sums of closed forms, but for the expected stubbornness, which is
/// integrated by a Gauss rule on each step.
#[derive(Clone, Debug)]
pub struct Tolerance {
    prior: TolerancePrior,
    lapse_rate: f64,
    tasks: Vec<[f64; 2]>,
    /// Ends of steps, ascending.
    ends: Vec<f64>,
    /// The probability of each step.
    weights: Vec<f64>,
    /// Nodes and weights of the rule of Gauss on [-1, 1].
    rule: Vec<(f64, f64)>,
}

impl Tolerance {
    /// The prior.
    ///
    /// # Errors
    /// A number is out of its range.
    pub fn new(prior: TolerancePrior, lapse_rate: f64) -> Result<Self, LearningError> {
        let positive = |name, value: f64| match value > 0.0 && value <= 1e6 {
            true => Ok(()),
            false => Err(LearningError { name, value, expected: "greater than 0 and at most 1000000" }),
        };
        positive("tolerance.median", prior.median)?;
        positive("tolerance.log_std", prior.log_std)?;
        super::check_rate("lapse_rate", lapse_rate)?;
        let (tasks, ends, weights) = (Vec::with_capacity(MAX_TASKS), Vec::new(), Vec::new());
        let points = NonZeroUsize::new(POINTS).unwrap_or(NonZeroUsize::MIN);
        let rule = GaussLegendre::new(points).as_node_weight_pairs().to_vec();
        let mut tolerance = Self { prior, lapse_rate, tasks, ends, weights, rule };
        tolerance.refresh();
        Ok(tolerance)
    }

    /// Begins a task, about which nothing is known yet.
    pub fn begin_task(&mut self) {
        if self.tasks.len() == MAX_TASKS {
            self.tasks.remove(0);
        }
        self.tasks.push([0.0, f64::INFINITY]);
    }

    /// Sets what the present task says, in place of what it said before.
    pub fn set_task(&mut self, interval: [f64; 2]) {
        if let Some(last) = self.tasks.last_mut() {
            *last = interval;
        }
        self.refresh();
    }

    /// The interval of eta that every task shows, the present task last.
    pub fn tasks(&self) -> &[[f64; 2]] {
        &self.tasks
    }

    /// Takes over what the tasks of another belief with the same prior say. False, and no change, if they are
    /// not intervals.
    pub fn restore(&mut self, tasks: &[[f64; 2]]) -> bool {
        let fits = tasks.len() <= MAX_TASKS && tasks.iter().all(|task| task[0] >= 0.0 && task[0] < task[1]);
        if fits {
            self.tasks.clear();
            self.tasks.extend_from_slice(tasks);
            self.refresh();
        }
        fits
    }

    /// Computes the steps anew.
    fn refresh(&mut self) {
        self.ends.clear();
        self.ends.extend([0.0, f64::INFINITY]);
        self.ends.extend(self.tasks.iter().flatten().filter(|end| **end > 0.0 && end.is_finite()));
        self.ends.sort_unstable_by(f64::total_cmp);
        self.ends.dedup();
        self.weights.clear();
        let mut total = 0.0;
        for step in self.ends.windows(2) {
            let mut weight = self.prior.probability([step[0], step[1]]);
            for task in &self.tasks {
                let is_within = task[0] <= step[0] && step[1] <= task[1];
                let lapsed = self.lapse_rate * self.prior.probability(*task);
                weight *= lapsed + if is_within { 1.0 - self.lapse_rate } else { 0.0 };
            }
            total += weight;
            self.weights.push(weight);
        }
        // intervals far out in the tails of the prior, or contradictions without lapses: back to the prior
        if total.is_nan() || total < 1e-290 {
            self.weights.clear();
            self.weights.extend(self.ends.windows(2).map(|step| self.prior.probability([step[0], step[1]])));
            total = 1.0;
        }
        self.weights.iter_mut().for_each(|weight| *weight /= total);
    }

    /// Steps with a probability, and this probability over the prior's.
    fn steps(&self) -> impl Iterator<Item = ([f64; 2], f64)> {
        let steps = self.ends.windows(2).zip(&self.weights).filter(|(_, weight)| **weight > 0.0);
        steps.map(|(step, weight)| ([step[0], step[1]], weight / self.prior.probability([step[0], step[1]])))
    }

    /// Mean and variance.
    pub fn moments(&self) -> [f64; 2] {
        let moment = |power| self.steps().map(|(step, ratio)| ratio * self.prior.partial(step, power)).sum();
        let (first, second): (f64, f64) = (moment(1.0), moment(2.0));
        [first, (second - first * first).max(0.0)]
    }

    /// The probability of an eta up to `eta`.
    pub fn probability_up_to(&self, eta: f64) -> f64 {
        let part = |([low, high], ratio): ([f64; 2], f64)| {
            if eta > low { ratio * self.prior.probability([low, eta.min(high)]) } else { 0.0 }
        };
        self.steps().map(part).sum()
    }

    /// The central interval with this probability.
    pub fn interval(&self, probability: f64) -> [f64; 2] {
        let tail = 0.5 * (1.0 - probability);
        [tail, 1.0 - tail].map(|share| self.quantile(share))
    }

    /// The eta up to which there is this probability.
    pub fn quantile(&self, probability: f64) -> f64 {
        let (mut below, mut above) = (-MAX_DEVIATIONS, MAX_DEVIATIONS);
        for _ in 0..60 {
            let middle = 0.5 * (below + above);
            let eta = self.prior.median * math::exp(self.prior.log_std * middle);
            if self.probability_up_to(eta) < probability { below = middle } else { above = middle }
        }
        self.prior.median * math::exp(self.prior.log_std * 0.5 * (below + above))
    }

    /// The mean of min(phi, 1) = min(phi(0) exp(g / eta), 1) at discomfort g.
    pub fn expected_stubbornness(&self, initial_stubbornness: f64, discomfort: f64) -> f64 {
        if discomfort == 0.0 {
            return initial_stubbornness;
        }
        // below this eta, phi is more than 1
        let exhausted = discomfort / discomfort_limit(initial_stubbornness).max(f64::MIN_POSITIVE);
        let part = |([low, high], ratio): ([f64; 2], f64)| {
            let split = exhausted.clamp(low, high);
            let certain = if split > low { self.prior.probability([low, split]) } else { 0.0 };
            let [from, to] =
                [self.prior.z(split), self.prior.z(high)].map(|z| z.clamp(-MAX_DEVIATIONS, MAX_DEVIATIONS));
            let half = 0.5 * (to - from);
            let mut sum = 0.0;
            for (node, weight) in &self.rule {
                let z = from + half * (1.0 + node);
                let eta = self.prior.median * math::exp(self.prior.log_std * z);
                let phi = (initial_stubbornness * math::exp(discomfort / eta)).min(1.0);
                sum += weight * math::exp(-0.5 * z * z) * phi;
            }
            ratio * (certain + half * sum / (2.0 * std::f64::consts::PI).sqrt())
        };
        self.steps().map(part).sum::<f64>().clamp(initial_stubbornness, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tolerance(lapse_rate: f64) -> Tolerance {
        Tolerance::new(TolerancePrior::default(), lapse_rate).unwrap()
    }

    /// Means over the belief by a fine rule in ln(eta), with the likelihood written out.
    fn brute_force(tasks: &[[f64; 2]], lapse_rate: f64, value: impl Fn(f64) -> f64) -> f64 {
        let prior = TolerancePrior::default();
        let (mut sum, mut total) = (0.0, 0.0);
        let points = 400_000;
        for i in 0..points {
            let z = -8.0 + 16.0 * (f64::from(i) + 0.5) / f64::from(points);
            let eta = prior.median * math::exp(prior.log_std * z);
            let mut weight = math::exp(-0.5 * z * z);
            for task in tasks {
                let inside = f64::from(u8::from(task[0] <= eta && eta < task[1]));
                weight *= (1.0 - lapse_rate) * inside + lapse_rate * prior.probability(*task);
            }
            total += weight;
            sum += weight * value(eta);
        }
        sum / total
    }

    #[test]
    fn property_brute_force_of_every_figure() {
        let cases: [(&[[f64; 2]], f64); 5] = [
            (&[], 0.0),
            (&[[4.0, f64::INFINITY]], 0.0),
            (&[[4.0, f64::INFINITY], [9.0, 9.5]], 0.02),
            (&[[4.0, 4.4], [9.0, 9.5], [9.2, 12.0]], 0.1),
            (&[[30.0, f64::INFINITY], [2.0, 3.0]], 0.3),
        ];
        for (tasks, lapse_rate) in cases {
            let mut belief = tolerance(lapse_rate);
            for task in tasks {
                belief.begin_task();
                belief.set_task(*task);
            }
            let [mean, variance] = belief.moments();
            let wanted = brute_force(tasks, lapse_rate, |eta| eta);
            assert!((mean - wanted).abs() < 1e-4 * wanted, "mean {mean} {wanted}, {tasks:?}");
            let wanted = brute_force(tasks, lapse_rate, |eta| math::squared(eta - mean));
            assert!((variance - wanted).abs() < 1e-3 * wanted, "variance {variance} {wanted}, {tasks:?}");
            for g in [0.0, 3.0, 20.0, 60.0] {
                let found = belief.expected_stubbornness(0.1, g);
                let wanted = brute_force(tasks, lapse_rate, |eta| (0.1 * math::exp(g / eta)).min(1.0));
                assert!((found - wanted).abs() < 1e-4, "phi {found} {wanted}, {tasks:?}, g {g}");
            }
            let interval = belief.interval(0.9).map(|eta| belief.probability_up_to(eta));
            assert!((interval[0] - 0.05).abs() < 1e-9 && (interval[1] - 0.95).abs() < 1e-9, "{interval:?}");
        }
    }

    #[test]
    fn closed_form_contradictions_without_lapses_give_the_prior() {
        let mut belief = tolerance(0.0);
        for task in [[2.0, 3.0], [20.0, 21.0]] {
            belief.begin_task();
            belief.set_task(task);
        }
        assert!((belief.probability_up_to(10.5) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn closed_form_bad_numbers_are_refused() {
        let of = |median, log_std, lapse_rate| {
            Tolerance::new(TolerancePrior { median, log_std }, lapse_rate).unwrap_err().to_string()
        };
        assert!(of(0.0, 0.5, 0.0).contains("tolerance.median = 0"));
        assert!(of(1.0, f64::NAN, 0.0).contains("tolerance.log_std = NaN"));
        assert!(of(1.0, 0.5, 1.0).contains("lapse_rate = 1"));
    }
}
