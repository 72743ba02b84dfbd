//! The exceptions, each with the message of the command line.

pub use cocarry::error::words;
use pyo3::create_exception;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
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
    PyErr::new::<E, _>(words(error))
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
    Ok(())
}
