//! The robots that the program exports, with their meshes, and what is drawn of them.

#[path = "../../program/src/catalog_robots.rs"]
mod catalog_robots;

use catalog_robots::{ROBOTS, RobotFiles};
use cocarry::error::{Error, Place};
use cocarry::geometry::{PlanarPose, Point};
use cocarry::robot::{ArmJoint, Configuration, Motion, Robot, RobotTexts};
use cocarry::scenario::{GivenRobot, Word};
use cocarry_output::player::{self, Meshes};
use serde::Deserialize;
use serde_json::{Value, json};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::Path;

/// The robot of `cocarry run` without a robot file.
pub const BUILT_IN: &str = "carrier";
/// The hulls of the collision meshes, which the program makes of the mesh files. A test writes them.
pub const HULLS: [(&str, &str); 2] =
    [("porter", include_str!("../robots/porter.json")), ("shuttle", include_str!("../robots/shuttle.json"))];

thread_local! {
    /// The robots so far.
    static KNOWN: RefCell<BTreeMap<&'static str, GivenRobot>> = RefCell::default();
}

/// A request of a robot.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Request {
    robot: String,
}

/// Names and descriptions.
pub fn names() -> Vec<Word> {
    ROBOTS.iter().map(|robot| (robot.name, robot.about)).collect()
}

fn files(name: &str) -> Result<&'static RobotFiles, Error> {
    ROBOTS.iter().find(|robot| robot.name == name).ok_or_else(|| {
        let known = ROBOTS.iter().map(|robot| robot.name);
        Error::unknown(Place::file("the scenario"), "robot", name, known, ROBOTS.len())
    })
}

/// The robot of a name, as the program reads it from its exported files.
///
/// # Errors
/// There is none.
pub fn named(name: &str) -> Result<GivenRobot, Error> {
    let files = files(name)?;
    if let Some(robot) = KNOWN.with_borrow(|known| known.get(files.name).cloned()) {
        return Ok(robot);
    }
    let robot = if files.name == BUILT_IN { Robot::built_in()?.into() } else { parsed(files)? };
    KNOWN.with_borrow_mut(|known| known.insert(files.name, robot.clone()));
    Ok(robot)
}

fn parsed(files: &RobotFiles) -> Result<GivenRobot, Error> {
    let text = |name: &str| {
        let found = files.files.iter().find(|(file, _)| *file == name);
        found.map_or_else(String::new, |(_, bytes)| String::from_utf8_lossy(bytes).into_owned())
    };
    let (file, urdf_file) = (format!("{}.toml", files.name), format!("{}.urdf", files.name));
    let mut texts =
        json!({ "text": text(&file), "urdf": text(&urdf_file), "file": file, "urdf_file": urdf_file });
    let wrong = |error| Error::new(format!("the built-in robot {}", files.name)).because(error);
    if let Some((_, hulls)) = HULLS.iter().find(|(name, _)| *name == files.name) {
        texts["hulls"] = serde_json::from_str(hulls).map_err(wrong)?;
        single(&mut texts["hulls"]);
    }
    serde_json::from_value::<RobotTexts>(texts).map(GivenRobot::from).map_err(wrong)
}

/// Makes numbers those of single precision, as mesh files have them: their texts are shorter.
fn single(value: &mut Value) {
    match value {
        Value::Array(items) => items.iter_mut().for_each(single),
        Value::Object(entries) => entries.values_mut().for_each(single),
        value => *value = value.as_f64().map(|number| f64::from(number as f32)).into(),
    }
}

/// The robot as it is drawn.
///
/// # Errors
/// There is none of this name.
pub fn describe(request: Request) -> Result<Value, Error> {
    let files = files(&request.robot)?;
    let robot = named(files.name)?.robot()?;
    let read = |path: &Path| {
        let end = path.to_string_lossy();
        let found = files.files.iter().find(|(name, _)| end.ends_with(name));
        found
            .map(|(_, bytes)| bytes.to_vec())
            .ok_or_else(|| Error::at(Place::file(end), "no mesh of this robot"))
    };
    let mut meshes = Meshes::new(Some(&read));
    let links = robot.links.iter().map(|link| {
        let shapes = player::shapes(link, &mut meshes)?;
        Ok(json!({ "name": link.name, "shapes": shapes }))
    });
    let links = links.collect::<Result<Vec<_>, Error>>()?;
    let base = PlanarPose { position: Point::origin(), yaw: 0.0 };
    let postures = robot.postures.iter().map(|posture| {
        let poses = robot.link_poses(&Configuration { base, joints: posture.joints });
        json!({ "name": posture.name, "links": poses.iter().map(player::pose).collect::<Vec<_>>() })
    });
    Ok(json!({
        "name": robot.name,
        "about": files.about,
        "width_m": robot.width(),
        "joints": robot.joints.iter().map(joint).collect::<Vec<_>>(),
        "links": links,
        "meshes": meshes.data(),
        "postures": postures.collect::<Vec<_>>(),
    }))
}

/// Name, kind and limits of a joint, rad or m; null without a limit.
fn joint(joint: &ArmJoint) -> Value {
    let turns = joint.motion == Motion::Revolute;
    json!({ "name": joint.name, "turns": turns, "lower": joint.lower, "upper": joint.upper })
}
