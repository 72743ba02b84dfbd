//! `cocarry completions` and `cocarry man`.

use super::output::{Failure, OverwriteArguments, examples, print_for_programs};
use anyhow::Context;
use clap::{Args, Command};
use clap_complete::Shell;
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
    clap_complete::generate(arguments.shell, &mut command, "cocarry", &mut script);
    print_for_programs(&String::from_utf8_lossy(&script))?;
    Ok(ExitCode::SUCCESS)
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
