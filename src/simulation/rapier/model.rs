//! The model of a physical plant at its start, as plain data: what another simulator has to know to simulate
//! the same bodies.

use super::articulation::{BASE_FORCE, BASE_TORQUE};
use super::base_motor::BaseMotor;
use super::clusters::{Cluster, clusters, moving};
use super::dimensions::{GRAVITY, TORSO_AHEAD, TORSO_HEIGHT};
use super::grip::Stiffness;
use super::human::Walker;
use super::motor::{MotorSpring, stops};
use super::parts::Group;
use super::scene::{LinedUp, object_inertia};
use super::{PhysicsSettings, Wrench};
use crate::geometry::{PlanarPose, Pose};
use crate::robot::{Configuration, JointKind, JointVector, Robot};
use crate::world::World;
use nalgebra::{Matrix3, Vector3};
use rapier3d::prelude::ColliderBuilder;

/// The bodies, motors and grips of a physical plant, and the poses at its start. SI units.
#[derive(Clone, Debug)]
pub struct PlantModel {
    /// Gravity against the world's z, m/s^2. It acts on the object alone.
    pub gravity: f64,
    /// Friction coefficient of all contacts.
    pub friction: f64,
    /// Configuration of the robot at the start.
    pub start: Configuration,
    /// The robot's bodies, parents before children. The first is the base, whose frame is the drive's.
    pub bodies: Vec<BodyModel>,
    /// Force of the base's motors per difference of rates, Ns/m or Nms/rad.
    pub base_gain: f64,
    /// Largest forces of the base's motors along x and y of the world, N, and torque about z, Nm.
    pub base_limits: [f64; 3],
    /// Index of the body that holds the object, and the grasp's pose in it.
    pub holder: (usize, Pose),
    /// `world_from_object` at the start; the origin is the object's centre.
    pub object: Pose,
    /// Inertia of the object about its centre, in its axes, kg m^2.
    pub object_inertia: Matrix3<f64>,
    /// The robot's grip, at the object's rear end, in the grasp's axes.
    pub gripper: GripModel,
    /// The human's grip, at the object's front end, in the hand's axes.
    pub hand_grip: GripModel,
    /// `world_from_hand` at the start.
    pub hand: Pose,
    /// `world_from_torso` at the start; the origin is the middle of the torso.
    pub torso: Pose,
}

/// Links of the robot that move as one body.
#[derive(Clone, Debug)]
pub struct BodyModel {
    /// Its first link: index into [`Robot::links`]. Its frame is the body's, except for the base.
    pub link: usize,
    /// The joint to its parent; `None` for the base.
    pub joint: Option<JointModel>,
    /// Its links, as indices into [`Robot::links`], with their poses in the body's frame.
    pub links: Vec<(usize, Pose)>,
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass in the body's frame, m.
    pub center: Vector3<f64>,
    /// Inertia about the centre of mass, in the body's axes, kg m^2.
    pub inertia: Matrix3<f64>,
}

/// The joint between a body and its parent.
#[derive(Clone, Debug)]
pub struct JointModel {
    /// Index of the parent among [`PlantModel::bodies`].
    pub parent: usize,
    /// Pose of the joint in the parent's frame at position 0.
    pub parent_from_joint: Pose,
    /// Unit axis in the joint's frame, about or along which it moves.
    pub axis: Vector3<f64>,
    /// Whether it moves along its axis, m, and not about it, rad.
    pub slides: bool,
    /// Lower and upper stop, rad or m; `None` without stops.
    pub stops: Option<[f64; 2]>,
    /// The arm joint that it is or mimics: index into [`Robot::joints`].
    pub arm_joint: usize,
    /// `ratio` and `offset` (rad or m) of a joint that mimics the arm joint; `None` for the arm joint itself.
    pub mimics: Option<[f64; 2]>,
    /// Position at the start, rad or m.
    pub start: f64,
    /// Stiffness of its motor or gear, Nm/rad or N/m.
    pub stiffness: f64,
    /// Damping of its motor or gear, Nms/rad or Ns/m.
    pub damping: f64,
    /// Largest effort, Nm or N; `None` without a limit.
    pub effort_limit: Option<f64>,
}

/// A grip: a spring-damper between a holder and an end of the object.
#[derive(Clone, Copy, Debug)]
pub struct GripModel {
    /// Stiffness along the holder's axes, N/m.
    pub stiffness: f64,
    /// Damping along the holder's axes, Ns/m.
    pub damping: f64,
    /// Rest position along the holder's z, m: half of the object's weight does not make it sag.
    pub rest: f64,
    /// Stiffness about the holder's axes for small angles, Nm/rad.
    pub angular_stiffness: f64,
    /// Damping about the holder's axes, Nms/rad.
    pub angular_damping: f64,
    /// Largest force along an axis, N, and torque about one, Nm.
    pub limits: [f64; 2],
}

