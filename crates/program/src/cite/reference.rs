//! A work that is cited, as an entry of BibTeX, of CSL-JSON, or as text.

use serde_json::{Map, Value, json};
use textwrap::{Options, WordSplitter};

/// Width of the entries as text.
const TEXT_WIDTH: usize = 80;

/// The kind of a work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ReferenceKind {
    Article,
    Preprint,
    Book,
    Chapter,
    Software,
}

/// The author of a work.
#[derive(Clone, Copy, Debug)]
pub(super) enum Author {
    /// A person: family name and given names.
    Person(&'static str, &'static str),
    /// An organisation, or a group without names.
    Group(&'static str),
}

/// A work. What it does not have is empty. In its title, braces hold words whose capitals stay.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reference<'a> {
    pub key: &'static str,
    pub kind: ReferenceKind,
    pub authors: &'static [Author],
    pub title: &'static str,
    pub year: Option<u16>,
    /// Journal of an article, book of a chapter.
    pub within: &'static str,
    pub editors: &'static [Author],
    pub volume: &'static str,
    pub issue: &'static str,
    /// First and last page.
    pub pages: Option<(u16, u16)>,
    pub publisher: &'static str,
    pub place: &'static str,
    /// Number on arXiv.
    pub arxiv: &'static str,
    pub doi: &'static str,
    pub url: &'static str,
    /// Of software.
    pub version: Option<&'a str>,
    /// Of software.
    pub commit: Option<&'static str>,
    /// What the episode used it for.
    pub used_for: &'static str,
}

impl Reference<'_> {
    /// A work that has only these, to be completed.
    pub const fn new(
        key: &'static str,
        kind: ReferenceKind,
        authors: &'static [Author],
        title: &'static str,
        used_for: &'static str,
    ) -> Self {
        Self {
            key,
            kind,
            authors,
            title,
            used_for,
            year: None,
            within: "",
            editors: &[],
            volume: "",
            issue: "",
            pages: None,
            publisher: "",
            place: "",
            arxiv: "",
            doi: "",
            url: "",
            version: None,
            commit: None,
        }
    }

    /// "version 0.1.0, commit ..."
    fn edition(&self) -> Option<String> {
        let version = self.version.map(|version| format!("version {version}"));
        let commit = self.commit.map(|commit| format!("commit {commit}"));
        let parts: Vec<String> = version.into_iter().chain(commit).collect();
        (!parts.is_empty()).then(|| parts.join(", "))
    }

    /// The entry for BibTeX. Styles from before biblatex know neither software nor versions: a note has them.
    pub fn bibtex(&self) -> String {
        let (entry, within) = match self.kind {
            ReferenceKind::Article => ("article", "journal"),
            ReferenceKind::Book => ("book", ""),
            ReferenceKind::Chapter => ("incollection", "booktitle"),
            ReferenceKind::Preprint | ReferenceKind::Software => ("misc", ""),
        };
        let names = |authors: &[Author]| {
            let name = |author: &Author| match author {
                Author::Person(family, given) => latex(&format!("{family}, {given}")),
                Author::Group(name) => format!("{{{}}}", latex(name)),
            };
            authors.iter().map(name).collect::<Vec<_>>().join(" and ")
        };
        let pages = self.pages.map(|(first, last)| format!("{first}--{last}"));
        let fields = [
            ("author", names(self.authors)),
            ("title", latex(self.title)),
            (within, latex(self.within)),
            ("editor", names(self.editors)),
            ("year", self.year.map(|year| year.to_string()).unwrap_or_default()),
            ("volume", self.volume.to_owned()),
            ("number", self.issue.to_owned()),
            ("pages", pages.unwrap_or_default()),
            ("publisher", latex(self.publisher)),
            ("address", latex(self.place)),
            ("eprint", self.arxiv.to_owned()),
            ("archivePrefix", if self.arxiv.is_empty() { "" } else { "arXiv" }.to_owned()),
            ("doi", self.doi.to_owned()),
            ("url", self.url.to_owned()),
            ("note", self.edition().map(|edition| sentence(&edition)).unwrap_or_default()),
        ];
        let fields = fields.into_iter().filter(|(_, value)| !value.is_empty());
        let fields: Vec<String> = fields.map(|(name, value)| format!("  {name} = {{{value}}}")).collect();
        format!("% {}\n@{entry}{{{},\n{}\n}}\n", self.used_for, self.key, fields.join(",\n"))
    }

    /// The item of CSL-JSON.
    pub fn csl(&self) -> Value {
        let kind = match self.kind {
            ReferenceKind::Article => "article-journal",
            ReferenceKind::Preprint => "article",
            ReferenceKind::Book => "book",
            ReferenceKind::Chapter => "chapter",
            ReferenceKind::Software => "software",
        };
        let names = |authors: &[Author]| {
            let name = |author: &Author| match author {
                Author::Person(family, given) => json!({ "family": family, "given": given }),
                Author::Group(name) => json!({ "literal": name }),
            };
            authors.iter().map(name).collect::<Value>()
        };
        let mut item: Map<String, Value> = Map::new();
        item.insert("id".into(), self.key.into());
        item.insert("type".into(), kind.into());
        item.insert("author".into(), names(self.authors));
        if !self.editors.is_empty() {
            item.insert("editor".into(), names(self.editors));
        }
        if let Some(year) = self.year {
            item.insert("issued".into(), json!({ "date-parts": [[year]] }));
        }
        let arxiv = if self.arxiv.is_empty() { String::new() } else { format!("arXiv:{}", self.arxiv) };
        for (name, value) in [
            ("title", self.plain_title()),
            ("container-title", self.within.to_owned()),
            ("volume", self.volume.to_owned()),
            ("issue", self.issue.to_owned()),
            ("page", self.pages.map(|(first, last)| format!("{first}-{last}")).unwrap_or_default()),
            ("publisher", self.publisher.to_owned()),
            ("publisher-place", self.place.to_owned()),
            ("number", arxiv),
            ("DOI", self.doi.to_owned()),
            ("URL", self.address()),
            ("version", self.version.unwrap_or_default().to_owned()),
            ("note", self.commit.map(|commit| format!("commit {commit}")).unwrap_or_default()),
            ("annote", self.used_for.to_owned()),
        ] {
            if !value.is_empty() {
                item.insert(name.into(), value.into());
            }
        }
        item.into()
    }

    /// A paragraph: what it is for, and the work.
    pub fn text(&self) -> String {
        let name = |author: &Author| match author {
            Author::Person(family, given) => format!("{given} {family}"),
            Author::Group(name) => (*name).to_owned(),
        };
        let names = |authors: &[Author]| authors.iter().map(name).collect::<Vec<_>>().join(", ");
        let editors =
            if self.editors.is_empty() { String::new() } else { format!("ed. {}", names(self.editors)) };
        let issue = if self.issue.is_empty() { String::new() } else { format!("({})", self.issue) };
        let title = self.plain_title();
        let parts = [
            format!("{}: {title}", names(self.authors)),
            if self.kind == ReferenceKind::Chapter {
                format!("in {}", self.within)
            } else {
                self.within.to_owned()
            },
            editors,
            format!("{}{issue}", self.volume),
            self.pages.map(|(first, last)| format!("{first}-{last}")).unwrap_or_default(),
            self.publisher.to_owned(),
            self.place.to_owned(),
            self.year.map(|year| year.to_string()).unwrap_or_default(),
            self.edition().unwrap_or_default(),
            self.address(),
        ];
        let parts: Vec<String> = parts.into_iter().filter(|part| !part.is_empty()).collect();
        // an address stays in one piece
        let options = Options::new(TEXT_WIDTH).word_splitter(WordSplitter::NoHyphenation).break_words(false);
        let options = options.initial_indent("  ").subsequent_indent("  ");
        format!("{}:\n{}\n", sentence(self.used_for), textwrap::fill(&parts.join(", "), options))
    }

    fn plain_title(&self) -> String {
        self.title.replace(['{', '}'], "")
    }

    /// Where it is found.
    fn address(&self) -> String {
        match (self.doi, self.arxiv) {
            ("", "") => self.url.to_owned(),
            ("", arxiv) => format!("https://arxiv.org/abs/{arxiv}"),
            (doi, _) => format!("https://doi.org/{doi}"),
        }
    }
}

