//! The page on which participants answer: its files.

use crate::carry::{drawing, scenarios};
use crate::digest::sha256;
use crate::order::orders;
use crate::study::{Study, StudyWorld};
use crate::walk::Shots;
use cocarry::Error;
use serde_json::{Value, json};
use std::borrow::Cow;

/// The built client. `viewer/people/build.mjs` makes it.
const CLIENT: [(&str, &str, &str); 4] = [
    ("index.html", "text/html; charset=utf-8", include_str!("../../../assets/people/index.html")),
    ("study.js", "text/javascript; charset=utf-8", include_str!("../../../assets/people/study.js")),
    ("study.css", "text/css; charset=utf-8", include_str!("../../../assets/people/study.css")),
    ("NOTICE.txt", "text/plain; charset=utf-8", include_str!("../../../assets/people/NOTICE.txt")),
];

/// The simulator, in the page of a study in which people carry.
const MODULE: &str = "cocarry.wasm";

/// Where the page sends what it records.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sink {
    /// To the server that it comes from.
    Server,
    /// Into a file, which the participant downloads at the end and hands over.
    Download,
}

/// A file of the page.
#[derive(Clone, Debug)]
pub struct SiteFile {
    /// Its name, relative to the page, with `/`.
    pub name: Cow<'static, str>,
    /// Its MIME type.
    pub mime: &'static str,
    /// Its bytes.
    pub bytes: Cow<'static, [u8]>,
}

/// The page of a study.
#[derive(Clone, Debug)]
pub struct Site {
    /// Its files.
    pub files: Vec<SiteFile>,
    /// SHA-256 of what participants see: of two versions of a study file it differs.
    pub digest: String,
}

impl Site {
    /// The page of a study. Equal studies give equal bytes. `module` is the simulator as a WebAssembly
    /// module, which a page needs on which people carry.
    ///
    /// # Errors
    /// The scenario of a carry cannot be written.
    pub fn new(study: &Study, sink: Sink, module: Option<Cow<'static, [u8]>>) -> Result<Self, Error> {
        let shots: Vec<Shots> =
            study.worlds.iter().map(|world| Shots::of(world, study.shows_openings)).collect();
        let mut content = content(study, &shots)?;
        let scenarios = if study.has_carry() { scenarios(study)? } else { Vec::new() };
        let shown = shots.iter().map(|shots| &shots.map).chain(scenarios.iter().map(|(_, text)| text));
        let shown: String = shown.map(String::as_str).collect();
        let digest = sha256((content.to_string() + &shown).as_bytes());
        content["digest"] = json!(digest);
        content["sink"] = json!(match sink {
            Sink::Server => "server",
            Sink::Download => "download",
        });
        let client = CLIENT.iter().map(|&(name, mime, text)| SiteFile {
            name: name.into(),
            mime,
            bytes: text.as_bytes().into(),
        });
        let maps = shots.into_iter().enumerate().map(|(at, shots)| SiteFile {
            name: map_file(at).into(),
            mime: "image/svg+xml",
            bytes: shots.map.into_bytes().into(),
        });
        let study = SiteFile {
            name: "study.json".into(),
            mime: "application/json",
            bytes: content.to_string().into_bytes().into(),
        };
        let scenarios = scenarios.into_iter().map(|(name, text)| SiteFile {
            name: name.into(),
            mime: "text/plain; charset=utf-8",
            bytes: text.into_bytes().into(),
        });
        let module = module.map(|bytes| SiteFile { name: MODULE.into(), mime: "application/wasm", bytes });
        let files = client.chain(maps).chain(scenarios).chain(module).chain([study]);
        Ok(Self { files: files.collect(), digest })
    }
}

/// The file of the map of a world, by its index.
fn map_file(world: usize) -> String {
    format!("maps/{}.svg", world + 1)
}

/// What the page knows. It has no risk, no length, no completion code, and no answer of anybody; it does have
/// the right answers of questions.
fn content(study: &Study, shots: &[Shots]) -> Result<Value, Error> {
    let world = |(at, (world, shots)): (usize, (&StudyWorld, &Shots))| {
        let mut value = json!(shots);
        value["name"] = json!(world.name);
        value["number"] = json!(at + 1);
        value["file"] = json!(map_file(at));
        value["options"] = json!(world.options);
        value
    };
    let tasks = study.tasks.iter().map(|task| task.name().to_owned());
    let instructions: serde_json::Map<String, Value> =
        tasks.zip(study.instructions.iter().map(|text| json!(text))).collect();
    Ok(json!({
        "version": 1,
        "title": study.title,
        "consent": { "version": study.consent[0], "text": study.consent[1] },
        "instructions": instructions,
        "worlds": study.worlds.iter().zip(shots).enumerate().map(world).collect::<Vec<_>>(),
        "carry": if study.has_carry() { drawing()? } else { Value::Null },
        "questions": study.questions,
        "scales": study.scales,
        "platform_ids": study.platform_ids,
        "orders": orders(study),
        "end": { "text": study.end.text, "redirect": study.end.redirect },
    }))
}
