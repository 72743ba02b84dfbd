//! A robot file drafted from a URDF: the base, its wheels, the arm, the grasp and postures, each found or
//! assumed.

use super::draft_arms::Arm;
use super::draft_holds::{self, Hold};
use super::draft_request::DraftRequest;
use super::draft_search::{self, Parts};
use super::draft_text::{self, BaseSize, euler};
use super::draft_tree::carried_by;
use super::level::FULL;
use super::link::Link;
use super::load;
use super::postures::{self, FoundPosture, Places};
use super::texts::{Expand, RobotTexts};
use super::{Robot, tuck};
use crate::error::{Error, Place};
use crate::geometry::Footprint;
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
/// Heights tried after these, of arms that are low, small, or high up, m.
const OTHER_HEIGHTS_M: [f64; 12] = [0.4, 0.35, 0.3, 0.25, 0.2, 0.15, 1.2, 1.3, 1.4, 1.6, 1.8, 2.0];

/// Radius of the balls around an arm's joints that eq. (7) keeps off obstacles, m.
const ARM_RADIUS_M: f64 = 0.08;
/// How far an arm's shapes may be outside these balls for a base that is narrower than its disc, m. In an
/// opening as narrow as the base, such an arm would touch the walls; a disc is as wide as what is farther out.
const MAX_OUTSIDE_M: f64 = 0.05;

/// Room of a posture, as [`FoundPosture`] has it, with which no other height is tried.
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
        let links = load::links_to_draft(&texts)?;
        let parts = draft_search::find(&texts.urdf_file, &links, request)?;
        let name = urdf.file_stem().map_or("robot".to_owned(), |s| s.to_string_lossy().into_owned());
        let name = name.trim_end_matches(".urdf").to_owned();
        let drafting = Drafting { texts: &texts, links: &links, parts: &parts, name: &name, named };
        drafting.draft(request).map_err(|error| about_urdf(error, &texts))
    }
}

/// An error about the robot file, which is not written: as one about the URDF.
fn about_urdf(error: Error, texts: &RobotTexts) -> Error {
    let Some(place) = error.place().filter(|place| place.file == texts.file) else { return error };
    let (place, text) = (place.to_string(), error.to_string());
    let sentence =
        text.strip_prefix(&place).map_or(text.as_str(), |rest| rest.trim_start_matches([':', ' ']));
    Error::at(Place::file(&texts.urdf_file), format_args!("no robot file can be drafted: {sentence}"))
}

/// A URDF with the parts that were found in it.
struct Drafting<'a> {
    texts: &'a RobotTexts,
    links: &'a [Link],
    parts: &'a Parts,
    name: &'a str,
    /// How the robot file names the URDF.
    named: &'a str,
}

/// A robot with some joints held, and its best postures.
struct Attempt {
    robot: Robot,
    holds: Vec<Hold>,
    base_size: BaseSize,
    height: f64,
    found: Vec<FoundPosture>,
}

impl Attempt {
    fn room(&self) -> f64 {
        self.found.first().map_or(0.0, |best| best.room)
    }
}

