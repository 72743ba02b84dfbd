//! The native module of the Python package `cocarry`: thin classes over the library. The package's own Python
//! files give it names, types and documentation.

mod arguments;
mod environments;
mod episode;
mod error;
mod partners;
mod preference;
mod recording;
mod registry;
mod results;
mod robot;
mod scenario;
mod study;
mod table;
mod value;
mod world;

use cocarry::quantities::{EPISODE, OPTION, Quantity, QuantityKind, TICK};
use cocarry_output::palette;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyDictMethods};
use std::ffi::OsString;
use std::process::ExitCode;

/// The Gumbel disturbances that the Boltzmann human of a seed draws, one for every option.
#[pyfunction]
fn gumbel(
    py: Python<'_>,
    #[pyo3(from_py_with = arguments::seed)] seed: u64,
    #[pyo3(from_py_with = arguments::options)] options: usize,
) -> PyResult<Bound<'_, PyArray1<f64>>> {
    if options > 1_000_000 {
        return Err(error::Error::new_err(format!("options = {options}; it must be at most 1000000")));
    }
    Ok(PyArray1::from_vec(py, cocarry::human::disturbances(seed, options)))
}

/// The colours of options in pictures, as ``#rrggbb``; they repeat after the last.
#[pyfunction]
fn option_colours() -> Vec<String> {
    (0..palette::option_colours()).map(|option| palette::hex(palette::option_colour(option))).collect()
}

/// The vocabulary of a table of quantities: key, unit and description.
fn vocabulary<'py, G>(py: Python<'py>, quantities: &[Quantity<G>]) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for quantity in quantities {
        let unit = if let QuantityKind::Number(unit) = quantity.kind { unit } else { "" };
        dict.set_item(quantity.key, (unit, quantity.description))?;
    }
    Ok(dict)
}

/// Every quantity of a ``"tick"``, an ``"option"`` or an ``"episode"``: its unit and its description.
#[pyfunction]
fn quantities<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = arguments::of)] of: &str,
) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    match of {
        "tick" => {
            for table in TICK {
                dict.update(vocabulary(py, table)?.as_mapping())?;
            }
        }
        "episode" => return vocabulary(py, EPISODE),
        "option" => return vocabulary(py, OPTION),
        other => {
            return Err(error::Error::new_err(format!(
                "of = {other:?}; it must be one of: tick, option, episode"
            )));
        }
    }
    Ok(dict)
}

/// Runs the command-line program with these arguments; returns its exit code.
#[pyfunction]
fn program(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    registry::provide(py);
    let code = py.detach(|| cocarry_program::main_of(arguments));
    (0..=u8::MAX).find(|number| ExitCode::from(*number) == code).unwrap_or(1)
}

#[pymodule]
fn _cocarry(module: &Bound<'_, PyModule>) -> PyResult<()> {
    error::add(module)?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<world::World>()?;
    module.add_class::<robot::Robot>()?;
    module.add_class::<scenario::Scenario>()?;
    module.add_class::<episode::Episode>()?;
    module.add_class::<partners::PyView>()?;
    module.add_class::<partners::PyRobotView>()?;
    module.add_class::<partners::PyHumanView>()?;
    module.add_class::<partners::PyHandView>()?;
    module.add_class::<preference::Preference>()?;
    module.add_class::<table::Table>()?;
    module.add_class::<environments::Lanes>()?;
    module.add_class::<recording::Recording>()?;
    module.add_function(wrap_pyfunction!(scenario::settings, module)?)?;
    module.add_function(wrap_pyfunction!(study::sweep, module)?)?;
    module.add_function(wrap_pyfunction!(study::study_rows, module)?)?;
    module.add_function(wrap_pyfunction!(study::study_episodes, module)?)?;
    module.add_function(wrap_pyfunction!(study::check_partner, module)?)?;
    module.add_function(wrap_pyfunction!(study::rows_table, module)?)?;
    module.add_function(wrap_pyfunction!(study::arithmetic_stamp, module)?)?;
    module.add_function(wrap_pyfunction!(results::compare, module)?)?;
    module.add_function(wrap_pyfunction!(results::summary, module)?)?;
    module.add_function(wrap_pyfunction!(results::bench, module)?)?;
    module.add_function(wrap_pyfunction!(results::plot, module)?)?;
    module.add_class::<study::Rows>()?;
    module.add_function(wrap_pyfunction!(recording::read, module)?)?;
    module.add_function(wrap_pyfunction!(recording::player, module)?)?;
    module.add_function(wrap_pyfunction!(recording::picture, module)?)?;
    module.add_function(wrap_pyfunction!(gumbel, module)?)?;
    module.add_function(wrap_pyfunction!(option_colours, module)?)?;
    module.add_function(wrap_pyfunction!(quantities, module)?)?;
    module.add_function(wrap_pyfunction!(program, module)?)?;
    Ok(())
}
