//! What the episodes of many humans find at the same places, kept.
//!
//! D_o, S_o, P_o and J~_o are of a world and a belief, not of a human. In the episodes of a study that share
//! both, they are the same numbers at the same places, however many humans there are.

use crate::coordination::OptionTick;
use crate::options::{OptionSet, Progress};
use crate::preference::{Predictor, Ways};
use foldhash::fast::FixedState;
use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, RwLock};

/// The largest number of options, each counted at every place, that are kept: about 20 MB.
const MAX_OPTIONS: usize = 1 << 17;
/// The largest number of pairs of an option set and a predictor.
const MAX_TABLES: usize = 1 << 10;

/// The options that episodes have evaluated at the places of their teams, for episodes on any number of
/// threads. What is found in it has the bits that would be computed again, so that results do not depend on
/// what it holds. Its size is limited.
#[derive(Debug, Default)]
pub struct PlaceMemory {
    tables: RwLock<Vec<(Predictor, Arc<Places>)>>,
    /// The number of options in all tables.
    count: Arc<AtomicUsize>,
}

/// The known places of one option set, by one predictor.
#[derive(Debug)]
pub(super) struct Places {
    /// Tells the option set from others.
    options: Arc<()>,
    /// By what they depend on: see [`Places::key`]. The hash is the same in every process.
    known: RwLock<HashMap<Box<[u64]>, Place, FixedState>>,
    /// That of the memory.
    count: Arc<AtomicUsize>,
}

/// The options at a place, and which of them have become one way.
#[derive(Debug)]
struct Place {
    options: Box<[OptionTick]>,
    ways: Ways,
}

impl PlaceMemory {
    /// The places of these options, as this predictor sees them; `None` where there are too many of such pairs.
    pub(super) fn of(&self, options: &OptionSet, predictor: &Predictor) -> Option<Arc<Places>> {
        let find = |tables: &[(Predictor, Arc<Places>)]| {
            let is_it = |(by, places): &&(Predictor, Arc<Places>)| {
                Arc::ptr_eq(&places.options, &options.identity) && by == predictor
            };
            tables.iter().find(is_it).map(|(_, places)| Arc::clone(places))
        };
        if let Some(found) = find(&self.tables.read().ok()?) {
            return Some(found);
        }
        let mut tables = self.tables.write().ok()?;
        // another thread may have been here in between
        if let Some(found) = find(&tables) {
            return Some(found);
        }
        if tables.len() == MAX_TABLES {
            return None;
        }
        let (options, count) = (Arc::clone(&options.identity), Arc::clone(&self.count));
        let places = Arc::new(Places { options, known: RwLock::default(), count });
        tables.push((predictor.clone(), Arc::clone(&places)));
        Some(places)
    }
}

impl Places {
    /// Writes what the options of a team depend on: its progress, the option executed, and which of P_o and
    /// J~_o are asked for.
    pub fn key(key: &mut Vec<u64>, progress: &Progress, executed: Option<usize>, asked: [bool; 2]) {
        key.clear();
        let [choice, expected] = asked.map(u64::from);
        let executed = executed.map_or(0, |option| option as u64 + 1);
        key.push(executed << 2 | choice << 1 | expected);
        progress.write_words(key);
    }

    /// Gives what is known of a place to `take`. Returns whether anything is.
    pub fn find(&self, key: &[u64], take: impl FnOnce(&[OptionTick], &Ways)) -> bool {
        let Ok(known) = self.known.read() else { return false };
        let found = known.get(key);
        found.inspect(|place| take(&place.options, &place.ways)).is_some()
    }

