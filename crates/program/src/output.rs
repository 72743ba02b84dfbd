//! Output of commands: text, tables, files, and a progress bar that is hidden in a pipe.

use super::terminal::{self, ATTENTION, BAD, GOOD, Text};
use super::text_table::TextTable;
use anstyle::Style;
use anyhow::{Context, Error, anyhow};
use clap::Args;
use cocarry::coordination::OptionTick;
use cocarry::quantities::{Fields, OptionView};
use cocarry_output::output_file::{OutputError, Outputs};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::json;
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

/// The reason why a command stopped, which gives the exit code.
pub(super) enum Failure {
    /// The input is wrong.
    Input(Error),
    /// An output could not be written.
    Output(Error),
    /// A signal stopped it; it can go on.
    Interrupted(Error),
}

/// An error in the input.
pub(super) fn input(error: impl Into<Error>) -> Failure {
    Failure::Input(error.into())
}

/// Text without control characters, which a terminal would obey, or by which it would show the rest in another
/// order: names in it come from files. Each is written as JSON writes it. Newlines and tabs stay.
pub(super) fn visible(text: &str) -> Cow<'_, str> {
    let is_direction = |c| matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{206f}');
    // two names that look the same
    let is_unseen = |c| matches!(c, '\u{ad}' | '\u{200b}' | '\u{2060}'..='\u{2065}' | '\u{feff}' | '\u{e0000}'..='\u{e007f}');
    let is_obeyed = |c: char| c.is_control() && !matches!(c, '\n' | '\t') || is_direction(c) || is_unseen(c);
    if !text.contains(is_obeyed) {
        return Cow::Borrowed(text);
    }
    let escaped = |c: char| c.encode_utf16(&mut [0; 2]).iter().map(|unit| format!("\\u{unit:04x}")).collect();
    let shown = |c: char| if is_obeyed(c) { escaped(c) } else { String::from(c) };
    Cow::Owned(text.chars().map(shown).collect())
}

/// Prints text, which ends with a newline: in the terminal's width and with its colours, if it is one.
pub(super) fn print(text: &str) -> Result<(), Failure> {
    let mut plain = Text::default();
    plain.plain(text);
    print_text(&plain)
}

/// As [`print()`], with the first line as a good or a bad verdict.
pub(super) fn print_verdict(text: &str, is_good: bool) -> Result<(), Failure> {
    print_text(&Text::headed(if is_good { GOOD } else { BAD }, text))
}

/// As [`print()`], for text that has styles.
pub(super) fn print_text(text: &Text) -> Result<(), Failure> {
    write_out(&text.shown(terminal::width(), |text| visible(text).into_owned()))
}

/// Prints text for programs, which is neither wrapped nor coloured.
pub(super) fn print_for_programs(text: &str) -> Result<(), Failure> {
    write_out(&visible(text))
}

/// What errors call standard output.
const STANDARD_OUTPUT: &str = "standard output";

fn write_out(text: &str) -> Result<(), Failure> {
    // removes colours in a pipe, and with NO_COLOR
    let mut out = anstream::stdout().lock();
    out.write_all(text.as_bytes())
        .and_then(|()| out.flush())
        .context(STANDARD_OUTPUT)
        .map_err(Failure::Output)
}

/// Prints a value as JSON.
pub(super) fn print_json(value: &serde_json::Value) -> Result<(), Failure> {
    print_for_programs(&format!("{value:#}\n"))
}

/// Whether an error is that the reader of standard output has closed it, as `head` does.
pub(super) fn is_closed_output(error: &Error) -> bool {
    let io = error.downcast_ref::<std::io::Error>();
    error.to_string() == STANDARD_OUTPUT && io.is_some_and(|e| e.kind() == std::io::ErrorKind::BrokenPipe)
}

/// The failure to write a file: bad input where the name is wrong.
pub(super) fn unwritten(error: OutputError) -> Failure {
    if error.is_refusal() { input(error) } else { Failure::Output(error.into()) }
}

