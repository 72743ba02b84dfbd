//! Plain pages of HTML, without scripts.

pub(crate) use cocarry_output::html::escaped;
use std::fmt::Write;

/// What all pages look like, in light and in dark.
pub(crate) const STYLE: &str = include_str!("../../../assets/people/plain.css");

/// The paragraphs of a text: blank lines divide them.
pub(crate) fn paragraphs(text: &str) -> String {
    let mut html = String::new();
    let mut lines = Vec::new();
    for line in text.trim().lines().chain([""]) {
        match line.trim() {
            "" if lines.is_empty() => {}
            "" => {
                // writing to a text does not fail
                let _ = writeln!(html, "<p>{}</p>", lines.join(" "));
                lines.clear();
            }
            line => lines.push(escaped(line)),
        }
    }
    html
}

/// A table with a caption, which is scrolled within a narrow page; texts are escaped.
pub(crate) fn table(caption: &str, head: &[&str], rows: &[Vec<String>]) -> String {
    let cells = |row: &[String], tag: &str| -> String {
        row.iter().map(|cell| format!("<{tag}>{}</{}>", escaped(cell), &tag[..2])).collect()
    };
    let head: Vec<String> = head.iter().map(|&name| name.to_owned()).collect();
    let body: String = rows.iter().map(|row| format!("<tr>{}</tr>\n", cells(row, "td"))).collect();
    format!(
        "<div class=\"wide\" role=\"region\" aria-label=\"{0}\" tabindex=\"0\"><table><caption>{0}</caption>\n\
         <thead><tr>{1}</tr></thead>\n<tbody>\n{body}</tbody></table></div>\n",
        escaped(caption),
        cells(&head, "th scope=\"col\""),
    )
}

/// A page. `style` is within its head: a link, or the style itself.
pub(crate) fn page(title: &str, style: &str, body: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"robots\" content=\"noindex\">\n<title>{}</title>\n{style}\n</head>\n<body>\n<main>\n{body}</main>\n</body>\n</html>\n",
        escaped(title)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paragraphs_and_tables_show_texts_as_text() {
        assert_eq!(paragraphs(" a <b>\n c\n \n\n d"), "<p>a &lt;b&gt; c</p>\n<p>d</p>\n");
        assert!(table("<i>", &["a"], &[vec!["<b>".to_owned()]]).contains("<td>&lt;b&gt;</td>"));
    }
}
