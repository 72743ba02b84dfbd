//! The vocabulary: every figure of a control period and of an episode, declared once.
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
//! let stage = scenario.prepare()?;
//! let mut episode = stage.episode()?;
//! while episode.step().is_none() {}
//! let figures = View::new(&stage, &episode).read(EPISODE);
//! assert_eq!(figures.get("outcome").as_text(), Some("arrived"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod episode;
mod event;
mod learned;
mod preparation;
mod tick;
mod value;

pub use episode::EPISODE;
pub use event::{Event, Severity};
pub use learned::LEARNED;
pub use preparation::PREPARATION;
pub use tick::{
    BASE, CONTROL, COORDINATION, COST, INTERACTION, JOINTS, OPTION, OPTIONS, OptionView, STEP, TICK, TIME,
};

pub use value::{Record, Value};

use crate::episode::{Episode, Outcome};
use crate::scenario::PreparedScenario;

/// An episode with its prepared scenario, which gives names to its indices.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// The prepared scenario.
    pub stage: &'a PreparedScenario,
    /// The episode. Quantities of a control period are those of the last step taken.
    pub episode: &'a Episode<'a>,
    /// Whether the user interrupted the episode.
    pub is_interrupted: bool,
}

impl<'a> View<'a> {
    /// A view of an episode that is not interrupted.
    pub fn new(stage: &'a PreparedScenario, episode: &'a Episode<'a>) -> Self {
        Self { stage, episode, is_interrupted: false }
    }

    /// The outcome; `None` if the user interrupted the episode.
    fn outcome(&self) -> Option<Outcome> {
        (!self.is_interrupted).then(|| self.episode.summary().outcome)
    }

    /// The values of these quantities, by their keys.
    pub fn read(&self, quantities: &[Quantity]) -> Record {
        read(quantities, self)
    }

    /// Two links of the robot, by their names.
    fn links(&self, links: Option<[usize; 2]>) -> Option<String> {
        let robot = self.stage.robot()?;
        links.map(|pair| pair.map(|link| robot.links[link].name.as_str()).join(", "))
    }

    /// What to say of an episode in which the robot touched itself.
    pub fn self_contact(&self) -> Option<String> {
        let control = self.episode.summary().control.as_ref()?;
        let links = self.links(control.self_contact)?;
        Some(format!("the robot touched itself in {} steps, first: {links}", control.self_contact_steps))
    }

    fn option(&self, option: usize) -> &str {
        &self.stage.options().options()[option].name
    }
}

/// A figure: its public name, kind, description and getter.
#[derive(Clone, Copy, Debug)]
pub struct Quantity<Getter = fn(&View) -> Value> {
    /// Public name, which ends in the unit: `length_m`.
    pub key: &'static str,
    /// The kind of its value.
    pub kind: Kind,
    /// Its symbol, its meaning, and when it is missing.
    pub description: &'static str,
    /// Its getter.
    pub get: Getter,
}

/// The kind of a quantity's value.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
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
    /// A list of records, with the headings of the values of one.
    List(fn() -> Vec<Heading>),
}

/// What a value is: the heading of a column, or of a field of a record.
#[derive(Clone, Copy, Debug)]
pub struct Heading {
    /// Public name, which ends in the unit.
    pub key: &'static str,
    /// The kind of its value, with the unit.
    pub kind: Kind,
    /// Its meaning.
    pub description: &'static str,
}

impl Kind {
    /// The unit; "" for what has none.
    pub fn unit(self) -> &'static str {
        if let Self::Number(unit) = self { unit } else { "" }
    }
}

const PLAIN: Kind = Kind::Number("");
const METRES: Kind = Kind::Number("m");
const DEGREES: Kind = Kind::Number("deg");
const RADIANS: Kind = Kind::Number("rad");
const SECONDS: Kind = Kind::Number("s");
const METRES_PER_SECOND: Kind = Kind::Number("m/s");
const RADIANS_PER_SECOND: Kind = Kind::Number("rad/s");
const NEWTONS: Kind = Kind::Number("N");
const NEWTON_METRES: Kind = Kind::Number("Nm");
const JOULES: Kind = Kind::Number("J");
const SQUARED_JERK: Kind = Kind::Number("m^2/s^5");

impl<Getter> Quantity<Getter> {
    /// Its key, kind and description.
    pub fn heading(&self) -> Heading {
        Heading { key: self.key, kind: self.kind, description: self.description }
    }
}

/// The headings of quantities.
pub fn headings<Getter>(quantities: &[Quantity<Getter>]) -> Vec<Heading> {
    quantities.iter().map(Quantity::heading).collect()
}

type Of<V> = Quantity<fn(&V) -> Value>;

/// The values of these quantities, by their keys.
fn read<V>(quantities: &[Of<V>], of: &V) -> Record {
    quantities.iter().map(|quantity| (quantity.key, (quantity.get)(of))).collect()
}

/// A table of quantities: key, kind, description and getter of each.
macro_rules! quantities {
    ($($key:literal, $kind:expr, $description:literal, |$view:pat_param| $get:expr;)*) => {
        &[$($crate::quantities::Quantity {
            key: $key,
            kind: $kind,
            description: $description,
            get: |$view| crate::quantities::Value::from($get),
        }),*]
    };
}
use quantities;

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// Key and kind of every quantity, with those of nested records.
    fn all() -> Vec<(&'static str, Kind)> {
        fn of<Getter>(quantities: &[Quantity<Getter>]) -> Vec<(&'static str, Kind)> {
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
            .filter_map(|(_, kind)| if let Kind::Number(unit) = kind { Some(*unit) } else { None })
            .collect();
        assert!(units.len() > 8, "{units:?}");
        for (key, kind) in all() {
            assert!(key.bytes().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == b'_'), "{key}");
            match kind {
                Kind::Number(unit) if !unit.is_empty() => {
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
