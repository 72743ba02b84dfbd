//! The drive, measured at its wheels.

use super::drive::{BaseInput, Drive, DriveKind, Wheel as DrivenWheel};
use super::link::{Geometry, JointKind, Link, Shape};
use super::urdf::Urdf;
use super::warning::RobotWarning;
use super::wheel_search::{round, turns_freely};
use crate::error::Error;
use crate::geometry::Pose;
use crate::math;
use nalgebra::{Point3, Rotation3, Vector3};
use std::collections::BTreeMap;

/// Largest difference between two lengths that must agree, m.
const SAME_LENGTH_M: f64 = 1.5e-3;
/// Largest share by which calibrated radii of wheels may differ from each other.
const SAME_RADIUS: f64 = 0.02;
/// Largest share by which a calibrated radius or track may differ from the URDF's.
const CALIBRATION: f64 = 0.1;
/// Largest difference between two directions that must agree, rad.
const SAME_DIRECTION_RAD: f64 = 1e-3;
/// The least sine of the angle between a wheel's axis and a cylinder that is drawn a quarter turn off.
const QUARTER_TURN: f64 = 0.9999;

/// A wheel in the base's frame.
struct Wheel {
    /// Centre in the base's frame, m.
    middle: Point3<f64>,
    /// Axis in the base's frame.
    axis: Vector3<f64>,
    radius: f64,
    /// The radius measured, where the robot file gives another.
    replaced: Option<f64>,
    /// Rate limit, rad/s.
    rate: f64,
    /// What is odd about it.
    remark: Option<String>,
}

/// The wheels that the robot file names: indices of their links.
pub(super) enum Named {
    /// The wheels of the left and of the right side, equally many.
    Sides {
        /// Left and right.
        wheels: [Vec<usize>; 2],
        /// The factor of the track of wheels that skid.
        multiplier: Option<f64>,
    },
    /// The wheels of an omnidirectional base.
    Omnidirectional(Omnidirectional),
}

/// The wheels of an omnidirectional base and what its robot file says about it.
pub(super) struct Omnidirectional {
    pub wheels: Vec<usize>,
    /// Whether they are mecanum wheels, with rollers at 45 degrees.
    pub is_mecanum: bool,
    /// Height of the base link's origin above the floor, m; measured at the wheels if not given.
    pub height: Option<f64>,
    /// Largest speed, m/s, and turning rate, rad/s.
    pub limits: [f64; 2],
}

/// The drive to measure.
pub(super) struct Wheels<'a> {
    pub base: usize,
    pub grasp: usize,
    pub named: Named,
    /// The radius given in the robot file, m.
    pub radius: Option<f64>,
    /// The distance between the wheels given in the robot file, m.
    pub track: Option<f64>,
    /// The rate limit given in the robot file, rad/s.
    pub rate: Option<f64>,
    pub base_radius: f64,
    /// Positions of held joints by name, rad or m, such as of a suspension.
    pub held: BTreeMap<&'a str, f64>,
}

/// A measured drive.
pub(super) struct Measured {
    pub drive: Drive,
    /// `drive_from_base`.
    pub drive_from_base: Pose,
    pub wheels: Vec<DrivenWheel>,
    pub warnings: Vec<RobotWarning>,
}

impl Named {
    /// All wheels.
    pub fn links(&self) -> Vec<usize> {
        match self {
            Self::Sides { wheels, .. } => wheels.concat(),
            Self::Omnidirectional(of) => of.wheels.clone(),
        }
    }
}

