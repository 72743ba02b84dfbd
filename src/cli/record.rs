//! `--record`: writes the recording of a run, and finishes it also when the user stops the run.

use super::output::{Failure, unwritten};
use crate::episode::Episode;
use crate::recording::{Ending, FileRecorder, RecordingError};
use crate::scenario::PreparedScenario;
use clap::Args;
use std::path::PathBuf;

/// The file to record into.
#[derive(Args, Debug)]
pub(super) struct RecordArguments {
    /// Record the episode into this MCAP file, for Foxglove and `cocarry inspect`. Not with --resume, since a
    /// recording holds a whole episode
    #[arg(long, value_name = "FILE", conflicts_with = "resume")]
    pub record: Option<PathBuf>,
}

/// The recording of a run, if any.
pub(super) struct Recording<'a>(Option<(PathBuf, FileRecorder<'a>)>);

impl RecordArguments {
    /// Begins the recording before the first step, with --record.
    pub fn begin<'a>(
        &self,
        stage: &'a PreparedScenario,
        episode: &Episode,
        overwrite: bool,
    ) -> Result<Recording<'a>, Failure> {
        let Some(file) = &self.record else { return Ok(Recording(None)) };
        let recorder = FileRecorder::create(file, overwrite, stage, episode).map_err(output)?;
        Ok(Recording(Some((file.clone(), recorder))))
    }
}

impl Recording<'_> {
    /// Writes the last step of the episode.
    pub fn step(&mut self, episode: &Episode) -> Result<(), Failure> {
        self.0.as_mut().map_or(Ok(()), |(_, recorder)| recorder.step(episode).map_err(output))
    }

    /// Finishes the file. Returns its name, if there is one.
    pub fn finish(self, episode: &Episode, ending: Ending) -> Result<Option<PathBuf>, Failure> {
        let Some((file, recorder)) = self.0 else { return Ok(None) };
        recorder.finish(episode, ending).map_err(output)?;
        Ok(Some(file))
    }
}

pub(super) fn output(error: RecordingError) -> Failure {
    match error {
        RecordingError::Output(error) => unwritten(error),
        other => Failure::Output(other.into()),
    }
}