impl Drafting<'_> {
    fn draft(&self, request: &DraftRequest) -> Result<Draft, Error> {
        let parts = self.parts;
        let Attempt { robot, holds, base_size, height, found } = self.best(request)?;
        let roll = found[0].roll;
        let level = Rotation3::from_axis_angle(&Vector3::x_axis(), -roll);
        let rpy = euler(&(parts.approach.tool_from_grasp * level));
        let mut text = self.head(parts.tool, &base_size, height, rpy, &holds);
        for (i, posture) in found.iter().filter(|f| f.roll == roll).enumerate() {
            text += &draft_text::posture(&robot, posture, i + 1);
        }
        let mut assumed = parts.assumed.clone();
        assumed.extend(self.told_holds(&holds));
        if request.grasp_height.is_none() {
            assumed.push(format!("the object is held {height} m above the floor (--grasp-height)"));
        }
        assumed.push(base_size.told(&robot));
        let texts = self.texts.with(text.clone());
        let robot = load::complete(texts).map_err(|mut faults| faults.swap_remove(0))?;
        Ok(Draft { text, assumed, robot })
    }

    /// The robot file without its postures.
    fn head(&self, tool: usize, size: &BaseSize, height: f64, rpy: Vector3<f64>, holds: &[Hold]) -> String {
        let link = |i: usize| self.links[i].name.as_str();
        let names = [self.name, self.named, link(self.parts.base), link(tool)];
        let holds: Vec<String> = holds.iter().map(|hold| hold.entry(self.links)).collect();
        draft_text::head(names, self.parts, size, height, rpy, &holds)
    }

    /// What is held besides a suspension, in sentences.
    fn told_holds(&self, holds: &[Hold]) -> Vec<String> {
        let told = |of: &[usize]| {
            let of = holds.iter().filter(|hold| of.contains(&hold.link));
            of.map(|hold| hold.told(self.links)).collect::<Vec<_>>().join(", ")
        };
        let mut lines = Vec::new();
        if !self.parts.excess.is_empty() {
            let joints = told(&self.parts.excess);
            lines.push(format!("more than 8 joints move between base and tool; held are {joints} (--hold)"));
        }
        for arm in &self.parts.idle {
            let (name, joints) = (&self.links[arm.tool].name, told(&arm.own));
            lines.push(match joints.is_empty() {
                true => format!("the other arm, of `{name}`, stays as the URDF has it: no way to tuck it was found (--hold)"),
                false => format!("the other arm, of `{name}`, is tucked away and held: {joints} (--tool {name} carries with it)"),
            });
        }
        lines
    }

    /// The first attempt with enough room, or the one with the most. Positions ahead of the base and at the
    /// usual heights come first.
    fn best(&self, request: &DraftRequest) -> Result<Attempt, Error> {
        let positions = draft_holds::positions(self.links, &self.parts.excess);
        let usual = request.grasp_height.map_or(HEIGHTS_M.to_vec(), |h| vec![h]);
        let all = request.grasp_height.map_or([&HEIGHTS_M[..], &OTHER_HEIGHTS_M].concat(), |h| vec![h]);
        let mut best: Option<Attempt> = None;
        let mut last = None;
        for (heights, places) in [(usual, Places::Ahead), (all.clone(), Places::Around)] {
            for position in &positions {
                let (robot, holds) = self.robot(position, heights[0])?;
                match attempt(robot, holds, &heights, places) {
                    Ok(next) if best.as_ref().is_none_or(|best| next.room() > best.room()) => {
                        best = Some(next)
                    }
                    Ok(_) => {}
                    Err(robot) => last = Some(robot),
                }
                if best.as_ref().is_some_and(|best| best.room() >= ENOUGH_ROOM) {
                    break;
                }
            }
            if let Some(best) = best {
                return Ok(best);
            }
        }
        Err(self.no_posture(last.as_deref(), &all))
    }

    /// The robot with joints of its torso at these positions, and the arms that do not carry tucked away; with
    /// all joints that it holds.
    fn robot(&self, torso: &[Hold], height: f64) -> Result<(Robot, Vec<Hold>), Error> {
        let fixed = draft_holds::once(self.parts.holds.iter().chain(torso).cloned());
        let tucked: Vec<Hold> =
            self.parts.idle.iter().flat_map(|arm| self.tucked(arm, &fixed, height)).collect();
        let holds = draft_holds::once(fixed.into_iter().chain(tucked));
        let rpy = euler(&self.parts.approach.tool_from_grasp);
        let text = self.head(self.parts.tool, &BaseSize::disc(0.5), height, rpy, &holds);
        Ok((load::without_postures(&self.texts.with(text))?, holds))
    }

    /// The joints of an arm tucked away; none if no way is found.
    fn tucked(&self, arm: &Arm, fixed: &[Hold], height: f64) -> Vec<Hold> {
        let shared = arm.joints.iter().filter(|joint| !arm.own.contains(joint));
        let shared = shared.map(|&link| Hold { link, at: draft_holds::near_zero(self.links, link) });
        let holds = draft_holds::once(fixed.iter().cloned().chain(shared));
        let text = self.head(arm.tool, &BaseSize::disc(0.5), height, Vector3::zeros(), &holds);
        let Ok(robot) = load::without_postures(&self.texts.with(text)) else { return Vec::new() };
        let Some(joints) = tuck::tucked(&robot) else { return Vec::new() };
        let of = robot.joints.iter().zip(joints.iter()).filter_map(|(joint, &at)| {
            let at = draft_holds::rounded(at, (joint.lower, joint.upper));
            carried_by(self.links, &joint.name).map(|link| Hold { link, at })
        });
        of.collect()
    }

    /// The error of a robot without a posture, with what its arm reaches.
    fn no_posture(&self, robot: Option<&Robot>, heights: &[f64]) -> Error {
        let tool = &self.links[self.parts.tool].name;
        let heights = heights.iter().map(|h| h.to_string()).collect::<Vec<_>>().join(", ");
        let reach = robot.map_or(String::new(), |robot| {
            let hint =
                if robot.freedom() < FULL { "; the arm cannot place its grasp in any pose" } else { "" };
            format!("; {}{hint}", robot.told_reach())
        });
        Error::at(
            Place::file(&self.texts.urdf_file),
            format_args!(
                "no posture found that holds `{tool}` level and straight ahead at {heights} m{reach}; try --grasp-height, --hold or --tool"
            ),
        )
    }
}

