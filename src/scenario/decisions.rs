//! The decisions of custom partners, whose code a scenario does not have: a log, and partners that repeat it.

use super::{Partners, PreparedScenario};
use crate::coordination::Mode;
use crate::episode::Episode;
use crate::geometry::Point;
use crate::human::{HandView, Human, HumanDecision, HumanView, PreferenceChange};
use crate::policy::{Decision, Motion, RobotPolicy, RobotView};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The largest magnitude of a number of a logged motion.
pub const MAX_MOTION: f64 = 1e6;

/// A log of the decisions of custom partners; `None` for those that the scenario names.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Decisions {
    /// The human's, by step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    human: Option<Vec<HumanDecision>>,
    /// The targets of the human's hand by step and control period, where the human gave one for a period.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    hands: BTreeMap<u64, Vec<Option<Point>>>,
    /// The human's decision in the trial of the first step, which gives the start its heading, if it differs
    /// from the decision in the first step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    human_trial: Option<HumanDecision>,
    /// Whether the human also has the scenario's preference changes.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    has_changes: bool,
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
    /// The decision in the trial of the first step, which gives the start its heading, if it differs from the
    /// decision in the first step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trial: Option<Decision>,
    /// The decisions, by step.
    pub steps: Vec<Decision>,
}

impl Decisions {
    /// A log before the first step. `policy` has no steps yet.
    pub fn new(logs_human: bool, policy: Option<PolicyLog>) -> Self {
        Self { human: logs_human.then(Vec::new), policy, ..Self::default() }
    }

    /// Adds the last step.
    pub fn add(&mut self, episode: &Episode) {
        let Some((human, decision)) = episode.decided() else { return };
        self.human.iter_mut().for_each(|steps| steps.push(*human));
        if self.human.is_some() && !episode.hands().is_empty() {
            self.hands.insert(episode.tick().step, episode.hands().to_vec());
        }
        self.policy.iter_mut().for_each(|log| log.steps.push(*decision));
    }

    /// The same log before the first step.
    #[must_use]
    pub fn begun(&self) -> Self {
        let policy = self.policy.as_ref().map(|log| PolicyLog { steps: Vec::new(), ..log.clone() });
        let human = self.human.as_ref().map(|_| Vec::new());
        let Self { human_trial, has_changes, .. } = *self;
        Self { human, hands: BTreeMap::new(), human_trial, has_changes, policy }
    }

    /// The same log with the decisions in the trial of the first step, where they differ from those in the
    /// first step.
    #[must_use]
    pub fn with_trials(self, human: Option<HumanDecision>, policy: Option<Decision>) -> Self {
        let log = self.policy.map(|log| PolicyLog { trial: policy, ..log });
        Self { human_trial: human, policy: log, ..self }
    }

    /// The same log of a human who also has the scenario's preference changes, as a steered human has.
    #[must_use]
    pub fn with_changes(self) -> Self {
        Self { has_changes: true, ..self }
    }

    /// The human's part of the log, the policy's, both or neither.
    #[must_use]
    pub fn only(self, human: bool, policy: bool) -> Self {
        let policy = self.policy.filter(|_| policy);
        if human { Self { policy, ..self } } else { Self { policy, ..Self::default() } }
    }

    /// Whether a policy decided that the scenario does not describe, one of another program.
    pub fn has_custom_policy(&self) -> bool {
        self.policy.is_some()
    }

    /// Whether a human decided whom the scenario does not describe, one of another program. A human who was
    /// steered is the scenario's all the same.
    pub fn has_custom_human(&self) -> bool {
        self.human.is_some() && !self.has_changes
    }

    /// Whether it logs a human.
    pub fn has_human(&self) -> bool {
        self.human.is_some()
    }

    /// The human's decision in a step, or in the trial of the first one; `None` where the log has none.
    pub fn human(&self, step: u64, is_trial: bool) -> Option<&HumanDecision> {
        let logged = || self.human.as_ref()?.get(usize::try_from(step).ok()?);
        self.human_trial.as_ref().filter(|_| is_trial).or_else(logged)
    }

    /// The policy's decision in a step, or in the trial of the first one; `None` where the log has none.
    pub fn policy(&self, step: u64, is_trial: bool) -> Option<&Decision> {
        let log = self.policy.as_ref()?;
        log.trial.as_ref().filter(|_| is_trial).or_else(|| log.steps.get(usize::try_from(step).ok()?))
    }

