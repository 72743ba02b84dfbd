//! A probability for every option: non-negative, summing to one.

use serde::{Deserialize, Serialize};

/// The probabilities `P_o` (eq. 4) that each option is the one the human prefers.
///
/// Invariant: every entry is non-negative and they sum to 1 up to rounding; without options there are no
/// entries. It is also a buffer: [`Predictor::predict`](super::Predictor::predict) refills it without
/// allocation.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ChoiceDistribution {
    probabilities: Vec<f64>,
}

/// P'_o = (1 - l) P_o + l / n: the probability that an option is taken, from the probability that it is
/// preferred. In a lapse, with probability l, any of the n options is taken.
///
/// ```
/// assert_eq!(cocarry::preference::with_lapses(0.75, 0.5, 4), 0.5);
/// ```
pub fn with_lapses(probability: f64, lapse_rate: f64, options: usize) -> f64 {
    (1.0 - lapse_rate) * probability + lapse_rate / options as f64
}

impl ChoiceDistribution {
    /// Normalises non-negative finite `weights`; `None` if one is negative or not finite, or if none is
    /// positive.
    pub fn from_weights(weights: &[f64]) -> Option<Self> {
        let mut distribution = Self { probabilities: weights.to_vec() };
        distribution.normalise().then_some(distribution)
    }

    /// All probabilities, in the order of the options.
    pub fn probabilities(&self) -> &[f64] {
        &self.probabilities
    }

    /// The most probable option; ties go to the lower index. 0 without options.
    pub fn most_likely(&self) -> usize {
        let mut best = 0;
        for (option, &probability) in self.probabilities.iter().enumerate() {
            if probability > self.probabilities[best] {
                best = option;
            }
        }
        best
    }

    /// Number of options.
    pub fn len(&self) -> usize {
        self.probabilities.len()
    }

    /// Whether there are no options.
    pub fn is_empty(&self) -> bool {
        self.probabilities.is_empty()
    }

    /// Takes lapses into account: see [`with_lapses`].
    pub(crate) fn add_lapses(&mut self, lapse_rate: f64) {
        let options = self.probabilities.len();
        self.probabilities.iter_mut().for_each(|p| *p = with_lapses(*p, lapse_rate, options));
    }

    /// Takes over the probabilities of another distribution.
    pub(crate) fn take_over(&mut self, probabilities: impl Iterator<Item = f64>) {
        self.probabilities.clear();
        self.probabilities.extend(probabilities);
    }

    /// Removes all entries, and keeps the memory.
    pub fn clear(&mut self) {
        self.probabilities.clear();
    }

    pub(super) fn set_certain(&mut self, options: usize, chosen: usize) {
        self.probabilities.clear();
        self.probabilities.resize(options, 0.0);
        if let Some(probability) = self.probabilities.get_mut(chosen) {
            *probability = 1.0;
        }
    }

    /// Takes over raw masses and normalises them. Returns false, with unspecified contents, if they are not a
    /// distribution.
    pub(super) fn set_masses(&mut self, masses: &[f64]) -> bool {
        self.probabilities.clear();
        // Rounding may leave a mass of -1e-17 where an option holds a vanishing interval.
        self.probabilities.extend(masses.iter().map(|mass| if *mass < 0.0 { 0.0 } else { *mass }));
        self.normalise()
    }

    fn normalise(&mut self) -> bool {
        let sum: f64 = self.probabilities.iter().sum();
        if !(sum > 0.0 && sum.is_finite() && self.probabilities.iter().all(|&p| p >= 0.0)) {
            return false;
        }
        for probability in &mut self.probabilities {
            *probability /= sum;
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_weights_are_normalised_or_refused() {
        let distribution = ChoiceDistribution::from_weights(&[1.0, 3.0, 3.0]).unwrap();
        assert!((distribution.probabilities().iter().sum::<f64>() - 1.0).abs() < 1e-15);
        assert_eq!(distribution.most_likely(), 1);
        assert_eq!(ChoiceDistribution::from_weights(&[0.0, 0.0]), None);
        assert_eq!(ChoiceDistribution::from_weights(&[]), None);
        assert_eq!(ChoiceDistribution::from_weights(&[1.0, -0.1]), None);
        assert_eq!(ChoiceDistribution::from_weights(&[1.0, f64::NAN]), None);
    }
}
