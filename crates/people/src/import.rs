//! Files that participants save where a page has no server.

use crate::digest::sha256;
use crate::store::{Begin, Chunk, Session, Store, StoreError, whole_digest};
use crate::study::{MAX_PARTICIPANTS, PeopleStudy};
use cocarry::bounds;
use cocarry::error::{Error, Place};
use cocarry::located;
use serde::Deserialize;
use std::path::Path;

/// What the page writes at the end, or JATOS has of a session so far: values of JSON, one after the other.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Saved {
    version: u64,
    study: String,
    key: String,
    platform_ids: Vec<(String, String)>,
    chunks: Vec<(u32, u32, String)>,
    /// Whether more may follow, as in JATOS.
    #[serde(default)]
    part: bool,
    /// The digest of the whole session.
    digest: Option<String>,
}

/// A session that was added.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Added {
    /// The pseudonym.
    pub participant: String,
    /// Whether it has its end.
    pub is_finished: bool,
}

/// Adds a file to a store: the one that a participant saved or that DataPipe passed on, or the results of
/// JATOS, which may have several sessions. The same one again changes nothing.
///
/// # Errors
/// The file is not one of the page, or of another study; the store refuses it.
pub fn add_file(
    study: &PeopleStudy,
    digest: &str,
    store: &mut Store,
    path: &Path,
    now: i64,
) -> Result<Vec<Added>, Error> {
    let file = path.display().to_string();
    let at = |sentence: &str| Error::at(Place::file(&file), sentence);
    let bytes =
        located::read_bytes(&bounds::SNAPSHOT, path).map_err(|error| located::unreadable(&file, error))?;
    let values = serde_json::Deserializer::from_slice(&bytes).into_iter::<Saved>();
    let mut sessions: Vec<Saved> = Vec::new();
    for saved in values {
        let saved = saved.map_err(|error| at("not answers that the page of a study saved").because(error))?;
        if saved.version != 1 {
            return Err(at("saved by a newer page; use a newer program"));
        }
        if saved.study != digest {
            let name = study.file.display();
            return Err(at(&format!("answers another study, or another version of it, than {name}")));
        }
        match sessions.iter_mut().find(|session| session.key == saved.key) {
            None => sessions.push(saved),
            Some(session) => session.extend(saved),
        }
    }
    if sessions.is_empty() {
        return Err(at("has no answers"));
    }
    let add = |session: Saved| {
        add(store, session, digest, now).map_err(|error| at("cannot be added to the answers").because(error))
    };
    sessions.into_iter().map(add).collect()
}

impl Saved {
    /// Adds what was saved later.
    fn extend(&mut self, later: Self) {
        self.chunks.extend(later.chunks);
        self.part &= later.part;
        self.digest = later.digest.or(self.digest.take());
    }
}

fn add(store: &mut Store, saved: Saved, study: &str, now: i64) -> Result<Added, StoreError> {
    let Saved { key, platform_ids, mut chunks, part, digest, .. } = saved;
    let begin = Begin { key: &key, platform_ids: &platform_ids, study, participants: MAX_PARTICIPANTS, now };
    let Session { participant, .. } = store.begin(&begin)?;
    // one whose receipt was lost was sent again
    chunks.sort();
    chunks.dedup();
    let mut stored = Vec::new();
    for (trial, number, body) in &chunks {
        let sha256 = sha256(body.as_bytes());
        store.put(&key, &Chunk { trial: *trial, number: *number, sha256: &sha256, body }, now)?;
        stored.push((*trial, *number, sha256));
    }
    if !part {
        store.finish(&key, &digest.unwrap_or_else(|| whole_digest(&stored)), None, now)?;
    }
    Ok(Added { participant, is_finished: !part })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::TEMPLATE;
    use serde_json::{Value, json};

    #[test]
    fn results_of_jatos_are_added_by_session_once_and_a_session_that_lacks_something_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("study.toml");
        std::fs::write(&file, TEMPLATE).unwrap();
        let study = PeopleStudy::read(&file).unwrap();
        let digest = sha256(b"a study");
        let key = |name: &str| sha256(name.as_bytes());
        let body = |n: u32| format!(r#"[{{"kind":"done","n":{n}}}]"#);
        let line = |name: &str, chunks: &[u32], more: Value| {
            let chunks: Vec<_> = chunks.iter().map(|n| (0, *n, body(*n))).collect();
            let mut line = json!({ "version": 1, "study": digest, "key": key(name), "platform_ids": [], "chunks": chunks });
            line.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
            format!("{line}\n")
        };
        let whole: Vec<_> = (0..3).map(|n| (0, n, sha256(body(n).as_bytes()))).collect();
        let part = || json!({ "part": true });
        let end = || json!({ "digest": whole_digest(&whole) });
        // one whole session, a chunk of which came twice, between the parts of one that was left
        let results = [
            line("anna", &[0], part()),
            line("ben", &[0], part()),
            line("anna", &[1], part()),
            line("anna", &[1, 2], part()),
            line("anna", &[], end()),
            line("ben", &[1], part()),
        ];
        let results_file = folder.path().join("results.txt");
        std::fs::write(&results_file, results.concat()).unwrap();
        let mut store = Store::open(&study.database()).unwrap();
        for _ in 0..2 {
            let added = add_file(&study, &digest, &mut store, &results_file, 0).unwrap();
            assert_eq!(added.iter().map(|added| added.is_finished).collect::<Vec<_>>(), [true, false]);
        }
        assert_eq!(store.counts().unwrap(), [2, 1]);
        assert_eq!(store.chunks(&key("anna")).unwrap().len(), 3);
        assert_eq!(store.chunks(&key("ben")).unwrap().len(), 2);
        // without its second chunk
        let lacking = [line("carla", &[0], part()), line("carla", &[2], part()), line("carla", &[], end())];
        std::fs::write(&results_file, lacking.concat()).unwrap();
        let error = add_file(&study, &digest, &mut store, &results_file, 0).unwrap_err();
        assert!(cocarry::error::words(&error).contains("results.txt"), "{error}");
        for text in ["", "{", "[]", "{}"] {
            std::fs::write(&results_file, text).unwrap();
            assert!(add_file(&study, &digest, &mut store, &results_file, 0).is_err(), "{text:?}");
        }
    }
}
