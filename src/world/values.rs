//! Lists of a fixed number of values.

use serde::Deserialize;

/// Two values; more or fewer are an error.
pub(super) type Pair<T> = Values<T, 2>;

/// So many values; more or fewer are an error.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(try_from = "Vec<T>")]
#[serde(bound(deserialize = "T: Deserialize<'de>"))]
pub(super) struct Values<T, const N: usize>(pub [T; N]);

impl<T, const N: usize> TryFrom<Vec<T>> for Values<T, N> {
    type Error = String;

    fn try_from(values: Vec<T>) -> Result<Self, String> {
        let n = values.len();
        let expected = if N == 2 { "two" } else { "three" };
        values.try_into().map(Self).map_err(|_| format!("expected {expected} values, found {n}"))
    }
}
