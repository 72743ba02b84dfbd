//! A scenario's bodies as MuJoCo's MJCF: robot, object, grips, hand, torso and obstacles, and a keyframe of the
//! start.
//!
//! Collision shapes are primitives and convex hulls, with their vertices in the file; visual meshes are left
//! out.

mod actuators;
mod text;

use crate::xml::escaped;
use actuators::{controls, gears, gripper};
use cocarry::geometry::Pose;
use cocarry::robot::{Geometry, Robot, Shape};
use cocarry::simulation::{ContactGroup, HAND_RADIUS, JointModel, PlantModel, TORSO_HEIGHT, TORSO_RADIUS};
use cocarry::world::{Part, World};
use nalgebra::{Matrix3, Quaternion, Rotation3, SymmetricEigen, Translation3, UnitQuaternion, Vector3};
use text::{Names, for_comment, number, numbers, placed, quaternion, vector};

/// Timestep of the file, s. MuJoCo keeps forces between kinematic trees, such as those of the hand's grip,
/// explicit: at 2 ms a grip's force is several per cent off.
const TIMESTEP: f64 = 0.0005;
/// The end of the object that the hand holds.
const FRONT: &str = "front";
/// The keyframe of the start.
const START: &str = "start";
const AXES: [&str; 3] = ["x", "y", "z"];

/// What the file cannot express.
const MISSING: [&str; 8] = [
    "the human's motion and gait: hand and torso are mocap bodies, and ctrl of the hand's motors is the hand's velocity",
    "the ramp of rates within a control period, and the wheels' limits of acceleration",
    "that two driven sides cannot move sideways: ctrl of base_x and base_y is in world axes",
    "that the reference of an arm joint stays within 0.02 rad or m of it: ctrl is a position",
    "steps that are made again until motors keep their limits: forcerange limits them here",
    "the limits of the gripper's torques",
    "contacts of hand and torso with obstacles: MuJoCo leaves out contacts between bodies that do not move",
    "the hardness of contacts, and when the object counts as dropped or lost",
];

/// A scene to be written.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// Name.
    pub name: &'a str,
    /// The world, for its obstacles and object.
    pub world: &'a World,
    /// The robot, for its names and shapes.
    pub robot: &'a Robot,
    /// The bodies at the start.
    pub model: &'a PlantModel,
}

/// An MJCF file.
#[derive(Clone, Debug)]
pub struct Mjcf {
    /// Its text.
    pub text: String,
    /// Names of the actuators that take a control, in the order of `ctrl`: base, arm, hand.
    pub controls: Vec<String>,
    /// What differs in this scene, and is said in the file too: sentences without a full stop.
    pub notes: Vec<String>,
}

/// Writes a scene as MJCF. The units are those of MuJoCo: SI and radians.
pub fn mjcf(scene: &Scene) -> Mjcf {
    let Scene { robot, model, .. } = *scene;
    let (mut links, mut joints) = (Names::default(), Names::default());
    let joint_name = |link: usize| robot.links[link].joint.as_ref().map_or("", |joint| &joint.name);
    let writer = Writer {
        scene: *scene,
        links: robot.links.iter().map(|link| links.unique("robot/", &link.name)).collect(),
        joints: model.bodies.iter().map(|body| joints.unique("robot/", joint_name(body.link))).collect(),
        geoms: Names::default(),
        meshes: Vec::new(),
        bodies: String::new(),
        start: Vec::new(),
        notes: Vec::new(),
    };
    writer.write()
}

struct Writer<'a> {
    scene: Scene<'a>,
    /// Names of the robot's links.
    links: Vec<String>,
    /// Names of the bodies' joints; the base's is used by none.
    joints: Vec<String>,
    /// Names of geoms so far.
    geoms: Names,
    /// Vertices of meshes so far.
    meshes: Vec<Vec<Vector3<f64>>>,
    /// The elements of the world's body so far.
    bodies: String,
    /// `qpos` at the start so far.
    start: Vec<f64>,
    notes: Vec<String>,
}

