//! Own policies and humans: the views that they get, and what they may return.

mod views;

pub use views::{PyHumanView, PyRobotView, configuration_vector};

use crate::error::DecisionError;
use cocarry::control::HORIZON;
use cocarry::coordination::{Mode, Stubbornness};
use cocarry::geometry::{PlanarPose, Point};
use cocarry::human::{Human, HumanDecision, HumanView, Stance};
use cocarry::policy::{Decision, Lead, Motion, RobotPolicy, RobotView};
use cocarry::preference::Perception;
use cocarry::quantities::Kind;
use cocarry::recording::{Decisions, PolicyLog};
use cocarry::robot::InputVector;
use cocarry::saved::{NotRestored, Saved};
use cocarry::scenario::{self, PreparedScenario};
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyString, PyType};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use views::{STANCES, Seen, stance};

/// The first exception of an own policy or human in an episode, which is raised once its step is over.
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

/// What an own partner may know of its scenario.
#[derive(Clone, Debug)]
struct Basis {
    names: Arc<[String]>,
    joints: usize,
    input_limits: usize,
    seed: u64,
    has_robot: bool,
}

impl Basis {
    fn of(stage: &PreparedScenario) -> Self {
        let names = stage.options().options().iter().map(|option| option.name.clone()).collect();
        let joints = stage.robot().map_or(0, |robot| robot.joints.len());
        let seed = stage.scenario().seed;
        Self { names, joints, input_limits: joints + 2, seed, has_robot: stage.robot().is_some() }
    }

    /// The option of an index or a name.
    fn option(&self, given: &Bound<'_, PyAny>) -> Option<usize> {
        if given.is_instance_of::<PyBool>() {
            return None;
        }
        if let Ok(name) = given.cast::<PyString>() {
            let name = name.to_string();
            return self.names.iter().position(|other| *other == name);
        }
        given.extract().ok().filter(|option| *option < self.names.len())
    }

    fn options(&self) -> String {
        format!("an option: an index from 0 to {} or one of {}", self.names.len() - 1, self.names.join(", "))
    }
}

