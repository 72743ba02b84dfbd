//! The provenance of a recording: its scenario, versions and arithmetic.

use super::records::Attachment;
use super::{Entry, ReadError, Reader};
use cocarry::Error;
use cocarry::scenario::{Scenario, WorldText};
use cocarry::{arithmetic, bounds};
use std::collections::BTreeMap;
use std::io::Read;

/// The name of the metadata record with the provenance.
pub const METADATA: &str = "cocarry";
/// The name of the metadata record with the losses of [`recover`](super::recover()).
pub const RECOVERED: &str = "recovered";
/// The size of the largest scenario that is read, bytes: a world and a robot.
const MAX_BYTES: usize = bounds::SCENARIO.bytes() as usize;
/// The key of the version of the program that wrote a recording.
pub const VERSION: &str = "crate_version";
/// The key of the [stamp](arithmetic::stamp) of a recording's arithmetic.
pub(super) const ARITHMETIC: &str = "arithmetic";
/// The name of the attachment with the scenario's text.
pub const SCENARIO: &str = "scenario.toml";

/// The provenance of a recording: everything that a replay needs. It has no wall clock, host or path, so that
/// equal runs give equal bytes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Provenance {
    /// Short facts by key.
    pub metadata: BTreeMap<String, String>,
    /// The input texts of the run.
    pub attachments: Vec<Attachment>,
}

impl Provenance {
    /// The provenance of a recording of a scenario. Files are named without their folders.
    ///
    /// # Errors
    /// A value cannot be written as TOML.
    pub fn of(scenario: &Scenario) -> Result<Self, Error> {
        let mut scenario = scenario.clone();
        let (file, text) = (stripped(scenario.world.file()), scenario.world.text().to_owned());
        scenario.world = WorldText { file, text }.into();
        if let Some(setup) = scenario.plant.robot_setup_mut() {
            let mut texts = setup.robot.texts().clone();
            texts.file = stripped(&texts.file);
            texts.urdf_file = stripped(&texts.urdf_file);
            setup.robot = texts.into();
        }
        let facts = [
            (VERSION, env!("CARGO_PKG_VERSION").to_owned()),
            (ARITHMETIC, arithmetic::stamp().to_owned()),
            ("seed", scenario.seed.to_string()),
            ("world", scenario.world.file().to_owned()),
            ("plant", scenario.plant.name().to_owned()),
            ("method", scenario.settings.method.name().to_owned()),
        ];
        let attachment = Attachment {
            name: SCENARIO.to_owned(),
            media_type: "application/toml".to_owned(),
            data: scenario.text()?.into_bytes(),
        };
        let metadata = facts.map(|(key, value)| (key.to_owned(), value)).into();
        Ok(Self { metadata, attachments: vec![attachment] })
    }
}

/// The name of a file without its folders.
fn stripped(path: &str) -> String {
    path.rsplit_once(['/', '\\']).map_or(path, |(_, name)| name).to_owned()
}

/// The scenario of a recording. Reads up to its attachment.
///
/// # Errors
/// [`ReadError`], also if there is no scenario before the first message.
pub fn scenario<R: Read>(reader: &mut Reader<R>) -> Result<Scenario, ReadError> {
    let file = reader.name().to_owned();
    let lacks = |what: &str| ReadError::Lacks { file: file.clone(), what: what.to_owned() };
    while let Some(entry) = reader.next()? {
        match entry {
            Entry::Attachment(attachment) if attachment.name == SCENARIO => {
                if attachment.data.len() > MAX_BYTES {
                    return Err(lacks(&format!(
                        "its attachment scenario.toml is larger than {MAX_BYTES} bytes"
                    )));
                }
                let text = String::from_utf8(attachment.data);
                let text = text.map_err(|_| lacks("its attachment scenario.toml is not UTF-8"))?;
                return Scenario::parse(&text)
                    .map_err(|source| ReadError::Scenario { file: file.clone(), source });
            }
            Entry::Message(_) => break,
            _ => {}
        }
    }
    Err(lacks("has no attachment scenario.toml, which defines the run"))
}
