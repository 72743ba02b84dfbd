//! A small rapier scene whose motion is part of the arithmetic [stamp](crate::arithmetic): a box slides down
//! a slope onto a ball, and two links swing on a driven hinge.

use super::GRAVITY;
use rapier3d::math::Vector;
use rapier3d::prelude::{
    ColliderBuilder, PhysicsWorld, RevoluteJointBuilder, RigidBodyBuilder, RigidBodyHandle,
};

/// Number of physics steps.
const STEPS: usize = 40;

/// Final positions and velocities of the bodies.
pub fn sample_motion() -> Vec<f64> {
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
