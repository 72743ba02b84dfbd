//! Options that a leader takes up and drops again soon, and why.

use cocarry::coordination::{Mode, OptionTick, robot_choice};
use cocarry::episode::Tick;
use cocarry::preference::{Perception, Predictor, Prospect, human_choice, objective_cost};
use serde::Serialize;

/// An option that is dropped after no more steps than this is dropped soon.
pub const SOON_STEPS: u64 = 5;

/// Lengths differ by rounding by no more than this, m.
const ROUNDING_M: f64 = 1e-9;

/// An option that a leader took up and dropped again soon.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Dropped {
    /// The seed of the episode.
    pub seed: u64,
    /// The step in which it was taken up.
    pub taken_up: u64,
    /// The step in which it was dropped.
    pub dropped: u64,
    /// Who led.
    pub mode: Mode,
    /// The option before it, the option itself, and the one after it, by name.
    pub options: [String; 3],
    /// Why.
    pub cause: Cause,
    /// The world, as a world file.
    pub world: String,
    /// The human.
    pub human: Perception,
    /// eta.
    pub eta: f64,
}

/// Why an option was dropped: the first of these without which the leader would have kept it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cause {
    /// phi grew: with phi of the step in which the option was taken up, eq. (6) keeps it.
    Stubbornness,
    /// A gap was crossed or left behind: the risks S of the options changed.
    Opening,
    /// A length D did not fall as the team walked: that of the option walked by less, or another's by more.
    Length,
    /// None of these: the perceived lengths change along the walk, eqs. (2), (3) and (6).
    Perception,
}

impl Cause {
    /// All causes.
    pub const ALL: [Self; 4] = [Self::Stubbornness, Self::Opening, Self::Length, Self::Perception];
}

/// Who decides, and by what.
pub(super) struct Leader<'a> {
    pub predictor: &'a mut Predictor,
    pub human: Perception,
    /// The length of a step, m.
    pub step: f64,
}

impl Leader<'_> {
    /// Why the option that was taken up in one step was dropped in another.
    pub fn cause(&mut self, taken_up: &Tick, dropped: &Tick) -> Cause {
        let kept = Some(taken_up.executed);
        if dropped.mode == Mode::RobotLed {
            let costs = dropped.options.iter().map(|o| (o.objective, o.expected));
            if robot_choice(costs, taken_up.stubbornness, kept) == taken_up.executed {
                return Cause::Stubbornness;
            }
        }
        let (before, after) = (&taken_up.options, &dropped.options);
        if before.iter().zip(after).any(|(a, b)| a.remaining.risk != b.remaining.risk) {
            return Cause::Opening;
        }
        let walked = self.step * (dropped.step - taken_up.step) as f64 + ROUNDING_M;
        let as_walked = |(o, (a, b)): (usize, (&OptionTick, &OptionTick))| {
            let (length, expected) = (b.remaining.length, a.remaining.length - walked);
            let length = if o == taken_up.executed { length.min(expected) } else { length.max(expected) };
            Prospect { length, risk: b.remaining.risk }
        };
        let prospects: Vec<Prospect> = before.iter().zip(after).enumerate().map(as_walked).collect();
        match self.choice(&prospects, dropped, kept) == taken_up.executed {
            true => Cause::Length,
            false => Cause::Perception,
        }
    }

    /// The choice of whoever leads among these options, eqs. (3) and (6).
    fn choice(&mut self, prospects: &[Prospect], tick: &Tick, current: Option<usize>) -> usize {
        let risk_weight = self.predictor.risk_weight();
        if tick.mode == Mode::HumanLed {
            return human_choice(prospects, risk_weight, self.human, current);
        }
        let mut expected = Vec::new();
        self.predictor.expected_costs(prospects, &mut expected);
        let costs = prospects.iter().map(|prospect| objective_cost(*prospect, risk_weight));
        robot_choice(costs.zip(expected), tick.stubbornness, current)
    }
}
