//! What custom policies and humans may return.

use super::views::{STANCES, Shown, stance};
use crate::error::DecisionError;
use crate::value::repr;
use cocarry::control::HORIZON;
use cocarry::coordination::Stubbornness;
use cocarry::geometry::{PlanarPose, Point};
use cocarry::human::{HumanDecision, Stance};
use cocarry::policy::{Decision, Lead, Motion};
use cocarry::preference::Perception;
use cocarry::robot::InputVector;
use cocarry::scenario::{PERCEPTION, PreparedScenario};
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyString};
use std::sync::Arc;

/// What a custom partner may know about its scenario.
#[derive(Clone, Debug)]
pub(super) struct Basis {
    pub(super) names: Arc<[String]>,
    pub(super) prepared: Arc<PreparedScenario>,
    pub(super) shown: Arc<Shown>,
    pub(super) joints: usize,
    /// The number of inputs of the base.
    pub(super) base: usize,
    pub(super) seed: u64,
    pub(super) has_robot: bool,
}

impl Basis {
    pub(super) fn of(prepared: &PreparedScenario) -> Self {
        let names = prepared.options().options().iter().map(|option| option.name.clone()).collect();
        let joints = prepared.robot().map_or(0, |robot| robot.joints.len());
        let seed = prepared.scenario().seed;
        let base = prepared.robot().map_or(2, |robot| robot.drive.inputs());
        let has_robot = prepared.robot().is_some();
        let (prepared, shown) = (Arc::new(prepared.clone()), Arc::default());
        Self { names, prepared, shown, joints, base, seed, has_robot }
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

fn numbers<const N: usize>(array: &PyReadonlyArray2<'_, f64>) -> Option<Vec<[f64; N]>> {
    let array = array.as_array();
    let rows = array.rows().into_iter().map(|row| <[f64; N]>::try_from(row.to_vec()).ok());
    rows.collect::<Option<Vec<_>>>().filter(|rows| rows.iter().flatten().all(|number| number.is_finite()))
}

/// A field of a decision; None if the decision leaves it open.
fn field<'py>(given: &Bound<'py, PyAny>, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
    Ok(Some(given.getattr(name)?).filter(|value| !value.is_none()))
}

/// A motion of the robot: a reference of shape (8, 3), or inputs of shape (base + joints,).
fn motion(
    reference: Option<&Bound<'_, PyAny>>,
    inputs: Option<&Bound<'_, PyAny>>,
    (base, joints): (usize, usize),
) -> Result<Motion, String> {
    if let Some(given) = reference {
        let rows = given.extract::<PyReadonlyArray2<'_, f64>>().ok().and_then(|rows| numbers::<3>(&rows));
        let poses: Option<[PlanarPose; HORIZON]> = rows.and_then(|rows| {
            let poses = rows.iter().map(|&[x, y, yaw]| PlanarPose { position: Point::new(x, y), yaw });
            poses.collect::<Vec<_>>().try_into().ok()
        });
        return poses.map(Motion::Reference).ok_or_else(|| {
            format!("reference = {}; it must be a float64 array of shape ({HORIZON}, 3) of finite numbers: x, y (m) and yaw (rad) of the grasp in the world, one row for each of the next {HORIZON} planning steps", repr(given))
        });
    }
    if let Some(given) = inputs {
        let found = given.extract::<PyReadonlyArray1<'_, f64>>().ok().map(|array| array.as_array().to_vec());
        let found = found.filter(|u| u.len() == base + joints && u.iter().all(|number| number.is_finite()));
        return match found {
            Some(found) => {
                let mut u = InputVector::zeros();
                found.iter().enumerate().for_each(|(i, number)| u[i] = *number);
                Ok(Motion::Inputs(u))
            }
            None => Err(format!(
                "inputs = {}; it must be a float64 array of shape ({},) of finite numbers: {}, then {joints} joint rates (rad/s, prismatic m/s)",
                repr(given),
                base + joints,
                if base == 2 {
                    "the left and the right rim speed (m/s)"
                } else {
                    "the base's velocity ahead and to the left (m/s) and its turning rate (rad/s)"
                },
            )),
        };
    }
    Ok(Motion::Controlled)
}

/// The decision that a policy returned: None to follow, an option to lead on it, or a cocarry.Decision.
pub(super) fn decision(basis: &Basis, given: &Bound<'_, PyAny>) -> PyResult<Decision> {
    let wrong = |what: String| DecisionError::new_err(format!("the policy returned {what}"));
    if given.is_none() {
        return Ok(Decision::follow());
    }
    let (lead, reference, inputs) = match given.hasattr("lead")? {
        false => (given.clone(), None, None),
        true => (given.getattr("lead")?, field(given, "reference")?, field(given, "inputs")?),
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
    let motion = motion(reference.as_ref(), inputs.as_ref(), (basis.base, basis.joints)).map_err(wrong)?;
    Ok(Decision { lead, motion })
}

/// The decision that a human returned: an option, or a cocarry.HumanDecision. One who returns only an option
/// has the stubbornness of eq. (5).
pub(super) fn human_decision(
    basis: &Basis,
    stubbornness: &Stubbornness,
    given: &Bound<'_, PyAny>,
) -> PyResult<HumanDecision> {
    let wrong = |what: String| DecisionError::new_err(format!("the human returned {what}"));
    let Some(option) = given.getattr_opt("option")? else {
        let option = basis.option(given).ok_or_else(|| {
            wrong(format!("{}; it must be {}, or a cocarry.HumanDecision", repr(given), basis.options()))
        })?;
        return Ok(HumanDecision::new(option, stubbornness, None));
    };
    let option = basis
        .option(&option)
        .ok_or_else(|| wrong(format!("option = {}; it must be {}", repr(&option), basis.options())))?;
    let mut decided = HumanDecision::new(option, stubbornness, None);
    let finite = |name: &'static str, value: &Bound<'_, PyAny>| {
        let number = value.extract::<f64>().ok().filter(|number| number.is_finite() && *number >= 0.0);
        number.ok_or_else(|| wrong(format!("{name} = {}; it must be a number of at least 0", repr(value))))
    };
    if let Some(value) = field(given, "stubbornness")? {
        decided.stubbornness = finite("stubbornness", &value)?;
        decided.stance = if decided.stubbornness > 1.0 { Stance::TakeOver } else { Stance::Follow };
    }
    if let Some(value) = field(given, "discomfort")? {
        decided.discomfort = finite("discomfort", &value)?;
    }
    if let Some(value) = field(given, "stance")? {
        let found = value.extract::<String>().ok().and_then(|name| stance(&name));
        decided.stance = found.ok_or_else(|| {
            wrong(format!(
                "stance = {}; it must be one of: {}",
                repr(&value),
                STANCES.map(|(name, _)| name).join(", ")
            ))
        })?;
    }
    if let Some(value) = field(given, "perception")? {
        let found = value.extract::<(f64, f64)>().ok();
        let range = PERCEPTION;
        let found = found.filter(|(alpha, gamma)| range.contains(*alpha) && range.contains(*gamma));
        let (alpha, gamma) = found.ok_or_else(|| {
            wrong(format!("perception = {}; it must be (alpha, gamma), each {range}", repr(&value)))
        })?;
        decided.perception = Some(Perception { alpha, gamma });
    }
    if let Some(value) = field(given, "hand")? {
        decided.hand = hand_target(&value)?;
    }
    Ok(decided)
}

/// A target of the human's hand: None, or (x, y).
pub(super) fn hand_target(given: &Bound<'_, PyAny>) -> PyResult<Option<Point>> {
    if given.is_none() {
        return Ok(None);
    }
    let found = given.extract::<(f64, f64)>().ok().filter(|(x, y)| x.is_finite() && y.is_finite());
    found.map(|(x, y)| Some(Point::new(x, y))).ok_or_else(|| {
        let given = repr(given);
        DecisionError::new_err(format!(
            "the human returned hand = {given}; it must be (x, y), finite, m, in the world"
        ))
    })
}
