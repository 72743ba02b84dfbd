//! Actions: rows of numbers, one for each lane, checked.

use super::Lanes;
use super::lane::STANCES;
use super::rules::{Rules, Task};
use crate::error::ActionError;
use crate::value::repr;
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

impl Lanes {
    /// The actions as rows, one a lane.
    pub(super) fn rows(&self, given: &Bound<'_, PyAny>, lanes: usize) -> PyResult<Vec<f64>> {
        match self.rules.task {
            Task::Options => options(&self.rules, given, lanes),
            Task::Both => both(&self.rules, given, lanes),
            Task::Inputs | Task::Reference | Task::Residual => {
                let rows = motions(&self.rules, given, lanes)?;
                let width = self.rules.limits.len();
                Ok(rows.chunks(width).flat_map(|row| row.iter().copied().chain([self.period])).collect())
            }
        }
    }
}

fn options(rules: &Rules, given: &Bound<'_, PyAny>, lanes: usize) -> PyResult<Vec<f64>> {
    let most = rules.options as i64;
    let found = given.extract::<PyReadonlyArray1<'_, i64>>().ok().map(|array| array.as_array().to_vec());
    let found = found.filter(|rows| rows.len() == lanes && rows.iter().all(|a| (0..=most).contains(a)));
    found.map(|found| found.into_iter().map(|action| action as f64).collect()).ok_or_else(|| {
        ActionError::new_err(format!(
            "action {}; it must be {lanes} whole number(s) (int64) from 0 to {most}: an option to lead on, or {most} to follow",
            repr(given)
        ))
    })
}

fn both(rules: &Rules, given: &Bound<'_, PyAny>, lanes: usize) -> PyResult<Vec<f64>> {
    let most = rules.options as i64;
    let found = given.extract::<PyReadonlyArray2<'_, i64>>().ok();
    let found = found.filter(|rows| rows.as_array().shape() == [lanes, 3]);
    let rows = found.map(|rows| rows.as_array().iter().copied().collect::<Vec<_>>());
    let fits = |row: &[i64]| {
        (0..=most).contains(&row[0])
            && (0..most).contains(&row[1])
            && (0..STANCES.len() as i64).contains(&row[2])
    };
    let rows = rows.filter(|rows| rows.chunks(3).all(fits));
    rows.map(|rows| rows.into_iter().map(|number| number as f64).collect()).ok_or_else(|| {
        ActionError::new_err(format!(
            "actions {}; the robot's must be a whole number from 0 to {most}, the human's an option from 0 to {} and a response from 0 to 2",
            repr(given),
            most - 1
        ))
    })
}

/// Shares of the limits, each from -1 to 1.
fn motions(rules: &Rules, given: &Bound<'_, PyAny>, lanes: usize) -> PyResult<Vec<f64>> {
    let width = rules.limits.len();
    let found = given.extract::<PyReadonlyArray2<'_, f64>>().ok();
    let found = found
        .filter(|rows| rows.as_array().shape() == [lanes, width])
        .map(|rows| rows.as_array().iter().copied().collect::<Vec<_>>());
    let found = found.filter(|numbers| numbers.iter().all(|number| number.is_finite()));
    let found = found.ok_or_else(|| {
        ActionError::new_err(format!(
            "action {}; it must be numbers, all finite, {width} for each of {lanes} environment(s)",
            repr(given)
        ))
    })?;
    match found.iter().position(|share| share.abs() > 1.0) {
        None => Ok(found),
        Some(at) => {
            let (lane, i) = (at / width, at % width);
            let name = rules.action_numbers().swap_remove(i).name;
            let place = if lanes == 1 { String::new() } else { format!(" of environment {lane}") };
            Err(ActionError::new_err(format!(
                "action[{i}]{place} ({name}) is {}; it must be from -1 to 1, a share of action_limits: gymnasium.wrappers.ClipAction clips",
                found[at]
            )))
        }
    }
}
