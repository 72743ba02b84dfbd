//! Contacts between named parts, and smallest distances.

use super::observation::Clearances;
use super::parts::Parts;
use super::{BodyKind, Clearance, Contact, Part};
use crate::simulation::convert;
use nalgebra::Point3;
use rapier3d::parry::bounding_volume::Aabb;
use rapier3d::parry::query::distance;
use rapier3d::prelude::{Collider, ContactPair, PhysicsWorld};
use serde::{Deserialize, Serialize};

/// The contact of two parts (by number) since an observation was begun.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Touch {
    between: [usize; 2],
    point: Point3<f64>,
    depth: f64,
    force: f64,
}

/// The contacts since an observation was begun, ordered by their parts.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Touches(Vec<Touch>);

impl Touches {
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Adds the contacts of the last step, of `dt` seconds.
    pub fn add(&mut self, world: &PhysicsWorld, dt: f64) {
        let mut now: Vec<Touch> = Vec::new();
        for touch in world.narrow_phase.contact_pairs().filter_map(|pair| touch(world, pair, dt)) {
            match now.iter_mut().find(|t| t.between == touch.between) {
                Some(same) => {
                    // several shapes of one link share the force
                    let force = same.force + touch.force;
                    same.deepen(&touch);
                    same.force = force;
                }
                None => now.push(touch),
            }
        }
        for touch in now {
            match self.0.binary_search_by(|t| t.between.cmp(&touch.between)) {
                Ok(i) => self.0[i].deepen(&touch),
                Err(i) => self.0.insert(i, touch),
            }
        }
    }

    pub fn contacts(&self, parts: &Parts) -> Vec<Contact> {
        let named = |t: &Touch| {
            let [a, b] = t.between.map(|number| parts.part(number).cloned());
            Some(Contact { between: ordered(a?, b?), point: t.point, depth: t.depth, force: t.force })
        };
        self.0.iter().filter_map(named).collect()
    }
}

impl Touch {
    /// Keeps the larger depth, with its place, and the larger force.
    fn deepen(&mut self, other: &Self) {
        if other.depth > self.depth {
            (self.depth, self.point) = (other.depth, other.point);
        }
        self.force = self.force.max(other.force);
    }
}

fn ordered(a: Part, b: Part) -> [Part; 2] {
    if b.kind < a.kind { [b, a] } else { [a, b] }
}

/// A contact of two colliders that penetrate or press against each other.
fn touch(world: &PhysicsWorld, pair: &ContactPair, dt: f64) -> Option<Touch> {
    let [first, second] = [pair.collider1, pair.collider2].map(|handle| world.colliders.get(handle));
    let (first, second) = (first?, second?);
    let (manifold, deepest) = pair.find_deepest_contact()?;
    let force = pair.total_impulse_magnitude() / dt;
    let depth = (-deepest.dist).max(0.0);
    if depth == 0.0 && force == 0.0 {
        return None;
    }
    let shape = manifold.subshape_pos1().map_or(*first.position(), |at| first.position() * at);
    let point = convert::vector(shape * deepest.local_p1).into();
    let mut between = [first, second].map(Parts::number);
    between.sort_unstable();
    Some(Touch { between, point, depth, force })
}

/// The smallest distances in the present state.
pub(super) fn clearances(world: &PhysicsWorld, parts: &Parts) -> Clearances {
    let [robot, object, human, obstacle] =
        [BodyKind::Robot, BodyKind::Object, BodyKind::Human, BodyKind::Obstacle]
            .map(|kind| bounded(world, parts, kind));
    Clearances {
        robot_obstacle: nearest(&robot, &obstacle, parts),
        object_obstacle: nearest(&object, &obstacle, parts),
        human_obstacle: nearest(&human, &obstacle, parts),
        robot_human: nearest(&robot, &human, parts),
    }
}

fn bounded<'w>(world: &'w PhysicsWorld, parts: &'w Parts, kind: BodyKind) -> Vec<(Aabb, &'w Collider)> {
    parts.of(world, kind).map(|c| (c.compute_aabb(), c)).collect()
}

/// The nearest pair. Shapes are compared in the order of the distance between their boxes, until no closer
/// pair is possible.
fn nearest(one: &[(Aabb, &Collider)], other: &[(Aabb, &Collider)], parts: &Parts) -> Option<Clearance> {
    let pairs = one
        .iter()
        .enumerate()
        .flat_map(|(i, (a, _))| other.iter().enumerate().map(move |(j, (b, _))| (apart(a, b), i, j)));
    let mut pairs: Vec<(f64, usize, usize)> = pairs.collect();
    pairs.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut least = f64::INFINITY;
    let mut found = None;
    for (bound, i, j) in pairs {
        if bound >= least {
            break;
        }
        let (a, b) = (one[i].1, other[j].1);
        // rapier supports distances between all its shapes
        let Ok(measured) = distance(a.position(), a.shape(), b.position(), b.shape()) else { continue };
        if measured.distance < least {
            least = measured.distance;
            found = Some([a, b].map(Parts::number));
        }
    }
    let [a, b] = found?.map(|number| parts.part(number).cloned());
    Some(Clearance { distance: least, between: ordered(a?, b?) })
}

/// Distance between two boxes, m.
fn apart(a: &Aabb, b: &Aabb) -> f64 {
    let gap = (a.mins - b.maxs).max(b.mins - a.maxs);
    convert::vector(gap).map(|g| g.max(0.0)).norm()
}
