//! `cocarry regress`: records the figures of a baseline's runs, or checks them against those recorded.

use super::output::{
    Failure, OverwriteArguments, counted, examples, input, print_json, print_verdict, short_number, table,
    table_text, unwritten, write_error, write_file, xml_file,
};
use super::reproduce::Common;
use super::scenario::ScenarioArguments;
use anyhow::anyhow;
use clap::error::ContextKind;
use clap::{ArgAction, Args, CommandFactory, Parser, Subcommand};
use cocarry::scenario::Scenario;
use cocarry::suggestion::shell_word;
use cocarry_output::html::escaped;
use cocarry_output::output_file::Outputs;
use cocarry_studies::regression::{Baseline, FORMAT, Figure, Figures, Moved, Run, Value, moved, run_all};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Record costs and outcomes of runs in a file, and check whether they moved
#[derive(Debug, Subcommand)]
pub(super) enum Action {
    /// Run all runs, and write their figures into the file; the rest of the file stays as it is
    #[command(after_help = examples(&[("cocarry regress record costs.toml", "after a change that is meant")]))]
    Record(RegressArguments),
    /// Run all runs, and list the figures that differ from those recorded; exit code 1 if there are any
    #[command(after_help = examples(&[
        ("cocarry regress check costs.toml", "in continuous integration"),
        ("cocarry regress check costs.toml --junit costs.xml --github", "with reports for the server"),
    ]))]
    Check(CheckArguments),
}

