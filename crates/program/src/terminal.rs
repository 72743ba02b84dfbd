//! What a terminal shows: its width, lines wrapped at words, colours for what matters.

use anstyle::{AnsiColor, Style};
use std::borrow::Cow;
use terminal_size::{Height, Width, terminal_size_of};
use textwrap::{Options, WordSplitter, core::display_width};

/// The least width that output is fitted to.
const MIN_WIDTH: usize = 40;

const GOOD: Style = AnsiColor::Green.on_default().bold();
const BAD: Style = AnsiColor::Red.on_default().bold();
const ATTENTION: Style = AnsiColor::Yellow.on_default().bold();
const BOLD: Style = Style::new().bold();
const RULE: Style = Style::new().dimmed();

/// How a line begins and what follows in it, and the line's style.
const STYLES: [(&str, &str, Style); 7] = [
    ("error:", "", BAD),
    ("warning:", "", ATTENTION),
    ("note:", "", ATTENTION),
    (EVENT, ": arrived at B on option", GOOD),
    (EVENT, ": did not arrive: ", BAD),
    (EVENT, " cm: it lost the object", BAD),
    (EVENT, ", the human takes the lead", BOLD),
];
/// How the line of an event begins.
const EVENT: &str = "  step ";

/// The width of standard output: the terminal's, or the environment's `COLUMNS`. `None` for a pipe or a file.
pub(super) fn width() -> Option<usize> {
    width_of(terminal_size_of(std::io::stdout()))
}

/// The same for standard error.
pub(super) fn error_width() -> Option<usize> {
    width_of(terminal_size_of(std::io::stderr()))
}

fn width_of(terminal: Option<(Width, Height)>) -> Option<usize> {
    let given: Option<usize> = std::env::var("COLUMNS").ok().and_then(|columns| columns.parse().ok());
    let width = given.or(terminal.map(|(Width(width), _)| width.into()));
    width.map(|width| width.max(MIN_WIDTH))
}

/// The text with lines that are too long wrapped at words, and indented further. Commands stay whole, to be
/// copied.
pub(super) fn wrapped(text: &str, width: Option<usize>) -> Cow<'_, str> {
    let Some(width) = width.filter(|width| text.lines().any(|line| display_width(line) > *width)) else {
        return Cow::Borrowed(text);
    };
    let mut wrapped = String::new();
    for line in text.split_inclusive('\n') {
        let content = line.trim_end_matches('\n');
        let command = content.trim_start().trim_start_matches("$ ").starts_with("cocarry ");
        if command || display_width(content) <= width {
            wrapped += line;
            continue;
        }
        let indentation = content.len() - content.trim_start().len();
        let indentation = if indentation == 0 { 0 } else { indentation + 2 };
        let further = " ".repeat(indentation);
        let options = Options::new(width)
            .break_words(false)
            .word_splitter(WordSplitter::NoHyphenation)
            .subsequent_indent(&further);
        wrapped += &textwrap::fill(content, options);
        wrapped += &line[content.len()..];
    }
    Cow::Owned(wrapped)
}

/// The text with its first line, a verdict, in its colour.
pub(super) fn verdict(text: &str, is_good: bool) -> String {
    let style = if is_good { GOOD } else { BAD };
    let (first, rest) = text.split_once('\n').unwrap_or((text, ""));
    format!("{style}{first}{style:#}\n{}", painted(rest))
}

/// The text with escape sequences for colours, which a stream without colours removes.
pub(super) fn painted(text: &str) -> String {
    let is_rule = |line: &str, sign: char| !line.is_empty() && line.chars().all(|c| c == sign);
    let lines: Vec<&str> = text.split_inclusive('\n').collect();
    let mut styles: Vec<Option<Style>> = Vec::with_capacity(lines.len());
    let mut headings = None;
    for (at, line) in lines.iter().map(|line| line.trim_end_matches('\n')).enumerate() {
        let has = |(start, words, _): &&(&str, &str, _)| line.starts_with(start) && line.contains(words);
        let listed = STYLES.iter().find(has).map(|(.., style)| *style);
        let style = match (is_rule(line, '─'), is_rule(line, '═'), headings) {
            (true, ..) => {
                headings = Some(at + 1);
                Some(RULE)
            }
            (_, true, Some(first)) => {
                styles[first..].fill(Some(BOLD));
                Some(RULE)
            }
            _ => listed,
        };
        styles.push(style);
    }
    let painted = lines.iter().zip(styles).map(|(line, style)| match style {
        None => Cow::Borrowed(*line),
        Some(style) => {
            let content = line.trim_end_matches('\n');
            Cow::Owned(format!("{style}{content}{style:#}{}", &line[content.len()..]))
        }
    });
    painted.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn golden_long_lines_wrap_at_words_and_commands_do_not() {
        let text =
            "short\n  a line that is longer than its width\n  cocarry run a-world-with-a-long-name.toml\n";
        assert_eq!(
            wrapped(text, Some(24)),
            "short\n  a line that is longer\n    than its width\n  cocarry run a-world-with-a-long-name.toml\n"
        );
        assert_eq!(wrapped(text, None), text);
    }

    #[test]
    fn golden_what_matters_has_a_colour_and_the_rest_has_none() {
        let text = "plain\n──\n a\n══\n b\n──\n  step    9 (  1.8 s): arrived at B on option 1\n";
        let painted = painted(text);
        assert!(painted.starts_with("plain\n") && painted.contains("\n b\n"), "{painted:?}");
        assert!(painted.contains("\u{1b}[1m a\u{1b}[0m"), "{painted:?}");
        assert!(
            painted.contains("\u{1b}[32m  step    9 (  1.8 s): arrived at B on option 1\u{1b}[0m"),
            "{painted:?}"
        );
        assert_eq!(anstream::adapter::strip_str(&painted).to_string(), text);
        // a name is not a verdict
        assert_eq!(super::painted("Lost: arrived at B on option 1\n"), "Lost: arrived at B on option 1\n");
        assert_eq!(verdict("bad\nrest\n", false), format!("{BAD}bad{BAD:#}\nrest\n"));
    }
}
