//! `cocarry study`: studies with people.

#[cfg(feature = "people")]
mod browsers;
#[cfg(feature = "people")]
mod power;
#[cfg(feature = "people")]
mod report;
#[cfg(feature = "people")]
mod run;

use super::output::{Failure, OverwriteArguments, csv_file, examples};
use super::reproduce::Common;
use clap::{Args, Subcommand};
use std::path::PathBuf;
use std::process::ExitCode;

/// Ask people: which way they would choose, and when they would stop following the robot
#[derive(Debug, Subcommand)]
pub(super) enum Action {
    New(NewArguments),
    Check(StudyArguments),
    Build(BuildArguments),
    Serve(ServeArguments),
    Ethics(EthicsArguments),
    Collect(CollectArguments),
    Forget(ForgetArguments),
    Simulate(SimulateArguments),
    Report(ReportArguments),
    Power(PowerArguments),
}

/// Write a commented study into a folder, to start from
///
/// Needs the cargo feature `people`, as all of `cocarry study`.
#[derive(Args, Debug)]
#[command(after_help = examples(&[("cocarry study new carrying", "carrying/study.toml; it runs as it is")]))]
pub(super) struct NewArguments {
    /// Folder; it is created if it does not exist
    folder: PathBuf,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

/// Check a study file and the answers next to it, and print what a participant goes through
#[derive(Args, Debug)]
#[command(after_help = examples(&[("cocarry study check carrying/study.toml", "")]))]
pub(super) struct StudyArguments {
    /// Study file (TOML), as `cocarry study new` writes it
    study: PathBuf,
}

/// Write the page of a study as plain files, for any web host
///
/// Without a server of ours, `--sink` says where answers go. `download`: the last page saves them as a file,
/// which the participant hands over. `jatos`: to JATOS, with the files as the assets of a study's component.
/// `datapipe=ID`: to DataPipe, which passes them on to the Open Science Framework. `cocarry study collect --add
/// FILE` reads what these have. The code of the study file is shown after the receipt, or after the download;
/// who reads the page's files finds it earlier.
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry study build carrying/study.toml -o site", "the page, in the new folder site"),
    ("cocarry study build carrying/study.toml --sink jatos -o site", "for the assets of a study in JATOS"),
]))]
pub(super) struct BuildArguments {
    /// Study file (TOML)
    study: PathBuf,
    /// Folder to write into; it is created if it does not exist
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// Where the answers go: download, jatos or datapipe=ID with the experiment's id
    #[arg(long, value_name = "SINK", default_value = "download", value_parser = sink)]
    sink: GivenSink,
    #[command(flatten)]
    module: ModuleArguments,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

/// Where the simulator for the page is.
#[derive(Args, Debug)]
pub(super) struct ModuleArguments {
    /// For the task `carry`: the folder with cocarry.wasm, as `crates/web/build` makes it [default: what a
    /// program with the feature `page` has within, or the folder in a clone of the project]
    #[arg(long, value_name = "FOLDER")]
    page: Option<PathBuf>,
}

/// Serve a study, and keep what participants answer in a database next to the study file
///
/// The server listens at this computer's own address alone, and has no encryption. To be reached from
/// elsewhere it needs a proxy with encryption on this computer (nginx, Caddy), which passes the host's name on;
/// `--public` says that name. The administrator's page has a port of its own and a random token: it shows how
/// far participants are, and has the tables so far.
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry study serve carrying/study.toml", "for a browser on this computer; Ctrl-C ends it"),
    ("cocarry study serve carrying/study.toml --public https://study.example.org", "behind a proxy of that name"),
]))]
pub(super) struct ServeArguments {
    /// Study file (TOML)
    study: PathBuf,
    /// Serve at this port of this computer; 0 takes a free one
    #[arg(long, value_name = "PORT", default_value_t = 8791)]
    port: u16,
    /// Serve the administrator's page at this port of this computer; 0 takes a free one
    #[arg(long, value_name = "PORT", default_value_t = 0)]
    admin_port: u16,
    /// Also take requests that a proxy on this computer passes on from this address, such as
    /// https://study.example.org
    #[arg(long, value_name = "ADDRESS", value_parser = public)]
    public: Option<String>,
    #[command(flatten)]
    module: ModuleArguments,
}