/// Other forms of the report of a check, for continuous integration.
#[derive(Args, Debug)]
pub(super) struct ReportArguments {
    /// Write the report of the runs into this file, as JUnit XML
    #[arg(long, value_name = "FILE", value_parser = xml_file)]
    junit: Option<PathBuf>,
    /// Print an annotation of the baseline file for every run that moved, as GitHub Actions take them, on
    /// standard error
    #[arg(long)]
    github: bool,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

#[derive(Args, Debug)]
pub(super) struct CheckArguments {
    #[command(flatten)]
    runs: RegressArguments,
    #[command(flatten)]
    reports: ReportArguments,
}

#[derive(Args, Debug)]
pub(super) struct RegressArguments {
    /// Runs (TOML): tables [[run]] with the keys of `cocarry run`'s arguments, and [tolerance]
    file: PathBuf,
    #[command(flatten)]
    common: Common,
}

/// The arguments of a run, without the name of the program.
#[derive(Parser, Debug)]
#[command(no_binary_name = true)]
struct BaselineRunArguments {
    #[command(flatten)]
    scenario: ScenarioArguments,
}

/// Arguments that name a file. The file is first looked for next to the baseline file.
const FILES: [&str; 3] = ["world", "robot", "belief-samples"];

pub(super) fn run_regress(action: &Action) -> Result<ExitCode, Failure> {
    let (arguments, reports) = match action {
        Action::Record(arguments) => (arguments, None),
        Action::Check(CheckArguments { runs, reports }) => (runs, Some(reports)),
    };
    let baseline = Baseline::load(&arguments.file).map_err(input)?;
    let is_check = reports.is_some();
    let folder = arguments.file.parent().unwrap_or(Path::new(""));
    let scenarios = baseline.runs.iter().map(|run| scenario(&baseline.file, folder, run));
    let scenarios = scenarios.collect::<Result<Vec<_>, _>>()?;
    if let Some(run) = baseline.runs.iter().find(|run| is_check && run.recorded.is_none()) {
        let file = &baseline.file;
        let place = place(file, run.line, &run.name);
        return Err(input(anyhow!(
            "{place} has no figures yet; record them: cocarry regress record {}",
            shell_word(file)
        )));
    }
    if is_check && baseline.format < FORMAT {
        let (file, found) = (&baseline.file, baseline.format);
        return Err(input(anyhow!(
            "{file}: its figures have format {found}, which lacks some of format {FORMAT} (2 added the openings walked; 3 has all figures, with the keys of `cocarry run --json`); record them again: cocarry regress record {}",
            shell_word(file)
        )));
    }
    // the file is what `record` is about; the worlds and robots are inputs
    let read = scenarios.iter().flat_map(|scenario| {
        let robot = scenario.plant.robot_setup().map(|setup| setup.robot.texts());
        let robot = robot.into_iter().flat_map(|robot| [&robot.file, &robot.urdf_file]);
        std::iter::once(scenario.world.file()).chain(robot.map(String::as_str)).map(PathBuf::from)
    });
    let read: Vec<PathBuf> = read.collect();
    if let Some(ReportArguments { junit, overwrite, .. }) = reports {
        let inputs = read.iter().chain([&arguments.file]).map(PathBuf::as_path);
        overwrite.outputs(inputs, junit)?;
    }
    let outputs = Outputs::new(true, read);
    if !is_check {
        outputs.check(&arguments.file).map_err(unwritten)?;
    }
    let results =
        arguments.common.with_progress(scenarios.len(), "runs", |on_done| run_all(scenarios, on_done))?;
    let mut figures: Vec<Figures> = Vec::new();
    for (run, result) in baseline.runs.iter().zip(results) {
        let error = |error| anyhow::Error::new(error).context(place(&baseline.file, run.line, &run.name));
        figures.push(result.map_err(error).map_err(Failure::Input)?);
    }
    let was_recorded = |(run, _): &(&Run, &Figures)| run.recorded.is_some();
    let pairs = baseline.runs.iter().zip(&figures).filter(was_recorded);
    let found: Vec<Moved> = pairs.flat_map(|(run, now)| moved(&baseline, run, now)).collect();
    if !is_check {
        write_file(&outputs, &arguments.file, baseline.recorded(&figures).map_err(input)?)?;
    }
    if let Some(reports) = reports {
        reports.write(&baseline, &arguments.file, &found)?;
    }
    let compared = figures.iter().map(Vec::len).sum();
    match arguments.common.json {
        true => print_json(&json!({
            "runs": figures.len(),
            "figures": compared,
            "moved": found.iter().map(as_json).collect::<Vec<_>>(),
        }))?,
        false => {
            print_verdict(&text(is_check, figures.len(), compared, &found), !is_check || found.is_empty())?
        }
    }
    Ok(if is_check && !found.is_empty() { ExitCode::from(1) } else { ExitCode::SUCCESS })
}

impl ReportArguments {
    /// Writes the reports that are asked for. The names of their files are checked.
    fn write(&self, baseline: &Baseline, file: &Path, found: &[Moved]) -> Result<(), Failure> {
        let moved = |run: &Run| found.iter().filter(|moved| moved.run == run.name).map(in_words).collect();
        let runs: Vec<(&Run, Vec<String>)> = baseline.runs.iter().map(|run| (run, moved(run))).collect();
        if let Some(path) = &self.junit {
            let outputs = self.overwrite.outputs([file], [path])?;
            write_file(&outputs, path, junit(&baseline.file, &runs))?;
        }
        if self.github {
            let annotation = |(run, moved): &(&Run, Vec<String>)| {
                let [file, name] = [&baseline.file, &run.name].map(|text| percent_encoded(text, ":,"));
                let sentence = percent_encoded(&moved.join("\n"), "");
                format!("::error file={file},line={},title={name}::{sentence}\n", run.line)
            };
            write_error(
                &runs.iter().filter(|(_, moved)| !moved.is_empty()).map(annotation).collect::<String>(),
            );
        }
        Ok(())
    }
}

/// A figure that moved, in a line.
fn in_words(moved: &Moved) -> String {
    let [recorded, now] = shown_figures(moved).map(|figure| figure.unwrap_or_else(|| "none".to_owned()));
    format!("{}: recorded {recorded}, now {now}", moved.figure)
}

/// The figure as recorded and as it is now, with as many digits as show the difference.
fn shown_figures(moved: &Moved) -> [Option<String>; 2] {
    let both = [&moved.recorded, &moved.now];
    let short = |figure: &Figure| match figure.as_f64() {
        Some(number) if number.fract() != 0.0 => short_number(number),
        _ => figure.cell(),
    };
    let shortened = both.map(|figure| figure.as_ref().map(short));
    if shortened[0] != shortened[1] {
        shortened
    } else {
        both.map(|figure| figure.as_ref().map(Figure::cell))
    }
}

/// The runs as JUnit's XML: each a test, which fails where a figure moved.
fn junit(file: &str, runs: &[(&Run, Vec<String>)]) -> String {
    let case = |(run, moved): &(&Run, Vec<String>)| {
        let case = format!(
            "    <testcase classname=\"{file}\" name=\"{}\" file=\"{file}\" line=\"{}\"",
            escaped(&run.name),
            run.line,
            file = escaped(file),
        );
        match moved.is_empty() {
            true => format!("{case}/>\n"),
            false => format!(
                "{case}>\n      <failure message=\"{} moved\">{}</failure>\n    </testcase>\n",
                counted(moved.len(), "figure"),
                escaped(&moved.join("\n"))
            ),
        }
    };
    let failures = runs.iter().filter(|(_, moved)| !moved.is_empty()).count();
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n  <testsuite name=\"cocarry regress check\" tests=\"{}\" failures=\"{failures}\">\n{}  </testsuite>\n</testsuites>\n",
        runs.len(),
        runs.iter().map(case).collect::<String>()
    )
}

