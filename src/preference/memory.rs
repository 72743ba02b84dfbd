//! Predictions of many episodes, kept by what they depend on.
//!
//! P_o and J~_o are of a belief, not of a human. In the episodes of a study that share a world and a belief,
//! they are the same numbers at the same places, however many humans there are.

use super::{ChoiceDistribution, Predictor, Prospect, Ways};
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, DefaultHasher};
use std::sync::{Arc, RwLock};

/// The largest number of predictors whose predictions are kept.
const MAX_PREDICTORS: usize = 8;
/// The largest number of values that are kept of one predictor: 2 MB, and about as much for the search.
const MAX_VALUES: usize = 1 << 18;

/// P_o and J~_o that predictors have given, for episodes on any number of threads. What is found in it has the
/// bits that the predictor would give again, so that results do not depend on what it holds. Its size is
/// limited.
#[derive(Debug, Default)]
pub struct PredictionMemory {
    predictors: RwLock<Vec<(Predictor, Arc<Predictions>)>>,
}

/// The predictions of one predictor.
#[derive(Debug, Default)]
pub(crate) struct Predictions {
    known: RwLock<Known>,
}

#[derive(Debug, Default)]
struct Known {
    /// P_o, then J~_o if it was asked for, by the bits of the options' lengths and risks and by the
    /// representatives of their ways, and by whether J~_o was asked for. The hash is the same in every process.
    by_options: HashMap<Box<[u64]>, Box<[f64]>, BuildHasherDefault<DefaultHasher>>,
    /// The number of values in it.
    values: usize,
}

impl PredictionMemory {
    /// The predictions of a predictor; `None` where there are too many predictors.
    pub(crate) fn of(&self, predictor: &Predictor) -> Option<Arc<Predictions>> {
        let find = |known: &[(Predictor, Arc<Predictions>)]| {
            known.iter().find(|(of, _)| of == predictor).map(|(_, predictions)| Arc::clone(predictions))
        };
        if let Some(found) = find(&self.predictors.read().ok()?) {
            return Some(found);
        }
        let mut known = self.predictors.write().ok()?;
        // another thread may have been here in between
        if let Some(found) = find(&known) {
            return Some(found);
        }
        if known.len() == MAX_PREDICTORS {
            return None;
        }
        let new = Arc::default();
        known.push((predictor.clone(), Arc::clone(&new)));
        Some(new)
    }
}

impl Predictions {
    /// P_o of these options into `choice`, and J~_o into `expected` if there is one: what is known of them, or
    /// else what the predictor gives. `key` is memory for the search.
    pub fn predict(
        &self,
        predictor: &mut Predictor,
        (prospects, ways): (&[Prospect], &Ways),
        key: &mut Vec<u64>,
        choice: &mut ChoiceDistribution,
        mut expected: Option<&mut Vec<f64>>,
    ) {
        key.clear();
        for (option, Prospect { length, risk }) in prospects.iter().enumerate() {
            key.extend([length.to_bits(), risk.to_bits(), ways.representative(option) as u64]);
        }
        key.push(u64::from(expected.is_some()));
        if let Ok(known) = self.known.read()
            && let Some(values) = known.by_options.get(key.as_slice())
        {
            let (probabilities, costs) = values.split_at(prospects.len());
            choice.take_over(probabilities);
            if let Some(expected) = expected {
                expected.clear();
                expected.extend_from_slice(costs);
            }
            return;
        }
        predictor.predict_from(prospects, ways, choice);
        if let Some(expected) = &mut expected {
            predictor.expected_costs(prospects, expected);
        }
        let costs = expected.as_ref().map_or(&[][..], |expected| expected.as_slice());
        if let Ok(mut known) = self.known.write()
            && known.values + key.len() + prospects.len() + costs.len() <= MAX_VALUES
        {
            let values: Box<[f64]> = choice.probabilities().iter().chain(costs).copied().collect();
            known.values += key.len() + values.len();
            known.by_options.insert(key.as_slice().into(), values);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preference::{Belief, Marginal};

    #[test]
    fn property_kept_predictions_are_those_of_the_predictor_to_the_bit() {
        let memory = PredictionMemory::default();
        let alpha = Marginal::truncated_normal(0.7, 0.1, 0.55, 0.95).unwrap();
        let normal = Belief::Independent { alpha, gamma: Marginal::uniform(0.5, 1.1).unwrap() };
        let mut lapsing = Predictor::default();
        lapsing.set_lapse_rate(0.1).unwrap();
        for mut predictor in [Predictor::default(), lapsing, Predictor::new(normal, 10.0).unwrap()] {
            let predictions = memory.of(&predictor).unwrap();
            let (mut choice, mut expected, mut key) = (ChoiceDistribution::default(), Vec::new(), Vec::new());
            // every place twice, and once with two options that have become one way
            for k in 0..120 {
                let near = f64::from(k % 30) / 3.0;
                let lengths = [18.07, 28.54, 18.07, 18.06].map(|length| length - near);
                let risks = [0.456, 0.202, 0.456, if k < 60 { 0.689 } else { 0.5 }];
                let prospects: [Prospect; 4] = std::array::from_fn(|o| Prospect::new(lengths[o], risks[o]));
                let mut ways = Ways::default();
                ways.find(4, Some(2), |a, b| k % 60 >= 30 && (a, b) == (0, 2));
                let asked = (prospects.as_slice(), &ways);
                let (mut own, mut costs) = (ChoiceDistribution::default(), Vec::new());
                predictor.predict_from(&prospects, &ways, &mut own);
                predictor.expected_costs(&prospects, &mut costs);
                // P_o alone, as while the human leads
                predictions.predict(&mut predictor, asked, &mut key, &mut choice, None);
                assert_eq!(choice, own, "{k}");
                predictions.predict(&mut predictor, asked, &mut key, &mut choice, Some(&mut expected));
                assert_eq!((&choice, &expected), (&own, &costs), "{k}");
            }
        }
    }

    #[test]
    fn closed_form_its_size_is_limited() {
        let memory = PredictionMemory::default();
        for k in 0..20 {
            let predictor = Predictor::new(Belief::default(), f64::from(k)).unwrap();
            assert_eq!(memory.of(&predictor).is_some(), k < MAX_PREDICTORS as i32);
            assert!(k > 7 || Arc::ptr_eq(&memory.of(&predictor).unwrap(), &memory.of(&predictor).unwrap()));
        }
        let (mut predictor, predictions) = (Predictor::default(), Predictions::default());
        let (mut choice, mut expected, mut key) = (ChoiceDistribution::default(), Vec::new(), Vec::new());
        for k in 0..=MAX_VALUES / 6 {
            let prospects = [Prospect::new(k as f64, 0.5)];
            let asked = (prospects.as_slice(), &Ways::default());
            predictions.predict(&mut predictor, asked, &mut key, &mut choice, Some(&mut expected));
            assert_eq!((choice.probabilities(), expected.len()), (&[1.0][..], 1));
        }
        let known = predictions.known.read().unwrap();
        assert!(known.values <= MAX_VALUES && known.values + 6 > MAX_VALUES, "{}", known.values);
        assert_eq!(known.by_options.len(), MAX_VALUES / 6);
    }
}