/// Whether files that exist may be replaced.
#[derive(Args, Clone, Copy, Debug)]
pub(super) struct OverwriteArguments {
    /// Replace existing output files. Inputs, links and special files are never replaced
    #[arg(long)]
    pub overwrite: bool,
}

impl OverwriteArguments {
    /// The rule for the output files of a command that reads `inputs`. The files are checked before the work,
    /// since an error afterwards would lose its results.
    pub fn outputs<'a>(
        self,
        inputs: impl IntoIterator<Item = &'a Path>,
        files: impl IntoIterator<Item = &'a PathBuf>,
    ) -> Result<Outputs, Failure> {
        let outputs = Outputs::new(self.overwrite, inputs.into_iter().map(Path::to_owned));
        let mut names: Vec<&PathBuf> = Vec::new();
        for file in files {
            outputs.check(file).map_err(unwritten)?;
            // a recording begins before the work
            if !has_extension(file, "mcap") {
                Outputs::check_folder(file).map_err(unwritten)?;
            }
            if names.contains(&file) {
                return Err(input(anyhow!(
                    "{}: duplicate output file; choose different names",
                    file.display()
                )));
            }
            names.push(file);
        }
        Ok(outputs)
    }
}

/// Writes a whole file.
pub(super) fn write_file(outputs: &Outputs, path: &Path, contents: impl AsRef<[u8]>) -> Result<(), Failure> {
    outputs.write(path, contents).map_err(unwritten)
}

/// The headings of a table of options. J~ is the mean subjective cost over the robot's belief, in cost units
/// (eq. (2) adds m^alpha and m).
pub(super) const OPTION_HEADINGS: [&str; 7] =
    ["option", "openings", "D (m)", "risk S", "cost J (m)", "belief's mean J~", "P (%)"];

/// An option as JSON: its quantities and its openings.
pub(super) fn option_json(
    name: &str,
    openings: &[impl AsRef<str>],
    option: &OptionTick,
) -> serde_json::Value {
    let mut fields = json!(OptionView { name, option }.read().into_iter().collect::<Fields>());
    fields["openings"] = openings.iter().map(AsRef::as_ref).collect();
    fields
}

/// The largest number of characters of a line on standard error: TOML's errors repeat the line of the file.
const MAX_LINE: usize = 4000;

/// The largest width of a line that an error of TOML quotes from a file, characters.
const MAX_QUOTED: usize = 80;

/// Prints a message for people on standard error.
pub(super) fn print_message(message: &str) {
    let mut text = Text::default();
    text.plain(message);
    print_on_error(&text);
}

/// Prints an error.
pub(super) fn print_error(error: &impl std::fmt::Display) {
    let width = terminal::error_width().map_or(MAX_QUOTED, |width| width.min(MAX_QUOTED));
    let text = with_short_quotes(&format!("error: {error}"), width);
    print_on_error(&Text::headed(BAD, &text));
}

/// The text with the lines that it quotes from files, as in `12 | text`, cut to a width: what is marked in the
/// line below a quoted one stays in sight.
fn with_short_quotes(text: &str, width: usize) -> String {
    let mut lines: Vec<Cow<str>> = text.split('\n').map(Cow::Borrowed).collect();
    for at in 0..lines.len() {
        let line = lines[at].clone();
        let Some((number, quoted)) = line.split_once(" | ") else { continue };
        let is_number = !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit());
        let quoted: Vec<char> = quoted.chars().collect();
        let gutter = number.len() + 3;
        let room = width.saturating_sub(gutter);
        if !is_number || room < 2 || quoted.len() <= room {
            continue;
        }
        let below = lines.get(at + 1).filter(|line| line.trim_start().starts_with("| "));
        let marks: Vec<char> = below.map(|line| line.chars().collect()).unwrap_or_default();
        let marked = marks.iter().position(|mark| *mark == '^').map_or(0, |mark| mark.saturating_sub(gutter));
        let first = if marked < room / 2 { 0 } else { (marked - room / 2).min(quoted.len() - room) };
        let mut shown = quoted[first..first + room].to_vec();
        if first > 0 {
            shown[0] = '…';
        }
        if first + room < quoted.len() {
            shown[room - 1] = '…';
        }
        lines[at] = format!("{number} | {}", String::from_iter(shown)).into();
        if !marks.is_empty() {
            let below = marks.iter().skip(gutter + first).take(room);
            lines[at + 1] = marks.iter().take(gutter).chain(below).collect::<String>().into();
        }
    }
    lines.join("\n")
}

