//! The README and the pages of the book, as they are written: files, commands, outputs, pictures and links.
//!
//! A page is followed from top to bottom in a folder of its own, which has copies of the repository's
//! [`INPUTS`]. Its blocks are, by the words behind the fence:
//!
//! | block | what is done |
//! | --- | --- |
//! | `toml NAME`, `csv NAME`, ... | the file NAME is written into the folder |
//! | `sh` | every line is run: `cocarry` with these arguments, or `cp` |
//! | `sh no_run` | every line is parsed only: it takes minutes, or needs a viewer |
//! | `sh ignore` | nothing |
//! | `console` | the command behind `$` is run; the block must be its output |
//! | anything else | nothing |
//!
//! `` `cocarry ...` `` within a sentence is parsed. Comments above and behind commands are checked by
//! [`CLAIMS`]. Figures that depend on many episodes come from kept tables: see [`figures`]. A picture whose
//! file name a command of the page has written must be that file. With the environment variable [`UPDATE`],
//! outputs, pictures and the pages of [`reference`] are written anew instead.

mod figures;
mod links;
mod reference;

use crate::support::{repository, stderr, stdout};
use clap::error::ErrorKind;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Set to anything: pages are brought up to date, not compared.
const UPDATE: &str = "COCARRY_UPDATE_BOOK";

/// What commands of the pages read.
const INPUTS: [&str; 4] = ["worlds", "docs", "recordings", "assets/robots"];

/// Defines the list of all pages, and a test for each.
macro_rules! pages {
    ($($test:ident: $page:literal,)*) => {
        const PAGES: &[&str] = &[$($page),*];
        $(#[test]
        fn $test() {
            follow($page);
        })*
    };
}

pages! {
    the_readme_can_be_followed: "README.md",
    the_quick_start_can_be_followed: "book/src/quick-start.md",
    the_page_of_the_model_can_be_followed: "book/src/model.md",
    the_page_of_worlds_can_be_followed: "book/src/worlds.md",
    the_page_of_measures_can_be_followed: "book/src/measures.md",
    the_page_of_the_benchmark_can_be_followed: "book/src/bench.md",
    the_page_of_robots_can_be_followed: "book/src/robots.md",
    the_page_of_published_robots_can_be_followed: "book/src/gallery.md",
    the_page_of_tiago_can_be_followed: "book/src/gallery/tiago.md",
    the_page_of_tiago_no_hand_can_be_followed: "book/src/gallery/tiago-no-hand.md",
    the_page_of_tiago_dual_can_be_followed: "book/src/gallery/tiago-dual.md",
    the_page_of_tiago_pro_can_be_followed: "book/src/gallery/tiago-pro.md",
    the_page_of_pr2_can_be_followed: "book/src/gallery/pr2.md",
    the_page_of_panda_can_be_followed: "book/src/gallery/panda.md",
    the_page_of_ur3_can_be_followed: "book/src/gallery/ur3.md",
    the_page_of_ur5_can_be_followed: "book/src/gallery/ur5.md",
    the_page_of_ur10_can_be_followed: "book/src/gallery/ur10.md",
    the_page_of_kinova_can_be_followed: "book/src/gallery/kinova.md",
    the_page_of_xarm7_can_be_followed: "book/src/gallery/xarm7.md",
    the_page_of_z1_can_be_followed: "book/src/gallery/z1.md",
    the_page_of_ur5_omni_can_be_followed: "book/src/gallery/ur5-omni.md",
    the_page_of_ur10_omni_can_be_followed: "book/src/gallery/ur10-omni.md",
    the_page_of_kinova_omni_can_be_followed: "book/src/gallery/kinova-omni.md",
    the_page_of_panda_omni_can_be_followed: "book/src/gallery/panda-omni.md",
    the_page_of_xarm7_omni_can_be_followed: "book/src/gallery/xarm7-omni.md",
    the_page_of_porter_can_be_followed: "book/src/gallery/porter.md",
    the_page_of_shuttle_can_be_followed: "book/src/gallery/shuttle.md",
    the_page_of_stretch_re1_can_be_followed: "book/src/gallery/stretch-re1.md",
    the_page_of_stretch_re2_can_be_followed: "book/src/gallery/stretch-re2.md",
    the_page_of_stretch_se3_can_be_followed: "book/src/gallery/stretch-se3.md",
    the_page_of_hsr_can_be_followed: "book/src/gallery/hsr.md",
    the_page_of_locobot_can_be_followed: "book/src/gallery/locobot.md",
    the_page_of_locobot_cmu_can_be_followed: "book/src/gallery/locobot-cmu.md",
    the_page_of_rby1a_can_be_followed: "book/src/gallery/rby1a.md",
    the_page_of_rby1m_can_be_followed: "book/src/gallery/rby1m.md",
    the_page_of_moma_tm12_can_be_followed: "book/src/gallery/moma-tm12.md",
    the_page_of_ffw_bg2_can_be_followed: "book/src/gallery/ffw-bg2.md",
    the_page_of_fetch_can_be_followed: "book/src/gallery/fetch.md",
    the_page_of_gen3_can_be_followed: "book/src/gallery/gen3.md",
    the_page_of_humans_can_be_followed: "book/src/humans.md",
    the_page_of_policies_can_be_followed: "book/src/policies.md",
    the_page_of_studies_can_be_followed: "book/src/studies.md",
    the_page_of_recordings_can_be_followed: "book/src/recordings.md",
    the_page_of_mujoco_can_be_followed: "book/src/mujoco.md",
    the_page_of_the_page_can_be_followed: "book/src/page.md",
    the_page_of_snapshots_can_be_followed: "book/src/snapshots.md",
    the_page_of_files_that_are_not_trusted_can_be_followed: "book/src/untrusted.md",
    the_page_of_people_can_be_followed: "book/src/people.md",
    the_page_of_peoples_results_can_be_followed: "book/src/people-results.md",
    the_page_of_fits_can_be_followed: "book/src/fits.md",
    the_page_of_participants_can_be_followed: "book/src/participants.md",
    the_page_of_regression_can_be_followed: "book/src/regression.md",
    the_page_of_the_library_can_be_followed: "book/src/library.md",
    the_page_of_python_can_be_followed: "book/src/python.md",
    the_page_of_the_physical_plant_can_be_followed: "book/src/physical-plant.md",
    the_page_of_releases_can_be_followed: "book/src/releasing.md",
    the_page_of_results_can_be_followed: "book/src/results.md",
    the_page_of_the_second_paper_can_be_followed: "book/src/second-paper.md",
    the_page_of_performance_can_be_followed: "book/src/performance.md",
    the_page_of_learning_can_be_followed: "book/src/learning.md",
    the_page_of_deviations_can_be_followed: "book/src/deviations.md",
    the_page_of_commands_can_be_followed: "book/src/commands.md",
    the_page_of_settings_can_be_followed: "book/src/settings.md",
    the_page_of_columns_can_be_followed: "book/src/columns.md",
    the_glossary_can_be_followed: "book/src/glossary.md",
}

