//! The text of a drafted robot file, and the size of its base.

use super::draft_search::Parts;
use super::footprint;
use super::postures::FoundPosture;
use super::warning::WarningKind;
use super::{Motion, Robot};
use crate::geometry::{Footprint, Point};
use crate::math;
use nalgebra::{Rotation3, Vector3};

/// A base is drafted with its own outline if a disc is more than this many times as wide.
const NARROWER: f64 = 1.1;

/// The robot file without its postures. Names: the robot's, the URDF's, the base's and the tool's. Angles in
/// degrees.
pub(super) fn head(
    [name, urdf, base, tool]: [&str; 4],
    parts: &Parts,
    base_size: &BaseSize,
    height: f64,
    rpy: Vector3<f64>,
    holds: &[String],
) -> String {
    let toml = |text: &str| toml::Value::String(text.to_owned()).to_string();
    let mut text = format!(
        "# Drafted by `cocarry robot init`. Check it with `cocarry robot check`.\nname = {}\nurdf = {}\nbase_link = {}\n",
        toml(name),
        toml(urdf),
        toml(base)
    );
    text += &format!("grasp_frame = {}\n", toml(tool));
    if rpy.norm() > 1e-9 {
        text += &format!(
            "grasp_rpy_deg = [{:.1}, {:.1}, {:.1}]   # turns the frame's axes: x ahead, z up\n",
            rpy.x, rpy.y, rpy.z
        );
    }
    parts.drive.iter().for_each(|line| text += &format!("{line}\n"));
    parts.radius.iter().for_each(|(r, from)| text += &format!("wheel_radius_m = {r:.4}   # {from}\n"));
    parts.rate.iter().for_each(|r| text += &format!("wheel_rate_limit_rad_s = {r:.2}   # assumed\n"));
    text += &format!("base_width_m = {:.2}\n", base_size.width);
    if let Footprint::Polygon(_) = base_size.footprint {
        text += "base_footprint = \"collision\"\n";
    }
    text += &format!("grasp_height_m = {height}\n");
    if !holds.is_empty() {
        text += &format!("\n[hold]\n{}\n", holds.join("\n"));
    }
    text
}

/// A `[[posture]]`.
pub(super) fn posture(robot: &Robot, found: &FoundPosture, number: usize) -> String {
    let FoundPosture { ahead, lateral_offset, .. } = *found;
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

/// Roll, pitch and yaw of a rotation, degrees.
pub(super) fn euler(rotation: &Rotation3<f64>) -> Vector3<f64> {
    let m = rotation.matrix();
    let pitch = math::asin((-m[(2, 0)]).clamp(-1.0, 1.0));
    let (roll, yaw) = match m[(2, 0)].abs() < 1.0 - 1e-9 {
        true => (math::atan2(m[(2, 1)], m[(2, 2)]), math::atan2(m[(1, 0)], m[(0, 0)])),
        false => (0.0, math::atan2(-m[(0, 1)], m[(1, 1)])),
    };
    Vector3::new(roll, pitch, yaw).map(|a| (a.to_degrees() * 10.0).round() / 10.0 + 0.0)
}

/// What a width may lie above whole centimetres by rounding, cm.
const ROUNDING_CM: f64 = 1e-9;

/// A width (m), rounded up.
fn centimetres(width: f64) -> f64 {
    (width * 100.0 - ROUNDING_CM).ceil() / 100.0
}

/// The outline of a base, and the width that its robot needs, m.
pub(super) struct BaseSize {
    pub width: f64,
    pub footprint: Footprint,
}

impl BaseSize {
    pub fn disc(width: f64) -> Self {
        Self { width, footprint: Footprint::Disc { center: Point::origin(), radius: width / 2.0 } }
    }

    /// A disc around the base's shapes.
    pub fn disc_around(robot: &Robot) -> Self {
        Self::disc(match robot.base_extent() {
            Some(extent) => centimetres(2.0 * extent),
            None => robot.drive.track.max(0.4) + 0.1,
        })
    }

    /// The polygon around the base's shapes where it is much narrower than a disc.
    pub fn polygon_around(robot: &Robot, disc: &Self) -> Option<Self> {
        if robot.warnings.iter().any(|w| w.kind() == WarningKind::MissingBaseShape) {
            return None;
        }
        let footprint = Footprint::Polygon(footprint::around_shapes(robot).ok()?);
        let polygon = Self { width: centimetres(footprint::across(&footprint)), footprint };
        polygon.is_narrower(disc).then_some(polygon)
    }

    /// Whether it is much narrower than a disc.
    pub fn is_narrower(&self, disc: &Self) -> bool {
        NARROWER * self.width < disc.width
    }

    /// Gives it at least this width, m.
    pub fn widen(&mut self, width: f64) {
        self.width = self.width.max(centimetres(width));
    }

    /// The assumption about it, in words.
    pub fn told(&self, robot: &Robot) -> String {
        let (width, across) = (self.width, centimetres(footprint::across(&self.footprint)));
        let arm = if across < width { format!(", and {width:.2} m with its arm") } else { String::new() };
        let Footprint::Polygon(_) = self.footprint else {
            return format!(
                "the base is {across:.2} m wide{arm}: a disc about the axle around its collision shapes"
            );
        };
        format!(
            "the base is {across:.2} m wide{arm}: its collision shapes seen from above; a disc about the axle would be {:.2} m wide",
            centimetres(2.0 * robot.base_extent().expect("the outline is that of collision shapes"))
        )
    }
}
