//! The robot's belief about a human's perception: independent marginals (the paper) or weighted samples.

use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

use super::perception::MAX_PERCEPTION;
use super::{Marginal, Perception};
use crate::error::Error;

/// A distribution over `(alpha, gamma)`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Belief {
    /// `alpha` and `gamma` independent, as in Sec. IV-A.
    Independent {
        /// Distance perception.
        alpha: Marginal,
        /// Risk perception.
        gamma: Marginal,
    },
    /// An empirical distribution: parameters fitted to people, or draws from any joint distribution.
    Samples(SampleSet),
}

/// One perception with its weight.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WeightedSample {
    /// The parameters.
    pub perception: Perception,
    /// Weight relative to the other samples, positive.
    pub weight: f64,
}

/// Weighted samples. Invariant: at least one, all parameters and weights positive and finite, weights summing
/// to 1.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<SampleFields>", into = "Vec<SampleFields>")]
pub struct SampleSet {
    samples: Vec<WeightedSample>,
}

/// A sample as it is serialised.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SampleFields {
    alpha: f64,
    gamma: f64,
    weight: f64,
}

impl From<SampleSet> for Vec<SampleFields> {
    fn from(set: SampleSet) -> Self {
        let row = |WeightedSample { perception: Perception { alpha, gamma }, weight }| SampleFields {
            alpha,
            gamma,
            weight,
        };
        set.samples.into_iter().map(row).collect()
    }
}

impl TryFrom<Vec<SampleFields>> for SampleSet {
    type Error = Error;

    /// Weights that already sum to 1 are kept to the last bit.
    fn try_from(rows: Vec<SampleFields>) -> Result<Self, Error> {
        let sample = |SampleFields { alpha, gamma, weight }| WeightedSample {
            perception: Perception { alpha, gamma },
            weight,
        };
        let samples: Vec<WeightedSample> = rows.into_iter().map(sample).collect();
        let scaled = Self::new(samples.clone())?;
        let sum: f64 = samples.iter().map(|sample| sample.weight).sum();
        let rounding = 2.0 * f64::EPSILON * (samples.len() + 1) as f64;
        Ok(if (sum - 1.0).abs() <= rounding { Self { samples } } else { scaled })
    }
}

impl SampleSet {
    /// Checks the samples and scales their weights to sum to 1.
    pub fn new(mut samples: Vec<WeightedSample>) -> Result<Self, Error> {
        let positive = |value: f64| value > 0.0 && value.is_finite();
        for (index, sample) in samples.iter().enumerate() {
            let WeightedSample { perception: Perception { alpha, gamma }, weight } = *sample;
            let is_good = |parameter: f64| positive(parameter) && parameter <= MAX_PERCEPTION;
            if !(is_good(alpha) && is_good(gamma) && positive(weight)) {
                return Err(Error::new(format!(
                    "sample {index} (alpha {alpha}, gamma {gamma}, weight {weight}): all three must be positive and finite, alpha and gamma at most {MAX_PERCEPTION}"
                )));
            }
        }
        // Dividing by the largest first keeps the sum finite whatever the scale of the weights.
        let largest = samples.iter().fold(0.0, |largest: f64, sample| largest.max(sample.weight));
        let sum: f64 = samples.iter().map(|sample| sample.weight / largest).sum();
        for sample in &mut samples {
            sample.weight = sample.weight / largest / sum;
        }
        match samples.is_empty() {
            true => Err(Error::new("a belief needs at least one sample")),
            false => Ok(Self { samples }),
        }
    }

    /// The sample at a share, from 0 to 1, of all weights in their order.
    pub(super) fn at(&self, share: f64) -> Perception {
        let mut left = share;
        let is_there = |sample: &&WeightedSample| {
            left -= sample.weight;
            left < 0.0
        };
        // the weights sum to 1 up to rounding: what is beyond them belongs to the last sample
        let found = self.samples.iter().find(is_there).unwrap_or(&self.samples[self.samples.len() - 1]);
        found.perception
    }

    /// The samples, with weights that sum to 1.
    pub fn samples(&self) -> &[WeightedSample] {
        &self.samples
    }
}

impl Default for Belief {
    /// The paper's ranges: `alpha ~ U(0.55, 0.95)`, `gamma ~ U(0.5, 1.1)` (Sec. IV-A).
    fn default() -> Self {
        Self::uniform((0.55, 0.95), (0.5, 1.1)).expect("the paper's ranges are valid")
    }
}

impl Belief {
    /// Independent uniforms on `(lower, upper)` ranges of `alpha` and `gamma`.
    pub fn uniform(alpha: (f64, f64), gamma: (f64, f64)) -> Result<Self, Error> {
        Ok(Self::Independent {
            alpha: Marginal::uniform(alpha.0, alpha.1)?,
            gamma: Marginal::uniform(gamma.0, gamma.1)?,
        })
    }

    /// An empirical belief; the weights need not sum to 1.
    pub fn samples(samples: Vec<WeightedSample>) -> Result<Self, Error> {
        SampleSet::new(samples).map(Self::Samples)
    }

    /// The ends of the ranges of `alpha` and `gamma`.
    pub fn ranges(&self) -> [[f64; 2]; 2] {
        match self {
            Self::Independent { alpha, gamma } => [alpha, gamma].map(|m| [m.lower(), m.upper()]),
            Self::Samples(set) => [|p: &Perception| p.alpha, |p: &Perception| p.gamma].map(|parameter| {
                let values = || set.samples.iter().map(|sample| parameter(&sample.perception));
                [values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max)]
            }),
        }
    }

    /// A random perception.
    pub fn sample<R: Rng + ?Sized>(&self, rng: &mut R) -> Perception {
        match self {
            Self::Independent { alpha, gamma } => {
                Perception { alpha: alpha.sample(rng), gamma: gamma.sample(rng) }
            }
            Self::Samples(set) => set.at(rng.random()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    fn sample(alpha: f64, gamma: f64, weight: f64) -> WeightedSample {
        WeightedSample { perception: Perception { alpha, gamma }, weight }
    }

    #[test]
    fn closed_form_weights_are_normalised_and_drawn_in_proportion() {
        let belief = Belief::samples(vec![sample(0.6, 0.7, 1e308), sample(0.8, 0.9, 1.5e308)]).unwrap();
        let Belief::Samples(set) = &belief else { panic!("an empirical belief was built") };
        assert!((set.samples()[1].weight - 0.6).abs() < 1e-15);
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let second = (0..5000).filter(|_| belief.sample(&mut rng).alpha == 0.8).count();
        assert!((second as f64 / 5000.0 - 0.6).abs() < 0.03);
    }

    #[test]
    fn closed_form_bad_samples_are_refused() {
        let refused = |samples| Belief::samples(samples).unwrap_err().to_string();
        assert_eq!(refused(Vec::new()), "a belief needs at least one sample");
        for bad in [
            sample(0.0, 1.0, 1.0),
            sample(1.0, f64::NAN, 1.0),
            sample(1.0, 1.0, f64::INFINITY),
            sample(1.0, 1.0, -1.0),
        ] {
            let error = refused(vec![sample(0.7, 0.7, 1.0), bad]);
            assert!(error.starts_with("sample 1 (alpha "), "{error}");
        }
    }

    #[test]
    fn paper_default_ranges() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for _ in 0..100 {
            let Perception { alpha, gamma } = Belief::default().sample(&mut rng);
            assert!((0.55..=0.95).contains(&alpha) && (0.5..=1.1).contains(&gamma));
        }
    }
}
