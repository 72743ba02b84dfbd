//! Texts in pages of HTML.

/// A text as HTML shows it, in an element or in an attribute with double quotes: nothing in it is markup, and
/// what is not seen but changes what is seen (control characters, those that turn the direction of text) is
/// replaced.
pub fn escaped(text: &str) -> String {
    let mut html = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => html.push_str("&amp;"),
            '<' => html.push_str("&lt;"),
            '>' => html.push_str("&gt;"),
            '"' => html.push_str("&quot;"),
            c if is_hidden(c) => html.push('\u{fffd}'),
            c => html.push(c),
        }
    }
    html
}

/// Whether a character is not seen but changes what is seen.
fn is_hidden(c: char) -> bool {
    (c.is_control() && !"\n\t".contains(c)) || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_shown_as_text() {
        assert_eq!(
            escaped("<script>alert('a' & \"b\")</script>\u{202e}\u{7}\n"),
            "&lt;script&gt;alert('a' &amp; &quot;b&quot;)&lt;/script&gt;\u{fffd}\u{fffd}\n"
        );
    }
}