    /// The target of the human's hand in a control period, where the human gave one for the period.
    pub fn hand(&self, step: u64, period: u32) -> Option<Point> {
        self.hands.get(&step)?.get(period as usize).copied().flatten()
    }

    /// Whether the log has no decisions and no partner to log.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Whether every number of its motions and targets is at most [`MAX_MOTION`].
    pub fn is_bounded(&self) -> bool {
        let is_bounded = |number: &f64| number.abs() <= MAX_MOTION;
        let is_near = |point: &Point| point.coords.iter().all(is_bounded);
        let decisions = self.policy.iter().flat_map(|log| log.trial.iter().chain(&log.steps));
        let mut motions = decisions.map(|decision| match &decision.motion {
            Motion::Controlled => true,
            Motion::Reference(poses) => {
                poses.iter().all(|pose| is_near(&pose.position) && is_bounded(&pose.yaw))
            }
            Motion::Inputs(u) | Motion::Residual(u) => u.iter().all(is_bounded),
        });
        let targets = self.human_decisions().filter_map(|decision| decision.hand.as_ref());
        let mut targets = targets.chain(self.hands.values().flatten().flatten());
        motions.all(|is| is) && targets.all(is_near)
    }

    /// The human's decisions: that of the trial, if it differs, then those of the steps.
    fn human_decisions(&self) -> impl Iterator<Item = &HumanDecision> {
        self.human_trial.iter().chain(self.human.iter().flatten())
    }

    /// Partners that repeat the decisions; after the last one, the human keeps the last option and leads.
    pub fn partners(self, prepared: &PreparedScenario) -> Partners<'static> {
        let has_robot = prepared.robot().is_some();
        let log = Arc::new(self);
        let mut partners = Partners::default();
        if log.human.is_some() {
            let changes = if log.has_changes { &prepared.scenario().changes[..] } else { &[] };
            let changes = PreferenceChange::in_force(changes);
            let human = LoggedHuman { log: Arc::clone(&log), changes, is_tried: Arc::default(), step: 0 };
            partners.human = Some(Box::new(human));
        }
        if let Some(PolicyLog { initial_mode, predicts, .. }) = log.policy {
            let policy = LoggedPolicy { log: Arc::clone(&log), initial_mode, predicts, has_robot };
            partners.policy = Some(Box::new(policy));
        }
        partners
    }
}

#[derive(Clone, Debug)]
struct LoggedHuman {
    log: Arc<Decisions>,
    /// By step.
    changes: Vec<PreferenceChange>,
    /// Whether the trial, in which a copy decides, is over.
    is_tried: Arc<AtomicBool>,
    /// The present step.
    step: u64,
}

impl Human for LoggedHuman {
    fn decide(&mut self, view: &HumanView<'_>) -> HumanDecision {
        self.step = view.step;
        let most = view.prospects.len().saturating_sub(1);
        let is_trial = !self.is_tried.swap(true, Ordering::Relaxed);
        let last = || self.log.human.as_ref().and_then(|steps| steps.last());
        match self.log.human(view.step, is_trial).or_else(last) {
            Some(decision) => HumanDecision { option: decision.option.min(most), ..*decision },
            None => HumanDecision::following(0),
        }
    }

    fn hand(&mut self, view: &HandView<'_>) -> Option<Point> {
        self.log.hand(self.step, view.period[0])
    }

    fn change(&self, step: u64) -> Option<&PreferenceChange> {
        self.changes.iter().find(|change| change.step == step)
    }
}

#[derive(Clone, Debug)]
struct LoggedPolicy {
    log: Arc<Decisions>,
    initial_mode: Mode,
    predicts: bool,
    has_robot: bool,
}

impl RobotPolicy for LoggedPolicy {
    fn initial_mode(&self) -> Mode {
        self.initial_mode
    }

    fn predicts(&self) -> bool {
        self.predicts
    }

    fn decide(&mut self, view: &RobotView<'_>) -> Decision {
        let is_trial = self.has_robot && view.configuration.is_none();
        self.log.policy(view.step, is_trial).copied().unwrap_or(Decision::follow())
    }
}
