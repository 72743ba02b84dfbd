//! Robots.

use crate::error::{RobotError, raise};
use crate::value::repr;
use cocarry::robot;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use std::path::PathBuf;

/// A mobile manipulator.
#[pyclass(frozen, module = "cocarry", name = "Robot")]
pub struct Robot {
    pub robot: robot::Robot,
}

#[pymethods]
impl Robot {
    #[new]
    #[pyo3(signature = (file = None, *, xacro = false))]
    fn new(py: Python<'_>, file: Option<PathBuf>, xacro: bool) -> PyResult<Self> {
        let expand: Option<&robot::Expand> = xacro.then_some(&cocarry_program::xacro::expand);
        // the program `xacro` may take a while
        let robot = py.detach(|| match file {
            None => robot::Robot::built_in(),
            Some(file) => {
                robot::Robot::check_expanded(&file, expand).map_err(|mut faults| faults.swap_remove(0))
            }
        });
        Ok(Self { robot: robot.map_err(|e| raise::<RobotError>(&e))? })
    }

    #[getter]
    fn name(&self) -> &str {
        &self.robot.name
    }

    #[getter]
    fn joints(&self) -> Vec<String> {
        self.robot.joints.iter().map(|joint| joint.name.clone()).collect()
    }

    /// How the base moves: "differential", "skid-steer" or "omnidirectional".
    #[getter]
    fn drive(&self) -> &str {
        self.robot.drive.kind.name()
    }

    #[getter]
    fn postures(&self) -> Vec<String> {
        self.robot.postures.iter().map(|posture| posture.name.clone()).collect()
    }

    /// The limits of u: the base's inputs, then joint rates (rad/s or m/s).
    #[getter]
    fn input_limits<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_vec(py, input_limits(&self.robot))
    }

    /// The limits of the joints, (n, 2), rad or m.
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

/// The robot of an argument: a file or a robot; the built-in one without it.
pub fn robot_of(given: Option<&Bound<'_, PyAny>>) -> PyResult<robot::Robot> {
    let Some(given) = given else { return robot::Robot::built_in().map_err(|e| raise::<RobotError>(&e)) };
    if let Ok(robot) = given.cast::<Robot>() {
        return Ok(robot.get().robot.clone());
    }
    match given.extract::<PathBuf>() {
        Ok(path) => robot::Robot::load(&path).map_err(|e| raise::<RobotError>(&e)),
        Err(_) => Err(RobotError::new_err(format!(
            "robot = {}; it must be a robot file or a cocarry.Robot",
            repr(given)
        ))),
    }
}
