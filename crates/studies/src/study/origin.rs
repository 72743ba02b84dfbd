//! The origin of results: the study, and the arithmetic.

use super::results::Identity;

/// Where rows come from.
#[derive(Clone, Debug)]
#[cfg_attr(not(feature = "parquet"), expect(dead_code, reason = "only Parquet files tell it"))]
pub(super) struct Origin {
    /// The text of the study file, if it is known.
    pub text: Option<String>,
    /// The study's digest.
    pub study: String,
    /// The number of episodes of the study.
    pub episodes: u64,
    /// The stamp of the arithmetic.
    pub arithmetic: String,
}

/// What the rows are of.
#[derive(Default)]
pub(super) struct Origins {
    pub rows: u64,
    pub unchecked: u64,
    /// Number of episodes by digest of the study, in the order of appearance.
    pub studies: Vec<(String, u64)>,
    /// That of the first row, and of all others.
    pub arithmetic: Option<String>,
    /// The identity of the row before.
    last: Option<Identity>,
}

impl Origins {
    /// Adds a row; its study and number there, and whether it is the next of the same study, or the first.
    pub fn add(&mut self, identity: Identity) -> (usize, u64, bool) {
        let is_next = self
            .last
            .as_ref()
            .is_none_or(|last| (&last.study, last.episode + 1) == (&identity.study, identity.episode));
        self.rows += 1;
        let known = self.studies.iter().position(|(study, _)| *study == identity.study);
        let study = known.unwrap_or_else(|| {
            self.studies.push((identity.study.clone(), identity.episodes));
            self.studies.len() - 1
        });
        let episode = identity.episode;
        self.last = Some(identity);
        (study, episode, is_next)
    }

    pub fn notes(&self, repeated: u64) -> Vec<String> {
        let mut notes = Vec::new();
        if self.unchecked > 0 {
            notes.push(format!(
                "{} of {} rows were written by another program, or without a checksum: their values could not be checked, and may be rounded",
                self.unchecked, self.rows
            ));
        }
        if repeated > 0 {
            notes.push(format!("{repeated} rows repeat others, and count once"));
        }
        notes
    }
}
