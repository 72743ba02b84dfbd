//! The constraints of eq. (7): the robot's limits over the horizon.

use super::{HORIZON, Inputs};
use crate::robot::{BaseInput, Configuration, Drive, InputVector, JointVector, Robot};

/// The violation (m/s, rad/s; for half-planes m) below which a constraint counts as satisfied.
pub const TOLERANCE: f64 = 1e-9;

/// Inputs of the base over the horizon.
pub type BaseInputs = [BaseInput; HORIZON];

/// The constraints on u(0..H-1): rates, joint positions, and half-planes for base and arm.
#[derive(Clone, Debug)]
pub struct Limits {
    /// Number of inputs that the robot has, and that its base has.
    inputs: usize,
    base: usize,
    /// Largest magnitude of each input, for u(0) and u(1..).
    rates: InputVector,
    /// The part of the first rates that the motion to another configuration already takes, m/s and rad/s.
    taken: InputVector,
    /// How far the sum of a joint's rates may decrease and increase, rad/s: the distance to the position
    /// limits divided by the period.
    room: [JointVector; 2],
    /// The half-planes.
    pub half_planes: Vec<HalfPlane>,
}

/// A linear bound on the inputs: on the position of a point of the robot after some periods.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfPlane {
    /// Coefficients of the inputs, one column per step; s.
    pub coefficients: Inputs,
    /// Largest weighted sum, m.
    pub bound: f64,
    /// Weight of the squared excess in the cost.
    pub price: f64,
}

impl HalfPlane {
    /// Treats the base's inputs as given; the remaining bounds apply to the arm's inputs.
    pub fn settle_base(&mut self, drive: &Drive, given: &BaseInputs) {
        for (t, given) in given.iter().enumerate() {
            for (i, rate) in given.iter().enumerate().take(drive.inputs()) {
                self.bound -= self.coefficients[(i, t)] * rate;
                self.coefficients[(i, t)] = 0.0;
            }
        }
    }
}

/// One linear constraint `a . u <= b`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Constraint {
    /// `sign * u_input(step)` is bounded.
    Rate { input: usize, step: usize, sign: f64 },
    /// `sign * (u_input(0) + .. + u_input(step))` is bounded.
    Position { input: usize, step: usize, sign: f64 },
    /// A half-plane (an index) is respected.
    Place(usize),
}

impl Limits {
    /// Limits to be filled by [`Limits::set`].
    pub fn new(robot: &Robot) -> Self {
        let base = robot.drive.inputs();
        Self {
            inputs: base + robot.joint_count(),
            base,
            rates: robot.input_limits(),
            taken: InputVector::zeros(),
            room: [JointVector::zeros(); 2],
            half_planes: Vec::new(),
        }
    }

    /// Largest magnitudes of the inputs: m/s and rad/s.
    pub fn rates(&self) -> &InputVector {
        &self.rates
    }

    /// Sets the limits at configuration `q`, where the motion that led there in this `period` (s) took
    /// `taken` of the rates.
    ///
    /// A joint beyond its limit, by rounding or because something pushed it, may stay but not move farther.
    /// Standing still is always allowed.
    pub fn set(&mut self, robot: &Robot, q: &Configuration, taken: &InputVector, period: f64) {
        self.taken = *taken;
        self.half_planes.clear();
        for (i, joint) in robot.joints.iter().enumerate() {
            self.room[0][i] = ((joint.lower - q.joints[i]) / period).min(0.0);
            self.room[1][i] = ((joint.upper - q.joints[i]) / period).max(0.0);
        }
    }

    fn rate_bound(&self, input: usize, step: usize, sign: f64) -> f64 {
        let taken = if step == 0 { sign * self.taken[input] } else { 0.0 };
        (self.rates[input] - taken).max(0.0)
    }

    fn position_bound(&self, input: usize, sign: f64) -> f64 {
        let joint = input - self.base;
        if sign > 0.0 { self.room[1][joint] } else { -self.room[0][joint] }
    }

    /// The bound b of a row.
    pub fn bound(&self, row: Constraint) -> f64 {
        match row {
            Constraint::Rate { input, step, sign } => self.rate_bound(input, step, sign),
            Constraint::Position { input, sign, .. } => self.position_bound(input, sign),
            Constraint::Place(i) => self.half_planes[i].bound,
        }
    }

    /// Calls `on_violation` for every constraint that `u` violates by more than 1e-9, with the excess
    /// `a . u - b`. The order is input by input, rates before positions, then half-planes.
    pub fn violations(&self, u: &Inputs, mut on_violation: impl FnMut(Constraint, f64)) {
        for input in 0..self.inputs {
            for step in 0..HORIZON {
                let value = u[(input, step)];
                let sign = value.signum();
                let excess = sign * value - self.rate_bound(input, step, sign);
                if excess > TOLERANCE {
                    on_violation(Constraint::Rate { input, step, sign }, excess);
                }
            }
            let mut sum = 0.0;
            for step in (0..HORIZON).filter(|_| input >= self.base) {
                sum += u[(input, step)];
                let sign = sum.signum();
                let excess = sign * sum - self.position_bound(input, sign);
                if excess > TOLERANCE {
                    on_violation(Constraint::Position { input, step, sign }, excess);
                }
            }
        }
        for (i, plane) in self.half_planes.iter().enumerate() {
            let excess = plane.coefficients.dot(u) - plane.bound;
            if excess > TOLERANCE {
                on_violation(Constraint::Place(i), excess);
            }
        }
    }

    /// Whether `u` violates no constraint.
    pub fn allow(&self, u: &Inputs) -> bool {
        let mut allowed = true;
        self.violations(u, |_, _| allowed = false);
        allowed
    }

    /// The coefficients a of a row.
    pub fn coefficients(&self, row: Constraint) -> Inputs {
        let mut a = Inputs::zeros();
        match row {
            Constraint::Rate { input, step, sign } => a[(input, step)] = sign,
            Constraint::Position { input, step, sign } => {
                a.row_mut(input).columns_mut(0, step + 1).fill(sign)
            }
            Constraint::Place(i) => return self.half_planes[i].coefficients,
        }
        a
    }

    /// The product `a . x` for the row's a.
    pub fn product(&self, row: Constraint, x: &Inputs) -> f64 {
        match row {
            Constraint::Rate { input, step, sign } => sign * x[(input, step)],
            Constraint::Position { input, step, sign } => sign * x.row(input).columns(0, step + 1).sum(),
            Constraint::Place(i) => self.half_planes[i].coefficients.dot(x),
        }
    }

    /// The fallback where no solution was found: the first input of `u`, scaled down as a whole until it
    /// violates no hard limit, then zeros.
    pub fn scaled_first(&self, u: &Inputs) -> Inputs {
        let mut scale: f64 = 1.0;
        for input in 0..self.inputs {
            let value = u[(input, 0)];
            let sign = value.signum();
            let mut bound = self.rate_bound(input, 0, sign);
            if input >= self.base {
                bound = bound.min(self.position_bound(input, sign));
            }
            if value.abs() > bound {
                scale = scale.min(bound / value.abs());
            }
        }
        let mut first = Inputs::zeros();
        first.set_column(0, &(u.column(0) * scale));
        first
    }
}
