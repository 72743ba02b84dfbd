//! Texts of users within XML.

/// `text` without the characters that XML does not allow; line breaks and tabs become blanks.
pub(crate) fn printable(text: &str) -> String {
    let fit = |c: char| match c {
        c if c.is_whitespace() => ' ',
        '\u{fffe}' | '\u{ffff}' => '\u{fffd}',
        c if c.is_control() => '\u{fffd}',
        c => c,
    };
    text.chars().map(fit).collect()
}

/// `text` for the inside of an element or an attribute.
pub(crate) fn escaped(text: &str) -> String {
    printable(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
