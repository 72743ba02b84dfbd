//! A robot file drafted from a URDF: the base, its wheels, the arm, the grasp and postures, each found or
//! assumed.

use super::draft_request::DraftRequest;
use super::draft_search::{self, Parts};
use super::footprint;
use super::level::FULL;
use super::load;
use super::postures::{self, Found};
use super::texts::{Expand, RobotTexts};
use super::warning::WarningKind;
use super::{Motion, Robot};
use crate::error::{Error, Place};
use crate::geometry::{Footprint, Point};
use crate::math;
use nalgebra::{Rotation3, Vector3};
use std::path::Path;

/// A drafted robot file.
#[derive(Clone, Debug)]
pub struct Draft {
    /// The text of the robot file.
    pub text: String,
    /// The assumptions, a sentence each.
    pub assumed: Vec<String>,
    /// The robot of the file.
    pub robot: Robot,
}

/// Heights tried in this order, m.
const HEIGHTS_M: [f64; 7] = [0.7, 0.8, 0.9, 0.6, 1.0, 1.1, 0.5];

/// A base is drafted with its own outline if a disc is more than this many times as wide.
const NARROWER: f64 = 1.1;
/// Radius of the balls around an arm's joints that eq. (7) keeps off obstacles, m.
const ARM_RADIUS_M: f64 = 0.08;
/// How far an arm's shapes may be outside these balls for a base that is narrower than its disc, m. In an
/// opening as narrow as the base, such an arm would touch the walls.
const MAX_OUTSIDE_M: f64 = 0.05;

/// Room of a posture, as [`Found`] has it, with which no other height is tried.
const ENOUGH_ROOM: f64 = 0.2;

impl Draft {
    /// A robot file for a URDF. `named` is how the file names the URDF, and `file` is its own name in errors.
    /// The same URDF gives the same text.
    ///
    /// # Errors
    /// The URDF is not valid, or a part of the robot is not found in it.
    pub fn new(urdf: &Path, named: &str, file: &str, request: &DraftRequest) -> Result<Self, Error> {
        Self::of_texts(RobotTexts::of_urdf(urdf, None)?, urdf, named, file, request)
    }

    /// As [`Draft::new`], with a function that expands a xacro to a URDF.
    ///
    /// # Errors
    /// As [`Draft::new`], and those of `expand`.
    pub fn expanded(
        urdf: &Path,
        named: &str,
        file: &str,
        request: &DraftRequest,
        expand: &Expand,
    ) -> Result<Self, Error> {
        Self::of_texts(RobotTexts::of_urdf(urdf, Some(expand))?, urdf, named, file, request)
    }

