//! A human who follows a script of options, each from a given step on.

use super::model::{HumanModel, Participant, bad_arguments};
use super::{Human, HumanDecision, HumanView};
use crate::coordination::Stubbornness;
use crate::error::Error;
use crate::preference::Perception;
use crate::saved::{RestoreError, Saved};

/// The model's entry in the list.
pub(super) const MODEL: HumanModel = HumanModel {
    name: "scripted",
    form: "scripted(STEP:OPTION,...)",
    about: "Walks the options of a list, each from its step on",
    make: |arguments, participant| Ok(Box::new(Scripted::parse(arguments, participant)?)),
};

/// A human who prefers the option of the latest script entry, and takes the lead by eq. (5) like the paper's
/// human.
#[derive(Clone, Debug)]
pub struct Scripted {
    /// Steps and options (as indices), ordered by step; the first entry is at step 0.
    script: Vec<(u64, usize)>,
    stubbornness: Stubbornness,
    perception: Perception,
}

impl Scripted {
    fn parse(script: &str, participant: &Participant<'_>) -> Result<Self, Error> {
        let expected =
            "scripted(STEP:OPTION,...), for example scripted(0:1,30:2), ordered by step, the first at step 0";
        let wrong = || bad_arguments(expected);
        let options = participant.options.options();
        let entry = |text: &str| {
            let (step, name) = text.split_once(':').ok_or_else(wrong)?;
            let step: u64 = step.trim().parse().map_err(|_| wrong())?;
            let name = name.trim();
            let option = options.iter().position(|option| option.name == name);
            let option = option.ok_or_else(|| {
                let known = options.iter().map(|o| format!("`{}`", o.name)).collect::<Vec<_>>().join(", ");
                Error::new(format!("step {step}: unknown option `{name}`; expected one of: {known}"))
            })?;
            Ok::<_, Error>((step, option))
        };
        let script: Vec<_> = script.split(',').map(entry).collect::<Result<_, _>>()?;
        let in_order = script.windows(2).all(|pair| pair[0].0 < pair[1].0);
        match script.first() {
            Some((0, _)) if in_order => {
                let stubbornness = Stubbornness::new(participant.stubbornness);
                Ok(Self { script, stubbornness, perception: participant.perception })
            }
            _ => Err(wrong()),
        }
    }
}

impl Human for Scripted {
    fn decide(&mut self, view: &HumanView<'_>) -> HumanDecision {
        view.accumulate(&mut self.stubbornness);
        let come = self.script.partition_point(|(step, _)| *step <= view.step);
        let (_, option) = self.script[come.saturating_sub(1)];
        HumanDecision::new(option, &self.stubbornness, Some(self.perception))
    }

    fn save(&self) -> Saved {
        Saved::of(&self.stubbornness)
    }

    fn restore(&mut self, saved: &Saved) -> Result<(), RestoreError> {
        self.stubbornness = saved.read("human")?;
        Ok(())
    }
}
