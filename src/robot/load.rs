//! Loading of a robot from its robot file and the URDF that it names.

use super::arm::{self, Arm, Ends, Hold};
use super::arm_limits::GivenRates;
use super::file::{RobotFile, number};
use super::link::{Coupling, Joint, JointKind, Limits, Link};
use super::mesh::MeshFolders;
use super::texts::{Expand, KIND, RobotTexts, xacro};
use super::urdf::{Hulls, Links, Urdf};
use super::urdf_xml::is_xacro;
use super::warning::RobotWarning;
use super::wheels::Wheels;
use super::{
    MAX_LISTED, Posture, Robot, SelfContacts, collision, described, driven, footprint, plausible, posture,
};
use crate::error::{Error, Place};
use crate::geometry::{Footprint, Point, Pose};
use crate::located::Source;
use nalgebra::{Rotation3, Vector3};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use toml::Spanned;

impl Robot {
    /// Reads and validates a robot file (`.toml`) with the URDF that it names, or a URDF (`.urdf`, `.xml`)
    /// with the robot file of the same name next to it.
    ///
    /// # Errors
    /// The file, the item and the numbers.
    pub fn load(path: &Path) -> Result<Self, Error> {
        Self::check(path).map_err(|mut faults| faults.swap_remove(0))
    }

    /// As [`Robot::load`], with all faults that can be seen at once in place of the first. Postures are
    /// checked only if everything else is valid.
    ///
    /// # Errors
    /// At least one.
    pub fn check(path: &Path) -> Result<Self, Vec<Error>> {
        complete(RobotTexts::read(path, None).map_err(|fault| vec![fault])?)
    }

    /// As [`Robot::check`], with a function that expands a xacro to a URDF; without it, a xacro is refused.
    /// The program `xacro` runs code that is in the file.
    ///
    /// # Errors
    /// As [`Robot::check`], and those of `expand`.
    pub fn check_expanded(path: &Path, expand: Option<&Expand>) -> Result<Self, Vec<Error>> {
        complete(RobotTexts::read(path, expand).map_err(|fault| vec![fault])?)
    }

    /// A robot built from texts that were read before. Meshes of texts from a recording or a snapshot keep
    /// the names that the URDF gives them; their files are not searched for.
    ///
    /// # Errors
    /// As [`Robot::load`].
    pub fn parse(texts: &RobotTexts) -> Result<Self, Error> {
        // files that were there may be gone
        let found = texts.folders().and_then(|folders| build(texts, Some(folders)).ok());
        found.map_or_else(|| build(texts, None), Ok).map_err(|mut faults| faults.swap_remove(0))
    }

    /// The built-in robot "carrier": two driven wheels and an arm of seven joints.
    ///
    /// # Errors
    /// None, as long as the two files in `assets/robots` are valid, which tests check.
    pub fn built_in() -> Result<Self, Error> {
        let text = include_str!("../../assets/robots/carrier.toml").to_owned();
        let urdf = include_str!("../../assets/robots/carrier.urdf").to_owned();
        let (file, urdf_file) = ("carrier".to_owned(), "carrier.urdf".to_owned());
        Self::parse(&RobotTexts::without_meshes([file, text], [urdf_file, urdf]))
    }
}

/// The links of a URDF from which a robot file is drafted.
pub(super) fn links_to_draft(texts: &RobotTexts) -> Result<Vec<Link>, Error> {
    let Links { links, faults, .. } = texts.as_urdf(texts.folders()).links()?;
    faults.into_iter().next().map_or(Ok(links), Err)
}

/// The robot of some texts whose robot file has no postures yet.
pub(super) fn without_postures(texts: &RobotTexts) -> Result<Robot, Error> {
    assemble(texts, texts.folders()).map_err(|mut faults| faults.swap_remove(0)).map(|(robot, _)| robot)
}