impl Wheels<'_> {
    /// The drive; its frame is on the floor, midway between the wheels' centres, or below the base link if an
    /// omnidirectional base names no wheels. The error is the first fault of each wheel, or of all together.
    pub fn measure(&self, urdf: Urdf, links: &[Link]) -> Result<Measured, Vec<Error>> {
        let fault = |i: usize, why: String| {
            Error::at(urdf.place(format!("joint `{}`", name(links, i))), format_args!("not a wheel: {why}"))
        };
        let mut found = Vec::new();
        let mut faults = Vec::new();
        for &i in &self.named.links() {
            match self.wheel(links, i) {
                Ok(wheel) => found.push((i, wheel)),
                Err(why) => faults.push(fault(i, why)),
            }
        }
        if !faults.is_empty() {
            return Err(faults);
        }
        let mut remarks: Vec<RobotWarning> = Vec::new();
        for (i, wheel) in &mut found {
            let remark = wheel.remark.take().map(|remark| format!("joint `{}`: {remark}", name(links, *i)));
            remarks.extend(remark.map(RobotWarning::new));
        }
        remarks.extend(equalize(&mut found));
        let measured = match &self.named {
            Named::Sides { wheels: [left, _], multiplier } => {
                let (left, right) = found.split_at(left.len());
                self.sides(links, left, right, *multiplier)
            }
            Named::Omnidirectional(of) => self.omnidirectional(links, &found, of),
        };
        let mut measured = measured.map_err(|(i, why)| vec![fault(i, why)])?;
        measured.warnings.extend(remarks);
        Ok(measured)
    }

    /// Two driven sides. Wheels of one side are alike, and mirror images of those of the other.
    fn sides(
        &self,
        links: &[Link],
        left: &[(usize, Wheel)],
        right: &[(usize, Wheel)],
        multiplier: Option<f64>,
    ) -> Result<Measured, (usize, String)> {
        for (side, sign, named, wheels) in
            [("left", "positive", 1.0, left), ("right", "negative", -1.0, right)]
        {
            for (i, wheel) in wheels {
                let y = wheel.middle.y;
                if named * y <= 0.0 {
                    return Err((
                        *i,
                        format!(
                            "it is at y = {y:.4} m in the base; it must be on the {side}, where y is {sign}"
                        ),
                    ));
                }
            }
        }
        let pairs = left.iter().zip(right).map(|pair| (pair, true));
        let along = left.iter().skip(1).map(|other| ((&left[0], other), false));
        for (((first, a), (second, b)), is_pair) in pairs.chain(along) {
            let (x, y) = if is_pair { (b.middle.x, -b.middle.y) } else { (a.middle.x, b.middle.y) };
            for (what, left, right, tolerance) in [
                ("x in the base (m)", a.middle.x, x, SAME_LENGTH_M),
                ("distance from the middle of the base (m)", a.middle.y, y, SAME_LENGTH_M),
                ("z in the base (m)", a.middle.z, b.middle.z, SAME_LENGTH_M),
                ("radius (m)", a.radius, b.radius, 1e-6),
                ("limit velocity (rad/s)", a.rate, b.rate, 1e-6),
            ] {
                if (left - right).abs() > tolerance {
                    return Err((*second, unlike(what, right, name(links, *first), left)));
                }
            }
        }
        let ((_, first), (_, opposite)) = (&left[0], &right[0]);
        let mut middle = nalgebra::center(&first.middle, &opposite.middle);
        let pairs = left.len() as f64;
        if left.len() > 1 {
            middle.x = left.iter().map(|(_, wheel)| wheel.middle.x).sum::<f64>() / pairs;
        }
        let measured = first.middle.y - opposite.middle.y;
        let mut warnings = Vec::new();
        if let Some(measured) = first.replaced {
            warnings.push(calibrated("wheel_radius_m", first.radius, measured));
        }
        if let Some(given) = self.track.filter(|&given| given != measured) {
            if (given - measured).abs() > CALIBRATION * measured {
                return Err((
                    left[0].0,
                    format!(
                        "the wheels are {measured:.4} m apart in the URDF, but wheel_separation_m = {given}; they must agree within 10 %"
                    ),
                ));
            }
            warnings.push(calibrated("wheel_separation_m", given, measured));
        }
        let track = self.track.unwrap_or(measured);
        let rim_speed_limit = first.rate * first.radius;
        let (kind, track) = match multiplier {
            None => (DriveKind::Differential, track),
            Some(multiplier) => (DriveKind::SkidSteer, track * multiplier),
        };
        let drive = Drive {
            kind,
            track,
            wheel_radius: first.radius,
            rim_speed_limit,
            turn_rate_limit: 2.0 * rim_speed_limit / track,
            base_radius: self.base_radius,
        };
        let spin = |wheel: &Wheel, side: usize| {
            let mut spin = BaseInput::zeros();
            spin[side] = wheel.axis.y.signum();
            spin
        };
        let of_side = |side: usize| {
            move |(link, wheel): &(usize, Wheel)| DrivenWheel { link: *link, spin: spin(wheel, side) }
        };
        let wheels = left.iter().map(of_side(0)).chain(right.iter().map(of_side(1))).collect();
        Ok(Measured { drive, drive_from_base: above(middle, first.radius), wheels, warnings })
    }

    /// An omnidirectional base. Its wheels, if it names any, are drawn turning; they have one radius.
    fn omnidirectional(
        &self,
        links: &[Link],
        found: &[(usize, Wheel)],
        of: &Omnidirectional,
    ) -> Result<Measured, (usize, String)> {
        let [rim_speed_limit, turn_rate_limit] = of.limits;
        let mut drive = Drive {
            kind: DriveKind::Omnidirectional,
            track: 0.0,
            wheel_radius: 0.0,
            rim_speed_limit,
            turn_rate_limit,
            base_radius: self.base_radius,
        };
        let Some((first, like)) = found.first() else {
            let floor = Point3::new(0.0, 0.0, -of.height.unwrap_or(0.0));
            let (wheels, warnings) = (Vec::new(), Vec::new());
            return Ok(Measured { drive, drive_from_base: above(floor, 0.0), wheels, warnings });
        };
        for (i, wheel) in &found[1..] {
            for (what, left, right, tolerance) in [
                ("z in the base (m)", like.middle.z, wheel.middle.z, SAME_LENGTH_M),
                ("radius (m)", like.radius, wheel.radius, 1e-6),
            ] {
                if (left - right).abs() > tolerance {
                    return Err((*i, unlike(what, right, name(links, *first), left)));
                }
            }
        }
        drive.wheel_radius = like.radius;
        let sum: Vector3<f64> = found.iter().map(|(_, wheel)| wheel.middle.coords).sum();
        let mut middle = Point3::from(sum / found.len() as f64);
        if let Some(height) = of.height {
            middle.z = like.radius - height;
        }
        let spin = |wheel: &Wheel| {
            let at = wheel.middle - middle;
            // the direction in which it rolls when it turns about its axis
            let ahead = wheel.axis.cross(&Vector3::z());
            // a roller does not slide along its axle: the hub's velocity along it is the wheel's. Mecanum
            // wheels stand such that the rollers on the floor point away from the base's middle
            let along = match of.is_mecanum {
                true => Vector3::new(1.0, -(at.x * at.y).signum(), 0.0),
                false => ahead,
            };
            let per_turn = along.dot(&ahead) * wheel.radius;
            BaseInput::new(along.x, along.y, along.y * at.x - along.x * at.y) / per_turn
        };
        let wheels =
            found.iter().map(|(link, wheel)| DrivenWheel { link: *link, spin: spin(wheel) }).collect();
        let replaced = like.replaced.map(|measured| calibrated("wheel_radius_m", like.radius, measured));
        let warnings = replaced.into_iter().collect();
        Ok(Measured { drive, drive_from_base: above(middle, like.radius), wheels, warnings })
    }

    fn wheel(&self, links: &[Link], i: usize) -> Result<Wheel, String> {
        let base = &links[self.base].name;
        let elsewhere =
            |root: &Link| format!("it does not descend from `{base}`; its root is `{}`", root.name);
        let Some(joint) = &links[i].joint else { return Err(elsewhere(&links[i])) };
        if !turns_freely(joint) {
            let kind = joint.kind.name();
            return Err(format!(
                "its joint is {kind}; it must be continuous: write type=\"continuous\" and its <axis> in the URDF"
            ));
        }
        if let Some(mimic) = &joint.mimic {
            return Err(format!("it mimics `{}`; each wheel must turn independently", mimic.joint));
        }
        let mut arm = std::iter::successors(Some(self.grasp), |&at| links[at].parent);
        if arm.any(|at| at == i) {
            return Err(format!("the grasp, `{}`, descends from it", links[self.grasp].name));
        }
        let mut base_from_wheel = joint.parent_from_joint;
        let mut at = links[i].parent.unwrap_or(i);
        while at != self.base {
            let (Some(parent), Some(between)) = (links[at].parent, &links[at].joint) else {
                return Err(elsewhere(&links[at]));
            };
            let held = self.held.get(between.name.as_str()).copied();
            if between.kind != JointKind::Fixed && held.is_none() {
                let (joint, kind) = (&between.name, between.kind.name());
                return Err(format!(
                    "it is connected to `{base}` through `{joint}`, which is {kind}; it must be fixed, or held under [hold]"
                ));
            }
            base_from_wheel = between.parent_from_link(held.unwrap_or(0.0)) * base_from_wheel;
            at = parent;
        }
        let axis = base_from_wheel.rotation * joint.axis.into_inner();
        let [x, y, z] = axis.into();
        let is_free = matches!(&self.named, Named::Omnidirectional(of) if !of.is_mecanum);
        if is_free && z.abs() > SAME_DIRECTION_RAD {
            return Err(format!("its axis is ({x:.4}, {y:.4}, {z:.4}) in the base; it must be level"));
        }
        if !is_free && math::hypot(x, z) > SAME_DIRECTION_RAD {
            return Err(format!(
                "its axis is ({x:.4}, {y:.4}, {z:.4}) in the base; it must be along the base's y"
            ));
        }
        let rate = self.rate.unwrap_or(joint.limits.rate);
        let needs_rate = matches!(self.named, Named::Sides { .. });
        if needs_rate && !(rate > 0.0 && rate.is_finite()) {
            return Err(format!(
                "limit velocity = {rate}; it must be greater than 0 and finite; give wheel_rate_limit_rad_s in the robot file"
            ));
        }
        let found = round(&links[i].collisions).or_else(|| round(&links[i].visuals));
        let mut remark = (joint.kind != JointKind::Continuous)
            .then(|| "it is revolute with a range of a turn or more; it is taken as continuous".to_owned());
        let (radius, replaced, middle) = match (found, self.radius) {
            (None, None) => {
                let why = "it has no cylinder or sphere to measure; give wheel_radius_m in the robot file";
                return Err(why.to_owned());
            }
            (None, Some(given)) => (given, None, Vector3::zeros()),
            (Some((shape, measured)), given) => match (along_axis(shape, &joint.axis), given) {
                (Err(Off::By(why)), Some(given)) => {
                    remark = Some(format!("its {why}; only wheel_radius_m counts"));
                    (given, None, Vector3::zeros())
                }
                (Err(Off::By(why)), None) => {
                    return Err(format!(
                        "its {why}; it must be centred on it, or give wheel_radius_m in the robot file"
                    ));
                }
                (_, Some(given)) if (given - measured).abs() > CALIBRATION * measured => {
                    return Err(format!(
                        "its radius is {measured} m in the URDF, but wheel_radius_m = {given}; they must agree within 10 %"
                    ));
                }
                (along, given) => {
                    let middle = along.unwrap_or_else(|_| {
                        remark = Some(format!(
                            "its cylinder is drawn 90 deg off the joint's axis; its radius of {measured} m is taken as the wheel's"
                        ));
                        Vector3::zeros()
                    });
                    (given.unwrap_or(measured), given.map(|_| measured), middle)
                }
            },
        };
        Ok(Wheel { middle: base_from_wheel * Point3::from(middle), axis, radius, replaced, rate, remark })
    }
}

