//! Columns of tables: name, unit and meaning of each; as Arrow data with the feature `parquet`.

#[cfg(feature = "parquet")]
mod arrow;

#[cfg(feature = "parquet")]
pub use arrow::{Column, Columns};

use cocarry::quantities::{EPISODE, Kind, Quantity, TICK};

/// What a column is.
#[derive(Clone, Debug)]
pub struct Heading {
    /// Its name, which ends in its unit.
    pub name: &'static str,
    /// The kind of its values, with the unit.
    pub kind: Kind,
    /// Its meaning.
    pub description: &'static str,
}

impl<Getter> From<&Quantity<Getter>> for Heading {
    fn from(quantity: &Quantity<Getter>) -> Self {
        Self { name: quantity.key, kind: quantity.kind, description: quantity.description }
    }
}

/// The kind of numbers whose key ends in their unit, as those of [`quantities`](cocarry::quantities) do.
pub fn number(key: &str) -> Kind {
    let kinds = TICK.into_iter().chain([EPISODE]).flatten().map(|quantity| quantity.kind);
    let units = kinds.filter_map(|kind| if let Kind::Number(unit) = kind { Some(unit) } else { None });
    // a unit of settings alone
    let units = units.chain(["rad/s"]);
    let suffix = |unit: &str| format!("_{}", unit.to_lowercase().replace('/', "_per_").replace('^', ""));
    let found = units.filter(|unit| !unit.is_empty() && key.ends_with(&suffix(unit)));
    Kind::Number(found.max_by_key(|unit| unit.len()).unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_says_its_unit() {
        let unit = |key| if let Kind::Number(unit) = number(key) { unit } else { "another kind" };
        let keys = ["speed_m_per_s", "yaw_rate_rad_per_s", "period_s", "sway_m", "eta", "state_weight"];
        assert_eq!(keys.map(unit), ["m/s", "rad/s", "s", "m", "", ""]);
    }
}