fn print_on_error(text: &Text) {
    write_error(&text.shown(terminal::error_width(), of_bounded_lines));
}

/// Writes text to standard error. If that is closed, there is nobody to tell.
pub(super) fn write_error(text: &str) {
    let _ = anstream::stderr().lock().write_all(text.as_bytes());
}

/// Visible text whose lines are cut, and end.
fn of_bounded_lines(text: &str) -> String {
    let text = visible(text);
    let cut = text.lines().map(|line| match line.char_indices().nth(MAX_LINE) {
        None => format!("{line}\n"),
        Some((end, _)) => format!("{}…\n", &line[..end]),
    });
    cut.collect()
}

/// A number with its noun, which gets an s unless the number is 1.
pub(super) fn counted(number: impl TryInto<u64>, noun: &str) -> String {
    let number = number.try_into().unwrap_or(u64::MAX);
    format!("{number} {noun}{}", if number == 1 { "" } else { "s" })
}

/// A number with at most seven significant digits, for people.
pub(super) fn short_number(number: f64) -> String {
    let rounded: f64 = format!("{number:.6e}").parse().unwrap_or(number);
    match rounded == 0.0 || (1e-5..1e12).contains(&rounded.abs()) {
        true => rounded.to_string(),
        false => format!("{rounded:e}"),
    }
}

/// Whether warnings, notes and progress are left out.
static IS_QUIET: AtomicBool = AtomicBool::new(false);

/// Leaves warnings, notes and progress out, or not.
pub(super) fn be_quiet(is_quiet: bool) {
    IS_QUIET.store(is_quiet, Ordering::Relaxed);
}

fn is_quiet() -> bool {
    IS_QUIET.load(Ordering::Relaxed)
}

/// Prints a warning, once. The command continues.
pub(super) fn warn(warning: &impl std::fmt::Display) {
    static WARNED: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    let warning = format!("warning: {warning}");
    let is_new = WARNED.lock().is_ok_and(|mut warned| warned.insert(warning.clone()));
    if is_new && !is_quiet() {
        print_on_error(&Text::headed(ATTENTION, &warning));
    }
}

/// Prints a note: something that a user may not expect.
pub(super) fn note(note: &impl std::fmt::Display) {
    if is_quiet() {
        return;
    }
    print_on_error(&Text::headed(ATTENTION, &format!("note: {note}")));
}

/// A table with the given headings. The first `left` columns are text, the others numbers.
pub(super) fn table(headings: impl IntoIterator<Item = impl Into<String>>, left: usize) -> TextTable {
    TextTable::new(headings, |column| column < left)
}

/// A table as text in the width of standard output, without indentation, ended by a newline.
pub(super) fn table_text(table: &TextTable) -> String {
    table.text(terminal::width())
}

/// A table of results as text: title, columns for people, notes.
pub(super) fn table_with_notes(of: &cocarry_studies::table::Table) -> String {
    let (headings, rows) = of.shown();
    let mut shown = TextTable::new(headings.iter().map(|heading| heading.0), |column| headings[column].1);
    rows.into_iter().for_each(|row| shown.add_row(row));
    let notes: String = of.notes.iter().map(|note| format!("{note}\n")).collect();
    format!("{}\n{}{notes}", of.title, table_text(&shown))
}

/// The examples of a command, for the end of its help: each a command and what it does.
pub(super) fn examples(all: &[(&str, &str)]) -> String {
    let heading = Style::new().bold().underline();
    let mut text = format!("{heading}Examples:{heading:#}\n");
    for (command, about) in all {
        text += &format!("  {command}\n");
        if !about.is_empty() {
            text += &format!("      {about}\n");
        }
    }
    text
}

/// A parser of the name of an SVG file.
pub(super) fn svg_file(name: &str) -> Result<PathBuf, String> {
    file_with_extension("svg", name)
}

