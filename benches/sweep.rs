//! A sweep from study to file, two threads against one.

mod rows;

use cocarry_studies::study::{Study, Sweep, SweepOutputs};
use rows::{Against, Declared};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

const ROWS: &[Declared] = &[
    Declared {
        name: "`sweep`, `mutual` on the planning level, two threads",
        unit: "us",
        cases: &["sweep/point"],
        against: &[Against::Peer("one thread", &["one thread/point"])],
    },
    Declared { name: "an episode of it", unit: "us", cases: &["episode/point"], against: &[] },
    Declared {
        name: "`sweep`, `human-led`, kinematic, two threads",
        unit: "us",
        cases: &["sweep/kinematic"],
        against: &[Against::Peer("one thread", &["one thread/kinematic"])],
    },
    Declared {
        name: "an episode of it, full control",
        unit: "us",
        cases: &["episode/kinematic"],
        against: &[],
    },
];

const STUDIES: [(&str, &str); 2] = [
    ("point", "plants = \"point\"\nmethods = \"mutual\"\nseeds = 100\n"),
    ("kinematic", "plants = \"kinematic\"\nmethods = \"human-led\"\nseeds = 2\n"),
];

fn time(study: &Study, out: &Path, threads: usize) -> Duration {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let begun = Instant::now();
    let sweep =
        Sweep::open(study, None, SweepOutputs { rows: out, ticks: None, overwrite: true }).expect("a file");
    pool.install(|| sweep.run(&|| (), &AtomicBool::new(false))).expect("rows");
    begun.elapsed()
}

fn main() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("results.csv");
    let worlds: Vec<_> = (1..=4).map(|n| format!("\"environment-{n}\"")).collect();
    rows::run("sweep", ROWS, |criterion, bench| {
        for (name, keys) in STUDIES {
            let text = format!("worlds = [{}]\n{keys}", worlds.join(", "));
            let study = Study::parse("bench", &text, Path::new(""), None).expect("a study");
            let (two, one) = (format!("sweep/{name}"), format!("one thread/{name}"));
            bench.in_turns(criterion, (&two, &one), || time(&study, &out, 2), || time(&study, &out, 1));
            if let Some(time) = bench.time(&two) {
                bench.give(&format!("episode/{name}"), time / study.episodes() as f64);
            }
        }
    });
}