    fn of_texts(
        mut texts: RobotTexts,
        urdf: &Path,
        named: &str,
        file: &str,
        request: &DraftRequest,
    ) -> Result<Self, Error> {
        texts.file = file.to_owned();
        let urdf_file = texts.urdf_file.clone();
        let links = load::links_to_draft(&texts)?;
        let parts = draft_search::find(&urdf_file, &links, request)?;
        let mut assumed = parts.assumed.clone();
        let name = urdf.file_stem().map_or("robot".to_owned(), |s| s.to_string_lossy().into_owned());
        let name = name.trim_end_matches(".urdf").to_owned();
        let toml = |text: &str| toml::Value::String(text.to_owned()).to_string();
        let heights: Vec<f64> = request.grasp_height.map_or(HEIGHTS_M.to_vec(), |h| vec![h]);
        let head = |base_size: &BaseSize, height: f64, rpy: Vector3<f64>| {
            let Parts { base, tool, drive, radius, rate, .. } = &parts;
            let mut text = format!(
                "# Drafted by `cocarry robot init`. Check it with `cocarry robot check`.\nname = {}\nurdf = {}\nbase_link = {}\n",
                toml(&name),
                toml(named),
                toml(base)
            );
            text += &format!("grasp_frame = {}\n", toml(tool));
            if rpy.norm() > 1e-9 {
                text += &format!(
                    "grasp_rpy_deg = [{:.1}, {:.1}, {:.1}]   # turns the frame's axes: x ahead, z up\n",
                    rpy.x, rpy.y, rpy.z
                );
            }
            drive.iter().for_each(|line| text += &format!("{line}\n"));
            radius
                .iter()
                .for_each(|r| text += &format!("wheel_radius_m = {r:.4}   # measured on its mesh\n"));
            rate.iter().for_each(|r| text += &format!("wheel_rate_limit_rad_s = {r:.2}   # assumed\n"));
            text += &format!("base_width_m = {:.2}\n", base_size.width);
            if let Footprint::Polygon(_) = base_size.footprint {
                text += "base_footprint = \"collision\"\n";
            }
            text += &format!("grasp_height_m = {height}\n");
            if !parts.holds.is_empty() {
                text += &format!("\n[hold]\n{}\n", parts.holds.join("\n"));
            }
            text
        };
        let plain = euler(&parts.tool_from_grasp);
        let robot = load::without_postures(&texts.with(head(&BaseSize::disc(0.5), heights[0], plain)))?;
        let disc = BaseSize::disc_around(&robot);
        // a narrow base, unless its arm needs the room of the disc
        let narrow = BaseSize::polygon_around(&robot, &disc).and_then(|mut polygon| {
            let best = best_postures(&robot, &heights, &polygon.footprint)?;
            let joints = &best.1[0].joints;
            let half_width = postures::arm_half_width(&robot, joints, ARM_RADIUS_M);
            // nothing but balls is kept off obstacles as the arm moves
            let outside = postures::outside_balls(&robot, joints, ARM_RADIUS_M);
            polygon.width = polygon.width.max(centimetres(2.0 * (half_width + outside)));
            let is_narrow = outside <= MAX_OUTSIDE_M && NARROWER * polygon.width < disc.width;
            is_narrow.then_some((polygon, best))
        });
        let found = narrow.or_else(|| {
            let best = best_postures(&robot, &heights, &disc.footprint)?;
            Some((disc, best))
        });
        let Some((base_size, (height, found))) = found else {
            let heights = heights.iter().map(|h| h.to_string()).collect::<Vec<_>>().join(", ");
            let hint =
                if robot.freedom() < FULL { "; the arm cannot place its grasp in any pose" } else { "" };
            let tool = &parts.tool;
            return Err(Error::at(
                Place::file(urdf_file),
                format_args!(
                    "no posture found that holds `{tool}` level and straight ahead at {heights} m; try --grasp-height or --tool{hint}"
                ),
            ));
        };
        let roll = found[0].roll;
        let level = Rotation3::from_axis_angle(&Vector3::x_axis(), -roll);
        let rpy = euler(&(parts.tool_from_grasp * level));
        let mut text = head(&base_size, height, rpy);
        for (i, posture) in found.iter().filter(|f| f.roll == roll).enumerate() {
            text += &entry(&robot, posture, i + 1);
        }
        if let Some(height) = request.grasp_height.is_none().then_some(height) {
            assumed.push(format!("the object is held {height} m above the floor (--grasp-height)"));
        }
        let width = base_size.width;
        assumed.push(match base_size.footprint {
            Footprint::Disc { .. } => {
                format!("the base is {width:.2} m wide: a disc about the axle around its collision shapes")
            }
            Footprint::Polygon(_) => {
                let across = centimetres(footprint::across(&base_size.footprint));
                let arm = if across < width { format!(", and {width:.2} m with its arm") } else { String::new() };
                format!(
                    "the base is {across:.2} m wide{arm}: its collision shapes seen from above; a disc about the axle would be {:.2} m wide",
                    2.0 * robot.base_extent().expect("the outline is that of collision shapes")
                )
            }
        });
        let texts = texts.with(text.clone());
        let robot = load::complete(texts).map_err(|mut faults| faults.swap_remove(0))?;
        Ok(Self { text, assumed, robot })
    }
}

