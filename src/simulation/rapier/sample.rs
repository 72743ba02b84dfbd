//! A small rapier scene whose motion is part of the arithmetic [stamp](crate::arithmetic): a box slides down
//! a slope onto a ball, and two links swing on a driven hinge.

use super::dimensions::GRAVITY;
use crate::math;
use rapier3d::math::{Matrix, Vector};
use rapier3d::prelude::{
    ColliderBuilder, MassProperties, PhysicsWorld, RevoluteJointBuilder, RigidBodyBuilder, RigidBodyHandle,
};

/// Number of physics steps.
const STEPS: usize = 40;

/// Principal inertias of bodies and their frames. parry takes them with the system's `acos` and `cos`, which no feature of
/// it replaces: a stamp without them would not tell such machines apart.
pub fn principal_inertias() -> Vec<f64> {
    let of = |i: u8| {
        let x = 0.1 * f64::from(i);
        let tensor = Matrix::from_cols(
            Vector::new(1.0 + x, 0.1 * x, 0.2),
            Vector::new(0.1 * x, 2.0 - x, 0.3 * x),
            Vector::new(0.2, 0.3 * x, 1.5),
        );
        let mass = MassProperties::with_inertia_matrix(Vector::ZERO, 1.0, tensor);
        let (inertia, frame) = (mass.principal_inertia(), mass.principal_inertia_local_frame);
        [inertia.x, inertia.y, inertia.z, frame.x, frame.y, frame.z, frame.w]
    };
    (1..=40).flat_map(of).collect()
}

/// Mass and inertia of the hull of points of no symmetry: parry finds its first tetrahedron in principal axes.
pub fn hull() -> Vec<f64> {
    let points: Vec<Vector> = (0..12)
        .map(|i| 0.37 * f64::from(i))
        .map(|x| Vector::new(math::cos(3.0 * x), math::sin(2.0 * x), math::cos(5.0 * x + 1.0)))
        .collect();
    let hull = ColliderBuilder::convex_hull(&points).map(|hull| hull.density(1.0).build().mass_properties());
    let of = |mass: MassProperties| {
        let (inertia, center) = (mass.principal_inertia(), mass.local_com);
        vec![mass.mass(), center.x, center.y, center.z, inertia.x, inertia.y, inertia.z]
    };
    of(hull.expect("twelve points in space have a hull"))
}

/// Final positions and velocities of the bodies.
pub fn moved() -> Vec<f64> {
    let mut world = PhysicsWorld::new();
    world.gravity = Vector::new(0.0, 0.0, -GRAVITY);
    world.insert_collider(
        ColliderBuilder::cuboid(3.0, 3.0, 0.1).rotation(Vector::new(0.1, 0.3, 0.0)).friction(0.2),
        None,
    );
    let body = |x: f64, z: f64| {
        RigidBodyBuilder::dynamic()
            .translation(Vector::new(x, 0.05, z))
            .linvel(Vector::new(0.3, 0.0, -1.0))
            .can_sleep(false)
    };
    let (slider, _) = world.insert(body(-0.4, 0.4), ColliderBuilder::cuboid(0.2, 0.1, 0.1));
    let (ball, _) = world.insert(body(0.1, 0.3), ColliderBuilder::ball(0.12));
    let anchor = world.insert_body(RigidBodyBuilder::fixed().translation(Vector::new(0.0, 5.0, 2.0)));
    let mut handles = vec![slider, ball];
    let mut parent = anchor;
    for k in 0..2 {
        let (link, _) = world.insert(
            RigidBodyBuilder::dynamic().can_sleep(false),
            ColliderBuilder::capsule_x(0.2, 0.05).density(800.0),
        );
        let axis = if k == 0 { Vector::Y } else { Vector::Z };
        let mut joint = RevoluteJointBuilder::new(axis).local_anchor2(Vector::new(-0.3, 0.0, 0.0));
        if k == 1 {
            joint = joint.local_anchor1(Vector::new(0.3, 0.0, 0.0)).motor_velocity(1.5, 20.0);
        }
        world.multibody_joints.insert(parent, link, joint, true);
        handles.push(link);
        parent = link;
    }
    (0..STEPS).for_each(|_| world.step());
    let state = |handle: RigidBodyHandle| {
        let body = &world.bodies[handle];
        [body.translation(), body.linvel(), body.angvel()]
    };
    handles.into_iter().flat_map(state).flat_map(|v| [v.x, v.y, v.z]).collect()
}
