//! A setting of an episode: its key, words and range, and its field in a scenario.

use super::word::{Word, one_of};
use super::{PlantKind, Scenario};
use crate::suggestion::Expected;
use std::fmt;

/// A setting of an episode.
#[derive(Debug)]
pub struct Setting {
    /// Its key in studies and their results, with the unit.
    pub key: &'static str,
    /// Its name on the command line, without the dashes.
    pub flag: &'static str,
    /// Its key in a scenario's text, with the tables around it.
    pub path: &'static str,
    /// The part of the help and of the documentation that it belongs to.
    pub group: SettingGroup,
    /// Its help text, with its unit.
    pub about: &'static str,
    /// The teams to which it applies.
    pub applies: Applies,
    /// Its values, and its field in a scenario.
    pub kind: SettingKind,
}

/// The part of the help that a setting belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SettingGroup {
    /// The human.
    Human,
    /// The robot and the plant.
    Robot,
    /// The method, and how it weighs risk.
    Method,
    /// How the team walks.
    Walk,
    /// The robot's controller.
    Control,
    /// The physical plant.
    Physics,
}

impl SettingGroup {
    /// Its title.
    pub const fn title(self) -> &'static str {
        match self {
            Self::Human => "Human",
            Self::Robot => "Robot and plant",
            Self::Method => "Method",
            Self::Walk => "Walk",
            Self::Control => "Robot's controller",
            Self::Physics => "Physics",
        }
    }
}

/// The teams to which a setting applies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Applies {
    /// Every team.
    Always,
    /// A robot.
    Robot,
    /// A robot that chooses among configurations.
    Candidates,
    /// A human with a body.
    Bodies,
}

/// The values of a setting, and its field in a scenario.
#[derive(Debug)]
pub enum SettingKind {
    /// A number with its unit ("" if it has none), in a range.
    Number(&'static str, Range, Field<f64>),
    /// A whole number from 1 to a limit.
    Count(u64, Field<Option<u64>>),
    /// True or false.
    Flag(Field<bool>),
    /// One of several words.
    Word(fn() -> Vec<Word>, Field<String>),
    /// A text: the form to name in errors, and a check.
    Text(fn() -> Expected, fn(&str) -> bool, Field<String>),
}

/// A field of a scenario: a getter, which returns `None` if the scenario does not have the field, and a
/// setter.
#[derive(Debug)]
pub struct Field<T> {
    pub(super) get: fn(&Scenario) -> Option<T>,
    pub(super) set: fn(&mut Scenario, T),
}

/// The value of a setting.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Of [`SettingKind::Number`].
    Number(f64),
    /// Of [`SettingKind::Count`].
    Count(u64),
    /// Of [`SettingKind::Flag`].
    Flag(bool),
    /// Of [`SettingKind::Word`] and [`SettingKind::Text`].
    Text(String),
}

/// A range of numbers from `least`, or above it, to `most`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    least: f64,
    is_open: bool,
    most: f64,
}

impl Setting {
    /// Its value in a scenario; `None` if the scenario does not have the setting.
    pub fn get(&self, scenario: &Scenario) -> Option<Value> {
        match &self.kind {
            SettingKind::Number(.., field) => (field.get)(scenario).map(Value::Number),
            SettingKind::Count(_, field) => (field.get)(scenario)?.map(Value::Count),
            SettingKind::Flag(field) => (field.get)(scenario).map(Value::Flag),
            SettingKind::Word(_, field) | SettingKind::Text(.., field) => {
                (field.get)(scenario).map(Value::Text)
            }
        }
    }

    /// Sets it in a scenario to a value that it [accepts](Setting::accepts). No effect if the scenario does
    /// not have the setting.
    pub fn set(&self, scenario: &mut Scenario, value: &Value) {
        match (&self.kind, value) {
            (SettingKind::Number(.., field), Value::Number(value)) => (field.set)(scenario, *value),
            (SettingKind::Count(_, field), Value::Count(value)) => (field.set)(scenario, Some(*value)),
            (SettingKind::Flag(field), Value::Flag(value)) => (field.set)(scenario, *value),
            (SettingKind::Word(_, field) | SettingKind::Text(.., field), Value::Text(text)) => {
                (field.set)(scenario, text.clone());
            }
            _ => {}
        }
    }

    /// Whether the value is allowed.
    pub fn accepts(&self, value: &Value) -> bool {
        match (&self.kind, value) {
            (SettingKind::Number(_, range, _), Value::Number(value)) => range.contains(*value),
            (SettingKind::Count(most, _), Value::Count(value)) => (1..=*most).contains(value),
            (SettingKind::Flag(_), Value::Flag(_)) => true,
            (SettingKind::Word(words, _), Value::Text(text)) => words().iter().any(|(word, _)| word == text),
            (SettingKind::Text(_, accepts, _), Value::Text(text)) => accepts(text),
            _ => false,
        }
    }

