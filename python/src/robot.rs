//! Robots.

use crate::arguments;
use crate::error::{RobotError, raise};
use crate::value::repr;
use cocarry::robot;
use cocarry::suggestion;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use std::path::{Path, PathBuf};

/// A mobile manipulator: a wheeled base with an arm.
///
/// Reads a robot file (TOML) with its URDF, or takes a built-in robot: carrier (the default), omni-carrier, porter or
/// shuttle. A xacro is refused, unless ``xacro`` is set: then the program ``xacro`` expands it, which runs code that is
/// in the file. Raises RobotError.
#[pyclass(frozen, module = "cocarry", name = "Robot")]
pub struct Robot {
    pub robot: robot::Robot,
}

#[pymethods]
impl Robot {
    #[new]
    #[pyo3(signature = (file = None, *, xacro = false))]
    fn new(
        py: Python<'_>,
        file: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::xacro)] xacro: bool,
    ) -> PyResult<Self> {
        let file = file.map(|given| path_of("file", given)).transpose()?;
        // the program `xacro` may take a while
        py.detach(|| load_robot(file.as_deref(), xacro)).map(|robot| Self { robot })
    }

    /// Name.
    #[getter]
    fn name(&self) -> &str {
        &self.robot.name
    }

    /// The names of the joints of its arm, from the base on.
    #[getter]
    fn joints(&self) -> Vec<String> {
        self.robot.joints.iter().map(|joint| joint.name.clone()).collect()
    }

    /// How the base moves: "differential", "skid-steer" or "omnidirectional".
    #[getter]
    fn drive(&self) -> &str {
        self.robot.drive.kind.name()
    }

    /// The names of its starting postures.
    #[getter]
    fn postures(&self) -> Vec<String> {
        self.robot.postures.iter().map(|posture| posture.name.clone()).collect()
    }

    /// The largest |u|, (base + joints,): rim speeds (m/s), or of an omnidirectional base speed ahead and to the left
    /// (m/s) and turning rate (rad/s); then joint rates (rad/s, prismatic m/s).
    #[getter]
    fn input_limits<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_vec(py, input_limits(&self.robot))
    }

    /// The limits of the joints, (joints, 2), rad or m.
    #[getter]
    fn joint_limits<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let limits: Vec<_> = self.robot.joints.iter().map(|joint| vec![joint.lower, joint.upper]).collect();
        Ok(PyArray2::from_vec2(py, &limits)?)
    }

    fn __repr__(&self) -> String {
        format!("<cocarry.Robot {:?}, {} joints>", self.robot.name, self.robot.joints.len())
    }
}

/// The largest inputs of a robot.
pub fn input_limits(robot: &robot::Robot) -> Vec<f64> {
    let inputs = robot.drive.inputs() + robot.joints.len();
    robot.input_limits().as_slice()[..inputs].to_vec()
}

/// The built-in robot of a name, the default one without it, or the robot in a file.
fn load_robot(file: Option<&Path>, xacro: bool) -> PyResult<robot::Robot> {
    let expand: Option<&robot::Expand> = xacro.then_some(&cocarry_program::xacro::expand);
    let found = match file {
        None => robot::Robot::built_in(),
        Some(file) => match cocarry_program::exported_robot(file) {
            Some(built_in) => built_in,
            None if file.extension().is_none() && !file.exists() => return Err(not_built_in(file)),
            None => robot::Robot::check_expanded(file, expand).map_err(|mut faults| faults.swap_remove(0)),
        },
    };
    found.map_err(|error| raise::<RobotError>(&error))
}

/// The error of a name that is neither that of a file nor of a built-in robot.
fn not_built_in(file: &Path) -> PyErr {
    let (name, known) = (file.to_string_lossy(), cocarry_program::robot_names());
    let (listed, hint) = (suggestion::listed(known, known.len()), suggestion::hint(&name, known));
    RobotError::new_err(format!(
        "{name}: neither a file nor a built-in robot; expected a robot file (.toml), a URDF with a robot file next to it, or one of: {listed}{hint}"
    ))
}

fn path_of(key: &str, given: &Bound<'_, PyAny>) -> PyResult<PathBuf> {
    given.extract().map_err(|_| {
        let given = repr(given);
        let known = cocarry_program::robot_names().map(|name| format!("{name:?}")).join(", ");
        RobotError::new_err(format!(
            "{key} = {given}; it must be a robot file, a built-in robot ({known}) or a cocarry.Robot"
        ))
    })
}

/// The robot of an argument: a name, a file or a robot; the built-in one without it.
pub fn robot_of(given: Option<&Bound<'_, PyAny>>) -> PyResult<robot::Robot> {
    let Some(given) = given else { return load_robot(None, false) };
    if let Ok(robot) = given.cast::<Robot>() {
        return Ok(robot.get().robot.clone());
    }
    load_robot(Some(&path_of("robot", given)?), false)
}