/// A parser of the name of an XML file.
pub(super) fn xml_file(name: &str) -> Result<PathBuf, String> {
    file_with_extension("xml", name)
}

/// A parser of the name of a page.
pub(super) fn html_file(name: &str) -> Result<PathBuf, String> {
    file_with_extension("html", name)
}

/// A parser of the name of a TOML file.
pub(super) fn toml_file(name: &str) -> Result<PathBuf, String> {
    file_with_extension("toml", name)
}

/// A parser of the name of a CSV file.
pub(super) fn csv_file(name: &str) -> Result<PathBuf, String> {
    file_with_extension("csv", name)
}

/// A parser of the name of a recording.
pub(super) fn mcap_file(name: &str) -> Result<PathBuf, String> {
    file_with_extension("mcap", name)
}

fn file_with_extension(extension: &str, name: &str) -> Result<PathBuf, String> {
    let file = PathBuf::from(name);
    match has_extension(&file, extension) {
        true => Ok(file),
        false => Err(format!("expected the extension .{extension}")),
    }
}

/// Whether a file's name has this extension, in any case of letters.
pub(super) fn has_extension(file: &Path, extension: &str) -> bool {
    file.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension))
}

/// A progress bar. It appears after two seconds of work, and only if standard error is a terminal.
pub(super) struct Progress {
    bar: ProgressBar,
    begun: Instant,
    is_shown: AtomicBool,
}

impl Progress {
    /// A bar for `total` units of work.
    pub fn new(total: usize, what: &str) -> Self {
        let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len}  {per_sec}  {eta} left")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        let bar = ProgressBar::with_draw_target(Some(total as u64), ProgressDrawTarget::hidden());
        bar.set_style(style);
        bar.set_message(what.to_owned());
        Self { bar, begun: Instant::now(), is_shown: AtomicBool::new(false) }
    }

    /// Counts one finished unit of work.
    pub fn step(&self) {
        self.bar.inc(1);
        let is_due = !is_quiet() && self.begun.elapsed() >= Duration::from_secs(2);
        if is_due && !self.is_shown.swap(true, Ordering::Relaxed) {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
    }

    /// Removes the bar at the end of the work.
    pub fn finish(self) {
        self.bar.finish_and_clear();
    }
}

/// Does work of unknown length. A line with the time spent appears after two seconds, and only if standard
/// error is a terminal.
pub(super) fn with_spinner<T>(what: &str, work: impl FnOnce() -> T) -> T {
    const QUIET_TIME: Duration = Duration::from_secs(2);
    std::thread::scope(|scope| {
        let (done, is_done) = std::sync::mpsc::channel::<()>();
        scope.spawn(move || {
            if is_done.recv_timeout(QUIET_TIME) == Err(RecvTimeoutError::Timeout) && !is_quiet() {
                let style = ProgressStyle::with_template("{spinner} {msg}, {elapsed}");
                let line = ProgressBar::new_spinner().with_message(what.to_owned()).with_elapsed(QUIET_TIME);
                line.set_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
                line.enable_steady_tick(Duration::from_millis(500));
                // until the sender is dropped
                let _ = is_done.recv();
                line.finish_and_clear();
            }
        });
        let _done = done;
        work()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn golden_a_long_line_of_a_file_is_cut_around_its_mark() {
        let error = |text: &str, mark: usize, marks: usize| {
            format!("not valid\n   |\n12 | {text}\n   | {}{}\nwhy", " ".repeat(mark), "^".repeat(marks))
        };
        let short = error("a = = 1", 4, 1);
        assert_eq!(with_short_quotes(&short, 80), short);
        let text = "0123456789".repeat(3);
        let begin = with_short_quotes(&error(&text, 3, 2), 15);
        assert_eq!(begin, error("012345678…", 3, 2));
        let middle = with_short_quotes(&error(&text, 13, 9), 15);
        assert_eq!(middle, error("…90123456…", 5, 5));
        let end = with_short_quotes(&error(&text, 29, 1), 15);
        assert_eq!(end, error("…123456789", 9, 1));
    }
}
