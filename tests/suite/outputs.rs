//! One rule for every output of every command: an existing file is replaced only with `--overwrite`, and
//! inputs, links and special files never.

use crate::support::{repository, stderr};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const WORLD: &str = "name = \"w\"\nrobot_width_m = 0.5\nstart_m = [0, 0]\ntarget_m = [2, 0]\n";
const STUDY: &str = "worlds = [\"world.toml\"]\nplants = [\"point\"]\nseeds = 2\n";
const SAMPLES: &str = "alpha,gamma\n0.7,0.8\n";
const NAMED: &str = "participant,world,option,step\np,environment.toml,1,20\n";
const SWITCHES: &str = "participant,world,option,step\np,environment-4,1,20\n";

/// A folder with a file of every kind that commands read.
struct Bench(tempfile::TempDir);

impl Bench {
    fn new() -> Self {
        let bench = Self(tempfile::tempdir().unwrap());
        let texts = [("world.toml", WORLD), ("study.toml", STUDY), ("switches.csv", SWITCHES)];
        for (name, text) in texts.into_iter().chain([("named.csv", NAMED), ("samples.csv", SAMPLES)]) {
            std::fs::write(bench.path(name), text).unwrap();
        }
        for (from, to) in [
            ("worlds/environment-1.toml", "environment.toml"),
            ("docs/data/table-1-humans.csv", "answers.csv"),
        ] {
            std::fs::copy(repository(from), bench.path(to)).unwrap();
        }
        bench.good("run world.toml --plant point --record in.mcap --save-at 3 in.snapshot");
        bench.good("sweep study.toml --shard 1/2 --output 1.csv");
        bench.good("sweep study.toml --shard 2/2 --output 2.csv");
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn run(&self, line: &str) -> Output {
        let program = env!("CARGO_BIN_EXE_cocarry");
        Command::new(program).args(line.split(' ')).current_dir(self.0.path()).output().unwrap()
    }

    fn good(&self, line: &str) {
        let output = self.run(line);
        assert!(output.status.success(), "{line}: {}", stderr(&output));
    }

    fn refused(&self, line: &str, words: &str) {
        let output = self.run(line);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{line}: {said}");
        assert!(said.contains(words), "{line}: {said}");
    }

    fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

/// Commands up to the name of their output, and what they read.
const OUTPUTS: [(&str, &str, &[&str]); 17] = [
    ("run world.toml --plant point --ticks ", "out.csv", &["world.toml"]),
    ("run --resume in.snapshot --ticks ", "out.jsonl", &["in.snapshot"]),
    ("run world.toml --plant point --svg ", "out.svg", &["world.toml"]),
    ("run world.toml --plant point --record ", "out.mcap", &["world.toml"]),
    ("run world.toml --plant point --save-at 3 ", "out.snapshot", &["world.toml"]),
    ("world environment.toml --svg ", "out.svg", &["environment.toml"]),
    ("inspect in.mcap --csv /coordination --output ", "out.csv", &["in.mcap"]),
    ("cite in.mcap -o ", "out.bib", &["in.mcap"]),
    ("inspect in.mcap --svg ", "out.svg", &["in.mcap"]),
    ("run world.toml --plant point --render ", "out.html", &[]),
    ("render in.mcap -o ", "out.html", &[]),
    ("recover in.mcap --output ", "out.mcap", &["in.mcap"]),
    ("sweep study.toml --output ", "out.csv", &["study.toml", "world.toml"]),
    ("fit eta switches.csv --svg ", "out.svg", &["switches.csv"]),
    ("fit eta named.csv --svg ", "out.svg", &["named.csv", "environment.toml"]),
    ("world environment.toml --belief-samples samples.csv --svg ", "out.svg", &["samples.csv"]),
    ("fit risk-weight answers.csv --normalise --resamples 40 --svg ", "out.svg", &["answers.csv"]),
];

#[test]
fn no_output_replaces_what_is_there_unasked() {
    let bench = Bench::new();
    for (command, name, inputs) in OUTPUTS {
        let line = format!("{command}{name}");
        std::fs::write(bench.path(name), "mine").unwrap();
        bench.refused(&line, &format!("{name}: exists already"));
        assert_eq!(bench.read(name), b"mine", "{line}");
        let names = bench.names();
        bench.good(&format!("{line} --overwrite"));
        assert_ne!(bench.read(name), b"mine", "{line}");
        assert_eq!(bench.names(), names, "{line}: nothing else is left");
        for input in inputs.iter().filter(|input| !command.contains("--ticks") || input.ends_with(".csv")) {
            let text = bench.read(input);
            // a name with another ending is refused before its file is looked at
            let has_rule = command.ends_with("--svg ") || command.ends_with("--record ");
            let is_kind = Path::new(input).extension() == Path::new(name).extension();
            let why =
                if has_rule && !is_kind { "expected the extension" } else { "is an input of this command" };
            bench.refused(&format!("{command}./{input} --overwrite"), why);
            assert_eq!(bench.read(input), text, "{command}");
        }
        std::fs::remove_file(bench.path(name)).unwrap();
    }
    let merged = "sweep --merge 1.csv 1.csv 2.csv --overwrite";
    bench.refused(merged, "1.csv: is an input of this command");
    std::fs::copy(bench.path("world.toml"), bench.path("world.svg")).unwrap();
    bench.refused("world world.svg --svg ./world.svg --overwrite", "is an input of this command");
    bench.refused(
        "run world.toml --plant point --svg x.svg --save-at 3 x.svg",
        "x.svg: duplicate output file",
    );
}

#[test]
#[cfg(unix)]
fn links_and_special_files_are_never_replaced() {
    let bench = Bench::new();
    std::fs::write(bench.path("mine"), "mine").unwrap();
    for (command, name, _) in OUTPUTS {
        std::os::unix::fs::symlink(bench.path("mine"), bench.path(name)).unwrap();
        bench.refused(&format!("{command}{name} --overwrite"), "is a symbolic link");
        std::fs::remove_file(bench.path(name)).unwrap();
    }
    assert_eq!(bench.read("mine"), b"mine");
    bench.refused("run world.toml --plant point --overwrite --save-at 3 /dev/null", "is a special file");
    assert!(Path::new("/dev/null").metadata().is_ok_and(|metadata| !metadata.is_file()));
}

#[test]
fn no_other_output_touches_an_unfinished_sweep() {
    let bench = Bench::new();
    std::fs::write(bench.path("out.csv.partial"), "rows of a sweep").unwrap();
    bench.good("run world.toml --plant point --ticks out.csv");
    bench.good("run world.toml --plant point --ticks out.csv --overwrite");
    assert_eq!(bench.read("out.csv.partial"), b"rows of a sweep");
}

#[test]
fn who_writes_a_name_has_it_alone() {
    let bench = Bench::new();
    let sweep = std::fs::File::create(bench.path("out.csv.partial")).unwrap();
    sweep.lock().unwrap();
    for command in
        ["sweep study.toml --output out.csv", "sweep --merge out.csv 1.csv 2.csv", "run --ticks out.csv"]
    {
        for overwrite in ["", " --overwrite"] {
            bench.refused(&format!("{command}{overwrite}"), "another process is writing it");
        }
    }
    assert!(!bench.path("out.csv").exists());
}
