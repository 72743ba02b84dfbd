//! A sweep from study to file: episodes per second, and two threads against one, taken in turns since other
//! work on the machine comes and goes.

use cocarry_studies::study::{Study, Sweep, SweepOutputs};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// Turns of one thread, then two.
const TURNS: usize = 7;

const STUDIES: [(&str, &str); 2] = [
    ("point, mutual", "plants = \"point\"\nmethods = \"mutual\"\nseeds = 500\n"),
    ("kinematic, human-led, full control", "plants = \"kinematic\"\nmethods = \"human-led\"\nseeds = 25\n"),
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
    for (name, keys) in STUDIES {
        let text = format!("worlds = [{}]\n{keys}", worlds.join(", "));
        let study = Study::parse("bench", &text, Path::new(""), None).expect("a study");
        let turns: Vec<_> = (0..TURNS).map(|_| [1, 2].map(|threads| time(&study, &out, threads))).collect();
        let ratios = turns.iter().map(|[one, two]| one.as_secs_f64() / two.as_secs_f64());
        let mut ratios: Vec<f64> = ratios.collect();
        ratios.sort_unstable_by(f64::total_cmp);
        let best = |i: usize| turns.iter().map(|turn| turn[i]).min().unwrap_or_default().as_secs_f64();
        let episodes = study.episodes() as f64;
        println!(
            "{name}: {episodes} episodes; one thread at best {:.3} ms an episode, two {:.3} ms: {:.2} times as fast; in the same turn {:.2} to {:.2} times, median {:.2}",
            1e3 * best(0) / episodes,
            1e3 * best(1) / episodes,
            best(0) / best(1),
            ratios[0],
            ratios[TURNS - 1],
            ratios[TURNS / 2],
        );
    }
}
