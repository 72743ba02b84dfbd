//! `cocarry robot init`: drafts a robot file from a URDF.

use super::output::{
    Failure, OverwriteArguments, counted, examples, has_extension, input, print, toml_file, write_file,
};
use super::xacro::XacroArguments;
use clap::{Args, ValueEnum};
use cocarry::robot::{Draft, DraftRequest, DriveKind};
use cocarry::suggestion::shell_word;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Draft a robot file from a URDF: find base, wheels, arm and tool, and solve postures
///
/// What was assumed is printed; edit the file where that is wrong. The tool is the end of an arm, by its name and
/// shape. Where more than 8 joints move between base and tool, the first ones are held, as is a second arm, which
/// is tucked away. Postures come from inverse kinematics with random starts, the same for every call, best first:
/// far from the joints' limits and from singular configurations, with the arm above the base. A xacro is refused
/// without --xacro.
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry robot init tiago.urdf", "tiago.toml, next to the URDF"),
    ("cocarry robot init tiago.urdf -o robots/tiago.toml", "another place"),
    ("cocarry robot init pr2.urdf --tool l_gripper_tool_frame", "another arm"),
    ("cocarry robot init summit.urdf --drive omnidirectional", "another base"),
    ("cocarry robot init rby1.urdf --hold torso_1=45 --hold torso_2=-90", "a torso that leans, degrees"),
    ("cocarry robot init ur5.urdf --base-size 0.8,0.6,0.5 --base-mass 80", "an arm on a base that its URDF lacks"),
]))]
pub(super) struct InitArguments {
    /// URDF, or a xacro
    urdf: PathBuf,
    /// The robot file to write [default: next to the URDF, with its name]
    #[arg(short, long, value_name = "FILE", value_parser = toml_file)]
    output: Option<PathBuf>,
    /// The link that holds the object
    #[arg(long, value_name = "LINK")]
    tool: Option<String>,
    /// The link that moves with the base [default: the one that carries the wheels and the arm]
    #[arg(long, value_name = "LINK")]
    base: Option<String>,
    /// How the base moves [default: differential, or omnidirectional if its wheels are named mecanum, are all
    /// steered, or have axes in several directions]
    #[arg(long, value_name = "DRIVE", value_enum)]
    drive: Option<Drive>,
    /// The joint of the left driven wheel
    #[arg(long, value_name = "JOINT", requires = "right_wheel")]
    left_wheel: Option<String>,
    /// The joint of the right driven wheel
    #[arg(long, value_name = "JOINT", requires = "left_wheel")]
    right_wheel: Option<String>,
    /// Radius of the wheels, m [default: measured on their shapes]
    #[arg(long, value_name = "M", value_parser = wheel_radius)]
    wheel_radius: Option<f64>,
    /// A joint that stays fixed, and its position: degrees, or m for a prismatic joint; may be repeated
    #[arg(long, value_name = "JOINT=VALUE", value_parser = hold)]
    hold: Vec<(String, f64)>,
    /// Length, width and height of the base that a robot stands on if its URDF has none, m: an omnidirectional box
    #[arg(long, value_name = "LENGTH,WIDTH,HEIGHT", value_parser = base_size)]
    base_size: Option<[f64; 3]>,
    /// Mass of that base, kg [default: 60]
    #[arg(long, value_name = "KG", value_parser = base_mass, requires = "base_size")]
    base_mass: Option<f64>,
    /// Height at which the object is held, m [default: the first of 0.7, 0.8, 0.9, 0.6, 1.0, 1.1 and 0.5 with enough
    /// room, or else the best from 0.15 to 2.0]
    #[arg(long, value_name = "M", value_parser = height)]
    grasp_height: Option<f64>,
    #[command(flatten)]
    xacro: XacroArguments,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

/// A drive on the command line.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Drive {
    /// Two driven wheels on one axle
    Differential,
    /// Two or more driven wheels on either side, which skid in turns
    SkidSteer,
    /// Mecanum wheels, omnidirectional wheels or powered casters
    Omnidirectional,
}

impl From<Drive> for DriveKind {
    fn from(drive: Drive) -> Self {
        match drive {
            Drive::Differential => Self::Differential,
            Drive::SkidSteer => Self::SkidSteer,
            Drive::Omnidirectional => Self::Omnidirectional,
        }
    }
}

