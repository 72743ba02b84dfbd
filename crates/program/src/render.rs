//! `cocarry render`: a recording as a page or a picture, and `--render` of `cocarry run`.

use super::output::{Failure, OverwriteArguments, examples, input, print, write_file};
use anyhow::anyhow;
use clap::Args;
use cocarry::error::{Error, Place, words};
use cocarry::robot::Robot;
use cocarry_output::output_file::Outputs;
use cocarry_recording::recording::{Playback, Reader};
use cocarry_recording::rendering::{self, Width};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The kinds of files, by their extensions.
const KINDS: [(&str, PictureKind); 5] = [
    ("html", PictureKind::Player),
    ("svg", PictureKind::StripSvg),
    ("png", PictureKind::StripPng),
    ("gif", PictureKind::Moving),
    ("json", PictureKind::Layout),
];

/// Render a recording: a 3-D player (.html), a filmstrip (.svg, .png), an animation (.gif), a layout for
/// Foxglove and Lichtblick (.json)
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry render run.mcap -o run.html", "a 3-D player in one file, for any browser, without a network"),
    ("cocarry render run.mcap -o run.gif", "the team on the map with phi next to it, at twice its speed"),
    ("cocarry render run.mcap -o run.svg --width 3.5in", "the team at six instants, for a paper"),
    ("cocarry render run.mcap -o run.png --width 1400px --instants 8", ""),
    ("cocarry render run.mcap -o layout.json", "the layout to import in Foxglove or Lichtblick, next to the recording"),
]))]
pub(super) struct RenderArguments {
    /// Recording (MCAP)
    recording: PathBuf,
    /// File to write. The extension selects the format: .html player, .svg or .png filmstrip, .gif animation,
    /// .json layout for Foxglove
    #[arg(short, long, value_name = "FILE", value_parser = Target::of)]
    output: Target,
    /// Width of a picture, in inches or pixels: 3.5in, 1200px. Type is at least 7 pt from 3.5 inches on; a
    /// PNG has 300 pixels an inch [default: 7in; .gif: 760px]
    #[arg(long, value_name = "WIDTH", value_parser = clap::value_parser!(Width))]
    width: Option<Width>,
    /// Number of instants in a filmstrip [default: 6]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=20))]
    instants: Option<u32>,
    /// The recording's robot file, for the meshes of a player: a recording has none [default: the collision
    /// shapes of links that have meshes]
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// Address of the page that runs the simulator, for "Take over from here" in a player: http://, https://, or
    /// relative to the player where both are published [default: that of `cocarry demo`, http://127.0.0.1:8790/]
    #[arg(long, value_name = "ADDRESS", value_parser = address)]
    demo: Option<String>,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

/// A file to render into.
#[derive(Clone, Debug)]
pub(super) struct Target {
    /// Its name.
    pub file: PathBuf,
    kind: PictureKind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PictureKind {
    Player,
    StripSvg,
    StripPng,
    Moving,
    Layout,
}

/// How to render.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Form<'a> {
    /// The width of a picture.
    pub width: Option<Width>,
    /// The number of instants in a filmstrip.
    pub instants: Option<u32>,
    /// The robot's file, for its meshes.
    pub robot: Option<&'a Path>,
    /// The address of the page that runs the simulator.
    pub demo: Option<&'a str>,
}

/// An address of a page.
fn address(text: &str) -> Result<String, String> {
    let expected =
        "expected http://..., https://... or a relative address, as in ../demo/, without # and spaces";
    let scheme = text.split(['/', '?']).next().unwrap_or_default().split_once(':');
    let is_known = scheme.is_none_or(|(scheme, _)| ["http", "https"].contains(&scheme));
    match is_known
        && !text.is_empty()
        && !text.contains(|c: char| c == '#' || c.is_whitespace() || c.is_control())
    {
        true => Ok(text.to_owned()),
        false => Err(expected.to_owned()),
    }
}

impl Target {
    /// The file of that name; an error if its extension is not one that can be rendered.
    pub fn of(name: &str) -> Result<Self, String> {
        let file = PathBuf::from(name);
        let ending = file.extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
        let Some((_, kind)) = KINDS.iter().find(|(known, _)| *known == ending) else {
            let known = KINDS.map(|(ending, _)| format!(".{ending}"));
            return Err(format!("expected one of the extensions {}", known.join(", ")));
        };
        Ok(Self { file, kind: *kind })
    }

    /// An error if the form has what this kind of file does not.
    fn check(&self, form: Form) -> Result<(), Failure> {
        let is_strip = matches!(self.kind, PictureKind::StripSvg | PictureKind::StripPng);
        let is_picture = is_strip || self.kind == PictureKind::Moving;
        let is_player = self.kind == PictureKind::Player;
        let misplaced = [
            ("--instants", form.instants.is_some() && !is_strip, ".svg and .png"),
            ("--width", form.width.is_some() && !is_picture, ".svg, .png and .gif"),
            ("--robot", form.robot.is_some() && !is_player, ".html"),
            ("--demo", form.demo.is_some() && !is_player, ".html"),
        ];
        match misplaced.into_iter().find(|(_, is_misplaced, _)| *is_misplaced) {
            None => Ok(()),
            Some((flag, _, kinds)) => {
                Err(input(anyhow!("{}: {flag} is for {kinds} only", self.file.display())))
            }
        }
    }

    /// Renders a recording into the file.
    pub fn render<R: Read>(
        &self,
        reader: &mut Reader<R>,
        form: Form,
        outputs: &Outputs,
    ) -> Result<(), Failure> {
        let name = reader.name().to_owned();
        let playback = Playback::read(reader).map_err(input)?;
        let title = Path::new(&name).file_stem().unwrap_or_default().to_string_lossy();
        let instants = form.instants.unwrap_or(6) as usize;
        let width = form.width.unwrap_or(match self.kind {
            PictureKind::Moving => Width::Pixels(760),
            _ => Width::Inches(7.0),
        });
        let rendered: Result<Vec<u8>, Error> = match self.kind {
            PictureKind::Player => {
                let robot = form.robot.map(Robot::load).transpose().map_err(input)?;
                let demo = form.demo.map_or_else(rendering::demo_address, str::to_owned);
                rendering::player(&playback, &title, robot.as_ref(), &demo).map(String::into_bytes)
            }
            PictureKind::StripSvg => {
                rendering::filmstrip_svg(&playback, instants, width).map(String::into_bytes)
            }
            PictureKind::StripPng => rendering::filmstrip_png(&playback, instants, width),
            PictureKind::Moving => rendering::moving_gif(&playback, width),
            PictureKind::Layout => Ok(rendering::viewer_layout(&playback).into_bytes()),
        };
        // what cannot be drawn is in the recording
        let rendered = rendered.map_err(|error| input(Error::at(Place::file(name.as_str()), words(&error))));
        write_file(outputs, &self.file, rendered?)
    }
}

pub(super) fn run_render(arguments: &RenderArguments) -> Result<ExitCode, Failure> {
    let RenderArguments { recording, output, width, instants, robot, demo, overwrite } = arguments;
    let form = Form { width: *width, instants: *instants, robot: robot.as_deref(), demo: demo.as_deref() };
    output.check(form)?;
    let inputs = [Some(recording), robot.as_ref()].into_iter().flatten().map(PathBuf::as_path);
    let outputs = overwrite.outputs(inputs, [&output.file])?;
    let mut reader = Reader::open(recording).map_err(input)?;
    output.render(&mut reader, form, &outputs)?;
    print(&format!("wrote {}\n", output.file.display()))?;
    Ok(ExitCode::SUCCESS)
}
