//! Recovery of incomplete and damaged recordings.

use super::file::{MessageFile, is_too_many};
use super::provenance::RECOVERED;
use super::{Entry, ReadError, Reader, RecordingError};
use cocarry_output::output_file::OutputFile;
use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

/// The result of a recovery.
#[derive(Debug, Default)]
pub struct Recovered {
    /// The number of messages saved.
    pub messages: u64,
    /// The time of the last message saved, ns.
    pub until: u64,
    /// The faults, in the order of the file; empty for a complete recording.
    pub lost: Vec<ReadError>,
}

/// The number of faults after which the recovery stops reading.
const MAX_FAULTS: usize = 1000;

/// The error of a recovery.
#[derive(Debug, thiserror::Error)]
pub enum RecoverError {
    /// There are no messages to save.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The recovered file cannot be written.
    #[error(transparent)]
    Write(#[from] RecordingError),
}

/// Writes all intact messages of a recording into a new file, with the losses as metadata.
///
/// # Errors
/// [`RecoverError`]: there are no messages to save, or the file cannot be written.
pub fn recover<R: Read>(
    reader: &mut Reader<R>,
    to: &Path,
    overwrite: bool,
) -> Result<Recovered, RecoverError> {
    let output = OutputFile::create(to, overwrite).map_err(RecordingError::from)?;
    let name = to.display().to_string();
    // the damaged recording still exists
    let (recovered, written) = save(reader, output, &name).map_err(|error| match error {
        RecoverError::Write(error) => RecoverError::Write(error.begun()),
        read => read,
    })?;
    written.finish().map_err(RecordingError::from)?;
    Ok(recovered)
}

/// Writes the intact messages. Returns the complete writer, not yet renamed.
fn save<R: Read>(
    reader: &mut Reader<R>,
    output: OutputFile,
    name: &str,
) -> Result<(Recovered, OutputFile), RecoverError> {
    let write = |source| RecordingError::Write { file: name.to_owned(), source };
    let mut file = MessageFile::new(output).map_err(write)?;
    let mut ids = BTreeMap::new();
    let mut recovered = Recovered::default();
    let mut chunk = None;
    let damaged = reader.name().to_owned();
    loop {
        let entry = match reader.next() {
            Ok(None) => break,
            Ok(Some(entry)) => entry,
            Err(fault) => {
                let goes_on = fault.is_local() && recovered.lost.len() < MAX_FAULTS;
                recovered.lost.push(fault);
                if goes_on {
                    continue;
                }
                break;
            }
        };
        let written = match entry {
            Entry::Metadata { name, entries } => file.metadata(&name, &entries),
            Entry::Attachment(attachment) => file.attach(&attachment),
            Entry::Channel { id, definition } => match file.define(definition) {
                Err(error) if is_too_many(&error) => {
                    let what = format!("cannot be saved: {error}");
                    return Err(ReadError::Lacks { file: damaged, what }.into());
                }
                defined => defined.map(|new| {
                    ids.insert(id, new);
                }),
            },
            Entry::Message(message) => {
                (recovered.messages, recovered.until) = (recovered.messages + 1, message.time);
                // the same chunks, so that a complete recording is copied unchanged
                let flushed = if chunk.is_some_and(|c| c != message.chunk) { file.flush() } else { Ok(()) };
                chunk = Some(message.chunk);
                let id = ids.get(&message.id).copied().unwrap_or(message.id);
                flushed.and_then(|()| file.write(id, message.time, message.data))
            }
        };
        written.map_err(write)?;
    }
    if !recovered.lost.is_empty() {
        let lost = recovered.lost.iter().enumerate();
        let entries = lost.map(|(i, fault)| (format!("{:03}", i + 1), fault.place())).collect();
        file.metadata(RECOVERED, &entries).map_err(write)?;
    }
    let written = file.finish().map_err(write)?;
    Ok((recovered, written))
}
