//! The base of a team with bodies follows the path of its grasp; the arm does the rest.

use super::hitch::Hitch;
use crate::control::{BaseInputs, Follower, HORIZON, Manipulator};
use crate::geometry::{PlanarPose, Point, angle_of, left_of};
use crate::plant::Seen;
use crate::robot::{BaseInput, Configuration, Drive};
use crate::team::{PathAhead, TEAM_ACCELERATION, Walk};

/// The share of the rims' largest acceleration that the base plans with.
const RIM_SHARE: f64 = 0.8;
/// The least distance of the grasp from a differential base's axis that counts, m.
const MIN_LATERAL_OFFSET_M: f64 = 1e-3;
/// The most points of a way beside another.
const MAX_POINTS: usize = 128;

/// Where the base keeps relative to the grasp's path.
#[derive(Clone, Debug)]
pub struct Guide {
    /// Initial distance of the base behind the grasp, m, which the base keeps.
    distance: f64,
    /// Initial bearing of the grasp from straight ahead of the base, rad; 0 on a differential base.
    bearing: f64,
    /// Lateral offset of a differential base to the right of the grasp's path, m; constant.
    lateral_offset: f64,
    /// Acceleration of the rims that the base plans with, m/s^2.
    rim_acceleration: f64,
    /// How the base follows a grasp whose reference is not on a path.
    hitch: Hitch,
    /// Buffers: the past path of the grasp, and of the base.
    way: Vec<Point>,
    beside: Vec<Point>,
}

impl Guide {
    /// The guide of a base that starts in the manipulator's posture. `rim_acceleration` is the largest,
    /// m/s^2.
    pub fn new(manipulator: &Manipulator, rim_acceleration: f64) -> Self {
        let Manipulator { robot, posture, .. } = *manipulator;
        let at_origin = PlanarPose { position: Point::origin(), yaw: 0.0 };
        let configuration = Configuration { base: at_origin, joints: posture };
        let held = robot.grasp_pose(&configuration).translation.vector.xy();
        let is_free = robot.drive.is_omnidirectional();
        let (distance, bearing) = if is_free { (held.norm(), angle_of(held)) } else { (held.x, 0.0) };
        let lateral_offset = if is_free || held.y.abs() < MIN_LATERAL_OFFSET_M { 0.0 } else { held.y };
        let rim_acceleration = RIM_SHARE * rim_acceleration;
        Self {
            distance,
            bearing,
            lateral_offset,
            rim_acceleration,
            hitch: Hitch::new([distance, lateral_offset, bearing], rim_acceleration),
            way: Vec::with_capacity(64),
            beside: Vec::with_capacity(MAX_POINTS),
        }
    }

    /// The guide of a base that has no room for its arm to make up for its turning: one that holds the grasp to its
    /// side. `None` for others.
    pub fn of_lateral(manipulator: &Manipulator) -> Option<Self> {
        let guide = Self::new(manipulator, f64::INFINITY);
        (guide.lateral_offset != 0.0).then_some(guide)
    }

    /// Inputs with which the base follows a grasp that goes from `grasp` through `poses`, one per `period`
    /// (s), wherever the team's path is.
    pub fn following(
        &self,
        seen: &Seen<'_>,
        (grasp, poses): (&PlanarPose, &[PlanarPose; HORIZON]),
        drive: &Drive,
        period: f64,
    ) -> Option<BaseInputs> {
        let bodies = seen.bodies?;
        let base = &bodies.configuration.base;
        Some(self.hitch.inputs(drive, base, bodies.base_rates, (grasp, poses), period))
    }

    /// The same for a base that takes any speed at once.
    pub fn following_at_once(
        &self,
        base: &PlanarPose,
        (grasp, poses): (&PlanarPose, &[PlanarPose; HORIZON]),
        drive: &Drive,
        period: f64,
    ) -> BaseInputs {
        self.hitch.inputs(drive, base, BaseInput::zeros(), (grasp, poses), period)
    }

