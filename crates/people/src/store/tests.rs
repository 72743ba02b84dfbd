//! Tests of the store.

use super::*;

fn key(n: u8) -> String {
    sha256(&[n])
}

fn begin<'a>(key: &'a str, platform_ids: &'a [(String, String)]) -> Begin<'a> {
    Begin { key, platform_ids, study: "study", participants: 3, now: 1_795_723_500 }
}

fn refusal<T>(result: Result<T, StoreError>) -> Refusal {
    match result {
        Err(StoreError::Refused(refusal)) => refusal,
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("it is not refused"),
    }
}

fn put(store: &mut Store, key: &str, [trial, number]: [u32; 2], body: &str) -> Result<Put, StoreError> {
    store.put(key, &Chunk { trial, number, sha256: &sha256(body.as_bytes()), body }, 5)
}

#[test]
fn a_session_begins_once_and_numbers_are_allotted_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(&folder.path().join("s.sqlite")).unwrap();
    let first = store.begin(&begin(&key(1), &[])).unwrap();
    assert_eq!(store.begin(&begin(&key(1), &[])).unwrap(), first);
    assert_eq!(first.place, 0);
    let anna = [("PID".to_owned(), "anna".to_owned())];
    let second = store.begin(&begin(&key(2), &anna)).unwrap();
    assert_eq!(second.place, 1);
    // the same person with another key
    assert_eq!(refusal(store.begin(&begin(&key(3), &anna))), Refusal::BegunBefore);
    // and the study is another one by now
    let key_3 = key(3);
    let changed = Begin { study: "study, corrected", ..begin(&key_3, &anna) };
    assert_eq!(refusal(store.begin(&changed)), Refusal::Changed);
    assert_eq!(store.begin(&begin(&key(3), &[])).unwrap().place, 2);
    assert_eq!(refusal(store.begin(&begin(&key(4), &[]))), Refusal::Full);
    assert!(matches!(refusal(store.begin(&begin("short", &[]))), Refusal::Form(_)));
    let script = [("PID".to_owned(), "<script>".to_owned())];
    assert!(matches!(refusal(store.begin(&begin(&key(4), &script))), Refusal::Form(_)));
    assert_eq!(store.counts().unwrap(), [3, 0]);
}

#[test]
fn a_chunk_is_stored_once_and_another_with_its_number_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(&folder.path().join("s.sqlite")).unwrap();
    store.begin(&begin(&key(1), &[])).unwrap();
    let body = r#"[{"kind":"done"}]"#;
    assert_eq!(put(&mut store, &key(1), [0, 0], body).unwrap(), Put::Stored);
    assert_eq!(put(&mut store, &key(1), [0, 0], body).unwrap(), Put::Known);
    assert_eq!(refusal(put(&mut store, &key(1), [0, 0], "[]")), Refusal::OtherChunk);
    assert_eq!(refusal(put(&mut store, &key(2), [0, 0], body)), Refusal::Unknown);
    assert!(matches!(refusal(put(&mut store, &key(1), [0, 1], "{}")), Refusal::Form(_)));
    let damaged = Chunk { trial: 0, number: 1, sha256: &sha256(b"other"), body };
    assert_eq!(refusal(store.put(&key(1), &damaged, 5)), Refusal::Damaged);
    let long = format!("[{}]", " ".repeat(MAX_CHUNK_BYTES));
    assert_eq!(refusal(put(&mut store, &key(1), [0, 1], &long)), Refusal::TooMuch);
    let chunks = store.chunks(&key(1)).unwrap();
    assert_eq!(chunks, [(0, 0, sha256(body.as_bytes()))]);
}

#[test]
fn the_code_is_given_for_the_digest_of_everything_alone() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(&folder.path().join("s.sqlite")).unwrap();
    let key = key(1);
    store.begin(&begin(&key, &[])).unwrap();
    assert_eq!(refusal(store.finish(&key, &whole_digest(&[]), None, 6)), Refusal::NotWhole);
    put(&mut store, &key, [1, 0], "[]").unwrap();
    put(&mut store, &key, [0, 0], "[]").unwrap();
    let lines = format!("0 0 {0}\n1 0 {0}\n", sha256(b"[]"));
    let digest = sha256(lines.as_bytes());
    assert_eq!(refusal(store.finish(&key, &sha256(b"x"), None, 6)), Refusal::NotWhole);
    let code = store.finish(&key, &digest, None, 6).unwrap();
    assert_eq!(code.len(), 8);
    assert_eq!(store.finish(&key, &digest, None, 7).unwrap(), code);
    assert_eq!(store.finish(&key, &digest, Some("ALL"), 7).unwrap(), "ALL");
    assert_eq!(refusal(put(&mut store, &key, [2, 0], "[]")), Refusal::Finished);
    assert_eq!(put(&mut store, &key, [1, 0], "[]").unwrap(), Put::Known);
    let session = &store.sessions().unwrap()[0];
    assert_eq!(session.begun, "2026-11-26T20:05:00Z");
    assert_eq!(session.finished.as_deref(), Some("1970-01-01T00:00:06Z"));
}

