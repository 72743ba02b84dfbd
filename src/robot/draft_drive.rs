//! The drive of a URDF: found where names say which it is, and asked for where they do not.

use super::draft_request::DraftRequest;
use super::drive::DriveKind;
use super::driven::SKID_MULTIPLIER;
use super::link::{JointKind, Link};
use super::wheel_search::{self, is_mecanum, is_wheel};
use crate::error::{Error, Place};
use crate::geometry::Pose;
use nalgebra::Vector3;

/// Largest difference of two wheels that are mirror images, m.
const MIRRORED_M: f64 = 5e-3;
/// Limits of an omnidirectional base, of which a URDF says nothing: m/s and rad/s.
const ASSUMED_LIMITS: [f64; 2] = [1.0, 1.5];

/// The drive that was found, with the links of its wheels.
#[derive(Clone, Debug)]
pub(super) enum Found {
    /// Two driven wheels, left first, and whether that is said: there are others that roll freely.
    Differential([usize; 2], bool),
    /// Driven wheels of the left and of the right side.
    SkidSteer([Vec<usize>; 2]),
    /// Mecanum wheels, or none that are named.
    Omnidirectional { mecanum: Vec<usize> },
}

impl Found {
    pub fn wheels(&self) -> Vec<usize> {
        match self {
            Self::Differential(wheels, _) => wheels.to_vec(),
            Self::SkidSteer(sides) => sides.concat(),
            Self::Omnidirectional { mecanum } => mecanum.clone(),
        }
    }

    /// Its keys in a robot file, a line each.
    pub fn keys(&self, links: &[Link]) -> Vec<String> {
        let quoted = |i: usize| toml::Value::String(joint_name(links, i).to_owned()).to_string();
        let list = |wheels: &[usize]| wheels.iter().map(|&i| quoted(i)).collect::<Vec<_>>().join(", ");
        match self {
            Self::Differential([left, right], is_said) => {
                let drive = is_said.then(|| "drive = \"differential\"".to_owned());
                let sides =
                    [format!("left_wheel = {}", quoted(*left)), format!("right_wheel = {}", quoted(*right))];
                drive.into_iter().chain(sides).collect()
            }
            Self::SkidSteer([left, right]) => vec![
                "drive = \"skid-steer\"".to_owned(),
                format!("left_wheels = [{}]", list(left)),
                format!("right_wheels = [{}]", list(right)),
            ],
            Self::Omnidirectional { mecanum } => {
                let [speed, turn] = ASSUMED_LIMITS;
                let mut keys = vec!["drive = \"omnidirectional\"".to_owned()];
                if !mecanum.is_empty() {
                    keys.push(format!("mecanum_wheels = [{}]", list(mecanum)));
                }
                keys.push(format!("base_speed_limit_m_s = {speed:.1}   # assumed"));
                keys.push(format!("base_turn_limit_rad_s = {turn:.1}   # assumed"));
                keys
            }
        }
    }
}

/// The drive that the request gives, or else the one that the URDF leaves no doubt about.
pub(super) fn drive(
    file: &str,
    links: &[Link],
    poses: &[Pose],
    request: &DraftRequest,
    assumed: &mut Vec<String>,
) -> Result<Found, Error> {
    let wheels = wheels(links, poses);
    if let Some(names) = &request.wheels {
        let found = names.each_ref().map(|name| (0..links.len()).find(|&i| joint_name(links, i) == *name));
        let [Some(left), Some(right)] = found else {
            let seen = format!("no joint has the name given; wheels are: {}", listed(links, &wheels));
            return Err(no_wheels(file, &seen));
        };
        let others = wheel_search::others(links, &[left, right]);
        // mecanum wheels are refused by the loader, whoever says that they are something else
        if request.drive.is_none() && !others.is_empty() {
            return Err(many_wheels(file, links, &[vec![left, right], others].concat()));
        }
        return Ok(Found::Differential([left, right], request.drive.is_some()));
    }
    let is_free = wheels.iter().any(|&i| is_mecanum(links, i));
    match request.drive {
        None if is_free => {
            assumed.push(format!("the base has mecanum wheels: {}", listed(links, &wheels)));
            Ok(omnidirectional(wheels, assumed))
        }
        None | Some(DriveKind::Differential) => {
            let wheels = pair(file, links, poses)?;
            let [left, right] = wheels.map(|i| joint_name(links, i));
            assumed.push(format!("the driven wheels are `{left}` and `{right}`"));
            Ok(Found::Differential(wheels, request.drive.is_some()))
        }
        Some(DriveKind::SkidSteer) => {
            let mut sides = [1.0, -1.0].map(|side| {
                let of = wheels.iter().copied().filter(|&i| poses[i].translation.y * side > 0.0);
                of.collect::<Vec<_>>()
            });
            for side in &mut sides {
                side.sort_by(|&a, &b| poses[b].translation.x.total_cmp(&poses[a].translation.x));
            }
            if sides[0].len() != sides[1].len() || sides[0].len() < 2 {
                let seen = format!(
                    "a skid-steer base has two or more on either side, found {}",
                    listed(links, &wheels)
                );
                return Err(no_wheels(file, &seen));
            }
            let [left, right] = sides.each_ref().map(|side| listed(links, side));
            assumed.push(format!("the driven wheels are {left} on the left and {right} on the right"));
            assumed.push(format!(
                "in turns they skid as if they were {SKID_MULTIPLIER} times as far apart (wheel_separation_multiplier)"
            ));
            Ok(Found::SkidSteer(sides))
        }
        Some(DriveKind::Omnidirectional) => {
            let mecanum = if wheels.len() == 4 { wheels } else { Vec::new() };
            assumed.push(match mecanum.is_empty() {
                true => "its wheels are not drawn turning: none are named (mecanum_wheels, omni_wheels)"
                    .to_owned(),
                false => format!("these are mecanum wheels: {}", listed(links, &mecanum)),
            });
            Ok(omnidirectional(mecanum, assumed))
        }
    }
}

