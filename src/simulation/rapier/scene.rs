//! The initial bodies and grips of the physical plant.

use super::accumulator::Accumulator;
use super::articulation::Articulation;
use super::dimensions::{GRAVITY, HAND_RADIUS, TORSO_AHEAD, TORSO_HEIGHT, TORSO_RADIUS};
use super::grip::{Grip, Stiffness};
use super::human::Walker;
use super::parts::{Group, Parts};
use super::{BodyKind, Failure, PhysicsSettings};
use crate::error::{Error, ErrorKind, Place};
use crate::geometry::{PlanarPose, Pose, direction};
use crate::robot::{Configuration, JointVector, Robot};
use crate::simulation::KinematicPlant;
use crate::simulation::convert::{to_matrix, to_rapier};
use crate::world::{CarriedObject, Part, World};
use nalgebra::Matrix3;
use rapier3d::math::Vector;
use rapier3d::parry::query::intersection_test;
use rapier3d::prelude::{
    ColliderBuilder, MassProperties, PhysicsWorld, RigidBodyBuilder, RigidBodyHandle, SharedShape,
};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};

/// Outer iterations of the solver; [`PhysicsSettings::solver_iterations`] are the inner ones.
const SOLVER_ITERATIONS: usize = 1;

/// The physical plant. It owns all its data and can be serialised between two periods.
#[derive(Serialize, Deserialize)]
pub struct PhysicalPlant {
    #[serde(deserialize_with = "bounded_world")]
    pub(super) world: PhysicsWorld,
    #[serde(deserialize_with = "checked_settings")]
    pub(super) settings: PhysicsSettings,
    pub(super) parts: Parts,
    pub(super) robot: Articulation,
    pub(super) object: RigidBodyHandle,
    pub(super) object_name: String,
    /// Half the object's length, and its carrying height, m.
    pub(super) reach: f64,
    pub(super) height: f64,
    pub(super) gripper: Grip,
    pub(super) hand: Grip,
    pub(super) hand_body: RigidBodyHandle,
    pub(super) torso_body: RigidBodyHandle,
    pub(super) human: Walker,
    pub(super) steps: u64,
    /// Physics steps that the control periods so far have asked for beyond those made; at most a half.
    #[serde(default)]
    pub(super) owed: f64,
    pub(super) accumulator: Accumulator,
    pub(super) failure: Option<Failure>,
}

/// A world that was read back, whose steps take no more work than those of a plant can.
fn bounded_world<'de, D: Deserializer<'de>>(from: D) -> Result<PhysicsWorld, D::Error> {
    let world = PhysicsWorld::deserialize(from)?;
    let parameters = &world.integration_parameters;
    let is_bounded = parameters.num_solver_iterations == SOLVER_ITERATIONS
        && parameters.num_internal_pgs_iterations <= PhysicsSettings::MAX_ITERATIONS
        && parameters.num_internal_stabilization_iterations <= PhysicsSettings::MAX_ITERATIONS
        && parameters.max_ccd_substeps == 0
        && world.bodies.iter().all(|(_, body)| body.additional_solver_iterations() == 0);
    is_bounded.then_some(world).ok_or_else(|| D::Error::custom("too many solver iterations"))
}

/// Settings that were read back, within their ranges.
fn checked_settings<'de, D: Deserializer<'de>>(from: D) -> Result<PhysicsSettings, D::Error> {
    let settings = PhysicsSettings::deserialize(from)?;
    settings.check().map(|()| settings).map_err(D::Error::custom)
}

/// The components of a plant.
pub(super) struct Scene<'a> {
    pub world: &'a World,
    pub robot: &'a Robot,
    pub joints: &'a JointVector,
    pub team: &'a PlanarPose,
    pub settings: &'a PhysicsSettings,
    pub seed: u64,
}

/// A team that stands at its start.
pub(super) struct LinedUp {
    pub robot: Configuration,
    /// The hand, at the object's front end.
    pub front: PlanarPose,
}

impl LinedUp {
    /// A team whose object has its centre and heading at `team`, and a length of twice `reach` (m).
    pub fn new(robot: &Robot, joints: &JointVector, team: &PlanarPose, reach: f64) -> Self {
        let along = direction(team.yaw) * reach;
        let rear = PlanarPose { position: team.position - along, yaw: team.yaw };
        let front = PlanarPose { position: team.position + along, yaw: team.yaw };
        Self { robot: *KinematicPlant::place(robot, joints, &rear).configuration(), front }
    }
}

/// Inertia of the object about its centre, kg m^2: that of a homogeneous box.
pub(super) fn object_inertia(object: &CarriedObject) -> Matrix3<f64> {
    let [x, y, z] = object.size;
    let squares = [y * y + z * z, x * x + z * z, x * x + y * y];
    Matrix3::from_diagonal(&nalgebra::Vector3::from(squares)) * (object.mass / 12.0)
}

