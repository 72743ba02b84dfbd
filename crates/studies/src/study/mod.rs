//! The study engine: one row of results for every episode of a study, in the study's order.
//!
//! A study is a product of lists of values, or several such products. Rows are ordered by seed: an unfinished
//! sweep already has all combinations of its seeds, and the combinations of one seed, which is one human, are
//! next to each other. Every row has the number of its episode, the number of episodes of the study, and the
//! study's digest, which identify any part of the results.

mod again;
pub mod bench;
mod cell;
mod compared;
mod comparison_table;
mod error;
mod file;
mod humans;
mod merge;
mod ordered;
mod origin;
mod partial;
mod partners;
mod pictures;
mod plane;
mod results;
mod row;
mod run;
mod source;
mod summary;
mod summary_reader;
#[cfg_attr(not(feature = "parquet"), path = "tables_unavailable.rs")]
mod tables;

pub use again::{Difference, different};
pub use compared::Comparing;
pub use error::{Position, SweepError};
pub use merge::merge;
pub use partial::{Shard, Sweep, SweepOutputs, complete_rows, rows_with};
pub use partners::{Custom, EpisodeMaker, Partner, Partners};
pub use pictures::{Drawn, picture};
pub use plane::{Plane, PlanePart};
pub(crate) use results::check_name;
pub use results::{Results, read_rows};
pub use row::line_of_cells as line_of;
pub use summary::{Comparison, OUTCOMES, Summary, SummaryGroup};

use cell::Cell;
use cocarry::arithmetic;
use cocarry::episode::{Episode, EpisodeSettings, PlaceMemory};
use cocarry::error::Place;
use cocarry::preference::{Predictor, RISK_WEIGHT};
use cocarry::quantities::Heading;
use cocarry::robot::SlowDrive;
use cocarry::scenario::{Plant, PlantKind, PreparedScenario, RobotSetup, SETTINGS, Scenario};
use cocarry::{bounds, located};
use file::Contents;
use origin::Origin;
use partners::BuiltIn;
use run::{Run, Seeds};
use std::collections::{BTreeMap, BTreeSet};
use std::num::NonZeroU64;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The columns of results, in order.
pub fn columns() -> Vec<Heading> {
    row::headings()
}

/// The largest number of prepared scenarios of a study, each with its own world, c_r and robot. They take
/// about 0.2 MB each.
const MAX_SCENES: usize = 1000;

/// A study, read and checked: its episodes by number.
#[derive(Debug)]
pub struct Study {
    /// What errors call the file.
    file: String,
    contents: Contents,
    /// Every combination of values of all runs, in the order of the runs.
    cells: Vec<Cell>,
    /// The default settings with each belief of `contents`.
    bases: Vec<EpisodeSettings>,
    /// A prepared scenario for every world, c_r and robot.
    prepared: Vec<PreparedScenario>,
    /// The index into `prepared` of each cell.
    prepared_of: Vec<usize>,
    /// Drives that are slower than the walking speed of their team, each once.
    slow_drives: Vec<SlowDrive>,
    robot_warnings: Vec<String>,
    human_warnings: Vec<String>,
    /// In the order of their seeds.
    blocks: Vec<Block>,
    /// The number of episodes.
    episodes: u64,
    digest: String,
    /// The text of the file.
    text: String,
}

/// A range of seeds that run the same cells. An episode's number gives its block, its seed and its cell.
#[derive(Debug)]
struct Block {
    /// The number of its first episode.
    begin: u64,
    seeds: Seeds,
    /// Ranges of indices into [`Study::cells`], one for each run that has these seeds.
    cells: Vec<Range<usize>>,
    cells_per_seed: u64,
}

impl Study {
    /// Reads a study file, and the worlds and robots that it names.
    ///
    /// `seeds`: the largest number of seeds of every run, if given.
    ///
    /// # Errors
    /// [`SweepError`], which names the file, the line, the key and the value.
    pub fn load(path: &Path, seeds: Option<NonZeroU64>) -> Result<Self, SweepError> {
        Self::load_with(path, seeds, Partners::default())
    }

    /// As [`Study::load`], with other policies and humans than the file's.
    ///
    /// # Errors
    /// As [`Study::load`].
    pub fn load_with(path: &Path, seeds: Option<NonZeroU64>, partners: Partners) -> Result<Self, SweepError> {
        let file = path.display().to_string();
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::parse_with(&file, &located::read(&bounds::SETTINGS, path)?, folder, seeds, partners)
    }

    /// Reads the text of a study file. Errors call it `file`. Files that it names are relative to `folder`.
    ///
    /// # Errors
    /// As [`Study::load`].
    pub fn parse(
        file: &str,
        text: &str,
        folder: &Path,
        seeds: Option<NonZeroU64>,
    ) -> Result<Self, SweepError> {
        Self::parse_with(file, text, folder, seeds, Partners::default())
    }

