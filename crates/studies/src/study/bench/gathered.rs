//! Rows of results, gathered by study and policy.

use super::super::error::Position;
use super::super::partners::MAX_PARTNERS;
use super::super::results::{Results, Rows};
use super::super::{Study, SweepError, row};
use super::{NAME, Set};
use cocarry::arithmetic;
use csv::StringRecord;
use std::collections::BTreeMap;

/// The rows of a study.
pub struct Gathered {
    study: String,
    /// The number of episodes of the study.
    episodes: u64,
    /// The file and the place of the first row.
    first: (String, Position),
    /// By their numbers.
    rows: BTreeMap<u64, Episode>,
}

/// What counts of an episode.
#[derive(Clone, Debug, PartialEq)]
struct Episode {
    policy: [String; 2],
    world: String,
    has_arrived: bool,
    has_succeeded: bool,
    objective_cost: f64,
    off_preference: f64,
    path_efficiency: f64,
    time: f64,
    internal_force: f64,
    work_share: f64,
    control_cost: f64,
}

/// The columns that count.
struct Places([usize; 12]);

const COLUMNS: [&str; 12] = [
    "method",
    "policy_code",
    "world",
    "outcome",
    "overruled_time_s",
    "accumulated_objective_cost_m",
    "share_off_preference",
    "path_efficiency",
    "time_s",
    "internal_force_rms_n",
    "human_work_share",
    "accumulated_control_cost",
];

impl Places {
    fn find() -> Self {
        let columns = row::columns();
        Self(COLUMNS.map(|name| columns.iter().position(|column| *column == name).expect("a column")))
    }

    fn episode(&self, fields: &StringRecord) -> Episode {
        let text = |i: usize| fields[self.0[i]].to_owned();
        // an empty cell is not a number
        let number = |i: usize| fields[self.0[i]].parse::<f64>().unwrap_or(f64::NAN);
        let has_arrived = fields[self.0[3]] == *row::arrived();
        Episode {
            policy: [text(0), text(1)],
            world: text(2),
            has_arrived,
            has_succeeded: has_arrived && number(4) == 0.0,
            objective_cost: number(5),
            off_preference: number(6),
            path_efficiency: number(7),
            time: number(8),
            internal_force: number(9),
            work_share: number(10),
            control_cost: number(11),
        }
    }
}

/// A share of episodes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Share {
    of: u64,
    which: u64,
}

impl Share {
    /// The share.
    pub fn share(self) -> f64 {
        self.which as f64 / self.of as f64
    }

    fn add(&mut self, is_one: bool) {
        self.of += 1;
        self.which += u64::from(is_one);
    }
}

/// A mean of the numbers that there are.
#[derive(Clone, Copy, Debug, Default)]
pub struct Mean {
    n: u64,
    sum: f64,
}

impl Mean {
    /// The mean; NaN of no numbers.
    pub fn mean(self) -> f64 {
        self.sum / self.n as f64
    }

    fn add(&mut self, value: f64) {
        if value.is_finite() {
            self.n += 1;
            self.sum += value;
        }
    }
}

/// The figures of a policy; means are of episodes that arrived.
#[derive(Clone, Copy, Debug, Default)]
pub struct Of {
    pub succeeded: Share,
    pub arrived: Share,
    pub off_preference: Mean,
    pub path_efficiency: Mean,
    pub time: Mean,
    pub internal_force: Mean,
    pub work_share: Mean,
    pub control_cost: Mean,
}

impl Of {
    fn add(&mut self, episode: &Episode) {
        self.succeeded.add(episode.has_succeeded);
        self.arrived.add(episode.has_arrived);
        if episode.has_arrived {
            self.off_preference.add(episode.off_preference);
            self.path_efficiency.add(episode.path_efficiency);
            self.time.add(episode.time);
            self.internal_force.add(episode.internal_force);
            self.work_share.add(episode.work_share);
            self.control_cost.add(episode.control_cost);
        }
    }
}

