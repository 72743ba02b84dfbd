//! A quantity of a study's episodes over the plane of the humans' alpha and gamma.

use super::results::{Results, Rows};
use super::summary::OUTCOMES;
use super::{SweepError, row};
use crate::statistics::Moments;
use std::collections::BTreeMap;

/// Means of a quantity over a grid of intervals of alpha and gamma.
#[derive(Debug)]
pub struct Plane {
    /// The ranges of alpha and of gamma of the humans in the file.
    pub ranges: [[f64; 2]; 2],
    /// The combinations, in the order in which they appear.
    pub parts: Vec<PlanePart>,
}

/// The grid of one combination.
#[derive(Debug)]
pub struct PlanePart {
    /// The inputs by column; empty where they do not apply.
    pub inputs: BTreeMap<String, String>,
    /// For every interval of gamma, from the least, the means for the intervals of alpha, from the least;
    /// `None` where no episode arrived.
    pub means: Vec<Vec<Option<f64>>>,
}

/// The largest number of combinations: each has a picture.
const MAX_PARTS: usize = 64;

impl Plane {
    /// Reads results. The grid has `cells` intervals on either side. `quantity` is a column of
    /// [`Summary`](super::Summary)'s outcomes. Only episodes that arrived count.
    ///
    /// # Errors
    /// [`SweepError`], which names the file and the line, also where no row has the quantity.
    pub fn load(results: &[Results], quantity: &str, cells: usize) -> Result<Self, SweepError> {
        let mut ranges = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        each(results, quantity, |_, person, _| {
            for (range, value) in ranges.iter_mut().zip(person) {
                *range = [range[0].min(value), range[1].max(value)];
            }
            Ok(())
        })?;
        if ranges[0][0] > ranges[0][1] {
            let names: Vec<String> = results.iter().map(Results::name).collect();
            return Err(SweepError::empty(names.join(", ")));
        }
        // humans who are all alike have a cell, too
        let widened = ranges
            .map(|[least, most]| if most > least { [least, most] } else { [least - 0.05, most + 0.05] });
        let cell = |value: f64, [least, most]: [f64; 2]| {
            (((value - least) / (most - least) * cells as f64) as usize).min(cells - 1)
        };
        let mut known: BTreeMap<Vec<String>, usize> = BTreeMap::new();
        let mut parts: Vec<(Vec<String>, Vec<Vec<Moments>>)> = Vec::new();
        each(results, quantity, |inputs, [alpha, gamma], value| {
            let next = parts.len();
            let part = *known.entry(inputs).or_insert_with_key(|inputs| {
                parts.push((inputs.clone(), vec![vec![Moments::default(); cells]; cells]));
                next
            });
            parts[part].1[cell(gamma, widened[1])][cell(alpha, widened[0])].add(value, value.abs());
            if parts.len() > MAX_PARTS {
                Err(format!("one of at most {MAX_PARTS} combinations"))
            } else {
                Ok(())
            }
        })?;
        let names: Vec<&str> = row::input_columns().collect();
        let part = |(inputs, grid): (Vec<String>, Vec<Vec<Moments>>)| PlanePart {
            inputs: names.iter().map(|name| (*name).to_owned()).zip(inputs).collect(),
            means: grid
                .iter()
                .map(|row| row.iter().map(|m| m.estimate(true).map(|estimate| estimate.mean)).collect())
                .collect(),
        };
        Ok(Self { ranges: widened, parts: parts.into_iter().map(part).collect() })
    }
}

/// Calls `on_row` for every episode that arrived and has the quantity: with the inputs, alpha and gamma, and
/// the value. An error of `on_row` says what was expected instead of the row.
fn each(
    results: &[Results],
    quantity: &str,
    mut on_row: impl FnMut(Vec<String>, [f64; 2], f64) -> Result<(), String>,
) -> Result<(), SweepError> {
    let columns = row::columns();
    let at = |name: &str| columns.iter().position(|column| *column == name).expect("a column of the rows");
    let inputs = row::IDENTITY.len()..row::IDENTITY.len() + row::input_columns().count();
    let quantity = OUTCOMES.into_iter().find(|known| *known == quantity).map(at);
    let (outcome, alpha, gamma) = (at("outcome"), at("alpha"), at("gamma"));
    for results in results {
        let mut rows = Rows::of(*results)?;
        while rows.next()?.is_some() {
            let fields = rows.checked_fields()?;
            let number = |i: usize| fields[i].parse::<f64>().ok().filter(|value| value.is_finite());
            let (Some(value), Some(alpha), Some(gamma)) =
                (quantity.and_then(number), number(alpha), number(gamma))
            else {
                continue;
            };
            if &fields[outcome] == row::arrived() {
                let inputs = inputs.clone().map(|i| fields[i].to_owned()).collect();
                let found = "another combination".to_owned();
                on_row(inputs, [alpha, gamma], value).map_err(|expected| {
                    SweepError::row(rows.position(), rows.file.clone(), found, expected)
                })?;
            }
        }
        rows.check_all()?;
    }
    Ok(())
}