    /// Keeps the options of a place, if there is room.
    pub fn keep(&self, key: &[u64], options: &[OptionTick], ways: &Ways) {
        if self.count.load(Ordering::Relaxed) + options.len() > MAX_OPTIONS {
            return;
        }
        let place = Place { options: options.into(), ways: ways.clone() };
        if let Ok(mut known) = self.known.write()
            && known.insert(key.into(), place).is_none()
        {
            self.count.fetch_add(options.len(), Ordering::Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::episode::{Episode, EpisodeSettings};
    use crate::policy::Method;
    use crate::preference::{Belief, Marginal, Perception};
    use crate::world::{BUILT_IN_WORLDS, World};

    #[test]
    fn property_episodes_that_share_places_are_those_that_do_not_to_the_bit() {
        let alpha = Marginal::truncated_normal(0.7, 0.1, 0.55, 0.95).unwrap();
        let normal = Belief::Independent { alpha, gamma: Marginal::uniform(0.5, 1.1).unwrap() };
        let mut lapsing = Predictor::default();
        lapsing.set_lapse_rate(0.1).unwrap();
        let memory = PlaceMemory::default();
        let mut found = 0;
        for built_in in BUILT_IN_WORLDS {
            let world = World::parse(built_in.name, built_in.text).unwrap();
            let options = OptionSet::new(&world, 10.0).unwrap();
            for predictor in
                [Predictor::default(), lapsing.clone(), Predictor::new(normal.clone(), 10.0).unwrap()]
            {
                for (method, predict) in
                    [(Method::MUTUAL, true), (Method::MUTUAL, false), (Method::HUMAN_LED, true)]
                {
                    let settings = EpisodeSettings {
                        predictor: predictor.clone(),
                        method,
                        predict_while_human_leads: predict,
                        ..EpisodeSettings::default()
                    };
                    for k in 0..6 {
                        let human = Perception {
                            alpha: 0.55 + 0.1 * f64::from(k % 3),
                            gamma: 0.6 + 0.1 * f64::from(k),
                        };
                        let mut own = Episode::new(&options, &settings, human);
                        let builder = Episode::builder(&options, &settings, human);
                        let mut sharing = builder.with_places(&memory).begin().unwrap();
                        while own.step().is_none() {
                            let before = memory.count.load(Ordering::Relaxed);
                            assert!(sharing.step().is_none());
                            assert_eq!(
                                sharing.state().digest(),
                                own.state().digest(),
                                "{} {method:?} {human:?}",
                                built_in.name
                            );
                            found += u32::from(memory.count.load(Ordering::Relaxed) == before);
                        }
                        assert!(sharing.step().is_some());
                    }
                }
            }
        }
        assert!(found > 10_000, "{found} places were known");
    }

    #[test]
    fn closed_form_its_size_is_limited() {
        let world = World::parse(BUILT_IN_WORLDS[0].name, BUILT_IN_WORLDS[0].text).unwrap();
        let options = OptionSet::new(&world, 10.0).unwrap();
        let memory = PlaceMemory::default();
        for k in 0..=MAX_TABLES {
            let predictor = Predictor::new(Belief::default(), k as f64).unwrap();
            assert_eq!(memory.of(&options, &predictor).is_some(), k < MAX_TABLES);
        }
        let table = |options: &OptionSet| memory.of(options, &Predictor::default());
        assert!(Arc::ptr_eq(&table(&options).unwrap(), &table(&options.clone()).unwrap()));
        // the options of another world, or of the same one built again, are others
        assert!(table(&OptionSet::new(&world, 10.0).unwrap()).is_none());

        let (places, progress) = (table(&options).unwrap(), options.begin());
        let settings = EpisodeSettings::default();
        let mut episode = Episode::new(&options, &settings, Perception { alpha: 0.7, gamma: 0.8 });
        episode.step();
        let (mut key, ways, kept) = (Vec::new(), Ways::default(), &episode.tick().options);
        for k in 0..=MAX_OPTIONS / kept.len() {
            Places::key(&mut key, &progress, Some(k), [true, false]);
            places.keep(&key, kept, &ways);
            let is_known = places.find(&key, |options, _| assert_eq!(options.len(), kept.len()));
            assert_eq!(is_known, k < MAX_OPTIONS / kept.len());
        }
        assert!(memory.count.load(Ordering::Relaxed) <= MAX_OPTIONS);
    }
}
