//! `cocarry completions` and `cocarry man`.

use super::output::{Failure, OverwriteArguments, examples, print_for_programs};
use anyhow::Context;
use clap::builder::PossibleValuesParser;
use clap::{Args, Command};
use clap_complete::Shell;
use cocarry::world::BUILT_IN_WORLDS;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Print a script that completes commands, options and values in your shell
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry completions bash > ~/.local/share/bash-completion/completions/cocarry", "bash: in every new shell"),
    ("cocarry completions zsh > ~/.zfunc/_cocarry", "zsh: if ~/.zfunc is in your fpath"),
    ("cocarry completions fish > ~/.config/fish/completions/cocarry.fish", "fish"),
]))]
pub(super) struct CompletionsArguments {
    /// Shell
    shell: Shell,
}

/// Print the manual page, or write the pages of all commands
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry man -o ~/.local/share/man/man1", "then: man cocarry, man cocarry-run"),
]))]
pub(super) struct ManArguments {
    /// Write a page for every command into this folder, which must exist, instead of printing the first
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

pub(super) fn completions(
    arguments: &CompletionsArguments,
    mut command: Command,
) -> Result<ExitCode, Failure> {
    let mut script = Vec::new();
    command = with_worlds(command);
    clap_complete::generate(arguments.shell, &mut command, "cocarry", &mut script);
    let script = String::from_utf8_lossy(&script);
    print_for_programs(&with_files(arguments.shell, &script))?;
    Ok(ExitCode::SUCCESS)
}

/// The commands that take a world.
const WITH_WORLD: [&str; 2] = ["run", "world"];

fn world_names() -> impl Iterator<Item = &'static str> {
    BUILT_IN_WORLDS.iter().map(|world| world.name)
}

/// The program's arguments, where the names of built-in worlds are values of a world.
fn with_worlds(command: Command) -> Command {
    WITH_WORLD.into_iter().fold(command, |command, name| {
        command.mut_subcommand(name, |command| {
            command.mut_arg("world", |world| world.value_parser(PossibleValuesParser::new(world_names())))
        })
    })
}

/// What completions say of the name of a world.
const WORLD: &str = "built-in world";

/// A script that also completes files as worlds. That of bash does where no name fits; those of fish, elvish
/// and PowerShell know options only, to which the names are added.
fn with_files(shell: Shell, script: &str) -> String {
    let names = world_names().collect::<Vec<_>>().join(" ");
    match shell {
        Shell::Zsh => {
            let both = format!("{{_alternative \"worlds:{WORLD}:({names})\" \"files:world file:_files\"}}");
            script.replace(&format!("({names})"), &both)
        }
        Shell::Fish => WITH_WORLD.into_iter().fold(script.to_owned(), |script, name| {
            script
                + &format!(
                    "complete -c cocarry -n \"__fish_cocarry_using_subcommand {name}\" -a \"{names}\"\n"
                )
        }),
        Shell::Elvish => {
            let line = |name: &str| format!("            cand {name} '{WORLD}'\n");
            after_commands(script, |command| format!("&'cocarry;{command}'= {{\n"), line)
        }
        Shell::PowerShell => {
            let line = |name: &str| {
                format!(
                    "            [CompletionResult]::new('{name}', '{name}', [CompletionResultType]::ParameterValue, '{WORLD}')\n"
                )
            };
            after_commands(script, |command| format!("'cocarry;{command}' {{\n"), line)
        }
        _ => script.to_owned(),
    }
}

/// A script with a line for every world where the part of a command that takes one begins.
fn after_commands(script: &str, begin: impl Fn(&str) -> String, line: impl Fn(&str) -> String) -> String {
    let lines: String = world_names().map(line).collect();
    WITH_WORLD.into_iter().fold(script.to_owned(), |script, command| {
        let begin = begin(command);
        script.replacen(&begin, &format!("{begin}{lines}"), 1)
    })
}

pub(super) fn man(arguments: &ManArguments, mut command: Command) -> Result<ExitCode, Failure> {
    command.build();
    let mut pages = Vec::new();
    match &arguments.output {
        None => print_for_programs(&page(command)?.1)?,
        Some(folder) => {
            collect(command, folder, &mut pages)?;
            let files: Vec<_> = pages.iter().map(|(file, text)| (file.clone(), text.as_str())).collect();
            super::export::write_all(arguments.overwrite, &files)?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// The name of the page of a command, and the page.
fn page(command: Command) -> Result<(String, String), Failure> {
    let page = clap_mangen::Man::new(command);
    let mut text = Vec::new();
    page.render(&mut text).context("manual page").map_err(Failure::Output)?;
    Ok((page.get_filename(), String::from_utf8_lossy(&text).into_owned()))
}

/// Adds the pages of a command and of those below it.
fn collect(command: clap::Command, folder: &Path, pages: &mut Vec<(PathBuf, String)>) -> Result<(), Failure> {
    for below in command.get_subcommands().filter(|below| below.get_name() != "help") {
        collect(below.clone(), folder, pages)?;
    }
    let (name, text) = page(command)?;
    pages.push((folder.join(name), text));
    Ok(())
}
