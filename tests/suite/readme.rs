//! The commands of the README, as they are written there.

use crate::support::{cocarry, repository, stderr};

#[test]
fn the_commands_of_the_readme_run() {
    let readme = std::fs::read_to_string(repository("README.md")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut run = 0;
    let mut in_shell = false;
    for line in readme.lines() {
        if line.starts_with("```") {
            in_shell = line == "```sh";
            continue;
        }
        let command = line.split('#').next().unwrap_or("").trim();
        let Some(arguments) = command.strip_prefix("cocarry").filter(|_| in_shell) else { continue };
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
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let output = cocarry(&arguments);
        assert!(output.status.success(), "{line}: {}", stderr(&output));
        run += 1;
    }
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
