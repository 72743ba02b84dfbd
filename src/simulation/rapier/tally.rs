//! Means, peaks, work and jerk of a control period, accumulated over its physics steps.

use super::grip::Hold;
use super::touch::Touches;
use super::{Forces, Wrench};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// What is booked during a control period.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Tally {
    pub touches: Touches,
    grips: [Sum; 2],
    squared_jerk: f64,
    effort_share: f64,
    /// Velocity (m/s) and acceleration (m/s^2) of the object after the last step; kept from one period to the next.
    velocity: Vector3<f64>,
    acceleration: Vector3<f64>,
}

/// Sums over the steps of a period.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Sum {
    steps: f64,
    force: Vector3<f64>,
    torque: Vector3<f64>,
    squared: f64,
    squared_change: f64,
    peak: f64,
    work: f64,
    stretch: f64,
    /// In the last step; kept from one period to the next. `None` before the first.
    last: Option<Wrench>,
}

impl Tally {
    /// A period begins.
    pub fn begin(&mut self) {
        self.touches.clear();
        self.squared_jerk = 0.0;
        self.effort_share = 0.0;
        for sum in &mut self.grips {
            *sum = Sum { last: sum.last, ..Sum::default() };
        }
    }

    /// Adds a step of `dt` seconds: what the gripper and the hand did, and the object's velocity after it.
    pub fn add(&mut self, holds: &[Hold; 2], velocity: Vector3<f64>, dt: f64) {
        for (sum, hold) in self.grips.iter_mut().zip(holds) {
            sum.add(hold, dt);
        }
        let acceleration = (velocity - self.velocity) / dt;
        self.squared_jerk += (acceleration - self.acceleration).norm_squared() / dt;
        (self.velocity, self.acceleration) = (velocity, acceleration);
    }

    /// Adds the largest share of its limit that a motor exerted in a step.
    pub fn add_effort(&mut self, share: f64) {
        self.effort_share = self.effort_share.max(share);
    }

    pub fn gripper(&self) -> Forces {
        self.grips[0].forces()
    }

    pub fn hand(&self) -> Forces {
        self.grips[1].forces()
    }

    /// The largest share of its limit that a motor exerted.
    pub fn effort_share(&self) -> f64 {
        self.effort_share
    }

    /// Integral of the squared jerk, m^2/s^5.
    pub fn squared_jerk(&self) -> f64 {
        self.squared_jerk
    }
}

impl Sum {
    fn add(&mut self, hold: &Hold, dt: f64) {
        let Wrench { force, torque } = hold.wrench;
        self.steps += 1.0;
        self.force += force;
        self.torque += torque;
        self.squared += force.norm_squared();
        self.peak = self.peak.max(force.norm());
        self.stretch = self.stretch.max(hold.stretch);
        self.work += (force.dot(&hold.velocity) + torque.dot(&hold.turning)) * dt;
        if let Some(last) = self.last {
            self.squared_change += (force - last.force).norm_squared();
        }
        self.last = Some(hold.wrench);
    }

    fn forces(&self) -> Forces {
        let steps = self.steps.max(1.0);
        Forces {
            mean: Wrench { force: self.force / steps, torque: self.torque / steps },
            last: self.last.unwrap_or_default(),
            peak: self.peak,
            rms: (self.squared / steps).sqrt(),
            step_change: (self.squared_change / steps).sqrt(),
            work: self.work,
            stretch: self.stretch,
        }
    }
}
