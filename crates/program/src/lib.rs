//! The command-line program.

mod bench;
mod calibrate;
mod catalog;
mod catalog_robots;
mod cite;
mod cluster;
mod compare;
mod custom;
mod demo;
mod episode_report;
mod export;
mod file_kind;
mod fit;
mod infer;
mod inspect;
mod interrupt;
mod live;
mod mjcf;
mod model;
mod motor_log;
mod new;
mod output;
mod plot;
mod record;
mod recover;
mod regress;
mod render;
mod replay;
mod replay_log;
mod report_folder;
mod reproduce;
mod robot;
mod robot_check;
mod robot_init;
mod run;
mod scenario;
#[cfg(feature = "live")]
mod serving;
mod settings;
mod shell;
mod snapshots;
mod stimuli;
#[cfg_attr(not(feature = "people"), allow(dead_code, reason = "the feature `people` reads the arguments"))]
mod study;
mod sweep;
mod terminal;
mod text_table;
mod tick_log;
mod world;
mod worlds;
pub mod xacro;

pub use custom::{CustomPolicies, provide};
pub use robot::{exported_robot, robot_names};

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, Parser, Subcommand};
use cocarry::suggestion;
use output::Failure;
use std::error::Error;
use std::ffi::{OsStr, OsString};
use std::num::ParseIntError;
use std::process::ExitCode;

/// Simulates a human and a mobile manipulator that carry an object together but prefer different paths, and
/// shows which way of adapting works best.
#[derive(Debug, Parser)]
#[command(
    name = "cocarry",
    version,
    max_term_width = 100,
    after_help = after_help()
)]
struct ProgramArguments {
    #[command(subcommand)]
    command: Option<Command>,
    /// No warnings, notes and progress bars on standard error; errors are printed
    #[arg(short, long, global = true)]
    quiet: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    Run(Box<run::RunArguments>),
    Demo(demo::DemoArguments),
    World(world::WorldArguments),
    Worlds(worlds::WorldsArguments),
    #[command(subcommand)]
    Robot(RobotAction),
    New(new::NewArguments),
    Export(Box<export::ExportArguments>),
    Sweep(sweep::SweepArguments),
    #[command(subcommand)]
    Cluster(cluster::Action),
    Compare(compare::CompareArguments),
    Bench(bench::BenchArguments),
    Plot(plot::PlotArguments),
    #[command(subcommand)]
    Reproduce(reproduce::Claim),
    Inspect(inspect::InspectArguments),
    Recover(recover::RecoverArguments),
    Render(render::RenderArguments),
    Replay(replay::ReplayArguments),
    Cite(cite::CiteArguments),
    #[command(subcommand)]
    Fit(fit::Parameter),
    Infer(infer::InferArguments),
    Stimuli(stimuli::StimuliArguments),
    #[command(subcommand)]
    Study(study::Action),
    Calibrate(calibrate::CalibrateArguments),
    #[command(subcommand)]
    Regress(regress::Action),
    Completions(shell::CompletionsArguments),
    Man(shell::ManArguments),
}

/// Check the files of a robot, or draft a robot file from its URDF
#[derive(Debug, Subcommand)]
enum RobotAction {
    Check(robot_check::CheckArguments),
    Init(robot_init::InitArguments),
}

/// The last lines of the program's help.
fn after_help() -> String {
    let examples = output::examples(&[
        ("cocarry", "an episode, with defaults"),
        ("cocarry demo", "a page in your browser, to watch, change and steer episodes"),
        ("cocarry run environment-4 --eta 5 --svg run.svg", "a sensitive human, with a picture"),
        ("cocarry run environment-4 --render run.html", "a 3-D player in one file, for any browser"),
        ("cocarry world free-form --svg map.svg", "obstacles, openings and options of a world"),
        ("cocarry new kitchen", "a world, a robot and a study to start from"),
        ("cocarry robot init robot.urdf", "a robot file for your URDF"),
        ("cocarry sweep kitchen/study.toml", "a study of many episodes, as CSV"),
        ("cocarry compare study.csv", "its methods, pair by pair"),
        ("cocarry cluster slurm study.toml -o study.csv", "the same on a cluster"),
        ("cocarry run --record run.mcap", "a recording, to watch in Foxglove"),
        ("cocarry inspect run.mcap", "contents of a recording"),
        ("cocarry cite run.mcap", "bibliography entries of what it used"),
        ("cocarry reproduce h2", "Table II of the paper"),
        ("cocarry reproduce all -o report", "all its tables and figures, as a page"),
    ]);
    format!(
        "With no command, one episode is run in the paper's Environment 4 with the human of its example.\n\n\
        Exit codes:\n  \
        0    done (run: the team arrived; replay: identical)\n  \
        1    replay: different; regress check: figures moved;\n  \
        \x20    calibrate: not calibrated; cluster gather: shards missing\n  \
        2    bad input\n  \
        3    the team did not arrive\n  \
        4    an output could not be written\n  \
        130  interrupted\n\n{examples}"
    )
}