/// Gives wheels whose radii differ by their calibration the mean of these, with a warning.
fn equalize(wheels: &mut [(usize, Wheel)]) -> Option<RobotWarning> {
    let radii = || wheels.iter().map(|(_, wheel)| wheel.radius);
    let (least, most) = (radii().reduce(f64::min)?, radii().reduce(f64::max)?);
    let mean = radii().sum::<f64>() / wheels.len() as f64;
    if most - least <= 1e-6 || most - least > SAME_RADIUS * mean {
        return None;
    }
    wheels.iter_mut().for_each(|(_, wheel)| wheel.radius = mean);
    Some(RobotWarning::new(format!(
        "the wheels' radii differ, {least:.4} to {most:.4} m in the URDF: their mean of {mean:.4} m is taken (wheel_radius_m)"
    )))
}

/// The warning that a value in the robot file (m) replaces the URDF's.
fn calibrated(key: &str, given: f64, measured: f64) -> RobotWarning {
    RobotWarning::new(format!("{key} = {given} replaces {measured:.4} m, as measured in the URDF"))
}

/// The fault of a wheel that is neither equal to another one nor its mirror image.
fn unlike(what: &str, value: f64, other: &str, of_other: f64) -> String {
    format!("its {what} is {value} but that of `{other}` is {of_other}; they must be the same")
}