impl Writer<'_> {
    fn write(mut self) -> Mjcf {
        let Scene { name, world, robot, model } = self.scene;
        for obstacle in &world.obstacles {
            for part in &obstacle.parts {
                self.add_obstacle(&obstacle.name, part);
            }
        }
        self.add_body(0, 2);
        self.add_human();

        let controls = controls(model, robot.joints.len(), &self.joints);
        let ctrl: Vec<f64> = controls.iter().map(|control| control.start).chain([0.0; 3]).collect();
        let mut missing: Vec<String> = MISSING.map(str::to_owned).into();
        let [force, _, torque] = model.base_limits;
        missing.push(format!(
            "the limits of the base's motors, {force} N and {torque} Nm: as forcerange they make such stiff motors chatter at this timestep"
        ));
        if model.bodies.iter().any(|body| body.joint.as_ref().is_some_and(|joint| joint.mimics.is_some())) {
            self.notes.push("that a gear loads only the joint that follows: here it loads both".to_owned());
        }
        missing.extend(self.notes.iter().cloned());

        let mut text = String::from("<!--\n");
        let title = format!("{} with {}, written by cocarry {}", name, robot.name, env!("CARGO_PKG_VERSION"));
        text += &format!("  {}\n", for_comment(&title));
        text += "  Units: m, kg, s, rad. Mesh files are left out; hulls are as they collide. The robot's weight is compensated.\n";
        text += "  Not in this file:\n";
        text += &missing.iter().map(|note| format!("  * {}\n", for_comment(note))).collect::<String>();
        text += "-->\n";
        text += &format!("<mujoco model=\"{}\">\n", escaped(name));
        text += "  <compiler angle=\"radian\" autolimits=\"true\"/>\n";
        text += &format!(
            "  <option timestep=\"{TIMESTEP}\" integrator=\"implicitfast\" gravity=\"0 0 {}\"/>\n",
            number(-model.gravity)
        );
        text += "  <default>\n";
        text += &format!("    <geom condim=\"3\" friction=\"{} 0 0\"/>\n", number(model.friction));
        for (group, class, colour) in CLASSES {
            let [own, others] = group.bits();
            text += &format!(
                "    <default class=\"{class}\"><geom contype=\"{own}\" conaffinity=\"{others}\" rgba=\"{colour}\"/></default>\n"
            );
        }
        text += "  </default>\n";
        if !self.meshes.is_empty() {
            text += "  <asset>\n";
            for (i, vertices) in self.meshes.iter().enumerate() {
                let vertices: Vec<String> = vertices.iter().map(vector).collect();
                text += &format!("    <mesh name=\"hull {i}\" vertex=\"{}\"/>\n", vertices.join("  "));
            }
            text += "  </asset>\n";
        }
        text += "  <worldbody>\n";
        text += "    <light pos=\"0 0 10\" dir=\"0 0 -1\" directional=\"true\"/>\n";
        // for the eye alone: nothing falls onto it
        text += "    <geom name=\"floor\" type=\"plane\" size=\"0 0 1\" contype=\"0\" conaffinity=\"0\" rgba=\"0.9 0.9 0.9 1\"/>\n";
        text += &self.bodies;
        text += "  </worldbody>\n";
        text += &gears(&model.bodies, &self.joints);
        text += "  <actuator>\n";
        text += &controls.iter().map(|control| control.text.as_str()).collect::<String>();
        text += &gripper(&model.gripper);
        text += "  </actuator>\n";
        text += "  <keyframe>\n";
        let mocap = [&model.hand, &model.torso];
        let places: Vec<String> = mocap.iter().map(|pose| vector(&pose.translation.vector)).collect();
        let turns: Vec<String> = mocap.iter().map(|pose| quaternion(pose)).collect();
        text += &format!(
            "    <key name=\"{START}\" qpos=\"{}\" ctrl=\"{}\" mpos=\"{}\" mquat=\"{}\"/>\n",
            numbers(&self.start),
            numbers(&ctrl),
            places.join("  "),
            turns.join("  ")
        );
        text += "  </keyframe>\n</mujoco>\n";
        Mjcf { text, controls: controls.into_iter().map(|control| control.name).collect(), notes: self.notes }
    }

    /// Adds one part of an obstacle.
    fn add_obstacle(&mut self, name: &str, part: &Part) {
        let (at, solid) = part.solid();
        let (place, turn) = (at.translation, at.rotation);
        let turn = UnitQuaternion::from_quaternion(Quaternion::new(turn.w, turn.x, turn.y, turn.z));
        let place = Translation3::new(place.x, place.y, place.z);
        let mut pose = Pose::from_parts(place, turn.to_rotation_matrix());
        let shape = if let Some(solid) = solid.as_cuboid() {
            let half = solid.half_extents;
            format!("type=\"box\" size=\"{}\"", numbers(&[half.x, half.y, half.z]))
        } else if let Some(solid) = solid.as_cylinder() {
            // MuJoCo's cylinder is aligned with z: the solid's y, which is upright
            pose.rotation = Rotation3::identity();
            format!("type=\"cylinder\" size=\"{}\"", numbers(&[solid.radius, solid.half_height]))
        } else if let Some(solid) = solid.as_convex_polyhedron() {
            let vertices = solid.points().iter().map(|p| Vector3::new(p.x, p.y, p.z)).collect();
            self.mesh(vertices)
        } else {
            self.notes.push(format!("obstacle {name}, whose shape MuJoCo does not have"));
            return;
        };
        self.add_geom(2, ContactGroup::Obstacle, ("obstacle/", name), &shape, &pose);
    }

    /// A hull as an attribute of a geom.
    fn mesh(&mut self, vertices: Vec<Vector3<f64>>) -> String {
        self.meshes.push(vertices);
        format!("type=\"mesh\" mesh=\"hull {}\"", self.meshes.len() - 1)
    }

    fn add_geom(
        &mut self,
        depth: usize,
        group: ContactGroup,
        (prefix, name): (&str, &str),
        shape: &str,
        pose: &Pose,
    ) {
        let name = self.geoms.unique(prefix, name);
        let class = class(group);
        self.bodies += &format!(
            "{:depth$}<geom class=\"{class}\" name=\"{}\" {shape} {}/>\n",
            "",
            escaped(&name),
            placed(pose),
            depth = 2 * depth
        );
    }

    /// Adds a body of the robot with all below it.
    fn add_body(&mut self, i: usize, depth: usize) {
        let Scene { robot, model, .. } = self.scene;
        let body = &model.bodies[i];
        let (name, blank) = (&self.links[body.link], " ".repeat(2 * depth));
        let pose = body.joint.as_ref().map_or(Pose::identity(), |joint| joint.parent_from_joint);
        let mut text = format!("{blank}<body name=\"{}\" {} gravcomp=\"1\">\n", escaped(name), placed(&pose));
        let (inertia, raised) = acceptable(&body.inertia);
        if raised > 0.0 {
            self.notes.push(format!(
                "the inertia of link {}, which no body can have: two of its moments are raised by {raised:.3e} kg m^2",
                robot.links[body.link].name
            ));
        }
        let entries = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|at| inertia[at]);
        text += &format!(
            "{blank}  <inertial pos=\"{}\" mass=\"{}\" fullinertia=\"{}\"/>\n",
            vector(&body.center),
            number(body.mass),
            numbers(&entries)
        );
        match &body.joint {
            None => {
                let base = model.start.base;
                for (axis, kind, along) in
                    [("x", "slide", "1 0 0"), ("y", "slide", "0 1 0"), ("yaw", "hinge", "0 0 1")]
                {
                    text +=
                        &format!("{blank}  <joint name=\"base_{axis}\" type=\"{kind}\" axis=\"{along}\"/>\n");
                }
                self.start.extend([base.position.x, base.position.y, base.yaw]);
            }
            Some(joint) => {
                text += &format!("{blank}  {}\n", joint_element(joint, &self.joints[i]));
                self.start.push(joint.start);
            }
        }
        self.bodies += &text;
        let group = if i == 0 { ContactGroup::Base } else { ContactGroup::Arm };
        for (link, body_from_link) in &body.links {
            let link = &robot.links[*link];
            for geometry in &link.collisions {
                let pose = body_from_link * geometry.link_from_shape;
                if let Some(shape) = self.shape(geometry) {
                    self.add_geom(depth + 1, group, ("robot/", &link.name), &shape, &pose);
                }
            }
        }
        if model.holder.0 == i {
            self.add_object(depth + 1);
        }
        for (child, other) in model.bodies.iter().enumerate() {
            if other.joint.as_ref().is_some_and(|joint| joint.parent == i) {
                self.add_body(child, depth + 1);
            }
        }
        self.bodies += &format!("{blank}</body>\n");
    }

    /// The shape of a geom; `None` of a mesh without a hull, which collides nowhere.
    fn shape(&mut self, geometry: &Geometry) -> Option<String> {
        Some(match &geometry.shape {
            Shape::Box { size } => format!("type=\"box\" size=\"{}\"", vector(&(size / 2.0))),
            Shape::Cylinder { radius, length } => {
                format!("type=\"cylinder\" size=\"{}\"", numbers(&[*radius, length / 2.0]))
            }
            Shape::Capsule { radius, length } => {
                format!("type=\"capsule\" size=\"{}\"", numbers(&[*radius, length / 2.0]))
            }
            Shape::Sphere { radius } => format!("type=\"sphere\" size=\"{}\"", number(*radius)),
            Shape::Mesh { hull, .. } => {
                // fewer span no volume
                let hull = Some(hull).filter(|hull| hull.len() > 3)?;
                self.mesh(hull.clone())
            }
        })
    }

    /// Adds the object, a child of the body that holds it. Its origin is its rear end, where it turns.
    fn add_object(&mut self, depth: usize) {
        let Scene { world, model, .. } = self.scene;
        let (length, grip) = (world.object.size[0], &model.gripper);
        let blank = " ".repeat(2 * depth);
        let world_from_rear = model.object * Translation3::new(-length / 2.0, 0.0, 0.0);
        let grasp_from_rear = self.grasp().inverse() * world_from_rear;
        let (place, turn) = (
            grasp_from_rear.translation.vector,
            UnitQuaternion::from_rotation_matrix(&grasp_from_rear.rotation),
        );
        self.start.extend([place.x, place.y, place.z, turn.w, turn.i, turn.j, turn.k]);
        let grasp = placed(&model.holder.1);
        let mut text =
            format!("{blank}<site name=\"grasp\" {grasp}/>\n{blank}<body name=\"object\" {grasp}>\n");
        let (inertia, _) = acceptable(&model.object_inertia);
        text += &format!(
            "{blank}  <inertial pos=\"{} 0 0\" mass=\"{}\" diaginertia=\"{}\"/>\n",
            number(length / 2.0),
            number(world.object.mass),
            vector(&inertia.diagonal())
        );
        for (axis, along) in AXES.into_iter().zip(["1 0 0", "0 1 0", "0 0 1"]) {
            text += &format!("{blank}  <joint name=\"grip_{axis}\" type=\"slide\" axis=\"{along}\"/>\n");
        }
        text += &format!(
            "{blank}  <joint name=\"grip_turn\" type=\"ball\" stiffness=\"{}\" damping=\"{}\"/>\n",
            number(grip.angular_stiffness),
            number(grip.angular_damping)
        );
        self.bodies += &text;
        let half = Vector3::from(world.object.size) / 2.0;
        let shape = format!("type=\"box\" size=\"{}\"", vector(&half));
        let middle = Pose::translation(length / 2.0, 0.0, 0.0);
        self.add_geom(depth + 1, ContactGroup::Object, ("", "object"), &shape, &middle);
        self.bodies +=
            &format!("{blank}  <site name=\"{FRONT}\" pos=\"{} 0 0\"/>\n{blank}</body>\n", number(length));
    }

    /// `world_from_grasp` at the start.
    fn grasp(&self) -> Pose {
        let Scene { model, .. } = self.scene;
        let mut poses: Vec<Pose> = Vec::with_capacity(model.bodies.len());
        for body in &model.bodies {
            poses.push(match &body.joint {
                None => model.start.base.at_height(0.0),
                Some(joint) => poses[joint.parent] * joint.parent_from_body(joint.start),
            });
        }
        let (holder, holder_from_grasp) = model.holder;
        poses[holder] * holder_from_grasp
    }

    /// Adds hand and torso.
    fn add_human(&mut self) {
        let model = self.scene.model;
        let hand = format!("type=\"sphere\" size=\"{}\"", number(HAND_RADIUS));
        let half = TORSO_HEIGHT / 2.0 - TORSO_RADIUS;
        let torso = format!("type=\"capsule\" size=\"{}\"", numbers(&[TORSO_RADIUS, half]));
        let bodies = [
            (ContactGroup::Hand, "hand", hand, &model.hand, "      <site name=\"hand\"/>\n"),
            (ContactGroup::Torso, "torso", torso, &model.torso, ""),
        ];
        for (group, name, shape, pose, site) in bodies {
            self.bodies += &format!("    <body name=\"{name}\" mocap=\"true\" {}>\n", placed(pose));
            self.add_geom(3, group, ("", name), &shape, &Pose::identity());
            self.bodies += site;
            self.bodies += "    </body>\n";
        }
    }
}

