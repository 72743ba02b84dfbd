//! The drive of a URDF: found where wheels or their names say which it is, and asked for where they do not.

use super::MAX_LISTED;
use super::draft_legs::in_plane;
use super::draft_request::DraftRequest;
use super::draft_tree::{carried_by, joint_name, link_says, listed, moving};
use super::drive::DriveKind;
use super::driven::SKID_MULTIPLIER;
use super::link::{JointKind, Link};
use super::wheel_search::{self, is_level_wheel, is_mecanum, is_wheel, radius, steering, turns_freely};
use crate::error::{Error, Place};
use crate::geometry::Pose;
use nalgebra::Vector3;

/// Largest difference of two wheels that are mirror images, m.
const MIRRORED_M: f64 = 5e-3;
/// Limits of an omnidirectional base, of which a URDF says nothing: m/s and rad/s.
const ASSUMED_LIMITS: [f64; 2] = [1.0, 1.5];
/// How many times as large driven wheels are as those that roll freely, or by how much higher their axle is, m.
const LARGER: f64 = 1.4;
const HIGHER_M: f64 = 0.02;
/// Words in the names of driven wheels.
const DRIVEN: [&str; 5] = ["drive", "driven", "driving", "traction", "powered"];
/// The least number of wheels whose axes differ in direction, or that are all steered, of a base that moves
/// in any direction; and the least difference of such axes, rad.
const MIN_WHEELS: usize = 2;
const MIN_FREE_WHEELS: usize = 3;
const SKEW_RAD: f64 = 0.2;

/// The drive that was found, with the links of its wheels.
#[derive(Clone, Debug)]
pub(super) enum FoundDrive {
    /// Two driven wheels, left first, and whether that is said: there are others that roll freely.
    Differential([usize; 2], bool),
    /// Driven wheels of the left and of the right side.
    SkidSteer([Vec<usize>; 2]),
    /// Wheels that are drawn turning, mecanum wheels or others; or none.
    Omnidirectional { wheels: Vec<usize>, are_mecanum: bool },
}

impl FoundDrive {
    pub fn wheels(&self) -> Vec<usize> {
        match self {
            Self::Differential(wheels, _) => wheels.to_vec(),
            Self::SkidSteer(sides) => sides.concat(),
            Self::Omnidirectional { wheels, .. } => wheels.clone(),
        }
    }

    pub fn is_omnidirectional(&self) -> bool {
        matches!(self, Self::Omnidirectional { .. })
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
            Self::Omnidirectional { wheels, are_mecanum } => {
                let [speed, turn] = ASSUMED_LIMITS;
                let mut keys = vec!["drive = \"omnidirectional\"".to_owned()];
                if !wheels.is_empty() {
                    let kind = if *are_mecanum { "mecanum_wheels" } else { "omni_wheels" };
                    keys.push(format!("{kind} = [{}]", list(wheels)));
                }
                keys.push(format!("base_speed_limit_m_s = {speed:.1}   # assumed"));
                keys.push(format!("base_turn_limit_rad_s = {turn:.1}   # assumed"));
                keys
            }
        }
    }
}

/// The wheels of a URDF.
pub(super) struct Seen<'a> {
    file: &'a str,
    links: &'a [Link],
    poses: &'a [Pose],
    /// Wheels about the base's y that are not steered.
    straight: Vec<usize>,
    /// Wheels that joints above them steer.
    steered: Vec<usize>,
    /// Wheels about any level axis that are not steered.
    level: Vec<usize>,
}

impl<'a> Seen<'a> {
    pub fn new(file: &'a str, links: &'a [Link], poses: &'a [Pose]) -> Self {
        let is_steered = |i: usize| steering(links, poses, i).is_some();
        let all = |is_one: &dyn Fn(usize) -> bool| (0..links.len()).filter(|&i| is_one(i)).collect();
        Self {
            file,
            links,
            poses,
            straight: all(&|i| is_wheel(links, poses, i) && !is_steered(i)),
            steered: all(&|i| {
                (is_wheel(links, poses, i) || is_level_wheel(links, poses, i)) && is_steered(i)
            }),
            level: all(&|i| is_level_wheel(links, poses, i) && !is_steered(i)),
        }
    }