/// The name of the joint that carries a link.
fn name(links: &[Link], i: usize) -> &str {
    links[i].joint.as_ref().map_or("", |joint| joint.name.as_str())
}

/// `drive_from_base` for a drive whose origin is on the floor, below this point of the base (m) by a
/// `radius`.
fn above(middle: Point3<f64>, radius: f64) -> Pose {
    let floor = Vector3::new(middle.x, middle.y, middle.z - radius);
    Pose::from_parts((-floor).into(), Rotation3::identity())
}

/// How a wheel's shape is off the joint's axis.
enum Off {
    /// Its cylinder is across the axis, around the same centre.
    QuarterTurn,
    /// A sentence.
    By(String),
}

/// The centre of a wheel's shape in the wheel's frame. The shape must be centred on the joint's axis.
fn along_axis(geometry: &Geometry, axis: &Vector3<f64>) -> Result<Vector3<f64>, Off> {
    let middle = geometry.link_from_shape.translation.vector;
    let by_m = axis.cross(&middle).norm();
    let (shape, sine) = match geometry.shape {
        Shape::Sphere { .. } => ("sphere", 0.0),
        _ => ("cylinder", (geometry.link_from_shape.rotation * Vector3::z()).cross(axis).norm()),
    };
    if by_m <= SAME_LENGTH_M && sine >= QUARTER_TURN {
        return Err(Off::QuarterTurn);
    }
    if by_m > SAME_LENGTH_M || sine > SAME_DIRECTION_RAD {
        let by_deg = math::asin(sine.min(1.0)).to_degrees();
        return Err(Off::By(format!("{shape} is {by_m:.4} m or {by_deg:.2} deg off the joint's axis")));
    }
    Ok(axis * axis.dot(&middle))
}