/// The robot of texts that were just read, with the hulls of its meshes; or all its faults.
pub(super) fn complete(texts: RobotTexts) -> Result<Robot, Vec<Error>> {
    let (texts, warnings) = texts.with_hulls();
    let mut robot = build(&texts, texts.folders())?;
    let replaces = robot.warnings.iter().any(RobotWarning::is_about_missing_shapes);
    if texts.hulls().is_some_and(Hulls::is_empty) && warnings.is_empty() && !replaces {
        robot.texts.forget_hulls();
    }
    robot.warnings.splice(0..0, warnings.into_iter().map(RobotWarning::about_file));
    Ok(robot)
}

/// The results of checks, of which each failed one adds its faults.
#[derive(Default)]
struct Faults(Vec<Error>);

impl Faults {
    fn keep<T>(&mut self, result: Result<T, Error>) -> Option<T> {
        result.map_err(|fault| self.0.push(fault)).ok()
    }

    fn keep_all<T>(&mut self, result: Result<T, Vec<Error>>) -> Option<T> {
        result.map_err(|faults| self.0.extend(faults)).ok()
    }
}

/// The robot built from these texts, or all its faults, at least one. Meshes are searched for in `folders`,
/// if there are any.
fn build(texts: &RobotTexts, folders: Option<&MeshFolders>) -> Result<Robot, Vec<Error>> {
    let (mut robot, entries) = assemble(texts, folders)?;
    let source = Source { file: &texts.file, text: &texts.text };
    robot.postures = postures(source, &entries, &robot)?;
    Ok(robot)
}

