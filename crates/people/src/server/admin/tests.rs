//! Tests of what the administrator's page shows; its connections are tested with the program.

use super::page::overview;
use crate::collect::collect;
use crate::digest::sha256;
use crate::store::{Begin, Chunk, Store};
use crate::study::{PeopleStudy, TEMPLATE};

#[test]
fn progress_drop_outs_flags_and_hostile_texts_are_shown_as_text() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("study.toml");
    std::fs::write(&file, TEMPLATE.replace("Carrying together", "Carrying <b>together</b>")).unwrap();
    let study = PeopleStudy::read(&file).unwrap();
    let mut store = Store::open(&study.database()).unwrap();
    let mut put = |person: u8, study: &str, [trial, now]: [u32; 2], data: &str| {
        let (key, now) = (sha256(&[person]), i64::from(now));
        store.begin(&Begin { key: &key, platform_ids: &[], study, participants: 20, now }).unwrap();
        let body = format!(r#"[{{"kind":"done","data":{data}}}]"#);
        let sha256 = sha256(body.as_bytes());
        store.put(&key, &Chunk { trial, number: 0, sha256: &sha256, body: &body }, now).unwrap();
    };
    let script = r#"{"task":"consent","version":"<script>alert(1)</script>","order":1}"#;
    put(1, "old", [0, 100], script);
    put(
        1,
        "old",
        [5, 200],
        r#"{"task":"percentages","world":"<img src=x>","practice":false,"percent":[],"ms":1,"hidden_ms":0}"#,
    );
    put(2, "new", [5, 10_000], r#"{"task":"question","text":"?","answers":["a"],"right":false}"#);
    let collected = collect(&study, &store.ends_of_trials().unwrap(), true);
    let html = overview(&study, "new", &store.progress().unwrap(), &collected, 10_100);
    assert!(html.contains("Carrying &lt;b&gt;together&lt;/b&gt;"));
    assert!(html.contains("&lt;script&gt;alert(1)&lt;/script&gt;") && html.contains("&lt;img src=x&gt;"));
    for script in ["<script", "<img", "<b>", "onerror", "style="] {
        assert!(!html.contains(script), "{script}");
    }
    assert!(
        html.contains("<dt>Begun</dt><dd>2 of 20</dd>")
            && html.contains("<dt>Left before the end</dt><dd>1</dd>")
    );
    assert!(html.contains("1970-01-01 02:46:40 UTC"), "{html}");
    // one has left on the sixth page, and one is answering there
    assert!(html.contains("<td>percentages</td><td>1</td><td>1</td>"), "{html}");
    assert!(
        html.contains("<td>question-not-right</td><td>1</td>")
            && html.contains("<td>left-out</td><td>1</td>")
    );
    assert!(
        html.contains("<td>old</td><td>before</td><td>1</td>")
            && html.contains("<td>new</td><td>now</td><td>1</td>")
    );
    // the first order has one, the second one the other
    assert!(html.contains("<td>1</td><td>environment-1, environment-4</td><td>1</td><td>0</td>"), "{html}");
}
