//! A mobile arm of rapier alone: a planar base and seven joints with implicit springs, whose hand holds one
//! end of a free beam by springs while a kinematic body leads the other. Prints the state after so many steps
//! of 0.01 s.
//!
//! It is what `measure` steps with every patch; it needs nothing of this repository.

use rapier3d::prelude::*;

const JOINTS: usize = 7;
const LINK: f64 = 0.16;

/// Springs on all six axes.
fn grip(front: Pose, back: Pose) -> GenericJoint {
    let mut joint = GenericJointBuilder::new(JointAxesMask::empty()).contacts_enabled(false);
    joint = joint.local_frame1(front).local_frame2(back);
    for axis in [JointAxis::LinX, JointAxis::LinY, JointAxis::LinZ] {
        joint = joint.motor_model(axis, MotorModel::ForceBased).motor_position(axis, 0.0, 5000.0, 300.0);
    }
    for axis in [JointAxis::AngX, JointAxis::AngY, JointAxis::AngZ] {
        joint = joint.motor_model(axis, MotorModel::ForceBased).motor_position(axis, 0.0, 50.0, 5.0);
    }
    joint.build()
}

fn body(world: &mut PhysicsWorld, builder: RigidBodyBuilder, mass: f64, size: [f64; 3]) -> RigidBodyHandle {
    let handle = world.insert_body(builder.can_sleep(false));
    let [x, y, z] = size.map(|side| side / 2.0);
    world.insert_collider(ColliderBuilder::cuboid(x, y, z).mass(mass), Some(handle));
    handle
}

fn main() {
    let steps: usize =
        std::env::args().nth(1).and_then(|steps| steps.parse().ok()).expect("a number of steps");
    let mut world = PhysicsWorld::new();
    world.gravity = Vector::new(0.0, 0.0, -9.81);
    world.integration_parameters.dt = 0.01;
    world.integration_parameters.num_solver_iterations = 1;
    world.integration_parameters.num_internal_pgs_iterations = 12;
    for i in 0..30 {
        let at = Vector::new(f64::from(i) - 15.0, if i % 2 == 0 { 4.0 } else { -4.0 }, 0.5);
        body(&mut world, RigidBodyBuilder::fixed().translation(at), 1.0, [0.8; 3]);
    }

    let anchor = world.insert_body(RigidBodyBuilder::fixed());
    let link = || RigidBodyBuilder::dynamic().gravity_scale(0.0);
    let base = body(&mut world, link(), 60.0, [0.6, 0.5, 0.4]);
    let planar = JointAxesMask::LIN_Z | JointAxesMask::ANG_X | JointAxesMask::ANG_Y;
    let drive = GenericJointBuilder::new(planar).contacts_enabled(false).build();
    let drive = world.multibody_joints.insert(anchor, base, drive, true).expect("a joint");
    let (mut last, mut joints) = (base, Vec::new());
    for i in 0..JOINTS {
        let next = body(&mut world, link(), 3.0, [0.08, 0.08, LINK]);
        let axis = [Vector::Z, Vector::Y, Vector::X][if i == 0 { 0 } else { 1 + i % 2 }];
        let basis = Pose::from_rotation(GenericJoint::complete_ang_frame(axis));
        let joint = GenericJointBuilder::new(JointAxesMask::LOCKED_REVOLUTE_AXES)
            .contacts_enabled(false)
            .local_frame1(
                Pose::from_translation(Vector::new(0.0, 0.0, if i == 0 { 0.2 } else { LINK / 2.0 })) * basis,
            )
            .local_frame2(Pose::from_translation(Vector::new(0.0, 0.0, -LINK / 2.0)) * basis);
        joints.push(world.multibody_joints.insert(last, next, joint.build(), true).expect("a joint"));
        last = next;
    }
    let (arm, _) = world.multibody_joints.get_mut(drive).expect("an arm");
    arm.set_self_contacts_enabled(false);
    arm.forward_kinematics(&world.bodies, true);
    arm.damping_mut().fill(20.0);
    arm.update_rigid_bodies(&mut world.bodies, true);

    let tip = Vector::new(0.0, 0.0, 0.2 + LINK * JOINTS as f64);
    let middle = tip + Vector::new(0.6, 0.0, 0.0);
    let beam = body(&mut world, RigidBodyBuilder::dynamic().translation(middle), 8.0, [1.2, 0.1, 0.1]);
    let lead = RigidBodyBuilder::kinematic_position_based().translation(tip + Vector::new(1.2, 0.0, 0.0));
    let lead = world.insert_body(lead);
    let end = |x: f64| Pose::from_translation(Vector::new(x, 0.0, 0.0));
    let at_tip = Pose::from_translation(Vector::new(0.0, 0.0, LINK / 2.0));
    world.impulse_joints.insert(last, beam, grip(at_tip, end(-0.6)), true);
    world.impulse_joints.insert(lead, beam, grip(Pose::IDENTITY, end(0.6)), true);

    for step in 0..steps {
        let time = 0.01 * step as f64;
        // triangles in place of sines: no function of the system
        let wave = |period: f64| (4.0 * ((time / period).fract() - 0.5).abs() - 1.0) * -1.0;
        let lead = world.bodies.get_mut(lead).expect("the lead");
        let to = tip + Vector::new(1.2 + 0.05 * time, 0.15 * (1.0 + wave(6.0)), 0.05 * (1.0 + wave(4.0)));
        lead.set_next_kinematic_position(Pose::from_translation(to));
        for (i, joint) in joints.iter().enumerate() {
            let (arm, id) = world.multibody_joints.get_mut(*joint).expect("an arm");
            let rest = 0.2 * (1.0 + wave(3.0 + i as f64));
            arm.link_mut(id).expect("a link").joint.set_spring(3, 3000.0, rest);
        }
        let (arm, id) = world.multibody_joints.get_mut(drive).expect("an arm");
        for (axis, rest) in [(0, 0.05 * time), (1, 0.0), (5, 0.1 * (1.0 + wave(5.0)))] {
            arm.link_mut(id).expect("a link").joint.set_spring(axis, 5000.0, rest);
        }
        world.step();
    }
    for (_, body) in world.bodies.iter().filter(|(_, body)| body.is_dynamic()) {
        let (at, velocity) = (body.translation(), body.linvel());
        println!("{} {} {} {} {} {}", at.x, at.y, at.z, velocity.x, velocity.y, velocity.z);
    }
}
