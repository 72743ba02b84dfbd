//! `cocarry robot check`: all faults of a robot's files, or what the program makes of them.

use super::file_kind::{self, FileKind};
use super::output::{
    Failure, OverwriteArguments, examples, html_file, input, print, print_error, print_json, table,
    table_text, write_file,
};
use super::robot::check_is_file;
use super::xacro::XacroArguments;
use anyhow::{Error, anyhow};
use clap::Args;
use cocarry::episode::EpisodeSettings;
use cocarry::error::Place;
use cocarry::geometry::{Footprint, Pose};
use cocarry::robot::{Drive, DriveKind, Motion, PlanarSpeeds, Posture, Robot, WeakestJoint};
use cocarry::team;
use cocarry::world::CarriedObject;
use cocarry_recording::rendering;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Show all faults of a robot's files; or its drive, masses, joints, reach, and the shapes that are missing
///
/// Every fault that can be seen at once is listed, and the exit code is 2. Postures are checked when
/// everything else is valid.
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry robot check robot.toml", ""),
    ("cocarry robot check robot.toml --json", "the same for programs"),
    ("cocarry robot check robot.toml --render robot.html", "its postures and shapes in a 3-D page, without a network"),
    ("cocarry run --robot robot.toml --render run.html", "to see the robot, carrying"),
]))]
pub(super) struct CheckArguments {
    /// Robot file (TOML), or a URDF with a robot file of the same name next to it
    robot: PathBuf,
    /// Print one JSON object instead of text
    #[arg(long)]
    json: bool,
    /// Write a page (.html) that shows the robot in its postures, as drawn and as it collides
    #[arg(long, value_name = "FILE", value_parser = html_file)]
    render: Option<PathBuf>,
    #[command(flatten)]
    xacro: XacroArguments,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

pub(super) fn run_robot_check(arguments: &CheckArguments) -> Result<ExitCode, Failure> {
    check_is_file("robot check", &arguments.robot)?;
    let file = file_kind::within(&arguments.robot, FileKind::Robot);
    let outputs = arguments.overwrite.outputs([file.as_path()], &arguments.render)?;
    let robot = match Robot::check_expanded(&file, arguments.xacro.expand()) {
        Ok(robot) => robot,
        Err(faults) => {
            let other = file_kind::other_kind(&file, FileKind::Robot);
            let other =
                other.map(|advice| cocarry::Error::at(Place::file(file.display().to_string()), advice));
            return refused(arguments, other.map_or(faults, |other| vec![other]));
        }
    };
    if let Some(file) = &arguments.render {
        // the robot file and the URDF are inputs by whichever name
        let inputs = [&robot.texts.file, &robot.texts.urdf_file].map(Path::new);
        arguments.overwrite.outputs(inputs, [file])?;
        let page = rendering::robot_page(&robot, &drive_text(&robot.drive), &remarks(&robot));
        write_file(&outputs, file, page.map_err(input)?)?;
    }
    match arguments.json {
        true => print_json(&as_json(&robot))?,
        false => print(&as_text(&robot))?,
    }
    if let Some(file) = arguments.render.as_ref().filter(|_| !arguments.json) {
        print(&format!("\nwrote {}\n", file.display()))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Prints all faults.
fn refused(arguments: &CheckArguments, faults: Vec<cocarry::Error>) -> Result<ExitCode, Failure> {
    let count = faults.len();
    let faults: Vec<String> = faults.into_iter().map(|fault| format!("{:#}", Error::from(fault))).collect();
    if arguments.json {
        print_json(
            &json!({ "file": arguments.robot.display().to_string(), "valid": false, "faults": faults }),
        )?;
    } else if count > 1 {
        faults[..count - 1].iter().for_each(print_error);
    }
    // the last one as any command ends
    let last = faults.last().cloned().expect("a robot that is refused has a fault");
    let last = if count > 1 && !arguments.json { format!("{last}\n{count} faults") } else { last };
    Err(input(anyhow!(last)))
}

/// Mass of the links below the base that move, and of all, kg.
fn masses(robot: &Robot) -> [f64; 2] {
    let mut of_arm = vec![false; robot.links.len()];
    for (i, link) in robot.links.iter().enumerate() {
        let moves = link.joint.as_ref().is_some_and(|joint| joint.coupling.joint.is_some());
        of_arm[i] = moves || link.parent.is_some_and(|parent| of_arm[parent]);
    }
    let mass = |is_counted: &dyn Fn(usize) -> bool| -> f64 {
        let counted = robot.links.iter().enumerate().filter(|(i, _)| is_counted(*i));
        counted.filter_map(|(_, link)| link.inertial).map(|inertial| inertial.mass).sum()
    };
    [mass(&|i| of_arm[i]), mass(&|_| true)]
}

/// A posture with where its grasp is and the room that it leaves.
struct PostureRow<'a> {
    posture: &'a Posture,
    ahead: f64,
    lateral_offset: f64,
    nearest: f64,
    farthest: f64,
    /// The joint nearest to a limit, and its share of room.
    tightest: Option<(&'a str, f64)>,
    dexterity: f64,
    /// The joint that limits the load at rest.
    weakest: Option<WeakestJoint<'a>>,
    speeds: PlanarSpeeds,
}

fn rows(robot: &Robot) -> Vec<PostureRow<'_>> {
    let row = |posture| {
        let Posture { joints, .. }: &Posture = posture;
        let (at, reach) = (robot.drive_from_grasp(joints).translation.vector, robot.reach(joints));
        let tightest = robot.limit_clearance(joints).map(|(i, share)| (robot.joints[i].name.as_str(), share));
        PostureRow {
            posture,
            ahead: at.x,
            lateral_offset: at.y,
            nearest: reach.nearest,
            farthest: reach.farthest,
            tightest,
            dexterity: robot.dexterity(joints),
            weakest: robot.weakest_joint(joints),
            speeds: robot.planar_speeds(joints),
        }
    };
    robot.postures.iter().map(row).collect()
}

/// The largest distance from the base's axis (m) at which a grasp is said to be on it.
const ON_AXIS_M: f64 = 0.01;

/// Remarks for the user, besides the warnings about the files.
fn remarks(robot: &Robot) -> Vec<String> {
    let mut remarks: Vec<String> = robot.warnings.iter().map(ToString::to_string).collect();
    let width = robot.width();
    match &robot.footprint {
        Footprint::Disc { .. } => {
            if let Some(extent) = robot.base_extent().filter(|extent| 2.0 * extent > width + 0.005) {
                remarks.push(format!(
                    "base_width_m = {width}, but a disc about the axle around the base's collision shapes is {:.2} m wide",
                    2.0 * extent
                ));
            }
        }
        Footprint::Polygon(_) => {
            let across = robot.footprint_across();
            if across > width + 0.005 {
                remarks.push(format!(
                    "base_width_m = {width}, but base_footprint is {across:.2} m wide about the middle of the drive: it may not fit through openings"
                ));
            }
        }
    }
    for row in rows(robot).iter().filter(|row| row.lateral_offset.abs() > ON_AXIS_M) {
        let needed = robot.carrying_width(&row.posture.joints);
        let needs = match needed > width {
            true => format!(", and needs openings of {needed:.2} m"),
            false => String::new(),
        };
        remarks.push(format!(
            "posture `{}` holds the grasp {:.2} m to the side of the base's axis; the base keeps that offset{needs}",
            row.posture.name,
            row.lateral_offset.abs()
        ));
    }
    let half = CarriedObject::default().mass / 2.0;
    for row in rows(robot) {
        let Some(joint) = row.weakest.filter(|joint| joint.payload < half) else { continue };
        remarks.push(format!(
            "posture `{}` holds {:.2} kg at the grasp, where joint `{}` is at its effort limit of {:.1} {}: half of an object of \
             {:.2} kg, less than a world's usual one of {:.1} kg ([object] mass_kg)",
            row.posture.name,
            joint.payload,
            joint.name,
            joint.limit,
            joint.unit,
            2.0 * joint.payload,
            2.0 * half
        ));
    }
    let speed = EpisodeSettings::default().speed;
    let slow =
        robot.postures.iter().filter_map(|posture| team::slow_drive(robot, &posture.joints, speed, true));
    let mut slow: Vec<String> = slow.map(|slow| slow.to_string()).collect();
    slow.dedup();
    remarks.extend(slow);
    for posture in &robot.postures {
        let missing = robot.missing_motions(&posture.joints);
        if !missing.is_empty() {
            remarks.push(format!(
                "posture `{}` holds the grasp where the arm alone cannot {}; the base has to help",
                posture.name,
                missing.join(", ")
            ));
        }
    }
    remarks
}

fn drive_text(drive: &Drive) -> String {
    let Drive { kind, track, wheel_radius, rim_speed_limit: speed, turn_rate_limit: turn, .. } = drive;
    match kind {
        DriveKind::Differential => format!(
            "differential: wheels of {wheel_radius:.4} m radius, {track:.4} m apart, up to {speed:.2} m/s"
        ),
        DriveKind::SkidSteer => format!(
            "skid-steer: wheels of {wheel_radius:.4} m radius, turning as if {track:.4} m apart, up to {speed:.2} m/s"
        ),
        DriveKind::Omnidirectional => {
            format!("omnidirectional: up to {speed:.2} m/s along x and y, and {turn:.2} rad/s")
        }
    }
}

fn as_text(robot: &Robot) -> String {
    let drive = &robot.drive;
    let [arm, all] = masses(robot);
    let mut text = format!("{} ({}, {})\n\n", robot.name, robot.texts.file, robot.texts.urdf_file);
    text += &format!("drive  {}\n", drive_text(drive));
    let outline = match &robot.footprint {
        Footprint::Disc { .. } => String::new(),
        Footprint::Polygon(corners) => {
            let length = robot.footprint.bounds().size().x;
            format!(" and {length:.2} m long, a polygon of {} corners", corners.len())
        }
    };
    text += &format!("base   {:.2} m wide{outline} for clearances, {:.1} kg\n", robot.width(), all - arm);
    text +=
        &format!("arm    {} joints, {arm:.1} kg; holds at {} m\n\n", robot.joint_count(), robot.grasp_height);
    let mut joints = table(["joint", "from", "to", "rate", "effort"], 1);
    for joint in &robot.joints {
        let is_turn = joint.motion == Motion::Revolute;
        let (scale, unit) = if is_turn { (1f64.to_degrees(), "deg") } else { (1.0, "m") };
        let at = |limit: f64| match limit.is_finite() {
            true if is_turn => format!("{:.0} {unit}", limit * scale),
            true => format!("{limit:.2} {unit}"),
            false => "free".to_owned(),
        };
        let effort = match joint.effort_limit.is_finite() {
            true => format!("{:.1} {}", joint.effort_limit, joint.motion.effort_unit()),
            false => "none given".to_owned(),
        };
        let rate = match is_turn {
            true => format!("{:.0} deg/s", joint.rate_limit * scale),
            false => format!("{:.3} m/s", joint.rate_limit),
        };
        joints.add_row([joint.name.clone(), at(joint.lower), at(joint.upper), rate, effort]);
    }
    text += &table_text(&joints);
    let mut postures = table(["posture", "ahead (m)", "reaches (m)", "room", "dexterity", "holds (kg)"], 1);
    let rows = rows(robot);
    for row in &rows {
        postures.add_row([
            row.posture.name.clone(),
            format!("{:.2}", row.ahead),
            format!("{:.2} to {:.2}", row.nearest, row.farthest),
            row.tightest.map_or("-".to_owned(), |(_, share)| format!("{:.0} %", 100.0 * share)),
            format!("{:.3}", row.dexterity),
            row.weakest.map_or("-".to_owned(), |joint| format!("{:.2}", joint.payload)),
        ]);
    }
    text += &format!("\n{}", table_text(&postures));
    text += "reaches: straight ahead at its height, from the axle; room: of the joint nearest to a limit, 100 % being\n\
             the middle of its range; dexterity: least singular value of the arm's Jacobian, 0 where it is stuck;\n\
             holds: the load at the grasp that takes a motor to its effort limit at rest, half of an object's mass\n";
    let remarks = remarks(robot);
    if !remarks.is_empty() {
        text += "\nNotes\n";
        text += &remarks.iter().map(|remark| format!("- {remark}\n")).collect::<String>();
    }
    text
}

/// The rows of a homogeneous transform.
fn transform(pose: &Pose) -> Value {
    let matrix = pose.to_homogeneous();
    matrix.row_iter().map(|row| row.iter().copied().collect::<Vec<f64>>()).collect()
}

/// Positions of the joints by name, rad or m.
fn joints_of(robot: &Robot, posture: &Posture) -> Value {
    let named = robot.joints.iter().zip(posture.joints.iter());
    named.map(|(joint, &at)| (joint.name.clone(), json!(at))).collect()
}

fn as_json(robot: &Robot) -> Value {
    let drive = &robot.drive;
    let footprint = match &robot.footprint {
        Footprint::Disc { .. } => None,
        Footprint::Polygon(corners) => Some(corners.iter().map(|c| [c.x, c.y]).collect::<Vec<_>>()),
    };
    let [arm, all] = masses(robot);
    let limit = |value: f64| if value.is_finite() { json!(value) } else { Value::Null };
    let joints: Vec<Value> = robot
        .joints
        .iter()
        .map(|joint| {
            json!({
                "name": joint.name,
                "motion": if joint.motion == Motion::Revolute { "revolute" } else { "prismatic" },
                "lower": limit(joint.lower),
                "upper": limit(joint.upper),
                "rate_limit": joint.rate_limit,
                "effort_limit": limit(joint.effort_limit),
            })
        })
        .collect();
    let postures: Vec<Value> = rows(robot)
        .iter()
        .map(|row| {
            json!({
                "name": row.posture.name,
                "joints": joints_of(robot, row.posture),
                "drive_from_grasp": transform(&robot.drive_from_grasp(&row.posture.joints)),
                "ahead_m": row.ahead,
                "lateral_offset_m": row.lateral_offset,
                "nearest_m": row.nearest,
                "farthest_m": row.farthest,
                "tightest_joint": row.tightest.map(|(name, _)| name),
                "room": row.tightest.map(|(_, share)| share),
                "dexterity": row.dexterity,
                "holds_kg": row.weakest.map(|joint| joint.payload),
                "weakest_joint": row.weakest.map(|joint| joint.name),
                "speeds": {
                    "ahead_m_s": row.speeds.ahead,
                    "sideways_m_s": row.speeds.sideways,
                    "turning_rad_s": row.speeds.turning,
                },
                "needed_width_m": robot.carrying_width(&row.posture.joints),
                "missing_motions": robot.missing_motions(&row.posture.joints),
            })
        })
        .collect();
    json!({
        "file": robot.texts.file,
        "urdf": robot.texts.urdf_file,
        "valid": true,
        "name": robot.name,
        "drive": {
            "kind": drive.kind.name(),
            "wheel_radius_m": Some(drive.wheel_radius).filter(|radius| *radius > 0.0),
            "wheel_separation_m": Some(drive.track).filter(|track| *track > 0.0),
            "speed_limit_m_s": drive.rim_speed_limit,
            "turn_limit_rad_s": drive.turn_rate_limit,
            "wheels": robot.wheels.iter().map(|wheel| json!({
                "joint": robot.links[wheel.link].joint.as_ref().map(|joint| joint.name.as_str()),
                "spin": wheel.spin.as_slice(),
            })).collect::<Vec<_>>(),
        },
        "base": {
            "link": robot.links[robot.base_link].name,
            "drive_from_base": transform(&robot.drive_from_base()),
            "width_m": robot.width(),
            "footprint_m": footprint,
            "extent_m": robot.base_extent(),
            "mass_kg": all - arm,
        },
        "arm_mass_kg": arm,
        "grasp_height_m": robot.grasp_height,
        "grasp_frame": robot.links[robot.grasp_link].name,
        "joints": joints,
        "postures": postures,
        "notes": remarks(robot),
    })
}
