//! Robots.

use crate::arguments;
use crate::error::{RobotError, raise};
use crate::partners::matrix;
use crate::value::repr;
use cocarry::geometry::{PlanarPose, Point};
use cocarry::robot::{self, Configuration, JointVector};
use cocarry::suggestion;
use numpy::{PyArray1, PyArray2, PyReadonlyArray1};
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

    /// world_from_grasp at a configuration, (4, 4).
    ///
    /// configuration: as ``RobotView.configuration``, (3 + joints,): base x, y (m) and yaw (rad), then the joints (rad,
    ///     prismatic m).
    fn grasp<'py>(
        &self,
        py: Python<'py>,
        configuration: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix(py, &self.robot.grasp_pose(&self.configuration(configuration)?))
    }

    /// The Jacobian of the grasp at a configuration, (6, base + joints): the velocity of the grasp is ``jacobian @ u``,
    /// linear (m/s), then angular (rad/s), in world axes, with the inputs u in the order and units of
    /// ``input_limits``.
    ///
    /// configuration: as that of ``grasp``.
    fn jacobian<'py>(
        &self,
        py: Python<'py>,
        configuration: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let there = self.robot.kinematics(&self.configuration(configuration)?);
        let inputs = self.robot.drive.inputs() + self.robot.joints.len();
        let row = |row| (0..inputs).map(|column| there.jacobian[(row, column)]).collect();
        Ok(PyArray2::from_vec2(py, &(0..6).map(row).collect::<Vec<Vec<f64>>>())?)
    }

    /// A robot never changes.
    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    #[pyo3(signature = (_memo = None))]
    fn __deepcopy__(slf: Py<Self>, _memo: Option<&Bound<'_, PyAny>>) -> Py<Self> {
        slf
    }

    fn __repr__(&self) -> String {
        format!("<cocarry.Robot {:?}, {} joints>", self.robot.name, self.robot.joints.len())
    }
}

impl Robot {
    /// The configuration of an argument.
    fn configuration(&self, given: &Bound<'_, PyAny>) -> PyResult<Configuration> {
        let count = self.robot.joints.len();
        let numbers = given.extract::<PyReadonlyArray1<'_, f64>>().map(|array| array.as_array().to_vec());
        let numbers = numbers.ok().or_else(|| given.extract::<Vec<f64>>().ok());
        let numbers = numbers.filter(|q| q.len() == 3 + count && q.iter().all(|number| number.is_finite()));
        let Some(q) = numbers else {
            return Err(RobotError::new_err(format!(
                "configuration = {}; it must be {} finite numbers: the base's x, y (m) and yaw (rad), then {count} joints (rad, prismatic m)",
                repr(given),
                3 + count
            )));
        };
        let mut joints = JointVector::zeros();
        joints.iter_mut().zip(&q[3..]).for_each(|(joint, number)| *joint = *number);
        Ok(Configuration { base: PlanarPose { position: Point::new(q[0], q[1]), yaw: q[2] }, joints })
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
