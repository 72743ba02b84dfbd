//! The vocabulary: every figure of a planning step and of an episode, declared once.
//!
//! A [`Quantity`] has a key, a kind with its unit, a description and a getter. Tables of ticks, JSON, the
//! channels of recordings with their schemas, the result columns of studies and the figures of baselines are
//! all read from the tables here, so a figure has one public name. The sentences about what happens in an
//! episode are in [`Event`].
//!
//! ```
//! use cocarry::quantities::{EPISODE, View};
//! # use cocarry::scenario::{Plant, Scenario};
//! # let scenario = Scenario {
//! #     seed: 1,
//! #     world: cocarry::world::World::load("worlds/environment-4.toml".as_ref())?.into(),
//! #     human: cocarry::preference::Perception { alpha: 0.747, gamma: 0.765 },
//! #     human_model: Default::default(),
//! #     changes: Vec::new(),
//! #     settings: Default::default(),
//! #     plant: Plant::Point,
//! # };
//! let prepared = scenario.prepare()?;
//! let mut episode = prepared.episode()?;
//! while episode.step().is_none() {}
//! let figures = View::new(&prepared, &episode).read(EPISODE);
//! assert_eq!((figures[0].0, figures[0].1.as_str()), ("outcome", Some("arrived")));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod episode;
mod event;
mod learned;
mod preparation;
mod report;
mod tick;
mod value;

pub use episode::EPISODE;
pub use event::{Event, Severity};
pub use learned::LEARNED;
pub use preparation::PREPARATION;
pub use tick::{
    BASE, CONTROL, COORDINATION, COST, INTERACTION, JOINTS, OPTION, OPTIONS, OptionView, STEP, TICK, TIME,
    option_numbers,
};
pub use value::{Fields, Value};

use crate::episode::{Episode, Outcome};
use crate::scenario::PreparedScenario;
use std::collections::BTreeMap;

/// Values by their keys, in the order of their table.
pub type Record = Vec<(&'static str, Value)>;

/// An episode with its prepared scenario, which gives names to its indices.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// The prepared scenario.
    pub prepared: &'a PreparedScenario,
    /// The episode. Quantities of a planning step are those of the last step taken.
    pub episode: &'a Episode<'a>,
    /// The outcome of the episode; `None` if the user interrupted it.
    pub outcome: Option<Outcome>,
}

impl<'a> View<'a> {
    /// An episode that goes on or is over.
    pub fn new(prepared: &'a PreparedScenario, episode: &'a Episode<'a>) -> Self {
        Self { prepared, episode, outcome: Some(episode.summary().outcome) }
    }
}

impl View<'_> {
    /// The values of these quantities, by their keys.
    pub fn read(&self, quantities: &[Quantity]) -> Record {
        read(quantities, self)
    }

    /// Two links of the robot, by their names.
    fn links(&self, links: Option<[usize; 2]>) -> Option<String> {
        let robot = self.prepared.robot()?;
        links.map(|pair| pair.map(|link| robot.links[link].name.as_str()).join(", "))
    }

    /// A sentence about the robot's contacts with itself; `None` if it had none.
    pub fn self_contact(&self) -> Option<String> {
        let control = self.episode.summary().control.as_ref()?;
        let links = self.links(control.self_contact)?;
        Some(format!("the robot touched itself in {} steps, first: {links}", control.self_contact_steps))
    }

    fn option(&self, option: usize) -> &str {
        &self.prepared.options().options()[option].name
    }
}

/// A figure: its public name, kind, description and getter.
#[derive(Clone, Copy, Debug)]
pub struct Quantity<Getter = fn(&View) -> Value> {
    /// Public name, which ends in the unit: `length_m`.
    pub key: &'static str,
    /// The kind of its value.
    pub kind: QuantityKind,
    /// Its symbol, its meaning, and when it is missing.
    pub description: &'static str,
    /// Its getter.
    pub get: Getter,
}