    /// Inputs with which the base follows the path of the grasp, where the human is seen to walk at `speed`
    /// (m/s).
    pub fn inputs(
        &mut self,
        seen: &Seen<'_>,
        walk: &dyn Walk,
        ahead: &PathAhead<'_>,
        speed: f64,
        manipulator: &Manipulator<'_>,
        period: f64,
    ) -> Option<BaseInputs> {
        let bodies = seen.bodies?;
        let speeds = walk.grasp_way(seen, ahead, speed, &mut self.way)?;
        let is_beside = self.lateral_offset != 0.0;
        if is_beside {
            write_beside(&self.way, self.lateral_offset, &mut self.beside);
        }
        let follower = Follower {
            way: if is_beside { &self.beside } else { &self.way },
            speeds,
            acceleration: TEAM_ACCELERATION,
            rim_acceleration: self.rim_acceleration,
            distance: self.distance,
            bearing: self.bearing,
            footprint: &manipulator.robot.footprint,
            obstacles: manipulator.obstacles,
        };
        let base = &bodies.configuration.base;
        Some(follower.inputs(&manipulator.robot.drive, base, bodies.base_rates, period))
    }
}

/// A way along another one, to its right by `by` (m; negative: to the left), with points [`Follower::STEP`] apart
/// that end beside its last. On the inside of a bend that is narrower than `by`, it has a corner.
fn write_beside(way: &[Point], by: f64, beside: &mut Vec<Point>) {
    beside.clear();
    let count = way.len();
    let mut to_go = Follower::STEP;
    let mut last = None;
    for i in (0..count).rev() {
        let ahead = way[(i + 1).min(count - 1)] - way[i.saturating_sub(1)];
        let ahead = ahead.try_normalize(1e-9).unwrap_or_default();
        let here = way[i] - left_of(ahead) * by;
        let Some(from) = last else {
            beside.push(here);
            last = Some(here);
            continue;
        };
        let back = here - from;
        // what turns back is cut off
        if back.dot(&ahead) >= 0.0 {
            continue;
        }
        let (length, mut walked) = (back.norm(), to_go);
        while walked <= length && beside.len() < beside.capacity() {
            beside.push(from + back * (walked / length));
            walked += Follower::STEP;
        }
        to_go = walked - length;
        last = Some(here);
    }
    beside.reverse();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::direction;

    /// Points on an arc of a circle of `radius` (m) about the origin, which end at the angle 0.
    fn arc(radius: f64) -> Vec<Point> {
        let angle = |i: u32| -Follower::STEP * f64::from(i) / radius;
        (0..40).rev().map(|i| Point::from(direction(angle(i)) * radius)).collect()
    }

    #[test]
    fn closed_form_a_way_beside_an_arc_is_an_arc() {
        let mut beside = Vec::with_capacity(64);
        for by in [0.5, -0.5] {
            write_beside(&arc(2.0), by, &mut beside);
            // the arc turns left: its right side is outside
            assert!(beside.iter().all(|at| (at.coords.norm() - 2.0 - by).abs() < 2e-3), "{beside:?}");
            let steps = beside.windows(2).map(|pair| (pair[1] - pair[0]).norm());
            assert!(steps.clone().all(|step| (step - Follower::STEP).abs() < 1e-3), "{beside:?}");
            assert!((beside[beside.len() - 1] - Point::new(2.0 + by, 0.0)).norm() < 0.02);
        }
    }

    #[test]
    fn a_way_inside_a_narrow_bend_does_not_turn_back() {
        // straight along x, then a quarter of a circle of 0.3 m to the left, then straight along y
        let mut way: Vec<Point> = (0..20).map(|i| Point::new(-0.95 + 0.05 * f64::from(i), 0.0)).collect();
        way.extend((1..10).map(|i| {
            let angle = f64::from(i) / 6.0 - std::f64::consts::FRAC_PI_2;
            Point::from(direction(angle) * 0.3 + nalgebra::Vector2::new(0.0, 0.3))
        }));
        way.extend((0..20).map(|i| Point::new(0.3, 0.3 + 0.05 * f64::from(i))));
        let mut beside = Vec::with_capacity(64);
        write_beside(&way, -0.6, &mut beside);
        // first along x, then along y, and never back
        let moves = beside.windows(2).map(|pair| pair[1] - pair[0]);
        assert!(moves.clone().all(|by| by.x > -0.01 && by.y > -0.01), "{beside:?}");
        let end = beside[beside.len() - 1];
        assert!((end - Point::new(-0.3, 1.25)).norm() < 0.01, "{end}");
    }
}