/// Write a page about a study for an ethics board
///
/// It has the consent as a whole, what participants are asked, what is stored of them, where, for how long, who
/// can read it, and how it is removed: all from the study file. Equal studies give equal pages.
#[derive(Args, Debug)]
#[command(after_help = examples(&[("cocarry study ethics carrying/study.toml", "carrying/study.ethics.html")]))]
pub(super) struct EthicsArguments {
    /// Study file (TOML)
    study: PathBuf,
    /// File to write [default: next to the study file, with the extension ethics.html]
    #[arg(short, long, value_name = "FILE.html")]
    output: Option<PathBuf>,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

/// Write the answers of a study as tables for `cocarry fit`, `cocarry infer` and others
///
/// The folder gets answers.csv, switches.csv, participants.csv, responses.csv, dictionary.csv with the
/// meaning of every column, README.md, and the world files that are not built in; of the task `carry` also
/// carries.csv and a recording of each episode, which is run again and compared with the page's, second by
/// second. Who did not finish is left out, and what does not fit the study; the program prints it.
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry study collect carrying/study.toml -o answers", "then: cocarry infer answers/answers.csv answers/switches.csv"),
]))]
pub(super) struct CollectArguments {
    /// Study file (TOML)
    study: PathBuf,
    /// Folder to write into; it is created if it does not exist
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// Also use the pages of those who did not finish
    #[arg(long)]
    with_unfinished: bool,
    /// Add answers of a page without our server: a file that a participant saved or that DataPipe passed on, or
    /// results of JATOS; may be given several times
    #[arg(long, value_name = "FILE")]
    add: Vec<PathBuf>,
    /// Collect the participants of `cocarry study simulate`
    #[arg(long, conflicts_with = "add")]
    simulated: bool,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

/// Remove a person with all answers from the database, and search its files for what is left
///
/// Tables that were collected before still have the answers: collect them anew.
#[derive(Args, Debug)]
#[command(after_help = examples(&[("cocarry study forget carrying/study.toml p0123456789ab", "")]))]
pub(super) struct ForgetArguments {
    /// Study file (TOML)
    study: PathBuf,
    /// The person: the number that the last page shows, or the identity that a recruiting platform gave
    id: String,
}

/// Let simulated participants answer a study, in a database of their own
///
/// alpha, gamma and eta are drawn as for docs/data/simulated-answers.csv. A participant gives 100 % to the
/// option that eq. (3) chooses (5 % of the answers say nothing), and stops following where phi(k) of eq. (5)
/// exceeds 1. Pages of the task `carry` stay empty.
///
/// With `--browser` they answer on the page itself, in real time, in a browser without a window: the same
/// participants with the same answers, as exactly as a browser is on time. Of those who carry, every other one
/// leads along the way that they chose, with a pointer, and the others let themselves be led. Every fourth
/// browser has the size of a phone.
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry study simulate study.toml --participants 40 --truth truth.csv", ""),
    ("cocarry study simulate study.toml --participants 8 --browser", "a rehearsal of the page, as long as the study is"),
    ("cocarry study collect study.toml --simulated -o simulated", "then fit, and compare with truth.csv"),
]))]
pub(super) struct SimulateArguments {
    /// Study file (TOML)
    study: PathBuf,
    /// Number of participants
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=100_000))]
    participants: u64,
    /// Seed of the draws
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Write alpha, gamma and eta of every participant into this CSV file
    #[arg(long, value_name = "FILE", value_parser = csv_file)]
    truth: Option<PathBuf>,
    /// Let them answer on the page, in Chromium, Chrome or Edge, or another program of that family
    #[arg(long, value_name = "PROGRAM", num_args = 0..=1, require_equals = true)]
    browser: Option<Option<PathBuf>>,
    /// Number of browsers at once
    #[arg(long, value_name = "N", default_value_t = 4, requires = "browser", value_parser = clap::value_parser!(u64).range(1..=64))]
    at_once: u64,
    #[command(flatten)]
    module: ModuleArguments,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

/// Write a report on a study: participants, choices, tolerance, posterior, methods
///
/// The folder gets report.html, the same as report.md, a CSV file for each table and an SVG file for each
/// picture. With a study file, the tables of the answers are collected into its folder `answers` first; with
/// a folder of tables that `collect` wrote, nothing else is read. Headline figures are given with all who
/// finished, and without those who have a flag. What a study does not have, or has of too few, is named as
/// absent. Equal tables give equal bytes.
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry study report carrying/study.toml -o report", "the page is report/report.html"),
    ("cocarry study report answers -o report", "from the tables that `study collect` wrote"),
]))]
pub(super) struct ReportArguments {
    /// Study file (TOML), or the folder that `cocarry study collect` wrote
    study: PathBuf,
    #[command(flatten)]
    common: Common,
    /// Folder to write into; it is created if it does not exist
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// Report on the participants of `cocarry study simulate`
    #[arg(long)]
    simulated: bool,
    /// Draws of each of four chains, as in `cocarry infer`
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u64).range(100..=100_000))]
    draws: u64,
    /// Number of resamples of the participants for bootstrap intervals
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u64).range(40..=1_000_000))]
    resamples: u64,
    /// Seed of draws and resamples
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Replace an existing report in the folder; other files stay
    #[arg(long)]
    overwrite: bool,
}

