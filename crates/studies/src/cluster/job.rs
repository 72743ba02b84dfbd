//! The folder of a job.

use super::ClusterError;
use crate::parallel::OnDone;
use crate::study::{Partner, Partners, Shard, Study, Sweep, SweepError, SweepOutputs, check_name};
use cocarry::arithmetic;
use cocarry::bounds;
use cocarry::located::{self, Source};
use cocarry_output::output_file::{OutputError, Outputs};
use serde::{Deserialize, Serialize};
use std::fs::{self, OpenOptions};
use std::io::{BufRead, BufReader, Write};
use std::num::NonZeroU64;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// The name of the job's description in its folder.
const DESCRIPTION: &str = "job.toml";
/// The names of the script of a task, of the folder of the shards, and of that of the logs.
const SCRIPT: &str = "task.sh";
const SHARDS: &str = "shards";
const LOGS: &str = "logs";
/// The first lines of the description.
const HEADING: &str =
    "# A study on a cluster; see `cocarry cluster --help`. The program reads and writes this file.\n\n";
/// The largest number of shards.
const MAX_SHARDS: u64 = 1_000_000;

/// The description of a job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Description {
    /// The program's version.
    pub version: String,
    /// The study file, absolute.
    pub study: PathBuf,
    /// The largest number of seeds, if limited.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seeds: Option<NonZeroU64>,
    /// The methods in place of the study's own; none: those of its file.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub methods: Vec<String>,
    /// The study's digest.
    pub digest: String,
    /// The stamp of the arithmetic of the machine that made the job.
    pub arithmetic: String,
    /// The number of episodes of the study.
    pub episodes: u64,
    /// The number of shards.
    pub shards: u64,
    /// Further options of `sbatch`.
    pub sbatch: Vec<String>,
    /// The submitted arrays, in order.
    #[serde(default, rename = "array", skip_serializing_if = "Vec::is_empty")]
    pub arrays: Vec<Array>,
}

/// Tasks that were submitted together. Task `i` runs shard `i + offset`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Array {
    /// The scheduler's identifier.
    pub id: u64,
    /// The difference between a shard's number and its task's.
    pub offset: u64,
    /// Ranges of shards, both ends included.
    pub shards: Vec<[u64; 2]>,
}

impl Array {
    /// Whether it runs a shard.
    pub fn has(&self, shard: u64) -> bool {
        self.shards.iter().any(|[first, last]| (*first..=*last).contains(&shard))
    }
}

/// How far the results of a shard are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Its episodes with results.
    pub done: u64,
    /// Its episodes.
    pub of: u64,
    /// Whether its file is complete.
    pub is_complete: bool,
}

/// A study on a cluster.
#[derive(Clone, Debug)]
pub struct Job {
    results: PathBuf,
    folder: PathBuf,
    description: Description,
}

impl Job {
    /// Makes the folder for a study whose results are to be in `results`: `RESULTS.job`. `script` is the
    /// script of a task. With `overwrite`, an earlier job for these results is removed.
    ///
    /// # Errors
    /// [`ClusterError`], among others where the results or their job exist.
    pub fn create(
        results: &Path,
        description: Description,
        script: impl FnOnce(&Self) -> String,
        overwrite: bool,
    ) -> Result<Self, ClusterError> {
        Outputs::new(overwrite, [description.study.clone()]).check(results)?;
        check_name(results)?;
        let results = std::path::absolute(results).map_err(folder_error(results))?;
        let job = Self { folder: folder_of(&results), results, description };
        if job.folder.join(DESCRIPTION).exists() {
            if !overwrite {
                return Err(ClusterError::exists(job.folder));
            }
            job.remove()?;
        }
        for folder in [&job.folder, &job.folder.join(SHARDS), &job.folder.join(LOGS)] {
            fs::create_dir_all(folder).map_err(folder_error(folder))?;
        }
        Outputs::new(true, []).write(&job.script(), script(&job))?;
        job.save()?;
        Ok(job)
    }

