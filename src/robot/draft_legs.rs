//! Robots that a draft refuses for what they stand on: on legs, or on nothing that rolls.

use super::MAX_LISTED;
use super::draft_tree::{independent, joint_name, link_says, listed, moving, names, says, upward};
use super::link::{JointKind, Link};
use crate::error::{Error, Place};
use crate::geometry::Pose;
use crate::suggestion;

/// Words in the names of legs.
pub(super) const LEGS: [&str; 16] = [
    "leg", "legs", "hip", "thigh", "calf", "knee", "shank", "shin", "ankle", "foot", "femur", "tibia",
    "coxa", "haa", "hfe", "kfe",
];
/// Words in names that tell of a base that rolls.
const ROLLS: [&str; 16] = [
    "wheel", "wheels", "caster", "castor", "mecanum", "crawler", "chassis", "amr", "agv", "omni", "mobile",
    "rover", "cart", "swerve", "tracks", "roller",
];
/// Joints that move the whole robot in the plane in place of a base, and the least length of such a slide, m.
const MIN_SLIDES: usize = 2;
const MIN_SLIDE_M: f64 = 0.5;

/// The joints at the top of legs: there are two at least, or none.
fn legs(links: &[Link]) -> Vec<usize> {
    let is_leg = |i: usize| moving(links, i).is_some() && link_says(links, i, &LEGS);
    let is_top = |&i: &usize| is_leg(i) && !upward(links, i).skip(1).any(is_leg);
    let tops: Vec<usize> = (0..links.len()).filter(is_top).collect();
    if tops.len() >= 2 { tops } else { Vec::new() }
}

/// The error of a robot that stands on legs.
pub(super) fn check_legs(file: &str, links: &[Link]) -> Result<(), Error> {
    let legs = legs(links);
    if legs.is_empty() {
        return Ok(());
    }
    let names = suggestion::listed(legs.iter().map(|&i| joint_name(links, i)), MAX_LISTED);
    Err(Error::at(
        Place::file(file),
        format_args!(
            "a legged robot: it stands on legs, which begin at {names}; a robot that carries drives on wheels. To carry with its arm alone, take the legs out of the URDF and describe a base: --base-size LENGTH,WIDTH,HEIGHT"
        ),
    ))
}

/// What tells that a robot rolls: the name of a part of its base.
pub(super) fn rolling_part(links: &[Link], arms: &[usize]) -> Option<String> {
    let of_base = (0..links.len()).filter(|&i| !upward(links, i).any(|above| arms.contains(&above)));
    of_base.into_iter().find_map(|i| names(&links[i]).into_iter().find(|name| says(name, &ROLLS)))
}

/// The link below joints that move the whole robot in the plane, as models for simulators have them: two
/// slides along the floor at least, and a turn. With the links that these joints carry.
pub(super) fn in_plane(links: &[Link], poses: &[Pose]) -> Option<(usize, Vec<usize>)> {
    let mut at = 0;
    let (mut slides, mut turns) = (Vec::new(), Vec::new());
    loop {
        let below: Vec<usize> = (0..links.len()).filter(|&i| links[i].parent == Some(at)).collect();
        let is_massless = links[at].inertial.is_none_or(|inertial| inertial.mass < 1.0);
        let next = below.iter().copied().find(|&i| {
            let Some(joint) = independent(links, i) else {
                let is_fixed = links[i].joint.as_ref().is_some_and(|j| j.kind == JointKind::Fixed);
                return is_fixed && below.len() == 1 && is_massless;
            };
            let axis = poses[i].rotation * joint.axis.into_inner();
            let range = joint.limits.upper - joint.limits.lower;
            match joint.kind {
                JointKind::Prismatic => axis.z.abs() < 1e-3 && range >= MIN_SLIDE_M && turns.is_empty(),
                // the turn comes once, after the slides
                _ => axis.z.abs() > 0.999 && slides.len() >= MIN_SLIDES && turns.is_empty() && range > 6.0,
            }
        });
        let Some(next) = next else { break };
        match independent(links, next).map(|joint| joint.kind) {
            Some(JointKind::Prismatic) => slides.push(next),
            Some(_) => turns.push(next),
            None => {}
        }
        at = next;
        if !turns.is_empty() {
            break;
        }
    }
    let base = turns.last().or(slides.last()).copied()?;
    (slides.len() >= MIN_SLIDES).then(|| (base, [slides, turns].concat()))
}

/// The error of an arm that stands on nothing that rolls.
pub(super) fn no_base(file: &str, base: &str) -> Error {
    Error::at(
        Place::file(file),
        format_args!(
            "no base that drives: no wheel, caster or platform is part of `{base}` or rigid with it; if the robot stands on a base that the URDF lacks, describe that: --base-size LENGTH,WIDTH,HEIGHT (metres) and --base-mass KG"
        ),
    )
}

/// The error of a base that is described although the URDF has one.
pub(super) fn has_base(file: &str, links: &[Link], wheels: &[usize]) -> Error {
    Error::at(
        Place::file(file),
        format_args!(
            "--base-size describes the base of a robot that has none, but this one has wheels: {}",
            listed(links, wheels)
        ),
    )
}
