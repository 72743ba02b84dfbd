//! Scenarios.

use crate::arguments;
use crate::error::{ScenarioError, WorldError, raise};
use crate::robot::{Robot, robot_of};
use crate::value::repr;
use crate::world::{World, load_world, world_of};
use cocarry::episode;
use cocarry::human::PreferenceChange;
use cocarry::preference::{Belief, Marginal, Perception, Predictor, RISK_WEIGHT, WeightedSample};
use cocarry::scenario::{
    self, GivenPerception, PERCEPTION, PERIOD, Plant, PlantKind, PreferenceChanges, PreparedScenario,
    RobotSetup, SETTINGS, Setting, SettingKind, Value, drawn_changes,
};
use cocarry::suggestion;
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyString};
use std::path::Path;
use std::sync::{Arc, OnceLock};

/// The complete definition of an episode: the same scenario gives the same episode, bit for bit.
/// Immutable.
///
/// A scenario with the defaults of ``cocarry run``.
///
/// world: a world file, a built-in world (default environment-4) or a World.
/// plant: what the controller moves: the planning level alone, exact kinematics, or bodies with dynamics.
/// seed: of the human, of the human's preference changes, and of the gait.
/// alpha, gamma: the human's perception of distance and risk; drawn from the belief if not given.
/// changes: (step, alpha, gamma): preference changes. preference_changes: their number, drawn from the
///     seed.
/// belief_alpha, belief_gamma: the robot's belief: uniform(LOWER,UPPER) or normal(MEAN,STD,LOWER,UPPER).
/// belief_samples: the belief as samples, (n, 2) alpha and gamma, or (n, 3) with weights.
/// robot: a robot file, a built-in robot or a Robot. settings: see cocarry.settings().
///
/// Raises ScenarioError with the key, the value and the values allowed; WorldError; RobotError.
#[pyclass(frozen, module = "cocarry", name = "Scenario")]
pub struct Scenario {
    scenario: scenario::Scenario,
    prepared: OnceLock<Arc<PreparedScenario>>,
}

/// The keywords of `Scenario` that are not settings.
const KEYWORDS: [&str; 10] = [
    "world",
    "plant",
    "seed",
    "alpha",
    "gamma",
    "changes",
    "preference_changes",
    "belief_alpha",
    "belief_gamma",
    "robot",
];

/// A preference change in Python: step, alpha, gamma.
type Change = (u64, f64, f64);

fn refused(key: &str, value: impl std::fmt::Display, expected: impl std::fmt::Display) -> PyErr {
    ScenarioError::new_err(format!("scenario: {key} = {value}; it must be {expected}"))
}

/// How many preference changes are drawn.
pub fn counted_changes(given: &Bound<'_, PyAny>) -> PyResult<PreferenceChanges> {
    let count = given.str()?.to_string().parse();
    count.map_err(|_| refused("preference_changes", repr(given), PreferenceChanges::expected()))
}

/// The value of a setting in a Python object.
fn value_of(setting: &Setting, given: &Bound<'_, PyAny>) -> PyResult<Value> {
    let is_flag = given.is_instance_of::<PyBool>();
    let value = match setting.kind {
        SettingKind::Number(..) if !is_flag => given.extract().ok().map(Value::Number),
        SettingKind::Count(..) if !is_flag => given.extract().ok().map(Value::Count),
        SettingKind::Flag(_) => given.extract().ok().map(Value::Flag),
        SettingKind::Word(..) | SettingKind::Text(..) => given.extract().ok().map(Value::Text),
        _ => None,
    };
    value.filter(|value| setting.accepts(value)).ok_or_else(|| {
        let expected = setting.expected();
        let hint = given.extract::<String>().map_or(String::new(), |text| expected.hint(&text));
        refused(setting.key, repr(given), format_args!("{expected}{hint}"))
    })
}

