//! Names of files and in files that are something else to whoever shows them: a page, a terminal, a shell, a
//! spreadsheet; and names that no file can have.

use crate::recording::{MAGIC, rapier, record, short_on, unpacked};
use crate::support::{repository, stderr, stdout};
use cocarry::scenario::Plant;
use cocarry_recording::recording::{Playback, Reader};
use cocarry_recording::rendering::{demo_address, player};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn within(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cocarry")).args(arguments).current_dir(folder).output().unwrap()
}

/// Environment 4 with this before the names of the world and of its obstacles.
fn world(before: &str) -> String {
    let text = std::fs::read_to_string(repository("worlds/environment-4.toml")).unwrap();
    let text = text.replace("name = \"", &format!("name = \"{before}"));
    let text = text.replace("between = [\"", &format!("between = [\"{before}"));
    let text = text.replace("openings = [\"", &format!("openings = [\"{before}"));
    text.replace("\", \"wall", &format!("\", \"{before}wall"))
}

/// The text of the episode in a player's page.
fn episode(page: &str) -> &str {
    let (_, rest) = page.split_once("<script type=\"application/json\" id=\"episode\">").expect("an episode");
    rest.split_once("</script>").expect("its end").0
}

/// `<!--<script` in a script element hides its end from a browser.
#[test]
fn a_name_cannot_end_or_open_anything_in_the_page_of_a_player() {
    let folder = tempfile::tempdir().unwrap();
    let name = "<!--<script></script>&<b>";
    std::fs::write(folder.path().join("w.toml"), world(name)).unwrap();
    let output = within(folder.path(), &["run", "w.toml", "--plant", "point", "--render", "page.html"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let page = std::fs::read_to_string(folder.path().join("page.html")).unwrap();
    let episode = episode(&page);
    assert!(!episode.contains('<'), "{}", &episode[..episode.find('<').unwrap_or(0) + 20]);
    let episode: Value = serde_json::from_str(episode).expect("JSON");
    assert_eq!(episode["world"]["name"], format!("{name}Environment 4"));
    assert_eq!(episode["options"].as_array().unwrap().len(), 4);
}

/// Whether the page can show a value of a figure: a number, or that there is none.
fn is_figure(value: &Value) -> bool {
    value.is_null() || value.as_f64().is_some_and(|number| number.abs() <= 1e9)
}

/// What the player relies on without looking.
fn check_episode(episode: &Value) {
    let list = |value: &Value| value.as_array().expect("a list").clone();
    let times = list(&episode["frames"]["time_s"]);
    assert!(times.last().and_then(Value::as_f64).is_some_and(|end| end > 0.0), "{times:?}");
    for option in list(&episode["options"]) {
        assert!(list(&option["probability"]).iter().all(is_figure), "{option}");
    }
    let steps = &episode["steps"];
    for figure in steps["figures"].as_object().expect("figures").values() {
        assert!(list(&figure["values"]).iter().all(is_figure), "{figure}");
    }
    for key in ["mode", "executed", "preferred"] {
        assert!(list(&steps[key]).iter().all(|word| word.is_string() || word.is_null()), "{}", steps[key]);
    }
    for body in ["object", "hand", "torso"] {
        assert!(list(&episode["frames"][body]).iter().all(|n| n.is_f64() && is_figure(n)), "{body}");
    }
}

#[test]
fn a_forged_recording_is_refused_or_gives_figures_that_the_player_can_show() {
    let mut rng = ChaCha8Rng::seed_from_u64(38);
    let (mut shown, mut refused) = (0, 0);
    for plant in [Plant::Point, rapier()] {
        let whole = unpacked(&short_on(plant));
        let begins = |at: &usize| whole[*at..].starts_with(b"\":") && whole[at + 2].is_ascii_digit();
        let places: Vec<usize> = (0..whole.len() - 3).filter(begins).map(|at| at + 2).collect();
        for _ in 0..60 {
            let mut forged = whole.clone();
            for _ in 0..rng.random_range(1..40) {
                let at = places[rng.random_range(0..places.len())];
                let is_number = |byte: &&u8| byte.is_ascii_digit() || b".-e".contains(byte);
                let length = whole[at..].iter().take_while(is_number).count();
                let fit = ["null", "\"a\"", "1e300", "-1e9", "[]", "{}", "0", "9e9"];
                let fit: Vec<_> = fit.iter().filter(|word| word.len() <= length).collect();
                let word = format!("{:length$}", fit[rng.random_range(0..fit.len())]);
                forged[at..at + length].copy_from_slice(word.as_bytes());
            }
            let read = Reader::new(&forged[..], "m").and_then(|mut reader| Playback::read(&mut reader));
            match read {
                Err(_) => refused += 1,
                Ok(playback) => {
                    let page = player(&playback, "m", None, &demo_address()).expect("a page");
                    check_episode(&serde_json::from_str(episode(&page)).expect("JSON"));
                    shown += 1;
                }
            }
        }
    }
    assert!(shown > 20, "{shown} shown, {refused} refused");
}

/// They would show the rest of a line in another order, or two names as one.
#[test]
fn a_terminal_gets_no_characters_that_are_not_seen_or_change_the_direction_of_text() {
    let folder = tempfile::tempdir().unwrap();
    for (hidden, shown) in [('\u{200b}', "\\u200b"), ('\u{feff}', "\\ufeff"), ('\u{e0041}', "\\udb40\\udc41")]
    {
        std::fs::write(folder.path().join("w.toml"), world(&hidden.to_string())).unwrap();
        let output = within(folder.path(), &["world", "w.toml", "--json"]);
        let said = stdout(&output);
        assert!(said.contains(shown) && !said.contains(hidden), "{said}");
        let told: Value = serde_json::from_str(&said).expect("JSON");
        assert!(told.to_string().contains(hidden), "{told}");
    }
    std::fs::write(folder.path().join("w.toml"), world("\u{202e}abc\u{2066}")).unwrap();
    for arguments in [&["world", "w.toml"][..], &["world", "w.toml", "--json"]] {
        let output = within(folder.path(), arguments);
        assert!(output.status.success(), "{}", stderr(&output));
        let said = stdout(&output);
        assert!(said.contains("\\u202eabc\\u2066") && !said.contains(['\u{202e}', '\u{2066}']), "{said}");
    }
    std::fs::write(
        folder.path().join("w.toml"),
        world("\u{202e}").replace("size_m = [0.1, ", "size_m = [0.1, -"),
    )
    .unwrap();
    let said = stderr(&within(folder.path(), &["world", "w.toml"]));
    assert!(said.contains("\\u202e") && !said.contains('\u{202e}'), "{said}");
}

/// A cell that begins like a formula is one where a spreadsheet opens the file.
#[test]
fn no_cell_of_a_table_is_a_formula() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let names = ["=HYPERLINK(1)", "@a", "+b", "-c", "d"];
    let mut answers = "participant,world,option,percent\n".to_owned();
    for name in names {
        for option in 1..=4 {
            answers += &format!("{name},environment-1,{option},25\n");
        }
    }
    std::fs::write(path("a.csv"), answers).unwrap();
    let output = within(folder.path(), &["infer", "a.csv", "--csv", "people.csv", "--draws", "100"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let people = std::fs::read_to_string(path("people.csv")).unwrap();
    for name in &names[..4] {
        assert!(people.contains(&format!("\n'{name},")), "{people}");
    }
    assert!(people.contains("\nd,"), "{people}");
    std::fs::write(path("=w.toml"), world("")).unwrap();
    let study = "worlds = \"=w.toml\"\nplants = \"point\"\nseeds = 1\nmax_steps = 3\n";
    std::fs::write(path("s.toml"), study).unwrap();
    let output = within(folder.path(), &["sweep", "s.toml", "-o", "rows.csv"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let rows = std::fs::read_to_string(path("rows.csv")).unwrap();
    assert!(rows.contains(",'=w.toml,"), "{rows}");
    let again = within(folder.path(), &["sweep", "--summary", "rows.csv"]);
    assert!(again.status.success(), "{}", stderr(&again));
}

#[test]
fn a_printed_command_can_be_copied_whatever_is_in_its_names() {
    let folder = tempfile::tempdir().unwrap();
    let study = "worlds = \"environment-1\"\nplants = \"point\"\nseeds = 4\nmax_steps = 3\n";
    std::fs::write(folder.path().join("s.toml"), study).unwrap();
    let arguments = ["cluster", "slurm", "s.toml", "-o", "a $(touch x).csv", "--shards", "2", "--no-submit"];
    let output = within(folder.path(), &arguments);
    assert!(output.status.success(), "{}", stderr(&output));
    let said = stdout(&output);
    let line = said.lines().find(|line| line.starts_with("sbatch ")).expect("the command");
    // a shell reads the words that were meant
    let words = Command::new("sh").args(["-c", &format!("printf '%s\\n' {line}")]).output().unwrap();
    let words = String::from_utf8(words.stdout).unwrap();
    let words: Vec<&str> = words.lines().collect();
    let is_script = |word: &&str| word.ends_with("a $(touch x).csv.job/task.sh");
    assert!(words[1] == "--parsable" && words.iter().any(is_script), "{line}");
    assert_eq!(words.len(), 6, "{words:?}");
}

#[test]
fn a_name_that_no_file_can_have_is_refused_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let long = format!("{}.csv", "a".repeat(300));
    for (ticks, code, said) in [
        (long.as_str(), 2, "cannot be the name of a file"),
        ("none/t.csv", 4, "none/t.csv: cannot be written"),
    ] {
        let line = ["run", "environment-1", "--plant", "point", "--svg", "run.svg", "--ticks", ticks];
        let output = within(folder.path(), &line);
        assert_eq!(output.status.code(), Some(code), "{}", stderr(&output));
        assert!(stderr(&output).contains(said) && stdout(&output).is_empty(), "{}", stderr(&output));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}

/// More channels than a file has numbers for, each number used again.
#[test]
fn a_recording_of_many_channels_is_bad_input() {
    let folder = tempfile::tempdir().unwrap();
    let text = |text: &str| [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat();
    let mut bytes = MAGIC.to_vec();
    for i in 0..70_000_u32 {
        let id = (i as u16).to_le_bytes();
        bytes
            .extend(record(4, &[&id[..], &[0, 0], &text(&format!("/{i}")), &text("json"), &[0; 4]].concat()));
    }
    std::fs::write(folder.path().join("m.mcap"), &bytes).unwrap();
    let output = within(folder.path(), &["inspect", "m.mcap"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        stderr(&output).contains("has more than 10000 channels, too many to list"),
        "{}",
        stderr(&output)
    );
    let output = within(folder.path(), &["recover", "m.mcap", "-o", "out.mcap"]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(stderr(&output).contains("m.mcap: cannot be saved"), "{}", stderr(&output));
    assert!(!folder.path().join("out.mcap").exists());
}
