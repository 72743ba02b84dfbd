//! The report as one self-contained HTML page.

use super::document::anchor;
use crate::paper::part::Figure;
use cocarry_output::drawing::dark_rules;
use cocarry_output::html::escaped;
use pulldown_cmark::{CowStr, Event, HeadingLevel, Options, Parser, Tag, TagEnd, html::push_html};

/// The style sheet for screen and paper.
const STYLE: &str = include_str!("page.css");

/// The page, with `made` at its end.
pub(super) fn html(markdown: &str, figures: &[&Figure], made: &str) -> String {
    let mut body = String::new();
    push_html(&mut body, events(markdown, figures).into_iter());
    let title = markdown.lines().find_map(|line| line.strip_prefix("# ")).unwrap_or("cocarry");
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{}</title>\n<style>\n{STYLE}\
         @media screen and (prefers-color-scheme: dark) {{\n{}}}\n</style>\n</head>\n<body>\n<main>\n{body}\
         <footer><p>{}</p></footer>\n</main>\n</body>\n</html>\n",
        escaped(title),
        dark_rules("figure svg"),
        escaped(made),
    )
}

/// The events of the Markdown, with pictures in place of links to them, and scrolling tables.
fn events<'a>(markdown: &'a str, figures: &[&'a Figure]) -> Vec<Event<'a>> {
    let mut events = Vec::new();
    let mut picture = None;
    let mut is_alone = false;
    for event in Parser::new_ext(markdown, Options::ENABLE_TABLES) {
        let raw = |html: String| Event::Html(CowStr::from(html));
        match event {
            Event::Start(Tag::Image { dest_url, .. }) => {
                let named = |f: &&&Figure| *dest_url == *format!("figures/{}.svg", f.name);
                picture = figures.iter().find(named);
                if let Some(figure) = picture {
                    // a picture is not part of a paragraph
                    is_alone = events.pop_if(|last| *last == Event::Start(Tag::Paragraph)).is_some();
                    let class = if figure.is_half { " class=\"half\"" } else { "" };
                    let begin =
                        format!("<figure id=\"{}\"{class}>\n{}\n<figcaption>", figure.name, inline(figure));
                    events.push(raw(begin));
                }
            }
            Event::End(TagEnd::Image) if picture.take().is_some() => {
                events.push(raw("</figcaption>\n</figure>\n".to_owned()));
            }
            Event::End(TagEnd::Paragraph) if std::mem::take(&mut is_alone) => {}
            Event::Start(Tag::Table(alignments)) => {
                events.push(raw("<div class=\"table\">".to_owned()));
                events.push(Event::Start(Tag::Table(alignments)));
            }
            Event::End(TagEnd::Table) => {
                events.push(Event::End(TagEnd::Table));
                events.push(raw("</div>\n".to_owned()));
            }
            other => events.push(other),
        }
    }
    with_anchors(events)
}

/// The events with an id for every section, and the first list, the contents, as navigation.
fn with_anchors(mut events: Vec<Event>) -> Vec<Event> {
    for at in 0..events.len() {
        let is_text = |event: &&Event| matches!(event, Event::Text(_) | Event::Code(_));
        let words: String = events[at + 1..]
            .iter()
            .take_while(|event| !matches!(event, Event::End(TagEnd::Heading(_))))
            .filter(is_text)
            .map(|event| if let Event::Text(text) | Event::Code(text) = event { &**text } else { "" })
            .collect();
        if let Event::Start(Tag::Heading { level: HeadingLevel::H2, id, .. }) = &mut events[at] {
            *id = Some(anchor(&words).into());
        }
    }
    let begin = events.iter().position(|event| matches!(event, Event::Start(Tag::List(_))));
    let end = events.iter().position(|event| matches!(event, Event::End(TagEnd::List(_))));
    if let (Some(begin), Some(end)) = (begin, end) {
        events.insert(end + 1, Event::Html(CowStr::from("</nav>\n")));
        events.insert(begin, Event::Html(CowStr::from("<nav aria-label=\"Contents\">\n")));
    }
    events
}

/// The picture as part of a page: as wide as the page allows, and with unique ids.
fn inline(figure: &Figure) -> String {
    let own = format!("{}-", figure.name);
    let svg = figure.svg.replace(" id=\"", &format!(" id=\"{own}")).replace("url(#", &format!("url(#{own}"));
    let label = escaped(&figure.caption);
    svg.replacen("<svg ", &format!("<svg role=\"img\" aria-label=\"{label}\" "), 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn golden_markdown_becomes_a_page_with_its_pictures_in_it() {
        let figure = Figure {
            name: "f".to_owned(),
            caption: "A \"b\" < c".to_owned(),
            is_half: false,
            svg: "<svg width=\"1\"><g id=\"risk\" fill=\"url(#risk)\"/></svg>".to_owned(),
        };
        let text = "# T & t\n\n![A \"b\" < c](figures/f.svg)\n\n| a | b |\n| :-- | --: |\n| 1 | **2** |\n";
        let page = html(text, &[&figure], "in 3 s");
        for part in [
            "<title>T &amp; t</title>",
            "<figure id=\"f\">",
            "<svg role=\"img\" aria-label=\"A &quot;b&quot; &lt; c\" width=\"1\"><g id=\"f-risk\" fill=\"url(#f-risk)\"/></svg>",
            "<figcaption>A \"b\" &lt; c</figcaption>",
            "<div class=\"table\"><table>",
            "<td style=\"text-align: right\"><strong>2</strong></td>",
            "<footer><p>in 3 s</p></footer>",
        ] {
            assert!(page.contains(part), "{part} is missing from\n{page}");
        }
        assert!(!page.contains("<img") && !page.contains("<p><figure"));
    }
}