impl Scene<'_> {
    /// The plant at rest. `None` if rapier does not accept the robot.
    pub fn build(&self) -> Option<PhysicalPlant> {
        let Self { robot, joints, team, settings, .. } = *self;
        let object = &self.world.object;
        let (reach, height) = (object.size[0] / 2.0, robot.grasp_height);
        let LinedUp { robot: start, front } = LinedUp::new(robot, joints, team, reach);

        let mut world = PhysicsWorld::new();
        world.gravity = Vector::new(0.0, 0.0, -GRAVITY);
        let parameters = &mut world.integration_parameters;
        parameters.num_solver_iterations = SOLVER_ITERATIONS;
        parameters.num_internal_pgs_iterations = settings.solver_iterations;
        // no body is fast enough to pass through a wall in one step
        parameters.max_ccd_substeps = 0;
        // reported depths must be current
        parameters.contact_recycling = false;

        let mut parts = Parts::default();
        let articulation = Articulation::new(&mut world, &mut parts, robot, &start, settings)?;
        for obstacle in &self.world.obstacles {
            for (at, shape) in obstacle.parts.iter().map(Part::solid) {
                let shape = ColliderBuilder::new(SharedShape(shape.clone_dyn().into())).position(at);
                parts.add(&mut world, None, shape, &obstacle.name, (BodyKind::Obstacle, Group::Obstacle));
            }
        }

        let [x, y, z] = object.size;
        let inertia = to_matrix(&object_inertia(object));
        let mass = MassProperties::with_inertia_matrix(Vector::ZERO, object.mass, inertia);
        let object_body = world.insert_body(
            RigidBodyBuilder::dynamic()
                .pose(to_rapier(&team.at_height(height)))
                .additional_mass_properties(mass)
                .can_sleep(false),
        );
        let shape = ColliderBuilder::cuboid(x / 2.0, y / 2.0, z / 2.0);
        let name = object.shape.name();
        parts.add(&mut world, Some(object_body), shape, name, (BodyKind::Object, Group::Object));

        let human = Walker::new(front, settings.human, self.seed);
        let mut kinematic = |pose: Pose| {
            world.insert_body(
                RigidBodyBuilder::kinematic_position_based().pose(to_rapier(&pose)).can_sleep(false),
            )
        };
        let hand_body = kinematic(human.hand(height));
        let torso_body = kinematic(human.torso(TORSO_AHEAD, TORSO_HEIGHT / 2.0));
        let shape = ColliderBuilder::ball(HAND_RADIUS);
        parts.add(&mut world, Some(hand_body), shape, "hand", (BodyKind::Human, Group::Hand));
        let shape = ColliderBuilder::capsule_z(TORSO_HEIGHT / 2.0 - TORSO_RADIUS, TORSO_RADIUS);
        parts.add(&mut world, Some(torso_body), shape, "torso", (BodyKind::Human, Group::Torso));

        let load = object.mass / 2.0;
        let end = |x: f64| (object_body, Pose::translation(x, 0.0, 0.0));
        let stiffness = Stiffness::of_gripper(settings.gripper_stiffness);
        let gripper = Grip::new(&mut world, articulation.gripper(), end(-reach), stiffness, load);
        let stiffness = Stiffness::of_hand(settings.human.hand_stiffness);
        let hand = Grip::new(&mut world, (hand_body, Pose::identity()), end(reach), stiffness, load);
        // a step of zero duration moves the colliders to their bodies
        world.integration_parameters.dt = 0.0;
        world.step();
        world.integration_parameters.dt = settings.step();
        Some(PhysicalPlant {
            world,
            settings: *settings,
            parts,
            robot: articulation,
            object: object_body,
            object_name: name.to_owned(),
            reach,
            height,
            gripper,
            hand,
            hand_body,
            torso_body,
            human,
            steps: 0,
            owed: 0.0,
            accumulator: Accumulator::default(),
            failure: None,
        })
    }
}

impl PhysicalPlant {
    /// Refuses a start inside an obstacle.
    pub(super) fn check_start(&self, world: &World, team: &PlanarPose) -> Result<(), Error> {
        let name = |c| self.parts.part(Parts::number(c)).map_or(String::new(), |p| p.name.clone());
        for kind in [BodyKind::Robot, BodyKind::Object, BodyKind::Human] {
            for own in self.parts.of(&self.world, kind) {
                for obstacle in self.parts.of(&self.world, BodyKind::Obstacle) {
                    let meets =
                        intersection_test(own.position(), own.shape(), obstacle.position(), obstacle.shape());
                    if meets.is_ok_and(|m| m.intersecting) {
                        let (part, own, obstacle) = (kind.name(), name(own), name(obstacle));
                        let (x, y) = (team.position.x, team.position.y);
                        let sentence = format_args!(
                            "at the start, the {part} `{own}` is inside obstacle `{obstacle}`; the team is 2 to 3 m long, with the human ahead of ({x}, {y})"
                        );
                        return Err(Error::at(Place::file(&world.file), sentence).of_kind(ErrorKind::World));
                    }
                }
            }
        }
        Ok(())
    }
}