/// How many participants a study needs, by simulated studies
///
/// Effects: `eta=WIDTH`, `alpha=WIDTH` and `gamma=WIDTH` are widths of a 95 % interval, of eta's median
/// (planning steps) as `cocarry fit eta` has it, and of the mean of alpha or gamma over people as `cocarry
/// infer` has it; `difference=D` is a difference between two methods within participants, as a share of the
/// standard deviation of the differences, found by a paired t-test. People are those of `cocarry study
/// simulate`, in the study's worlds.
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry study power study.toml --effect eta=4 --effect alpha=0.1", "by how many people they are known so well"),
    ("cocarry study power s.toml --effect difference=0.5 --comparisons 3 -o power", "three methods; the page is power/report.html"),
]))]
pub(super) struct PowerArguments {
    /// Study file (TOML)
    study: PathBuf,
    #[command(flatten)]
    common: Common,
    /// What the study shall find; may be given several times, each kind once
    #[arg(long, value_name = "EFFECT=SIZE", required = true)]
    effect: Vec<String>,
    /// Numbers of participants to try, separated by commas
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "8,12,16,20,30,40,60,80", value_parser = clap::value_parser!(u64).range(2..=2000))]
    participants: Vec<u64>,
    /// Number of simulated studies
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u64).range(10..=100_000))]
    studies: u64,
    /// Number of comparisons in the table in which the difference shall be found: with it as the smallest
    /// p-value, Holm's method tests it at 0.05 divided by this number
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=1000))]
    comparisons: u64,
    /// Share of the studies that shall find it
    #[arg(long, value_name = "SHARE", default_value_t = 0.8, value_parser = share)]
    power: f64,
    /// Seed of everything random
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Write a page, tables and pictures into this folder; it is created if it does not exist
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Replace an existing report in the folder; other files stay
    #[arg(long, requires = "output")]
    overwrite: bool,
}

/// A share between 0 and 1.
fn share(text: &str) -> Result<f64, String> {
    let share = text.parse().ok().filter(|share: &f64| *share > 0.0 && *share < 1.0);
    share.ok_or_else(|| "must be a number between 0 and 1".to_owned())
}

pub(super) fn run_study(action: &Action) -> Result<ExitCode, Failure> {
    #[cfg(feature = "people")]
    return run::run_action(action).map(|()| ExitCode::SUCCESS);
    #[cfg(not(feature = "people"))]
    {
        let _ = action;
        Err(super::output::input(anyhow::anyhow!(
            "this program was built without the feature `people`; build it with `cargo install --path crates/program \
             --features people`"
        )))
    }
}

/// Where a page without our server sends what it records.
#[derive(Clone, Debug)]
#[cfg_attr(not(feature = "people"), allow(dead_code, reason = "only studies with people have pages"))]
enum GivenSink {
    Download,
    Jatos,
    DataPipe(String),
}

fn sink(text: &str) -> Result<GivenSink, String> {
    let is_id = |id: &&str| !id.is_empty() && id.chars().all(|c| c.is_ascii_alphanumeric());
    match (text, text.strip_prefix("datapipe=").filter(is_id)) {
        ("download", _) => Ok(GivenSink::Download),
        ("jatos", _) => Ok(GivenSink::Jatos),
        (_, Some(id)) => Ok(GivenSink::DataPipe(id.to_owned())),
        _ => Err("must be download, jatos, or datapipe=ID with the letters and digits of an experiment's id"
            .to_owned()),
    }
}

/// An address without a path.
fn public(text: &str) -> Result<String, String> {
    let host = text.strip_prefix("https://").or_else(|| text.strip_prefix("http://"));
    let is_plain = |c: char| c.is_ascii_alphanumeric() || ".-:[]".contains(c);
    let is_address = host.is_some_and(|host| !host.is_empty() && host.chars().all(is_plain));
    let expected = "must be a scheme and a host without a path, such as https://study.example.org";
    is_address.then(|| text.to_owned()).ok_or_else(|| expected.to_owned())
}