    /// As [`Study::parse`], with other policies and humans than the file's.
    ///
    /// # Errors
    /// As [`Study::load`].
    pub fn parse_with(
        file: &str,
        text: &str,
        folder: &Path,
        seeds: Option<NonZeroU64>,
        partners: Partners,
    ) -> Result<Self, SweepError> {
        let mut contents = file::read(file, text, folder, seeds)?;
        partners.apply(&mut contents);
        let most = contents.runs.iter().map(|(run, _)| run.cells.len()).sum::<usize>();
        if most > cell::MAX_RUN {
            let place = Place { file: file.to_owned(), line: None, item: "study".to_owned() };
            return Err(SweepError::too_many(place, cell::MAX_RUN, "combinations"));
        }
        let cells: Vec<Cell> = contents.runs.iter().flat_map(|(run, _)| run.cells.iter().cloned()).collect();
        let blocks = blocks(&contents);
        let episodes = blocks.last().map_or(0, |b| b.begin + b.episodes());
        let mut study = Self {
            file: file.to_owned(),
            digest: String::new(),
            text: text.to_owned(),
            contents,
            cells,
            bases: Vec::new(),
            prepared: Vec::new(),
            prepared_of: Vec::new(),
            slow_drives: Vec::new(),
            robot_warnings: Vec::new(),
            human_warnings: Vec::new(),
            blocks,
            episodes,
        };
        study.refuse_repetition()?;
        study.set_bases()?;
        study.prepare()?;
        study.warn_of_humans()?;
        study.digest = study.hash()?;
        Ok(study)
    }

    /// The number of episodes of the whole study.
    pub fn episodes(&self) -> u64 {
        self.episodes
    }

    /// The world and robot files that the study at `path` names.
    pub fn files(&self, path: &Path) -> impl Iterator<Item = PathBuf> {
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let worlds = self.contents.worlds.iter().map(|(_, world)| world.file());
        let robots = self
            .contents
            .robots
            .iter()
            .flat_map(|(_, robot, _)| [robot.texts().file.as_str(), &robot.texts().urdf_file]);
        worlds.chain(robots).map(move |name| folder.join(name))
    }

    /// The number of combinations of values. Each is run with all its seeds.
    pub fn combinations(&self) -> usize {
        self.cells.len()
    }

    /// The digest that identifies the study. It covers everything that the results depend on, and the version
    /// of the program.
    pub fn digest(&self) -> &str {
        &self.digest
    }

    /// What identifies the study in a file of its rows.
    fn origin(&self) -> Origin {
        Origin {
            text: Some(self.text.clone()),
            study: self.digest.clone(),
            episodes: self.episodes,
            arithmetic: arithmetic::stamp().to_owned(),
        }
    }

    /// The scenario of an episode.
    pub fn scenario(&self, episode: u64) -> Option<Scenario> {
        let (cell, seed) = self.place(episode)?;
        Some(self.drawn(cell, seed))
    }

    /// Probable mistakes in the worlds of the study.
    pub fn world_warnings(&self) -> &[String] {
        &self.contents.world_warnings
    }

    /// Drives that are slower than the walking speed of their team, each once.
    pub fn slow_drives(&self) -> &[SlowDrive] {
        &self.slow_drives
    }

    /// Warnings about robots in their worlds, each once: see [`PreparedScenario::robot_warnings`].
    pub fn robot_warnings(&self) -> &[String] {
        &self.robot_warnings
    }

    /// Warnings about an alpha or a gamma that is the same for all humans, each once: see
    /// [`PreparedScenario::warnings`].
    pub fn human_warnings(&self) -> &[String] {
        &self.human_warnings
    }

    /// The scenario of a cell with everything that is drawn from the seed.
    fn drawn(&self, cell: usize, seed: u64) -> Scenario {
        let scenario = self.scenario_of(cell, seed);
        let prepared = &self.prepared[self.prepared_of[cell]];
        let options = prepared.options_as_written().expect("worlds were checked when the study was read");
        let cell = &self.cells[cell];
        let (_, humans) = &self.contents.humans[cell.humans];
        let changes = humans.draw_changes(cell.changes, seed, options, &scenario.settings);
        Scenario { changes, ..scenario }
    }

    /// The cell and the seed of an episode.
    fn place(&self, episode: u64) -> Option<(usize, u64)> {
        let block = self.blocks.partition_point(|block| block.begin <= episode).checked_sub(1)?;
        let block = &self.blocks[block];
        let within = episode - block.begin;
        let seed = block.seeds.first + within / block.cells_per_seed;
        let mut left = (within % block.cells_per_seed) as usize;
        for cells in &block.cells {
            match cells.len() {
                n if left < n => return (seed <= block.seeds.last).then_some((cells.start + left, seed)),
                n => left -= n,
            }
        }
        None
    }

