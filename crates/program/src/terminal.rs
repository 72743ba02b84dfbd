//! Text for a terminal: its width, lines wrapped at words, colours for what matters.

use anstyle::{AnsiColor, Style};
use std::borrow::Cow;
use terminal_size::{Height, Width, terminal_size_of};
use textwrap::{Options, WordSplitter, core::display_width};

/// The least width that output is fitted to.
const MIN_WIDTH: usize = 40;

pub(super) const GOOD: Style = AnsiColor::Green.on_default().bold();
pub(super) const BAD: Style = AnsiColor::Red.on_default().bold();
pub(super) const ATTENTION: Style = AnsiColor::Yellow.on_default().bold();
pub(super) const BOLD: Style = Style::new().bold();
const RULE: Style = Style::new().dimmed();

/// The width of standard output: the terminal's, or the environment's `COLUMNS`. `None` for a pipe or a file.
pub(super) fn width() -> Option<usize> {
    width_of(terminal_size_of(std::io::stdout()))
}

/// The same for standard error.
pub(super) fn error_width() -> Option<usize> {
    width_of(terminal_size_of(std::io::stderr()))
}

fn width_of(terminal: Option<(Width, Height)>) -> Option<usize> {
    let given = std::env::var("COLUMNS").ok().and_then(|columns| columns.parse().ok());
    // 0 is unknown, as some terminals and tools set it
    let given: Option<usize> = given.filter(|columns| *columns > 0);
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

/// Text for a terminal: parts, some of which have a style.
#[derive(Debug, Default)]
pub(super) struct Text(Vec<(Option<Style>, String)>);

impl Text {
    /// A text whose first line has a style: a verdict, an error.
    pub fn headed(style: Style, text: &str) -> Self {
        let (first, rest) = text.split_at(text.find('\n').map_or(text.len(), |end| end + 1));
        let mut headed = Self::default();
        headed.styled(style, first);
        headed.plain(rest);
        headed
    }

    /// Adds text without a style; tables in it are drawn with theirs.
    pub fn plain(&mut self, text: &str) {
        self.0.push((None, text.to_owned()));
    }

    /// Adds lines in a style.
    pub fn styled(&mut self, style: Style, lines: &str) {
        self.0.push((Some(style), lines.to_owned()));
    }

    /// The text for this width, with escape sequences for colours, which a stream without colours removes.
    /// `clean` is applied to every part before these are added.
    pub fn shown(&self, width: Option<usize>, clean: impl Fn(&str) -> String) -> String {
        let shown = self.0.iter().map(|(style, text)| {
            let text = clean(text);
            let text = wrapped(&text, width);
            match style {
                None => with_tables(&text),
                Some(style) => text.split_inclusive('\n').map(|line| in_style(*style, line)).collect(),
            }
        });
        shown.collect()
    }
}

fn in_style(style: Style, line: &str) -> String {
    let content = line.trim_end_matches('\n');
    format!("{style}{content}{style:#}{}", &line[content.len()..])
}

/// The text with the rules of its tables dimmed and their headings bold.
fn with_tables(text: &str) -> String {
    let is_rule = |line: &str, sign: char| !line.is_empty() && line.chars().all(|c| c == sign);
    let lines: Vec<&str> = text.split_inclusive('\n').collect();
    let mut styles: Vec<Option<Style>> = Vec::with_capacity(lines.len());
    let mut headings = None;
    for (at, line) in lines.iter().map(|line| line.trim_end_matches('\n')).enumerate() {
        let style = match (is_rule(line, '─'), is_rule(line, '═'), headings) {
            (true, ..) => {
                headings = Some(at + 1);
                Some(RULE)
            }
            (_, true, Some(first)) => {
                styles[first..].fill(Some(BOLD));
                Some(RULE)
            }
            _ => None,
        };
        styles.push(style);
    }
    let styled = lines.iter().zip(styles);
    styled
        .map(|(line, style)| style.map_or_else(|| (*line).to_owned(), |style| in_style(style, line)))
        .collect()
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
        let mut text = Text::default();
        text.plain("plain\n──\n a\n══\n b\n──\n");
        text.styled(GOOD, "  arrived\n");
        let shown = text.shown(None, str::to_owned);
        assert!(shown.starts_with("plain\n") && shown.contains("\n b\n"), "{shown:?}");
        assert!(shown.contains("\u{1b}[1m a\u{1b}[0m"), "{shown:?}");
        assert!(shown.contains("\u{1b}[32m  arrived\u{1b}[0m"), "{shown:?}");
        let bare = "plain\n──\n a\n══\n b\n──\n  arrived\n";
        assert_eq!(anstream::adapter::strip_str(&shown).to_string(), bare);
        let headed = Text::headed(BAD, "bad\nrest\n").shown(None, str::to_owned);
        assert_eq!(headed, format!("{BAD}bad{BAD:#}\nrest\n"));
        // a name is not a verdict
        let mut name = Text::default();
        name.plain("Lost: arrived at B on option 1\n");
        assert_eq!(name.shown(None, str::to_owned), "Lost: arrived at B on option 1\n");
    }
}
