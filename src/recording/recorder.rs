//! A recording of a running episode.

use super::channel::{Channel, Message};
use super::encoder::{Encoder, Ending};
use super::file::MessageFile;
use super::provenance::{METADATA, Provenance};
use super::{Definition, RecordingError};
use crate::episode::Episode;
use crate::output_file::OutputFile;
use crate::scenario::PreparedScenario;
use std::collections::BTreeMap;
use std::io::{Seek, Write};
use std::path::Path;

const SECOND: u64 = 1_000_000_000;

/// Writes an episode as MCAP. All up to the last whole second of simulated time is in the system's hands.
pub struct Recorder<'a, W: Write + Seek> {
    encoder: Encoder<'a>,
    file: MessageFile<W>,
    name: String,
    channels: BTreeMap<Channel, u16>,
    /// Whole simulated seconds that are written.
    seconds: u64,
}

impl<'a, W: Write + Seek> Recorder<'a, W> {
    /// Writes provenance, scene and start of an episode that has not begun; `name` is what errors call the
    /// file.
    ///
    /// # Errors
    /// [`RecordingError`]: it cannot be written, or the scenario cannot.
    pub fn new(
        to: W,
        name: &str,
        stage: &'a PreparedScenario,
        episode: &Episode,
    ) -> Result<Self, RecordingError> {
        let mut encoder = Encoder::new(stage);
        let provenance = Provenance::of(stage.scenario())
            .map_err(|source| RecordingError::Scenario { file: name.to_owned(), source })?;
        let written = MessageFile::new(to).and_then(|mut file| {
            file.metadata(METADATA, &provenance.metadata)?;
            provenance.attachments.iter().try_for_each(|attachment| file.attach(attachment))?;
            // all in the first chunk: what follows can be read without the file's end
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
        Ok(Self { encoder, file, name: name.to_owned(), channels, seconds: 0 })
    }

    /// Writes the step that the episode has just taken.
    ///
    /// # Errors
    /// [`RecordingError::Write`].
    pub fn step(&mut self, episode: &Episode) -> Result<(), RecordingError> {
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

    /// Writes the end, and gives back what was written to.
    ///
    /// # Errors
    /// [`RecordingError::Write`].
    pub fn finish(mut self, episode: &Episode, ending: Ending) -> Result<W, RecordingError> {
        let written = write(&mut self.file, &self.channels, self.encoder.end(episode, ending));
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

/// A [`Recorder`] into a file, which is called `<name>.partial` until it is finished.
pub struct FileRecorder<'a>(Recorder<'a, OutputFile>);

impl<'a> FileRecorder<'a> {
    /// As [`Recorder::new`]. An existing file is only replaced if told to `overwrite`.
    ///
    /// # Errors
    /// [`RecordingError`]: the file exists or cannot be written.
    pub fn create(
        file: &Path,
        overwrite: bool,
        stage: &'a PreparedScenario,
        episode: &Episode,
    ) -> Result<Self, RecordingError> {
        let mut to = OutputFile::anew(file, overwrite)?;
        to.keep();
        let partial = to.partial().to_owned();
        let recorder = Recorder::new(to, &partial.display().to_string(), stage, episode);
        Ok(Self(recorder.map_err(|error| {
            // without its first chunk it is of no use; if it cannot be removed, the first error matters
            let _ = std::fs::remove_file(&partial);
            error.begun()
        })?))
    }

    /// As [`Recorder::step`].
    ///
    /// # Errors
    /// [`RecordingError::Write`].
    pub fn step(&mut self, episode: &Episode) -> Result<(), RecordingError> {
        self.0.step(episode)
    }

    /// Writes the end, and gives the file its name.
    ///
    /// # Errors
    /// [`RecordingError`]: it cannot be written, or renamed.
    pub fn finish(self, episode: &Episode, ending: Ending) -> Result<(), RecordingError> {
        Ok(self.0.finish(episode, ending)?.finish()?)
    }
}