/// A text for an annotation, with line breaks, percent signs and these characters by their codes.
fn percent_encoded(text: &str, also: &str) -> String {
    let encoded = |c: char| match c {
        '%' | '\r' | '\n' => format!("%{:02X}", c as u32),
        _ if also.contains(c) => format!("%{:02X}", c as u32),
        _ => String::from(c),
    };
    text.chars().map(encoded).collect()
}

fn place(file: &str, line: usize, name: &str) -> String {
    format!("{file}:{line}: run `{name}`")
}

/// The scenario of a run: its keys are parsed as the arguments of `cocarry run`.
fn scenario(file: &str, folder: &Path, run: &Run) -> Result<Scenario, Failure> {
    let command = BaselineRunArguments::command();
    let mut line_of_words = Vec::new();
    for (key, value, line) in &run.arguments {
        let long = key.replace('_', "-");
        let known = command.get_arguments().find(|a| a.get_id() == key || a.get_long() == Some(&long));
        let Some(argument) = known else {
            let keys = command.get_arguments().map(|a| a.get_long().unwrap_or(a.get_id().as_str()));
            let expected = ["name"].into_iter().chain(keys.filter(|key| *key != "help"));
            let (place, expected) = (place(file, *line, &run.name), expected.collect::<Vec<_>>().join(", "));
            return Err(input(anyhow!("{place}: unknown key `{key}`; expected one of: {expected}")));
        };
        let is_flag = matches!(argument.get_action(), ArgAction::SetTrue);
        let is_repeated = matches!(argument.get_action(), ArgAction::Append);
        let word = |text: &String| match argument.is_positional() {
            true => text.clone(),
            false => format!("--{long}={text}"),
        };
        let words = match value {
            Value::Flag(is_set) if is_flag => is_set.then(|| format!("--{long}")).into_iter().collect(),
            Value::Text(text) if !is_flag => {
                let sibling = folder.join(text);
                let is_sibling = FILES.contains(&long.as_str()) && sibling.is_file();
                vec![word(&if is_sibling { sibling.display().to_string() } else { text.clone() })]
            }
            Value::List(texts) if is_repeated => texts.iter().map(word).collect(),
            Value::Flag(value) => {
                return Err(wrong(file, run, *line, key, &value.to_string(), "a number or a word in quotes"));
            }
            Value::Text(value) => return Err(wrong(file, run, *line, key, value, "true or false")),
            Value::List(texts) => {
                let expected =
                    if is_flag { "true or false" } else { "a number or a word in quotes, not a list" };
                return Err(wrong(file, run, *line, key, &format!("[{}]", texts.join(", ")), expected));
            }
        };
        line_of_words.extend(words.into_iter().map(|word: String| (word, *line)));
    }
    let words = line_of_words.iter().map(|(word, _)| word.as_str());
    let arguments = BaselineRunArguments::try_parse_from(words).map_err(|error| {
        let named = error.get(ContextKind::InvalidArg).map(ToString::to_string).unwrap_or_default();
        let option = named.split([' ', '=']).next().unwrap_or_default();
        let is_named = |word: &str| !option.is_empty() && word.split('=').next() == Some(option);
        let line = line_of_words.iter().find(|(word, _)| is_named(word)).map_or(run.line, |(_, line)| *line);
        let said = error.to_string();
        let said = said.split("\n\n").next().unwrap_or_default().trim_start_matches("error: ");
        let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
        input(anyhow!("{}: {said}", place(file, line, &run.name)))
    })?;
    if let Some(name) = arguments.scenario.custom_policy() {
        let sentence = "figures are of the program's methods only";
        return Err(input(anyhow!("{}: method = {name:?}: {sentence}", place(file, run.line, &run.name))));
    }
    arguments.scenario.scenario().map_err(|failure| match failure {
        Failure::Input(error) => Failure::Input(error.context(place(file, run.line, &run.name))),
        other => other,
    })
}

