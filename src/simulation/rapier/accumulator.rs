//! Means, peaks, work and jerk since an observation was begun, accumulated over the physics steps.

use super::grip::WrenchSample;
use super::noise::{Coefficients, HighPass};
use super::sharing::Sharing;
use super::touch::Touches;
use super::{Forces, Wrench};
use crate::robot::JointVector;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Share of its limit from which a motor is at it.
const AT_LIMIT: f64 = 1.0 - 1e-5;

/// An accumulator over the physics steps since an observation was begun.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Accumulator {
    pub touches: Touches,
    grips: [Sum; 2],
    sharing: Sharing,
    squared_jerk: f64,
    effort_share: f64,
    #[serde(default)]
    time_at_limit: JointVector,
    /// Velocity (m/s) and acceleration (m/s^2) of the object after the last step; kept between observations.
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
    squared_noise: f64,
    peak: f64,
    work: f64,
    deflection: f64,
    /// The wrench of the last step; kept between periods. `None` before the first step.
    last: Option<Wrench>,
    /// The filter of the force's noise; kept between periods.
    filter: HighPass,
}

impl Accumulator {
    /// Begins a period.
    pub fn begin(&mut self) {
        self.touches.clear();
        self.sharing = Sharing::default();
        self.squared_jerk = 0.0;
        self.effort_share = 0.0;
        self.time_at_limit = JointVector::zeros();
        for sum in &mut self.grips {
            *sum = Sum { last: sum.last, filter: sum.filter, ..Sum::default() };
        }
    }

    /// Adds a step of `dt` seconds, with the noise filter of such steps: the samples of gripper and hand, and
    /// after the step the direction from the one to the other and the object's velocity.
    pub fn add(
        &mut self,
        samples: &[WrenchSample; 2],
        (ahead, velocity): (Vector3<f64>, Vector3<f64>),
        (dt, noise): (f64, &Coefficients),
    ) {
        for (sum, sample) in self.grips.iter_mut().zip(samples) {
            sum.add(sample, (dt, noise));
        }
        self.sharing.add_step(samples, &ahead, dt);
        let acceleration = (velocity - self.velocity) / dt;
        self.squared_jerk += (acceleration - self.acceleration).norm_squared() / dt;
        (self.velocity, self.acceleration) = (velocity, acceleration);
    }

    /// Adds the motors' efforts in a step of `dt` seconds, as shares of their limits.
    pub fn add_efforts(&mut self, shares: &JointVector, dt: f64) {
        self.effort_share = self.effort_share.max(shares.max());
        self.time_at_limit += shares.map(|share| if share >= AT_LIMIT { dt } else { 0.0 });
    }

    pub fn gripper(&self) -> Forces {
        self.grips[0].forces()
    }

    pub fn hand(&self) -> Forces {
        self.grips[1].forces()
    }

    pub fn sharing(&self) -> Sharing {
        self.sharing
    }

    /// The largest motor effort as a share of its limit.
    pub fn effort_share(&self) -> f64 {
        self.effort_share
    }

    /// How long each joint's motor was at its limit, s.
    pub fn time_at_limit(&self) -> JointVector {
        self.time_at_limit
    }

    /// Integral of the squared jerk, m^2/s^5.
    pub fn squared_jerk(&self) -> f64 {
        self.squared_jerk
    }
}

impl Sum {
    fn add(&mut self, sample: &WrenchSample, (dt, noise): (f64, &Coefficients)) {
        let Wrench { force, torque } = sample.wrench;
        self.steps += 1.0;
        self.force += force;
        self.torque += torque;
        self.squared += force.norm_squared();
        self.peak = self.peak.max(force.norm());
        self.deflection = self.deflection.max(sample.deflection);
        self.work += sample.work(dt);
        self.squared_noise += self.filter.next(&force, noise).norm_squared();
        self.last = Some(sample.wrench);
    }

    fn forces(&self) -> Forces {
        let steps = self.steps.max(1.0);
        Forces {
            mean: Wrench { force: self.force / steps, torque: self.torque / steps },
            last: self.last.unwrap_or_default(),
            peak: self.peak,
            rms: (self.squared / steps).sqrt(),
            noise: (self.squared_noise / steps).sqrt(),
            work: self.work,
            deflection: self.deflection,
        }
    }
}