    /// The scenario of a cell without preference changes: to draw them takes a world's options.
    fn scenario_of(&self, cell: usize, seed: u64) -> Scenario {
        let (contents, cell) = (&self.contents, &self.cells[cell]);
        let robot = contents.robots.get(cell.robot).map(|(_, robot, _)| robot.clone()).unwrap_or_default();
        let plant = Plant::new(cell.plant, RobotSetup { robot, ..RobotSetup::default() });
        let (world, settings) = (contents.worlds[cell.world].1.clone(), self.bases[cell.belief].clone());
        let humans = &contents.humans[cell.humans].1;
        let mut scenario = Scenario::of_seed(seed, world, plant, settings, &humans.belief(), humans.given());
        for (setting, value) in SETTINGS.iter().zip(&cell.values) {
            value.iter().for_each(|value| setting.set(&mut scenario, value));
        }
        scenario
    }

    /// Sets `bases`.
    fn set_bases(&mut self) -> Result<(), SweepError> {
        for belief in 0..self.contents.beliefs.len() {
            let made = Predictor::new(self.contents.beliefs[belief].1.clone(), RISK_WEIGHT);
            let predictor = made.map_err(|source| self.refused(0, source))?;
            // single ticks are not needed here
            self.bases.push(EpisodeSettings {
                predictor,
                predict_while_human_leads: false,
                ..EpisodeSettings::default()
            });
        }
        Ok(())
    }

    /// Prepares a scenario for every world, c_r and robot, and checks every cell on it.
    fn prepare(&mut self) -> Result<(), SweepError> {
        let mut known: BTreeMap<(usize, u64, Option<usize>), usize> = BTreeMap::new();
        let memory = Arc::new(PlaceMemory::default());
        for i in 0..self.cells.len() {
            let cell = &self.cells[i];
            let robot = (cell.plant != PlantKind::Point).then_some(cell.robot);
            let scenario = self.scenario_of(i, 0);
            let (world, risk_weight) = (cell.world, scenario.settings.predictor.risk_weight().to_bits());
            let key = (world, risk_weight, robot);
            let mut similar = known.range((world, risk_weight, None)..);
            let similar = similar.next().filter(|(key, _)| (key.0, key.1) == (world, risk_weight));
            if known.len() == MAX_SCENES && !known.contains_key(&key) {
                let (place, most) = (self.place_of(i), MAX_SCENES);
                let what = "combinations of a world, a risk weight and a robot";
                return Err(SweepError::too_many(place, most, what));
            }
            let made = match known.get(&key).or(similar.map(|(_, at)| at)) {
                Some(&at) => self.prepared[at].prepare(scenario),
                None => scenario.prepare(),
            };
            let made = made.map_err(|source| self.refused(i, source))?;
            made.options_as_written().map_err(|source| self.refused(i, source))?;
            let slow = made.slow_drive().filter(|found| !self.slow_drives.contains(found));
            self.slow_drives.extend(slow.cloned());
            for warning in made.robot_warnings() {
                if !self.robot_warnings.contains(&warning) {
                    self.robot_warnings.push(warning);
                }
            }
            let at = *known.entry(key).or_insert(self.prepared.len());
            if at == self.prepared.len() {
                self.prepared.push(made.keeping_places(Arc::clone(&memory)));
            }
            self.prepared_of.push(at);
        }
        Ok(())
    }

    /// A 64-bit hash (FNV-1a) of everything that the results depend on, as text. It detects accidental
    /// mix-ups, not forgeries. It covers one complete scenario of each world, robot and plant, and the
    /// settings of each combination.
    fn hash(&self) -> Result<String, SweepError> {
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        let mut add = |text: &str| {
            for byte in text.bytes().chain([0]) {
                hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
            }
        };
        add(env!("CARGO_PKG_VERSION"));
        let (mut whole, mut cell) = (BTreeSet::new(), 0);
        for (Run { cells, seeds }, _) in &self.contents.runs {
            add(&format!("{} combinations, seeds {} to {}", cells.len(), seeds.first, seeds.last));
            for _ in cells {
                if whole.insert((self.prepared_of[cell], self.cells[cell].plant.name())) {
                    let text = self.scenario_of(cell, seeds.first).text();
                    add(&text.map_err(|source| self.refused(cell, source))?);
                }
                self.inputs(cell).iter().for_each(|input| add(input));
                cell += 1;
            }
        }
        Ok(format!("{hash:016x}"))
    }

