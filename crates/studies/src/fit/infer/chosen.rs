//! The population of people who each chose one option in every world: for many simulated studies with the same
//! worlds, whose people answer in few different ways.

use super::evidence::Perceived;
use super::inputs::{InferenceModel, InferenceSettings};
use super::population::{Figure, Grid, weights};
use crate::fit::{Answers, Situation};
use cocarry::Error;
use cocarry::math;

/// Worlds, and the model by which answers in them are understood.
#[derive(Clone, Debug)]
pub struct ChosenWorlds {
    situations: Vec<Situation>,
    grid: Grid,
    prior: Perceived,
    lapse_rate: f64,
}

/// What a person's choices say about the population: the logarithm of their probability in each population.
#[derive(Clone, Debug)]
pub struct ChoiceEvidence(Vec<f64>);

impl ChosenWorlds {
    /// These worlds.
    ///
    /// # Errors
    /// The belief is not valid.
    pub fn new(
        situations: Vec<Situation>,
        model: &InferenceModel,
        settings: &InferenceSettings,
    ) -> Result<Self, Error> {
        Ok(Self {
            situations,
            grid: Grid::new(model.belief.ranges())?,
            prior: Perceived::new(&model.belief, model.risk_weight)?,
            lapse_rate: settings.lapse_rate,
        })
    }

    /// The evidence of a person who chose these options, one in each world.
    ///
    /// # Errors
    /// No alpha and gamma agree with them, and there are no lapses.
    pub fn evidence(&self, chosen: &[usize]) -> Result<ChoiceEvidence, Error> {
        let share = |(situation, chosen): (&Situation, &usize)| {
            Some((0..situation.options.len()).map(|o| f64::from(u8::from(o == *chosen))).collect())
        };
        let answers = Answers {
            file: "simulated answers".to_owned(),
            situations: self.situations.clone(),
            participants: vec!["one".to_owned()],
            shares: vec![self.situations.iter().zip(chosen).map(share).collect()],
            scaled: Vec::new(),
        };
        let perceived = self.prior.after(&answers, 0, None, self.lapse_rate)?;
        let mut logs = self.grid.integrals(&self.grid.steps(|gamma| perceived.posterior.steps_at(gamma)));
        logs.iter_mut().for_each(|value| *value = perceived.log_evidence + math::ln(value.max(0.0)));
        Ok(ChoiceEvidence(logs))
    }

    /// The posterior of a quantity of [`super::QUANTITIES`], by index, from people: how many of each evidence.
    /// `None` if no population gives it.
    pub fn posterior(&self, people: &[(&ChoiceEvidence, usize)], which: usize) -> Option<Figure> {
        let mut logs = vec![0.0; self.grid.len()];
        for (evidence, count) in people {
            let count = *count as f64;
            logs.iter_mut().zip(&evidence.0).for_each(|(sum, log)| *sum += count * log);
        }
        let (weights, _) = weights(&logs)?;
        Some(self.grid.figure(which, &weights))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::{InferenceSettings, infer};
    use cocarry::options::OptionSet;
    use cocarry::preference::{Belief, RISK_WEIGHT};
    use cocarry::world::World;
    use std::path::Path;

    #[test]
    fn it_is_the_population_that_infer_has() {
        let situation = |name: &str| {
            let world = World::find(Path::new(""), name).unwrap();
            Situation::new(name.to_owned(), &OptionSet::new(&world, RISK_WEIGHT).unwrap())
        };
        let situations = vec![situation("environment-1"), situation("environment-4")];
        let chosen = [[1, 2], [2, 2], [1, 2], [3, 3], [1, 0]];
        let one_hot = |option: usize| Some((0..4).map(|o| f64::from(u8::from(o == option))).collect());
        let answers = Answers {
            file: "a".to_owned(),
            situations: situations.clone(),
            participants: (0..chosen.len()).map(|p| p.to_string()).collect(),
            shares: chosen.iter().map(|own| own.iter().map(|o| one_hot(*o)).collect()).collect(),
            scaled: Vec::new(),
        };
        let model = InferenceModel { belief: Belief::default(), risk_weight: RISK_WEIGHT };
        let settings = InferenceSettings { draws: 1, keeps_draws: false, ..InferenceSettings::default() };
        let inferred =
            infer(Some(&answers), None, &[], &model, &settings, &|| ()).unwrap().population.unwrap();
        let worlds = ChosenWorlds::new(situations, &model, &settings).unwrap();
        let evidence = chosen.map(|own| worlds.evidence(&own).unwrap());
        let people = [(&evidence[0], 2), (&evidence[1], 1), (&evidence[3], 1), (&evidence[4], 1)];
        for (which, wanted) in inferred.posterior.iter().enumerate() {
            let found = worlds.posterior(&people, which).unwrap();
            let pairs = [(found.median, wanted.median), (found.mean, wanted.mean), (found.std, wanted.std)];
            let ends = found.interval.into_iter().zip(wanted.interval);
            for (found, wanted) in pairs.into_iter().chain(ends) {
                assert!((found - wanted).abs() < 1e-9, "{which}: {found} {wanted}");
            }
        }
    }
}
