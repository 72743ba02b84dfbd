//! Recorders of running episodes.

use super::channel::{Channel, Message};
use super::decisions;
use super::encoder::Encoder;
use super::ending::Ending;
use super::file::MessageFile;
use super::provenance::{METADATA, Provenance};
use super::{Definition, RecordingError};
use cocarry::episode::Episode;
use cocarry::scenario::{Decisions, PreparedScenario};
use cocarry_output::output_file::OutputFile;
use std::collections::BTreeMap;
use std::io::{Seek, Write};
use std::path::Path;

const SECOND: u64 = 1_000_000_000;

/// A recorder of an episode as MCAP. It hands the file to the system at every whole simulated second.
pub struct Recorder<'a, W: Write + Seek> {
    encoder: Encoder<'a>,
    file: MessageFile<W>,
    name: String,
    channels: BTreeMap<Channel, u16>,
    /// The number of whole simulated seconds written.
    seconds: u64,
    decisions: Decisions,
}

impl<'a, W: Write + Seek> Recorder<'a, W> {
    /// A recorder before the first step, with provenance, scene and start written. Errors call the file
    /// `name`.
    ///
    /// # Errors
    /// [`RecordingError`]: it cannot be written, or the scenario cannot.
    pub fn new(
        to: W,
        name: &str,
        prepared: &'a PreparedScenario,
        episode: &Episode,
    ) -> Result<Self, RecordingError> {
        let mut encoder = Encoder::new(prepared);
        let provenance = Provenance::of(prepared.scenario())
            .map_err(|source| RecordingError::Scenario { file: name.to_owned(), source })?;
        let written = MessageFile::new(to).and_then(|mut file| {
            file.metadata(METADATA, &provenance.metadata)?;
            provenance.attachments.iter().try_for_each(|attachment| file.attach(attachment))?;
            // these are in the first chunk, so that a reader does not need the end of the file
            let mut channels = BTreeMap::new();
            for channel in encoder.channels(episode) {
                channels.insert(channel, file.define(&Definition::of(channel))?);
            }
            write(&mut file, &channels, encoder.begin(episode))?;
            file.flush()?;
            Ok((file, channels))
        });
        let (file, channels) =
            written.map_err(|source| RecordingError::Write { file: name.to_owned(), source })?;
        Ok(Self {
            encoder,
            file,
            name: name.to_owned(),
            channels,
            seconds: 0,
            decisions: Decisions::default(),
        })
    }

    /// The same recorder, which also logs the decisions of custom partners, so that the recording can be
    /// replayed.
    #[must_use]
    pub fn logging(self, decisions: Decisions) -> Self {
        Self { decisions, ..self }
    }

    /// Writes the last step of the episode.
    ///
    /// # Errors
    /// [`RecordingError::Write`].
    pub fn step(&mut self, episode: &Episode) -> Result<(), RecordingError> {
        self.decisions.add(episode);
        let messages = self.encoder.step(episode);
        let seconds = messages.last().map_or(0, |message| message.time) / SECOND;
        let written = write(&mut self.file, &self.channels, messages);
        let written = written.and_then(|()| match seconds > self.seconds {
            true => self.file.flush(),
            false => Ok(()),
        });
        self.seconds = seconds;
        written.map_err(|source| RecordingError::Write { file: self.name.clone(), source })
    }

    /// Writes the end, and returns the writer.
    ///
    /// # Errors
    /// [`RecordingError::Write`].
    pub fn finish(mut self, episode: &Episode, ending: Ending) -> Result<W, RecordingError> {
        let written = write(&mut self.file, &self.channels, self.encoder.end(episode, ending));
        let attached = decisions::attachment(&self.decisions);
        let written =
            written.and_then(|()| attached.map_or(Ok(()), |decisions| self.file.attach(&decisions)));
        let finished = written.and_then(|()| self.file.finish());
        finished.map_err(|source| RecordingError::Write { file: self.name, source })
    }
}

fn write<W: Write + Seek>(
    file: &mut MessageFile<W>,
    channels: &BTreeMap<Channel, u16>,
    messages: &[Message],
) -> Result<(), std::io::Error> {
    messages.iter().try_for_each(|message| match channels.get(&message.channel) {
        Some(channel) => file.write(*channel, message.time, &message.data),
        None => Ok(()),
    })
}

/// A [`Recorder`] into a file, whose name is `<name>.partial` until it is finished.
pub struct FileRecorder<'a>(Recorder<'a, OutputFile>);

impl<'a> FileRecorder<'a> {
    /// As [`Recorder::new`]. An existing file is only replaced with `overwrite`.
    ///
    /// # Errors
    /// [`RecordingError`]: the file exists or cannot be written.
    pub fn create(
        file: &Path,
        overwrite: bool,
        prepared: &'a PreparedScenario,
        episode: &Episode,
    ) -> Result<Self, RecordingError> {
        let mut to = OutputFile::anew(file, overwrite)?;
        to.keep();
        let partial = to.partial().to_owned();
        let recorder = Recorder::new(to, &partial.display().to_string(), prepared, episode);
        Ok(Self(recorder.map_err(|error| {
            // without its first chunk the file is useless; if the removal fails, the first error is reported
            let _ = std::fs::remove_file(&partial);
            error.begun()
        })?))
    }

    /// As [`Recorder::logging`].
    #[must_use]
    pub fn logging(self, decisions: Decisions) -> Self {
        Self(self.0.logging(decisions))
    }

    /// As [`Recorder::step`].
    ///
    /// # Errors
    /// [`RecordingError::Write`].
    pub fn step(&mut self, episode: &Episode) -> Result<(), RecordingError> {
        self.0.step(episode)
    }

    /// Writes the end, and renames the file.
    ///
    /// # Errors
    /// [`RecordingError`]: it cannot be written, or renamed.
    pub fn finish(self, episode: &Episode, ending: Ending) -> Result<(), RecordingError> {
        Ok(self.0.finish(episode, ending)?.finish()?)
    }
}
