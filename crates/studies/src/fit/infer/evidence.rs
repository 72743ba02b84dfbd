//! The evidence of a participant's answers and switches: likelihoods, and the exact posterior from them.

use super::inputs::{InferenceSettings, Walk};
use crate::fit::set::{Set, hull, intersection};
use crate::fit::{Answers, Situation};
use cocarry::Error;
use cocarry::episode::Sighting;
use cocarry::error::Place;
use cocarry::learning::{MAX_TASKS, Tolerance, likelihoods_of_sighting};
use cocarry::math;
use cocarry::preference::{Belief, ChoiceDistribution, Posterior, Prospect, Ways, with_lapses};

/// The likelihood of an answer if the human prefers each option: one choice, distributed as the participant
/// says.
pub(super) fn likelihoods(shares: &[f64], lapse_rate: f64) -> Vec<f64> {
    // of the option that the human prefers, and of another
    let [own, other] = [1.0, 0.0].map(|preferred| with_lapses(preferred, lapse_rate, shares.len()));
    let power = |base: f64, exponent: f64| if exponent == 0.0 { 1.0 } else { math::pow(base, exponent) };
    shares.iter().map(|share| power(own, *share) * power(other, (1.0 - share).max(0.0))).collect()
}

/// The probability of each option in an answer, from the probability that the human prefers it.
pub(super) fn answered(preferred: &[f64], lapse_rate: f64) -> Vec<f64> {
    preferred.iter().map(|p| with_lapses(*p, lapse_rate, preferred.len())).collect()
}

/// P_o in a world.
pub(super) fn predicted(posterior: &mut Posterior, situation: &Situation) -> Vec<f64> {
    let mut choice = ChoiceDistribution::default();
    posterior.predict_from(&situation.prospects, &Ways::default(), &mut choice);
    choice.probabilities().to_vec()
}

/// The belief over a participant's alpha and gamma.
#[derive(Clone, Debug)]
pub(super) struct Perceived {
    pub posterior: Posterior,
    /// The logarithm of the probability of all answers.
    pub log_evidence: f64,
    /// Number of answers.
    pub answers: usize,
    /// Number of sightings in walks.
    pub sightings: usize,
}

impl Perceived {
    pub fn new(belief: &Belief, risk_weight: f64) -> Result<Self, Error> {
        Ok(Self {
            posterior: Posterior::new(belief.clone(), risk_weight)?,
            log_evidence: 0.0,
            answers: 0,
            sightings: 0,
        })
    }

    /// Learns from the likelihood of what was seen, by option. False, and no change, if no human of the
    /// belief gives it.
    pub fn learn(&mut self, prospects: &[Prospect], ways: &Ways, likelihoods: &[f64]) -> bool {
        match self.posterior.observe(prospects, ways, likelihoods) {
            Ok(evidence) => {
                self.log_evidence += math::ln(evidence);
                true
            }
            Err(_) => false,
        }
    }

    /// Learns from the sightings of a walk.
    ///
    /// # Errors
    /// No alpha and gamma agree with it, and there are no lapses.
    pub fn observe(&mut self, walk: &Walk, lapse_rate: f64) -> Result<(), Error> {
        let mut likelihoods = Vec::new();
        for Sighting { prospects, ways, is_consistent } in &walk.sightings {
            likelihoods_of_sighting(is_consistent.iter().copied(), lapse_rate, &mut likelihoods);
            if !self.learn(prospects, ways, &likelihoods) {
                return Err(contradicted(
                    &walk.file,
                    &walk.participant,
                    "no alpha and gamma of the belief agree with this walk and the rest; give a --lapse-rate above 0",
                ));
            }
            self.sightings += 1;
        }
        Ok(())
    }

    /// The belief after a participant's answers in all worlds but one.
    ///
    /// # Errors
    /// No alpha and gamma agree with them, and there are no lapses.
    pub fn after(
        &self,
        answers: &Answers,
        participant: usize,
        without: Option<usize>,
        lapse_rate: f64,
    ) -> Result<Self, Error> {
        let mut perceived = self.clone();
        for (w, shares) in answers.shares[participant].iter().enumerate() {
            let Some(shares) = shares.as_ref().filter(|_| without != Some(w)) else { continue };
            let situation = &answers.situations[w];
            perceived.answers += 1;
            if !perceived.learn(&situation.prospects, &Ways::default(), &likelihoods(shares, lapse_rate)) {
                let sentence = format!(
                    "no alpha and gamma of the belief agree with the answer in {} and the others; without lapses, every answer must be 100 percent for the option that the model's human prefers: give a --lapse-rate above 0",
                    situation.world
                );
                return Err(contradicted(&answers.file, &answers.participants[participant], &sentence));
            }
        }
        Ok(perceived)
    }
}

/// The error of what a participant did.
fn contradicted(file: &str, participant: &str, sentence: &str) -> Error {
    Error::at(Place::item(file, format!("participant `{participant}`")), sentence)
}

/// The belief over a participant's eta. Episodes that no eta explains are left out.
///
/// # Errors
/// The episodes contradict each other and there are no lapses, or there are too many.
pub(super) fn tolerance(
    file: &str,
    participant: &str,
    sets: Vec<Set>,
    settings: &InferenceSettings,
) -> Result<Tolerance, Error> {
    let sets: Vec<Set> = sets.into_iter().filter(|set| !set.is_empty()).collect();
    let contradicts = !sets.is_empty() && intersection(&sets).is_empty();
    if settings.lapse_rate == 0.0 && contradicts {
        let sentence = "no eta agrees with all episodes; give a --lapse-rate above 0";
        return Err(contradicted(file, participant, sentence));
    }
    if sets.len() > MAX_TASKS {
        let count = sets.len();
        let sentence = format!("{count} episodes with a robot that leads; at most {MAX_TASKS}");
        return Err(contradicted(file, participant, &sentence));
    }
    let mut tolerance = Tolerance::new(settings.tolerance, settings.lapse_rate)?;
    for interval in sets.iter().filter_map(hull) {
        tolerance.begin_task();
        tolerance.set_task(interval);
    }
    Ok(tolerance)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_likelihoods_of_an_answer() {
        let all = likelihoods(&[0.0, 1.0, 0.0, 0.0], 0.2);
        assert!(all.iter().zip([0.05, 0.85, 0.05, 0.05]).all(|(a, b)| (a - b).abs() < 1e-12), "{all:?}");
        // half of the weight for each of two options
        let split = likelihoods(&[0.5, 0.5], 0.2);
        assert!(split.iter().all(|l| (l - (0.9f64 * 0.1).sqrt()).abs() < 1e-12), "{split:?}");
        assert_eq!(likelihoods(&[0.0, 1.0], 0.0), [0.0, 1.0]);
        assert_eq!(likelihoods(&[0.5, 0.5], 0.0), [0.0, 0.0]);
    }
}
