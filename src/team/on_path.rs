//! A team without extent: the human walks the path exactly, and the grasp should be where the human is.

use super::{ARRIVAL_TOLERANCE_M, Pace, PathAhead, Place, Step, Travel, Walk};
use crate::control::{HORIZON, Intent, Reference, reference};
use crate::geometry::{PlanarPose, Pose, nearest_between};
use crate::options::{nominal_trajectory, turned};
use crate::plant::{HumanMotion, Seen};

/// A team that walks its path exactly, as in the paper's simulations.
#[derive(Clone, Copy, Debug)]
pub struct OnPath {
    /// The team's pace.
    pub pace: Pace,
}

fn pose(seen: &Seen<'_>) -> PlanarPose {
    seen.human.unwrap_or(PlanarPose { position: seen.position, yaw: 0.0 })
}

impl Walk for OnPath {
    fn grasp_goal(&self, seen: &Seen<'_>) -> PlanarPose {
        pose(seen)
    }

    fn advance(&mut self, step: &Step<'_>, seen: &Seen<'_>) -> HumanMotion {
        let yaw = pose(seen).yaw;
        let most = self.pace.yaw_rate * self.pace.period;
        let yaw = step.path.heading_at(step.to).map_or(yaw, |tangent| turned(yaw, tangent, most));
        HumanMotion { hand: Some(PlanarPose { position: step.position, yaw }), facing: None }
    }

    fn locate(&self, step: &Step<'_>, seen: &Seen<'_>) -> Place {
        if seen.position == step.position {
            return Place { along: step.to, path_lead: 0.0 };
        }
        let distance = |along: f64| {
            let at = step.path.point_at(along).unwrap_or(seen.position);
            (at - seen.position).norm_squared()
        };
        let (along, length) = (nearest_between([step.from, step.to], distance), step.path.length());
        let along = if along >= length - ARRIVAL_TOLERANCE_M { length } else { along };
        Place { along, path_lead: step.to - along }
    }

    fn observed_speed(&self, _: &Seen<'_>, intent: &Intent, _: Travel) -> f64 {
        intent.speed().unwrap_or(self.pace.speed)
    }

    fn reference(
        &self,
        seen: &Seen<'_>,
        ahead: &PathAhead<'_>,
        speed: f64,
        grasp: &Pose,
        height: f64,
    ) -> Reference {
        let Pace { period, yaw_rate, .. } = self.pace;
        let (path, along) = ahead.turn.map_or((ahead.path, ahead.along), |path| (path, 0.0));
        let poses = nominal_trajectory(path, along, pose(seen).yaw, speed, yaw_rate, period);
        reference(poses.take(HORIZON), grasp, height)
    }
}
