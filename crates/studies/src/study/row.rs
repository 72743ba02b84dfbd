//! Rows of results: a column for every input and every figure of an episode, with its unit.

use super::cell::Cell;
use super::file::Contents;
use crate::table::text_cell;
use cocarry::Error;
use cocarry::episode::{Episode, Outcome};
use cocarry::error::words;
use cocarry::preference::Perception;
use cocarry::quantities::{EPISODE, Heading, QuantityKind, View};
use cocarry::scenario::{self, PlantKind, PreparedScenario, SETTINGS, Scenario, Value};

/// A column: its name, its meaning, and its value for a cell, which is `None` where the column does not apply.
type InputColumn = (&'static str, &'static str, fn(&Inputs) -> Option<String>);

/// The columns that identify rows and studies, and the CRC-32 of the row without it.
pub(super) const IDENTITY: [Heading; 5] = [
    heading("episode", QuantityKind::Count, "number of the episode in the study, from 0"),
    heading("episodes", QuantityKind::Count, "number of episodes of the whole study"),
    heading(
        "study",
        QuantityKind::Text,
        "digest of the study: of all values, worlds, robots and the program's version",
    ),
    heading("arithmetic", QuantityKind::Text, "stamp of the machine's arithmetic"),
    heading("checksum", QuantityKind::Text, "checksum of the row's values"),
];
/// The index of the checksum's column.
const CHECKSUM: usize = IDENTITY.len() - 1;

/// A combination of values.
struct Inputs<'a> {
    contents: &'a Contents,
    cell: &'a Cell,
}

/// The columns of the inputs, without the seed, the values drawn from it, and the settings.
#[rustfmt::skip]
const INPUTS: &[InputColumn] = &[
    ("world", "world, as named in the study", |r| Some(written_name(&r.contents.worlds[r.cell.world].0))),
    ("plant", "point, kinematic or rapier", |r| word(r.cell.plant.name())),
    ("humans", "name of the humans' distribution", |r| Some(written_name(&r.contents.humans[r.cell.humans].0))),
    ("humans_alpha", "distribution of alpha", |r| some(r.contents.humans[r.cell.humans].1.alpha)),
    ("humans_gamma", "distribution of gamma", |r| some(r.contents.humans[r.cell.humans].1.gamma)),
    ("preference_changes_drawn", "how many preference changes are drawn", |r| some(r.cell.changes)),
    ("belief", "name of the robot's belief", |r| Some(written_name(&r.contents.beliefs[r.cell.belief].0))),
    ("belief_alpha", "the belief's distribution of alpha; empty for samples", |r| r.belief()[0].clone()),
    ("belief_gamma", "the belief's distribution of gamma; empty for samples", |r| r.belief()[1].clone()),
    ("robot", "robot, as named in the study; empty for a point", |r| (r.cell.plant != PlantKind::Point).then(|| written_name(&r.contents.robots[r.cell.robot].0))),
    ("policy_code", "version and digest of a custom policy; empty for a method of the program", |r| r.code(0)),
    ("human_code", "version and digest of a custom human; empty for a model of the program", |r| r.code(1)),
];

/// The columns of the seed and of the values drawn from it; those of [`EPISODE`] follow.
const DRAWN: [Heading; 4] = [
    heading("seed", QuantityKind::Count, "seed of the episode"),
    heading("alpha", QuantityKind::Number(""), "the human's alpha"),
    heading("gamma", QuantityKind::Number(""), "the human's gamma"),
    heading(
        "preference_changes",
        QuantityKind::Text,
        "the changes drawn, in the form of `--change`, by step",
    ),
];

const fn heading(name: &'static str, kind: QuantityKind, description: &'static str) -> Heading {
    Heading { name, kind, description }
}

/// The names of all columns, in order.
pub(super) fn columns() -> Vec<&'static str> {
    headings().into_iter().map(|heading| heading.name).collect()
}

/// All columns, in order.
pub(super) fn headings() -> Vec<Heading> {
    let figures = EPISODE.iter().map(Heading::from);
    IDENTITY.into_iter().chain(input_headings()).chain(DRAWN).chain(figures).collect()
}

