//! What is compared in a summary: combinations that differ in one input, by some quantities, over the humans.

use super::SweepError;
use super::row;
use super::summary::{COSTS, OUTCOMES};
use cocarry::Error;
use cocarry::quantities::{EPISODE, QuantityKind};
use cocarry::scenario::{Applies, SETTINGS};
use cocarry::suggestion::hint;

/// Columns that say the same in more words, or are there only with certain values of the first: they are
/// compared together.
const TOGETHER: [&[&str]; 5] = [
    &["method", "policy_code"],
    &["human_model", "human_code"],
    &["humans", "humans_alpha", "humans_gamma"],
    &["belief", "belief_alpha", "belief_gamma"],
    &["pose", "pose_criterion", "prepare_while_leading"],
];
/// The inputs that are compared unless others are asked for.
const BY_DEFAULT: [&str; 2] = ["method", "pose"];

/// What to compare.
#[derive(Clone, Debug)]
pub struct Comparing {
    /// Groups of input columns. Combinations that differ in the columns of a group only are compared.
    by: Vec<Vec<&'static str>>,
    /// Input columns over which each human's differences are averaged, so that a human counts once.
    over: Vec<&'static str>,
    /// Columns of figures.
    quantities: Vec<&'static str>,
}

impl Default for Comparing {
    /// Methods, and choices of the pose, by their costs.
    fn default() -> Self {
        let by = BY_DEFAULT.map(columns_with).to_vec();
        Self { by, over: Vec::new(), quantities: OUTCOMES[..COSTS].to_vec() }
    }
}

impl Comparing {
    /// Combinations that differ in the input `by`, averaged over the inputs `over`, by these quantities; no
    /// names: as by default, which is methods and poses, nothing, and J and C.
    ///
    /// # Errors
    /// A name is not that of a column that can be compared, or averaged over.
    pub fn new(by: Option<&str>, over: &[String], quantities: &[String]) -> Result<Self, Error> {
        let default = Self::default();
        let by = match by {
            Some(by) => vec![columns_with(input_column("by", by)?)],
            None => default.by,
        };
        let over = over.iter().map(|over| input_column("over", over).map(columns_with));
        let over = over.collect::<Result<Vec<_>, _>>()?.concat();
        if let Some(twice) = over.iter().find(|over| by.iter().flatten().any(|by| by == *over)) {
            return Err(Error::new(format!("over: `{twice}` is compared, and cannot be averaged over")));
        }
        let quantities = match quantities {
            [] => default.quantities,
            given => given.iter().map(|name| quantity(name)).collect::<Result<_, _>>()?,
        };
        Ok(Self { by, over, quantities })
    }

    /// The number of comparisons that differ in what is compared.
    pub(super) fn kinds(&self) -> usize {
        self.by.len()
    }

    pub(super) fn is_by(&self, kind: usize, column: &str) -> bool {
        self.by[kind].contains(&column)
    }

    pub(super) fn is_over(&self, column: &str) -> bool {
        self.over.contains(&column)
    }

    pub(super) fn quantities(&self) -> &[&'static str] {
        &self.quantities
    }
}

/// A column with those that go with it.
fn columns_with(column: &'static str) -> Vec<&'static str> {
    if column == "plant" {
        // settings that some plants ignore have no value there
        let settings = SETTINGS.iter().filter(|setting| !matches!(setting.applies, Applies::Always));
        return ["plant", "robot"].into_iter().chain(settings.map(|setting| setting.key)).collect();
    }
    let group = TOGETHER.iter().find(|group| group[0] == column);
    group.map_or_else(|| vec![column], |group| group.to_vec())
}

/// An input column of that name.
fn input_column(what: &str, name: &str) -> Result<&'static str, Error> {
    one_of(what, name, row::input_columns())
}

/// The column of a quantity of episodes that is a number.
fn quantity(name: &str) -> Result<&'static str, Error> {
    let numbers = EPISODE
        .iter()
        .filter(|quantity| matches!(quantity.kind, QuantityKind::Number(_) | QuantityKind::Count));
    one_of("quantity", name, numbers.map(|quantity| quantity.key))
}

fn one_of(what: &str, name: &str, known: impl Iterator<Item = &'static str>) -> Result<&'static str, Error> {
    let known: Vec<&'static str> = known.collect();
    known.iter().copied().find(|known| *known == name).ok_or_else(|| {
        let hint = hint(name, known.iter().copied());
        Error::new(format!("{what}: unknown column `{name}`{hint}; expected one of: {}", known.join(", ")))
    })
}

/// The refusal of results without anything to compare, although some episodes were paired, or not.
pub(super) fn nothing(names: &[String], by: &str, are_paired: bool) -> SweepError {
    let why = match are_paired {
        true => "no pair of episodes has both arrived, with the quantities that are compared".to_owned(),
        false => format!("no two combinations differ in {by} alone, with the same seed"),
    };
    SweepError::File(Error::new(format!("{}: {why}", names.join(", "))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_columns_that_are_compared_are_written() {
        let columns = row::columns();
        for name in TOGETHER.into_iter().flatten().copied().chain(BY_DEFAULT) {
            assert!(columns.contains(&name), "{name}");
        }
        assert!(columns_with("plant").iter().all(|name| columns.contains(name)));
    }

    #[test]
    fn a_mistyped_column_is_refused_by_name() {
        let error = Comparing::new(Some("metod"), &[], &[]).unwrap_err().to_string();
        assert!(error.contains("`metod`") && error.contains("`method`"), "{error}");
        for wrong in ["outcome", "alfa", "seed"] {
            assert!(Comparing::new(None, &[], &[wrong.to_owned()]).is_err(), "{wrong}");
        }
        assert!(Comparing::new(Some("method"), &["method".to_owned()], &[]).is_err());
    }
}