/// The program's arguments, commands and help, for documentation.
pub fn command() -> clap::Command {
    ProgramArguments::command()
}

/// The program: parses the process's arguments, runs the command and prints errors.
pub fn main() -> ExitCode {
    main_of(std::env::args_os())
}

/// [`main`] with these arguments, the first of which is the program's name.
pub fn main_of(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let words: Vec<OsString> = arguments.into_iter().collect();
    let arguments = match ProgramArguments::try_parse_from(&words) {
        Ok(arguments) => arguments,
        Err(error) => return refused(with_suggestion(error, &words)),
    };
    output::be_quiet(arguments.quiet);
    let done = match arguments.command {
        None => run::example(),
        Some(Command::Run(arguments)) => run::run_episode(&arguments),
        Some(Command::Demo(arguments)) => demo::run_demo(&arguments),
        Some(Command::World(arguments)) => world::run_world(&arguments),
        Some(Command::Worlds(arguments)) => worlds::run_worlds(&arguments),
        Some(Command::Robot(RobotAction::Check(arguments))) => robot_check::run_robot_check(&arguments),
        Some(Command::Robot(RobotAction::Init(arguments))) => robot_init::run_robot_init(&arguments),
        Some(Command::New(arguments)) => new::run_new(&arguments),
        Some(Command::Export(arguments)) => export::run_export(&arguments),
        Some(Command::Sweep(arguments)) => sweep::run_sweep(&arguments),
        Some(Command::Cluster(action)) => cluster::run_cluster(&action),
        Some(Command::Compare(arguments)) => compare::run_compare(&arguments),
        Some(Command::Bench(arguments)) => bench::run_bench(&arguments),
        Some(Command::Plot(arguments)) => plot::run_plot(&arguments),
        Some(Command::Reproduce(claim)) => reproduce::run_reproduce(&claim),
        Some(Command::Inspect(arguments)) => inspect::run_inspect(&arguments),
        Some(Command::Recover(arguments)) => recover::run_recover(&arguments),
        Some(Command::Stimuli(arguments)) => stimuli::run_stimuli(&arguments),
        Some(Command::Study(action)) => study::run_study(&action),
        Some(Command::Render(arguments)) => render::run_render(&arguments),
        Some(Command::Replay(arguments)) => replay::run_replay(&arguments),
        Some(Command::Cite(arguments)) => cite::run_cite(&arguments),
        Some(Command::Fit(parameter)) => fit::run_fit(&parameter),
        Some(Command::Infer(arguments)) => infer::run_infer(&arguments),
        Some(Command::Calibrate(arguments)) => calibrate::run_calibrate(&arguments),
        Some(Command::Regress(action)) => regress::run_regress(&action),
        Some(Command::Completions(arguments)) => shell::completions(&arguments, command()),
        Some(Command::Man(arguments)) => shell::man(&arguments, command()),
    };
    match done {
        Ok(code) => code,
        Err(failure) => {
            let (code, error) = match failure {
                Failure::Input(error) => (2, error),
                Failure::Output(error) => (4, error),
                Failure::Interrupted(error) => {
                    output::print_message(&format!("interrupted: {error:#}"));
                    return ExitCode::from(130);
                }
            };
            // the reader of standard output has what it wanted
            if output::is_closed_output(&error) {
                return ExitCode::SUCCESS;
            }
            output::print_error(&format_args!("{error:#}"));
            ExitCode::from(code)
        }
    }
}

