//! Contacts of a robot with itself: parts of its arm that touch each other or the base.

use super::collision::bodies;
use super::link::{Geometry, Shape};
use super::{Configuration, JointVector, Robot};
use crate::geometry::{PlanarPose, Point, Pose};
use nalgebra::{Point3, Rotation3, UnitQuaternion};
use parry3d::math;
use parry3d::query::contact;
use parry3d::shape::SharedShape;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::f64::consts::FRAC_PI_2;

/// How deep two bodies have to be in each other to count as touching, m: the convex hulls are larger than the
/// meshes that they stand for.
const DEPTH_M: f64 = 0.01;
/// Random configurations for which pairs are tried, and the share of them in which a pair that touches by
/// design does so at least.
const SAMPLES: usize = 40;
const BY_DESIGN: f64 = 0.5;
/// Two joints nearer to each other, m, are a wrist: of the links on either side of it, that share is smaller.
const WRIST_M: f64 = 0.06;
const BY_DESIGN_AT_WRIST: f64 = 0.15;

/// The pairs of a robot's bodies that can touch each other and should not. A body is the links that move as
/// one.
///
/// Neighbours in the chain are left out, because they touch by design, and so are pairs that touch in half of
/// all random configurations, or in 15 % where nothing but a wrist is between them: hulls fill the hollows of a
/// wrist's links.
#[derive(Clone, Debug, Default)]
pub(crate) struct SelfContacts {
    bodies: Vec<Body>,
    pairs: Vec<[usize; 2]>,
}

/// Links that move as one.
#[derive(Clone, Debug)]
struct Body {
    /// The link that a joint moves, or the base: index into [`Robot::links`].
    link: usize,
    /// The body that carries it, and the joint's frame in it; `None` for the base.
    parent: Option<(usize, Pose)>,
    shapes: Vec<Solid>,
    /// Around all shapes; its radius is negative without shapes.
    ball: Ball,
}

/// A convex shape of a body.
#[derive(Clone, Debug)]
struct Solid {
    body_from_shape: math::Pose,
    shape: SharedShape,
    ball: Ball,
}

/// A ball that holds a shape: two shapes can be no deeper in each other than their balls.
#[derive(Clone, Copy, Debug)]
struct Ball {
    /// Centre in the body's frame, m.
    center: Point3<f64>,
    /// Radius, m.
    radius: f64,
}

impl Ball {
    fn may_touch(&self, at: &Pose, other: &Self, other_at: &Pose) -> bool {
        let near = self.radius + other.radius - DEPTH_M;
        let between = other_at * other.center - at * self.center;
        between.norm_squared() < near * near
    }
}

impl SelfContacts {
    /// The pairs of a robot whose joints, links and limits are known.
    pub fn new(robot: &Robot) -> Self {
        let bodies = found(robot);
        let is_solid = |i: usize| !bodies[i].shapes.is_empty();
        // the nearest body with shapes that carries it
        let carrier = |i: usize| {
            let parents =
                std::iter::successors(bodies[i].parent.as_ref(), |(at, _)| bodies[*at].parent.as_ref());
            parents.map(|(at, _)| *at).find(|&at| is_solid(at))
        };
        let solid: Vec<usize> = (0..bodies.len()).filter(|&i| is_solid(i)).collect();
        let mut pairs = Vec::new();
        for (n, &b) in solid.iter().enumerate() {
            let others = solid[..n].iter().filter(|&&a| carrier(b) != Some(a) && carrier(a) != Some(b));
            pairs.extend(others.map(|&a| [a, b]));
        }
        let mut contacts = Self { bodies, pairs };
        contacts.leave_out_by_design(robot);
        contacts
    }

    fn leave_out_by_design(&mut self, robot: &Robot) {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut poses = Vec::new();
        let mut touched = vec![0usize; self.pairs.len()];
        for _ in 0..SAMPLES {
            let joints = robot.random_joints(&mut rng);
            self.place(robot, &joints, &mut poses);
            for (count, pair) in touched.iter_mut().zip(&self.pairs) {
                *count += usize::from(self.touch(*pair, &poses));
            }
        }
        let is_wrist = |[a, b]: [usize; 2]| self.is_wrist(a, b) || self.is_wrist(b, a);
        let shares =
            self.pairs.iter().map(|pair| if is_wrist(*pair) { BY_DESIGN_AT_WRIST } else { BY_DESIGN });
        let most: Vec<f64> = shares.map(|share| share * SAMPLES as f64).collect();
        let mut is_kept = touched.into_iter().zip(most).map(|(count, most)| (count as f64) < most);
        self.pairs.retain(|_| is_kept.next().unwrap_or(true));
    }

    /// Whether there is a wrist between two bodies: one body whose own joint is near that of `b` on it.
    fn is_wrist(&self, a: usize, b: usize) -> bool {
        let Some((between, frame)) = &self.bodies[b].parent else { return false };
        let carrier = self.bodies[*between].parent.as_ref().map(|(carrier, _)| *carrier);
        carrier == Some(a) && frame.translation.vector.norm() < WRIST_M
    }

    /// The poses of all bodies in the frame of the base link.
    fn place(&self, robot: &Robot, joints: &JointVector, poses: &mut Vec<Pose>) {
        poses.clear();
        for body in &self.bodies {
            let pose = match (&body.parent, &robot.links[body.link].joint) {
                (Some((parent, parent_from_frame)), Some(joint)) => {
                    let coupling = joint.coupling;
                    let position =
                        coupling.joint.map_or(0.0, |j| coupling.ratio * joints[j]) + coupling.offset;
                    poses[*parent] * parent_from_frame * joint.parent_from_link(position)
                }
                _ => Pose::identity(),
            };
            poses.push(pose);
        }
    }

