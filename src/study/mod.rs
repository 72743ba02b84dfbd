//! The study engine: one row of results for every episode of a study, in the study's order.
//!
//! A study is a product of lists of values, or several such products. Seeds vary slowest: a sweep that is under way has all combinations of
//! the seeds it has come to, and the combinations of one seed, which is one human, stand together. Every row carries the number of its
//! episode, how many the study has, and the study's digest, so that any part of the results says what it is a part of.

mod cell;
mod error;
mod file;
mod humans;
mod merge;
mod names;
mod ordered;
mod partial;
mod results;
mod row;
mod source;
mod summary;

pub use error::SweepError;
pub use merge::merge;
pub use partial::{Shard, Sweep};
pub use summary::{Comparison, Group, Summary};

use crate::control;
use crate::coordination;
use crate::episode::Settings;
use crate::preference::Predictor;
use crate::robot::SlowDrive;
use crate::scenario::{Carrier, Plant, Scenario, Stage};
use crate::simulation::{HumanSettings, PhysicsSettings};
use cell::Cell;
use file::Contents;
use names::Plants;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

/// The seeds of a run, both ends included.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Seeds {
    first: u64,
    last: u64,
}

/// Combinations, each of which is run with all seeds.
#[derive(Debug)]
struct Run {
    cells: Vec<Cell>,
    seeds: Seeds,
}

/// A study, read and checked: what its episodes are, by their numbers.
#[derive(Debug)]
pub struct Study {
    file: String,
    contents: Contents,
    cells: Vec<Cell>,
    /// Belief and c_r, for each cell.
    predictors: Vec<Predictor>,
    predictor_of: Vec<usize>,
    /// One for every world, c_r and robot; which, for each cell.
    stages: Vec<Stage>,
    stage_of: Vec<usize>,
    blocks: Vec<Block>,
    episodes: u64,
    digest: String,
}

/// Seeds for which the same cells are run.
#[derive(Debug)]
struct Block {
    /// The number of its first episode.
    begin: u64,
    seeds: Seeds,
    cells: Vec<Range<usize>>,
    cells_per_seed: u64,
}

impl Study {
    /// Reads a study file, and the worlds and robots that it names.
    ///
    /// `seeds`: no more than so many of every run, if given.
    ///
    /// # Errors
    /// [`SweepError`], which names the file, the line, the key and the value.
    pub fn load(path: &Path, seeds: Option<u64>) -> Result<Self, SweepError> {
        let file = path.display().to_string();
        let folder = path.parent().unwrap_or(Path::new(""));
        match std::fs::read_to_string(path) {
            Ok(text) => Self::parse(&file, &text, folder, seeds),
            Err(source) => Err(SweepError::Read { file, source }),
        }
    }

    /// Reads the text of a study file; `file` is what errors call it, and the files that it names lie relative to `folder`.
    ///
    /// # Errors
    /// As [`Study::load`].
    pub fn parse(file: &str, text: &str, folder: &Path, seeds: Option<u64>) -> Result<Self, SweepError> {
        let contents = file::read(file, text, folder, seeds)?;
        let cells: Vec<Cell> = contents.runs.iter().flat_map(|(run, _)| run.cells.iter().copied()).collect();
        let blocks = blocks(&contents);
        let episodes = blocks.last().map_or(0, |b| b.begin + b.episodes());
        let mut study = Self {
            file: file.to_owned(),
            digest: digest(&contents),
            contents,
            cells,
            predictors: Vec::new(),
            predictor_of: Vec::new(),
            stages: Vec::new(),
            stage_of: Vec::new(),
            blocks,
            episodes,
        };
        study.refuse_repetition()?;
        study.set_predictors()?;
        study.prepare()?;
        Ok(study)
    }

    /// Episodes of the whole study.
    pub fn episodes(&self) -> u64 {
        self.episodes
    }

    /// Combinations of values; each is run with all its seeds.
    pub fn combinations(&self) -> usize {
        self.cells.len()
    }

    /// Tells this study from others: it depends on all that the results depend on, and on the version of the program.
    pub fn digest(&self) -> &str {
        &self.digest
    }

    /// The scenario of an episode.
    pub fn scenario(&self, episode: u64) -> Option<Scenario> {
        let (cell, seed) = self.place(episode)?;
        Some(self.drawn(cell, seed))
    }

    /// Drives that are slower than their team is to walk, each once.
    pub fn slow_drives(&self) -> Vec<SlowDrive> {
        let mut slow = Vec::new();
        for (cell, &stage) in self.cells.iter().zip(&self.stage_of) {
            let found = self.stages[stage].robot().and_then(|robot| robot.slow_drive(cell.speed));
            slow.extend(found.filter(|found| !slow.contains(found)));
        }
        slow
    }

