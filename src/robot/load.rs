//! Loading of a robot from its robot file and the URDF that it names.

use super::arm::{Arm, Ends, Hold};
use super::error::{RobotError, known};
use super::file::{RobotFile, number};
use super::link::Link;
use super::urdf::Urdf;
use super::wheels::Wheels;
use super::{Posture, Robot, posture};
use crate::located::{self, LARGEST_SETTINGS, Place, Source};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// What a robot file is, in errors.
const KIND: &str = "robot file";

/// The source texts of a robot, from which it can be built again without the files.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotTexts {
    /// The robot file, as the caller named it.
    pub file: String,
    /// Text of the robot file.
    pub text: String,
    /// The URDF that the robot file names.
    pub urdf_file: String,
    /// Text of the URDF.
    pub urdf: String,
    /// The folder from which meshes are searched for.
    #[serde(skip)]
    meshes: MeshFolder,
}

/// The folder of a URDF, where its meshes are at hand. It is no part of what a robot is: recordings and
/// snapshots do not have it.
#[derive(Clone, Debug, Default)]
struct MeshFolder(Option<PathBuf>);

impl PartialEq for MeshFolder {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Eq for MeshFolder {}

impl RobotTexts {
    /// Reads a robot file (`.toml`) and the URDF that it names, or a URDF (`.urdf`, `.xml`) and the robot
    /// file of the same name beside it.
    fn read(path: &Path) -> Result<Self, RobotError> {
        let file = path.display().to_string();
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_lowercase();
        let robot_file = match extension.as_str() {
            "toml" => path.to_owned(),
            "urdf" | "xml" => path.with_extension("toml"),
            "xacro" => return Err(xacro(path)),
            _ => return Err(RobotError::Format { file }),
        };
        let asked = (extension != "toml").then_some(path);
        if let Some(urdf) = asked
            && urdf.exists()
            && !robot_file.exists()
        {
            return Err(RobotError::NoRobotFile { urdf: file, needed: robot_file.display().to_string() });
        }
        let (name, text) =
            (robot_file.display().to_string(), located::read_at_most(LARGEST_SETTINGS, &robot_file)?);
        let source = Source { file: &name, text: &text };
        let entries: RobotFile = source.parse(KIND)?;
        let folder = robot_file.parent().unwrap_or(Path::new(""));
        let urdf = folder.join(entries.urdf.get_ref());
        if let Some(asked) = asked.filter(|&asked| !is_same(asked, &urdf)) {
            return Err(RobotError::OtherUrdf {
                place: source.place(&entries.urdf, "urdf"),
                found: entries.urdf.get_ref().clone(),
                asked: asked.display().to_string(),
            });
        }
        if urdf.extension().is_some_and(|e| e.eq_ignore_ascii_case("xacro")) {
            return Err(xacro(&urdf));
        }
        let urdf_text = located::read(&urdf)?;
        let meshes = MeshFolder(Some(urdf.parent().unwrap_or(Path::new("")).to_owned()));
        Ok(Self { file: name, text, urdf_file: urdf.display().to_string(), urdf: urdf_text, meshes })
    }
}

impl Robot {
    /// Reads and validates a robot file (`.toml`) with the URDF that it names, or a URDF (`.urdf`, `.xml`)
    /// with the robot file of the same name beside it.
    ///
    /// # Errors
    /// [`RobotError`], which names the file, the item and the numbers.
    pub fn load(path: &Path) -> Result<Self, RobotError> {
        let texts = RobotTexts::read(path)?;
        build(&texts, texts.meshes.0.as_deref())
    }

    /// A robot built from texts that were read before. Meshes of texts from a recording or a snapshot keep the
    /// names that the URDF gives them; their files are not searched for.
    ///
    /// # Errors
    /// As [`Robot::load`].
    pub fn parse(texts: &RobotTexts) -> Result<Self, RobotError> {
        // files that were there may be gone
        let found = texts.meshes.0.as_deref().and_then(|folder| build(texts, Some(folder)).ok());
        found.map_or_else(|| build(texts, None), Ok)
    }

