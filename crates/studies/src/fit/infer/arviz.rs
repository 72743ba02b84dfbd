//! The result of an inference as a store of ArviZ's groups.

use super::{CHAINS, Draws, Inference, InferenceSettings, Switches};
use crate::fit::{Answers, set::hull};
use crate::zarr::{Array, Store, Values, ZarrGroup};

type Dimension = (String, usize);

fn dimension(name: &str, length: usize) -> Dimension {
    (name.to_owned(), length)
}

/// The coordinate of a dimension: its indices.
fn indices(name: &str, length: usize) -> Array {
    let values = Values::Indices((0..length as i64).collect());
    Array { name: name.to_owned(), dimensions: vec![dimension(name, length)], values }
}

/// The coordinate of a dimension: texts.
fn texts(name: &str, texts: Vec<String>) -> Array {
    let dimensions = vec![dimension(name, texts.len())];
    Array { name: name.to_owned(), dimensions, values: Values::Texts(texts) }
}

fn numbers(name: &str, dimensions: Vec<Dimension>, values: Vec<f64>) -> Array {
    Array { name: name.to_owned(), dimensions, values: Values::Numbers(values) }
}

impl Inference {
    /// Groups `posterior`, `prior`, `sample_stats` and `observed_data`, as ArviZ names them.
    pub fn store(
        &self,
        answers: Option<&Answers>,
        switches: Option<Switches>,
        settings: &InferenceSettings,
    ) -> Store {
        let mut store = Store::default();
        let attributes = [
            ("inference_library", "cocarry".into()),
            ("inference_library_version", env!("CARGO_PKG_VERSION").into()),
            ("lapse_rate", settings.lapse_rate.into()),
            ("seed", settings.seed.into()),
        ];
        store.attributes.extend(attributes.map(|(name, value)| (name.to_owned(), value)));
        store.groups.push(self.group("posterior", &self.posterior));
        store.groups.push(self.group("prior", &self.prior));
        let by_draw = by_draw(&self.posterior);
        let lp = numbers("lp", by_draw.to_vec(), self.posterior.log_density.clone());
        let arrays = by_draw.map(|(name, length)| indices(&name, length)).into_iter().chain([lp]).collect();
        store.groups.push(ZarrGroup { name: "sample_stats".to_owned(), arrays });
        let mut observed = ZarrGroup { name: "observed_data".to_owned(), arrays: Vec::new() };
        if let Some(answers) = answers {
            observed.arrays.extend(shares(answers));
        }
        if let Some(Switches { switches, .. }) = switches {
            let episodes = || vec![dimension("episode", switches.len())];
            let end = |which: usize| {
                let of = |set| hull(set).map_or(f64::NAN, |ends| ends[which]);
                switches.iter().map(|switch| of(&switch.etas)).collect()
            };
            let participants = switches.iter().map(|switch| switch.participant.clone()).collect();
            observed.arrays.extend([
                indices("episode", switches.len()),
                Array {
                    name: "episode_participant".to_owned(),
                    dimensions: episodes(),
                    values: Values::Texts(participants),
                },
                numbers("eta_low", episodes(), end(0)),
                numbers("eta_high", episodes(), end(1)),
            ]);
        }
        store.groups.push(observed);
        store
    }

    fn group(&self, name: &str, draws: &Draws) -> ZarrGroup {
        let by_draw = by_draw(draws);
        let names: Vec<String> = self.people.iter().map(|person| person.participant.clone()).collect();
        let mut by_person = by_draw.to_vec();
        by_person.push(dimension("participant", names.len()));
        let mut arrays: Vec<Array> = by_draw.iter().map(|(name, length)| indices(name, *length)).collect();
        arrays.push(texts("participant", names));
        for (name, all) in [("alpha", &draws.alpha), ("gamma", &draws.gamma), ("eta", &draws.eta)] {
            if !all.is_empty() {
                let draws = 0..CHAINS * draws.length;
                let values = draws.flat_map(|draw| all.iter().map(move |own| own[draw])).collect();
                arrays.push(numbers(name, by_person.clone(), values));
            }
        }
        let names = ["alpha_mu", "alpha_sigma", "gamma_mu", "gamma_sigma"];
        for (name, all) in names.into_iter().zip(&draws.population).filter(|(_, all)| !all.is_empty()) {
            arrays.push(numbers(name, by_draw.to_vec(), all.clone()));
        }
        ZarrGroup { name: name.to_owned(), arrays }
    }
}

fn by_draw(draws: &Draws) -> [Dimension; 2] {
    [dimension("chain", CHAINS), dimension("draw", draws.length)]
}

/// The answers, by participant and option of every world; NaN where a participant was not asked.
fn shares(answers: &Answers) -> [Array; 3] {
    let participants = answers.participants.clone();
    let options: Vec<String> = answers
        .situations
        .iter()
        .flat_map(|s| s.options.iter().map(move |option| format!("{}: {option}", s.world)))
        .collect();
    let of = |own: &Vec<Option<Vec<f64>>>| -> Vec<f64> {
        let one = |(s, shares): (&crate::fit::Situation, &Option<Vec<f64>>)| {
            shares.clone().unwrap_or_else(|| vec![f64::NAN; s.options.len()])
        };
        answers.situations.iter().zip(own).flat_map(one).collect()
    };
    let values = answers.shares.iter().flat_map(of).collect();
    let dimensions = vec![dimension("answerer", participants.len()), dimension("option", options.len())];
    [texts("answerer", participants), texts("option", options), numbers("share", dimensions, values)]
}
