//! What custom policies and humans see.

use crate::arguments;
use crate::error::Error;
use crate::robot::Robot;
use crate::world::World;
use cocarry::coordination::{Mode, OptionTick};
use cocarry::geometry::{PlanarPose, Point, Pose};
use cocarry::human::Stance;
use cocarry::options::Progress;
use cocarry::preference::{Perception, Prospect, subjective_cost};
use cocarry::quantities::{OPTION, OptionView, QuantityKind, Value};
use cocarry::robot::Configuration;
use cocarry::scenario::PreparedScenario;
use numpy::{PyArray1, PyArray2};
use pyo3::exceptions::{PyAttributeError, PyKeyError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyList;
use std::sync::Arc;

/// How far the chords of a path may be off its arcs, m.
const SAGITTA_M: f64 = 1e-3;

/// The world and the robot of an episode as Python objects, each made once a view is asked for it.
pub(super) struct Shown {
    world: PyOnceLock<Py<World>>,
    robot: PyOnceLock<Py<Robot>>,
}

impl Default for Shown {
    fn default() -> Self {
        Self { world: PyOnceLock::new(), robot: PyOnceLock::new() }
    }
}

impl std::fmt::Debug for Shown {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Shown").finish_non_exhaustive()
    }
}

/// What both a custom policy and a custom human see at the beginning of a planning step.
///
/// Every quantity of ``quantities("option")`` is an attribute and an item: an array of one number for each
/// option (NaN where missing), as ``view.objective_cost_m``; ``view.name`` is a list of names. ``len`` counts
/// the options.
#[pyclass(frozen, subclass, module = "cocarry._cocarry", name = "View")]
pub struct PyView {
    pub(super) prepared: Arc<PreparedScenario>,
    pub(super) shown: Arc<Shown>,
    pub(super) step: u64,
    pub(super) time: f64,
    pub(super) planning_step: f64,
    pub(super) position: Point,
    pub(super) progress: Progress,
    pub(super) names: Arc<[String]>,
    pub(super) evaluated: Vec<OptionTick>,
    pub(super) executed: Option<usize>,
    pub(super) mode: Mode,
    pub(super) hand: Option<Pose>,
    pub(super) hand_wrench: Option<[f64; 6]>,
}

impl PyView {
    /// The values of a quantity of the options, by its key.
    fn column<'py>(&self, py: Python<'py>, key: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        let Some(quantity) = OPTION.iter().find(|quantity| quantity.key == key) else { return Ok(None) };
        let values = self.names.iter().zip(&self.evaluated);
        let values = values.map(|(name, option)| (quantity.get)(&OptionView { name, option }));
        Ok(Some(match quantity.kind {
            QuantityKind::Flag => PyArray1::from_iter(py, values.map(|v| v == Value::Flag(true))).into_any(),
            QuantityKind::Text => {
                PyList::new(py, values.map(|v| v.as_str().unwrap_or_default().to_owned()))?.into_any()
            }
            _ => PyArray1::from_iter(py, values.map(|v| v.as_f64().unwrap_or(f64::NAN))).into_any(),
        }))
    }
}