    /// The scenario of a cell that has its stage, with all that is drawn.
    fn drawn(&self, cell: usize, seed: u64) -> Scenario {
        let scenario = self.scenario_of(cell, seed);
        let options = self.stages[self.stage_of[cell]].options();
        let Cell { humans, redraws, .. } = self.cells[cell];
        let (_, humans) = &self.contents.humans[humans];
        let changes = humans.draw_changes(redraws, seed, options, &scenario.settings);
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

    /// The scenario but for changes of mind, which are drawn for a world's options.
    fn scenario_of(&self, cell: usize, seed: u64) -> Scenario {
        let (contents, predictor) = (&self.contents, &self.predictors[self.predictor_of[cell]]);
        let cell = &self.cells[cell];
        let settings = Settings {
            predictor: predictor.clone(),
            coordination: coordination::Settings {
                initial_stubbornness: cell.initial_stubbornness,
                eta: cell.eta,
            },
            method: cell.method,
            period: cell.period,
            speed: cell.speed,
            yaw_rate: cell.yaw_rate,
            tick_limit: cell.max_steps,
            // nobody looks at single ticks here
            predict_while_human_leads: false,
        };
        let plant = match cell.plant {
            Plants::Point => Plant::Point,
            Plants::Kinematic => Plant::Kinematic { carrier: self.carrier(cell) },
            Plants::Rapier => {
                let human = HumanSettings {
                    sway_lateral: cell.sway,
                    sway_vertical: cell.sway / 2.0,
                    ..HumanSettings::default()
                };
                let physics = PhysicsSettings { human, ..PhysicsSettings::default() };
                Plant::Rapier { carrier: self.carrier(cell), physics }
            }
        };
        let world = contents.worlds[cell.world].1.clone();
        let human = contents.humans[cell.humans].1.draw(seed);
        let human_model = Default::default();
        Scenario { seed, world, human, human_model, changes: Vec::new(), settings, plant }
    }

    fn carrier(&self, cell: &Cell) -> Carrier {
        let (_, robot, _) = &self.contents.robots[cell.robot];
        let control = control::Settings {
            candidates: cell.candidates,
            criterion: cell.criterion,
            prepare_while_leading: cell.prepare_while_leading,
            avoid: cell.avoid,
            ..control::Settings::default()
        };
        Carrier { posture: self.posture(cell).to_owned(), control, robot: robot.clone() }
    }

    fn posture(&self, cell: &Cell) -> &str {
        match cell.posture {
            Some(posture) => &self.contents.postures[posture],
            None => self.contents.robots[cell.robot].2.first().map_or("", String::as_str),
        }
    }

    fn set_predictors(&mut self) -> Result<(), SweepError> {
        let mut known: BTreeMap<(usize, u64), usize> = BTreeMap::new();
        for i in 0..self.cells.len() {
            let cell = &self.cells[i];
            let next = self.predictors.len();
            let at = *known.entry((cell.belief, cell.risk_weight.to_bits())).or_insert(next);
            if at == next {
                let belief = self.contents.beliefs[cell.belief].1.clone();
                let made = Predictor::new(belief, cell.risk_weight);
                self.predictors.push(made.map_err(|source| self.refused(i, source))?);
            }
            self.predictor_of.push(at);
        }
        Ok(())
    }

    /// Prepares one stage for every world, c_r and robot; and sees that every cell is a valid scenario on it.
    fn prepare(&mut self) -> Result<(), SweepError> {
        let mut known: BTreeMap<(usize, u64, Option<usize>), usize> = BTreeMap::new();
        for i in 0..self.cells.len() {
            let cell = &self.cells[i];
            let robot = (cell.plant != Plants::Point).then_some(cell.robot);
            let (world, risk_weight) = (cell.world, cell.risk_weight.to_bits());
            let scenario = self.scenario_of(i, 0);
            let at = match known.get(&(world, risk_weight, robot)) {
                Some(&at) => {
                    self.stages[at].prepare(scenario).map_err(|source| self.refused(i, source))?;
                    at
                }
                None => {
                    let mut similar = known.range((world, risk_weight, None)..);
                    let similar = similar.next().filter(|(key, _)| (key.0, key.1) == (world, risk_weight));
                    let made = match similar {
                        Some((_, &at)) => self.stages[at].prepare(scenario),
                        None => scenario.prepare(),
                    };
                    self.stages.push(made.map_err(|source| self.refused(i, source))?);
                    known.insert((world, risk_weight, robot), self.stages.len() - 1);
                    self.stages.len() - 1
                }
            };
            self.stage_of.push(at);
        }
        Ok(())
    }

    fn refused(&self, cell: usize, source: impl std::error::Error + Send + Sync + 'static) -> SweepError {
        let (file, inputs) = (self.file.clone(), row::inputs_in_words(self, cell));
        SweepError::Scenario { file, inputs, source: Box::new(source) }
    }

    /// An episode that is run twice would count twice.
    fn refuse_repetition(&self) -> Result<(), SweepError> {
        let mut known: BTreeMap<Vec<String>, Vec<Seeds>> = BTreeMap::new();
        let mut cell = 0;
        for (run, place) in &self.contents.runs {
            for _ in &run.cells {
                let before = known.entry(row::inputs(self, cell)).or_default();
                let common = before.iter().find(|b| b.first <= run.seeds.last && run.seeds.first <= b.last);
                if let Some(other) = common {
                    let (place, seed) = (place.clone(), other.first.max(run.seeds.first));
                    let inputs = row::inputs_in_words(self, cell);
                    return Err(SweepError::Repeated { place, seed, inputs });
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

/// The seeds of all runs, cut where a run's begin or end.
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

/// 64 bits (FNV-1a) of all that the results depend on: accidents are told apart, not forgeries.
fn digest(contents: &Contents) -> String {
    let runs: Vec<&Run> = contents.runs.iter().map(|(run, _)| run).collect();
    let Contents { worlds, robots, postures, humans, beliefs, .. } = contents;
    let version = env!("CARGO_PKG_VERSION");
    let text = format!("{version} {worlds:?} {robots:?} {postures:?} {humans:?} {beliefs:?} {runs:?}");
    let hash = text.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    format!("{hash:016x}")
}
