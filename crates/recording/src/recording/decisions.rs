//! The decisions of custom partners in a recording, whose code it does not have: replays repeat them.

use super::records::Attachment;
use super::{ReadError, Reader};
use cocarry::bounds;
use cocarry::coordination::Mode;
use cocarry::episode::Episode;
use cocarry::geometry::Point;
use cocarry::human::{HandView, Human, HumanDecision, HumanView};
use cocarry::policy::{Decision, Motion, RobotPolicy, RobotView};
use cocarry::scenario::{Partners, PreparedScenario};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The name of the attachment with the decisions.
pub const DECISIONS: &str = "decisions.json";
/// The largest magnitude of a number of a logged motion.
const MAX_MOTION: f64 = 1e6;

/// A log of the decisions of custom partners; `None` for those that the scenario names.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Decisions {
    /// The human's, by step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    human: Option<Vec<HumanDecision>>,
    /// The targets of the human's hand by step and control period, where the human gave one for a period.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    hands: BTreeMap<u64, Vec<Option<Point>>>,
    /// The policy's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    policy: Option<PolicyLog>,
}

/// The decisions of a policy, and what it says about itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PolicyLog {
    /// The mode before the first step.
    pub initial_mode: Mode,
    /// Whether it needs predictions while the human leads.
    pub predicts: bool,
    /// The decision in the trial of the first step, which gives the start its heading, where it is another one
    /// than in the first step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trial: Option<Decision>,
    /// The decisions, by step.
    pub steps: Vec<Decision>,
}

impl Decisions {
    /// A log before the first step. `policy` has no steps yet.
    pub fn new(logs_human: bool, policy: Option<PolicyLog>) -> Self {
        Self { human: logs_human.then(Vec::new), hands: BTreeMap::new(), policy }
    }

    /// Adds the last step.
    pub(super) fn add(&mut self, episode: &Episode) {
        let Some((human, decision)) = episode.decided() else { return };
        self.human.iter_mut().for_each(|steps| steps.push(*human));
        if self.human.is_some() && !episode.hands().is_empty() {
            self.hands.insert(episode.tick().step, episode.hands().to_vec());
        }
        self.policy.iter_mut().for_each(|log| log.steps.push(*decision));
    }

    /// As an attachment; `None` for an empty log, or one that JSON cannot represent.
    pub(super) fn attachment(&self) -> Option<Attachment> {
        let data = serde_json::to_vec(self).ok().filter(|_| *self != Self::default())?;
        Some(Attachment { name: DECISIONS.to_owned(), media_type: "application/json".to_owned(), data })
    }

    /// Reads an attachment.
    pub(super) fn read<R: std::io::Read>(
        reader: &Reader<R>,
        attachment: &Attachment,
    ) -> Result<Self, ReadError> {
        let lacks = |what: String| ReadError::Lacks { file: reader.name().to_owned(), what };
        let limit = bounds::DECISIONS.bytes();
        if attachment.data.len() as u64 > limit {
            return Err(lacks(format!("its attachment {DECISIONS} is larger than {limit} bytes")));
        }
        let log: Self = serde_json::from_slice(&attachment.data).map_err(|error| {
            lacks(format!("its attachment {DECISIONS} is not a log of decisions: {error}"))
        })?;
        let decisions = log.policy.iter().flat_map(|log| log.trial.iter().chain(&log.steps));
        let is_bounded = |number: &f64| number.abs() <= MAX_MOTION;
        let mut motions = decisions.map(|decision| match &decision.motion {
            Motion::Controlled => true,
            Motion::Reference(poses) => {
                poses.iter().all(|pose| [pose.position.x, pose.position.y, pose.yaw].iter().all(is_bounded))
            }
            Motion::Inputs(u) => u.iter().all(is_bounded),
        });
        match motions.all(|is_bounded| is_bounded) {
            true => Ok(log),
            false => Err(lacks(format!("its attachment {DECISIONS} has a motion beyond {MAX_MOTION}"))),
        }
    }

    /// Partners that repeat the decisions; after the last one, the human keeps the last option and leads.
    pub(super) fn partners(self, prepared: &PreparedScenario) -> Partners<'static> {
        let has_robot = prepared.robot().is_some();
        Partners {
            human: self
                .human
                .map(|steps| Box::new(LoggedHuman { steps, hands: self.hands, step: 0 }) as Box<dyn Human>),
            policy: self.policy.map(|log| Box::new(LoggedPolicy { log, has_robot }) as Box<dyn RobotPolicy>),
        }
    }
}

#[derive(Clone, Debug)]
struct LoggedHuman {
    steps: Vec<HumanDecision>,
    hands: BTreeMap<u64, Vec<Option<Point>>>,
    /// The present step.
    step: u64,
}

impl Human for LoggedHuman {
    fn decide(&mut self, view: &HumanView<'_>) -> HumanDecision {
        self.step = view.step;
        let step = usize::try_from(view.step).unwrap_or(usize::MAX).min(self.steps.len().saturating_sub(1));
        let most = view.prospects.len().saturating_sub(1);
        match self.steps.get(step) {
            Some(decision) => HumanDecision { option: decision.option.min(most), ..*decision },
            None => HumanDecision::following(0),
        }
    }

    fn hand(&mut self, view: &HandView<'_>) -> Option<Point> {
        let logged = self.hands.get(&self.step).and_then(|hands| hands.get(view.period[0] as usize));
        logged.copied().flatten()
    }
}

#[derive(Clone, Debug)]
struct LoggedPolicy {
    log: PolicyLog,
    has_robot: bool,
}

impl RobotPolicy for LoggedPolicy {
    fn initial_mode(&self) -> Mode {
        self.log.initial_mode
    }

    fn predicts(&self) -> bool {
        self.log.predicts
    }

    fn decide(&mut self, view: &RobotView<'_>) -> Decision {
        let is_trial = self.has_robot && view.configuration.is_none();
        let trial = self.log.trial.filter(|_| is_trial);
        let step = usize::try_from(view.step).unwrap_or(usize::MAX);
        trial.or_else(|| self.log.steps.get(step).copied()).unwrap_or(Decision::follow())
    }
}
