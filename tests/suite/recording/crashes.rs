//! Full disks, folders that are not there, kills and Ctrl-C: what was written stays, and it is said what went
//! wrong.

use super::{example, messages, path, rapier};
use crate::support::{cocarry, json, stderr};
use cocarry::episode::EpisodeSettings;
use cocarry::scenario::Scenario;
use cocarry_recording::recording::{FileRecorder, Reader, recover};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

#[test]
fn a_recording_that_is_there_is_replaced_only_if_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let file = path(folder.path(), "r.mcap");
    for name in ["r.mcap", "r.mcap.partial"] {
        std::fs::write(folder.path().join(name), "mine").unwrap();
        let output = cocarry(&["run", "--plant", "point", "--record", &file]);
        assert_eq!(output.status.code(), Some(2));
        assert!(stderr(&output).contains(&format!("{name}: ")) && stderr(&output).contains("--overwrite"));
        assert_eq!(std::fs::read(folder.path().join(name)).unwrap(), b"mine");
        assert_eq!(
            std::fs::read_dir(folder.path()).unwrap().count(),
            1,
            "refused before anything is written"
        );
        assert!(cocarry(&["run", "--plant", "point", "--record", &file, "--overwrite"]).status.success());
        assert!(messages(&std::fs::read(&file).unwrap()).len() > 100);
        std::fs::remove_file(&file).unwrap();
    }
}

