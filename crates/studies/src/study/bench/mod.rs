//! A benchmark with names: how well policies carry, in worlds and with humans and robots that are part of the
//! program and do not change.
//!
//! An episode succeeds if the team arrives and the robot never led a human whose stubbornness exceeded 1. The
//! mean over a world's episodes of 1 / (accumulated objective cost), 0 for one that does not succeed, is a
//! policy's result there (the form of SPL, arXiv:1807.06757, with the cost of the paper's Table II in place of a
//! length). Its score is 100 times the mean over the worlds of its result by the best known one.

mod best;
mod files;
mod gathered;

pub use best::Best;
pub use files::{FILES, NAME};

use super::{Partner, Partners, Study, SweepError};
use crate::statistics::{Estimate, Moments};
use crate::table::{Cell, Columns, Table};
use cocarry::located;
use files::README;
use gathered::{Gathered, MEANS, Of};
use std::path::Path;

/// A set of the benchmark's episodes, which is a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Set {
    /// Six worlds and one robot: 60 episodes.
    Small,
    /// Thirty worlds and three robots: 900 episodes.
    Full,
}

impl Set {
    /// All sets.
    pub const ALL: [Self; 2] = [Self::Small, Self::Full];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Small => "small",
            Self::Full => "full",
        }
    }

    /// Its study in the benchmark's folder.
    pub fn file(self) -> &'static str {
        match self {
            Self::Small => "small.toml",
            Self::Full => "full.toml",
        }
    }

    /// Its number of episodes with one policy.
    pub fn episodes(self) -> u64 {
        match self {
            Self::Small => 6 * 5 * 2,
            Self::Full => 30 * 5 * 3 * 2,
        }
    }
}

/// A policy's results in a set.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The set.
    pub set: Set,
    /// The policy, as in the column `method`.
    pub policy: String,
    /// Version and digest of a custom policy; empty for one of the program's.
    pub code: String,
    /// Its result in every world, in the order of the study.
    pub worlds: Vec<InWorld>,
    /// 100 times the mean over the worlds of its result by the best known one, with its uncertainty.
    pub score: Option<Estimate>,
    of: Of,
}

/// A policy's result in a world.
#[derive(Clone, Debug)]
pub struct InWorld {
    /// The world, as in the column `world`.
    pub world: String,
    /// Mean of 1 / (accumulated objective cost) of episodes that succeeded and 0 of others, 1/m.
    pub result: f64,
    /// The best known result there; `None` if there is none yet.
    pub best: Option<Best>,
}

impl InWorld {
    /// The result by the best known one.
    pub fn share(&self) -> Option<f64> {
        self.best.as_ref().map(|best| self.result / best.result)
    }
}

/// The entries of files of results, best first.
#[derive(Clone, Debug)]
pub struct ScoreCard(Vec<Entry>);

/// The check that a folder has the benchmark's studies, worlds and robots as they ship.
///
/// # Errors
/// [`SweepError`], which names a file that is missing or differs.
pub fn check(folder: &Path) -> Result<(), SweepError> {
    for (name, contents) in FILES.iter().filter(|(name, _)| *name != README) {
        let file = folder.join(name);
        let read = match std::fs::read(&file) {
            Ok(read) => read,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                return Err(SweepError::not_the_benchmarks(file.display().to_string(), NAME));
            }
            Err(error) => return Err(located::unreadable(file.display().to_string(), error).into()),
        };
        // a version control may have other ends of lines
        if read != *contents && without_returns(&read) != without_returns(contents) {
            return Err(SweepError::not_the_benchmarks(file.display().to_string(), NAME));
        }
    }
    Ok(())
}

fn without_returns(text: &[u8]) -> Vec<u8> {
    text.iter().copied().filter(|byte| *byte != b'\r').collect()
}

impl ScoreCard {
    /// Reads results of the benchmark's studies in `folder`: of all their episodes, run by this version of the
    /// program on an arithmetic as this machine's, and with no value changed since.
    ///
    /// # Errors
    /// [`SweepError`], which names the file, and the row, and why it does not count.
    pub fn load(folder: &Path, results: &[super::Results]) -> Result<Self, SweepError> {
        check(folder)?;
        let mut entries = Vec::new();
        for gathered in Gathered::read(results)? {
            let set = gathered.set()?;
            let policies = gathered.policies();
            let partner = |[policy, code]: &[String; 2]| match code.is_empty() {
                true => Partner::BuiltIn(policy.clone()),
                false => Partner::Custom { name: policy.clone(), code: code.clone() },
            };
            let partners = Partners::new(policies.iter().map(partner).collect(), Vec::new())?;
            let study = Study::load_with(&folder.join(set.file()), None, partners)?;
            gathered.check(&study)?;
            entries.extend(policies.into_iter().map(|key| entry(set, &gathered, key)));
        }
        let of = |entry: &Entry| entry.score.map_or(f64::NAN, |score| score.mean);
        entries.sort_by(|a, b| a.set.cmp(&b.set).then_with(|| of(b).total_cmp(&of(a))));
        Ok(Self(entries))
    }