/// Groups of shapes that touch each other or not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactGroup {
    /// The robot's base.
    Base,
    /// The robot's other bodies.
    Arm,
    /// The object.
    Object,
    /// The human's torso.
    Torso,
    /// The human's hand.
    Hand,
    /// Obstacles.
    Obstacle,
}

impl ContactGroup {
    /// The group's bit, and the bits of all groups that it touches. Two shapes touch if each has the other's
    /// bit.
    pub fn bits(self) -> [u32; 2] {
        let group = match self {
            Self::Base => Group::Base,
            Self::Arm => Group::Arm,
            Self::Object => Group::Object,
            Self::Torso => Group::Torso,
            Self::Hand => Group::Hand,
            Self::Obstacle => Group::Obstacle,
        };
        group.bits()
    }
}

impl PlantModel {
    /// The model of a plant that [`PhysicalPlant::new`](super::PhysicalPlant::new) makes of the same arguments.
    pub fn new(
        world: &World,
        robot: &Robot,
        joints: &JointVector,
        team: &PlanarPose,
        settings: &PhysicsSettings,
    ) -> Self {
        let (object, height) = (&world.object, robot.grasp_height);
        let LinedUp { robot: start, front } = LinedUp::new(robot, joints, team, object.size[0] / 2.0);
        let clusters = clusters(robot);
        let place = |(i, cluster): (usize, &Cluster)| {
            let grasp = cluster.links.iter().find(|(link, _)| *link == robot.grasp_link);
            grasp.map(|(_, body_from_grasp)| (i, *body_from_grasp))
        };
        let holder = clusters.iter().enumerate().find_map(place);
        let bodies = clusters.into_iter().map(|cluster| BodyModel::of(cluster, robot, &start)).collect();
        let load = object.mass / 2.0;
        let gripper = Stiffness::of_gripper(settings.gripper_stiffness);
        let hand = Stiffness::of_hand(settings.human.hand_stiffness);
        // the sway begins with the walk
        let human = Walker::new(front, settings.human, 0);
        Self {
            gravity: GRAVITY,
            friction: ColliderBuilder::default_friction(),
            start,
            bodies,
            base_gain: BaseMotor::gain(settings.step()),
            base_limits: [BASE_FORCE, BASE_FORCE, BASE_TORQUE],
            holder: holder.unwrap_or((0, Pose::identity())),
            object: team.at_height(height),
            object_inertia: object_inertia(object),
            // rapier's spring about an axis of a multibody's link follows the sine of half the angle
            gripper: GripModel::of(gripper, gripper.angular / 2.0, load),
            hand_grip: GripModel::of(hand, hand.angular, load),
            hand: human.hand(height),
            torso: human.torso(TORSO_AHEAD, TORSO_HEIGHT / 2.0),
        }
    }
}

impl BodyModel {
    fn of(cluster: Cluster, robot: &Robot, start: &Configuration) -> Self {
        let joint = cluster.parent.zip(moving(robot, cluster.link));
        let joint = joint.map(|((parent, parent_from_joint), (joint, driver))| {
            let spring = MotorSpring::of(joint);
            let coupling = joint.coupling;
            JointModel {
                parent,
                parent_from_joint,
                axis: *joint.axis,
                slides: joint.kind == JointKind::Prismatic,
                stops: stops(joint, &robot.joints[driver]),
                arm_joint: driver,
                mimics: joint.mimic.is_some().then_some([coupling.ratio, coupling.offset]),
                start: coupling.ratio * start.joints[driver] + coupling.offset,
                effort_limit: spring.limit(),
                stiffness: spring.stiffness,
                damping: spring.damping,
            }
        });
        let Cluster { link, links, mass, center, inertia, .. } = cluster;
        Self { link, joint, links, mass, center, inertia }
    }
}

impl JointModel {
    /// The pose of the body in its parent's frame at a position (rad or m) of the joint.
    pub fn parent_from_body(&self, position: f64) -> Pose {
        let moved = self.axis * position;
        self.parent_from_joint
            * match self.slides {
                true => Pose::translation(moved.x, moved.y, moved.z),
                false => Pose::rotation(moved),
            }
    }
}

impl GripModel {
    fn of(grip: Stiffness, angular_stiffness: f64, load: f64) -> Self {
        let [damping, angular_damping] = grip.damping(load);
        Self {
            stiffness: grip.linear,
            damping,
            rest: grip.rest(load),
            angular_stiffness,
            angular_damping,
            limits: grip.most,
        }
    }
}

