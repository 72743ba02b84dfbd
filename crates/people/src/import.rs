//! Files that participants save where a page has no server.

use crate::digest::sha256;
use crate::store::{Begin, Chunk, Session, Store, StoreError, whole_digest};
use crate::study::{MAX_PARTICIPANTS, Study};
use cocarry::bounds;
use cocarry::error::{Error, Place};
use cocarry::located;
use serde::Deserialize;
use std::path::Path;

/// What the page writes into a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Saved {
    version: u64,
    study: String,
    key: String,
    platform_ids: Vec<(String, String)>,
    chunks: Vec<(u32, u32, String)>,
}

/// Adds the file of a participant to a store. The same one again changes nothing. Whoever saved a file is
/// finished.
///
/// # Errors
/// The file is not one of the page, or of another study; the store refuses it.
pub fn add_file(
    study: &Study,
    digest: &str,
    store: &mut Store,
    path: &Path,
    now: i64,
) -> Result<Session, Error> {
    let file = path.display().to_string();
    let at = |sentence: &str| Error::at(Place::file(&file), sentence);
    let refused = |error: StoreError| at("cannot be added to the answers").because(error);
    let bytes =
        located::read_bytes(&bounds::SNAPSHOT, path).map_err(|error| located::unreadable(&file, error))?;
    let saved: Saved = serde_json::from_slice(&bytes)
        .map_err(|error| at("not a file that the page of a study saves").because(error))?;
    if saved.version != 1 {
        return Err(at("saved by a newer page; use a newer program"));
    }
    if saved.study != digest {
        let name = study.file.display();
        return Err(at(&format!("answers another study, or another version of it, than {name}")));
    }
    let Saved { key, platform_ids, mut chunks, .. } = saved;
    let begin =
        Begin { key: &key, platform_ids: &platform_ids, study: digest, participants: MAX_PARTICIPANTS, now };
    let session = store.begin(&begin).map_err(refused)?;
    chunks.sort();
    let mut stored = Vec::new();
    for (trial, number, body) in &chunks {
        let sha256 = sha256(body.as_bytes());
        store
            .put(&key, &Chunk { trial: *trial, number: *number, sha256: &sha256, body }, now)
            .map_err(refused)?;
        stored.push((*trial, *number, sha256));
    }
    store.finish(&key, &whole_digest(&stored), None, now).map_err(refused)?;
    Ok(session)
}
