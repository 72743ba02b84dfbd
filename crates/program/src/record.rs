//! `--record` and `--render`: the recording of a run, written or rendered, and finished also when the user
//! stops the run.

use super::output::{Failure, input, mcap_file, unwritten};
use super::render::{Form, Target};
use clap::Args;
use cocarry::episode::Episode;
use cocarry::scenario::{Decisions, PreparedScenario};
use cocarry_output::output_file::Outputs;
use cocarry_recording::recording::{Ending, FileRecorder, Reader, Recorder, RecordingError};
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// The files to record and to render into.
#[derive(Args, Debug)]
pub(super) struct RecordArguments {
    /// Record the episode into this MCAP file, for Foxglove and `cocarry inspect`. Not with --resume, since a
    /// recording holds a whole episode
    #[arg(long, value_name = "FILE", value_parser = mcap_file, conflicts_with = "resume")]
    pub record: Option<PathBuf>,
    /// Render the episode into this file, as `cocarry render` does from a recording: a 3-D player (.html), a
    /// filmstrip (.svg, .png) or an animation (.gif). Not with --resume
    #[arg(long, value_name = "FILE", value_parser = Target::of, conflicts_with = "resume")]
    render: Option<Target>,
}

/// The recording of a run: into a file, in memory to be rendered, both or neither.
pub(super) struct Recording<'a> {
    file: Option<(PathBuf, FileRecorder<'a>)>,
    in_memory: Option<(Target, Recorder<'a, Cursor<Vec<u8>>>)>,
}

impl RecordArguments {
    /// The files to write.
    pub fn files(&self) -> impl Iterator<Item = &PathBuf> {
        self.record.iter().chain(self.rendered())
    }

    /// The file that is rendered into.
    pub fn rendered(&self) -> Option<&PathBuf> {
        self.render.as_ref().map(|target| &target.file)
    }

    /// Begins the recording before the first step, with the log of custom partners.
    pub fn begin<'a>(
        &self,
        prepared: &'a PreparedScenario,
        episode: &Episode,
        decisions: &Decisions,
        overwrite: bool,
    ) -> Result<Recording<'a>, Failure> {
        let file = self.record.as_ref().map(|file| {
            let recorder = FileRecorder::create(file, overwrite, prepared, episode).map_err(output)?;
            Ok((file.clone(), recorder.logging(decisions.clone())))
        });
        let in_memory = self.render.as_ref().map(|target| {
            let recorder = Recorder::new(Cursor::default(), IN_MEMORY, prepared, episode).map_err(output)?;
            Ok((target.clone(), recorder.logging(decisions.clone())))
        });
        Ok(Recording { file: file.transpose()?, in_memory: in_memory.transpose()? })
    }
}

impl Recording<'_> {
    /// Writes the last step of the episode.
    pub fn step(&mut self, episode: &Episode) -> Result<(), Failure> {
        if let Some((_, recorder)) = &mut self.file {
            recorder.step(episode).map_err(output)?;
        }
        self.in_memory.as_mut().map_or(Ok(()), |(_, recorder)| recorder.step(episode).map_err(output))
    }

    /// Finishes the files. `robot` is the robot's file, for its meshes. Returns the name of the recording, if
    /// it is a file.
    pub fn finish(
        self,
        episode: &Episode,
        ending: Ending,
        robot: Option<&Path>,
        outputs: &Outputs,
    ) -> Result<Option<PathBuf>, Failure> {
        let recorded = self.file.map(|(file, recorder)| {
            recorder.finish(episode, ending).map_err(output)?;
            Ok(file)
        });
        let recorded = recorded.transpose()?;
        if let Some((target, recorder)) = self.in_memory {
            let recording = recorder.finish(episode, ending).map_err(output)?.into_inner();
            let mut reader = Reader::new(Cursor::new(recording), IN_MEMORY).map_err(input)?;
            target.render(&mut reader, Form { robot, ..Form::default() }, outputs)?;
        }
        Ok(recorded)
    }
}

/// The name of a recording that is only rendered.
const IN_MEMORY: &str = "the recording of this run";

pub(super) fn output(error: RecordingError) -> Failure {
    match error {
        RecordingError::Output(error) => unwritten(error),
        other => Failure::Output(other.into()),
    }
}
