//! Custom policies and humans: the views that they get, and what they may return.

mod answers;
mod views;

pub use views::{PyHandView, PyHumanView, PyRobotView, PyView, configuration_vector, matrix};

use crate::error::{ClosedError, DecisionError};
use crate::value::repr;
use answers::{Basis, decision, hand_target, human_decision};
use cocarry::coordination::{Mode, Stubbornness};
use cocarry::geometry::Point;
use cocarry::human::{HandView, Human, HumanDecision, HumanView};
use cocarry::policy::{Decision, RobotPolicy, RobotView};
use cocarry::saved::{RestoreError, Saved};
use cocarry::scenario::{self, Decisions, PolicyLog, PreparedScenario};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyString, PyType};
use pyo3::{PyTraverseError, PyVisit};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// The first exception of a custom policy or human in an episode, which is raised once its step is over.
#[derive(Clone, Debug, Default)]
pub struct Fault(Arc<Mutex<Option<PyErr>>>, Arc<AtomicBool>);

impl Fault {
    /// Keeps the exception, if it is the first.
    pub fn put(&self, error: PyErr) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
    }

    /// Notes that the policy failed in the trial of the first step, and the human was taken to lead.
    fn fail_trial(&self) {
        self.1.store(true, Ordering::Relaxed);
    }

    /// The exception, once.
    pub fn take(&self) -> PyResult<()> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take().map_or(Ok(()), Err)
    }

    /// Whether there is an exception.
    pub fn is_there(&self) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }
}

/// A custom partner of an episode: the only reference to it, so that Python's collector can find an object that refers
/// to its episode, and let go of it.
#[derive(Clone, Debug)]
pub struct Held(Arc<Mutex<Option<Py<PyAny>>>>);

impl Held {
    pub fn new(object: Py<PyAny>) -> Self {
        Self(Arc::new(Mutex::new(Some(object))))
    }

    /// The object, unless it was collected.
    pub fn get(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let held = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let collected = || ClosedError::new_err("the episode's partner was collected");
        held.as_ref().map(|object| object.clone_ref(py)).ok_or_else(collected)
    }

    fn bound<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(self.get(py)?.into_bound(py))
    }

    pub fn traverse(&self, visit: &PyVisit<'_>) -> Result<(), PyTraverseError> {
        // it is locked for moments only
        self.0.try_lock().map_or(Ok(()), |held| held.as_ref().map_or(Ok(()), |object| visit.call(object)))
    }

    pub fn clear(&self) {
        let held = self.0.lock().unwrap_or_else(PoisonError::into_inner).take();
        drop(held);
    }
}

/// A Python object that decides, with its saved state.
#[derive(Debug)]
struct Partner {
    object: Held,
    basis: Basis,
    fault: Fault,
}

impl Clone for Partner {
    fn clone(&self) -> Self {
        let object = Python::attach(|py| {
            self.object.bound(py).and_then(|object| copy(&object)).map(Held::new).unwrap_or_else(|error| {
                self.fault.put(error);
                self.object.clone()
            })
        });
        Self { object, basis: self.basis.clone(), fault: self.fault.clone() }
    }
}

/// A deep copy; of a function, the function itself.
pub fn copy(object: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
    let copy = object.py().import("copy")?;
    copy.call_method1("deepcopy", (object,)).map(Bound::unbind).map_err(|cause| {
        let error = DecisionError::new_err(format!(
            "{} cannot be copied, but an episode tries its first step on a copy: {cause}; give it a __deepcopy__",
            repr(object)
        ));
        error.set_cause(object.py(), Some(cause));
        error
    })
}

/// An attribute that is true; false if there is none.
fn flag(object: &Bound<'_, PyAny>, name: &str) -> bool {
    let value = object.getattr_opt(name).ok().flatten();
    value.is_some_and(|value| value.is_truthy().unwrap_or(false))
}

/// The mode before the first step that a policy asks for.
fn initial_mode(policy: &Bound<'_, PyAny>) -> Mode {
    if flag(policy, "human_leads_first") { Mode::HumanLed } else { Mode::RobotLed }
}