#[test]
fn a_folder_that_cannot_be_written_to_ends_with_4() {
    let folder = tempfile::tempdir().unwrap();
    let gone = path(folder.path(), "no/such/folder/r.mcap");
    // below a file nobody can write, whoever they are
    std::fs::write(folder.path().join("file"), "").unwrap();
    let below = path(folder.path(), "file/r.mcap");
    for file in [&*gone, &*below, "/proc/r.mcap"] {
        let output = cocarry(&["run", "--plant", "point", "--record", file]);
        assert_eq!(output.status.code(), Some(4), "{file}");
        assert!(stderr(&output).starts_with(&format!("error: {file}.partial: cannot be written")));
    }
    // a folder of that name, which no finished file could replace
    let taken = path(folder.path(), "taken.mcap");
    std::fs::create_dir(&taken).unwrap();
    let output = cocarry(&["run", "--plant", "point", "--record", &taken, "--overwrite"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        stderr(&output).contains("taken.mcap: is a directory, which is never replaced"),
        "{}",
        stderr(&output)
    );
    assert!(!Path::new(&format!("{taken}.partial")).exists(), "refused before anything is run");
    let whole = path(folder.path(), "r.mcap");
    assert!(cocarry(&["run", "--plant", "point", "--record", &whole]).status.success());
    let output = cocarry(&["recover", &whole, "-o", &gone]);
    assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
}

/// A world so long that a run in it takes many seconds.
fn long_world(folder: &Path) -> String {
    let text = "name = \"long\"\nrobot_width_m = 0.5\nstart_m = [0, 0]\ntarget_m = [5000, 0]\n";
    let file = folder.join("long.toml");
    std::fs::write(&file, text).unwrap();
    file.to_str().unwrap().to_owned()
}

/// Runs the program under `sh`, which sets the limit that a full disk would set, in blocks of 512 bytes.
fn with_room_for(blocks: u32, arguments: &str) -> Output {
    let program = env!("CARGO_BIN_EXE_cocarry");
    let command = format!("trap '' XFSZ; ulimit -f {blocks}; exec '{program}' {arguments}");
    let folder = crate::support::repository(".");
    Command::new("sh").args(["-c", &command]).current_dir(folder).output().unwrap()
}

#[test]
fn a_full_disk_ends_with_4_and_leaves_what_was_written() {
    let folder = tempfile::tempdir().unwrap();
    let file = path(folder.path(), "r.mcap");
    for blocks in [300, 500] {
        let output = with_room_for(blocks, &format!("run environment-4 --plant rapier --record '{file}'"));
        assert_eq!(output.status.code(), Some(4), "{blocks}: {}", stderr(&output));
        assert!(stderr(&output).contains("r.mcap.partial: cannot be written on"), "{}", stderr(&output));
        assert!(!Path::new(&file).exists());
        let partial = format!("{file}.partial");
        let saved = path(folder.path(), "saved.mcap");
        let output = cocarry(&["recover", &partial, "-o", &saved, "--overwrite"]);
        assert!(output.status.success(), "{blocks}: {}", stderr(&output));
        assert!(messages(&std::fs::read(&saved).unwrap()).len() > 50, "{blocks}");
        std::fs::remove_file(partial).unwrap();
    }
}

/// Not even the beginning, or not all that was to be recovered: there is nothing to be kept, and nothing in
/// the way of the next attempt.
#[test]
fn what_is_of_no_use_is_not_left_on_a_full_disk() {
    let folder = tempfile::tempdir().unwrap();
    let file = path(folder.path(), "r.mcap");
    let output = with_room_for(1, &format!("run environment-4 --plant point --record '{file}'"));
    assert_eq!(output.status.code(), Some(4));
    assert!(stderr(&output).contains("r.mcap.partial: cannot be written: "), "{}", stderr(&output));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    let output = with_room_for(300, &format!("recover recordings/environment-4.mcap -o '{file}'"));
    assert_eq!(output.status.code(), Some(4));
    assert!(stderr(&output).contains("r.mcap: cannot be written: "), "{}", stderr(&output));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

/// A run in the long world, once it has recorded something.
fn under_way(folder: &Path, name: &str) -> (std::process::Child, String) {
    let file = path(folder, name);
    let world = long_world(folder);
    let mut child = Command::new(env!("CARGO_BIN_EXE_cocarry"))
        .args(["run", &world, "--plant", "rapier", "--sway", "0", "--record", &file])
        .args(["--ticks", &format!("{file}.csv"), "--svg", &format!("{file}.svg")])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let partial = format!("{file}.partial");
    // it begins with what comes before the first step
    let mut begun = None;
    for _ in 0..3000 {
        let length = std::fs::metadata(&partial).map_or(0, |m| m.len());
        if length > 20_000 && length > *begun.get_or_insert(length) + 10_000 {
            return (child, file);
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    child.kill().unwrap();
    panic!("nothing was recorded: {}", child.wait().unwrap());
}

#[test]
fn a_killed_run_leaves_all_but_the_last_second() {
    let folder = tempfile::tempdir().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut runs: Vec<Vec<(String, u64, Vec<u8>)>> = Vec::new();
    for i in 0..4 {
        let (mut child, file) = under_way(folder.path(), &format!("{i}.mcap"));
        std::thread::sleep(Duration::from_millis(rng.random_range(0..400)));
        child.kill().unwrap();
        child.wait().unwrap();
        let saved = path(folder.path(), "saved.mcap");
        let output = cocarry(&["recover", &format!("{file}.partial"), "-o", &saved, "--overwrite"]);
        assert!(output.status.success(), "{}", stderr(&output));
        let saved = messages(&std::fs::read(&saved).unwrap());
        // what is saved ends with a whole second
        let last = saved.last().expect("messages").1;
        assert!(last >= 1_000_000_000 && last.is_multiple_of(1_000_000_000), "{last}");
        runs.push(saved);
    }
    runs.sort_by_key(Vec::len);
    let longest = runs.pop().unwrap();
    for run in runs {
        assert!(longest[..run.len()] == run[..], "what is saved is how the run began");
    }
}

/// Whenever it stops, at most a second is not in the system's hands.
#[test]
fn what_a_crash_leaves_is_at_most_a_second_behind() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = example(rapier());
    let settings = EpisodeSettings { tick_limit: Some(17), ..scenario.settings };
    let prepared = Scenario { settings, ..scenario }.prepare().unwrap();
    let mut episode = prepared.episode().unwrap();
    let file = folder.path().join("r.mcap");
    let mut recorder = FileRecorder::create(&file, false, &prepared, &episode).unwrap();
    let mut written = Vec::new();
    while episode.step().is_none() {
        recorder.step(&episode).unwrap();
        let left = std::fs::read(folder.path().join("r.mcap.partial")).unwrap();
        let to = folder.path().join("saved.mcap");
        recover(&mut Reader::new(&left[..], "m").unwrap(), &to, true).unwrap();
        let saved = messages(&std::fs::read(&to).unwrap());
        let (last, now) = (saved.last().unwrap().1, 200_000_000 * (episode.tick().step + 1));
        assert!(last + 1_000_000_000 > now && last <= now, "{last} of {now}");
        assert!(saved[..written.len()] == written[..]);
        written = saved;
    }
    assert!(written.len() > 100);
}

#[test]
#[cfg(unix)]
fn an_interrupted_run_finishes_its_files() {
    let folder = tempfile::tempdir().unwrap();
    for signal in ["INT", "TERM", "HUP"] {
        let (child, file) = under_way(folder.path(), &format!("{signal}.mcap"));
        Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status().unwrap();
        let output = child.wait_with_output().unwrap();
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(130), "{signal}: {said}");
        let told = json(&["inspect", &file, "--json"]);
        assert_eq!(told["outcome"]["outcome"], "interrupted");
        assert!(!Path::new(&format!("{file}.partial")).exists());
        let ticks = std::fs::read_to_string(format!("{file}.csv")).unwrap();
        let steps = ticks.lines().count() - 1;
        let files = format!("{file}, {file}.csv, {file}.svg");
        assert!(said.contains(&format!("interrupted after {steps} steps, which are in {files}")), "{said}");
        assert_eq!(told["outcome"]["steps"], steps);
        assert!(std::fs::read_to_string(format!("{file}.svg")).unwrap().contains("</svg>"));
    }
}

#[test]
#[cfg(unix)]
fn a_folder_that_vanishes_ends_with_4() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("gone")).unwrap();
    let (child, file) = under_way(&folder.path().join("gone"), "r.mcap");
    std::fs::remove_dir_all(folder.path().join("gone")).unwrap();
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(4));
    let said = stderr(&output);
    assert!(
        said.contains(&format!("{file}.partial: is complete, but cannot be renamed to {file}")),
        "{said}"
    );
}