    /// The built-in robot "carrier": two driven wheels and an arm of seven joints.
    ///
    /// # Errors
    /// None, as long as the two files in `assets/robots` are valid, which tests check.
    pub fn built_in() -> Result<Self, RobotError> {
        let text = include_str!("../../assets/robots/carrier.toml").to_owned();
        let urdf = include_str!("../../assets/robots/carrier.urdf").to_owned();
        let (file, urdf_file) = ("carrier".to_owned(), "carrier.urdf".to_owned());
        Self::parse(&RobotTexts { file, text, urdf_file, urdf, meshes: MeshFolder::default() })
    }
}

fn xacro(path: &Path) -> RobotError {
    let stem = path.with_extension("");
    let has_urdf = stem.extension().is_some_and(|e| e == "urdf");
    let expanded = if has_urdf { stem } else { stem.with_extension("urdf") };
    let expanded = if expanded == path { path.with_extension("expanded.urdf") } else { expanded };
    RobotError::Xacro { file: path.display().to_string(), expanded: expanded.display().to_string() }
}

fn is_same(a: &Path, b: &Path) -> bool {
    let same = |a: &Path, b: &Path| Some(a.canonicalize().ok()? == b.canonicalize().ok()?);
    a == b || same(a, b).unwrap_or(false)
}

/// The robot built from these texts. Meshes are searched for from `folder`, if there is one.
fn build(texts: &RobotTexts, folder: Option<&Path>) -> Result<Robot, RobotError> {
    let source = Source { file: &texts.file, text: &texts.text };
    let entries = &source.parse::<RobotFile>(KIND)?;
    let (urdf, text) = (Urdf { file: &texts.urdf_file, folder }, texts.urdf.as_str());
    // older versions of xacro leave the bare namespace in what they expand, so it is no sign of a xacro file
    // and it keeps the comments
    let mut outside = text.split("<!--").map(|part| part.split_once("-->").map_or(part, |(_, rest)| rest));
    if outside.any(|part| part.contains("<xacro:") || part.contains("${")) {
        return Err(xacro(Path::new(urdf.file)));
    }
    let width = number(
        source,
        "base_width_m",
        &entries.base_width_m,
        |w| w > 0.0 && w <= 10.0,
        "greater than 0 and at most 10 (metres)",
    )?;
    let grasp_height = number(
        source,
        "grasp_height_m",
        &entries.grasp_height_m,
        |h| (0.0..=3.0).contains(&h),
        "from 0 to 3 (metres)",
    )?;
    let radius = entries.wheel_radius_m.as_ref().map(|r| {
        number(source, "wheel_radius_m", r, |r| r > 0.0 && r <= 1.0, "greater than 0 and at most 1 (metres)")
    });
    let mut links = urdf.links(text)?;
    let base = link(source, &links, "base_link", &entries.base_link)?;
    let grasp = link(source, &links, "grasp_frame", &entries.grasp_frame)?;
    let wheel_links = [
        carried_by(source, &links, "left_wheel", &entries.left_wheel)?,
        carried_by(source, &links, "right_wheel", &entries.right_wheel)?,
    ];
    let wheels =
        Wheels { base, grasp, links: wheel_links, radius: radius.transpose()?, base_radius: width / 2.0 };
    let (drive, drive_from_base) = wheels.measure(urdf, &links)?;
    let place = source.place(&entries.grasp_frame, format!("link `{}`", entries.grasp_frame.get_ref()));
    let holds: Vec<Hold> = entries
        .hold
        .iter()
        .map(|(joint, spanned)| Hold {
            joint,
            angle_deg: spanned.get_ref().angle_deg,
            position_m: spanned.get_ref().position_m,
            place: source.place(spanned, format!("hold `{joint}`")),
        })
        .collect();
    let ends = Ends { base, grasp, drive_from_base, place };
    let Arm { joints, chain, last_from_grasp } = Arm::new(urdf, &mut links, &ends, &holds)?;
    let mut robot = Robot {
        name: entries.name.clone(),
        texts: texts.clone(),
        drive,
        joints,
        grasp_height,
        postures: Vec::new(),
        links,
        base_link: base,
        grasp_link: grasp,
        wheel_links,
        drive_from_base,
        chain,
        last_from_grasp,
    };
    robot.postures = postures(source, entries, &robot)?;
    Ok(robot)
}

fn postures(source: Source, entries: &RobotFile, robot: &Robot) -> Result<Vec<Posture>, RobotError> {
    if entries.postures.is_empty() {
        let place = Place { file: source.file.to_owned(), line: None, item: "robot".to_owned() };
        return Err(RobotError::Missing { place, needed: "a [[posture]] to start from".to_owned() });
    }
    let mut names = BTreeSet::new();
    let read = |spanned: &Spanned<_>| posture::read(source, spanned, robot);
    entries
        .postures
        .iter()
        .map(|spanned| {
            let name = &spanned.get_ref().name;
            if !names.insert(name) {
                let place = source.place(spanned, format!("posture `{name}`"));
                return Err(RobotError::Duplicate { place, kind: "posture" });
            }
            read(spanned)
        })
        .collect()
}

/// The link of this name.
fn link(source: Source, links: &[Link], key: &str, name: &Spanned<String>) -> Result<usize, RobotError> {
    links.iter().position(|l| l.name == *name.get_ref()).ok_or_else(|| RobotError::Unknown {
        place: source.place(name, key),
        kind: "link",
        name: name.get_ref().clone(),
        known: known(links.iter().map(|l| l.name.as_str())),
    })
}

/// The child link of the joint of this name.
fn carried_by(
    source: Source,
    links: &[Link],
    key: &str,
    name: &Spanned<String>,
) -> Result<usize, RobotError> {
    let joint_name = |l: &Link| l.joint.as_ref().map(|j| j.name.clone());
    links.iter().position(|l| joint_name(l).as_ref() == Some(name.get_ref())).ok_or_else(|| {
        let names: Vec<String> = links.iter().filter_map(joint_name).collect();
        RobotError::Unknown {
            place: source.place(name, key),
            kind: "joint",
            name: name.get_ref().clone(),
            known: known(names.iter().map(String::as_str)),
        }
    })
}