fn wrong(file: &str, run: &Run, line: usize, key: &str, value: &str, expected: &str) -> Failure {
    input(anyhow!("{}: {key} = {value}; it must be {expected}", place(file, line, &run.name)))
}

fn text(is_check: bool, runs: usize, figures: usize, found: &[Moved]) -> String {
    let done = if is_check { "checked" } else { "recorded" };
    let done = format!("{}, {} {done}", counted(runs, "run"), counted(figures, "figure"));
    if found.is_empty() {
        return format!("{done}: nothing moved.\n");
    }
    let mut shown = table(["run", "figure", "recorded", "now", "change", "may move by"], 2);
    for moved in found {
        let [recorded, after] = shown_figures(moved).map(|figure| figure.unwrap_or_else(|| "-".to_owned()));
        let [before, now] = [&moved.recorded, &moved.now].map(|f| f.as_ref().and_then(Figure::as_f64));
        let change = before.zip(now).map(|(before, now)| {
            let change = now - before;
            match before != 0.0 {
                true => format!("{} ({} %)", signed(change), signed(100.0 * change / before.abs())),
                false => signed(change),
            }
        });
        let most = before.map(|before| moved.tolerance.absolute + moved.tolerance.relative * before.abs());
        shown.add_row([
            moved.run.clone(),
            moved.figure.clone(),
            recorded,
            after,
            change.unwrap_or_else(|| "-".to_owned()),
            most.map_or("-".to_owned(), |most| format!("{most:.1e}")),
        ]);
    }
    let n = found.len();
    format!("{done}: {n} moved.\n{}", table_text(&shown))
}

/// A signed number with about three digits.
fn signed(value: f64) -> String {
    match value.abs() {
        100.0..1e6 => format!("{value:+.0}"),
        0.01..100.0 => format!("{value:+.2}"),
        _ => format!("{value:+.1e}"),
    }
}

fn as_json(moved: &Moved) -> serde_json::Value {
    json!({
        "run": moved.run,
        "figure": moved.figure,
        "recorded": moved.recorded,
        "now": moved.now,
        "relative_tolerance": moved.tolerance.relative,
        "absolute_tolerance": moved.tolerance.absolute,
    })
}
