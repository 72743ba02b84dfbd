//! "Did you mean": the known name that is most like a mistyped one.

use std::fmt;
use std::path::Path;

/// The least similarity of a suggestion, from 0 (nothing in common) to 1 (the same).
const MIN_SIMILARITY: f64 = 0.78;

/// The largest number of files that are compared with a name that does not exist.
const MAX_FILES: usize = 1000;

/// The known name that is most like `name`. What a name has in parentheses is not compared.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str, IntoIter: Clone>) -> Option<&'a str> {
    let known = known.into_iter();
    let stem = |name: &str| name.split_once('(').map_or(name, |(stem, _)| stem).to_lowercase();
    let similarity = |other: &str| {
        let (name, other) = (stem(name), stem(other));
        // one slip of the finger, also in a short name
        let is_slip = name.len() > 2 && strsim::osa_distance(&name, &other) == 1;
        strsim::jaro(&name, &other).max(if is_slip { MIN_SIMILARITY } else { 0.0 })
    };
    let near = known.clone().map(|other| (similarity(other), other));
    let near = near.filter(|(similarity, other)| *similarity >= MIN_SIMILARITY && *other != name);
    // the first of equals
    near.fold(None, |best: Option<(f64, &str)>, next| Some(best.filter(|b| b.0 >= next.0).unwrap_or(next)))
        .map(|(_, other)| other)
        .or_else(|| abbreviated(name, known))
}

/// The known name that `name` abbreviates: its number, after the beginning of its letters, as in `env4`, `env-4`
/// or `4` for `environment-4`.
fn abbreviated<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let parts = |name: &str| {
        let letters = name.trim_end_matches(|c: char| c.is_ascii_digit()).len();
        let (letters, number) = name.split_at(letters);
        (letters.trim_end_matches(['-', '_', ' ']).to_lowercase(), number.to_owned())
    };
    let (letters, number) = parts(name);
    let fits = |other: &&str| {
        let (whole, of) = parts(other);
        whole.starts_with(&letters) && of == number
    };
    known.into_iter().find(|other| !number.is_empty() && fits(other))
}

/// The end of an error about `name`: "; did you mean `OTHER`?", or nothing.
pub fn hint<'a>(name: &str, known: impl IntoIterator<Item = &'a str, IntoIter: Clone>) -> String {
    nearest(name, known).map_or(String::new(), |other| format!("; did you mean `{other}`?"))
}

/// Known names for an error, each in backticks: the first `most` of a long list.
pub fn listed<'a>(names: impl IntoIterator<Item = &'a str>, most: usize) -> String {
    let names: Vec<String> = names.into_iter().map(|name| format!("`{name}`")).collect();
    match names.len() {
        0 => "none".to_owned(),
        n if n <= most => names.join(", "),
        n => format!("{} and {} more", names[..most].join(", "), n - most),
    }
}

/// The values allowed, for an error: a sentence, and the names among them, for a suggestion.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Expected {
    sentence: String,
    names: Vec<String>,
}

impl Expected {
    /// One of these names, each shown in quotes.
    pub fn one_of<'a>(names: impl IntoIterator<Item = &'a str>) -> Self {
        let names: Vec<String> = names.into_iter().map(str::to_owned).collect();
        let quoted: Vec<String> = names.iter().map(|name| format!("{name:?}")).collect();
        Self { sentence: format!("one of {}", quoted.join(", ")), names }
    }

    /// The same values, of which these are names.
    #[must_use]
    pub fn with_names<'a>(self, names: impl IntoIterator<Item = &'a str>) -> Self {
        Self { names: names.into_iter().map(str::to_owned).collect(), ..self }
    }

    /// [`hint`] for a value that is not allowed.
    pub fn hint(&self, name: &str) -> String {
        hint(name, self.names.iter().map(String::as_str))
    }
}

impl<T: Into<String>> From<T> for Expected {
    fn from(sentence: T) -> Self {
        Self { sentence: sentence.into(), names: Vec::new() }
    }
}

impl fmt::Display for Expected {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.sentence)
    }
}

/// [`hint`] for a file that does not exist: a file next to it, with its folder as given.
pub fn hint_of_files(path: &Path) -> String {
    let Some(name) = path.file_name() else { return String::new() };
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let entries = std::fs::read_dir(folder).into_iter().flatten().take(MAX_FILES).flatten();
    let mut files: Vec<String> =
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    files.sort();
    let near = nearest(&name.to_string_lossy(), files.iter().map(String::as_str));
    near.map_or(String::new(), |other| format!("; did you mean `{}`?", path.with_file_name(other).display()))
}

/// A text as one word of a shell's command, for commands that errors and messages give to copy.
pub fn shell_word(text: &str) -> String {
    // a NUL is in no word of a shell
    let text = text.replace('\0', "");
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_@%+=:,./-".contains(c);
    if !text.is_empty() && !text.starts_with('=') && text.chars().all(is_plain) {
        return text;
    }
    shlex::try_quote(&text).map_or_else(|_| String::new(), |word| word.into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_of_a_command_is_the_text_again_in_a_shell() {
        for text in ["plain-1.toml", "with space", "$(touch x)", "it's", "a\"b`c`", "", "a\nb", "!x;&|*?~"] {
            let word = shell_word(text);
            assert_eq!(shlex::split(&word), Some(vec![text.to_owned()]), "{word}");
        }
        assert_eq!(shell_word("--array=1-3,%A_%a"), "--array=1-3,%A_%a");
        assert_eq!(shell_word("a\0b"), "ab");
    }

    #[test]
    fn a_mistyped_name_finds_the_right_one_and_another_none() {
        let worlds = ["environment-1", "environment-2", "environment-3", "environment-4", "free-form"];
        for (name, expected) in [
            ("environmnt-4", Some("environment-4")),
            ("Environment-2", Some("environment-2")),
            ("enviroment3", Some("environment-3")),
            ("freeform", Some("free-form")),
            ("env4", Some("environment-4")),
            ("env_4", Some("environment-4")),
            ("e-1", Some("environment-1")),
            ("2", Some("environment-2")),
            ("7", None),
            ("kitchen", None),
            ("", None),
            ("free-form", None),
        ] {
            assert_eq!(nearest(name, worlds), expected, "{name}");
        }
        let models = ["preference", "boltzmann(RATIONALITY)"];
        assert_eq!(nearest("boltzman(2)", models), Some("boltzmann(RATIONALITY)"));
    }

    #[test]
    fn expected_values_give_hints_from_their_names() {
        let expected = Expected::one_of(["point", "rapier"]);
        assert_eq!(expected.to_string(), r#"one of "point", "rapier""#);
        assert_eq!(expected.hint("rapie"), "; did you mean `rapier`?");
        assert_eq!(Expected::from("true or false").hint("tru"), "");
    }
}