/// A physics step that was made: what its motors and the human were given, and where it led. World axes, SI
/// units.
#[derive(Clone, Copy, Debug)]
pub struct PhysicsStep {
    /// Simulated time at its end, s.
    pub time: f64,
    /// Rates that the base's motors shall keep: along x and y of the world, m/s, and about z, rad/s.
    pub base_rates: [f64; 3],
    /// Rest positions of the arm's motors, rad or m, in the order of [`Robot::joints`].
    pub rests: JointVector,
    /// `world_from_hand` at its end.
    pub hand: Pose,
    /// Velocity (m/s) and angular velocity (rad/s) of the hand during it, in the hand's axes at its middle.
    pub hand_velocity: [Vector3<f64>; 2],
    /// `world_from_torso` at its end; the origin is the middle of the torso.
    pub torso: Pose,
    /// `world_from_object` at its end; the origin is the object's centre.
    pub object: Pose,
    /// Wrenches of the gripper and of the hand on the object during it.
    pub grips: [Wrench; 2],
}

#[cfg(test)]
mod tests {
    use super::super::{HumanCommand, PhysicalPlant, convert};
    use super::*;
    use crate::geometry::rotation_vector;
    use crate::robot::InputVector;

    fn scene() -> (World, Robot, PlanarPose) {
        let text = "name = \"w\"\nrobot_width_m = 0.5\nstart_m = [0, 0]\ntarget_m = [9, 0]\n";
        let world = World::parse("w.toml", text).unwrap();
        let team = PlanarPose { position: world.start, yaw: 0.3 };
        (world, Robot::built_in().unwrap(), team)
    }

    #[test]
    fn the_model_is_where_the_plant_is() {
        let (world, robot, team) = scene();
        let (joints, settings) = (robot.postures[0].joints, PhysicsSettings::default());
        let model = PlantModel::new(&world, &robot, &joints, &team, &settings);
        let seen = PhysicalPlant::new(&world, &robot, &joints, &team, &settings, 1).unwrap().observe();
        let apart = |a: &Pose, b: &Pose| {
            let turn = rotation_vector(&(a.rotation.inverse() * b.rotation));
            (a.translation.vector - b.translation.vector).norm() + turn.norm()
        };
        for (modelled, seen) in
            [(model.object, seen.object), (model.hand, seen.hand), (model.torso, seen.torso)]
        {
            assert!(apart(&modelled, &seen) < 1e-12, "{modelled} {seen}");
        }
        assert!((model.start.joints - seen.configuration.joints).norm() < 1e-12);
        assert!((model.start.base.position - seen.configuration.base.position).norm() < 1e-12);
        let (holder, at) = model.holder;
        let mut poses = vec![model.start.base.at_height(0.0)];
        for body in &model.bodies[1..] {
            let joint = body.joint.as_ref().unwrap();
            poses.push(poses[joint.parent] * joint.parent_from_body(joint.start));
        }
        assert!(apart(&(poses[holder] * at), &seen.grasp) < 1e-12);
    }

    /// An object that is twisted about its long axis at rest, one way and the other: the grips' torques differ by
    /// their stiffness times the difference of the angles. The hand's, which is small, is 2.4 % larger here.
    #[test]
    fn closed_form_the_angular_stiffness_of_a_grip_is_that_of_its_torque() {
        let (world, robot, team) = scene();
        let (joints, settings) = (robot.postures[0].joints, PhysicsSettings::default());
        let model = PlantModel::new(&world, &robot, &joints, &team, &settings);
        let along = convert::to_vector(&(model.object.rotation * Vector3::x()));
        let twisted = |torque: f64| {
            let mut plant = PhysicalPlant::new(&world, &robot, &joints, &team, &settings, 1).unwrap();
            plant.world.bodies[plant.object].add_torque(along * torque, true);
            for _ in 0..20 {
                plant.step(&InputVector::zeros(), &HumanCommand::Follow, 0.2);
            }
            let seen = plant.observe();
            [(seen.grasp, seen.grip), (seen.hand, seen.hand_grip)].map(|(holder, forces)| {
                let twist = rotation_vector(&(holder.rotation.inverse() * seen.object.rotation)).x;
                [twist, (holder.rotation.inverse() * forces.last.torque).x]
            })
        };
        let [one, other] = [2.0, -2.0].map(twisted);
        for (i, (grip, near)) in [(model.gripper, 0.002), (model.hand_grip, 0.03)].into_iter().enumerate() {
            let [twist, torque] = [0, 1].map(|k| one[i][k] - other[i][k]);
            let stiffness = -torque / twist;
            assert!((stiffness / grip.angular_stiffness - 1.0).abs() < near, "{stiffness} {grip:?}");
        }
    }
}