    fn touch(&self, [a, b]: [usize; 2], poses: &[Pose]) -> bool {
        let (first, second) = (&self.bodies[a], &self.bodies[b]);
        let [at_first, at_second] = [&poses[a], &poses[b]];
        if !first.ball.may_touch(at_first, &second.ball, at_second) {
            return false;
        }
        let (from_first, from_second) = (to_parry(at_first), to_parry(at_second));
        first.shapes.iter().any(|one| {
            second.shapes.iter().any(|other| {
                if !one.ball.may_touch(at_first, &other.ball, at_second) {
                    return false;
                }
                let (at, other_at) = (from_first * one.body_from_shape, from_second * other.body_from_shape);
                // parry has contacts of all convex shapes
                let found = contact(&at, &*one.shape, &other_at, &*other.shape, 0.0);
                found.ok().flatten().is_some_and(|contact| contact.dist < -DEPTH_M)
            })
        })
    }

    /// The first pair of bodies that touch.
    pub fn first(&self, robot: &Robot, joints: &JointVector, poses: &mut Vec<Pose>) -> Option<[usize; 2]> {
        self.place(robot, joints, poses);
        let pair = self.pairs.iter().find(|pair| self.touch(**pair, poses))?;
        Some(pair.map(|i| self.bodies[i].link))
    }
}

impl Robot {
    /// Two links of the robot that touch each other with these joint positions, by more than a centimetre:
    /// indices into [`Robot::links`]. Links that do not move relative to each other, neighbours in the chain,
    /// and links that touch in half of all configurations (with a wrist between them, in 15 %) do not count.
    /// Meshes are their convex hulls.
    /// `poses` is memory for the calculation, kept between calls.
    pub fn self_contact(&self, joints: &JointVector, poses: &mut Vec<Pose>) -> Option<[usize; 2]> {
        self.self_contacts.first(self, joints, poses)
    }
}

/// The bodies with their shapes, parents before children.
fn found(robot: &Robot) -> Vec<Body> {
    let base = PlanarPose { position: Point::origin(), yaw: 0.0 };
    let rest = robot.link_poses(&Configuration { base, joints: JointVector::zeros() });
    let body_of = bodies(robot);
    let own: Vec<usize> =
        (0..robot.links.len()).filter(|&i| body_of[i] == i || i == robot.base_link).collect();
    // the base first: links that stand above it in the URDF are part of it
    let order: Vec<usize> =
        std::iter::once(robot.base_link).chain(own.into_iter().filter(|&i| i != robot.base_link)).collect();
    order
        .iter()
        .map(|&link| {
            let parent = robot.links[link].parent.filter(|_| link != robot.base_link).and_then(|above| {
                let carrier = order.iter().position(|&body| body == body_of[above])?;
                Some((carrier, rest[body_of[above]].inverse() * rest[above]))
            });
            let members = (0..robot.links.len()).filter(|&i| body_of[i] == link);
            let shapes: Vec<Solid> = members
                .flat_map(|i| robot.links[i].collisions.iter().map(move |geometry| (i, geometry)))
                .filter_map(|(i, geometry)| {
                    solid(&(rest[link].inverse() * rest[i] * geometry.link_from_shape), geometry)
                })
                .collect();
            let boxes = shapes.iter().map(|solid| solid.shape.compute_aabb(&solid.body_from_shape));
            let whole = boxes.reduce(|a, b| parry3d::bounding_volume::BoundingVolume::merged(&a, &b));
            let ball = whole.map_or(Ball { center: Point3::origin(), radius: -1.0 }, |whole| Ball {
                center: from_parry(whole.center()),
                radius: whole.half_extents().length(),
            });
            Body { link, parent, shapes, ball }
        })
        .collect()
}

/// A shape for parry; `None` for a mesh without a hull.
fn solid(body_from_shape: &Pose, geometry: &Geometry) -> Option<Solid> {
    // parry's cylinders are aligned with y
    let upright = Pose::from_parts(
        Default::default(),
        Rotation3::from_axis_angle(&nalgebra::Vector3::x_axis(), FRAC_PI_2),
    );
    let (shape, at) = match &geometry.shape {
        Shape::Box { size } => {
            (SharedShape::cuboid(size.x / 2.0, size.y / 2.0, size.z / 2.0), *body_from_shape)
        }
        Shape::Cylinder { radius, length } => {
            (SharedShape::cylinder(length / 2.0, *radius), body_from_shape * upright)
        }
        Shape::Capsule { radius, length } => {
            (SharedShape::capsule_z(length / 2.0, *radius), *body_from_shape)
        }
        Shape::Sphere { radius } => (SharedShape::ball(*radius), *body_from_shape),
        Shape::Mesh { hull, .. } => {
            let points: Vec<_> = hull.iter().map(|p| math::Vector::new(p.x, p.y, p.z)).collect();
            let hull = if points.len() < 4 { None } else { SharedShape::convex_hull(&points) };
            (hull?, *body_from_shape)
        }
    };
    let body_from_shape = to_parry(&at);
    let sphere = shape.compute_bounding_sphere(&body_from_shape);
    let ball = Ball { center: from_parry(sphere.center), radius: sphere.radius };
    Some(Solid { body_from_shape, shape, ball })
}

fn from_parry(point: math::Vector) -> Point3<f64> {
    Point3::new(point.x, point.y, point.z)
}

fn to_parry(pose: &Pose) -> math::Pose {
    let turn = UnitQuaternion::from_rotation_matrix(&pose.rotation);
    let at = pose.translation.vector;
    math::Pose::from_parts(
        math::Vector::new(at.x, at.y, at.z),
        math::Rotation::from_xyzw(turn.i, turn.j, turn.k, turn.w),
    )
}
