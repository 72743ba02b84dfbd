//! A scenario from its parts, as `cocarry run` makes one of its arguments, and the command line that gives the
//! same.

use crate::robots;
use cocarry::episode::{EpisodeSettings, PreferenceChange};
use cocarry::error::{Error, Place};
use cocarry::policy::Method;
use cocarry::preference::{Belief, Marginal, Predictor, RISK_WEIGHT};
use cocarry::scenario::{
    GivenPerception, PERCEPTION, Plant, PlantKind, RobotSetup, SETTINGS, Scenario, Setting, SettingKind,
    Value,
};
use cocarry::suggestion::shell_word;
use cocarry::world::{BuiltInWorld, World};
use serde::Deserialize;
use serde_json::json;
use std::collections::BTreeMap;

/// Settings by their keys.
pub type SettingsPart = BTreeMap<String, serde_json::Value>;

/// The parts of a scenario.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parts {
    world: WorldPart,
    robot: Option<String>,
    plant: Option<String>,
    #[serde(default)]
    seed: u64,
    alpha: Option<f64>,
    gamma: Option<f64>,
    #[serde(default)]
    changes: Vec<PreferenceChange>,
    #[serde(default)]
    settings: SettingsPart,
    #[serde(default)]
    belief: BeliefPart,
}

/// A world: the name of a built-in one, or a file.
#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "the world must be the name of a built-in world, or { file, text }")]
enum WorldPart {
    Name(String),
    File { file: String, text: String },
}

/// The distributions of alpha and gamma that a belief consists of.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BeliefPart {
    alpha: Option<String>,
    gamma: Option<String>,
}

/// The predictor of these settings and this belief.
///
/// # Errors
/// A setting or a distribution is not valid.
pub fn predictor(settings: &SettingsPart, belief: &BeliefPart) -> Result<Predictor, Error> {
    let mut scenario = Scenario::defaults();
    scenario.settings.predictor = belief.predictor()?;
    for (setting, value) in given(settings)? {
        setting.set(&mut scenario, &value);
    }
    Ok(scenario.settings.predictor)
}

impl BeliefPart {
    fn predictor(&self) -> Result<Predictor, Error> {
        let Self { alpha, gamma } = self;
        let Belief::Independent { alpha: own_alpha, gamma: own_gamma } = Belief::default() else {
            return Ok(Predictor::default());
        };
        let marginal = |key: &str, given: &Option<String>, own: Marginal| match given {
            None => Ok(own),
            Some(text) => text.parse().map_err(|error: Error| {
                Error::value(Place::item("belief", key), format_args!("{text:?}")).because(error)
            }),
        };
        let (alpha, gamma) = (marginal("alpha", alpha, own_alpha)?, marginal("gamma", gamma, own_gamma)?);
        Predictor::new(Belief::Independent { alpha, gamma }, RISK_WEIGHT)
    }
}

/// The settings with their values, in the order of their table.
fn given(settings: &SettingsPart) -> Result<Vec<(&'static Setting, Value)>, Error> {
    let keys = SETTINGS.iter().map(|setting| setting.key);
    if let Some(key) = settings.keys().find(|key| !keys.clone().any(|known| known == key.as_str())) {
        return Err(Error::unknown(Place::file("settings"), "setting", key, keys, SETTINGS.len()));
    }
    let given = SETTINGS.iter().filter_map(|setting| {
        let value = settings.get(setting.key).filter(|value| !value.is_null())?;
        Some(value_of(setting, value).map(|value| (setting, value)))
    });
    given.collect()
}

fn value_of(setting: &Setting, given: &serde_json::Value) -> Result<Value, Error> {
    let value = match &setting.kind {
        SettingKind::Number(..) => given.as_f64().map(Value::Number),
        SettingKind::Count(..) => given.as_u64().map(Value::Count),
        SettingKind::Flag(_) => given.as_bool().map(Value::Flag),
        SettingKind::Word(..) | SettingKind::Text(..) => {
            given.as_str().map(|text| Value::Text(text.to_owned()))
        }
    };
    value.filter(|value| setting.accepts(value)).ok_or_else(|| {
        let expected = setting.expected();
        let hint = given.as_str().map_or(String::new(), |text| expected.hint(text));
        let place = Place::item("settings", setting.key);
        Error::value(place, format_args!("{given}; it must be {expected}{hint}"))
    })
}

impl Parts {
    fn plant_kind(&self) -> Result<PlantKind, Error> {
        let Some(name) = &self.plant else { return Ok(PlantKind::Rapier) };
        PlantKind::named(name).ok_or_else(|| {
            let known = PlantKind::ALL.map(PlantKind::name);
            Error::unknown(Place::file("the scenario"), "plant", name, known, known.len())
        })
    }

    /// The name of a robot other than the built-in one.
    fn other_robot(&self) -> Option<&str> {
        self.robot.as_deref().filter(|name| *name != robots::BUILT_IN)
    }

