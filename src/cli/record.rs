//! `--record`: an episode, step by step, in; a recording out, finished also where the user stops the run.

use super::output::Failure;
use crate::episode::Episode;
use crate::recording::{Ending, FileRecorder, RecordingError};
use crate::scenario::Stage;
use anyhow::anyhow;
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Where to record to.
#[derive(Args, Debug)]
pub(super) struct RecordArguments {
    /// Record the episode into this MCAP file, to watch in Foxglove and to be read by `cocarry inspect`. A recording holds an episode from its
    /// start: not with --resume
    #[arg(long, value_name = "FILE", conflicts_with = "resume")]
    record: Option<PathBuf>,
    /// Replace an existing recording
    #[arg(long, requires = "record")]
    overwrite: bool,
}

/// A recording under way, or none.
pub(super) struct Recording<'a> {
    file: Option<(PathBuf, FileRecorder<'a>)>,
    interrupted: Arc<AtomicBool>,
}

impl RecordArguments {
    /// Begins to record an episode that has not begun, if that is asked for. From then on Ctrl-C stops the episode, not the program.
    pub fn begin<'a>(&self, stage: &'a Stage, episode: &Episode) -> Result<Recording<'a>, Failure> {
        let interrupted = Arc::new(AtomicBool::new(false));
        let Some(file) = &self.record else { return Ok(Recording { file: None, interrupted }) };
        let recorder = FileRecorder::create(file, self.overwrite, stage, episode).map_err(output)?;
        let flag = Arc::clone(&interrupted);
        let stop = move || {
            // one who asks twice does not want to wait
            if flag.swap(true, Ordering::Relaxed) {
                std::process::exit(130);
            }
        };
        ctrlc::set_handler(stop)
            .map_err(|error| Failure::Output(anyhow!(error).context("Ctrl-C cannot be caught")))?;
        Ok(Recording { file: Some((file.clone(), recorder)), interrupted })
    }
}

impl Recording<'_> {
    /// Whether the user wants the run to stop.
    pub fn is_interrupted(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed)
    }

    /// Writes the step that the episode has just taken.
    pub fn step(&mut self, episode: &Episode) -> Result<(), Failure> {
        self.file.as_mut().map_or(Ok(()), |(_, recorder)| recorder.step(episode).map_err(output))
    }

    /// Finishes the file. With what code to exit, if the user stopped the run.
    pub fn finish(self, episode: &Episode) -> Result<Option<ExitCode>, Failure> {
        let interrupted = self.is_interrupted();
        let Some((file, recorder)) = self.file else { return Ok(None) };
        let summary = episode.summary();
        let ending = if interrupted { Ending::Interrupted } else { Ending::Over(summary.outcome) };
        recorder.finish(episode, ending).map_err(output)?;
        Ok(interrupted.then(|| {
            eprintln!("interrupted after {} steps, which are in {}", summary.steps, file.display());
            ExitCode::from(130)
        }))
    }
}

pub(super) fn output(error: RecordingError) -> Failure {
    Failure::Output(error.into())
}