/// Prints help that was asked for, or why the arguments are refused, in the terminal's width.
fn refused(error: clap::Error) -> ExitCode {
    if !error.use_stderr() {
        error.exit()
    }
    let text = not_whole(&error).unwrap_or(error).render().ansi().to_string();
    output::write_error(&terminal::wrapped(&text, terminal::error_width()));
    ExitCode::from(2)
}

/// The error with the command or argument that was probably meant, where clap has none: `rnu`, or `-eta` for `--eta`.
fn with_suggestion(mut error: clap::Error, words: &[OsString]) -> clap::Error {
    let mut of = command();
    of.build();
    for word in words.iter().skip(1).filter_map(|word| word.to_str()) {
        let Some(below) = of.find_subcommand(word) else { break };
        of = below.clone();
    }
    let invalid = |error: &clap::Error, kind| error.get(kind).map(ToString::to_string).unwrap_or_default();
    // a former argument is nobody's choice
    let suggested = invalid(&error, ContextKind::SuggestedArg);
    let is_hidden = |argument: &clap::Arg| {
        let long = argument.get_long().is_some_and(|long| suggested.strip_prefix("--") == Some(long));
        long && argument.is_hide_set()
    };
    if of.get_arguments().any(is_hidden) {
        error.remove(ContextKind::SuggestedArg);
    }
    match error.kind() {
        ErrorKind::InvalidSubcommand if error.get(ContextKind::SuggestedSubcommand).is_none() => {
            let name = invalid(&error, ContextKind::InvalidSubcommand);
            let known: Vec<&str> = of.get_subcommands().map(clap::Command::get_name).collect();
            if let Some(meant) = suggestion::nearest(&name, known) {
                let meant = ContextValue::Strings(vec![meant.to_owned()]);
                error.insert(ContextKind::SuggestedSubcommand, meant);
            }
        }
        ErrorKind::UnknownArgument if error.get(ContextKind::SuggestedArg).is_none() => {
            // how to give it as a value is no help
            error.remove(ContextKind::Suggested);
            let letter = invalid(&error, ContextKind::InvalidArg);
            let is_meant = |long: &&str| {
                let with_one = format!("-{long}");
                with_one.starts_with(&letter) && words.iter().any(|word| word == OsStr::new(&with_one))
            };
            if let Some(meant) = of.get_arguments().filter_map(clap::Arg::get_long).find(is_meant) {
                error.insert(ContextKind::SuggestedArg, ContextValue::String(format!("--{meant}")));
            }
        }
        _ => {}
    }
    error
}

/// The error of an argument that is not a whole number, in words.
fn not_whole(error: &clap::Error) -> Option<clap::Error> {
    error.source()?.downcast_ref::<ParseIntError>()?;
    let (argument, value) = (error.get(ContextKind::InvalidArg)?, error.get(ContextKind::InvalidValue)?);
    let sentence = format!("invalid value '{value}' for '{argument}': expected a whole number of at least 0");
    Some(clap::Error::raw(error.kind(), format!("{sentence}\n\nFor more information, try '--help'.\n")))
}

#[cfg(test)]
mod tests {
    #[test]
    fn golden_the_command_line_is_consistent() {
        super::command().debug_assert();
    }

    #[test]
    fn a_snapshot_takes_no_argument_that_settles_a_scenario() {
        let mut command = super::command();
        command.build();
        let run = command.find_subcommand("run").unwrap();
        let resume = run.get_arguments().find(|a| a.get_id() == "resume").unwrap();
        let refused: Vec<_> = run.get_arg_conflicts_with(resume).iter().map(|a| a.get_id()).collect();
        for argument in run.get_arguments() {
            let goes_along = [
                "json",
                "ticks",
                "svg",
                "width",
                "save_at",
                "resume",
                "record",
                "render",
                "overwrite",
                "live",
                "live_origin",
                "live_rate",
                "live_wait",
                "quiet",
                "help",
            ];
            let goes_along = goes_along.iter().any(|id| argument.get_id() == id);
            assert_ne!(refused.contains(&argument.get_id()), goes_along, "{}", argument.get_id());
        }
    }
}