/// The class of every group of shapes, with its colour.
const CLASSES: [(ContactGroup, &str, &str); 6] = [
    (ContactGroup::Base, "base", "0.35 0.38 0.42 1"),
    (ContactGroup::Arm, "arm", "0.55 0.58 0.62 1"),
    (ContactGroup::Object, "object", "0.9 0.62 0 1"),
    (ContactGroup::Torso, "torso", "0 0.45 0.7 1"),
    (ContactGroup::Hand, "hand", "0 0.45 0.7 1"),
    (ContactGroup::Obstacle, "obstacle", "0.75 0.75 0.75 1"),
];

fn class(group: ContactGroup) -> &'static str {
    CLASSES.iter().find(|(known, _, _)| *known == group).map_or("obstacle", |(_, class, _)| class)
}

fn joint_element(joint: &JointModel, name: &str) -> String {
    let kind = if joint.slides { "slide" } else { "hinge" };
    let range = joint.stops.map(|stops| format!(" range=\"{}\"", numbers(&stops))).unwrap_or_default();
    format!("<joint name=\"{}\" type=\"{kind}\" axis=\"{}\"{range}/>", escaped(name), vector(&joint.axis))
}

/// An inertia that MuJoCo accepts, whose largest moment is at most the sum of the others: the smaller two are
/// raised by the same amount, which is returned, kg m^2.
fn acceptable(inertia: &Matrix3<f64>) -> (Matrix3<f64>, f64) {
    let eigen = SymmetricEigen::new(*inertia);
    let (moments, most) = (eigen.eigenvalues, eigen.eigenvalues.imax());
    let lacking = 2.0 * moments[most] - moments.sum();
    if lacking <= 0.0 {
        return (*inertia, 0.0);
    }
    let raised = lacking / 2.0 + 1e-9 * moments[most];
    let axis = eigen.eigenvectors.column(most);
    let others = Matrix3::identity() - axis * axis.transpose();
    // of a flat body, not worth a word
    let is_rounding = lacking < 1e-9 * moments[most];
    (inertia + others * raised, if is_rounding { 0.0 } else { raised })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_an_inertia_that_no_body_has_is_raised_to_the_next_one_that_a_body_has() {
        let (inertia, raised) = acceptable(&Matrix3::from_diagonal(&Vector3::new(1.0, 4.0, 2.0)));
        let moments = inertia.diagonal();
        assert!((raised - 0.5).abs() < 1e-8 && (moments - Vector3::new(1.5, 4.0, 2.5)).norm() < 1e-7);
        assert!(moments[0] + moments[2] >= moments[1]);
        let flat = Matrix3::from_diagonal(&Vector3::new(1.0, 3.0, 2.0));
        let (same, raised) = acceptable(&flat);
        assert!(raised == 0.0 && (same - flat).norm() < 1e-8, "{same}");
    }
}