impl Partner {
    /// Calls the object: its method `decide`, or itself.
    fn ask<'py>(&self, py: Python<'py>, view: Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let object = self.object.bound(py)?;
        match object.getattr_opt("decide")? {
            Some(decide) => decide.call1((view,)),
            None => object.call1((view,)),
        }
    }

    fn save(&self) -> Vec<u8> {
        Python::attach(|py| {
            let save = self.object.bound(py).and_then(|object| object.getattr_opt("save"));
            let saved = save.and_then(|save| match save {
                Some(save) => save.call0()?.extract::<Vec<u8>>(),
                None => Ok(Vec::new()),
            });
            saved.unwrap_or_else(|error| {
                self.fault.put(error);
                Vec::new()
            })
        })
    }

    fn restore(&self, bytes: &[u8]) -> PyResult<()> {
        Python::attach(|py| match self.object.bound(py)?.getattr_opt("restore")? {
            Some(restore) => restore.call1((PyBytes::new(py, bytes),)).map(drop),
            None => Ok(()),
        })
    }

    fn saved(&self) -> Saved {
        let bytes = self.save();
        if bytes.is_empty() { Saved::default() } else { Saved::of(&bytes) }
    }

    fn read(&self, saved: &Saved, part: &'static str) -> Result<(), RestoreError> {
        if saved.is_empty(part).is_ok() {
            return Ok(());
        }
        let bytes: Vec<u8> = saved.read(part)?;
        self.restore(&bytes).map_err(|error| {
            self.fault.put(error);
            RestoreError { part }
        })
    }
}

/// What the views of policies and humans have in common, as Python sees it.
macro_rules! common {
    ($view:expr, $basis:expr, $hand:expr, $hand_wrench:expr) => {
        PyView {
            prepared: Arc::clone(&$basis.prepared),
            shown: Arc::clone(&$basis.shown),
            step: $view.step,
            time: $view.time,
            planning_step: $view.planning_step,
            position: $view.position,
            progress: $view.progress.clone(),
            names: Arc::clone(&$basis.names),
            evaluated: $view.evaluated.to_vec(),
            executed: $view.executed,
            mode: $view.mode,
            hand: $hand,
            hand_wrench: $hand_wrench,
        }
    };
}

/// A custom policy.
#[derive(Clone, Debug)]
struct OwnPolicy(Partner);

impl RobotPolicy for OwnPolicy {
    fn initial_mode(&self) -> Mode {
        Python::attach(|py| self.0.object.bound(py).map_or(Mode::RobotLed, |object| initial_mode(&object)))
    }

    fn predicts(&self) -> bool {
        Python::attach(|py| self.0.object.bound(py).is_ok_and(|object| flag(&object, "predicts")))
    }

    fn decide(&mut self, view: &RobotView<'_>) -> Decision {
        let Partner { basis, fault, .. } = &self.0;
        if fault.is_there() {
            return Decision::follow();
        }
        let decided = Python::attach(|py| {
            let seen = PyRobotView {
                stance: view.stance,
                stubbornness: view.stubbornness,
                discomfort: view.discomfort,
                configuration: view.configuration.map(|configuration| (*configuration, basis.joints)),
                grasp: view.grasp,
                object: view.object.copied(),
                grip_wrench: view.grip_wrench.map(wrench),
            };
            let seen = (seen, common!(view, basis, view.hand.copied(), view.hand_wrench.map(wrench)));
            let answer = self.0.ask(py, Bound::new(py, seen)?.into_any())?;
            decision(basis, &answer)
        });
        decided.unwrap_or_else(|error| {
            // the trial of the first step, which sets the start's heading, is without a robot: a policy that
            // needs one starts as if the human led
            match basis.has_robot && view.configuration.is_none() {
                true => fault.fail_trial(),
                false => fault.put(error),
            }
            Decision::follow()
        })
    }

    fn save(&self) -> Saved {
        self.0.saved()
    }

    fn restore(&mut self, saved: &Saved) -> Result<(), RestoreError> {
        self.0.read(saved, "policy")
    }
}

fn wrench(wrench: &cocarry::simulation::Wrench) -> [f64; 6] {
    let (f, t) = (wrench.force, wrench.torque);
    [f.x, f.y, f.z, t.x, t.y, t.z]
}

/// A custom human. One who returns only an option has the stubbornness of eq. (5).
#[derive(Clone, Debug)]
struct OwnHuman {
    partner: Partner,
    stubbornness: Stubbornness,
}

impl Human for OwnHuman {
    fn decide(&mut self, view: &HumanView<'_>) -> HumanDecision {
        view.accumulate(&mut self.stubbornness);
        let Partner { basis, fault, .. } = &self.partner;
        let nothing = HumanDecision::new(0, &self.stubbornness, None);
        if fault.is_there() {
            return nothing;
        }
        let decided = Python::attach(|py| {
            let seen = PyHumanView {
                prospects: view.prospects.to_vec(),
                risk_weight: view.risk_weight,
                seed: basis.seed,
            };
            let seen = (seen, common!(view, basis, view.hand.copied(), view.wrench.map(wrench)));
            let answer = self.partner.ask(py, Bound::new(py, seen)?.into_any())?;
            human_decision(basis, &self.stubbornness, &answer)
        });
        decided.unwrap_or_else(|error| {
            fault.put(error);
            nothing
        })
    }