/// As [`build`], without postures.
fn assemble(texts: &RobotTexts, folders: Option<&MeshFolders>) -> Result<(Robot, RobotFile), Vec<Error>> {
    let source = Source { file: &texts.file, text: &texts.text };
    let parsed = source.parse::<RobotFile>(KIND).map_err(|fault| vec![fault])?;
    let entries = &parsed;
    let hulls = texts.hulls();
    let urdf = texts.as_urdf(folders);
    urdf.check().map_err(|fault| vec![fault])?;
    if is_xacro(&texts.urdf) {
        return Err(vec![xacro(Path::new(urdf.file))]);
    }
    let mut faults = Faults::default();
    let checked = |spanned: &Option<Spanned<f64>>, key, most: f64, unit| {
        let expected = format!("greater than 0 and at most {most} ({unit})");
        let number = |n| number(source, key, n, |n| n > 0.0 && n <= most, &expected);
        spanned.as_ref().map(number).transpose()
    };
    let width = faults.keep(number(
        source,
        "base_width_m",
        &entries.base_width_m,
        |w| w > 0.0 && w <= 10.0,
        "greater than 0 and at most 10 (metres)",
    ));
    let asked = faults.keep(footprint::asked(source, &entries.base_footprint));
    let grasp_height = faults.keep(number(
        source,
        "grasp_height_m",
        &entries.grasp_height_m,
        |h| (0.0..=3.0).contains(&h),
        "from 0 to 3 (metres)",
    ));
    let radius = faults.keep(checked(&entries.wheel_radius_m, "wheel_radius_m", 1.0, "metres"));
    let track = faults.keep(checked(&entries.wheel_separation_m, "wheel_separation_m", 10.0, "metres"));
    let rate =
        faults.keep(checked(&entries.wheel_rate_limit_rad_s, "wheel_rate_limit_rad_s", 1000.0, "rad/s"));
    let turning =
        faults.keep(checked(&entries.arm_rate_limit_rad_s, "arm_rate_limit_rad_s", 1000.0, "rad/s"));
    let sliding = faults.keep(checked(&entries.arm_rate_limit_m_s, "arm_rate_limit_m_s", 1000.0, "m/s"));
    let tool = faults.keep(tool(source, entries));
    let Links { mut links, faults: of_links, joint_faults, mut warnings, lines } = match urdf.links() {
        Ok(read) => read,
        Err(fault) => {
            faults.0.push(fault);
            return Err(faults.0);
        }
    };
    let urdf = Urdf { lines: Some(&lines), ..urdf };
    let is_sound = of_links.is_empty();
    faults.0.extend(of_links);
    let base = faults.keep(link(source, &links, "base_link", &entries.base_link));
    let described = faults.keep_all(described::base(source, entries));
    if let (Some(base), Some(Some(described))) = (base, &described) {
        links.push(described.link(&links, base));
    }
    let grasp = faults.keep(link(source, &links, "grasp_frame", &entries.grasp_frame));
    let named = faults.keep_all(driven::named(source, urdf, &links, entries));
    // what follows from a broken link or a wrong name would say nothing
    let (Some(base), Some(grasp), Some(named), true) = (base, grasp, named, is_sound) else {
        return Err(faults.0);
    };
    let wheel_links = named.links();
    let (used, unused) = split_by_use(&links, joint_faults, [base, grasp], &wheel_links);
    faults.0.extend(used);
    warnings.extend(unused);
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
    let held = faults.keep_all(arm::held(urdf, &links, &wheel_links, &holds));
    let held = held.unwrap_or_default();
    let joint_of = |&link: &usize| links[link].joint.as_ref().map_or("", |j| j.name.as_str());
    let width = width.unwrap_or(1.0);
    let wheels = Wheels {
        base,
        grasp,
        named,
        radius: radius.flatten(),
        track: track.flatten(),
        rate: rate.flatten(),
        base_radius: width / 2.0,
        held: held.iter().map(|(link, position)| (joint_of(link), *position)).collect(),
    };
    let measured = faults.keep_all(wheels.measure(urdf, &links));
    let drive_from_base = measured.as_ref().map_or(Pose::identity(), |measured| measured.drive_from_base);
    let grasp = match tool.flatten() {
        None => grasp,
        Some(pose) => {
            links.push(tool_link(&links, grasp, pose));
            links.len() - 1
        }
    };
    let place = source.place(&entries.grasp_frame, format!("link `{}`", entries.grasp_frame.get_ref()));
    let rates = GivenRates { turning: turning.flatten(), sliding: sliding.flatten() };
    let ends = Ends { base, grasp, drive_from_base, place, rates };
    let arm = faults.keep(Arm::new(urdf, &mut links, &ends, &held));
    let (Some(measured), Some(arm), Some(grasp_height)) = (measured, arm, grasp_height) else {
        return Err(faults.0);
    };
    let Arm { joints, chain, last_from_grasp, warnings: of_arm } = arm;
    warnings.extend(measured.warnings);
    warnings.extend(of_arm);
    let center = Point::origin();
    let mut robot = Robot {
        name: entries.name.clone(),
        texts: texts.clone(),
        drive: measured.drive,
        footprint: Footprint::Disc { center, radius: measured.drive.base_radius },
        base_width: width,
        joints,
        grasp_height,
        postures: Vec::new(),
        links,
        base_link: base,
        grasp_link: grasp,
        wheels: measured.wheels,
        warnings: Vec::new(),
        drive_from_base,
        chain,
        last_from_grasp,
        self_contacts: SelfContacts::default(),
    };
    let (of_inertias, about_inertias) = collision::check_inertias(urdf, &robot);
    faults.0.extend(of_inertias);
    warnings.extend(about_inertias);
    warnings.extend(plausible::warnings(&robot));
    if let Some(asked) = asked {
        let has_shapes = collision::has_shapes(&robot);
        if hulls.is_some() {
            warnings.extend(collision::complete(&mut robot, asked.corners()));
        }
        faults.keep(footprint::set(&mut robot, asked, has_shapes));
    }
    robot.warnings = warnings;
    if !faults.0.is_empty() {
        return Err(faults.0);
    }
    robot.self_contacts = SelfContacts::new(&robot);
    Ok((robot, parsed))
}

/// The faults of joints that the robot uses, on the way from the base to the grasp and to the wheels; and a
/// warning for each of the others, which refuse nothing.
fn split_by_use(
    links: &[Link],
    faults: BTreeMap<usize, Error>,
    [base, grasp]: [usize; 2],
    wheels: &[usize],
) -> (Vec<Error>, Vec<RobotWarning>) {
    let up = |end: usize| std::iter::successors(Some(end), |&at| links[at].parent);
    let way = |end: usize| up(end).take_while(|&at| at != base);
    let used: BTreeSet<usize> = wheels.iter().chain([&grasp]).flat_map(|&end| way(end)).collect();
    let (mut of_used, mut of_others) = (Vec::new(), Vec::new());
    for (link, fault) in faults {
        match used.contains(&link) {
            true => of_used.push(fault),
            false => of_others.push(RobotWarning::new(format!("{fault}; nothing uses it"))),
        }
    }
    (of_used, of_others)
}

