//! The choices of a scenario, from the program's tables.

use crate::robots;
use crate::state::OUTCOMES;
use cocarry::episode::Outcome;
use cocarry::human::MODELS;
use cocarry::policy::METHODS;
use cocarry::preference::Predictor;
use cocarry::scenario::{
    Applies, PERCEPTION, PlantKind, Range, SETTINGS, Scenario, Setting, SettingKind, Word,
};
use cocarry::world::BUILT_IN_WORLDS;
use cocarry::{arithmetic, bounds};
use cocarry_output::{figure, player};
use serde_json::{Value, json};

/// Worlds, robots, plants, methods, humans, settings.
pub fn catalogue() -> Value {
    let plants = PlantKind::ALL.map(PlantKind::word);
    let methods = METHODS.map(|method| (method.name, method.about));
    let humans = MODELS.map(|model| json!({ "name": model.name, "form": model.form, "about": model.about }));
    let belief = Predictor::default();
    let [alpha, gamma] = belief.belief().ranges();
    let defaults = Scenario::defaults();
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "worlds": BUILT_IN_WORLDS.iter().map(|w| json!({ "name": w.name, "text": w.text })).collect::<Vec<_>>(),
        "robots": words(&robots::names()),
        "plants": words(&plants),
        "methods": words(&methods),
        "humans": humans,
        "outcomes": OUTCOMES.map(Outcome::name),
        "settings": SETTINGS.iter().map(|setting| described(setting, &defaults)).collect::<Vec<_>>(),
        "belief": { "alpha": alpha, "gamma": gamma },
        "perception": range(&PERCEPTION),
        "max_bytes": {
            "world": bounds::WORLD.bytes(),
            "scenario": bounds::SCENARIO.bytes(),
            "log": bounds::DECISIONS.bytes(),
        },
        "measures": figure::measures(),
        "colours": player::colours(),
    })
}

/// The stamp of the arithmetic, and digests of its parts.
pub fn arithmetic() -> Value {
    let parts = arithmetic::parts().into_iter().map(|(name, digest)| (name.to_owned(), digest.into()));
    json!({ "stamp": arithmetic::stamp(), "parts": Value::Object(parts.collect()) })
}

fn words(words: &[Word]) -> Value {
    words.iter().map(|(name, about)| json!({ "name": name, "about": about })).collect()
}

fn range(range: &Range) -> Value {
    let [least, most] = range.ends();
    json!({ "least": least, "least_is_open": range.is_open(), "most": most })
}

fn described(setting: &Setting, defaults: &Scenario) -> Value {
    let mut described = match &setting.kind {
        SettingKind::Number(unit, limits, _) => {
            let mut described = range(limits);
            described["kind"] = "number".into();
            described["unit"] = (*unit).into();
            described
        }
        SettingKind::Count(most, _) => {
            json!({ "kind": "count", "least": 1, "least_is_open": false, "most": most })
        }
        SettingKind::Flag(_) => json!({ "kind": "flag" }),
        SettingKind::Word(all, _) => json!({ "kind": "word", "words": words(&all()) }),
        SettingKind::Text(..) => json!({ "kind": "text" }),
    };
    let applies = match setting.applies {
        Applies::Always => "always",
        Applies::Robot => "robot",
        Applies::Candidates => "candidates",
        Applies::Bodies => "bodies",
    };
    described["key"] = setting.key.into();
    described["flag"] = setting.flag.into();
    described["path"] = setting.path.into();
    described["group"] = setting.group.title().into();
    described["about"] = setting.about.into();
    described["applies"] = applies.into();
    described["expected"] = setting.expected().to_string().into();
    described["default"] = setting.get(defaults).map_or(Value::Null, |value| json_of(&value));
    described
}

fn json_of(value: &cocarry::scenario::Value) -> Value {
    use cocarry::scenario::Value;
    match value {
        Value::Number(number) => json!(number),
        Value::Count(count) => json!(count),
        Value::Flag(flag) => json!(flag),
        Value::Text(text) => json!(text),
    }
}