    /// The job for these results.
    ///
    /// # Errors
    /// [`ClusterError`], where there is none, or another version of the program made it.
    pub fn open(results: &Path) -> Result<Self, ClusterError> {
        let results = std::path::absolute(results).map_err(folder_error(results))?;
        let folder = folder_of(&results);
        let path = folder.join(DESCRIPTION);
        if !path.exists() {
            return Err(ClusterError::no_job(results, folder));
        }
        let file = path.display().to_string();
        let text = located::read(&bounds::SETTINGS, &path)?;
        let description: Description = Source { file: &file, text: &text }.parse("job description")?;
        let this = env!("CARGO_PKG_VERSION");
        if description.version != this {
            let made = description.version;
            return Err(ClusterError::other_version(folder, made, this.to_owned()));
        }
        Ok(Self { results, folder, description })
    }

    /// The file of the results, absolute.
    pub fn results(&self) -> &Path {
        &self.results
    }

    /// The job's folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The script of a task.
    pub fn script(&self) -> PathBuf {
        self.folder.join(SCRIPT)
    }

    /// The folder of the scheduler's logs.
    pub fn logs(&self) -> PathBuf {
        self.folder.join(LOGS)
    }

    /// The description.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// Adds what was submitted to the description.
    ///
    /// # Errors
    /// [`ClusterError::Output`].
    pub fn add(&mut self, array: Array) -> Result<(), ClusterError> {
        self.description.arrays.push(array);
        self.save()
    }

    /// The file with the results of a shard.
    pub fn file_of(&self, shard: u64) -> PathBuf {
        self.shard_file(shard, "csv")
    }

    /// The study, as it was when the job was made.
    ///
    /// # Errors
    /// [`ClusterError`].
    pub fn study(&self) -> Result<Study, ClusterError> {
        let Description { study: file, seeds, methods, digest, .. } = &self.description;
        let study = with_methods(file, *seeds, methods)?;
        match study.digest() == digest {
            true => Ok(study),
            false => {
                let (made, now) = (digest.clone(), study.digest().to_owned());
                Err(ClusterError::changed(file.clone(), made, now))
            }
        }
    }

    /// A shard by its number.
    ///
    /// # Errors
    /// [`ClusterError`].
    pub fn shard(&self, number: u64) -> Result<Shard, ClusterError> {
        let of = self.description.shards;
        match (1..=of).contains(&number) {
            true => Ok(Shard { number, of }),
            false => Err(ClusterError::no_shard(number, self.folder.clone(), of)),
        }
    }

    /// Runs the episodes of a shard that have no results yet, on all threads of the current pool. `node` is
    /// the name of this machine. With `stop` it stops after the episodes that are running. Returns how far the
    /// shard was before.
    ///
    /// # Errors
    /// [`ClusterError`], before any episode, where the study has changed or this machine has another
    /// arithmetic.
    pub fn run_shard(
        &self,
        number: u64,
        node: &str,
        on_done: OnDone,
        stop: &AtomicBool,
    ) -> Result<Progress, ClusterError> {
        let shard = self.shard(number)?;
        let study = self.study()?;
        let (found, made) = (arithmetic::stamp(), &self.description.arithmetic);
        if found != made {
            let (node, found, made) = (node.to_owned(), found.to_owned(), made.clone());
            return Err(ClusterError::other_arithmetic(node, found, made));
        }
        let before = self.progress(number);
        if before.is_complete {
            return Ok(before);
        }
        let rows = self.file_of(number);
        let to = SweepOutputs { rows: &rows, ticks: None, overwrite: false };
        let sweep = Sweep::open(&study, Some(shard), to)?;
        let before = Progress { done: sweep.kept(), of: sweep.episodes(), is_complete: false };
        self.note_node(number, shard.episodes(study.episodes()).start + before.done, node)?;
        sweep.run(on_done, stop)?;
        Ok(before)
    }

    /// How far the results of a shard are.
    pub fn progress(&self, number: u64) -> Progress {
        let file = self.file_of(number);
        let episodes = Shard { number, of: self.description.shards }.episodes(self.description.episodes);
        let of = episodes.end - episodes.start;
        if file.exists() {
            return Progress { done: of, of, is_complete: true };
        }
        // complete rows below the header
        let lines = located::open(&self.shard_file(number, "csv.partial")).map_or(0, |file| {
            let mut reader = BufReader::with_capacity(1 << 16, file);
            let mut lines = 0;
            while let Ok(bytes @ [_, ..]) = reader.fill_buf() {
                lines += bytes.iter().filter(|byte| **byte == b'\n').count() as u64;
                let read = bytes.len();
                reader.consume(read);
            }
            lines
        });
        Progress { done: lines.saturating_sub(1).min(of), of, is_complete: false }
    }