/// The best postures of a robot, and the size of its base that leaves them room; the robot, without postures.
fn attempt(robot: Robot, holds: Vec<Hold>, heights: &[f64], places: Places) -> Result<Attempt, Box<Robot>> {
    let disc = BaseSize::disc_around(&robot);
    // a narrow base, unless its arm needs the room of the disc
    let narrow = BaseSize::polygon_around(&robot, &disc).and_then(|mut polygon| {
        let best = best_postures(&robot, heights, &polygon.footprint, places)?;
        let joints = &best.1[0].joints;
        let half_width = postures::arm_half_width(&robot, joints, ARM_RADIUS_M);
        // nothing but balls is kept off obstacles as the arm moves
        let outside = postures::outside_balls(&robot, joints, ARM_RADIUS_M);
        polygon.widen(2.0 * (half_width + outside));
        let is_narrow = outside <= MAX_OUTSIDE_M && polygon.is_narrower(&disc);
        is_narrow.then_some((polygon, best))
    });
    let best = narrow.or_else(|| {
        let best = best_postures(&robot, heights, &disc.footprint, places)?;
        let joints = &best.1[0].joints;
        let half_width = postures::half_width_outside_balls(&robot, joints, ARM_RADIUS_M, MAX_OUTSIDE_M);
        let mut disc = disc;
        disc.widen(2.0 * half_width);
        Some((disc, best))
    });
    match best {
        Some((base_size, (height, found))) => Ok(Attempt { robot, holds, base_size, height, found }),
        None => Err(Box::new(robot)),
    }
}

/// The first height at which there is a posture with enough room, or the height with the most room, and its
/// postures; `None` without postures.
fn best_postures(
    robot: &Robot,
    heights: &[f64],
    outline: &Footprint,
    places: Places,
) -> Option<(f64, Vec<FoundPosture>)> {
    let room = |found: &Option<(f64, Vec<FoundPosture>)>| {
        found.as_ref().and_then(|(_, postures)| postures.first()).map_or(0.0, |best| best.room)
    };
    let mut found = None;
    for &height in heights {
        let here = Some((height, postures::search(robot, height, outline, places)));
        if room(&here) > room(&found) {
            found = here;
        }
        if room(&found) >= ENOUGH_ROOM {
            break;
        }
    }
    found
}
