//! The arguments of classes and functions: each with its name, and what it must be.
//!
//! Python converts an argument before a function sees it. What cannot be converted is refused here, so that it is
//! a `cocarry.Error` with the argument's name, its value and what would be right.

use crate::error::{Error, ScenarioError, StudyError};
use crate::scenario::Scenario;
use crate::value::repr;
use cocarry::scenario::PERCEPTION;
use pyo3::PyTypeInfo;
use pyo3::conversion::FromPyObjectOwned;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyString};
use std::fmt::Display;
use std::num::NonZeroU64;
use std::path::PathBuf;

const WHOLE: &str = "a whole number from 0 to 18446744073709551615";
const NUMBER: &str = "a number";
const PLACE: &str = "two numbers, x and y (m)";
const NUMBERS: &str = "a list of numbers";
const RANGE: &str = "a lower and an upper end, two numbers";
const FILE: &str = "a file: a str or a path";

/// The exception of type `E` of an argument.
pub fn refused<E: PyTypeInfo>(name: &str, given: &Bound<'_, PyAny>, expected: impl Display) -> PyErr {
    PyErr::new::<E, _>(format!("{name} = {}; it must be {expected}", repr(given)))
}

/// An argument that is not a flag.
pub fn argument<'py, T: FromPyObjectOwned<'py>>(
    name: &str,
    expected: impl Display,
    given: &Bound<'py, PyAny>,
) -> PyResult<T> {
    argument_of::<Error, T>(name, expected, given)
}

/// The same; what is refused is an exception of type `E`.
fn argument_of<'py, E: PyTypeInfo, T: FromPyObjectOwned<'py>>(
    name: &str,
    expected: impl Display,
    given: &Bound<'py, PyAny>,
) -> PyResult<T> {
    let is_flag = given.is_instance_of::<PyBool>();
    given.extract().ok().filter(|_| !is_flag).ok_or_else(|| refused::<E>(name, given, expected))
}

fn text<'a, E: PyTypeInfo>(
    name: &str,
    expected: impl Display,
    given: &'a Bound<'_, PyAny>,
) -> PyResult<&'a str> {
    let given_text = given.cast::<PyString>().map_err(|_| refused::<E>(name, given, expected))?;
    given_text.to_str().map_err(|_| refused::<E>(name, given, "a text without lone surrogates"))
}

macro_rules! arguments {
    ($error:ident: $($function:ident = $name:literal: $kind:ty, $expected:expr;)*) => {
        $(
            #[doc = concat!("The argument `", $name, "`.")]
            pub fn $function(given: &Bound<'_, PyAny>) -> PyResult<$kind> {
                argument_of::<$error, $kind>($name, $expected, given)
            }
        )*
    };
}

macro_rules! texts {
    ($error:ident: $($function:ident = $name:literal, $expected:expr;)*) => {
        $(
            #[doc = concat!("The argument `", $name, "`, a text.")]
            pub fn $function<'a>(given: &'a Bound<'_, PyAny>) -> PyResult<&'a str> {
                text::<$error>($name, $expected, given)
            }
        )*
    };
}

macro_rules! flags {
    ($($function:ident = $name:literal;)*) => {
        $(
            #[doc = concat!("The argument `", $name, "`, a flag.")]
            pub fn $function(given: &Bound<'_, PyAny>) -> PyResult<bool> {
                given.extract().map_err(|_| refused::<Error>($name, given, "True or False"))
            }
        )*
    };
}

arguments! {
    Error:
    seed = "seed": u64, WHOLE;
    other_seed = "seed": Option<u64>, WHOLE;
    alpha = "alpha": f64, PERCEPTION;
    gamma = "gamma": f64, PERCEPTION;
    given_alpha = "alpha": Option<f64>, PERCEPTION;
    given_gamma = "gamma": Option<f64>, PERCEPTION;
    steps = "steps": Option<u64>, "a whole number of at least 0, or None for all";
    option = "option": usize, "a whole number of at least 0";
    options = "options": usize, "a whole number from 0 to 1000000";
    start = "start": [f64; 2], PLACE;
    target = "target": [f64; 2], PLACE;
    robot_width = "robot_width_m": Option<f64>, NUMBER;
    tolerance = "tolerance_m": Option<f64>, NUMBER;
    risk_weight = "risk_weight_m": f64, NUMBER;
    lengths = "length_m": Vec<f64>, NUMBERS;
    risks = "risk": Vec<f64>, NUMBERS;
    alphas = "alpha": Vec<f64>, NUMBERS;
    gammas = "gamma": Vec<f64>, NUMBERS;
    range_of_alpha = "alpha": Option<[f64; 2]>, RANGE;
    range_of_gamma = "gamma": Option<[f64; 2]>, RANGE;
    file = "file": PathBuf, FILE;
    map = "map": PathBuf, FILE;
    threads = "threads": Option<usize>, "a whole number of at least 1";
    num_envs = "num_envs": usize, "a whole number from 1 to 100000";
    index = "index": usize, "a whole number, less than the number of environments";
    max_steps = "max_steps": Option<u64>, "a whole number of at least 1";
    max_episode_steps = "max_episode_steps": Option<u64>, "a whole number of at least 1";
    most_step_cost = "most_step_cost": Option<f64>, "a number greater than 0";
    action_scale = "action_scale": Option<f64>, "a number greater than 0 and at most 1";
    reset_mask = "reset_mask": Option<Vec<bool>>, "one True or False for each environment";
}

arguments! {
    ScenarioError:
    seed_of_scenario = "seed": u64, WHOLE;
    other_seed_of_scenario = "seed": Option<u64>, WHOLE;
    alpha_of_scenario = "alpha": Option<f64>, PERCEPTION;
    gamma_of_scenario = "gamma": Option<f64>, PERCEPTION;
    changes = "changes": Option<Vec<(u64, f64, f64)>>, "a list of (step, alpha, gamma), step a whole number of at least 0";
}

arguments! {
    StudyError:
    seeds_of_study = "seeds": Option<NonZeroU64>, "a whole number of at least 1";
    threads_of_study = "threads": Option<usize>, "a whole number of at least 1";
    shard = "shard": Option<(u64, u64)>, "(i, n), the i-th of n parts, with 1 <= i <= n";
}

/// The argument `scenario`.
pub fn scenario(given: &Bound<'_, PyAny>) -> PyResult<Py<Scenario>> {
    argument("scenario", "a cocarry.Scenario", given)
}

texts! {
    ScenarioError:
    plant = "plant", "one of: \"point\", \"kinematic\", \"rapier\"";
    belief_alpha = "belief_alpha", "uniform(LOWER,UPPER) or normal(MEAN,STD,LOWER,UPPER)";
    belief_gamma = "belief_gamma", "uniform(LOWER,UPPER) or normal(MEAN,STD,LOWER,UPPER)";
    text_of_scenario = "text", "a text";
}

texts! {
    Error:
    contents = "text", "a text";
    name = "name", "a text";
    title = "title", "a text";
    of = "of", "one of: tick, option, episode";
}

flags! {
    overwrite = "overwrite";
    xacro = "xacro";
}