    fn hand(&mut self, view: &HandView<'_>) -> Option<Point> {
        let Partner { object, fault, .. } = &self.partner;
        if fault.is_there() {
            return None;
        }
        let target = Python::attach(|py| {
            let Some(hand) = object.bound(py)?.getattr_opt("hand")?.filter(|hand| hand.is_callable()) else {
                return Ok(None);
            };
            let HandView { time, period, control_period, hand: at, heading, wrench: felt, .. } = *view;
            let hand_wrench = felt.map(wrench);
            let seen = PyHandView { time, period, control_period, hand: at, heading, hand_wrench };
            hand_target(&hand.call1((Bound::new(py, seen)?,))?)
        });
        target.unwrap_or_else(|error| {
            fault.put(error);
            None
        })
    }

    fn save(&self) -> Saved {
        Saved::of(&(&self.stubbornness, self.partner.save()))
    }

    fn restore(&mut self, saved: &Saved) -> Result<(), RestoreError> {
        let (stubbornness, bytes): (Stubbornness, Vec<u8>) = saved.read("human")?;
        self.stubbornness = stubbornness;
        if bytes.is_empty() {
            return Ok(());
        }
        self.partner.restore(&bytes).map_err(|error| {
            self.partner.fault.put(error);
            RestoreError { part: "human" }
        })
    }
}

/// The custom partners of an episode: None for the scenario's.
#[derive(Clone, Debug, Default)]
pub struct Own {
    pub policy: Option<Held>,
    pub human: Option<Held>,
}

impl Own {
    /// Takes the arguments: an object with a method `decide`, a callable, or a class of one of them, of which
    /// an instance is made.
    pub fn of(policy: Option<&Bound<'_, PyAny>>, human: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let one = |name: &str, given: Option<&Bound<'_, PyAny>>| {
            let Some(given) = given else { return Ok(None) };
            let given = &match given.is_instance_of::<PyString>() {
                // one that a package has registered
                true => given.py().import("cocarry._registry")?.call_method1("load", (name, given))?,
                false => given.clone(),
            };
            let object = if given.is_instance_of::<PyType>() { given.call0()? } else { given.clone() };
            if !object.is_callable() && object.getattr_opt("decide")?.is_none() {
                return Err(DecisionError::new_err(format!(
                    "{name} = {}; it must be a callable, an object with a method decide(view), or a class of such objects",
                    repr(given)
                )));
            }
            Ok(Some(Held::new(object.unbind())))
        };
        Ok(Self { policy: one("policy", policy)?, human: one("human", human)? })
    }

    /// Deep copies of them.
    pub fn copied(&self, py: Python<'_>) -> PyResult<Self> {
        let one =
            |held: &Option<Held>| held.as_ref().map(|held| copy(&held.bound(py)?).map(Held::new)).transpose();
        Ok(Self { policy: one(&self.policy)?, human: one(&self.human)? })
    }

    /// The partners, for Python's collector.
    pub fn held(&self) -> impl Iterator<Item = &Held> {
        self.policy.iter().chain(&self.human)
    }

    /// A log for a recording of an episode of theirs.
    pub fn log(&self, py: Python<'_>, fault: &Fault) -> Decisions {
        let policy = self.policy.as_ref().and_then(|held| held.bound(py).ok());
        let policy = policy.map(|object| PolicyLog {
            initial_mode: initial_mode(&object),
            predicts: flag(&object, "predicts"),
            trial: fault.1.load(Ordering::Relaxed).then(Decision::follow),
            steps: Vec::new(),
        });
        Decisions::new(self.human.is_some(), policy)
    }

    /// As partners of an episode of a prepared scenario.
    pub fn partners(self, prepared: &PreparedScenario, fault: &Fault) -> scenario::Partners<'static> {
        let basis = Basis::of(prepared);
        let partner = |object| Partner { object, basis: basis.clone(), fault: fault.clone() };
        let stubbornness = Stubbornness::new(prepared.scenario().settings.coordination);
        scenario::Partners {
            human: self.human.map(|object| {
                Box::new(OwnHuman { partner: partner(object), stubbornness }) as Box<dyn Human>
            }),
            policy: self.policy.map(|object| Box::new(OwnPolicy(partner(object))) as Box<dyn RobotPolicy>),
        }
    }
}
