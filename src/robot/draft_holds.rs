//! Joints that a draft holds: a suspension, a torso, an idle arm, and those that the user names.

use super::draft_tree::{carried_by, independent, joint_name, path, upward};
use super::link::{Joint, JointKind, Link};
use super::{MAX_JOINTS, MAX_LISTED};
use crate::error::{Error, Place};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::f64::consts::PI;

/// A joint that stays fixed.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Hold {
    /// Its link.
    pub link: usize,
    /// Its position, rad or m.
    pub at: f64,
}

/// Positions of a torso that are tried, besides that of the URDF.
const POSITIONS: usize = 8;
/// The farthest from the URDF's position that they are, rad or m.
const MAX_AWAY: f64 = 1.2;

impl Hold {
    /// Its entry under `[hold]`.
    pub fn entry(&self, links: &[Link]) -> String {
        let name = toml::Value::String(joint_name(links, self.link).to_owned());
        match links[self.link].joint.as_ref().map(|joint| joint.kind) {
            Some(JointKind::Prismatic) => format!("{name} = {{ position_m = {} }}", self.at),
            _ => format!("{name} = {{ angle_deg = {} }}", self.at.to_degrees()),
        }
    }

    /// Its joint and position, for a sentence.
    pub fn told(&self, links: &[Link]) -> String {
        let name = joint_name(links, self.link);
        match links[self.link].joint.as_ref().map(|joint| joint.kind) {
            Some(JointKind::Prismatic) => format!("`{name}` at {:.3} m", self.at),
            _ => format!("`{name}` at {:.1} deg", self.at.to_degrees()),
        }
    }
}

/// The position of a link's joint, rad or m, that is nearest to 0.
pub(super) fn near_zero(links: &[Link], link: usize) -> f64 {
    let limits = links[link].joint.as_ref().map(|joint| joint.limits);
    limits.map_or(0.0, |limits| 0f64.max(limits.lower).min(limits.upper))
}

/// Whether a joint can be held: its limits are known.
fn is_holdable(joint: &Joint) -> bool {
    joint.limits.lower < joint.limits.upper
}

/// The joints that the user holds.
pub(super) fn given(file: &str, links: &[Link], hold: &[(String, f64)]) -> Result<Vec<Hold>, Error> {
    let of = |(name, value): &(String, f64)| {
        let known = (0..links.len()).filter(|&i| independent(links, i).is_some());
        let found = carried_by(links, name).filter(|&i| independent(links, i).is_some());
        let Some(link) = found else {
            let known = known.map(|i| joint_name(links, i)).collect::<Vec<_>>();
            return Err(Error::unknown(Place::file(file), "independent joint", name, known, MAX_LISTED));
        };
        let joint = links[link].joint.as_ref().expect("a joint of this name was found");
        let (at, unit, scale) = match joint.kind {
            JointKind::Prismatic => (*value, "metres", 1.0),
            _ => (value.to_radians(), "degrees", 1f64.to_degrees()),
        };
        let (lower, upper) = (joint.limits.lower, joint.limits.upper);
        if !at.is_finite() || !(lower..=upper).contains(&at) {
            let expected = format!("from {:.3} to {:.3} ({unit})", lower * scale, upper * scale);
            let place = Place::item(file, format!("joint `{name}`"));
            return Err(Error::number(place, &format!("--hold {name}"), *value, &expected));
        }
        Ok(Hold { link, at })
    };
    hold.iter().map(of).collect()
}

/// The joints between the base and its wheels, each once, at 0 or as near to it as their limits allow.
pub(super) fn suspension(links: &[Link], base: usize, wheels: &[usize]) -> Vec<Hold> {
    let above = |&wheel: &usize| upward(links, wheel).skip(1).take_while(|&at| at != base);
    let mut between: Vec<usize> = wheels.iter().flat_map(above).collect();
    between.retain(|&at| independent(links, at).is_some_and(is_holdable));
    let mut seen = Vec::new();
    between.retain(|at| {
        !seen.contains(at) && {
            seen.push(*at);
            true
        }
    });
    between.into_iter().map(|link| Hold { link, at: near_zero(links, link) }).collect()
}

/// The joints above the last eight of an arm, of those that are not held already, from the base outward.
pub(super) fn excess(links: &[Link], base: usize, tool: usize, held: &[Hold]) -> Vec<usize> {
    let mut path = path(links, base, tool).unwrap_or_default();
    path.retain(|&i| independent(links, i).is_some() && held.iter().all(|hold| hold.link != i));
    path.truncate(path.len().saturating_sub(MAX_JOINTS));
    path
}

/// Positions at which these joints may be held: that of the URDF, then others drawn at random, the same for
/// every call.
pub(super) fn positions(links: &[Link], of: &[usize]) -> Vec<Vec<Hold>> {
    let zero: Vec<Hold> = of.iter().map(|&link| Hold { link, at: near_zero(links, link) }).collect();
    if of.is_empty() {
        return vec![zero];
    }
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let drawn = (0..POSITIONS).map(|_| {
        let near = |hold: &Hold| {
            let limits =
                links[hold.link].joint.as_ref().map_or((0.0, 0.0), |j| (j.limits.lower, j.limits.upper));
            let [lower, upper] = [limits.0.max(hold.at - MAX_AWAY), limits.1.min(hold.at + MAX_AWAY)];
            Hold { link: hold.link, at: rounded(lower + (upper - lower) * rng.random::<f64>(), limits) }
        };
        zero.iter().map(near).collect()
    });
    let drawn: Vec<Vec<Hold>> = drawn.collect();
    std::iter::once(zero).chain(drawn).collect()
}

/// A position, rad or m, in tenths of a degree or of that many radians, within its limits.
pub(super) fn rounded(at: f64, (lower, upper): (f64, f64)) -> f64 {
    let step = PI / 1800.0;
    ((at / step).round() * step).max(lower).min(upper)
}

/// The first of several entries for each joint.
pub(super) fn once(holds: impl IntoIterator<Item = Hold>) -> Vec<Hold> {
    let mut kept: Vec<Hold> = Vec::new();
    for hold in holds {
        if kept.iter().all(|other| other.link != hold.link) {
            kept.push(hold);
        }
    }
    kept
}