fn omnidirectional(mecanum: Vec<usize>, assumed: &mut Vec<String>) -> Found {
    let [speed, turn] = ASSUMED_LIMITS;
    assumed.push(format!(
        "the base drives {speed:.1} m/s and turns {turn:.1} rad/s at most: a URDF does not say"
    ));
    Found::Omnidirectional { mecanum }
}

fn wheels(links: &[Link], poses: &[Pose]) -> Vec<usize> {
    (0..links.len()).filter(|&i| is_wheel(links, poses, i)).collect()
}

/// The error of a URDF in which no pair of driven wheels is found, with what is `seen` instead.
fn no_wheels(file: &str, seen: &str) -> Error {
    Error::at(
        Place::file(file),
        format_args!(
            "no pair of driven wheels: expected two continuous joints about the base's y axis, one on either side; {seen}; an omnidirectional base needs --drive omnidirectional"
        ),
    )
}

/// The error of a URDF with more than one pair of wheels.
fn many_wheels(file: &str, links: &[Link], wheels: &[usize]) -> Error {
    let (count, names) = (wheels.len(), listed(links, wheels));
    Error::at(
        Place::file(file),
        format_args!(
            "{count} wheels could be driven: {names}; say which drive it has: --drive skid-steer, --drive omnidirectional (mecanum), or, if only two are driven and the others roll freely, --drive differential with --left-wheel and --right-wheel"
        ),
    )
}

/// The name of the joint that carries a link.
pub(super) fn joint_name(links: &[Link], i: usize) -> &str {
    links[i].joint.as_ref().map_or("", |joint| joint.name.as_str())
}

fn listed(links: &[Link], wheels: &[usize]) -> String {
    wheels.iter().map(|&i| format!("`{}`", joint_name(links, i))).collect::<Vec<_>>().join(", ")
}

/// The lowest link above all of these.
pub(super) fn common(links: &[Link], below: &[usize]) -> usize {
    let above =
        |i: usize| -> Vec<usize> { std::iter::successors(links[i].parent, |&at| links[at].parent).collect() };
    let of_others: Vec<Vec<usize>> = below.iter().skip(1).map(|&i| above(i)).collect();
    let first = below.first().map(|&i| above(i)).unwrap_or_default();
    first.into_iter().find(|at| of_others.iter().all(|above| above.contains(at))).unwrap_or(0)
}

/// The base of a URDF whose wheels are not known: the link on the floor by its name, else the root.
pub(super) fn standing(links: &[Link]) -> usize {
    let named = |name: &str| links.iter().position(|link| link.name.to_lowercase().ends_with(name));
    named("base_footprint").or_else(|| named("base_link")).unwrap_or(0)
}

/// The only pair of wheels that mirror each other, left first.
fn pair(file: &str, links: &[Link], poses: &[Pose]) -> Result<[usize; 2], Error> {
    let wheels = wheels(links, poses);
    let at = |i: usize| poses[i].translation.vector;
    let mut pairs = Vec::new();
    for &left in wheels.iter().filter(|&&i| at(i).y > 0.0) {
        let mirrored = Vector3::new(at(left).x, -at(left).y, at(left).z);
        pairs.extend(
            wheels.iter().filter(|&&i| (at(i) - mirrored).amax() < MIRRORED_M).map(|&right| [left, right]),
        );
    }
    match pairs[..] {
        [only] => Ok(only),
        [] => {
            let turning = links.iter().filter_map(|l| l.joint.as_ref());
            let turning =
                turning.filter(|j| j.kind == JointKind::Continuous).map(|j| format!("`{}`", j.name));
            let turning = turning.take(8).collect::<Vec<_>>().join(", ");
            let seen = match turning.is_empty() {
                true => {
                    "the URDF has no continuous joint: fix the arm to a base with two wheels, or make the wheels' joints continuous".to_owned()
                }
                false => format!("its continuous joints are {turning}"),
            };
            Err(no_wheels(file, &seen))
        }
        _ => Err(many_wheels(file, links, &wheels)),
    }
}