    /// The entries: small set first, then by score.
    pub fn entries(&self) -> &[Entry] {
        &self.0
    }

    /// A line for every entry.
    pub fn table(&self) -> Table {
        let mut columns = Columns::of(&self.0)
            .text("set", "set", |entry| entry.set.name())
            .text("policy", "policy", |entry| entry.policy.clone())
            .data("policy_code", |entry| entry.code.clone())
            .column("score (95 %)", false, &["score", "score_low", "score_high"], |entry| score(entry.score))
            .column("success %", false, &["success_percent"], |entry| figure(entry.of.succeeded.mean(), 1))
            .column("arrived %", false, &["arrived_percent"], |entry| figure(entry.of.arrived.mean(), 1));
        for (i, mean) in MEANS.iter().enumerate() {
            let of = move |entry: &Entry| figure(entry.of.means[i].mean(), 1);
            columns = columns.column(mean.heading, false, &[mean.key], of);
        }
        columns
            .table("bench", NAME)
            .with_note("score: 100 is the best known in every world; the interval is over worlds.")
            .with_note("success: arrived, and never led a human whose stubbornness exceeds 1.")
            .with_note("off: share of the steps off the option that the human prefers; force: internal; work: the human's share. They and the time are means over episodes that arrived.")
    }

    /// A line for every world and entry, world by world.
    pub fn world_table(&self) -> Table {
        let all = self.0.iter().flat_map(|entry| entry.worlds.iter().enumerate().map(move |at| (entry, at)));
        let mut lines: Vec<(&Entry, (usize, &InWorld))> = all.collect();
        lines.sort_by_key(|(entry, (number, _))| (entry.set, *number));
        let lines: Vec<(&Entry, &InWorld)> =
            lines.into_iter().map(|(entry, (_, world))| (entry, world)).collect();
        Columns::of(&lines)
            .text("set", "set", |(entry, _)| entry.set.name())
            .text("world", "world", |(_, world)| world.world.clone())
            .text("policy", "policy", |(entry, _)| entry.policy.clone())
            .data("policy_code", |(entry, _)| entry.code.clone())
            .number("result (1/km)", "result_per_km", 4, |(_, world)| 1000.0 * world.result)
            .column("best known", false, &["best_per_km"], |(_, world)| {
                figure(world.best.as_ref().map(|best| 1000.0 * best.result), 4)
            })
            .text("by", "best_policy", |(_, world)| {
                world.best.as_ref().map_or("-".to_owned(), |best| best.policy.clone())
            })
            .column("share %", false, &["share_percent"], |(_, world)| {
                figure(world.share().map(|share| 100.0 * share), 1)
            })
            .table("bench-worlds", format!("{NAME}, world by world"))
            .with_note("result: mean of 1 / (accumulated objective cost), 0 without success.")
    }
}

/// A number, or `-` if there is none.
fn figure(number: Option<f64>, decimals: usize) -> Cell {
    let shown = number.map_or("-".to_owned(), |number| format!("{number:.decimals$}"));
    Cell { shown, values: vec![number.into()] }
}

fn score(score: Option<Estimate>) -> Cell {
    let Some(Estimate { mean, interval, .. }) = score else {
        return Cell { shown: "-".to_owned(), values: vec![().into(); 3] };
    };
    let half = interval.map_or(String::new(), |[low, high]| format!(" ± {:.1}", (high - low) / 2.0));
    let values = [Some(mean), interval.map(|ends| ends[0]), interval.map(|ends| ends[1])];
    Cell { shown: format!("{mean:.1}{half}"), values: values.map(Into::into).into() }
}

fn entry(set: Set, gathered: &Gathered, [policy, code]: [String; 2]) -> Entry {
    let (of, results) = gathered.of([policy.clone(), code.clone()]);
    let world = |(world, result): (String, f64)| {
        let best = best::of(set, &world);
        InWorld { world, result, best }
    };
    let worlds: Vec<InWorld> = results.into_iter().map(world).collect();
    let mut shares = Moments::default();
    for share in worlds.iter().filter_map(InWorld::share) {
        shares.add(100.0 * share, 100.0 * share);
    }
    Entry { set, policy, code, worlds, score: shares.estimate(true), of }
}
