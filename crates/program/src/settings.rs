//! The command-line arguments of the table of settings: one for each, with its words, range and default.

use super::custom;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use cocarry::scenario::{
    AVOID, PERIOD, PlantKind, SETTINGS, Scenario, Setting, SettingGroup, SettingKind, Value,
};
use std::borrow::Cow;

/// The key of the setting of the robot's method.
const METHOD: &str = "method";
/// A flag that means `--avoid nothing`.
const NO_OBSTACLES: &str = "no-obstacles";

/// The settings given on the command line.
#[derive(Clone, Debug)]
pub(super) struct SettingArguments {
    given: Vec<(&'static Setting, &'static str, Value)>,
    /// The custom policy that takes the place of a method.
    pub custom_policy: Option<String>,
}

impl SettingArguments {
    /// Applies the given settings to a scenario.
    pub fn apply(&self, scenario: &mut Scenario) {
        self.given.iter().for_each(|(setting, _, value)| setting.set(scenario, value));
    }

    /// The value given for a setting.
    pub fn given(&self, setting: &Setting) -> Option<&Value> {
        self.given.iter().find(|(other, ..)| other.key == setting.key).map(|(_, _, value)| value)
    }

    /// The first argument that does not apply on the plant: its flag and its setting.
    pub fn idle(&self, plant: PlantKind) -> Option<(&'static str, &'static Setting)> {
        let idle = self.given.iter().find(|(setting, ..)| !setting.applies.is_on(plant, true));
        idle.map(|(setting, flag, _)| (*flag, *setting))
    }
}

impl Args for SettingArguments {
    fn augment_args(command: Command) -> Command {
        let no_obstacles = Arg::new("no_obstacles")
            .long(NO_OBSTACLES)
            .action(ArgAction::SetTrue)
            .help_heading(SettingGroup::Control.title())
            .conflicts_with("avoid")
            .help("Leave obstacles out of the robot's MPC, as the paper does; the same as --avoid nothing");
        let defaults = Scenario::defaults();
        let [_, period, instead] = PERIOD;
        let period = Arg::new(period).long(period).hide(true).allow_negative_numbers(true);
        let period = period.value_parser(move |_: &str| Err::<f64, _>(format!("must be {instead}")));
        let settings = SETTINGS.iter().map(|setting| argument(setting, &defaults));
        command.args(settings).arg(no_obstacles).arg(period)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for SettingArguments {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let value = |setting: &'static Setting| {
            let value = match setting.kind {
                SettingKind::Flag(_) => matches.get_flag(setting.key).then_some(Value::Flag(true)),
                _ => matches.get_one(setting.key).cloned(),
            };
            Some((setting, setting.flag, value?))
        };
        let mut given: Vec<_> = SETTINGS.iter().filter_map(value).collect();
        if matches.get_flag("no_obstacles") {
            given.push((&AVOID, NO_OBSTACLES, Value::Text("nothing".to_owned())));
        }
        let is_custom = |(setting, _, value): &(&Setting, &str, Value)| {
            setting.key == METHOD && custom::has(&value.to_string())
        };
        let at = given.iter().position(is_custom);
        let custom_policy = at.map(|at| given.remove(at).2.to_string());
        Ok(Self { given, custom_policy })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

fn argument(setting: &'static Setting, defaults: &Scenario) -> Arg {
    let argument = Arg::new(setting.key).long(setting.flag).help_heading(setting.group.title());
    let default = match setting.get(defaults) {
        Some(Value::Flag(_)) => return argument.action(ArgAction::SetTrue).help(setting.about),
        Some(value) => Cow::Owned(format!(" [default: {value}]")),
        None => Cow::Borrowed(""),
    };
    let value = match setting.kind {
        SettingKind::Number(..) => "NUMBER",
        SettingKind::Count(..) => "COUNT",
        SettingKind::Text(..) => "TEXT",
        SettingKind::Word(..) | SettingKind::Flag(_) => "WORD",
    };
    let argument = argument.value_name(value).allow_negative_numbers(true);
    let argument = argument.help(format!("{}{default}", setting.about));
    match setting.words() {
        None => argument.value_parser(|text: &str| setting.parse(text)),
        Some(words) if setting.key == METHOD => {
            argument.value_parser(named(words.into_iter().chain(custom::list())).map(Value::Text))
        }
        Some(words) => argument.value_parser(named(words).map(Value::Text)),
    }
}

/// A parser of the name of a method or a custom policy.
pub(super) fn methods() -> PossibleValuesParser {
    named(method_words().chain(custom::list()))
}

/// A parser that accepts the methods of the program alone.
pub(super) fn built_in_methods() -> PossibleValuesParser {
    named(method_words())
}

/// The methods of the program, each with a sentence about it.
fn method_words() -> impl Iterator<Item = (&'static str, &'static str)> {
    let methods = SETTINGS.iter().find(|setting| setting.key == METHOD).and_then(Setting::words);
    methods.into_iter().flatten()
}

/// A parser that accepts one of several words.
pub(super) fn named(words: impl IntoIterator<Item = (&'static str, &'static str)>) -> PossibleValuesParser {
    PossibleValuesParser::new(words.into_iter().map(|(word, about)| PossibleValue::new(word).help(about)))
}

/// A parser that accepts the name of one of `plants`.
pub(super) fn plants(plants: &[PlantKind]) -> impl TypedValueParser<Value = PlantKind> + use<> {
    named(plants.iter().map(|plant| plant.word()))
        .try_map(|name| PlantKind::named(&name).ok_or("unknown plant"))
}

/// A parser of a setting's number, for commands without the other settings.
pub(super) fn number(setting: &'static Setting) -> impl Fn(&str) -> Result<f64, String> + Clone {
    |text| match setting.parse(text)? {
        Value::Number(number) => Ok(number),
        _ => Err("must be a number".to_owned()),
    }
}