    /// Its words; `None` if its values are not words.
    pub fn words(&self) -> Option<Vec<Word>> {
        if let SettingKind::Word(words, _) = &self.kind { Some(words()) } else { None }
    }

    /// A description of the allowed values, for errors.
    pub fn expected(&self) -> Expected {
        match &self.kind {
            SettingKind::Number(_, range, _) => range.to_string().into(),
            SettingKind::Count(most, _) => format!("a whole number from 1 to {most}").into(),
            SettingKind::Flag(_) => "true or false".into(),
            SettingKind::Word(words, _) => one_of(&words()),
            SettingKind::Text(form, ..) => form(),
        }
    }

    /// The value in a text, as [`Value`] is displayed.
    ///
    /// # Errors
    /// A description of the allowed values, if the text is not one of them.
    pub fn parse(&self, text: &str) -> Result<Value, String> {
        let value = match &self.kind {
            SettingKind::Number(..) => text.parse().ok().map(Value::Number),
            SettingKind::Count(..) => text.parse().ok().map(Value::Count),
            SettingKind::Flag(_) => text.parse().ok().map(Value::Flag),
            SettingKind::Word(..) | SettingKind::Text(..) => Some(Value::Text(text.to_owned())),
        };
        value.filter(|value| self.accepts(value)).ok_or_else(|| {
            let expected = self.expected();
            format!("must be {expected}{}", expected.hint(text))
        })
    }

    /// The value in a scenario, if it is a number out of range.
    pub(super) fn number_out_of_range(&self, scenario: &Scenario) -> Option<f64> {
        match self.get(scenario).filter(|value| !self.accepts(value))? {
            Value::Number(value) => Some(value),
            Value::Count(count) => Some(count as f64),
            Value::Flag(_) | Value::Text(_) => None,
        }
    }
}

impl Applies {
    /// Whether it applies to a team on that plant. `chooses`: whether the team's robot, if any, chooses among
    /// configurations.
    pub fn is_on(self, plant: PlantKind, chooses: bool) -> bool {
        match self {
            Self::Always => true,
            Self::Robot => plant != PlantKind::Point,
            Self::Candidates => plant != PlantKind::Point && chooses,
            Self::Bodies => plant == PlantKind::Rapier,
        }
    }

    /// The parts that the setting needs, for errors.
    pub fn what(self) -> &'static str {
        match self {
            Self::Always => "a team",
            Self::Robot | Self::Candidates => "a robot",
            Self::Bodies => "a human's body",
        }
    }
}

impl Range {
    pub(super) const fn between(least: f64, most: f64) -> Self {
        Self { least, is_open: false, most }
    }

    pub(super) const fn of([least, most]: [f64; 2]) -> Self {
        Self::between(least, most)
    }

    pub(super) const fn above(least: f64, most: f64) -> Self {
        Self { least, is_open: true, most }
    }

    /// The least number, or the one that all are above if [`Range::is_open`], and the largest.
    pub fn ends(&self) -> [f64; 2] {
        [self.least, self.most]
    }

    /// Whether the least end is not in the range itself.
    pub fn is_open(&self) -> bool {
        self.is_open
    }

    /// Whether the number is in the range; NaN is not.
    pub fn contains(&self, value: f64) -> bool {
        value <= self.most && if self.is_open { value > self.least } else { value >= self.least }
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { least, is_open, most } = self;
        match is_open {
            true => write!(f, "a number greater than {least} and at most {most}"),
            false => write!(f, "a number from {least} to {most}"),
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Number(value) => value.fmt(f),
            Self::Count(count) => count.fmt(f),
            Self::Flag(flag) => flag.fmt(f),
            Self::Text(text) => text.fmt(f),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::SETTINGS;

    #[test]
    fn a_key_ends_in_the_unit_that_its_setting_declares() {
        let suffix = |unit: &str| format!("_{}", unit.to_lowercase().replace('/', "_per_").replace('^', ""));
        let unit =
            |setting: &Setting| if let SettingKind::Number(unit, ..) = setting.kind { unit } else { "" };
        for setting in SETTINGS {
            let unit = unit(setting);
            match unit {
                "" => {
                    let ends = ["_m", "_s", "_hz"].iter().any(|end| setting.key.ends_with(end));
                    assert!(!ends, "{} has a unit", setting.key);
                }
                unit => assert!(setting.key.ends_with(&suffix(unit)), "{}: {unit}", setting.key),
            }
        }
        let stiffness = SETTINGS.iter().find(|setting| setting.key == "hand_stiffness_n_per_m");
        assert_eq!(stiffness.map(unit), Some("N/m"));
    }
}