/// Words of a comment behind `cocarry run`, and whether the JSON of the run agrees.
type Claim = (&'static str, fn(&Value) -> bool);

/// What comments say of how an episode goes. Each must occur on a page.
const CLAIMS: [Claim; 9] = [
    ("takes the lead at step 22", |told| told["transition_step"] == 22),
    ("ends on option 4", |told| told["last_option"] == "4"),
    ("turns onto option 4", |told| told["option_changes"][0]["to"] == "4"),
    ("ends on option 3", |told| told["last_option"] == "3"),
    ("the human leads from start to end", |told| {
        told["method"] == "without-model" && told["transition_step"].is_null()
    }),
    ("through narrow openings", |told| told["world"] == "Environment 2"),
    ("without a robot", |told| told["robot"].is_null()),
    ("a human who changes their mind on the way", |told| told["preference_changes"][0]["applied"] == true),
    ("at step 15, and again at step 40", |told| {
        [15, 40].into_iter().enumerate().all(|(i, step)| {
            let change = &told["preference_changes"][i];
            change["step"] == step && change["applied"] == true
        })
    }),
];

fn is_updating() -> bool {
    std::env::var_os(UPDATE).is_some()
}

fn read(page: &str) -> String {
    std::fs::read_to_string(repository(page)).unwrap_or_else(|e| panic!("{page}: {e}"))
}

/// Compares a page with what it should be, or brings it up to date.
fn settle(page: &str, found: &str, expected: &str) {
    if found == expected {
        return;
    }
    if is_updating() {
        return std::fs::write(repository(page), expected).unwrap_or_else(|e| panic!("{page}: {e}"));
    }
    let at = found.lines().zip(expected.lines()).take_while(|(found, expected)| found == expected).count();
    panic!(
        "{page}:{}: found\n  {}\nexpected\n  {}\n`{UPDATE}=1 cargo test --test suite book` brings the page up to date",
        at + 1,
        found.lines().nth(at).unwrap_or_default(),
        expected.lines().nth(at).unwrap_or_default()
    );
}

/// Does what a page says, and compares.
fn follow(page: &str) {
    let text = read(page);
    let workplace = Workplace::new(page);
    let mut expected = String::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        expected += &format!("{line}\n");
        let Some(kind) = line.strip_prefix("```") else {
            line.split('`').skip(1).step_by(2).for_each(|code| workplace.parse_inline(code));
            continue;
        };
        let body: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
        for line in workplace.block(kind, &body) {
            expected += &format!("{line}\n");
        }
        expected += "```\n";
    }
    settle(page, &text, &figures::fill(page, &expected));
    workplace.compare_pictures(&text);
}

