//! Partners who decide as the scenario says, unless somebody outside does.

use cocarry::coordination::Mode;
use cocarry::geometry::Point;
use cocarry::human::{HandView, Human, HumanDecision, HumanView, PreferenceChange, Stance};
use cocarry::policy::{Decision, Lead, RobotPolicy, RobotView};
use cocarry::preference::Perception;
use cocarry::saved::{RestoreError, Saved};
use cocarry::scenario::Decisions;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The decisions from outside, shared by an episode's partners and whoever steers them.
#[derive(Clone, Debug, Default)]
pub struct Steering(Arc<Mutex<Steered>>);

/// What is decided outside; `None` leaves it to the scenario's partners.
#[derive(Debug, Default)]
pub struct Steered {
    /// The human's option, and the response to the robot's lead.
    pub option: Option<usize>,
    /// See [`Steered::option`].
    pub stance: Option<Stance>,
    /// The target of the hand, m.
    pub hand: Option<Point>,
    /// The leader.
    pub lead: Option<Lead>,
    /// Decisions of before, which are repeated, and how many steps they last.
    pub log: Decisions,
    /// See [`Steered::log`].
    pub logged_steps: u64,
    /// Whether the first step is tried, which gives the start its heading.
    pub is_trial: bool,
    /// The decisions in the trial.
    pub trial: (Option<HumanDecision>, Option<Decision>),
    /// Whether the human, and the policy, were ever decided for from outside.
    pub was_outside: [bool; 2],
    /// The present step.
    step: u64,
}

impl Steering {
    /// Steering that repeats the decisions of a log of this many steps first.
    pub fn repeating(log: Decisions, steps: u64) -> Self {
        Self(Arc::new(Mutex::new(Steered { log, logged_steps: steps, ..Steered::default() })))
    }

    /// The decisions.
    pub fn now(&self) -> MutexGuard<'_, Steered> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Steered {
    /// Whether the decisions of a step are repeated: a log may have more than are asked for.
    fn is_logged(&self, step: u64) -> bool {
        step < self.logged_steps
    }
}

/// A human whom somebody outside may steer. Stubbornness is that of the scenario's human.
#[derive(Clone, Debug)]
pub struct SteeredHuman {
    /// The scenario's human.
    pub human: Box<dyn Human>,
    /// The decisions from outside.
    pub steering: Steering,
}

impl Human for SteeredHuman {
    fn decide(&mut self, view: &HumanView<'_>) -> HumanDecision {
        let own = self.human.decide(view);
        let mut steered = self.steering.now();
        let most = view.prospects.len().saturating_sub(1);
        let logged = steered.log.human(view.step, steered.is_trial).copied();
        let logged = logged.filter(|_| steered.is_logged(view.step));
        let decision = logged.unwrap_or(HumanDecision {
            option: steered.option.unwrap_or(own.option),
            stance: steered.stance.unwrap_or(own.stance),
            hand: steered.hand.or(own.hand),
            ..own
        });
        let decision = HumanDecision { option: decision.option.min(most), ..decision };
        steered.was_outside[0] |= logged.is_some() || decision != own;
        steered.step = view.step;
        if steered.is_trial {
            steered.trial.0 = Some(decision);
        }
        decision
    }

    fn hand(&mut self, view: &HandView<'_>) -> Option<Point> {
        let own = self.human.hand(view);
        let mut steered = self.steering.now();
        if steered.is_logged(steered.step) && steered.log.has_human() {
            return steered.log.hand(steered.step, view.period[0]);
        }
        let target = steered.hand.or(own);
        steered.was_outside[0] |= target != own;
        target
    }

    fn set_preference(&mut self, preference: Perception) {
        self.human.set_preference(preference);
    }

    fn change(&self, step: u64) -> Option<&PreferenceChange> {
        self.human.change(step)
    }

    fn save(&self) -> Saved {
        self.human.save()
    }

    fn restore(&mut self, saved: &Saved) -> Result<(), RestoreError> {
        self.human.restore(saved)
    }
}

/// A policy in whose place somebody outside may decide who leads.
#[derive(Clone, Debug)]
pub struct SteeredPolicy {
    /// The method's policy.
    pub policy: Box<dyn RobotPolicy>,
    /// The decisions from outside.
    pub steering: Steering,
}

impl RobotPolicy for SteeredPolicy {
    fn initial_mode(&self) -> Mode {
        self.policy.initial_mode()
    }

    fn predicts(&self) -> bool {
        self.policy.predicts()
    }

    fn decide(&mut self, view: &RobotView<'_>) -> Decision {
        let own = self.policy.decide(view);
        let mut steered = self.steering.now();
        let logged = steered.log.policy(view.step, steered.is_trial).copied();
        let logged = logged.filter(|_| steered.is_logged(view.step));
        let decision =
            logged.or(steered.lead.map(|lead| Decision { lead, ..Decision::follow() })).unwrap_or(own);
        steered.was_outside[1] |= logged.is_some() || decision != own;
        if steered.is_trial {
            steered.trial.1 = Some(decision);
        }
        decision
    }

    fn save(&self) -> Saved {
        self.policy.save()
    }

    fn restore(&mut self, saved: &Saved) -> Result<(), RestoreError> {
        self.policy.restore(saved)
    }
}
