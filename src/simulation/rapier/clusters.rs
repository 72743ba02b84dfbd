//! The rigid clusters of a robot's links, each with its mass and inertia.
//!
//! Everything that does not move relative to its parent is merged into it: fixed joints, the wheels (their
//! spin is only displayed), and joints that stay where they are, such as the gripper's. Fewer bodies make a
//! faster step and change nothing else.

use crate::geometry::{PlanarPose, Pose};
use crate::robot::{Configuration, Inertial, Joint, JointVector, Robot};
use nalgebra::{Matrix3, Vector3};

/// Links that move as one body. The first cluster is the base, whose frame is the drive's. The frame of any
/// other cluster is that of its first link.
pub(super) struct Cluster {
    /// The first link: index into [`Robot::links`]; for the base, the base link.
    pub link: usize,
    /// The parent cluster and the joint's frame in it at position 0; `None` for the base.
    pub parent: Option<(usize, Pose)>,
    /// The links with their poses in the cluster.
    pub links: Vec<(usize, Pose)>,
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass, m.
    pub center: Vector3<f64>,
    /// Inertia about the centre of mass, kg m^2.
    pub inertia: Matrix3<f64>,
}

/// Mass and inertia of a moving link without any, because the equations of motion need them.
const MIN_MASS: f64 = 0.01;
const MIN_INERTIA: f64 = 1e-5;

/// The joint that moves a link, and its arm joint, if the arm moves it.
pub(super) fn moving(robot: &Robot, link: usize) -> Option<(&Joint, usize)> {
    let joint = robot.links[link].joint.as_ref()?;
    joint.coupling.joint.map(|driver| (joint, driver))
}

/// The clusters, parents before children.
pub(super) fn clusters(robot: &Robot) -> Vec<Cluster> {
    let at_origin = PlanarPose { position: Default::default(), yaw: 0.0 };
    let at_rest = robot.link_poses(&Configuration { base: at_origin, joints: JointVector::zeros() });
    let mut found = vec![Cluster::new(robot.base_link, None)];
    // for every link, its cluster and its pose in the cluster
    let mut place: Vec<(usize, Pose)> = Vec::with_capacity(robot.links.len());
    for (i, link) in robot.links.iter().enumerate() {
        let within = match (link.parent, &link.joint) {
            (Some(parent), Some(joint)) => {
                let (cluster, cluster_from_parent) = place[parent];
                if moving(robot, i).is_some() {
                    let joint = cluster_from_parent * joint.parent_from_joint;
                    found.push(Cluster::new(i, Some((cluster, joint))));
                    (found.len() - 1, Pose::identity())
                } else if cluster == 0 {
                    // all of these are fixed in the drive's frame
                    (0, at_rest[i])
                } else {
                    (cluster, cluster_from_parent * joint.parent_from_link(joint.coupling.offset))
                }
            }
            _ => (0, at_rest[i]),
        };
        place.push(within);
        found[within.0].links.push((i, within.1));
    }
    for cluster in &mut found {
        cluster.weigh(robot);
    }
    found
}

impl Cluster {
    fn new(link: usize, parent: Option<(usize, Pose)>) -> Self {
        let (center, inertia) = (Vector3::zeros(), Matrix3::zeros());
        Self { link, parent, links: Vec::new(), mass: 0.0, center, inertia }
    }

    fn weigh(&mut self, robot: &Robot) {
        let bodies: Vec<(Inertial, Pose)> = self
            .links
            .iter()
            .filter_map(|&(i, cluster_from_link)| {
                let inertial = robot.links[i].inertial?;
                Some((inertial, cluster_from_link * inertial.center))
            })
            .collect();
        self.mass = bodies.iter().map(|(b, _)| b.mass).sum();
        if self.mass > 0.0 {
            let moment: Vector3<f64> = bodies.iter().map(|(b, at)| at.translation.vector * b.mass).sum();
            self.center = moment / self.mass;
        }
        for (body, at) in &bodies {
            let turn = at.rotation.matrix();
            let offset = at.translation.vector - self.center;
            let shift = Matrix3::identity() * offset.norm_squared() - offset * offset.transpose();
            self.inertia += turn * body.inertia * turn.transpose() + shift * body.mass;
        }
        self.mass = self.mass.max(MIN_MASS);
        self.inertia += Matrix3::identity() * MIN_INERTIA;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_the_carrier_is_eight_bodies_of_its_mass() {
        let robot = Robot::built_in().unwrap();
        let found = clusters(&robot);
        assert_eq!(found.len(), 8);
        assert_eq!(found.iter().map(|c| c.links.len()).sum::<usize>(), robot.links.len());
        let mass: f64 = robot.links.iter().filter_map(|l| l.inertial).map(|i| i.mass).sum();
        assert!((found.iter().map(|c| c.mass).sum::<f64>() - mass).abs() < 1e-9);
        // base, two wheels, two casters and the torso: centre of mass and inertia by hand
        let base = &found[0];
        let parts = [
            (66.0, Vector3::new(0.0, 0.0, 0.21), 2.0625),
            (1.8, Vector3::new(0.0, 0.187, 0.06), 0.00186),
            (1.8, Vector3::new(0.0, -0.187, 0.06), 0.00186),
            (0.2, Vector3::new(0.19, 0.0, 0.03), 7.2e-5),
            (0.2, Vector3::new(-0.19, 0.0, 0.03), 7.2e-5),
            (13.0, Vector3::new(-0.087, 0.0, 0.707), 0.125233),
        ];
        let center: Vector3<f64> = parts.iter().map(|(m, at, _)| at * *m).sum::<Vector3<f64>>() / 83.0;
        assert!((base.center - center).norm() < 1e-12 && (base.mass - 83.0).abs() < 1e-12);
        let about_z: f64 = parts.iter().map(|(m, at, own)| own + m * (at - center).xy().norm_squared()).sum();
        assert!((base.inertia[(2, 2)] - about_z - MIN_INERTIA).abs() < 1e-12);
    }
}
