//! The tables that are written: their columns, the dictionary of these, and the README beside them.

use crate::study::{PeopleStudy, SUBSCALES, Scale, ScaleKind};
use cocarry_studies::table::text_cell;
use std::fmt::Write;

/// A column: its name, its unit, and what it means.
pub(super) type Column = (&'static str, &'static str, &'static str);

const PARTICIPANT: Column = ("participant", "", "pseudonym; the same in all files");
const WORLD: Column = ("world", "", "built-in world, or world file relative to this folder");
const OPTION: Column = ("option", "", "name of the option in the world");

pub(super) const ANSWERS: [Column; 7] = [
    PARTICIPANT,
    WORLD,
    OPTION,
    ("percent", "%", "how likely the participant would choose the option; the options of a world sum to 100"),
    (
        "longer_and_riskier",
        "",
        "whether the option is both longer and riskier than another one: eq. (2) never prefers it",
    ),
    ("answered_s", "s", "time from the display of the map to the answer"),
    ("hidden_s", "s", "of it, while the page was not visible"),
];
pub(super) const SWITCHES: [Column; 9] = [
    PARTICIPANT,
    WORLD,
    OPTION,
    (
        "step",
        "planning steps of 0.2 s",
        "the step in which the participant asked to switch, from 0; empty: never",
    ),
    ("switched_ms", "ms", "the same as a time since the robot began to walk"),
    ("frame", "", "the number of pictures that had been shown until then"),
    ("plays", "", "how often the walk was begun: again after the page was hidden"),
    ("stalls", "", "the number of pictures that came more than 100 ms after the one before"),
    ("trial", "", "which showing of this walk it was, from 1"),
];
pub(super) const PARTICIPANTS: [Column; 13] = [
    PARTICIPANT,
    ("number", "", "the participant's number, from 1"),
    ("order", "", "the row of the Latin square, from 1"),
    ("begun_utc", "", "when the participant began, by the server's clock"),
    ("finished_utc", "", "when everything had arrived; empty: never"),
    ("consent_version", "", "the version of the consent that the participant accepted"),
    ("study_sha256", "", "digest of what the participant saw: it differs between versions of the study file"),
    ("pages_done", "", "the number of pages that the participant completed"),
    ("pages", "", "the number of all pages"),
    ("questions_right", "", "the number of questions answered rightly, in the attempts allowed"),
    (
        "left_at",
        "",
        "the page that a participant who did not finish did not complete; their answers are in no other table, unless \
         asked for",
    ),
    ("flags", "", "what to look at before the participant is used; nobody is left out for a flag"),
    (
        "eta_group",
        "planning steps of 0.2 s",
        "the eta of the study file's groups that is nearest, by ratio, to the one that `cocarry fit eta` estimates; \
         empty: no groups, or the walks do not say",
    ),
];
pub(super) const RESPONSES: [Column; 7] = [
    PARTICIPANT,
    ("page", "", "name of the scale; `question` for a question with a right answer"),
    ("item", "", "the scale's statement, or the question; `mean: ...` for a subscale"),
    (
        "answer",
        "",
        "the number on the scale, or the last answer; reversed statements are turned round in means only",
    ),
    ("right", "", "whether the answer of a question is right"),
    ("world", "", "of a scale after a carry: the world in which the participant carried"),
    ("method", "", "of a scale after a carry: the robot's method"),
];

/// The episodes in which participants carried, run again.
const CARRIES: [Column; 17] = [
    PARTICIPANT,
    WORLD,
    ("method", "", "the robot's method"),
    ("recording", "", "the episode, run again from the page's log: a file in this folder"),
    ("outcome", "", "how the episode ended"),
    ("option", "", "the option that the team walked at the end"),
    ("duration_s", "s", "simulated time of the episode"),
    ("human_led_from_s", "s", "when the participant first led; empty: never"),
    ("human_led_s", "s", "the time during which the participant led"),
    ("transitions", "", "how often the lead changed, either way"),
    ("walked_m", "m", "length of the path walked"),
    ("hand_force_mean_n", "N", "mean of the simulated human's force on the object; nobody felt it"),
    ("peak_force_n", "N", "largest simulated force in either grip"),
    (
        "differs_within_s",
        "s",
        "the second by which the episode run again differs from the page's; empty: it does not",
    ),
    ("stalls", "", "the number of pictures that came more than 100 ms after the one before"),
    ("behind_clock_s", "s", "the time by which the episode fell behind the clock"),
    (
        "options_walked",
        "",
        "the options, divided by semicolons, whose openings are those that the team went through, in this order, there and \
         back again left out; of an episode that ended earlier, those that begin so; empty: none",
    ),
];

/// A table that is being written.
pub(super) struct Table {
    name: &'static str,
    columns: &'static [Column],
    writer: csv::Writer<Vec<u8>>,
}

impl Table {
    pub fn new(name: &'static str, columns: &'static [Column]) -> Self {
        let mut table = Self { name, columns, writer: csv::Writer::from_writer(Vec::new()) };
        table.row(columns.iter().map(|column| column.0.to_owned()).collect());
        table
    }

    /// Adds a row, with no cell that a spreadsheet would take for a formula.
    pub fn row(&mut self, cells: Vec<String>) {
        debug_assert_eq!(cells.len(), self.columns.len());
        let cells: Vec<_> = cells.iter().map(|cell| text_cell(cell).into_owned()).collect();
        self.writer.write_record(&cells).expect("a table in memory is always written");
    }

    pub fn finish(self) -> (String, Vec<u8>) {
        let bytes = self.writer.into_inner().expect("a table in memory is always written");
        (self.name.to_owned(), bytes)
    }
}

/// The table of carries, whose episodes have been run again: its name and contents. A row has the cells of the
/// dictionary's columns.
pub fn carries_table(rows: impl IntoIterator<Item = [String; CARRIES.len()]>) -> (String, Vec<u8>) {
    let mut table = Table::new("carries.csv", &CARRIES);
    rows.into_iter().for_each(|row| table.row(row.into()));
    table.finish()
}

/// What every column means.
pub(super) fn dictionary(study: &PeopleStudy) -> (String, Vec<u8>) {
    const COLUMNS: [Column; 4] =
        [("file", "", ""), ("column", "", ""), ("unit", "", ""), ("meaning", "", "")];
    let mut table = Table::new("dictionary.csv", &COLUMNS);
    let files: [(&str, &[Column]); 5] = [
        ("answers.csv", &ANSWERS),
        ("switches.csv", &SWITCHES),
        ("participants.csv", &PARTICIPANTS),
        ("responses.csv", &RESPONSES),
        ("carries.csv", &CARRIES),
    ];
    for (file, columns) in files {
        for (name, unit, meaning) in columns {
            table.row([file, name, unit, meaning].map(str::to_owned).into());
        }
    }
    let fluency = study.scales.iter().filter(|scale| scale.kind == ScaleKind::Fluency);
    fluency.flat_map(subscale_rows).for_each(|row| table.row(row));
    table.finish()
}

/// What the means of a fluency scale are of: a row for each statement of a subscale.
fn subscale_rows(scale: &Scale) -> Vec<Vec<String>> {
    let unit = format!("1 to {}", scale.points);
    let row = |name: &str, (statement, is_reversed): (&str, bool)| {
        let part = if is_reversed { "reversed part" } else { "part" };
        let meaning = format!("{part} of `mean: {name}`: {statement} (after Hoffman 2019)");
        vec!["responses.csv".to_owned(), "item".to_owned(), unit.clone(), meaning]
    };
    let rows = SUBSCALES.iter().flat_map(|s| s.statements().map(|statement| row(s.name, statement)));
    rows.collect()
}

pub(super) fn readme(study: &PeopleStudy, participants: usize, left_out: &[String]) -> String {
    let people = if participants == 1 { "participant" } else { "participants" };
    let mut text = format!(
        "# {}\n\nAnswers of {participants} {people}, written by cocarry {}. Every participant has a pseudonym; who they are is in \
         none of these files.\n\n",
        study.title.replace(['\n', '\r', '#', '<', '[', '`'], " "),
        env!("CARGO_PKG_VERSION"),
    );
    text += "| file | what it has |\n| --- | --- |\n\
        | answers.csv | the percentage that each participant gave to each option of each map |\n\
        | switches.csv | the step at which each participant would have stopped following a robot that leads on an option |\n\
        | participants.csv | a row for each participant: order, times, versions, flags |\n\
        | responses.csv | answers to scales and questions |\n\
        | carries.csv, carries/ | episodes in which participants carried, if they did, run again and recorded |\n\
        | dictionary.csv | what every column means, with its unit |\n\n";
    text += "```sh\ncocarry fit risk-weight answers.csv\ncocarry fit eta switches.csv\ncocarry infer answers.csv switches.csv\n```\n\n";
    text += "The walks are those of a point along each option at 0.5 m/s, as `cocarry fit eta` takes them. Answers were given on a page: \
        they are choices and their timing. A mouse is not a beam in the hands, and nothing here measures a force on a person.\n";
    if !left_out.is_empty() {
        text += "\nLeft out:\n\n";
        for line in left_out {
            // writing to a text does not fail
            let _ = writeln!(text, "- {}", line.replace(['<', '[', '`', '\n', '\r'], " "));
        }
    }
    text
}
