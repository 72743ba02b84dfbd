//! The planning level: a team that is a point and walks its path exactly.

use super::{RobotTick, Step, Team};

/// A team without extent and without a robot.
#[derive(Clone, Copy, Debug)]
pub struct PointTeam;

impl Team for PointTeam {
    fn walk(&mut self, step: &Step<'_>, _: Option<&mut RobotTick>) -> f64 {
        step.to
    }
}