#[pymethods]
impl PyView {
    /// k, from 0.
    #[getter]
    fn step(&self) -> u64 {
        self.step
    }
    /// Simulated time, s.
    #[getter]
    fn time_s(&self) -> f64 {
        self.time
    }
    /// Length of a planning step, s.
    #[getter]
    fn planning_step_s(&self) -> f64 {
        self.planning_step
    }
    /// The world of the episode: the same object in every view of an episode.
    #[getter]
    fn world(&self, py: Python<'_>) -> PyResult<Py<World>> {
        let make = || Py::new(py, World { world: self.prepared.world().clone() });
        self.shown.world.get_or_try_init(py, make).map(|world| world.clone_ref(py))
    }
    /// The remaining path of an option, (n, 2), m, in the world, from the team to the target; None where no path
    /// leads on. option: an index.
    fn path<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = arguments::option)] option: usize,
    ) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let options = self.prepared.options();
        let count = options.options().len();
        if option >= count {
            return Err(Error::new_err(format!("option = {option}; it must be from 0 to {}", count - 1)));
        }
        let points = options.path(&self.progress, option).map(|path| path.polyline(SAGITTA_M));
        let rows = points.map(|points| points.iter().map(|p| vec![p.x, p.y]).collect::<Vec<_>>());
        Ok(rows.map(|rows| PyArray2::from_vec2(py, &rows)).transpose()?)
    }
    /// Position of the team, (2,), m.
    #[getter]
    fn position<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.position.coords.as_slice())
    }
    /// The executed option; None before the first step.
    #[getter]
    fn executed(&self) -> Option<usize> {
        self.executed
    }
    /// Who led in the last planning step: robot-led or human-led.
    #[getter]
    fn mode(&self) -> &'static str {
        self.mode.name()
    }
    /// world_from_hand, (4, 4); the physical plant only.
    #[getter]
    fn hand<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        self.hand.as_ref().map(|pose| matrix(py, pose)).transpose()
    }
    /// Mean force (N) and torque (Nm) of the human on the object in the last planning step, (6,), world axes; the
    /// physical plant only.
    #[getter]
    fn hand_wrench<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.hand_wrench.as_ref().map(|wrench| PyArray1::from_slice(py, wrench))
    }
    fn __getattr__<'py>(&self, py: Python<'py>, key: &str) -> PyResult<Bound<'py, PyAny>> {
        self.column(py, key)?.ok_or_else(|| PyAttributeError::new_err(unknown(key)))
    }
    fn __getitem__<'py>(&self, py: Python<'py>, key: &str) -> PyResult<Bound<'py, PyAny>> {
        self.column(py, key)?.ok_or_else(|| PyKeyError::new_err(unknown(key)))
    }
    fn __len__(&self) -> usize {
        self.evaluated.len()
    }
}

fn unknown(key: &str) -> String {
    let known = OPTION.iter().map(|quantity| quantity.key).collect::<Vec<_>>().join(", ");
    format!("unknown `{key}`; the options have {known}")
}

/// A pose as a homogeneous matrix, (4, 4).
pub fn matrix<'py>(py: Python<'py>, pose: &Pose) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let matrix = pose.to_homogeneous();
    let rows: Vec<Vec<f64>> =
        (0..4).map(|row| (0..4).map(|column| matrix[(row, column)]).collect()).collect();
    Ok(PyArray2::from_vec2(py, &rows)?)
}

/// What a custom policy sees at the beginning of a planning step: that of View, and the robot.
#[pyclass(frozen, extends = PyView, module = "cocarry", name = "RobotView")]
pub struct PyRobotView {
    pub(super) stance: Stance,
    pub(super) stubbornness: f64,
    pub(super) discomfort: f64,
    pub(super) configuration: Option<(Configuration, usize)>,
    pub(super) grasp: Option<Pose>,
    pub(super) object: Option<Pose>,
    pub(super) grip_wrench: Option<[f64; 6]>,
}

#[pymethods]
impl PyRobotView {
    /// The robot of the episode: the same object in every view of an episode; None on the point plant.
    #[getter]
    fn robot(slf: &Bound<'_, Self>) -> PyResult<Option<Py<Robot>>> {
        let py = slf.py();
        let PyView { prepared, shown, .. } = slf.as_super().get();
        let Some(robot) = prepared.robot() else { return Ok(None) };
        let made = shown.robot.get_or_try_init(py, || Py::new(py, Robot { robot: robot.clone() }))?;
        Ok(Some(made.clone_ref(py)))
    }
    /// phi(k), eq. (5).
    #[getter]
    fn stubbornness(&self) -> f64 {
        self.stubbornness
    }
    /// g(k), eq. (5).
    #[getter]
    fn discomfort(&self) -> f64 {
        self.discomfort
    }
    /// The human's response to the robot's lead: follow, resist or take-over.
    #[getter]
    fn stance(&self) -> &'static str {
        stance_name(self.stance)
    }
    /// Base x, y (m) and yaw (rad), then the joints (rad, prismatic m), (3 + joints,); None without a
    /// robot.
    #[getter]
    fn configuration<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        let (configuration, joints) = self.configuration.as_ref()?;
        Some(PyArray1::from_vec(py, configuration_vector(configuration, *joints)))
    }
    /// world_from_grasp, (4, 4); None without a robot.
    #[getter]
    fn grasp<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        self.grasp.as_ref().map(|pose| matrix(py, pose)).transpose()
    }
    /// world_from_object, (4, 4), x from the robot's end to the human's; the physical plant only.
    #[getter]
    fn object<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        self.object.as_ref().map(|pose| matrix(py, pose)).transpose()
    }
    /// Mean force (N) and torque (Nm) of the robot on the object in the last planning step, (6,), world axes; the
    /// physical plant only.
    #[getter]
    fn grip_wrench<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.grip_wrench.as_ref().map(|wrench| PyArray1::from_slice(py, wrench))
    }
}