/// The text with a capital at its beginning.
fn sentence(text: &str) -> String {
    let mut characters = text.chars();
    characters.next().map_or(String::new(), |first| first.to_uppercase().chain(characters).collect())
}

/// Text as every LaTeX reads it: what has a meaning there is escaped, braces stay.
fn latex(text: &str) -> String {
    let mut escaped = String::new();
    for character in text.chars() {
        match character {
            '&' | '%' | '#' | '_' | '$' => escaped.extend(['\\', character]),
            'é' => escaped += r"{\'e}",
            'ú' => escaped += r"{\'u}",
            other => escaped.push(other),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    const ARTICLE: Reference<'static> = Reference {
        year: Some(1998),
        within: "Computers & Operations Research",
        volume: "66",
        issue: "3",
        pages: Some((497, 527)),
        doi: "10.1/2_3",
        ..Reference::new(
            "key",
            ReferenceKind::Article,
            &[Author::Person("Júdice", "J. J."), Author::Group("A group")],
            "{Clarabel}: a title",
            "what it is for",
        )
    };

    #[test]
    fn closed_form_an_article_in_each_format() {
        assert_eq!(
            ARTICLE.bibtex(),
            "% what it is for\n@article{key,\n  author = {J{\\'u}dice, J. J. and {A group}},\n  title = {{Clarabel}: a title},\n  \
             journal = {Computers \\& Operations Research},\n  year = {1998},\n  volume = {66},\n  number = {3},\n  \
             pages = {497--527},\n  doi = {10.1/2_3}\n}\n"
        );
        assert_eq!(
            ARTICLE.csl(),
            json!({
                "id": "key", "type": "article-journal", "title": "Clarabel: a title",
                "author": [{ "family": "Júdice", "given": "J. J." }, { "literal": "A group" }],
                "container-title": "Computers & Operations Research", "volume": "66", "issue": "3",
                "page": "497-527", "DOI": "10.1/2_3", "URL": "https://doi.org/10.1/2_3",
                "issued": { "date-parts": [[1998]] }, "annote": "what it is for",
            })
        );
        assert_eq!(
            ARTICLE.text(),
            "What it is for:\n  J. J. Júdice, A group: Clarabel: a title, Computers & Operations Research,\n\
             \u{20} 66(3), 497-527, 1998, https://doi.org/10.1/2_3\n"
        );
    }

    #[test]
    fn the_edition_of_software_is_version_and_commit() {
        let program = Reference { version: Some("0.1.0"), commit: Some("abc"), ..ARTICLE };
        assert!(program.bibtex().contains("  note = {Version 0.1.0, commit abc}\n"));
        assert!(program.text().contains(", version 0.1.0, commit abc, "));
        assert_eq!(program.csl()["version"], "0.1.0");
        assert_eq!(program.csl()["note"], "commit abc");
    }
}