    fn plant(&self, settings: &[(&Setting, Value)]) -> Result<Plant, Error> {
        let kind = self.plant_kind()?;
        let idle = settings.iter().find(|(setting, _)| !setting.applies.is_on(kind, true));
        if let Some((setting, _)) = idle {
            let sentence =
                format!("needs {}, which the plant {} does not have", setting.applies.what(), kind.name());
            return Err(Error::at(Place::item("settings", setting.key), sentence));
        }
        if kind == PlantKind::Point {
            return Ok(Plant::Point);
        }
        let robot = robots::named(self.robot.as_deref().unwrap_or(robots::BUILT_IN))?;
        let setup = RobotSetup { robot: robot.clone(), ..RobotSetup::new(&*robot.robot()?) };
        Ok(Plant::new(kind, setup))
    }

    fn world(&self) -> Result<World, Error> {
        match &self.world {
            WorldPart::File { file, text } => World::parse(file, text),
            WorldPart::Name(name) => match BuiltInWorld::named(name) {
                Some(world) => World::parse(world.name, world.text),
                None => {
                    let known = cocarry::world::BUILT_IN_WORLDS.iter().map(|world| world.name);
                    Err(Error::unknown(Place::file("the scenario"), "world", name, known, usize::MAX))
                }
            },
        }
    }

    fn scenario(&self, given: &[(&'static Setting, Value)]) -> Result<Scenario, Error> {
        let world = self.world()?;
        let plant = self.plant(given)?;
        for (key, value) in [("alpha", self.alpha), ("gamma", self.gamma)] {
            if let Some(value) = value.filter(|value| !PERCEPTION.contains(*value)) {
                return Err(Error::number(Place::file("the scenario"), key, value, &PERCEPTION.to_string()));
            }
        }
        let settings = EpisodeSettings { predictor: self.belief.predictor()?, ..EpisodeSettings::default() };
        let belief = settings.predictor.belief().clone();
        let perception = GivenPerception { alpha: self.alpha, gamma: self.gamma };
        let mut scenario = Scenario::of_seed(self.seed, world.into(), plant, settings, &belief, perception);
        given.iter().for_each(|(setting, value)| setting.set(&mut scenario, value));
        scenario.changes.clone_from(&self.changes);
        Ok(scenario)
    }

    /// The command line that runs the same episode.
    fn command(&self, settings: &[(&Setting, Value)]) -> String {
        let mut words = vec!["cocarry run".to_owned()];
        words.push(shell_word(match &self.world {
            WorldPart::Name(name) => name,
            WorldPart::File { file, .. } => file,
        }));
        let mut flag = |flag: &str, value: &dyn ToString| {
            words.push(format!("--{flag} {}", shell_word(&value.to_string())));
        };
        if let Some(plant) = &self.plant {
            flag("plant", plant);
        }
        if let Some(robot) = self.other_robot() {
            flag("robot", &format!("{robot}.toml"));
        }
        self.alpha.iter().for_each(|alpha| flag("alpha", alpha));
        self.gamma.iter().for_each(|gamma| flag("gamma", gamma));
        if self.seed != 0 {
            flag("seed", &self.seed);
        }
        self.changes.iter().for_each(|change| flag("change", change));
        self.belief.alpha.iter().for_each(|alpha| flag("belief-alpha", alpha));
        self.belief.gamma.iter().for_each(|gamma| flag("belief-gamma", gamma));
        for (setting, value) in settings {
            match value {
                Value::Flag(false) => {}
                Value::Flag(true) => words.push(format!("--{}", setting.flag)),
                value => words.push(format!("--{} {}", setting.flag, shell_word(&value.to_string()))),
            }
        }
        let run = words.join(" ");
        match self.other_robot() {
            Some(robot) if self.plant.as_deref() != Some("point") => {
                format!("cocarry export {robot} && {run}")
            }
            _ => run,
        }
    }
}

/// The scenario of some parts, as text, with the command line that gives the same.
///
/// # Errors
/// A part is not valid.
pub fn scenario(parts: Parts) -> Result<serde_json::Value, Error> {
    let settings = given(&parts.settings)?;
    let prepared = parts.scenario(&settings)?.prepare()?;
    let scenario = prepared.scenario();
    let files = match &parts.world {
        WorldPart::Name(_) => Vec::new(),
        WorldPart::File { file, text } => vec![json!({ "name": file, "text": text })],
    };
    let method: Method = scenario.settings.method;
    Ok(json!({
        "scenario": scenario.text()?,
        "command": parts.command(&settings),
        "files": files,
        "alpha": scenario.human.alpha,
        "gamma": scenario.human.gamma,
        "method": method.name(),
        "warnings": ([prepared.world().warnings(), prepared.warnings()].concat()),
    }))
}