/// Sets the settings given by their keys.
fn apply(scenario: &mut scenario::Scenario, settings: Option<&Bound<'_, PyDict>>) -> PyResult<()> {
    for (key, given) in settings.into_iter().flatten() {
        let key: String = key.extract()?;
        if key == PERIOD[0] {
            return Err(refused(&key, repr(&given), PERIOD[2]));
        }
        let Some(setting) = SETTINGS.iter().find(|setting| setting.key == key) else {
            let keys = KEYWORDS.into_iter().chain(SETTINGS.iter().map(|setting| setting.key));
            let hint = suggestion::hint(&key, keys);
            let known = SETTINGS.iter().map(|setting| setting.key).collect::<Vec<_>>().join(", ");
            return Err(ScenarioError::new_err(format!(
                "scenario: unknown setting `{key}`; expected one of: {known}{hint}"
            )));
        };
        let plant = scenario.plant.kind();
        if !setting.applies.is_on(plant, true) {
            let has_it = PlantKind::ALL.into_iter().filter(|plant| setting.applies.is_on(*plant, true));
            let has_it = has_it.map(|plant| format!("{:?}", plant.name())).collect::<Vec<_>>().join(" or ");
            return Err(ScenarioError::new_err(format!(
                "scenario: {key} needs {}, which plant={:?} does not have; use plant={has_it}",
                setting.applies.what(),
                plant.name()
            )));
        }
        let value = value_of(setting, &given)?;
        setting.set(scenario, &value);
    }
    Ok(())
}

fn marginal(key: &str, text: &str) -> PyResult<Marginal> {
    text.parse().map_err(|error| ScenarioError::new_err(format!("scenario: {key} = {text:?}: {error}")))
}

fn perception(key: &str, given: Option<f64>) -> PyResult<Option<f64>> {
    match given.filter(|value| !PERCEPTION.contains(*value)) {
        Some(wrong) => Err(refused(key, wrong, PERCEPTION)),
        None => Ok(given),
    }
}

/// The robot's belief of the arguments.
pub fn belief_of(alpha: &str, gamma: &str, samples: Option<&Bound<'_, PyAny>>) -> PyResult<Belief> {
    let Some(samples) = samples else {
        let (alpha, gamma) = (marginal("belief_alpha", alpha)?, marginal("belief_gamma", gamma)?);
        return Ok(Belief::Independent { alpha, gamma });
    };
    let expected = "an array of shape (n, 2) or (n, 3): alpha, gamma and the weight";
    // lists and other numbers too
    let rows = samples.py().import("numpy")?.call_method1("asarray", (samples, "float64"));
    let Ok(rows) = rows.and_then(|rows| rows.extract::<PyReadonlyArray2<'_, f64>>()) else {
        return Err(refused("belief_samples", repr(samples), expected));
    };
    let samples = rows.as_array();
    let columns = samples.ncols();
    if columns != 2 && columns != 3 {
        let shape = format!("an array of shape {:?}", samples.shape());
        return Err(refused("belief_samples", shape, expected));
    }
    let sample = |row: numpy::ndarray::ArrayView1<'_, f64>| WeightedSample {
        perception: Perception { alpha: row[0], gamma: row[1] },
        weight: if columns == 3 { row[2] } else { 1.0 },
    };
    Belief::samples(samples.rows().into_iter().map(sample).collect()).map_err(|e| raise::<ScenarioError>(&e))
}

impl Scenario {
    pub fn of(scenario: scenario::Scenario) -> Self {
        Self { scenario, prepared: OnceLock::new() }
    }

    pub fn inner(&self) -> &scenario::Scenario {
        &self.scenario
    }

    /// The prepared scenario, made once.
    pub fn prepared(&self, py: Python<'_>) -> PyResult<Arc<PreparedScenario>> {
        if let Some(prepared) = self.prepared.get() {
            return Ok(Arc::clone(prepared));
        }
        let scenario = self.scenario.clone();
        let prepared = py.detach(|| scenario.prepare()).map_err(|e| raise::<ScenarioError>(&e))?;
        Ok(Arc::clone(self.prepared.get_or_init(|| Arc::new(prepared))))
    }
}

