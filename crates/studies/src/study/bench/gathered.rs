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
    /// Name and code.
    policy: [String; 2],
    world: String,
    has_arrived: bool,
    has_succeeded: bool,
    /// 1/m; 0 without success.
    result: f64,
    /// The values of [`MEANS`]; none where the episode has none.
    values: [Option<f64>; MEANS.len()],
}

/// A mean on the score card, over episodes that arrived.
pub struct MeanOf {
    /// Heading for people; empty for programs only.
    pub heading: &'static str,
    /// Name for programs.
    pub key: &'static str,
    column: &'static str,
    factor: f64,
}

const fn mean(heading: &'static str, key: &'static str, column: &'static str, factor: f64) -> MeanOf {
    MeanOf { heading, key, column, factor }
}

/// The means on the score card.
pub const MEANS: [MeanOf; 6] = [
    mean("off %", "off_preference_percent", "share_off_preference", 100.0),
    mean("", "path_efficiency_percent", "path_efficiency", 100.0),
    mean("time s", "time_s", "time_s", 1.0),
    mean("force N", "internal_force_rms_n", "internal_force_rms_n", 1.0),
    mean("work %", "human_work_percent", "human_work_share", 100.0),
    mean("", "accumulated_control_cost", "accumulated_control_cost", 1.0),
];

/// Places of the columns of a row.
struct Places(BTreeMap<&'static str, usize>);

impl Places {
    fn find() -> Self {
        Self(row::columns().into_iter().enumerate().map(|(place, name)| (name, place)).collect())
    }

    fn episode(&self, fields: &StringRecord) -> Episode {
        let cell = |name: &str| &fields[self.0[name]];
        let number = |name: &str| cell(name).parse::<f64>().ok().filter(|number| number.is_finite());
        let has_arrived = cell("outcome") == row::arrived();
        let has_succeeded = has_arrived && number("overruled_time_s") == Some(0.0);
        let cost = number("accumulated_objective_cost_m").filter(|_| has_succeeded);
        Episode {
            policy: ["method", "policy_code"].map(|name| cell(name).to_owned()),
            world: cell("world").to_owned(),
            has_arrived,
            has_succeeded,
            result: cost.map_or(0.0, |cost| 1.0 / cost),
            values: MEANS.each_ref().map(|of| number(of.column).map(|value| of.factor * value)),
        }
    }
}

/// A mean so far.
#[derive(Clone, Copy, Debug, Default)]
pub struct Mean {
    n: u64,
    sum: f64,
}

impl Mean {
    /// The mean; `None` of no values.
    pub fn mean(self) -> Option<f64> {
        (self.n > 0).then(|| self.sum / self.n as f64)
    }

    fn add(&mut self, value: f64) {
        self.n += 1;
        self.sum += value;
    }
}

/// The figures of a policy.
#[derive(Clone, Copy, Debug, Default)]
pub struct Of {
    /// Percentages of episodes that succeeded and that arrived.
    pub succeeded: Mean,
    pub arrived: Mean,
    /// Those of [`MEANS`].
    pub means: [Mean; MEANS.len()],
}

impl Of {
    fn add(&mut self, episode: &Episode) {
        let percent = |is_so: bool| if is_so { 100.0 } else { 0.0 };
        self.succeeded.add(percent(episode.has_succeeded));
        self.arrived.add(percent(episode.has_arrived));
        let values = episode.values.iter().filter(|_| episode.has_arrived);
        for (mean, value) in self.means.iter_mut().zip(values) {
            value.iter().for_each(|value| mean.add(*value));
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
                if *known != found {
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
            let at = worlds.iter().position(|(world, _)| *world == episode.world).unwrap_or_else(|| {
                worlds.push((episode.world.clone(), Mean::default()));
                worlds.len() - 1
            });
            worlds[at].1.add(episode.result);
        }
        (of, worlds.into_iter().filter_map(|(world, mean)| Some((world, mean.mean()?))).collect())
    }

    fn other(&self) -> SweepError {
        let (file, position) = self.first.clone();
        SweepError::not_of_the_benchmark(file, position, self.study.clone(), NAME)
    }
}