/// A number in a range, or what it must be.
fn within(text: &str, is_good: impl Fn(f64) -> bool, expected: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok().filter(|&value| is_good(value));
    value.ok_or_else(|| format!("it must be {expected}"))
}

fn height(text: &str) -> Result<f64, String> {
    within(text, |h| (0.0..=3.0).contains(&h), "a number from 0 to 3 (metres)")
}

fn wheel_radius(text: &str) -> Result<f64, String> {
    within(text, |r| r > 0.0 && r <= 1.0, "a number greater than 0 and at most 1 (metres)")
}

fn base_mass(text: &str) -> Result<f64, String> {
    within(text, |m| m > 0.0 && m <= 10_000.0, "a number greater than 0 and at most 10000 (kilograms)")
}

fn base_size(text: &str) -> Result<[f64; 3], String> {
    let expected =
        "LENGTH,WIDTH,HEIGHT, each greater than 0 and at most 10 (metres), for example 0.8,0.6,0.5";
    let sizes = text.split(',').map(|size| within(size, |s| s > 0.0 && s <= 10.0, expected));
    let sizes: Vec<f64> = sizes.collect::<Result<_, _>>()?;
    sizes.try_into().map_err(|_| format!("it must be {expected}"))
}

fn hold(text: &str) -> Result<(String, f64), String> {
    let expected = "JOINT=VALUE, with a number of degrees, or of metres for a prismatic joint";
    let (joint, value) = text.rsplit_once('=').ok_or_else(|| format!("it must be {expected}"))?;
    Ok((joint.to_owned(), within(value, f64::is_finite, expected)?))
}

pub(super) fn run_robot_init(arguments: &InitArguments) -> Result<ExitCode, Failure> {
    let InitArguments { urdf, output, drive, left_wheel, right_wheel, xacro, overwrite, .. } = arguments;
    let next_to_urdf = || match has_extension(urdf, "xacro") {
        true => urdf.with_extension("").with_extension("toml"),
        false => urdf.with_extension("toml"),
    };
    let file = output.clone().unwrap_or_else(next_to_urdf);
    let outputs = overwrite.outputs([urdf.as_path()], [&file])?;
    let request = DraftRequest {
        tool: arguments.tool.clone(),
        base: arguments.base.clone(),
        drive: drive.map(DriveKind::from),
        wheels: left_wheel.clone().zip(right_wheel.clone()).map(|(left, right)| [left, right]),
        wheel_radius: arguments.wheel_radius,
        hold: arguments.hold.clone(),
        base_size: arguments.base_size,
        base_mass: arguments.base_mass,
        grasp_height: arguments.grasp_height,
    };
    let named = name_from(urdf, &file);
    let as_named = file.display().to_string();
    let draft = match xacro.expand() {
        Some(expand) => Draft::expanded(urdf, &named, &as_named, &request, expand),
        None => Draft::new(urdf, &named, &as_named, &request),
    };
    let draft = draft.map_err(input)?;
    write_file(&outputs, &file, &draft.text)?;
    let notes = draft.robot.warnings.iter().map(ToString::to_string);
    let lines: String =
        draft.assumed.iter().cloned().chain(notes).map(|line| format!("- {line}\n")).collect();
    let word = shell_word(&as_named);
    print(&format!(
        "wrote {as_named}: {}, {}\n\nAssumed\n{lines}\nTry:\n  \
        cocarry robot check {word}\n  \
        cocarry run environment-1 --robot {word} --render episode.html\n",
        counted(draft.robot.joint_count(), "joint"),
        counted(draft.robot.postures.len(), "posture"),
    ))?;
    Ok(ExitCode::SUCCESS)
}

/// The URDF as a robot file names it: its bare name if the two are in one folder, else its full path.
fn name_from(urdf: &Path, file: &Path) -> String {
    let folder = |path: &Path| {
        path.parent()
            .map(|p| if p.as_os_str().is_empty() { Path::new(".") } else { p })
            .and_then(|p| p.canonicalize().ok())
    };
    if let (Some(a), Some(b), Some(name)) = (folder(urdf), folder(file), urdf.file_name())
        && a == b
    {
        return name.to_string_lossy().into_owned();
    }
    urdf.canonicalize().unwrap_or_else(|_| urdf.to_owned()).display().to_string()
}