#[test]
fn nothing_of_a_forgotten_person_is_in_the_files_and_the_others_stay() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("s.sqlite");
    let mut store = Store::open(&file).unwrap();
    let anna = [("PID".to_owned(), "annasidentity".to_owned()), ("STUDY".to_owned(), "shared".to_owned())];
    let ben = [("PID".to_owned(), "bensidentity".to_owned()), ("STUDY".to_owned(), "shared".to_owned())];
    let participant = store.begin(&begin(&key(1), &anna)).unwrap().participant;
    store.begin(&begin(&key(2), &ben)).unwrap();
    for n in 0..40 {
        put(&mut store, &key(1), [n, 0], r#"[{"secretword":1}]"#).unwrap();
        put(&mut store, &key(2), [n, 0], "[]").unwrap();
    }
    let bytes = || {
        let mut bytes = std::fs::read(&file).unwrap();
        bytes.extend(std::fs::read(folder.path().join("s.sqlite-wal")).unwrap_or_default());
        bytes
    };
    let has = |text: &str| bytes().windows(text.len()).any(|part| part == text.as_bytes());
    assert!(has("annasidentity") && has(&participant) && has("secretword"));
    assert!(store.forget("shared").unwrap_err().to_string().contains("stands for 2 people"));
    assert!(store.forget("clara").unwrap_err().to_string().contains("nobody is known as `clara`"));
    let forgotten = store.forget("annasidentity").unwrap();
    assert_eq!((forgotten.chunks, forgotten.platform_ids, &forgotten.participant), (40, 2, &participant));
    assert!(
        !has("annasidentity") && !has(&participant) && !has("secretword") && !has(&sha256(key(1).as_bytes()))
    );
    assert!(has("bensidentity") && store.faults().unwrap().is_empty());
    assert_eq!(store.chunks(&key(2)).unwrap().len(), 40);
    assert_eq!(refusal(store.chunks(&key(1))), Refusal::Unknown);
}

#[test]
fn a_store_of_a_newer_program_and_a_file_of_others_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("s.sqlite");
    assert!(Store::open_existing(&file).is_err());
    Store::open(&file).unwrap().connection.pragma_update(None, "user_version", 9).unwrap();
    let Err(error) = Store::open(&file) else { panic!("it is opened") };
    assert!(error.to_string().contains("version 9"), "{error}");
    std::fs::write(
        folder.path().join("text.sqlite"),
        "not a database, but long enough to be one".repeat(100),
    )
    .unwrap();
    assert!(Store::open(&folder.path().join("text.sqlite")).is_err());
}

#[test]
fn a_store_of_the_first_version_is_brought_up_to_date_and_still_bounded() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("s.sqlite");
    let old = Connection::open(&file).unwrap();
    old.execute_batch(MIGRATIONS[0]).unwrap();
    old.execute_batch(
        "INSERT INTO study VALUES (1, x'00'); PRAGMA user_version = 1;
         INSERT INTO sessions VALUES ('p1', 'k', 0, 'study', 0, NULL, NULL), ('p2', 'l', 1, 'study', 0, NULL, NULL);
         INSERT INTO chunks VALUES ('p1', 0, 0, 'a', 5, '[]'), ('p1', 0, 1, 'b', 6, '[{\"é\":1}]');",
    )
    .unwrap();
    drop(old);
    let store = Store::open(&file).unwrap();
    let of = |participant: &str| -> (i64, i64) {
        let counted = "SELECT chunks, bytes FROM sessions WHERE participant = ?1";
        store.connection.query_row(counted, [participant], |row| Ok((row.get(0)?, row.get(1)?))).unwrap()
    };
    assert_eq!([of("p1"), of("p2")], [(2, 12), (0, 0)]);
}

#[test]
fn requests_that_share_a_transaction_are_all_stored_or_none_is() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(&folder.path().join("s.sqlite")).unwrap();
    let key_1 = key(1);
    store.begin(&begin(&key_1, &[])).unwrap();
    let sha256 = sha256(b"[]");
    let chunk = |number| Chunk { trial: 0, number, sha256: &sha256, body: "[]" };
    let failed: Result<(), _> = store.alone(|writing| {
        writing.put(&key_1, &chunk(0), 5)?;
        Err(Fault::Database(rusqlite::Error::InvalidQuery))
    });
    assert!(matches!(failed, Err(StoreError::Database { .. })));
    assert_eq!(store.chunks(&key_1).unwrap().len(), 0);
    let puts = store.alone(|writing| {
        [0, 1, 0]
            .map(|number| writing.put(&key_1, &chunk(number), 5))
            .into_iter()
            .collect::<Result<Vec<_>, _>>()
    });
    assert_eq!(puts.unwrap(), [Put::Stored, Put::Stored, Put::Known]);
}