impl Gathered {
    /// Reads files of results, study by study. Rows that are there twice count once.
    pub fn read(results: &[Results]) -> Result<Vec<Self>, SweepError> {
        let places = Places::find();
        let mut studies: Vec<Self> = Vec::new();
        for results in results {
            let mut rows = Rows::of(*results)?;
            let mut count = 0;
            while let Some(identity) = rows.next()? {
                count += 1;
                let place = (rows.file.clone(), rows.position());
                let stamp = arithmetic::stamp();
                if identity.arithmetic != stamp {
                    let file = format!("{}: {}", place.0, place.1);
                    let this = "this machine".to_owned();
                    return Err(SweepError::other_arithmetic(
                        file,
                        identity.arithmetic,
                        this,
                        stamp.to_owned(),
                    ));
                }
                let fields = rows.checked_fields()?;
                if rows.unchecked > 0 {
                    let (file, position) = place;
                    return Err(SweepError::row(
                        position,
                        file,
                        "a row whose values another program has changed or rounded".to_owned(),
                        "as its sweep wrote it".to_owned(),
                    ));
                }
                let at = studies.iter().position(|study| study.study == identity.study);
                let at = at.unwrap_or_else(|| {
                    let (study, episodes) = (identity.study.clone(), identity.episodes);
                    studies.push(Self { study, episodes, first: place.clone(), rows: BTreeMap::new() });
                    studies.len() - 1
                });
                let found = places.episode(&fields);
                let known = studies[at].rows.entry(identity.episode).or_insert_with(|| found.clone());
                // NaN is no number, and equal to nothing: texts tell
                if format!("{known:?}") != format!("{found:?}") {
                    let (file, position) = place;
                    let found = format!("of episode {} with other values than before", identity.episode);
                    return Err(SweepError::row(
                        position,
                        file,
                        found,
                        "of an episode of its own".to_owned(),
                    ));
                }
            }
            rows.check_all()?;
            if count == 0 {
                return Err(SweepError::empty(rows.file.clone()));
            }
        }
        Ok(studies)
    }

    /// The set that they can be of, by their number.
    pub fn set(&self) -> Result<Set, SweepError> {
        let policies = self.policies().len() as u64;
        let fits = |set: &Set| set.episodes() * policies == self.episodes;
        Set::ALL.into_iter().find(fits).ok_or_else(|| self.other())
    }

    /// Name and code of the policies, in the order of the study.
    pub fn policies(&self) -> Vec<[String; 2]> {
        let mut found: Vec<[String; 2]> = Vec::new();
        for episode in self.rows.values() {
            if !found.contains(&episode.policy) {
                found.push(episode.policy.clone());
            }
            // more than a study has
            if found.len() > MAX_PARTNERS {
                break;
            }
        }
        found
    }

    /// The check that these are all episodes of this study.
    pub fn check(&self, study: &Study) -> Result<(), SweepError> {
        if study.digest() != self.study {
            return Err(self.other());
        }
        let missing = (0..self.episodes).find(|episode| !self.rows.contains_key(episode));
        let missing = missing.map(|first| {
            let found = self.rows.len();
            SweepError::incomplete(self.first.0.clone(), found as u64, self.episodes, first)
        });
        missing.map_or(Ok(()), Err)
    }

    /// The figures of a policy, and its result in every world in the order of the study, 1/m.
    pub fn of(&self, policy: [String; 2]) -> (Of, Vec<(String, f64)>) {
        let (mut of, mut worlds) = (Of::default(), Vec::<(String, Mean)>::new());
        for episode in self.rows.values().filter(|episode| episode.policy == policy) {
            of.add(episode);
            let result = if episode.has_succeeded { 1.0 / episode.objective_cost } else { 0.0 };
            match worlds.iter_mut().find(|(world, _)| *world == episode.world) {
                Some((_, mean)) => mean.add(result),
                None => worlds.push((episode.world.clone(), Mean { n: 1, sum: result })),
            }
        }
        (of, worlds.into_iter().map(|(world, mean)| (world, mean.mean())).collect())
    }

    fn other(&self) -> SweepError {
        let (file, position) = self.first.clone();
        SweepError::not_of_the_benchmark(file, position, self.study.clone(), NAME)
    }
}
