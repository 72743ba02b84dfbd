//! Humans who perceive risk otherwise than by Stevens and Prelec.

use super::model::{HumanModel, Participant, bad_arguments};
use super::{Human, HumanDecision, HumanView};
use crate::coordination::{Stubbornness, StubbornnessSettings};
use crate::error::Error;
use crate::preference::{self, RiskPerception};
use crate::saved::{RestoreError, Saved};

/// The models' entries in the list.
pub(super) const CUMULATIVE_PROSPECT: HumanModel = HumanModel {
    name: "cumulative-prospect",
    form: "cumulative-prospect(EXPONENT,WEIGHTING)",
    about: "Perceives length and risk by cumulative prospect theory",
    make: |arguments, participant| make(&preference::CUMULATIVE_PROSPECT, arguments, participant),
};

pub(super) const CONDITIONAL_VALUE_AT_RISK: HumanModel = HumanModel {
    name: "cvar",
    form: "cvar(TAIL)",
    about: "Looks at the worst outcomes of probability TAIL: conditional value at risk",
    make: |arguments, participant| make(&preference::CONDITIONAL_VALUE_AT_RISK, arguments, participant),
};

pub(super) const EXPECTED_RISK: HumanModel = HumanModel {
    name: "expected-risk",
    form: "expected-risk",
    about: "Prefers the option of least objective cost, eq. (1)",
    make: |arguments, participant| make(&preference::EXPECTED_RISK, arguments, participant),
};

/// A human who prefers the option of least cost by a [`RiskPerception`] with fixed parameters, and takes the
/// lead by eq. (5) like the paper's human.
#[derive(Clone, Debug)]
pub struct Perceiving {
    perception: &'static dyn RiskPerception,
    parameters: Vec<f64>,
    stubbornness: Stubbornness,
}

impl Perceiving {
    /// The human at the start; `parameters` are within the ranges of the perception.
    pub fn new(
        perception: &'static dyn RiskPerception,
        parameters: Vec<f64>,
        stubbornness: StubbornnessSettings,
    ) -> Self {
        Self { perception, parameters, stubbornness: Stubbornness::new(stubbornness) }
    }
}

/// The human of a model's arguments.
fn make(
    perception: &'static dyn RiskPerception,
    arguments: &str,
    participant: &Participant<'_>,
) -> Result<Box<dyn Human>, Error> {
    let known = perception.parameters();
    let wrong = || {
        let name = perception.name();
        let upper: Vec<String> = known.iter().map(|parameter| parameter.name.to_uppercase()).collect();
        let examples: Vec<String> = known.iter().map(|parameter| parameter.example.to_string()).collect();
        let ranges = known.iter().map(|parameter| {
            let [low, high] = parameter.range;
            // a tail of 0 has no mean
            let low = if low == 0.0 { "above 0".to_owned() } else { format!("from {low}") };
            format!("{} {low} to {high}", parameter.name.to_uppercase())
        });
        let ranges = ranges.collect::<Vec<_>>().join(", ");
        bad_arguments(&match known {
            [] => format!("{name}, with no arguments"),
            _ => format!(
                "{name}({}), for example {name}({}), with {ranges}",
                upper.join(","),
                examples.join(",")
            ),
        })
    };
    let texts: Vec<&str> = if arguments.is_empty() { Vec::new() } else { arguments.split(',').collect() };
    let parsed = texts.iter().map(|text| text.trim().parse::<f64>().ok());
    let parameters: Vec<f64> = parsed.collect::<Option<_>>().ok_or_else(wrong)?;
    let fits = |(parameter, value): (&preference::RiskParameter, &f64)| {
        let [low, high] = parameter.range;
        *value > 0.0 && (low..=high).contains(value)
    };
    match parameters.len() == known.len() && known.iter().zip(&parameters).all(fits) {
        true => Ok(Box::new(Perceiving::new(perception, parameters, participant.stubbornness))),
        false => Err(wrong()),
    }
}

impl Human for Perceiving {
    fn decide(&mut self, view: &HumanView<'_>) -> HumanDecision {
        view.accumulate(&mut self.stubbornness);
        let option =
            self.perception.choice(view.prospects, view.risk_weight, &self.parameters, view.executed);
        HumanDecision::new(option, &self.stubbornness, None)
    }

    fn save(&self) -> Saved {
        Saved::of(&self.stubbornness)
    }

    fn restore(&mut self, saved: &Saved) -> Result<(), RestoreError> {
        self.stubbornness = saved.read("human")?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::human::MODELS;
    use crate::preference::ALTERNATIVES;

    #[test]
    fn every_perception_is_a_human_of_its_name_and_parameters() {
        for perception in ALTERNATIVES {
            let model = MODELS.into_iter().find(|model| model.name == perception.name()).unwrap();
            let names: Vec<_> = perception.parameters().iter().map(|one| one.name.to_uppercase()).collect();
            let arguments = if names.is_empty() { String::new() } else { format!("({})", names.join(",")) };
            assert_eq!(model.form, format!("{}{arguments}", model.name));
        }
    }
}