#[pymethods]
impl Scenario {
    #[new]
    #[pyo3(signature = (world = None, *, plant = "rapier", seed = 0, alpha = None, gamma = None, changes = None,
        preference_changes = None, belief_alpha = "uniform(0.55,0.95)", belief_gamma = "uniform(0.5,1.1)",
        belief_samples = None, robot = None, **settings))]
    #[allow(clippy::too_many_arguments, reason = "keywords")]
    fn new(
        world: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::plant)] plant: &str,
        #[pyo3(from_py_with = arguments::seed_of_scenario)] seed: u64,
        #[pyo3(from_py_with = arguments::alpha_of_scenario)] alpha: Option<f64>,
        #[pyo3(from_py_with = arguments::gamma_of_scenario)] gamma: Option<f64>,
        #[pyo3(from_py_with = arguments::changes)] changes: Option<Vec<Change>>,
        preference_changes: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::belief_alpha)] belief_alpha: &str,
        #[pyo3(from_py_with = arguments::belief_gamma)] belief_gamma: &str,
        belief_samples: Option<&Bound<'_, PyAny>>,
        robot: Option<&Bound<'_, PyAny>>,
        settings: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let world = match world {
            Some(given) => world_of(given)?,
            None => load_world(Path::new("environment-4"))?,
        };
        let names = || PlantKind::ALL.map(|kind| format!("{:?}", kind.name())).join(", ");
        let kind = PlantKind::named(plant).ok_or_else(|| {
            let hint = suggestion::hint(plant, PlantKind::ALL.map(PlantKind::name));
            refused("plant", format!("{plant:?}"), format!("one of: {}{hint}", names()))
        })?;
        let plant = match kind {
            PlantKind::Point if robot.is_some() => {
                return Err(ScenarioError::new_err(
                    "scenario: robot needs a robot, which plant=\"point\" does not have; use plant=\"kinematic\" or plant=\"rapier\"",
                ));
            }
            PlantKind::Point => Plant::Point,
            kind => Plant::new(kind, RobotSetup::new(&robot_of(robot)?)),
        };
        let belief = belief_of(belief_alpha, belief_gamma, belief_samples)?;
        let predictor =
            Predictor::new(belief.clone(), RISK_WEIGHT).map_err(|e| raise::<ScenarioError>(&e))?;
        let chosen = episode::EpisodeSettings { predictor, ..episode::EpisodeSettings::default() };
        let given = GivenPerception { alpha, gamma };
        let mut made = scenario::Scenario::of_seed(seed, world.into(), plant, chosen, &belief, given);
        apply(&mut made, settings)?;
        perception("alpha", alpha)?;
        perception("gamma", gamma)?;
        if changes.is_some() && preference_changes.is_some() {
            return Err(ScenarioError::new_err(
                "scenario: give changes or preference_changes, which draws them, not both",
            ));
        }
        for (step, alpha, gamma) in changes.into_iter().flatten() {
            perception("alpha of a change", Some(alpha))?;
            perception("gamma of a change", Some(gamma))?;
            made.changes.push(PreferenceChange { step, perception: Perception { alpha, gamma } });
        }
        if let Some(count) = preference_changes {
            let count = counted_changes(count)?;
            let settings = &made.settings;
            let options = made.world.options(settings.predictor.risk_weight());
            let options = options.map_err(|e| raise::<WorldError>(&e))?;
            made.changes = drawn_changes(count, &belief, given, seed, &options, settings);
        }
        Ok(Self::of(made))
    }

    /// Reads a scenario's text (TOML).
    #[staticmethod]
    fn parse(#[pyo3(from_py_with = arguments::text_of_scenario)] text: &str) -> PyResult<Self> {
        scenario::Scenario::parse(text).map(Self::of).map_err(|e| raise::<ScenarioError>(&e))
    }

    /// The scenario as text (TOML), exact to the last bit.
    #[getter]
    fn text(&self) -> PyResult<String> {
        self.scenario.text().map_err(|e| raise::<ScenarioError>(&e))
    }

    /// The same scenario with other values. A new seed does not draw another human.
    #[pyo3(signature = (*, seed = None, alpha = None, gamma = None, **settings))]
    fn replace(
        &self,
        #[pyo3(from_py_with = arguments::other_seed_of_scenario)] seed: Option<u64>,
        #[pyo3(from_py_with = arguments::alpha_of_scenario)] alpha: Option<f64>,
        #[pyo3(from_py_with = arguments::gamma_of_scenario)] gamma: Option<f64>,
        settings: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let mut made = self.scenario.clone();
        made.seed = seed.unwrap_or(made.seed);
        let given =
            GivenPerception { alpha: perception("alpha", alpha)?, gamma: perception("gamma", gamma)? };
        made.human = given.or(made.human);
        apply(&mut made, settings)?;
        Ok(Self::of(made))
    }

    /// The world.
    #[getter]
    fn world(&self, py: Python<'_>) -> PyResult<World> {
        Ok(World { world: self.prepared(py)?.world().clone() })
    }

    /// The robot; None on the point plant.
    #[getter]
    fn robot(&self, py: Python<'_>) -> PyResult<Option<Robot>> {
        Ok(self.prepared(py)?.robot().map(|robot| Robot { robot: robot.clone() }))
    }

    /// The plant.
    #[getter]
    fn plant(&self) -> &'static str {
        self.scenario.plant.name()
    }

    /// The seed.
    #[getter]
    fn seed(&self) -> u64 {
        self.scenario.seed
    }

    /// The human's alpha at the start.
    #[getter]
    fn alpha(&self) -> f64 {
        self.scenario.human.alpha
    }

    /// The human's gamma at the start.
    #[getter]
    fn gamma(&self) -> f64 {
        self.scenario.human.gamma
    }

    /// The preference changes: step, alpha, gamma.
    #[getter]
    fn changes(&self) -> Vec<Change> {
        let change = |c: &PreferenceChange| (c.step, c.perception.alpha, c.perception.gamma);
        self.scenario.changes.iter().map(change).collect()
    }

    /// The names of the world's options.
    #[getter]
    fn options(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        Ok(self.prepared(py)?.options().options().iter().map(|option| option.name.clone()).collect())
    }

    /// The settings that the scenario has, by their keys.
    #[getter]
    fn settings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for setting in SETTINGS {
            match setting.get(&self.scenario) {
                None => {}
                Some(Value::Number(value)) => dict.set_item(setting.key, value)?,
                Some(Value::Count(value)) => dict.set_item(setting.key, value)?,
                Some(Value::Flag(value)) => dict.set_item(setting.key, value)?,
                Some(Value::Text(value)) => dict.set_item(setting.key, value)?,
            }
        }
        Ok(dict)
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Self>().is_ok_and(|other| other.get().scenario == self.scenario)
    }

    fn __repr__(&self) -> String {
        let scenario::Scenario { seed, world, human, .. } = &self.scenario;
        let (plant, [alpha, gamma]) = (self.scenario.plant.name(), [human.alpha, human.gamma].map(short));
        format!("<cocarry.Scenario {:?}, {plant}, seed {seed}, alpha {alpha}, gamma {gamma}>", world.file())
    }

    /// A scenario never changes.
    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    #[pyo3(signature = (_memo = None))]
    fn __deepcopy__(slf: Py<Self>, _memo: Option<&Bound<'_, PyAny>>) -> Py<Self> {
        slf
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        Ok((slf.get_type().getattr("parse")?, (slf.get().text()?,)))
    }
}