    /// All wheels.
    pub fn all(&self) -> Vec<usize> {
        let mut all = [&self.straight[..], &self.steered, &self.level].concat();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// The drive that the request gives, or else the one that the URDF leaves no doubt about.
    pub fn drive(&self, request: &DraftRequest, assumed: &mut Vec<String>) -> Result<FoundDrive, Error> {
        if let Some(names) = &request.wheels {
            return self.given(names, request.drive);
        }
        let wheels = self.listed(&self.straight);
        match request.drive {
            None if self.straight.iter().any(|&i| is_mecanum(self.links, i)) => {
                assumed.push(format!("the base has mecanum wheels: {wheels}"));
                Ok(omnidirectional(self.straight.clone(), true, assumed))
            }
            None if request.base_size.is_some() => Ok(omnidirectional(Vec::new(), false, assumed)),
            None => match self.in_any_direction() {
                Some((why, wheels)) => {
                    assumed.push(why);
                    Ok(omnidirectional(wheels, false, assumed))
                }
                None => self.differential(false, assumed),
            },
            Some(DriveKind::Differential) => self.differential(true, assumed),
            Some(DriveKind::SkidSteer) => self.skid_steer(assumed),
            Some(DriveKind::Omnidirectional) => {
                let (wheels, are_mecanum) = match (self.straight.len(), self.skew()) {
                    (4, _) => (self.straight.clone(), true),
                    (_, Some(wheels)) => (wheels, false),
                    _ => (Vec::new(), false),
                };
                if are_mecanum {
                    assumed.push(format!("these are mecanum wheels: {}", self.listed(&wheels)));
                }
                Ok(omnidirectional(wheels, are_mecanum, assumed))
            }
        }
    }

    /// The wheels that the request names.
    fn given(&self, names: &[String; 2], drive: Option<DriveKind>) -> Result<FoundDrive, Error> {
        let links = self.links;
        let found = names.each_ref().map(|name| carried_by(links, name));
        let [Some(left), Some(right)] = found else {
            let unknown = names.iter().zip(found).find(|(_, found)| found.is_none());
            let name = unknown.map_or("", |(name, _)| name);
            let known = links.iter().filter_map(|link| Some(link.joint.as_ref()?.name.as_str()));
            return Err(Error::unknown(Place::file(self.file), "joint", name, known, MAX_LISTED));
        };
        let others = wheel_search::others(links, &[left, right]);
        // mecanum wheels are refused by the loader, whoever says that they are something else
        if drive.is_none() && !others.is_empty() {
            return Err(self.many(&[vec![left, right], others].concat()));
        }
        Ok(FoundDrive::Differential([left, right], drive.is_some()))
    }

    fn differential(&self, is_said: bool, assumed: &mut Vec<String>) -> Result<FoundDrive, Error> {
        let (wheels, has_others) = self.pair()?;
        let car = self.steered.iter().filter_map(|&i| steering(self.links, self.poses, i));
        let car: Vec<usize> =
            car.filter(|&i| !self.links[i].joint.as_ref().is_some_and(turns_freely)).collect();
        if !car.is_empty() && !is_said {
            return Err(Error::at(
                Place::file(self.file),
                format_args!(
                    "a base that steers like a car, with {}, and cannot turn on the spot; it cannot be expressed. If it can turn, say how: --drive differential, --drive skid-steer or --drive omnidirectional",
                    self.listed(&car)
                ),
            ));
        }
        let [left, right] = wheels.map(|i| joint_name(self.links, i));
        let freely = if has_others { "; the others roll freely (--left-wheel, --right-wheel)" } else { "" };
        assumed.push(format!("the driven wheels are `{left}` and `{right}`{freely}"));
        Ok(FoundDrive::Differential(wheels, is_said || has_others))
    }

    fn skid_steer(&self, assumed: &mut Vec<String>) -> Result<FoundDrive, Error> {
        let mut sides = [1.0, -1.0].map(|side| {
            let of = self.straight.iter().copied().filter(|&i| self.at(i).y * side > 0.0);
            of.collect::<Vec<_>>()
        });
        for side in &mut sides {
            side.sort_by(|&a, &b| self.at(b).x.total_cmp(&self.at(a).x));
        }
        if sides[0].len() != sides[1].len() || sides[0].len() < 2 {
            let found = self.listed(&self.straight);
            return Err(
                self.none(&format!("a skid-steer base has two or more on either side, found {found}"))
            );
        }
        let [left, right] = sides.each_ref().map(|side| self.listed(side));
        assumed.push(format!("the driven wheels are {left} on the left and {right} on the right"));
        assumed.push(format!(
            "in turns they skid as if they were {SKID_MULTIPLIER} times as far apart (wheel_separation_multiplier)"
        ));
        Ok(FoundDrive::SkidSteer(sides))
    }

    /// Why the base moves in any direction, if its wheels leave no doubt, and those of them that are drawn
    /// turning.
    fn in_any_direction(&self) -> Option<(String, Vec<usize>)> {
        if let Some(wheels) = self.skew() {
            let names = self.listed(&wheels);
            return Some((format!("the base moves in any direction on {names}"), wheels));
        }
        let is_caster = |i: usize| link_says(self.links, i, &["caster", "castor"]);
        let steering = |&i: &usize| steering(self.links, self.poses, i);
        let steered: Vec<usize> = self.steered.iter().filter_map(steering).collect();
        let are_steered = self.straight.is_empty() && steered.len() >= MIN_WHEELS;
        if are_steered && !steered.iter().any(|&i| is_caster(i)) {
            let names = self.listed(&steered);
            return Some((
                format!("the base moves in any direction: all its wheels are steered, by {names}"),
                Vec::new(),
            ));
        }
        if let Some((_, joints)) =
            self.straight.is_empty().then(|| in_plane(self.links, self.poses)).flatten()
        {
            let names = self.listed(&joints);
            return Some((format!("the base moves in any direction: {names} stand for it"), Vec::new()));
        }
        let table = wheel_search::turntable(self.links, self.poses, &self.straight);
        let table = table.filter(|_| self.straight.len() == 2)?;
        let why = format!(
            "the base moves in any direction: its two wheels turn under it about {}",
            self.listed(&[table])
        );
        Some((why, Vec::new()))
    }

    /// Wheels whose axes differ in direction, as those of a base with three omnidirectional wheels do.
    fn skew(&self) -> Option<Vec<usize>> {
        let direction = |&i: &usize| wheel_search::direction(self.links, self.poses, i);
        let first = direction(self.level.first()?);
        let is_skew = |i: &usize| {
            let by = (direction(i) - first).abs();
            by.min(std::f64::consts::PI - by) > SKEW_RAD
        };
        let is_free = self.level.len() >= MIN_FREE_WHEELS && self.level.iter().any(is_skew);
        is_free.then(|| self.level.clone())
    }

    /// The only pair of wheels that mirror each other, left first, or the only one that is driven; and whether
    /// there are others.
    fn pair(&self) -> Result<([usize; 2], bool), Error> {
        let mut pairs = Vec::new();
        for &left in self.straight.iter().filter(|&&i| self.at(i).y > 0.0) {
            let mirrored = Vector3::new(self.at(left).x, -self.at(left).y, self.at(left).z);
            let is_mirrored = |&&i: &&usize| (self.at(i) - mirrored).amax() < MIRRORED_M;
            pairs.extend(self.straight.iter().filter(is_mirrored).map(|&right| [left, right]));
        }
        match pairs[..] {
            [only] => Ok((only, false)),
            [] => Err(self.none(&self.seen())),
            _ => self.driven(&pairs).map(|pair| (pair, true)).ok_or_else(|| self.many(&self.straight)),
        }
    }

    /// The pair of wheels that are named as driven, or are much larger than all others.
    fn driven(&self, pairs: &[[usize; 2]]) -> Option<[usize; 2]> {
        let named: Vec<_> =
            pairs.iter().filter(|pair| pair.iter().all(|&i| link_says(self.links, i, &DRIVEN))).collect();
        if let [only] = named[..] {
            return Some(*only);
        }
        let best_by = |size: &dyn Fn(usize) -> Option<f64>, is_larger: &dyn Fn(f64, f64) -> bool| {
            let mut sizes = Vec::new();
            for pair in pairs {
                sizes.push((size(pair[0])?, *pair));
            }
            sizes.sort_by(|a, b| b.0.total_cmp(&a.0));
            is_larger(sizes[0].0, sizes[1].0).then(|| sizes[0].1)
        };
        best_by(&|i| radius(self.links, self.poses, i), &|a, b| a > LARGER * b)
            .or_else(|| best_by(&|i| Some(self.at(i).z), &|a, b| a > b + HIGHER_M))
    }

    /// What the URDF has in place of driven wheels.
    fn seen(&self) -> String {
        let links = self.links;
        let named: Vec<usize> = (0..links.len())
            .filter(|&i| wheel_search::is_named(links, i) && links[i].joint.is_some())
            .filter(|&i| !links[i].joint.as_ref().is_some_and(turns_freely))
            .filter(|&i| {
                moving(links, i).is_some()
                    || links[i].joint.as_ref().is_some_and(|j| j.kind == JointKind::Fixed)
            })
            .collect();
        if let Some(&first) = named.first() {
            let kind = links[first].joint.as_ref().map_or("", |joint| joint.kind.name());
            return format!(
                "{} are named as wheels but do not turn freely (`{}` is {kind}): write type=\"continuous\" and an <axis> for those that are driven",
                self.first(&named),
                joint_name(links, first)
            );
        }
        let turning: Vec<usize> = (0..links.len())
            .filter(|&i| links[i].joint.as_ref().is_some_and(|j| j.kind == JointKind::Continuous))
            .collect();
        match turning.is_empty() {
            true => {
                "the URDF has no continuous joint: fix the arm to a base with two wheels, or make the wheels' joints continuous".to_owned()
            }
            false => format!("its continuous joints are {}", self.first(&turning)),
        }
    }

    /// The first few of some joints.
    fn first(&self, of: &[usize]) -> String {
        self.listed(&of[..of.len().min(8)])
    }

    /// The error of a URDF in which no pair of driven wheels is found, with what is `seen` instead.
    fn none(&self, seen: &str) -> Error {
        Error::at(
            Place::file(self.file),
            format_args!(
                "no pair of driven wheels: expected two continuous joints about the base's y axis, one on either side; {seen}; an omnidirectional base needs --drive omnidirectional, and an arm that stands on a base without a URDF --base-size LENGTH,WIDTH,HEIGHT"
            ),
        )
    }

    /// The error of a URDF with more than one pair of wheels.
    fn many(&self, wheels: &[usize]) -> Error {
        let (count, names) = (wheels.len(), self.listed(wheels));
        Error::at(
            Place::file(self.file),
            format_args!(
                "{count} wheels could be driven: {names}; say which drive it has: --drive skid-steer, --drive omnidirectional (mecanum), or, if only two are driven and the others roll freely, --drive differential with --left-wheel and --right-wheel"
            ),
        )
    }

    fn listed(&self, of: &[usize]) -> String {
        listed(self.links, of)
    }

    fn at(&self, i: usize) -> Vector3<f64> {
        self.poses[i].translation.vector
    }
}

fn omnidirectional(wheels: Vec<usize>, are_mecanum: bool, assumed: &mut Vec<String>) -> FoundDrive {
    let [speed, turn] = ASSUMED_LIMITS;
    assumed.push(format!(
        "the base drives {speed:.1} m/s and turns {turn:.1} rad/s at most: a URDF does not say"
    ));
    FoundDrive::Omnidirectional { wheels, are_mecanum }
}

/// The base of a URDF whose wheels are not known: the link below joints that stand for one, the link on the
/// floor by its name, else the root.
pub(super) fn standing(links: &[Link], poses: &[Pose]) -> usize {
    let named = |name: &str| links.iter().position(|link| link.name.to_lowercase().ends_with(name));
    let in_plane = in_plane(links, poses).map(|(base, _)| base);
    in_plane.or_else(|| named("base_footprint")).or_else(|| named("base_link")).unwrap_or(0)
}