/// The folder in which a page is followed.
struct Workplace<'a> {
    page: &'a str,
    folder: tempfile::TempDir,
}

impl<'a> Workplace<'a> {
    fn new(page: &'a str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        for input in INPUTS {
            copy(&repository(input), &folder.path().join(input));
        }
        Self { page, folder }
    }

    /// Does what a block says. Its lines, as they should be.
    fn block(&self, kind: &str, body: &[&str]) -> Vec<String> {
        match kind {
            "sh" => commands(body).for_each(|(line, above)| self.run_line(line, above)),
            "sh no_run" => commands(body).for_each(|(line, _)| {
                let (arguments, _) = self.command(line);
                self.parse(&arguments, &[]);
            }),
            "console" => {
                let command =
                    body[0].strip_prefix("$ ").unwrap_or_else(|| panic!("{}: {}", self.page, body[0]));
                let output = self.run(&self.command(command).0);
                return [body[0].to_owned()].into_iter().chain(lines(&stdout(&output))).collect();
            }
            _ => {
                if let Some((_, file)) = kind.split_once(' ').filter(|(_, file)| file.contains('.')) {
                    let file = self.folder.path().join(file);
                    std::fs::create_dir_all(file.parent().unwrap()).unwrap();
                    std::fs::write(file, body.join("\n") + "\n").unwrap();
                }
            }
        }
        body.iter().map(|line| (*line).to_owned()).collect()
    }

    /// Runs a line of a shell block, and checks the comments above and behind it.
    fn run_line(&self, line: &str, above: &str) {
        if let Some(files) = line.strip_prefix("cp ") {
            let (from, to) = files.split_once(' ').unwrap();
            std::fs::copy(self.folder.path().join(from), self.folder.path().join(to)).unwrap();
            return;
        }
        let (mut arguments, comment) = self.command(line);
        let is_episode = arguments.first().is_some_and(|command| command == "run");
        if is_episode {
            arguments.push("--json".to_owned());
        }
        let output = self.run(&arguments);
        let is_made = |claim: &str| is_episode && (above.contains(claim) || comment.contains(claim));
        for (claim, holds) in CLAIMS.iter().filter(|(claim, _)| is_made(claim)) {
            let told: Value = serde_json::from_slice(&output.stdout).expect("JSON");
            assert!(holds(&told), "{}: {line}: not so: {claim}\n{told}", self.page);
        }
    }

    /// The arguments and the comment of a line. `cargo run` is the program without a command.
    fn command<'l>(&self, line: &'l str) -> (Vec<String>, &'l str) {
        let (command, comment) = line.split_once(" #").unwrap_or((line, ""));
        if command.trim() == "cargo run --release" {
            return (Vec::new(), comment);
        }
        let arguments = command.strip_prefix("cocarry");
        let arguments = arguments.unwrap_or_else(|| panic!("{}: not run by this test: {line}", self.page));
        // what is between quotes is one word
        let words = arguments
            .split('"')
            .enumerate()
            .flat_map(|(i, part)| if i % 2 == 1 { vec![part] } else { part.split_whitespace().collect() });
        (words.map(str::to_owned).collect(), comment)
    }

    fn run(&self, arguments: &[String]) -> Output {
        let mut program = Command::new(env!("CARGO_BIN_EXE_cocarry"));
        program.args(arguments).env_remove("COLUMNS").current_dir(self.folder.path());
        let output = program.output().expect("it starts");
        assert!(output.status.success(), "{}: cocarry {arguments:?}: {}", self.page, stderr(&output));
        output
    }

    /// Parses a command within a sentence, which may be its name alone.
    fn parse_inline(&self, code: &str) {
        if code.starts_with("cocarry ") {
            let names = [
                ErrorKind::MissingRequiredArgument,
                ErrorKind::MissingSubcommand,
                ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand,
            ];
            self.parse(&self.command(code).0, &names);
        }
    }

    fn parse(&self, arguments: &[String], allowed: &[ErrorKind]) {
        let line = ["cocarry"].into_iter().chain(arguments.iter().map(String::as_str));
        if let Err(error) = cocarry_program::command().try_get_matches_from(line) {
            // help is an "error" of success
            let is_fine = error.exit_code() == 0 || allowed.contains(&error.kind());
            assert!(is_fine, "{}: cocarry {arguments:?}: {error}", self.page);
        }
    }

    /// Compares the pictures on the page with files of the same name that its commands wrote.
    fn compare_pictures(&self, text: &str) {
        for picture in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let Some(name) = Path::new(picture).file_name() else { continue };
            let made = self.folder.path().join(name);
            let shown = repository(self.page).parent().unwrap().join(picture);
            if !made.is_file() {
                continue;
            }
            let made = std::fs::read(made).unwrap();
            if is_updating() {
                std::fs::write(shown, made).unwrap();
            } else {
                assert!(
                    made == std::fs::read(&shown).unwrap(),
                    "{}: {picture} is of an earlier program",
                    self.page
                );
            }
        }
    }
}

