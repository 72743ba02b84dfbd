//! How partners share what they carry: which part of their forces moves it and which cancels, and whose work
//! drives it.

use super::grip::WrenchSample;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// The forces of any number of partners along one axis (N), taken apart: the motive part, their sum, and the
/// internal part, which others cancel: the lesser of what acts ahead and what acts back. For two partners it is
/// the lesser of two opposed forces, and 0 where they are not opposed: the largest compensating forces that do
/// not exceed those applied (Schmidts, Schneider and Peer 2013).
pub fn motive_and_internal(forces: impl IntoIterator<Item = f64>) -> [f64; 2] {
    let (mut ahead, mut back) = (0.0, 0.0);
    for force in forces {
        if force > 0.0 { ahead += force } else { back -= force }
    }
    [ahead - back, f64::min(ahead, back)]
}

/// Forces and work of robot and human on the object, as sums over physics steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sharing {
    /// Number of physics steps.
    pub steps: f64,
    /// Sums of the squares of the motive and of the internal part of both forces along the line between the
    /// grips, N^2.
    pub squared_parts: [f64; 2],
    /// Sums of the magnitudes of the robot's and of the human's horizontal force, N.
    pub level_force: [f64; 2],
    /// Work of the robot and of the human while their power was positive, J.
    pub driving_work: [f64; 2],
}

impl Sharing {
    /// Adds a physics step of `dt` seconds with these samples of gripper and hand. `ahead` is the direction from
    /// the one to the other.
    pub(super) fn add_step(&mut self, samples: &[WrenchSample; 2], ahead: &Vector3<f64>, dt: f64) {
        let parts = motive_and_internal(samples.iter().map(|sample| sample.wrench.force.dot(ahead)));
        self.add(&Self {
            steps: 1.0,
            squared_parts: parts.map(|part| part * part),
            level_force: [0, 1].map(|by| samples[by].wrench.force.xy().norm()),
            driving_work: [0, 1].map(|by| samples[by].work(dt).max(0.0)),
        });
    }

    /// Adds the sums of other steps.
    pub fn add(&mut self, other: &Self) {
        let Self { steps, squared_parts, level_force, driving_work } = other;
        self.steps += steps;
        for by in 0..2 {
            self.squared_parts[by] += squared_parts[by];
            self.level_force[by] += level_force[by];
            self.driving_work[by] += driving_work[by];
        }
    }

    /// Root mean square of the motive part, N.
    pub fn motive_force(&self) -> f64 {
        (self.squared_parts[0] / self.steps.max(1.0)).sqrt()
    }

    /// Root mean square of the internal part, N.
    pub fn internal_force(&self) -> f64 {
        (self.squared_parts[1] / self.steps.max(1.0)).sqrt()
    }

    /// The human's share of both horizontal forces; `None` if there were none.
    pub fn human_force_share(&self) -> Option<f64> {
        human_share(self.level_force)
    }

    /// The human's share of the driving work of both; `None` if there was none.
    pub fn human_work_share(&self) -> Option<f64> {
        human_share(self.driving_work)
    }
}

fn human_share([robot, human]: [f64; 2]) -> Option<f64> {
    (robot + human > 0.0).then(|| human / (robot + human))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_of_two_and_of_more_partners() {
        assert_eq!(motive_and_internal([5.0, 3.0]), [8.0, 0.0]);
        assert_eq!(motive_and_internal([5.0, -3.0]), [2.0, 3.0]);
        assert_eq!(motive_and_internal([-7.0, 7.0]), [0.0, 7.0]);
        assert_eq!(motive_and_internal([5.0, -3.0, -4.0, 1.0]), [-1.0, 6.0]);
        assert_eq!(motive_and_internal([]), [0.0, 0.0]);
    }
}
