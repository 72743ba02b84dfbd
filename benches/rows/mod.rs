//! What a bench measures, declared as rows of one table: name, unit, budget or peer. criterion measures; ratios
//! are those of one run. The rows are printed, and merged into `benches/results.json`: a row whose cases were
//! not all measured stays as it was, with the commit at which it was measured.

mod file;
mod print;

use criterion::Criterion;
use criterion::measurement::WallTime;
use file::{Comparison, Kind, Measured, Range, Results, Row};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, SystemTime};

/// A row of the table.
pub struct Declared {
    pub name: &'static str,
    /// `us` if the cases are times.
    pub unit: &'static str,
    /// Names of criterion's benchmarks (`group/function`) or of values given by [`Bench::give`]. The row has
    /// the least and the most of them.
    pub cases: &'static [&'static str],
    pub against: &'static [Against],
}

/// What a row is compared with.
#[allow(dead_code, reason = "some benches have budgets alone, or peers")]
pub enum Against {
    /// A limit in the row's unit.
    Budget(f64),
    /// A peer's name and its cases, one for every case of the row, or one for all.
    Peer(&'static str, &'static [&'static str]),
}

/// A run of a bench.
pub struct Bench {
    is_whole: bool,
    estimates: PathBuf,
    started: SystemTime,
    values: BTreeMap<String, f64>,
}

impl Bench {
    /// Whether all is measured: no name was given on the command line, and the run is not a check.
    #[allow(dead_code, reason = "for benches that measure something without criterion")]
    pub fn is_whole(&self) -> bool {
        self.is_whole
    }

    /// Median time of a criterion benchmark if this run has measured it, us.
    pub fn time(&self, id: &str) -> Option<f64> {
        estimates(&self.estimates, self.started).remove(id)
    }

    /// Gives a value that criterion does not measure.
    #[allow(dead_code, reason = "some benches have times alone")]
    pub fn give(&mut self, id: &str, value: f64) {
        self.values.insert(id.to_owned(), value);
    }

    /// Measures two ways in turns, since other work on the machine comes and goes: the first as criterion's
    /// benchmark `id` (`group/function`), the other as the case `other_id`. How many times as long the other
    /// takes in the median; `None` if this run does not measure it. Both return how long they took.
    #[allow(dead_code, reason = "some benches have peers that take far longer, or none")]
    pub fn in_turns(
        &mut self,
        criterion: &mut Criterion,
        (id, other_id): (&str, &str),
        mut one: impl FnMut() -> Duration,
        mut other: impl FnMut() -> Duration,
    ) -> Option<f64> {
        let (group, function) = id.split_once('/').expect("a group and a function");
        let mut ratios = Vec::new();
        let mut group = criterion.benchmark_group(group);
        group.sample_size(10).warm_up_time(Duration::from_millis(1));
        group.sampling_mode(criterion::SamplingMode::Flat);
        group.bench_function(function, |bencher: &mut criterion::Bencher<'_, WallTime>| {
            bencher.iter_custom(|iterations| {
                let turns = (0..iterations).map(|_| (one(), other()));
                let (one, other) = turns
                    .fold((Duration::ZERO, Duration::ZERO), |sum, turn| (sum.0 + turn.0, sum.1 + turn.1));
                ratios.push(other.as_secs_f64() / one.as_secs_f64());
                one
            });
        });
        group.finish();
        ratios.sort_unstable_by(f64::total_cmp);
        let time = self.time(id)?;
        let ratio = ratios[ratios.len() / 2];
        self.give(other_id, time * ratio);
        Some(ratio)
    }
}

/// Runs a bench: its groups, then its rows.
pub fn run(name: &str, rows: &[Declared], measure: impl FnOnce(&mut Criterion, &mut Bench)) {
    let estimates = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("criterion");
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let has = |argument: &str| arguments.iter().any(|other| other == argument);
    // `cargo test --benches` only checks that the benches run
    let is_measuring = has("--bench") && !has("--test") && !has("--list") && !has("--profile-time");
    let is_whole = is_measuring && arguments.iter().all(|argument| argument.starts_with('-'));
    let mut bench = Bench { is_whole, started: SystemTime::now(), values: BTreeMap::new(), estimates };
    let mut criterion = Criterion::default()
        .output_directory(&bench.estimates)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
        .sample_size(50)
        .nresamples(10_000)
        .without_plots()
        .configure_from_args();
    measure(&mut criterion, &mut bench);
    criterion.final_summary();
    if !is_measuring {
        return;
    }
    let mut values = self::estimates(&bench.estimates, bench.started);
    values.append(&mut bench.values);
    let measured = measured();
    let found = rows.iter().map(|row| (row.name, row_of(name, row, &values, &measured)));
    merge(name, found.collect());
}

/// All medians that criterion has written since a time, us, by the benchmarks' names.
fn estimates(folder: &Path, since: SystemTime) -> BTreeMap<String, f64> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        let Ok(entries) = std::fs::read_dir(&folder) else { continue };
        folders.extend(entries.filter_map(Result::ok).map(|entry| entry.path()).filter(|path| path.is_dir()));
        let estimates = folder.join("estimates.json");
        let is_new = folder.ends_with("new")
            && std::fs::metadata(&estimates).and_then(|file| file.modified()).is_ok_and(|time| time >= since);
        if is_new {
            let read = |name: &str| -> serde_json::Value {
                let text = std::fs::read_to_string(folder.join(name)).expect("a file of criterion");
                serde_json::from_str(&text).expect("JSON")
            };
            let (id, estimates) = (read("benchmark.json"), read("estimates.json"));
            let nanoseconds = estimates["median"]["point_estimate"].as_f64().expect("a median");
            found.insert(id["full_id"].as_str().expect("a name").to_owned(), nanoseconds / 1e3);
        }
    }
    found
}

