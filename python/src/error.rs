//! The exceptions, each with the message of the command line.

pub use cocarry::error::words;
use pyo3::create_exception;
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyType};
use std::error::Error as StdError;

create_exception!(
    cocarry,
    Error,
    PyValueError,
    "An input or a call that cocarry refuses; the base of all others."
);
create_exception!(cocarry, WorldError, Error, "A world that is not valid.");
create_exception!(cocarry, RobotError, Error, "A robot that is not valid.");
create_exception!(cocarry, ScenarioError, Error, "A scenario or a setting that is not valid.");
create_exception!(cocarry, DecisionError, Error, "A decision of a custom policy or human that is not valid.");
create_exception!(cocarry, ActionError, Error, "An action of an environment that is not valid.");
create_exception!(cocarry, SnapshotError, Error, "A snapshot that cannot be resumed.");
create_exception!(cocarry, RecordingError, Error, "A recording that cannot be read, written or drawn.");
create_exception!(cocarry, StudyError, Error, "A study that is not valid.");
create_exception!(cocarry, ClosedError, Error, "An object that is closed, in use, or of another process.");

/// The exception of type `E` with the error's message.
pub fn raise<E>(error: &dyn StdError) -> PyErr
where
    E: pyo3::PyTypeInfo,
{
    PyErr::new::<E, _>(in_python(&words(error)))
}

/// A message of the program with the keyword in place of the flag.
fn in_python(message: &str) -> String {
    // with the words around it: the message may name files
    message
        .replace("or give --overwrite", "or give overwrite=True")
        .replace("; --overwrite starts again", "; overwrite=True starts again")
}

/// The exception of an unknown column or quantity: an `Error` that is a `KeyError` too.
fn unknown_key(py: Python<'_>) -> PyResult<&'static Py<PyType>> {
    static KIND: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    KIND.get_or_try_init(py, || {
        let about = PyDict::new(py);
        about.set_item("__module__", "cocarry")?;
        about.set_item("__doc__", "A column or a quantity that there is not; a KeyError, too.")?;
        // that of KeyError has quotes around it
        about.set_item("__str__", py.get_type::<PyValueError>().getattr("__str__")?)?;
        let bases = (py.get_type::<Error>(), py.get_type::<PyKeyError>());
        let made = py.get_type::<PyType>().call1(("UnknownKeyError", bases, about))?;
        Ok(made.cast_into::<PyType>()?.unbind())
    })
}

/// The exception of an unknown column or quantity.
pub fn no_such_key(py: Python<'_>, message: String) -> PyErr {
    match unknown_key(py) {
        Ok(kind) => PyErr::from_type(kind.bind(py).clone(), (message,)),
        Err(error) => error,
    }
}

/// Runs `act`. A panic in it becomes an exception: the physics engine panics on a state that is not consistent.
pub fn guarded<T>(act: impl FnOnce() -> T) -> PyResult<T> {
    cocarry::guarded::here(act).map_err(|words| Error::new_err(format!("the simulation failed: {words}")))
}

/// Adds the exceptions to the module.
pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    for (name, exception) in [
        ("Error", py.get_type::<Error>()),
        ("WorldError", py.get_type::<WorldError>()),
        ("RobotError", py.get_type::<RobotError>()),
        ("ScenarioError", py.get_type::<ScenarioError>()),
        ("DecisionError", py.get_type::<DecisionError>()),
        ("ActionError", py.get_type::<ActionError>()),
        ("SnapshotError", py.get_type::<SnapshotError>()),
        ("RecordingError", py.get_type::<RecordingError>()),
        ("StudyError", py.get_type::<StudyError>()),
        ("ClosedError", py.get_type::<ClosedError>()),
    ] {
        module.add(name, exception)?;
    }
    module.add("UnknownKeyError", unknown_key(py)?)
}