fn repr(value: &Bound<'_, PyAny>) -> String {
    let text = value.repr().map_or_else(|_| "?".to_owned(), |text| text.to_string());
    match text.char_indices().nth(120) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

fn numbers<const N: usize>(array: &PyReadonlyArray2<'_, f64>) -> Option<Vec<[f64; N]>> {
    let array = array.as_array();
    let rows = array.rows().into_iter().map(|row| <[f64; N]>::try_from(row.to_vec()).ok());
    rows.collect::<Option<Vec<_>>>().filter(|rows| rows.iter().flatten().all(|number| number.is_finite()))
}

/// A motion of the robot: a reference of shape (8, 3), or inputs of shape (2 + joints,).
pub fn motion(
    reference: Option<&Bound<'_, PyAny>>,
    inputs: Option<&Bound<'_, PyAny>>,
    joints: usize,
) -> Result<Motion, String> {
    if let Some(given) = reference {
        let rows = given.extract::<PyReadonlyArray2<'_, f64>>().ok().and_then(|rows| numbers::<3>(&rows));
        let poses: Option<[PlanarPose; HORIZON]> = rows.and_then(|rows| {
            let poses = rows.iter().map(|&[x, y, yaw]| PlanarPose { position: Point::new(x, y), yaw });
            poses.collect::<Vec<_>>().try_into().ok()
        });
        return poses.map(Motion::Reference).ok_or_else(|| {
            format!("reference = {}; it must be a float64 array of shape ({HORIZON}, 3) of finite numbers: x, y (m) and yaw (rad) of the grasp in the world, one row for each of the next {HORIZON} control periods", repr(given))
        });
    }
    if let Some(given) = inputs {
        let found = given.extract::<PyReadonlyArray1<'_, f64>>().ok().map(|array| array.as_array().to_vec());
        let found = found.filter(|u| u.len() == joints + 2 && u.iter().all(|number| number.is_finite()));
        return match found {
            Some(found) => {
                let mut u = InputVector::zeros();
                found.iter().enumerate().for_each(|(i, number)| u[i] = *number);
                Ok(Motion::Inputs(u))
            }
            None => Err(format!(
                "inputs = {}; it must be a float64 array of shape ({},) of finite numbers: the left and the right rim speed (m/s), then {joints} joint rates (rad/s, prismatic m/s)",
                repr(given),
                joints + 2
            )),
        };
    }
    Ok(Motion::Controlled)
}

/// The decision that a policy returned: None to follow, an option to lead on it, or a cocarry.Decision.
fn decision(basis: &Basis, given: &Bound<'_, PyAny>) -> PyResult<Decision> {
    let wrong = |what: String| DecisionError::new_err(format!("the policy returned {what}"));
    if given.is_none() {
        return Ok(Decision::follow());
    }
    let (lead, reference, inputs) = match given.hasattr("lead")? {
        false => (given.clone(), None, None),
        true => {
            let field =
                |name: &str| Ok::<_, PyErr>(Some(given.getattr(name)?).filter(|value| !value.is_none()));
            (given.getattr("lead")?, field("reference")?, field("inputs")?)
        }
    };
    let lead = match lead.extract::<String>().ok().as_deref() {
        _ if lead.is_none() => Lead::Human,
        Some("human") if basis.option(&lead).is_none() => Lead::Human,
        Some("human-keeping-option") if basis.option(&lead).is_none() => Lead::HumanKeepingOption,
        _ => Lead::Robot(basis.option(&lead).ok_or_else(|| {
            wrong(format!(
                "{}; it must be None (the human leads), {}, or a cocarry.Decision",
                repr(given),
                basis.options()
            ))
        })?),
    };
    if (reference.is_some() || inputs.is_some()) && !basis.has_robot {
        return Err(wrong(
            "a motion, but plant=\"point\" has no robot; use plant=\"kinematic\" or plant=\"rapier\""
                .to_owned(),
        ));
    }
    let motion = motion(reference.as_ref(), inputs.as_ref(), basis.joints).map_err(wrong)?;
    debug_assert_eq!(basis.input_limits, basis.joints + 2);
    Ok(Decision { lead, motion })
}

/// A Python object that decides, with its saved state.
#[derive(Debug)]
struct Partner {
    object: Py<PyAny>,
    basis: Basis,
    fault: Fault,
}

impl Clone for Partner {
    fn clone(&self) -> Self {
        let object = Python::attach(|py| {
            copy(self.object.bind(py)).unwrap_or_else(|error| {
                self.fault.put(error);
                self.object.clone_ref(py)
            })
        });
        Self { object, basis: self.basis.clone(), fault: self.fault.clone() }
    }
}

/// A deep copy; functions are their own.
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

impl Partner {
    /// Calls the object: its method `decide`, or itself.
    fn ask<'py>(&self, py: Python<'py>, view: Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let object = self.object.bind(py);
        match object.getattr_opt("decide")? {
            Some(decide) => decide.call1((view,)),
            None => object.call1((view,)),
        }
    }

    fn flag(&self, name: &str) -> bool {
        Python::attach(|py| match self.object.bind(py).getattr_opt(name) {
            Ok(value) => value.is_some_and(|value| value.is_truthy().unwrap_or(false)),
            Err(_) => false,
        })
    }

    fn save(&self) -> Vec<u8> {
        Python::attach(|py| {
            let saved = self.object.bind(py).getattr_opt("save").and_then(|save| match save {
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
        Python::attach(|py| match self.object.bind(py).getattr_opt("restore")? {
            Some(restore) => restore.call1((pyo3::types::PyBytes::new(py, bytes),)).map(drop),
            None => Ok(()),
        })
    }

    fn saved(&self) -> Saved {
        let bytes = self.save();
        if bytes.is_empty() { Saved::default() } else { Saved::of(&bytes) }
    }

    fn read(&self, saved: &Saved, part: &'static str) -> Result<(), NotRestored> {
        if saved.is_empty(part).is_ok() {
            return Ok(());
        }
        let bytes: Vec<u8> = saved.read(part)?;
        self.restore(&bytes).map_err(|error| {
            self.fault.put(error);
            NotRestored { part }
        })
    }
}

/// An own policy.
#[derive(Clone, Debug)]
struct OwnPolicy(Partner);

impl RobotPolicy for OwnPolicy {
    fn initial_mode(&self) -> Mode {
        if self.0.flag("human_leads_first") { Mode::HumanLed } else { Mode::RobotLed }
    }

    fn predicts(&self) -> bool {
        self.0.flag("predicts")
    }

    fn decide(&mut self, view: &RobotView<'_>) -> Decision {
        let Partner { basis, fault, .. } = &self.0;
        if fault.is_there() {
            return Decision::follow();
        }
        let decided = Python::attach(|py| {
            let wrenches = view.seen.map(|seen| [&seen.grip.mean, &seen.hand_grip.mean].map(wrench));
            let seen = PyRobotView {
                seen: Seen {
                    step: view.step,
                    time: view.time,
                    position: view.position,
                    names: Arc::clone(&basis.names),
                    evaluated: view.evaluated.to_vec(),
                    executed: view.executed,
                    mode: view.mode,
                },
                human: *view.human,
                configuration: view.configuration.map(|configuration| (*configuration, basis.joints)),
                grasp: view.grasp,
                object: view.seen.map(|seen| seen.object),
                hand: view.seen.map(|seen| seen.hand),
                wrenches,
            };
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

    fn restore(&mut self, saved: &Saved) -> Result<(), NotRestored> {
        self.0.read(saved, "policy")
    }
}

fn wrench(wrench: &cocarry::simulation::Wrench) -> [f64; 6] {
    let (f, t) = (wrench.force, wrench.torque);
    [f.x, f.y, f.z, t.x, t.y, t.z]
}

/// An own human. One who returns only an option has the stubbornness of eq. (5).
#[derive(Clone, Debug)]
struct OwnHuman {
    partner: Partner,
    stubbornness: Stubbornness,
}

impl OwnHuman {
    fn read(&self, given: &Bound<'_, PyAny>) -> PyResult<HumanDecision> {
        let basis = &self.partner.basis;
        let wrong = |what: String| DecisionError::new_err(format!("the human returned {what}"));
        let Some(option) = given.getattr_opt("option")? else {
            let option = basis.option(given).ok_or_else(|| {
                wrong(format!("{}; it must be {}, or a cocarry.HumanDecision", repr(given), basis.options()))
            })?;
            return Ok(HumanDecision::new(option, &self.stubbornness, None));
        };
        let option = basis
            .option(&option)
            .ok_or_else(|| wrong(format!("option = {}; it must be {}", repr(&option), basis.options())))?;
        let mut decided = HumanDecision::new(option, &self.stubbornness, None);
        let field = |name: &str| Ok::<_, PyErr>(Some(given.getattr(name)?).filter(|value| !value.is_none()));
        let finite = |name: &'static str, value: &Bound<'_, PyAny>| {
            let number = value.extract::<f64>().ok().filter(|number| number.is_finite() && *number >= 0.0);
            number
                .ok_or_else(|| wrong(format!("{name} = {}; it must be a number of at least 0", repr(value))))
        };
        if let Some(value) = field("stubbornness")? {
            decided.stubbornness = finite("stubbornness", &value)?;
            decided.stance = if decided.stubbornness > 1.0 { Stance::TakeOver } else { Stance::Follow };
        }
        if let Some(value) = field("discomfort")? {
            decided.discomfort = finite("discomfort", &value)?;
        }
        if let Some(value) = field("stance")? {
            let found = value.extract::<String>().ok().and_then(|name| stance(&name));
            decided.stance = found.ok_or_else(|| {
                wrong(format!(
                    "stance = {}; it must be one of: {}",
                    repr(&value),
                    STANCES.map(|(name, _)| name).join(", ")
                ))
            })?;
        }
        if let Some(value) = field("perception")? {
            let found = value.extract::<(f64, f64)>().ok();
            let range = scenario::PERCEPTION;
            let found = found.filter(|(alpha, gamma)| range.contains(*alpha) && range.contains(*gamma));
            let (alpha, gamma) = found.ok_or_else(|| {
                wrong(format!("perception = {}; it must be (alpha, gamma), each {range}", repr(&value)))
            })?;
            decided.perception = Some(Perception { alpha, gamma });
        }
        if let Some(value) = field("hand")? {
            let found = value.extract::<(f64, f64)>().ok().filter(|(x, y)| x.is_finite() && y.is_finite());
            let (x, y) = found.ok_or_else(|| {
                wrong(format!("hand = {}; it must be (x, y), finite, m, in the world", repr(&value)))
            })?;
            decided.hand = Some(Point::new(x, y));
        }
        Ok(decided)
    }
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
                seen: Seen {
                    step: view.step,
                    time: view.time,
                    position: view.position,
                    names: Arc::clone(&basis.names),
                    evaluated: view.evaluated.to_vec(),
                    executed: view.executed,
                    mode: view.mode,
                },
                prospects: view.prospects.to_vec(),
                risk_weight: view.risk_weight,
                seed: basis.seed,
                hand: view.hand.copied(),
                wrench: view.wrench.map(wrench),
            };
            let answer = self.partner.ask(py, Bound::new(py, seen)?.into_any())?;
            self.read(&answer)
        });
        decided.unwrap_or_else(|error| {
            fault.put(error);
            nothing
        })
    }

    fn save(&self) -> Saved {
        Saved::of(&(&self.stubbornness, self.partner.save()))
    }

    fn restore(&mut self, saved: &Saved) -> Result<(), NotRestored> {
        let (stubbornness, bytes): (Stubbornness, Vec<u8>) = saved.read("human")?;
        self.stubbornness = stubbornness;
        if bytes.is_empty() {
            return Ok(());
        }
        self.partner.restore(&bytes).map_err(|error| {
            self.partner.fault.put(error);
            NotRestored { part: "human" }
        })
    }
}

/// The own partners of an episode: None for the scenario's.
#[derive(Debug, Default)]
pub struct Own {
    pub policy: Option<Py<PyAny>>,
    pub human: Option<Py<PyAny>>,
}

impl Own {
    /// Takes the arguments: an object with a method `decide`, a callable, or a class of one of them, of which
    /// an instance is made.
    pub fn of(policy: Option<&Bound<'_, PyAny>>, human: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let one = |name: &str, given: Option<&Bound<'_, PyAny>>| {
            let Some(given) = given else { return Ok(None) };
            let object = if given.is_instance_of::<PyType>() { given.call0()? } else { given.clone() };
            if !object.is_callable() && object.getattr_opt("decide")?.is_none() {
                return Err(DecisionError::new_err(format!(
                    "{name} = {}; it must be a callable, an object with a method decide(view), or a class of such objects",
                    repr(given)
                )));
            }
            Ok(Some(object.unbind()))
        };
        Ok(Self { policy: one("policy", policy)?, human: one("human", human)? })
    }

    pub fn is_empty(&self) -> bool {
        self.policy.is_none() && self.human.is_none()
    }

    pub fn clone_ref(&self, py: Python<'_>) -> Self {
        let one = |object: &Option<Py<PyAny>>| object.as_ref().map(|object| object.clone_ref(py));
        Self { policy: one(&self.policy), human: one(&self.human) }
    }

    /// Deep copies of them.
    pub fn copied(&self, py: Python<'_>) -> PyResult<Self> {
        let one =
            |object: &Option<Py<PyAny>>| object.as_ref().map(|object| copy(object.bind(py))).transpose();
        Ok(Self { policy: one(&self.policy)?, human: one(&self.human)? })
    }

    /// A log for a recording of an episode of theirs.
    pub fn log(&self, py: Python<'_>, fault: &Fault) -> Decisions {
        let flag = |object: &Py<PyAny>, name: &str| {
            let value = object.bind(py).getattr_opt(name).ok().flatten();
            value.is_some_and(|value| value.is_truthy().unwrap_or(false))
        };
        let policy = self.policy.as_ref().map(|object| PolicyLog {
            initial_mode: if flag(object, "human_leads_first") { Mode::HumanLed } else { Mode::RobotLed },
            predicts: flag(object, "predicts"),
            trial: fault.1.load(Ordering::Relaxed).then(Decision::follow),
            steps: Vec::new(),
        });
        Decisions::new(self.human.is_some(), policy)
    }

    /// As partners of an episode of a prepared scenario.
    pub fn partners(self, stage: &PreparedScenario, fault: &Fault) -> scenario::Partners<'static> {
        let basis = Basis::of(stage);
        let partner = |object| Partner { object, basis: basis.clone(), fault: fault.clone() };
        let stubbornness = Stubbornness::new(stage.scenario().settings.coordination);
        scenario::Partners {
            human: self.human.map(|object| {
                Box::new(OwnHuman { partner: partner(object), stubbornness }) as Box<dyn Human>
            }),
            policy: self.policy.map(|object| Box::new(OwnPolicy(partner(object))) as Box<dyn RobotPolicy>),
        }
    }
}

/// The vocabulary of a table of quantities: key, unit and description.
pub fn vocabulary<'py, G>(
    py: Python<'py>,
    quantities: &[cocarry::quantities::Quantity<G>],
) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for quantity in quantities {
        let unit = if let Kind::Number(unit) = quantity.kind { unit } else { "" };
        dict.set_item(quantity.key, (unit, quantity.description))?;
    }
    Ok(dict)
}
