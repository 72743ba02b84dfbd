//! The largest values of the parameters of the preference model.

use crate::error::Error;

/// The largest lapse rate.
pub const MAX_LAPSE_RATE: f64 = 0.5;

/// The largest rationality of a belief. Beyond it, costs would have to be exact to more digits than they
/// have, and choices are those of eq. (3).
pub const MAX_RATIONALITY: f64 = 1000.0;

/// Checks a probability, called `name` in the error.
///
/// # Errors
/// It is not a number from 0 to `most`.
pub(super) fn check_rate(name: &str, value: f64, most: f64) -> Result<(), Error> {
    match (0.0..=most).contains(&value) {
        true => Ok(()),
        false => Err(Error::new(format!("{name} {value} must be a number from 0 to {most}"))),
    }
}

/// Checks the probability of a lapse: of a choice, or of a time of taking over, that is uninformative.
///
/// # Errors
/// It is not a number from 0 to [`MAX_LAPSE_RATE`].
pub(crate) fn check_lapse_rate(value: f64) -> Result<(), Error> {
    check_rate("lapse rate", value, MAX_LAPSE_RATE)
}
