//! `cocarry study power`: how many participants a study needs.

use super::PowerArguments;
use super::run::read;
use crate::output::{Failure, input, print, print_json, table_with_notes};
use crate::report_folder::{PAGE, prepare, write};
use anyhow::anyhow;
use cocarry_people::{Effect, PowerSettings, power, power_document};
use serde_json::{Map, Value, json};

pub(super) fn run_power(arguments: &PowerArguments) -> Result<(), Failure> {
    let effects = effects(&arguments.effect)?;
    let study = read(&arguments.study)?;
    if let Some(folder) = &arguments.output {
        prepare(folder, arguments.overwrite)?;
    }
    let mut participants = arguments.participants.clone();
    participants.sort_unstable();
    participants.dedup();
    let settings = PowerSettings {
        participants,
        studies: arguments.studies as usize,
        comparisons: arguments.comparisons,
        power: arguments.power,
        seed: arguments.seed,
    };
    let mut found = Vec::new();
    for effect in effects {
        let rows = arguments.common.with_progress(settings.studies, &effect.to_string(), |done| {
            power(&study, effect, &settings, done)
        })?;
        found.push((effect, rows.map_err(input)?));
    }
    let document = power_document(&study.title, &found, &settings).map_err(input)?;
    if let Some(folder) = &arguments.output {
        let made = format!("Made by cocarry {}.", env!("CARGO_PKG_VERSION"));
        let texts = [("report.md", document.markdown.clone()), (PAGE, document.page(&made))];
        write(folder, document.figures(), document.tables(), texts)?;
    }
    if arguments.common.json {
        let tables: Map<String, Value> = document.tables().map(|t| (t.name.clone(), t.json())).collect();
        return print_json(&json!({ "studies": settings.studies, "seed": settings.seed, "tables": tables }));
    }
    let shown: Vec<String> = document.tables().map(table_with_notes).collect();
    let page = arguments.output.iter().map(|folder| format!("\nopen {}\n", folder.join(PAGE).display()));
    print(&(shown.join("\n") + &page.collect::<String>()))
}

/// The effects, each kind once.
fn effects(texts: &[String]) -> Result<Vec<Effect>, Failure> {
    let mut effects: Vec<Effect> = Vec::new();
    for text in texts {
        let effect: Effect = text.parse().map_err(|fault| input(anyhow!("--effect {text}: {fault}")))?;
        let is_same = |other: &Effect| std::mem::discriminant(other) == std::mem::discriminant(&effect);
        if effects.iter().any(is_same) {
            return Err(input(anyhow!("--effect {text}: a second one of this kind; give each kind once")));
        }
        effects.push(effect);
    }
    Ok(effects)
}