/// The columns that define a combination.
fn input_headings() -> impl Iterator<Item = Heading> {
    let of_setting = |setting: &scenario::Setting| match setting.kind {
        scenario::SettingKind::Number(unit, ..) => QuantityKind::Number(unit),
        scenario::SettingKind::Count(..) => QuantityKind::Count,
        scenario::SettingKind::Flag(_) => QuantityKind::Flag,
        scenario::SettingKind::Word(..) | scenario::SettingKind::Text(..) => QuantityKind::Text,
    };
    let inputs = INPUTS.iter().map(|(name, about, _)| heading(name, QuantityKind::Text, about));
    inputs.chain(SETTINGS.iter().map(move |setting| heading(setting.key, of_setting(setting), setting.about)))
}

/// The names of the columns that define a combination.
pub(super) fn input_columns() -> impl Iterator<Item = &'static str> {
    INPUTS.iter().map(|(name, ..)| *name).chain(SETTINGS.iter().map(|setting| setting.key))
}

/// The first line of a file of results.
pub(super) fn header() -> Vec<u8> {
    line(columns().into_iter().map(str::to_owned))
}

/// The values of a cell's input columns.
pub(super) fn inputs(contents: &Contents, cell: &Cell) -> Vec<String> {
    let inputs = Inputs { contents, cell };
    let settings = SETTINGS.iter().zip(&cell.values).map(|(setting, value)| {
        let custom = contents.partners.name_of(setting.key, cell).map(written_name);
        custom.or_else(|| value.as_ref().map(Value::to_string))
    });
    let values = INPUTS.iter().map(|(_, _, value)| value(&inputs)).chain(settings);
    values.map(Option::unwrap_or_default).collect()
}

/// A cell's inputs as a text for errors.
pub(super) fn in_words(inputs: &[String]) -> String {
    let pairs = input_columns().zip(inputs).filter(|(_, value)| !value.is_empty());
    pairs.map(|(name, value)| format!("{name} {value}")).collect::<Vec<_>>().join(", ")
}

/// The line of a file of results with these values. No cell contains a newline.
fn line(values: impl Iterator<Item = String>) -> Vec<u8> {
    line_of_cells(values.map(|value| text_cell(&value.replace(['\n', '\r'], " ")).into_owned()))
}

/// The line of a file of results with these cells, as they are.
pub fn line_of_cells(cells: impl Iterator<Item = impl AsRef<[u8]>>) -> Vec<u8> {
    let mut writer = csv::WriterBuilder::new().buffer_capacity(1024).from_writer(Vec::with_capacity(1024));
    writer.write_record(cells).expect("writing to memory does not fail");
    writer.into_inner().expect("writing to memory does not fail")
}

/// What `pandas.read_csv` reads as no value at all, by its documentation (`na_values`); R reads NA so.
const MISSING: [&str; 18] = [
    "#N/A", "#N/A N/A", "#NA", "-1.#IND", "-1.#QNAN", "-NaN", "-nan", "1.#IND", "1.#QNAN", "<NA>", "N/A",
    "NA", "NULL", "NaN", "None", "n/a", "nan", "null",
];

/// A name as it is written into rows: in one line, and `'NA'` for NA, which other programs would read as no
/// value. Different names stay different.
fn written_name(name: &str) -> String {
    let bare = name.trim_matches('\'');
    let is_taken = MISSING.contains(&bare) || bare.is_empty();
    if is_taken { format!("'{}'", one_line(name)) } else { one_line(name) }
}

/// A name in one line; different names stay different.
fn one_line(name: &str) -> String {
    let mut line = String::with_capacity(name.len());
    let mut rest = name.chars();
    while let Some(character) = rest.next() {
        match (character, rest.clone().next()) {
            ('\n', _) => line += "\\n",
            ('\r', _) => line += "\\r",
            // a backslash that would be read as part of one of these
            ('\\', Some('\n' | '\r' | 'n' | 'r' | '\\')) => line += "\\\\",
            _ => line.push(character),
        }
    }
    line
}

/// Runs an episode to its end, and returns its line of results; an empty one if it is given up. `basis` has
/// the world, the options and the robot of the scenario.
pub(super) fn of(
    identity: [String; CHECKSUM],
    inputs: Vec<String>,
    scenario: Scenario,
    basis: &PreparedScenario,
    run: Run,
) -> Vec<u8> {
    let drawn = drawn(&scenario);
    let results = match basis.prepare(scenario).and_then(|prepared| carry_out(&prepared, run)) {
        Ok(None) => return Vec::new(),
        Ok(Some(figures)) => figures,
        Err(error) => not_begun(&words(&error)),
    };
    let line = line(identity.into_iter().chain([String::new()]).chain(inputs).chain(drawn).chain(results));
    let ([begin, _, end], checksum) = split(&line).expect("a row has columns before and after its checksum");
    [begin, checksum.as_bytes(), end].concat()
}

