//! The pages of the book that are written from the program's tables: commands, settings, columns.

use super::{read, settle};
use cocarry::quantities::{
    BASE, CONTROL, COORDINATION, COST, EPISODE, INTERACTION, JOINTS, OPTION, OPTIONS, PREPARATION, Quantity,
    QuantityKind, STEP, TIME,
};
use cocarry::scenario::{Applies, SETTINGS, Scenario};
use std::process::Command;

/// The first lines of a page.
fn heading(title: &str, about: &str) -> String {
    format!(
        "<!-- Written by tests/suite/book/reference.rs from the program's tables. -->\n\n# {title}\n\n{about}\n"
    )
}

fn row(cells: &[&str]) -> String {
    let cells: Vec<String> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
    format!("| {} |\n", cells.join(" | "))
}

fn table(titles: &[&str]) -> String {
    format!("\n{}{}", row(titles), row(&vec!["---"; titles.len()]))
}

#[test]
fn the_reference_of_commands_is_the_help_of_the_program() {
    let mut text = heading(
        "Commands",
        "Every command prints this text with `--help`. Without a command, `cocarry` runs the example of the paper's\nEnvironment 4.",
    );
    let mut program = cocarry_program::command();
    program.build();
    add_help(&program, &mut text);
    settle("book/src/commands.md", &read("book/src/commands.md"), &text);
}

/// Adds the help of a command and of the commands below it.
fn add_help(command: &clap::Command, text: &mut String) {
    let name = command.get_bin_name().unwrap_or("cocarry");
    let help = command.clone().term_width(100).render_long_help().to_string();
    *text += &format!("\n## {name}\n\n```text\n{}\n```\n", super::lines(&help).join("\n"));
    for below in command.get_subcommands().filter(|below| below.get_name() != "help") {
        add_help(below, text);
    }
}

#[test]
fn the_reference_of_settings_is_the_table_of_settings() {
    let mut text = heading(
        "Settings",
        "Every setting of an episode is an option of `cocarry run`, a key of [studies](studies.md) and of\n[baselines](regression.md) (there by the name of the option), and a column of a study's rows.",
    );
    text += &table(&["key of studies, column", "option", "values", "default", "needs", "meaning"]);
    let defaults = Scenario::defaults();
    for setting in SETTINGS {
        let needs = match setting.applies {
            Applies::Always => "",
            Applies::Robot => "a robot",
            Applies::Candidates => "a robot with pose optimisation",
            Applies::Bodies => "the physical plant",
        };
        let default = setting.get(&defaults).map_or(String::new(), |value| value.to_string());
        let (key, option) = (format!("`{}`", setting.key), format!("`--{}`", setting.flag));
        text += &row(&[&key, &option, &setting.expected().to_string(), &default, needs, setting.about]);
    }
    text += "\nA setting without a default in the table says in its meaning what is taken.\n";
    settle("book/src/settings.md", &read("book/src/settings.md"), &text);
}

/// Groups of the quantities of a step: heading, channel of recordings, quantities.
const STEPS: [(&str, &str, &[Quantity]); 9] = [
    ("Step", "every channel of JSON", STEP),
    ("Time", "the time stamp of every message", TIME),
    ("Coordination", "`/coordination`", COORDINATION),
    ("Cost", "`/cost`", COST),
    ("Control", "`/control`", CONTROL),
    ("Omnidirectional base", "`/base`", BASE),
    ("Interaction", "`/interaction`", INTERACTION),
    ("Options", "`/options`", OPTIONS),
    ("Joints", "`/control`", JOINTS),
];

#[test]
fn the_reference_of_columns_is_the_table_of_quantities() {
    let mut text = heading(
        "Columns",
        "A quantity has one name everywhere: in `--ticks`, in `--json`, in the channels of [recordings](recordings.md), in the rows\nof [studies](studies.md) and in [baselines](regression.md). A name ends in its unit. What does not apply is empty in CSV, null in JSON and left\nout of recordings. Symbols are those of [the model](model.md).",
    );
    text += "\n## Columns of a step\n\nOne row per planning step: `cocarry run --ticks FILE.csv`, or `.jsonl`. Recordings have the same in their channels.\n";
    for (title, channel, quantities) in STEPS {
        text += &format!("\n### {title}\n\nIn recordings: {channel}.\n");
        text += &listed(quantities);
        if title == "Options" {
            text += "\nFor each option; in CSV, `length_m[NAME]` is the length of option NAME:\n";
            text += &listed(OPTION);
        }
    }
    text += "\n### Preparation\n\nIn recordings only: `/preparation`.\n";
    text += &listed(PREPARATION);
    text += "\n## Columns of an episode\n\nIn `cocarry run --json`, in the rows of studies, in baselines and in the channel `/outcome`.\n";
    text += &listed(EPISODE);
    text += "\n## Further columns of a study's rows\n\nBefore the figures of the episode, a row has these and a column for every [setting](settings.md).\n";
    text += &table(&["column", "meaning"]);
    let is_listed = |name: &str| {
        SETTINGS.iter().any(|setting| setting.key == name) || EPISODE.iter().any(|figure| figure.key == name)
    };
    for heading in cocarry_studies::study::columns().iter().filter(|heading| !is_listed(heading.name)) {
        text += &row(&[&format!("`{}`", heading.name), heading.description]);
    }
    settle("book/src/columns.md", &read("book/src/columns.md"), &text);
}

/// A table of quantities, with the fields of nested records.
fn listed<Getter>(quantities: &[Quantity<Getter>]) -> String {
    let mut text = table(&["column", "unit", "meaning"]);
    for quantity in quantities {
        let (unit, fields) = match quantity.kind {
            QuantityKind::Number(unit) => (unit, None),
            QuantityKind::Count => ("whole number", None),
            QuantityKind::Text => ("text", None),
            QuantityKind::Flag => ("true or false", None),
            QuantityKind::Numbers => ("list of numbers", None),
            QuantityKind::Record(fields) => ("record", Some(fields())),
            QuantityKind::List(fields) => ("list of records", Some(fields())),
        };
        text += &row(&[&format!("`{}`", quantity.key), unit, quantity.description]);
        // those of options have a table of their own
        let fields = fields.filter(|_| quantity.key != "options");
        for field in fields.into_iter().flatten() {
            let unit = match field.kind {
                QuantityKind::Number("") => "number",
                QuantityKind::Number(unit) => unit,
                QuantityKind::Count => "integer",
                QuantityKind::Text => "string",
                QuantityKind::Flag => "boolean",
                QuantityKind::Numbers | QuantityKind::List(_) => "array",
                QuantityKind::Record(_) => "object",
            };
            text += &row(&[&format!("`{}.{}`", quantity.key, field.name), unit, field.description]);
        }
    }
    text
}

#[test]
fn the_reference_of_columns_has_every_column_of_a_study() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("s.toml"),
        "worlds = \"environment-1\"\nplants = \"point\"\nseeds = 1\n",
    )
    .unwrap();
    let mut program = Command::new(env!("CARGO_BIN_EXE_cocarry"));
    let output = program.args(["sweep", "s.toml"]).current_dir(folder.path()).output().unwrap();
    assert!(output.status.success());
    let rows = std::fs::read_to_string(folder.path().join("s.csv")).unwrap();
    let page = read("book/src/columns.md") + &read("book/src/settings.md");
    let mut columns = rows.lines().next().unwrap().split(',');
    assert_eq!(columns.clone().count(), cocarry_studies::study::columns().len());
    assert_eq!(columns.find(|column| !page.contains(&format!("| `{column}` |"))), None);
}