/// A row with its values, if all of them were measured.
fn row_of(bench: &str, row: &Declared, values: &BTreeMap<String, f64>, measured: &Measured) -> Option<Row> {
    let all =
        |cases: &[&str]| -> Option<Vec<f64>> { cases.iter().map(|c| values.get(*c).copied()).collect() };
    let own = all(row.cases)?;
    let comparison = |against: &Against| {
        Some(match against {
            Against::Budget(limit) => Comparison {
                kind: Kind::Budget,
                name: String::new(),
                value: Range(*limit, *limit),
                ratio: range(own.iter().map(|value| value / limit)),
            },
            Against::Peer(name, cases) => {
                let peers = all(cases)?;
                assert!(peers.len() == own.len() || peers.len() == 1, "{}: {name}", row.name);
                let ratios = own.iter().zip(peers.iter().cycle()).map(|(own, peer)| peer / own);
                Comparison {
                    kind: Kind::Peer,
                    name: (*name).to_owned(),
                    value: range(peers.iter().copied()),
                    ratio: range(ratios),
                }
            }
        })
    };
    Some(Row {
        bench: bench.to_owned(),
        name: row.name.to_owned(),
        unit: row.unit.to_owned(),
        value: range(own.iter().copied()),
        against: row.against.iter().map(comparison).collect::<Option<_>>()?,
        measured: measured.clone(),
    })
}

/// The least and the most, to three digits.
fn range(values: impl Iterator<Item = f64>) -> Range {
    let (least, most) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), v| (l.min(v), m.max(v)));
    let rounded = |value: f64| format!("{value:.2e}").parse().expect("a number");
    Range(rounded(least), rounded(most))
}

/// Puts a bench's rows in place of its former ones in the file, and prints what was measured.
fn merge(bench: &str, found: Vec<(&str, Option<Row>)>) {
    let new: Vec<Row> = found.iter().filter_map(|(_, row)| row.clone()).collect();
    print::print(&new, "no row of the table was measured whole");
    let repository = repository();
    let mut results = Results::read(&repository);
    let (mut rows, former): (Vec<Row>, Vec<Row>) =
        results.rows.into_iter().partition(|row| row.bench != bench);
    rows.extend(
        found.into_iter().filter_map(|(name, row)| {
            row.or_else(|| former.iter().find(|former| former.name == name).cloned())
        }),
    );
    rows.sort_by(|a, b| a.bench.cmp(&b.bench));
    results.rows = rows;
    let text = serde_json::to_string_pretty(&results).expect("JSON") + "\n";
    let path = file::path(&repository);
    std::fs::write(&path, text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
}

fn measured() -> Measured {
    let git = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).current_dir(repository()).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    // what the benches themselves write is no change
    let status = ["status", "--porcelain", "--", ".", ":!benches/results.json", ":!book"];
    let changes = git(&status).is_some_and(|changes| !changes.is_empty());
    let commit = git(&["rev-parse", "--short=8", "HEAD"]).unwrap_or_default();
    Measured {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        commit: commit + if changes { "+" } else { "" },
        date: time::OffsetDateTime::now_utc().date().to_string(),
        cores: std::thread::available_parallelism().map_or(1, usize::from),
    }
}

/// The root of the repository, from that of a package.
fn repository() -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let is_root = |folder: &&Path| folder.join("benches/rows").is_dir();
    package.ancestors().find(is_root).expect("a clone").to_owned()
}