/// The parts of a row before its checksum, the checksum, and those after it; then the checksum that its values
/// have.
fn split(line: &[u8]) -> Option<([&[u8]; 3], String)> {
    let comma = |(i, byte): (usize, &u8)| (*byte == b',').then_some(i);
    let mut commas = line.iter().enumerate().filter_map(comma).skip(CHECKSUM - 1);
    let (begin, end) = (commas.next()? + 1, commas.next()?);
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&line[..begin]);
    hasher.update(&line[end..]);
    Some(([&line[..begin], &line[begin..end], &line[end..]], format!("{:08x}", hasher.finalize())))
}

/// The checksum in the fields of a row.
pub(super) fn checksum(fields: &csv::StringRecord) -> &str {
    &fields[CHECKSUM]
}

/// The checksum of a row, and the one that its values have, if they differ.
pub(super) fn wrong_checksum(line: &[u8]) -> Option<[String; 2]> {
    let ([_, found, _], expected) = split(line)?;
    (found != expected.as_bytes()).then(|| [String::from_utf8_lossy(found).into_owned(), expected])
}

/// The seed and the values drawn from it. Preference changes have the form of `cocarry run --change`,
/// separated by spaces, by step.
fn drawn(scenario: &Scenario) -> [String; DRAWN.len()] {
    let mut changes = scenario.changes.clone();
    changes.sort_by_key(|change| change.step);
    let changes = changes.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ");
    let Perception { alpha, gamma } = scenario.human;
    [scenario.seed.to_string(), alpha.to_string(), gamma.to_string(), changes]
}

/// Makes the episode of a prepared scenario and runs it to its end; `None` if it is given up.
pub(super) type Run<'r> = &'r dyn for<'s> Fn(&'s PreparedScenario) -> Result<Option<Episode<'s>>, Error>;

/// The figures of a finished episode.
fn carry_out(prepared: &PreparedScenario, run: Run) -> Result<Option<Vec<String>>, Error> {
    let episode = run(prepared)?;
    let figures = |episode| View::new(prepared, &episode).read(EPISODE);
    let cells = |episode| figures(episode).iter().map(|(_, value)| value.cell()).collect();
    Ok(episode.map(cells))
}

/// The figures of an episode that could not begin.
fn not_begun(why: &str) -> Vec<String> {
    let value = |key| match key {
        "outcome" => "not-begun",
        "failure" => why,
        _ => "",
    };
    EPISODE.iter().map(|quantity| value(quantity.key).to_owned()).collect()
}

fn some(value: impl ToString) -> Option<String> {
    Some(value.to_string())
}

fn word(word: &str) -> Option<String> {
    Some(word.to_owned())
}

impl Inputs<'_> {
    /// The version and the digest of a custom partner.
    fn code(&self, which: usize) -> Option<String> {
        self.contents.partners.custom(which, self.cell).map(|[_, code]| code.to_owned())
    }

    fn belief(&self) -> [Option<String>; 2] {
        match &self.contents.beliefs[self.cell.belief].1 {
            cocarry::preference::Belief::Independent { alpha, gamma } => [some(alpha), some(gamma)],
            cocarry::preference::Belief::Samples(_) => [None, None],
        }
    }
}

/// The outcome that counts as success.
pub(super) fn arrived() -> &'static str {
    Outcome::Arrived.name()
}

/// The plant on which noise may change the cost of equal choices.
pub(super) fn with_bodies() -> &'static str {
    PlantKind::Rapier.name()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_as_written_differ_where_the_names_do() {
        let parts = ["\\", "\n", "\r", "n", "r", "a", " ", "'", "NA"];
        let mut lines = std::collections::BTreeMap::new();
        let mut names = vec![String::new()];
        for _ in 0..4 {
            names = names.iter().flat_map(|name| parts.map(|part| format!("{name}{part}"))).collect();
            for name in &names {
                let line = written_name(name);
                assert!(!MISSING.contains(&line.as_str()), "{line:?}");
                assert!(!line.contains(['\n', '\r']), "{line:?}");
                assert_eq!(lines.insert(line, name.clone()), None, "{name:?}");
            }
        }
        for (name, written) in [
            ("rooms/a b.toml", "rooms/a b.toml"),
            ("null", "'null'"),
            ("'NA'", "''NA''"),
            ("NA.toml", "NA.toml"),
        ] {
            assert_eq!(written_name(name), written);
        }
    }
}
