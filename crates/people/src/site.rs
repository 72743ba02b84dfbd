//! The page on which participants answer: its files.

use crate::carry::{drawing, scenarios};
use crate::digest::sha256;
use crate::order::orders;
use crate::study::{PeopleStudy, StudyWorld};
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

/// A script that answers the page, and its plan; the page of people has neither.
const SCRIPT: (&str, &str) = ("simulated.js", include_str!("../../../assets/people/simulated.js"));
const PLAN: &str = "simulated.json";

/// What the page knows of the study.
const STUDY: &str = "study.json";

/// The simulator, in the page of a study in which people carry.
const MODULE: &str = "cocarry.wasm";

/// Where the page sends what it records.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Sink {
    /// To the server that it comes from.
    Server,
    /// Into a file, which the participant downloads at the end and hands over.
    Download,
    /// To JATOS, in which the page is a component of a study.
    Jatos,
    /// To DataPipe, which passes it on to a project of the Open Science Framework: the experiment's id there.
    DataPipe(String),
}

/// Where DataPipe takes answers.
const DATAPIPE: &str = "https://pipe.jspsych.org";

impl Sink {
    /// Its name, as the page knows it.
    fn name(&self) -> &'static str {
        match self {
            Self::Server => "server",
            Self::Download => "download",
            Self::Jatos => "jatos",
            Self::DataPipe(_) => "datapipe",
        }
    }

    /// What the head of the page has for it: the page loads nothing from elsewhere, and sends nothing but to
    /// its sink. Our own server says that itself.
    fn head(&self) -> String {
        let (hosts, script) = match self {
            Self::Server => return String::new(),
            Self::Download => ("", ""),
            // JATOS has this file next to every component, and runs a worker
            Self::Jatos => ("", "<script src=\"jatos.js\"></script>\n"),
            Self::DataPipe(_) => (DATAPIPE, ""),
        };
        let others = if *self == Self::Jatos { "; worker-src 'self' blob:" } else { "" };
        let connect = format!("'self' {hosts}");
        let connect = connect.trim_end();
        format!(
            "<meta http-equiv=\"content-security-policy\" content=\"default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; \
             style-src 'self' 'unsafe-inline'; img-src 'self' data:; connect-src {connect}; base-uri 'none'; form-action 'none'{others}\">\n\
             {script}"
        )
    }
}

/// Before this of the built client comes what a sink needs.
const BEFORE: &str = "<link rel=\"icon\"";

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
    pub fn new(study: &PeopleStudy, sink: Sink, module: Option<Cow<'static, [u8]>>) -> Result<Self, Error> {
        let shots: Vec<Shots> =
            study.worlds.iter().map(|world| Shots::of(world, study.shows_openings)).collect();
        let mut content = content(study, &shots)?;
        let scenarios = if study.has_carry() { scenarios(study)? } else { Vec::new() };
        let shown = shots.iter().map(|shots| &shots.map).chain(scenarios.iter().map(|(_, text)| text));
        let shown: String = shown.map(String::as_str).collect();
        let digest = sha256((content.to_string() + &shown).as_bytes());
        content["digest"] = json!(digest);
        content["sink"] = json!(sink.name());
        if let Sink::DataPipe(experiment) = &sink {
            content["datapipe"] =
                json!({ "address": format!("{DATAPIPE}/api/data/"), "experiment": experiment });
        }
        // without a server of ours, whoever reads the page's files finds the code in them
        if sink != Sink::Server {
            content["end"]["code"] = json!(study.end.code);
        }
        let head = sink.head();
        let client = CLIENT.iter().map(|&(name, mime, text)| SiteFile {
            name: name.into(),
            mime,
            bytes: match name {
                "index.html" => text.replacen(BEFORE, &format!("{head}{BEFORE}"), 1).into_bytes().into(),
                _ => text.as_bytes().into(),
            },
        });
        let maps = shots.into_iter().enumerate().map(|(at, shots)| SiteFile {
            name: map_file(at).into(),
            mime: "image/svg+xml",
            bytes: shots.map.into_bytes().into(),
        });
        let study = SiteFile {
            name: STUDY.into(),
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

impl Site {
    /// The page, with the script that answers it by a plan. `parameter` of its address says for whom.
    pub(crate) fn answering(mut self, parameter: &str, plan: &Value) -> Self {
        let (script, text) = SCRIPT;
        for file in &mut self.files {
            let text = str::from_utf8(&file.bytes);
            let changed = match &*file.name {
                "index.html" => {
                    let before = format!("<script type=\"module\" src=\"{script}\"></script>\n{BEFORE}");
                    text.expect("the page is text").replacen(BEFORE, &before, 1)
                }
                STUDY => {
                    let text = text.expect("the study is text");
                    let mut content: Value = serde_json::from_str(text).expect("the study is JSON");
                    content["platform_ids"] = json!([parameter]);
                    content.to_string()
                }
                _ => continue,
            };
            file.bytes = changed.into_bytes().into();
        }
        let mime = "text/javascript; charset=utf-8";
        self.files.push(SiteFile { name: script.into(), mime, bytes: text.as_bytes().into() });
        let bytes = plan.to_string().into_bytes().into();
        self.files.push(SiteFile { name: PLAN.into(), mime: "application/json", bytes });
        self
    }
}

/// The file of the map of a world, by its index.
fn map_file(world: usize) -> String {
    format!("maps/{}.svg", world + 1)
}

/// What the page knows. It has no risk, no length, no completion code, and no answer of anybody; it does have
/// the right answers of questions.
fn content(study: &PeopleStudy, shots: &[Shots]) -> Result<Value, Error> {
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
