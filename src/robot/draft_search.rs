//! The parts of a URDF: the base, the driven wheels, the tool and the arms, found by what they are and then by
//! their names.

use super::MAX_LISTED;
use super::collision;
use super::draft_approach::{Approach, approach};
use super::draft_arms::{Arm, arms};
use super::draft_drive::{FoundDrive, Seen, standing};
use super::draft_holds::{self, Hold};
use super::draft_legs::{check_legs, has_base, in_plane, no_base, rolling_part};
use super::draft_request::DraftRequest;
use super::draft_tree::{common, is_within, joint_name, listed, path, shapes, upward};
use super::link::{Link, Shape};
use super::wheel_search::{self, poses};
use crate::error::{Error, Place};
use crate::geometry::Pose;
use nalgebra::Point3;

/// The parts found in a URDF.
#[derive(Clone, Debug)]
pub(super) struct Parts {
    pub base: usize,
    pub tool: usize,
    /// Other arms, which are tucked away.
    pub idle: Vec<Arm>,
    /// The keys of the drive and of a base that is described, a line each.
    pub drive: Vec<String>,
    /// Radius of the wheels where the loader would not find it, m, and where it is from.
    pub radius: Option<(f64, &'static str)>,
    /// Assumed rate limit of the wheels where the URDF gives none, rad/s.
    pub rate: Option<f64>,
    /// Joints that are held: those that the user names, and those between the base and its wheels.
    pub holds: Vec<Hold>,
    /// Joints to hold so that eight are left.
    pub excess: Vec<usize>,
    pub approach: Approach,
    pub assumed: Vec<String>,
}

/// Speed of a base whose wheels have no limit, m/s.
const ASSUMED_SPEED: f64 = 1.0;
/// Mass of a base whose size is given, kg.
const ASSUMED_MASS: f64 = 60.0;
/// A base whose origin is nearer to the floor is on it, m.
const ON_FLOOR_M: f64 = 0.01;

/// A URDF and what is asked about it.
struct Search<'a> {
    file: &'a str,
    links: &'a [Link],
    poses: &'a [Pose],
    request: &'a DraftRequest,
}

/// Finds the parts. Names that the request gives are taken as they are.
pub(super) fn find(file: &str, links: &[Link], request: &DraftRequest) -> Result<Parts, Error> {
    Search { file, links, poses: &poses(links), request }.find()
}