/// The kind of a quantity's value.
#[derive(Clone, Copy, Debug)]
pub enum QuantityKind {
    /// A real number, with its unit; "" if it has none.
    Number(&'static str),
    /// A whole number.
    Count,
    /// A word or a sentence.
    Text,
    /// True or false.
    Flag,
    /// A list of numbers.
    Numbers,
    /// A record, with the headings of its values.
    Record(fn() -> Vec<Heading>),
    /// A list of records, with the headings of one.
    List(fn() -> Vec<Heading>),
}

/// A quantity without its getter: name, kind and meaning.
#[derive(Clone, Copy, Debug)]
pub struct Heading {
    /// Its name, which ends in its unit.
    pub name: &'static str,
    /// The kind of its values, with the unit.
    pub kind: QuantityKind,
    /// Its meaning.
    pub description: &'static str,
}

impl<Getter> From<&Quantity<Getter>> for Heading {
    fn from(quantity: &Quantity<Getter>) -> Self {
        Self { name: quantity.key, kind: quantity.kind, description: quantity.description }
    }
}

const PLAIN: QuantityKind = QuantityKind::Number("");
const METRES: QuantityKind = QuantityKind::Number("m");
const DEGREES: QuantityKind = QuantityKind::Number("deg");
const RADIANS: QuantityKind = QuantityKind::Number("rad");
const SECONDS: QuantityKind = QuantityKind::Number("s");
const METRES_PER_SECOND: QuantityKind = QuantityKind::Number("m/s");
const ACCELERATION: QuantityKind = QuantityKind::Number("m/s^2");
const JERK: QuantityKind = QuantityKind::Number("m/s^3");
const RADIANS_PER_SECOND: QuantityKind = QuantityKind::Number("rad/s");
const NEWTONS: QuantityKind = QuantityKind::Number("N");
const NEWTON_METRES: QuantityKind = QuantityKind::Number("Nm");
const JOULES: QuantityKind = QuantityKind::Number("J");
const SQUARED_JERK: QuantityKind = QuantityKind::Number("m^2/s^5");

type Of<V> = Quantity<fn(&V) -> Value>;

/// The values of these quantities, by their keys.
fn read<V>(quantities: &[Of<V>], of: &V) -> Record {
    quantities.iter().map(|quantity| (quantity.key, (quantity.get)(of))).collect()
}

/// The values of these quantities as a nested record.
fn fields<V>(quantities: &[Of<V>], of: &V) -> Fields {
    read(quantities, of).into_iter().collect()
}

/// The headings of the quantities of a record, in the order of their names. Each name stands once.
pub fn headings<'a, Getter: 'a>(quantities: impl IntoIterator<Item = &'a Quantity<Getter>>) -> Vec<Heading> {
    let named = quantities.into_iter().map(|quantity| (quantity.key, Heading::from(quantity)));
    named.collect::<BTreeMap<_, _>>().into_values().collect()
}

/// A table of quantities: key, kind, description and getter of each.
macro_rules! quantities {
    ($($key:literal, $kind:expr, $description:literal, |$view:pat_param| $get:expr;)*) => {
        &[$($crate::quantities::Quantity {
            key: $key,
            kind: $kind,
            description: $description,
            get: |$view| $crate::quantities::Value::from($get),
        }),*]
    };
}
use quantities;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coordination::OptionTick;
    use crate::options::{Remaining, Waypoint};
    use std::collections::BTreeSet;

    #[test]
    fn closed_form_the_numbers_of_an_option_are_its_quantities() {
        let remaining = Remaining { length: 17.4, risk: 0.36, next: Waypoint::Target };
        let near =
            OptionTick { remaining, objective: 21.0, expected: 15.5, probability: 0.25, misaligned: true };
        let far = Remaining { length: f64::INFINITY, ..remaining };
        let unknown = OptionTick {
            remaining: far,
            objective: f64::INFINITY,
            expected: f64::NAN,
            probability: f64::NAN,
            misaligned: false,
        };
        for option in [near, unknown] {
            let view = OptionView { name: "1", option: &option };
            let numbers: Vec<f64> = OPTION[1..]
                .iter()
                .map(|quantity| match (quantity.get)(&view) {
                    Value::Flag(is_set) => f64::from(u8::from(is_set)),
                    value => value.as_f64().unwrap_or(0.0),
                })
                .collect();
            assert_eq!((OPTION[0].key, option_numbers(&option).as_slice()), ("name", numbers.as_slice()));
        }
    }

    /// Key and kind of every quantity, nested ones included.
    fn all() -> Vec<(&'static str, QuantityKind)> {
        fn of<Getter>(quantities: &[Quantity<Getter>]) -> Vec<(&'static str, QuantityKind)> {
            quantities.iter().map(|quantity| (quantity.key, quantity.kind)).collect()
        }
        let nested =
            [of(OPTION), of(tick::REVOLUTE), of(tick::PRISMATIC), of(learned::HUMAN), preparation::nested()];
        TICK.into_iter().chain([PREPARATION, LEARNED, EPISODE]).map(of).chain(nested).flatten().collect()
    }

    #[test]
    fn keys_are_plain_and_end_in_their_unit() {
        let suffix = |unit: &str| format!("_{}", unit.to_lowercase().replace('/', "_per_").replace('^', ""));
        let units: BTreeSet<&str> = all()
            .iter()
            .filter_map(|(_, kind)| if let QuantityKind::Number(unit) = kind { Some(*unit) } else { None })
            .collect();
        assert!(units.len() > 8, "{units:?}");
        for (key, kind) in all() {
            assert!(key.bytes().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == b'_'), "{key}");
            match kind {
                QuantityKind::Number(unit) if !unit.is_empty() => {
                    assert!(key.ends_with(&suffix(unit)), "{key}: {unit}")
                }
                _ => {
                    let unit = units.iter().find(|unit| !unit.is_empty() && key.ends_with(&suffix(unit)));
                    assert_eq!(unit, None, "{key} is said to have no unit");
                }
            }
        }
    }

    #[test]
    fn a_key_stands_for_one_quantity_of_a_tick_and_for_one_of_an_episode() {
        for tables in [&TICK[..], &[STEP, PREPARATION], &[EPISODE]] {
            let keys: Vec<_> = tables.iter().flat_map(|table| table.iter().map(|q| q.key)).collect();
            assert_eq!(keys.iter().collect::<BTreeSet<_>>().len(), keys.len(), "{keys:?}");
        }
    }
}