/// The commands of a shell block, each with the comment in the line above it, if any.
fn commands<'l>(body: &'l [&'l str]) -> impl Iterator<Item = (&'l str, &'l str)> {
    let is_comment = |line: &str| line.starts_with('#');
    let above = body.iter().map(move |line| if is_comment(line) { line } else { "" });
    let above = [""].into_iter().chain(above);
    body.iter().copied().zip(above).filter(move |(line, _)| !is_comment(line))
}

/// Lines of an output, without spaces at their ends.
fn lines(output: &str) -> Vec<String> {
    output.trim_end().lines().map(|line| line.trim_end().to_owned()).collect()
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap_or_else(|e| panic!("{}: {e}", from.display())) {
        let (from, to): (PathBuf, PathBuf) =
            entry.map(|entry| (entry.path(), to.join(entry.file_name()))).unwrap();
        if from.is_dir() {
            copy(&from, &to);
        } else {
            std::fs::copy(from, to).unwrap();
        }
    }
}

#[test]
fn every_claim_is_a_comment_of_a_command() {
    let all: String = PAGES.iter().map(|page| read(page)).collect();
    let comments = all.lines().filter(|line| line.starts_with("# ") || line.starts_with("cocarry run"));
    let comments: Vec<&str> = comments.collect();
    for (claim, _) in CLAIMS {
        assert!(comments.iter().any(|comment| comment.contains(claim)), "no comment says: {claim}");
    }
}

#[test]
fn the_page_of_recordings_has_every_channel() {
    let page = read("book/src/recordings.md");
    for channel in cocarry_recording::recording::Channel::ALL {
        assert!(page.contains(&format!("| `{}` |", channel.topic())), "{}", channel.topic());
    }
}

#[test]
fn the_readme_fits_on_two_screens() {
    assert!(read("README.md").lines().count() <= 150);
}

#[test]
fn the_test_command_of_the_readme_is_the_one_that_ci_runs() {
    let readme = read("README.md");
    let ci = read(".ci/run");
    let command = readme.lines().find(|line| line.starts_with("cargo test")).expect("a test command");
    let command = command.split('#').next().unwrap().trim();
    assert!(ci.lines().any(|line| line.trim() == command), "`{command}` is not in .ci/run");
}

#[test]
fn the_citation_and_the_changelog_have_the_version_of_the_crate() {
    let version = env!("CARGO_PKG_VERSION");
    assert!(read("CITATION.cff").lines().any(|line| line == format!("version: {version}")));
    assert!(read("CHANGELOG.md").contains(&format!("\n## {version} - ")));
}

#[test]
fn the_costs_of_table_2_in_readme_and_book_are_those_that_the_program_prints() {
    let told = crate::support::json(&["reproduce", "h2", "--json"]);
    let rows = told["rows"].as_array().expect("rows");
    for environment in 1..=4 {
        let cells = rows.iter().filter(|row| row["environment"] == environment).map(|row| {
            let figure = |key: &str| row[key].as_f64().unwrap();
            format!("{:.1} ({:.1})", figure("ours_mean"), figure("paper_mean"))
        });
        let line = format!("| {environment} | {} |", cells.collect::<Vec<_>>().join(" | "));
        for page in ["README.md", "book/src/results.md"] {
            assert!(read(page).lines().any(|found| found == line), "{page}: {line}");
        }
    }
}
