//! The arguments of the plant and its robot. Robot files are loaded, and the arguments are checked against
//! each other.

use super::catalog::ROBOT;
use super::catalog_robots::ROBOTS;
use super::file_kind::{self, FileKind};
use super::output::{Failure, input};
use super::settings::{SettingArguments, number, plants};
use super::xacro::XacroArguments;
use anyhow::anyhow;
use clap::Args;
use cocarry::Error;
use cocarry::robot::Robot;
use cocarry::scenario::{POSE, POSTURE, Plant, PlantKind, RobotSetup, SWAY, Scenario, Value};
use cocarry::suggestion;
use std::io;
use std::path::{Path, PathBuf};

/// The plant and the robot.
#[derive(Args, Debug)]
pub(super) struct RobotArguments {
    /// Plant: what the controller moves
    #[arg(long, default_value = PlantKind::Rapier.name(), value_parser = plants(&PlantKind::ALL))]
    plant: PlantKind,
    /// Robot file (TOML), or a URDF with a robot file of the same name next to it [default: the built-in
    /// robot]
    #[arg(long, value_name = "FILE")]
    pub robot: Option<PathBuf>,
    #[command(flatten)]
    xacro: XacroArguments,
}

impl RobotArguments {
    /// The plant with its robot, whose files are read and checked. The settings are checked against the
    /// plant, but not applied.
    pub fn plant(&self, settings: &SettingArguments) -> Result<Plant, Failure> {
        let robot = self.robot.as_ref().map(|_| ("robot", &POSTURE));
        let idle = robot.filter(|_| self.plant == PlantKind::Point).or_else(|| settings.idle(self.plant));
        if let Some((flag, setting)) = idle {
            let has_it = PlantKind::ALL.into_iter().filter(|plant| setting.applies.is_on(*plant, true));
            let has_it = has_it.map(PlantKind::name).collect::<Vec<_>>().join(" or ");
            let (what, plant) = (setting.applies.what(), self.plant.name());
            return Err(input(anyhow!(
                "--{flag} needs {what}, which --plant {plant} does not have; use --plant {has_it}"
            )));
        }
        let text = |setting| match settings.given(setting) {
            Some(Value::Text(text)) => Some(text.as_str()),
            _ => None,
        };
        if self.plant == PlantKind::Rapier && text(&POSE) == Some("whole-body") {
            return Err(input(anyhow!(
                "--pose whole-body needs --plant kinematic; with bodies, the base follows the path and is not optimised"
            )));
        }
        if self.plant == PlantKind::Point {
            return Ok(Plant::Point);
        }
        let robot = load_robot_with(self.robot.as_deref(), self.xacro)?;
        if let Some(asked) = text(&POSTURE).filter(|name| robot.posture(name).is_none()) {
            let known = robot.postures.iter().map(|posture| posture.name.as_str());
            let (file, hint) = (&robot.texts.file, suggestion::hint(asked, known.clone()));
            let known = suggestion::listed(known, usize::MAX);
            return Err(input(anyhow!(
                "--posture {asked}: {file} has no posture of that name; it has {known}{hint}"
            )));
        }
        Ok(Plant::new(self.plant, RobotSetup::new(&robot)))
    }
}

/// The sway of the human's hand, for commands without the other settings.
#[derive(Args, Debug)]
pub(super) struct SwayArguments {
    #[arg(long, value_name = "M", help = format!("{} (--plant rapier) [default: 0.01]", SWAY.about), value_parser = number(&SWAY), allow_negative_numbers = true)]
    pub sway: Option<f64>,
}

impl SwayArguments {
    /// The physical plant with the built-in robot and this sway.
    pub fn plant(&self) -> Result<Plant, Failure> {
        let robot = load_robot(None)?;
        let plant = Plant::new(PlantKind::Rapier, RobotSetup::new(&robot));
        let mut scenario = Scenario { plant, ..Scenario::defaults() };
        self.sway.iter().for_each(|sway| SWAY.set(&mut scenario, &Value::Number(*sway)));
        Ok(scenario.plant)
    }
}

/// The lateral sway of the hand on a plant, m; 0 without bodies.
pub(super) fn sway_of(plant: &Plant) -> f64 {
    plant.physics().map_or(0.0, |physics| physics.human.sway_lateral)
}

fn is_name(file: &Path, name: &str) -> bool {
    file == Path::new(name) && !file.is_file()
}

/// The robot of this name that `cocarry export` writes, unless there is a file of that name.
fn robot_to_export(file: &Path) -> Option<&'static str> {
    ROBOTS.iter().map(|robot| robot.name).find(|name| is_name(file, name))
}

/// The names of the robots that `cocarry export` writes, the built-in default first.
pub fn robot_names() -> [&'static str; ROBOTS.len()] {
    ROBOTS.map(|robot| robot.name)
}

/// The robot of this name that `cocarry export` writes, as it is read from its files; `None` if there is no
/// robot of that name, or a file of that name.
///
/// # Errors
/// The files of its meshes, which are read from a temporary folder, cannot be written there.
pub fn exported_robot(file: &Path) -> Option<Result<Robot, Error>> {
    let name = robot_to_export(file)?;
    if name == ROBOT {
        return Some(Robot::built_in());
    }
    let robot = ROBOTS.into_iter().find(|robot| robot.name == name)?;
    Some(read_exported(robot.name, robot.files))
}

/// The robot of these files. Its texts have the names that `cocarry export` gives them.
fn read_exported(name: &str, files: &[(&str, &[u8])]) -> Result<Robot, Error> {
    let written = || {
        let folder = tempfile::tempdir()?;
        for (file, bytes) in files {
            let file = folder.path().join(file);
            file.parent().map_or(Ok(()), std::fs::create_dir_all)?;
            std::fs::write(file, bytes)?;
        }
        Ok(folder)
    };
    let unwritten =
        |error: io::Error| Error::new(format!("{name}: its files cannot be written")).because(error);
    let folder = written().map_err(unwritten)?;
    let mut texts = Robot::load(&folder.path().join(format!("{name}.toml")))?.texts.without_folders();
    (texts.file, texts.urdf_file) = (format!("{name}.toml"), format!("{name}.urdf"));
    Robot::parse(&texts)
}

/// The error of a robot's name where a file belongs.
pub(super) fn check_is_file(flag: &str, file: &Path) -> Result<(), Failure> {
    let named = |name: &&str| is_name(file, name);
    let said = if [ROBOT, "built-in"].iter().any(named) && flag == "--robot" {
        format!(
            "the built-in robot is the default; leave --robot out, or write its files with `cocarry export {ROBOT}`"
        )
    } else if let Some(name) = robot_to_export(file) {
        format!(
            "not a file; `cocarry export {name}` writes this robot's files, then use `{flag} {name}.toml`"
        )
    } else {
        return Ok(());
    };
    Err(input(anyhow!("{flag} {}: {said}", file.display())))
}

/// The robot in a file, or the built-in one. A xacro is refused.
pub(super) fn load_robot(file: Option<&Path>) -> Result<Robot, Failure> {
    load_robot_with(file, XacroArguments::default())
}

/// As [`load_robot`], with a xacro expanded where the user asks for it.
fn load_robot_with(file: Option<&Path>, xacro: XacroArguments) -> Result<Robot, Failure> {
    let Some(file) = file else { return Robot::built_in().map_err(input) };
    check_is_file("--robot", file)?;
    let file = &file_kind::within(file, FileKind::Robot);
    let robot = Robot::check_expanded(file, xacro.expand()).map_err(|mut faults| faults.swap_remove(0));
    robot.map_err(|error| file_kind::refused(file, FileKind::Robot, error.into()))
}
