//! The arguments of snapshots: the steps to save, and the snapshot to resume.

use super::output::{Failure, input, warn, write_file};
use super::scenario::ScenarioArguments;
use anyhow::{Error, anyhow};
use clap::{Args, Command, Id};
use cocarry::arithmetic;
use cocarry::episode::Episode;
use cocarry::scenario::{PreparedScenario, Snapshot};
use cocarry_output::output_file::Outputs;
use std::path::PathBuf;
use std::process::ExitCode;

/// The arguments that define a scenario. They conflict with --resume, since a snapshot has its own scenario.
fn settled() -> impl Iterator<Item = Id> {
    let command = ScenarioArguments::augment_args(Command::new(""));
    command.get_arguments().map(|argument| argument.get_id().clone()).collect::<Vec<_>>().into_iter()
}

/// The snapshots of a run: to write, and to resume.
#[derive(Args, Debug)]
pub(super) struct SnapshotArguments {
    /// Save the episode into FILE after TICK steps, as in --save-at 60 half.snapshot; --resume FILE continues
    /// from there. May be given several times. Exits with 2 if the episode ends earlier
    #[arg(long, num_args = 2, value_names = ["TICK", "FILE"])]
    save_at: Vec<String>,
    /// Resume the episode saved in this file, with the same bits as without interruption. The file has the
    /// world, human, team and robot. Per-tick output starts at the resumed step; totals cover the whole
    /// episode
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
    /// The snapshot to resume, if any.
    pub fn load(&self) -> Result<Option<Snapshot>, Failure> {
        let Some(file) = &self.resume else { return Ok(None) };
        let snapshot = Snapshot::load(file).map_err(input)?;
        let (theirs, ours) = (&snapshot.written_by, env!("CARGO_PKG_VERSION"));
        if theirs != ours {
            warn(&format!(
                "{} was written by cocarry {theirs}; with {ours} the episode may not resume bit-identically",
                file.display()
            ));
        }
        let (theirs, ours) = (&snapshot.arithmetic, arithmetic::stamp());
        if theirs != ours {
            warn(&format!(
                "{} was saved with arithmetic {theirs}, this program has {ours}: the episode may not resume bit-identically",
                file.display()
            ));
        }
        Ok(Some(snapshot))
    }

    /// Runs `act`, the whole command. With --resume, a panic in it is bad input: the physics engine panics on
    /// a state of its own that is not consistent.
    pub fn guard(&self, act: impl FnOnce() -> Result<ExitCode, Failure>) -> Result<ExitCode, Failure> {
        let Some(file) = &self.resume else { return act() };
        // the error says it
        cocarry::guarded::here(act).unwrap_or_else(|words| {
            let file = file.display();
            Err(input(anyhow!("{file}: the state in it is not consistent: the simulation fails: {words}")))
        })
    }

    /// An error of the scenario, with the name of the snapshot if it comes from one.
    pub fn refused(&self, error: cocarry::Error) -> Failure {
        match &self.resume {
            None => input(error),
            Some(file) => input(Error::from(error).context(file.display().to_string())),
        }
    }

    /// The snapshots to write of an episode from its start, or from `resumed` steps on.
    pub fn saves(&self, resumed: Option<u64>) -> Result<Saves, Failure> {
        let save = |pair: &[String]| {
            let [tick, file] = pair else { return Err(anyhow!("--save-at takes TICK and FILE")) };
            let Ok(tick) = tick.parse() else {
                return Err(anyhow!("--save-at {tick} {file}: TICK must be a whole number of steps"));
            };
            match resumed.filter(|&from| tick < from) {
                Some(from) => Err(anyhow!(
                    "--save-at {tick} {file}: the episode resumes at step {from}; TICK must be at least {from}"
                )),
                None => Ok(Save { tick, file: file.into(), is_written: false }),
            }
        };
        self.save_at.chunks(2).map(save).collect::<Result<_, _>>().map(Saves).map_err(Failure::Input)
    }
}

impl Saves {
    /// The files to write.
    pub fn files(&self) -> impl Iterator<Item = &PathBuf> {
        self.0.iter().map(|save| &save.file)
    }

    /// Writes the snapshots of the present step.
    pub fn write(
        &mut self,
        outputs: &Outputs,
        prepared: &PreparedScenario,
        episode: &Episode,
    ) -> Result<(), Failure> {
        let steps = episode.summary().steps;
        for save in self.0.iter_mut().filter(|save| save.tick == steps) {
            let bytes = prepared.snapshot(episode).bytes().map_err(|e| Failure::Output(e.into()))?;
            write_file(outputs, &save.file, bytes)?;
            save.is_written = true;
        }
        Ok(())
    }

    /// The check, after the last step, that all snapshots were written.
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