/// What a custom human sees at the beginning of a control period, for the hand.
#[pyclass(frozen, module = "cocarry", name = "HandView")]
pub struct PyHandView {
    pub(super) time: f64,
    pub(super) period: [u32; 2],
    pub(super) control_period: f64,
    pub(super) hand: [Point; 2],
    pub(super) heading: f64,
    pub(super) hand_wrench: Option<[f64; 6]>,
}

#[pymethods]
impl PyHandView {
    /// Simulated time, s.
    #[getter]
    fn time_s(&self) -> f64 {
        self.time
    }
    /// The control period within the planning step, from 0.
    #[getter]
    fn period(&self) -> u32 {
        self.period[0]
    }
    /// The number of control periods in a planning step.
    #[getter]
    fn periods(&self) -> u32 {
        self.period[1]
    }
    /// Length of a control period, s.
    #[getter]
    fn control_period_s(&self) -> f64 {
        self.control_period
    }
    /// Position of the hand at the beginning of the planning step (x, y), without sway, m.
    #[getter]
    fn begun_at<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.hand[0].coords.as_slice())
    }
    /// Position of the hand (x, y), without sway, m.
    #[getter]
    fn hand<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.hand[1].coords.as_slice())
    }
    /// Direction in which the hand faces, without sway: its yaw in the world, rad.
    #[getter]
    fn heading_rad(&self) -> f64 {
        self.heading
    }
    /// Mean force (N) and torque (Nm) of the human on the object in this planning step so far, (6,), world axes.
    #[getter]
    fn hand_wrench<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.hand_wrench.as_ref().map(|wrench| PyArray1::from_slice(py, wrench))
    }
}

/// What a custom human sees at the beginning of a planning step: that of View, and what only the human knows.
#[pyclass(frozen, extends = PyView, module = "cocarry", name = "HumanView")]
pub struct PyHumanView {
    pub(super) prospects: Vec<Prospect>,
    pub(super) risk_weight: f64,
    pub(super) seed: u64,
}

#[pymethods]
impl PyHumanView {
    /// c_r, m.
    #[getter]
    fn risk_weight_m(&self) -> f64 {
        self.risk_weight
    }
    /// The episode's seed.
    #[getter]
    fn seed(&self) -> u64 {
        self.seed
    }
    /// J^ of every option with this alpha and gamma, eq. (2), cost units.
    fn subjective_cost<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = arguments::alpha)] alpha: f64,
        #[pyo3(from_py_with = arguments::gamma)] gamma: f64,
    ) -> Bound<'py, PyArray1<f64>> {
        let perception = Perception { alpha, gamma };
        PyArray1::from_iter(
            py,
            self.prospects.iter().map(|p| subjective_cost(*p, self.risk_weight, perception)),
        )
    }
    /// The Gumbel disturbances that the episode's seed draws for the built-in Boltzmann human, one per
    /// option.
    fn gumbel<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_vec(py, cocarry::human::disturbances(self.seed, self.prospects.len()))
    }
}

pub fn configuration_vector(configuration: &Configuration, joints: usize) -> Vec<f64> {
    let PlanarPose { position, yaw } = configuration.base;
    [position.x, position.y, yaw].into_iter().chain((0..joints).map(|i| configuration.joints[i])).collect()
}

pub(super) const STANCES: [(&str, Stance); 3] =
    [("follow", Stance::Follow), ("resist", Stance::Resist), ("take-over", Stance::TakeOver)];

pub(super) fn stance_name(stance: Stance) -> &'static str {
    STANCES.iter().find(|(_, other)| *other == stance).map_or("", |(name, _)| name)
}

/// The stance of that name.
pub fn stance(name: &str) -> Option<Stance> {
    STANCES.iter().find(|(other, _)| *other == name).map(|(_, stance)| *stance)
}