impl Search<'_> {
    fn find(&self) -> Result<Parts, Error> {
        let Self { file, links, poses, request } = *self;
        check_legs(file, links)?;
        let given_tool = request.tool.as_ref().map(|name| self.link("--tool", name)).transpose()?;
        let given_base = request.base.as_ref().map(|name| self.link("--base", name)).transpose()?;
        let mut assumed = Vec::new();
        let seen = Seen::new(file, links, poses);
        let all = seen.all();
        if request.base_size.is_some() && !all.is_empty() {
            return Err(has_base(file, links, &all));
        }
        let mut drive = seen.drive(request, &mut assumed)?;
        let wheels = drive.wheels();
        let named = if wheels.is_empty() { standing(links, poses) } else { common(links, &wheels) };
        let base = given_base.unwrap_or_else(|| self.with_arm(named, given_tool, &all));
        let arms = arms(links, poses, base, &all);
        let (tool, own) = self.tool(base, given_tool, &arms)?;
        let are_arms = arms.iter().filter(|&arm| Some(arm) == own || arm.is_another());
        let tops: Vec<usize> = are_arms.filter_map(|arm| arm.joints.first().copied()).collect();
        if drive.is_omnidirectional() && request.base_size.is_none() {
            self.check_rolls(&seen, base, &tops, &mut assumed)?;
        }
        let radius = self.radius(&mut drive)?;
        let mut keys = drive.keys(links);
        if drive.is_omnidirectional() && drive.wheels().is_empty() {
            if request.base_size.is_none() {
                assumed.push(
                    "its wheels are not drawn turning: none are named (mecanum_wheels, omni_wheels)"
                        .to_owned(),
                );
            }
            keys.extend(self.stand(base, &tops, &mut assumed));
        }
        assumed.push(format!("the base is `{}`, with x ahead", links[base].name));
        let idle = self.tell_tool(tool, own, &arms, &mut assumed);
        let approach = approach(links, poses, base, tool);
        assumed.push(approach.told.clone());
        let rate = self.rate(&drive, radius);
        if rate.is_some() {
            assumed.push("the URDF does not limit the wheels' rate; it is assumed".to_owned());
        }
        let given = draft_holds::given(file, links, &request.hold)?;
        let suspension = draft_holds::suspension(links, base, &drive.wheels());
        let between: Vec<usize> = suspension.iter().map(|hold| hold.link).collect();
        if !between.is_empty() {
            let names = listed(links, &between);
            assumed.push(format!("the wheels' suspension stays fixed: {names} (under [hold])"));
        }
        let holds = draft_holds::once(given.into_iter().chain(suspension));
        let excess = draft_holds::excess(links, base, tool, &holds);
        Ok(Parts { base, tool, idle, drive: keys, radius, rate, holds, excess, approach, assumed })
    }

    /// The link of this name.
    fn link(&self, flag: &str, name: &str) -> Result<usize, Error> {
        self.links.iter().position(|link| link.name == name).ok_or_else(|| {
            let known = self.links.iter().map(|link| link.name.as_str());
            Error::unknown(Place::item(self.file, flag), "link", name, known, MAX_LISTED)
        })
    }

    /// The lowest link from `named` upward from which the tool descends, or else an arm; `named` itself if
    /// there is none.
    fn with_arm(&self, named: usize, tool: Option<usize>, wheels: &[usize]) -> usize {
        let has_arm = |&base: &usize| match tool {
            Some(tool) => base != tool && is_within(self.links, tool, base),
            None => !arms(self.links, self.poses, base, wheels).is_empty(),
        };
        upward(self.links, named).find(has_arm).unwrap_or(named)
    }

    /// The tool, and the arm that has it.
    fn tool<'r>(
        &self,
        base: usize,
        given: Option<usize>,
        arms: &'r [Arm],
    ) -> Result<(usize, Option<&'r Arm>), Error> {
        let base_name = &self.links[base].name;
        let Some(tool) = given else {
            let first = arms.first().ok_or_else(|| {
                Error::at(
                    Place::file(self.file),
                    format_args!(
                        "no arm descends from `{base_name}`; name the link that holds the object with --tool, or the link that drives with --base"
                    ),
                )
            })?;
            return Ok((first.tool, Some(first)));
        };
        let moves = path(self.links, base, tool).is_some_and(|path| {
            path.iter().any(|&i| super::draft_tree::independent(self.links, i).is_some())
        });
        if !moves {
            let name = &self.links[tool].name;
            return Err(Error::at(
                Place::item(self.file, format!("--tool {name}")),
                format_args!(
                    "no joint moves `{name}` against the base, `{base_name}`; name another link, or another --base"
                ),
            ));
        }
        Ok((tool, arms.iter().find(|arm| arm.carries(self.links, tool) || arm.tool == tool)))
    }

    /// Tells which tool it is, and returns the arms that do not carry.
    fn tell_tool(&self, tool: usize, own: Option<&Arm>, arms: &[Arm], assumed: &mut Vec<String>) -> Vec<Arm> {
        let name = |i: usize| format!("`{}`", self.links[i].name);
        let idle: Vec<Arm> =
            arms.iter().filter(|&arm| Some(arm) != own && arm.is_another()).cloned().collect();
        let others = idle.iter().map(|arm| name(arm.tool)).collect::<Vec<_>>().join(", ");
        if self.request.tool.is_none() {
            let instead = if idle.is_empty() { String::new() } else { format!("; another arm has {others}") };
            assumed.push(format!("the tool is {} (--tool){instead}", name(tool)));
        }
        idle
    }

    /// Whether the base of an omnidirectional robot shows that it drives.
    fn check_rolls(
        &self,
        seen: &Seen,
        base: usize,
        tops: &[usize],
        assumed: &mut Vec<String>,
    ) -> Result<(), Error> {
        if !seen.all().is_empty() || in_plane(self.links, self.poses).is_some() {
            return Ok(());
        }
        let part =
            rolling_part(self.links, tops).ok_or_else(|| no_base(self.file, &self.links[base].name))?;
        assumed.push(format!("the URDF has no wheels that turn; that the base drives is said by `{part}`"));
        Ok(())
    }

    /// The radius of the wheels where the loader cannot measure it. Wheels of an omnidirectional base without
    /// one are not drawn turning.
    fn radius(&self, drive: &mut FoundDrive) -> Result<Option<(f64, &'static str)>, Error> {
        let wheels = drive.wheels();
        let Some(&wheel) = wheels.first() else { return Ok(None) };
        if let Some(given) = self.request.wheel_radius {
            return Ok(Some((given, "given")));
        }
        let link = &self.links[wheel];
        if wheel_search::round(&link.collisions).or_else(|| wheel_search::round(&link.visuals)).is_some() {
            return Ok(None);
        }
        if let Some(radius) = wheel_search::mesh_radius(self.links, self.poses, wheel) {
            return Ok(Some((radius, "measured on its mesh")));
        }
        if let Some(floor) = self.floor() {
            let height = self.poses[wheel].translation.z - self.poses[floor].translation.z;
            if height > ON_FLOOR_M {
                return Ok(Some((height, "the height of its axle")));
            }
        }
        if let FoundDrive::Omnidirectional { wheels, .. } = drive {
            wheels.clear();
            return Ok(None);
        }
        let wheel = joint_name(self.links, wheel);
        Err(Error::at(
            Place::file(self.file),
            format_args!(
                "the radius of `{wheel}` cannot be measured: it has no shape; give it with --wheel-radius M"
            ),
        ))
    }

    /// The link that is on the floor by its name.
    fn floor(&self) -> Option<usize> {
        self.links.iter().position(|link| link.name.to_lowercase().ends_with("base_footprint"))
    }

    /// The rate limit of wheels for which the URDF has none.
    fn rate(&self, drive: &FoundDrive, radius: Option<(f64, &str)>) -> Option<f64> {
        let has_rate = |&wheel: &usize| {
            self.links[wheel].joint.as_ref().is_some_and(|j| j.limits.rate > 0.0 && j.limits.rate.is_finite())
        };
        let wheels = drive.wheels();
        let needs = !drive.is_omnidirectional() && !wheels.iter().all(has_rate);
        let measured = || wheel_search::radius(self.links, self.poses, wheels[0]);
        needs.then(|| ASSUMED_SPEED / radius.map(|(radius, _)| radius).or_else(measured).unwrap_or(0.1))
    }

    /// The keys of a base without wheels: its height above the floor, and its size and mass if the user
    /// describes it.
    fn stand(&self, base: usize, arms: &[usize], assumed: &mut Vec<String>) -> Vec<String> {
        let Some([length, width, height]) = self.request.base_size else {
            let height = self.height(base, arms);
            if height.abs() < ON_FLOOR_M {
                return Vec::new();
            }
            assumed.push(format!(
                "`{}` is {height:.3} m above the floor (base_height_m)",
                self.links[base].name
            ));
            return vec![format!("base_height_m = {height:.4}")];
        };
        let mass = self.request.base_mass.unwrap_or(ASSUMED_MASS);
        let is_said = if self.request.base_mass.is_some() { "" } else { " (assumed: --base-mass)" };
        assumed.push(format!(
            "the robot stands on a base that the URDF lacks: a box {length} m long, {width} m wide and {height} m high, of {mass} kg{is_said}"
        ));
        vec![
            format!("base_size_m = [{length:?}, {width:?}, {height:?}]   # a box that the URDF lacks"),
            format!("base_mass_kg = {mass:?}"),
            format!("base_height_m = {height:?}"),
        ]
    }

    /// How far a base is above the floor: above a link on the floor by its name, or above the lowest shape
    /// that no arm has, m.
    fn height(&self, base: usize, arms: &[usize]) -> f64 {
        let at = self.poses[base].translation.z;
        if let Some(floor) = self.floor() {
            return at - self.poses[floor].translation.z;
        }
        let of_base =
            (0..self.links.len()).filter(|&i| !upward(self.links, i).any(|above| arms.contains(&above)));
        let lowest = of_base.filter_map(|i| lowest(&self.links[i], &self.poses[i])).reduce(f64::min);
        lowest.map_or(0.0, |lowest| at - lowest)
    }
}

/// The lowest point of a link's shapes whose extent is known, m.
fn lowest(link: &Link, pose: &Pose) -> Option<f64> {
    let of_shape = |geometry: &super::link::Geometry| {
        let corners = match &geometry.shape {
            Shape::Mesh { hull, .. } if hull.is_empty() => return None,
            shape => collision::corners(shape),
        };
        let of_corner = corners
            .into_iter()
            .map(|(corner, radius)| (pose * geometry.link_from_shape * Point3::from(corner)).z - radius);
        of_corner.reduce(f64::min)
    };
    shapes(link).filter_map(of_shape).reduce(f64::min)
}