    /// Where in the file the run of a cell is, for errors.
    fn place_of(&self, cell: usize) -> Place {
        let mut end = 0;
        let run = self.contents.runs.iter().find(|(run, _)| {
            end += run.cells.len();
            cell < end
        });
        let whole = || Place { file: self.file.clone(), line: None, item: "study".to_owned() };
        run.map_or_else(whole, |(_, place)| place.clone())
    }

    /// The error of a cell whose scenario is refused.
    fn refused(&self, cell: usize, source: impl std::error::Error + Send + Sync + 'static) -> SweepError {
        let (file, inputs) = (self.file.clone(), row::in_words(&self.inputs(cell)));
        SweepError::scenario(file, inputs, source)
    }

    /// The values of a cell's input columns.
    fn inputs(&self, cell: usize) -> Vec<String> {
        row::inputs(&self.contents, &self.cells[cell])
    }

    /// Runs an episode of the program's partners to its end, and returns its line of results.
    fn run(&self, episode: u64) -> Vec<u8> {
        self.row(episode, &BuiltIn)
    }

    /// The lines of results of these episodes, run one after the other; none after the last episode.
    pub fn rows(&self, episodes: Range<u64>) -> Vec<u8> {
        (episodes.start..episodes.end.min(self.episodes)).flat_map(|episode| self.run(episode)).collect()
    }

    /// The line of results of an episode, as in a file of results. The line is empty after the last episode,
    /// and if the episode is given up.
    pub fn row(&self, episode: u64, maker: &dyn EpisodeMaker) -> Vec<u8> {
        let Some((cell, seed)) = self.place(episode) else { return Vec::new() };
        self.row_of(episode, cell, self.drawn(cell, seed), maker, &|_, _| ())
    }

    /// The line of an episode, whose scenario is of this cell. `on_step` sees the episode after every step.
    fn row_of(
        &self,
        episode: u64,
        cell: usize,
        scenario: Scenario,
        maker: &dyn EpisodeMaker,
        on_step: &dyn Fn(&PreparedScenario, &Episode<'_>),
    ) -> Vec<u8> {
        let (episodes, digest) = (self.episodes.to_string(), self.digest.clone());
        let identity = [episode.to_string(), episodes, digest, arithmetic::stamp().to_owned()];
        let custom = self.cells[cell].custom;
        let prepared = &self.prepared[self.prepared_of[cell]];
        row::of(identity, self.inputs(cell), scenario, prepared, &|prepared| {
            let mut episode = maker.begin(prepared, custom)?;
            while !maker.is_over() {
                if episode.step().is_some() {
                    return Ok((!maker.is_over()).then_some(episode));
                }
                on_step(prepared, &episode);
            }
            Ok(None)
        })
    }

    /// The check that no episode is in two runs, where it would count twice.
    fn refuse_repetition(&self) -> Result<(), SweepError> {
        let mut known: BTreeMap<Vec<String>, Vec<Seeds>> = BTreeMap::new();
        let mut cell = 0;
        for (run, place) in &self.contents.runs {
            for _ in &run.cells {
                let before = known.entry(self.inputs(cell)).or_default();
                let common = before.iter().find(|b| b.first <= run.seeds.last && run.seeds.first <= b.last);
                if let Some(other) = common {
                    let (place, seed) = (place.clone(), other.first.max(run.seeds.first));
                    let inputs = row::in_words(&self.inputs(cell));
                    return Err(SweepError::repeated(place, seed, inputs));
                }
                before.push(run.seeds);
                cell += 1;
            }
        }
        Ok(())
    }
}

impl Block {
    fn episodes(&self) -> u64 {
        (self.seeds.last - self.seeds.first + 1) * self.cells_per_seed
    }
}

/// The seeds of all runs, split where a run begins or ends.
fn blocks(contents: &Contents) -> Vec<Block> {
    let runs = || contents.runs.iter().map(|(run, _)| run);
    let mut cuts: Vec<u64> = runs().flat_map(|r| [r.seeds.first, r.seeds.last.saturating_add(1)]).collect();
    cuts.sort_unstable();
    cuts.dedup();
    let mut blocks: Vec<Block> = Vec::new();
    for cut in cuts.windows(2) {
        let seeds = Seeds { first: cut[0], last: cut[1] - 1 };
        let mut next = 0;
        let mut cells = Vec::new();
        for run in runs() {
            let range = next..next + run.cells.len();
            next = range.end;
            if run.seeds.first <= seeds.first && seeds.last <= run.seeds.last {
                cells.push(range);
            }
        }
        let cells_per_seed = cells.iter().map(|range| range.len() as u64).sum();
        if cells_per_seed > 0 {
            let begin = blocks.last().map_or(0, |b| b.begin + b.episodes());
            blocks.push(Block { begin, seeds, cells, cells_per_seed });
        }
    }
    blocks
}
