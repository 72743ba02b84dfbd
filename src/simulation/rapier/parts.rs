//! Colliders and the named parts that they belong to.

use super::{BodyKind, Part};
use crate::geometry::Pose;
use crate::robot::{Link, Shape};
use crate::simulation::convert::{to_rapier, to_vector};
use rapier3d::prelude::{
    ActiveCollisionTypes, Collider, ColliderBuilder, ColliderHandle, InteractionGroups, InteractionTestMode,
    PhysicsWorld, RigidBodyHandle, SharedShape,
};
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_2;

/// Collision groups. The robot's own parts never touch each other, and neither arm nor hand touches the
/// object that it holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Group {
    Base,
    Arm,
    Object,
    Torso,
    Hand,
    Obstacle,
}

impl Group {
    fn bit(self) -> u32 {
        1 << self as u32
    }

    fn touches(self) -> &'static [Group] {
        use Group::{Arm, Base, Hand, Object, Obstacle, Torso};
        match self {
            Base => &[Object, Torso, Hand, Obstacle],
            Arm => &[Torso, Hand, Obstacle],
            Object => &[Base, Torso, Obstacle],
            Torso => &[Base, Arm, Object, Obstacle],
            Hand => &[Base, Arm, Obstacle],
            Obstacle => &[Base, Arm, Object, Torso, Hand],
        }
    }

    /// Its bit, and the bits of the groups that it touches.
    pub fn bits(self) -> [u32; 2] {
        [self.bit(), self.touches().iter().fold(0, |bits, group| bits | group.bit())]
    }

    fn interaction(self) -> InteractionGroups {
        let [own, filter] = self.bits();
        InteractionGroups::new(own.into(), filter.into(), InteractionTestMode::And)
    }
}

/// All parts by number. A collider carries the number of its part.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Parts {
    parts: Vec<Part>,
    colliders: Vec<(BodyKind, ColliderHandle)>,
    /// Links with shapes that the physics ignores.
    left_out: Vec<String>,
}

impl Parts {
    /// Adds one shape.
    pub fn add(
        &mut self,
        world: &mut PhysicsWorld,
        body: Option<RigidBodyHandle>,
        shape: ColliderBuilder,
        name: &str,
        (kind, group): (BodyKind, Group),
    ) {
        let known = self.parts.iter().position(|p| p.kind == kind && p.name == name);
        let number = known.unwrap_or_else(|| {
            self.parts.push(Part { kind, name: name.to_owned() });
            self.parts.len() - 1
        });
        let collider = shape
            .density(0.0)
            .collision_groups(group.interaction())
            // the human is kinematic and obstacles are fixed: rapier ignores such pairs by default
            .active_collision_types(ActiveCollisionTypes::default() | ActiveCollisionTypes::KINEMATIC_FIXED)
            .user_data(number as u128);
        let handle = match body {
            Some(body) => world.colliders.insert_with_parent(collider, body, &mut world.bodies),
            None => world.colliders.insert(collider),
        };
        self.colliders.push((kind, handle));
    }

    /// Adds the collision shapes of a link.
    pub fn add_link(
        &mut self,
        world: &mut PhysicsWorld,
        body: RigidBodyHandle,
        link: &Link,
        body_from_link: &Pose,
        kind: (BodyKind, Group),
    ) {
        let quarter = to_rapier(&Pose::identity()) * rapier3d::math::Rotation::from_rotation_x(FRAC_PI_2);
        for geometry in &link.collisions {
            let at = to_rapier(&(body_from_link * geometry.link_from_shape));
            let (shape, at) = match &geometry.shape {
                Shape::Box { size } => {
                    (ColliderBuilder::cuboid(size.x / 2.0, size.y / 2.0, size.z / 2.0), at)
                }
                // rapier's cylinder is aligned with y; outside a compound its bounding box would be
                // searched for in every step
                Shape::Cylinder { radius, length } => {
                    let cylinder = SharedShape::cylinder(length / 2.0, *radius);
                    (ColliderBuilder::compound(vec![(quarter, cylinder)]), at)
                }
                Shape::Capsule { radius, length } => (ColliderBuilder::capsule_z(length / 2.0, *radius), at),
                Shape::Sphere { radius } => (ColliderBuilder::ball(*radius), at),
                Shape::Mesh { hull, .. } => {
                    let vertices: Vec<_> = hull.iter().map(to_vector).collect();
                    let hull =
                        if vertices.is_empty() { None } else { ColliderBuilder::convex_hull(&vertices) };
                    let Some(hull) = hull else {
                        self.left_out.push(link.name.clone());
                        continue;
                    };
                    (hull, at)
                }
            };
            self.add(world, Some(body), shape.position(at), &link.name, kind);
        }
    }

    /// Links with mesh shapes without a hull, which the physics ignores.
    pub fn left_out(&self) -> &[String] {
        &self.left_out
    }

    /// The part that a collider belongs to.
    pub fn number(collider: &Collider) -> usize {
        collider.user_data as usize
    }

    /// The part of that number.
    pub fn part(&self, number: usize) -> Option<&Part> {
        self.parts.get(number)
    }

    /// The colliders of a kind of body.
    pub fn of<'w>(
        &'w self,
        world: &'w PhysicsWorld,
        kind: BodyKind,
    ) -> impl Iterator<Item = &'w Collider> + Clone {
        let own = self.colliders.iter().filter(move |(owner, _)| *owner == kind);
        own.filter_map(|(_, handle)| world.colliders.get(*handle))
    }
}