/// `tool_from_grasp`, if the robot file gives any of it.
fn tool(source: Source, entries: &RobotFile) -> Result<Option<Pose>, Error> {
    let vector = |key: &str, spanned: &Option<Spanned<[f64; 3]>>, most: f64, unit: &str| {
        let Some(spanned) = spanned else { return Ok(Vector3::zeros()) };
        for (axis, value) in ["[0]", "[1]", "[2]"].iter().zip(spanned.get_ref()) {
            if value.abs() > most || value.is_nan() {
                let (place, key) = (source.place(spanned, "robot"), format!("{key}{axis}"));
                let expected = format!("from -{most} to {most} ({unit})");
                return Err(Error::number(place, &key, *value, &expected));
            }
        }
        Ok(Vector3::from(*spanned.get_ref()))
    };
    let xyz = vector("grasp_xyz_m", &entries.grasp_xyz_m, 2.0, "metres")?;
    let rpy = vector("grasp_rpy_deg", &entries.grasp_rpy_deg, 360.0, "degrees")?.map(f64::to_radians);
    let is_given = entries.grasp_xyz_m.is_some() || entries.grasp_rpy_deg.is_some();
    let turn = Rotation3::from_euler_angles(rpy.x, rpy.y, rpy.z);
    Ok(is_given.then(|| Pose::from_parts(xyz.into(), turn)))
}

/// A frame fixed to the link of the tool.
fn tool_link(links: &[Link], tool: usize, tool_from_grasp: Pose) -> Link {
    fixed_link(links, tool, "grasp", tool_from_grasp)
}

/// A link without shapes that is fixed to another, with a unique name that ends in `what`.
pub(super) fn fixed_link(links: &[Link], parent: usize, what: &str, parent_from_link: Pose) -> Link {
    let mut name = format!("{}_{what}", links[parent].name);
    let is_taken = |name: &str| {
        links
            .iter()
            .any(|l| l.name == name || l.joint.as_ref().is_some_and(|j| j.name == format!("{name}_joint")))
    };
    while is_taken(&name) {
        name.push('_');
    }
    let joint = Joint {
        name: format!("{name}_joint"),
        kind: JointKind::Fixed,
        parent_from_joint: parent_from_link,
        axis: Vector3::x_axis(),
        limits: Limits { lower: 0.0, upper: 0.0, rate: 0.0, effort: f64::INFINITY },
        mimic: None,
        coupling: Coupling { joint: None, ratio: 1.0, offset: 0.0 },
    };
    let (visuals, collisions) = (Vec::new(), Vec::new());
    Link { name, parent: Some(parent), joint: Some(joint), inertial: None, visuals, collisions }
}

/// All postures, or the faults of all.
fn postures(source: Source, entries: &RobotFile, robot: &Robot) -> Result<Vec<Posture>, Vec<Error>> {
    if entries.postures.is_empty() {
        let place = Place::item(source.file, "robot");
        return Err(vec![Error::missing(place, "a [[posture]] to start from")]);
    }
    let mut names = BTreeSet::new();
    let (mut found, mut faults) = (Vec::new(), Faults::default());
    for spanned in &entries.postures {
        let name = &spanned.get_ref().name;
        if names.insert(name) {
            found.extend(faults.keep(posture::read(source, spanned, robot)));
        } else {
            let place = source.place(spanned, format!("posture `{name}`"));
            faults.0.push(Error::duplicate(place, "posture"));
        }
    }
    if faults.0.is_empty() { Ok(found) } else { Err(faults.0) }
}

/// The link of this name.
fn link(source: Source, links: &[Link], key: &str, name: &Spanned<String>) -> Result<usize, Error> {
    links.iter().position(|l| l.name == *name.get_ref()).ok_or_else(|| {
        let known = links.iter().map(|l| l.name.as_str());
        Error::unknown(source.place(name, key), "link", name.get_ref(), known, MAX_LISTED)
    })
}
