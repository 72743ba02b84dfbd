//! The commands of the README, as they are written there.

use crate::support::{cocarry, repository, stderr};
use serde_json::Value;

/// Words of a comment, and whether a run does what they say.
type Claim = (&'static str, fn(&Value) -> bool);

/// What comments behind `cocarry run` say of how an episode goes, and what its JSON has then. Each must occur
/// in the README.
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

#[test]
fn the_commands_of_the_readme_run_and_do_what_is_said_of_them() {
    let mut unseen: Vec<&str> = CLAIMS.iter().map(|(claim, _)| *claim).collect();
    let readme = std::fs::read_to_string(repository("README.md")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut run = 0;
    let mut in_shell = false;
    for line in readme.lines() {
        if line.starts_with("```") {
            in_shell = line == "```sh";
            continue;
        }
        let (command, comment) = line.split_once('#').unwrap_or((line, ""));
        let Some(arguments) = command.trim().strip_prefix("cocarry").filter(|_| in_shell) else { continue };
        // pictures and logs go elsewhere than into the repository; long searches are shortened
        let arguments: Vec<String> = arguments
            .split_whitespace()
            .map(|word| match word {
                "10000" => "20".to_owned(),
                "100" => "2".to_owned(),
                word if repository(word).exists() => word.to_owned(),
                word if [".svg", ".csv", ".jsonl", ".mcap", ".snapshot"]
                    .iter()
                    .any(|end| word.ends_with(end)) =>
                {
                    folder.path().join(word.replace('/', "-")).to_str().unwrap().to_owned()
                }
                word => word.to_owned(),
            })
            .collect();
        let mut arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let is_episode = arguments.first() == Some(&"run");
        if is_episode {
            arguments.push("--json");
        }
        let output = cocarry(&arguments);
        assert!(output.status.success(), "{line}: {}", stderr(&output));
        run += 1;
        let claims = CLAIMS.iter().filter(|(claim, _)| is_episode && comment.contains(claim));
        for (claim, holds) in claims {
            let told: Value = serde_json::from_slice(&output.stdout).expect("JSON");
            assert!(holds(&told), "{line}: not so: {claim}\n{told}");
            unseen.retain(|unseen| unseen != claim);
        }
    }
    assert!(unseen.is_empty(), "the README no longer says: {unseen:?}");
    assert!(run >= 5, "only {run} commands were found");
}

#[test]
fn the_test_command_of_the_readme_is_the_one_that_ci_runs() {
    let readme = std::fs::read_to_string(repository("README.md")).unwrap();
    let ci = std::fs::read_to_string(repository(".ci/run")).unwrap();
    let command = readme.lines().find(|line| line.starts_with("cargo test")).expect("a test command");
    let command = command.split('#').next().unwrap().trim();
    assert!(ci.lines().any(|line| line.trim() == command), "`{command}` is not in .ci/run");
}

#[test]
fn the_world_of_the_readme_is_a_world() {
    let readme = std::fs::read_to_string(repository("README.md")).unwrap();
    let (_, rest) = readme.split_once("```toml\n").expect("a world file");
    let (text, _) = rest.split_once("```").expect("its end");
    let world = cocarry::world::World::parse("README.md", text).unwrap_or_else(|e| panic!("{e}"));
    let set = cocarry::options::OptionSet::new(&world, 10.0).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(set.options().len(), 2);
}