/// A number with six significant digits, for people.
fn short(number: f64) -> f64 {
    format!("{number:.5e}").parse().unwrap_or(number)
}

/// Every setting of an episode: type, about, allowed values, default and words.
#[pyfunction]
pub fn settings<'py>(py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
    let defaults = scenario::Scenario::defaults();
    let dict = PyDict::new(py);
    for setting in SETTINGS {
        let about = PyDict::new(py);
        let kind = match setting.kind {
            SettingKind::Number(..) => "float",
            SettingKind::Count(..) => "int",
            SettingKind::Flag(_) => "bool",
            SettingKind::Word(..) | SettingKind::Text(..) => "str",
        };
        about.set_item("type", kind)?;
        about.set_item("about", setting.about)?;
        about.set_item("allowed", setting.expected().to_string())?;
        match setting.get(&defaults) {
            None => about.set_item("default", py.None())?,
            Some(Value::Number(value)) => about.set_item("default", value)?,
            Some(Value::Count(value)) => about.set_item("default", value)?,
            Some(Value::Flag(value)) => about.set_item("default", value)?,
            Some(Value::Text(value)) => about.set_item("default", value)?,
        }
        about.set_item(
            "words",
            setting.words().map(|words| words.iter().map(|(word, _)| *word).collect::<Vec<_>>()),
        )?;
        dict.set_item(PyString::new(py, setting.key), about)?;
    }
    Ok(dict)
}