/// The first height at which there is a posture with enough room, or the height with the most room, and its
/// postures; `None` without postures.
fn best_postures(robot: &Robot, heights: &[f64], outline: &Footprint) -> Option<(f64, Vec<Found>)> {
    let room = |found: &Option<(f64, Vec<Found>)>| {
        found.as_ref().and_then(|(_, postures)| postures.first()).map_or(0.0, |best| best.room)
    };
    let mut found = None;
    for &height in heights {
        let here = Some((height, postures::search(robot, height, outline)));
        if room(&here) > room(&found) {
            found = here;
        }
        if room(&found) >= ENOUGH_ROOM {
            break;
        }
    }
    found
}

/// A width (m), rounded up.
fn centimetres(width: f64) -> f64 {
    (width * 100.0).ceil() / 100.0
}

/// The outline of a base, and the width that its robot needs, m.
struct BaseSize {
    width: f64,
    footprint: Footprint,
}

impl BaseSize {
    fn disc(width: f64) -> Self {
        Self { width, footprint: Footprint::Disc { center: Point::origin(), radius: width / 2.0 } }
    }

    /// A disc around the base's shapes.
    fn disc_around(robot: &Robot) -> Self {
        Self::disc(match robot.base_extent() {
            Some(extent) => centimetres(2.0 * extent),
            None => robot.drive.track.max(0.4) + 0.1,
        })
    }

    /// The polygon around the base's shapes where it is much narrower than a disc.
    fn polygon_around(robot: &Robot, disc: &Self) -> Option<Self> {
        if robot.warnings.iter().any(|w| w.kind() == WarningKind::MissingBaseShape) {
            return None;
        }
        let footprint = Footprint::Polygon(footprint::around_shapes(robot).ok()?);
        let width = centimetres(footprint::across(&footprint));
        (NARROWER * width < disc.width).then_some(Self { width, footprint })
    }
}

/// Roll, pitch and yaw of a rotation, degrees.
fn euler(rotation: &Rotation3<f64>) -> Vector3<f64> {
    let m = rotation.matrix();
    let pitch = math::asin((-m[(2, 0)]).clamp(-1.0, 1.0));
    let (roll, yaw) = match m[(2, 0)].abs() < 1.0 - 1e-9 {
        true => (math::atan2(m[(2, 1)], m[(2, 2)]), math::atan2(m[(1, 0)], m[(0, 0)])),
        false => (0.0, math::atan2(-m[(0, 1)], m[(1, 1)])),
    };
    Vector3::new(roll, pitch, yaw).map(|a| (a.to_degrees() * 10.0).round() / 10.0 + 0.0)
}

/// A `[[posture]]`.
fn entry(robot: &Robot, found: &Found, number: usize) -> String {
    let Found { ahead, lateral_offset, .. } = *found;
    let aside = match lateral_offset.abs() < 0.005 {
        true => String::new(),
        false => format!(
            " and {:.2} m to the {}",
            lateral_offset.abs(),
            if lateral_offset > 0.0 { "left" } else { "right" }
        ),
    };
    let mut text = format!(
        "\n[[posture]]   # the grasp {ahead:.2} m ahead of the axle{aside}\nname = \"posture-{number}\"\n"
    );
    for (motion, key) in [(Motion::Revolute, "angles_deg"), (Motion::Prismatic, "positions_m")] {
        let of = robot.joints.iter().zip(found.joints.iter()).filter(|(joint, _)| joint.motion == motion);
        let lines: String = of
            .map(|(joint, at)| {
                let value = if motion == Motion::Revolute { at.to_degrees() } else { *at };
                format!("{} = {value:.6}\n", toml::Value::String(joint.name.clone()))
            })
            .collect();
        if !lines.is_empty() {
            text += &format!("[posture.{key}]\n{lines}");
        }
    }
    text
}
