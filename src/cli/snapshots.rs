//! The arguments of snapshots: which steps to save, and what to resume.

use super::output::{Failure, input, write_file};
use super::scenario::ScenarioArguments;
use crate::arithmetic;
use crate::episode::Episode;
use crate::output_file::Outputs;
use crate::scenario::{PreparedScenario, ScenarioError, Snapshot};
use anyhow::{Error, anyhow};
use clap::{Args, Command, Id};
use std::path::PathBuf;

/// The arguments that define a scenario: a snapshot has its own.
fn settled() -> impl Iterator<Item = Id> {
    let command = ScenarioArguments::augment_args(Command::new(""));
    command.get_arguments().map(|argument| argument.get_id().clone()).collect::<Vec<_>>().into_iter()
}

/// Where an episode is cut, and gone on with.
#[derive(Args, Debug)]
pub(super) struct SnapshotArguments {
    /// Save the episode after so many steps: `--resume FILE` goes on from there. May be given several times; ends with 2 if the episode does
    /// not come so far
    #[arg(long, num_args = 2, value_names = ["TICK", "FILE"])]
    save_at: Vec<String>,
    /// Go on with an episode that was saved, to the end and to the same bits. World, human, team and robot are in the file. What is told
    /// of single ticks begins there; sums are of the whole episode
    #[arg(long, value_name = "FILE", conflicts_with_all = settled())]
    pub resume: Option<PathBuf>,
}

/// Snapshots to write, the earliest first.
pub(super) struct Saves(Vec<Save>);

struct Save {
    tick: u64,
    file: PathBuf,
    is_written: bool,
}

impl SnapshotArguments {
    /// The snapshot to go on from.
    pub fn load(&self) -> Result<Option<Snapshot>, Failure> {
        let Some(file) = &self.resume else { return Ok(None) };
        let snapshot = Snapshot::load(file).map_err(input)?;
        let (theirs, ours) = (&snapshot.written_by, env!("CARGO_PKG_VERSION"));
        if theirs != ours {
            eprintln!(
                "note: {} was written by cocarry {theirs}; with {ours} the episode may go on differently",
                file.display()
            );
        }
        let (theirs, ours) = (&snapshot.arithmetic, arithmetic::stamp());
        if theirs != ours {
            eprintln!(
                "note: {} was saved with arithmetic {}, this program has {ours}: the last bits of the episode will not be those that it would have had there",
                file.display(),
                theirs.escape_debug()
            );
        }
        Ok(Some(snapshot))
    }

    /// The error about a scenario, which is the snapshot's where there is one.
    pub fn refused(&self, error: ScenarioError) -> Failure {
        match &self.resume {
            None => input(error),
            Some(file) => input(Error::from(error).context(file.display().to_string())),
        }
    }

    /// The snapshots to write of an episode that begins, or goes on after `resumed` steps.
    pub fn saves(&self, resumed: Option<u64>) -> Result<Saves, Failure> {
        let save = |pair: &[String]| {
            let [tick, file] = pair else { return Err(anyhow!("--save-at takes TICK and FILE")) };
            let Ok(tick) = tick.parse() else {
                return Err(anyhow!("--save-at {tick} {file}: TICK must be a whole number of steps"));
            };
            match resumed.filter(|&from| tick < from) {
                Some(from) => Err(anyhow!("--save-at {tick} {file}: the snapshot is of step {from} already")),
                None => Ok(Save { tick, file: file.into(), is_written: false }),
            }
        };
        self.save_at.chunks(2).map(save).collect::<Result<_, _>>().map(Saves).map_err(Failure::Input)
    }
}

impl Saves {
    /// The files to be written.
    pub fn files(&self) -> impl Iterator<Item = &PathBuf> {
        self.0.iter().map(|save| &save.file)
    }

    /// Writes what is due.
    pub fn write(
        &mut self,
        outputs: &Outputs,
        stage: &PreparedScenario,
        episode: &Episode,
    ) -> Result<(), Failure> {
        let steps = episode.summary().steps;
        for save in self.0.iter_mut().filter(|save| save.tick == steps) {
            let bytes = stage.snapshot(episode).bytes().map_err(|e| Failure::Output(e.into()))?;
            write_file(outputs, &save.file, bytes)?;
            save.is_written = true;
        }
        Ok(())
    }

    /// The episode is over after so many steps: what was not due is not written.
    pub fn finish(&self, steps: u64) -> Result<(), Failure> {
        match self.0.iter().find(|save| !save.is_written) {
            None => Ok(()),
            Some(Save { tick, file, .. }) => {
                let file = file.display();
                Err(input(anyhow!(
                    "--save-at {tick} {file}: the episode ended after {steps} steps; {file} is not written"
                )))
            }
        }
    }
}