    /// The machine that ran an episode, if it was noted.
    pub fn node_of(&self, episode: u64) -> Option<(u64, String)> {
        let Description { shards: of, episodes, .. } = self.description;
        let number = (1..=of).find(|&number| Shard { number, of }.episodes(episodes).contains(&episode))?;
        let notes = located::read(&bounds::TABLE, &self.shard_file(number, "nodes")).unwrap_or_default();
        let starts = notes.lines().filter_map(|line| line.split_once(' '));
        let mut begun = starts.filter(|(first, _)| first.parse().is_ok_and(|first: u64| first <= episode));
        Some((number, begun.next_back().map_or("unknown", |(_, node)| node).to_owned()))
    }

    /// Notes which machine runs a shard from an episode on.
    fn note_node(&self, shard: u64, episode: u64, node: &str) -> Result<(), ClusterError> {
        let path = self.shard_file(shard, "nodes");
        let opened = OpenOptions::new().create(true).append(true).open(&path);
        let written = opened.and_then(|mut file| file.write_all(format!("{episode} {node}\n").as_bytes()));
        let write = |source| OutputError::write(&path, source);
        Ok(written.map_err(write)?)
    }

    fn shard_file(&self, shard: u64, extension: &str) -> PathBuf {
        self.folder.join(SHARDS).join(format!("{shard}-of-{}.{extension}", self.description.shards))
    }

    fn save(&self) -> Result<(), ClusterError> {
        let text = toml::to_string(&self.description).expect("numbers, texts and lists have a form in TOML");
        Ok(Outputs::new(true, []).write(&self.folder.join(DESCRIPTION), format!("{HEADING}{text}"))?)
    }

    /// Removes what a job has in its folder, and nothing else.
    fn remove(&self) -> Result<(), ClusterError> {
        for folder in [SHARDS, LOGS].map(|name| self.folder.join(name)).iter().filter(|f| f.is_dir()) {
            fs::remove_dir_all(folder).map_err(folder_error(folder))?;
        }
        for file in [SCRIPT, DESCRIPTION].map(|name| self.folder.join(name)).iter().filter(|f| f.exists()) {
            fs::remove_file(file).map_err(folder_error(file))?;
        }
        Ok(())
    }
}

impl Description {
    /// The description of a job that has not been submitted, with at most as many shards as episodes.
    pub fn of(
        study: &Study,
        file: &Path,
        seeds: Option<NonZeroU64>,
        methods: Vec<String>,
        shards: u64,
        sbatch: Vec<String>,
    ) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            study: std::path::absolute(file).unwrap_or_else(|_| file.to_owned()),
            seeds,
            methods,
            digest: study.digest().to_owned(),
            arithmetic: arithmetic::stamp().to_owned(),
            episodes: study.episodes(),
            shards: shards.clamp(1, study.episodes().clamp(1, MAX_SHARDS)),
            sbatch,
            arrays: Vec::new(),
        }
    }
}

/// The study of a file, with these methods of the program in place of its own, if there are any.
///
/// # Errors
/// As [`Study::load`], or a method is not known.
pub fn with_methods(file: &Path, seeds: Option<NonZeroU64>, methods: &[String]) -> Result<Study, SweepError> {
    let policies = methods.iter().cloned().map(Partner::BuiltIn).collect();
    Study::load_with(file, seeds, Partners::new(policies, Vec::new())?)
}

/// The folder of the job for these results.
fn folder_of(results: &Path) -> PathBuf {
    let mut name = results.file_name().unwrap_or_default().to_owned();
    name.push(".job");
    results.with_file_name(name)
}

fn folder_error(path: &Path) -> impl Fn(std::io::Error) -> ClusterError {
    let path = path.to_owned();
    move |source| ClusterError::Folder { path: path.clone(), source }
}
