//! The base where the arm does not reach the grasp's place: it moves to where the arm does.
//!
//! DEVIATION (eq. 7): a base that follows the path of the grasp keeps a straight distance from it. Where the
//! path bends by more than a right angle within the length of object and arm, the arm folds, or turns its
//! wrist, up to its limits at that distance, and from there no input of the arm brings the grasp nearer to its
//! place. The leader waits meanwhile.

use crate::control::{BaseInputs, Manipulator};
use crate::geometry::{Pose, Vector};
use crate::robot::{BaseInput, BaseTwist, Configuration};

/// The grasp is out of place where it is this far (m) from where it should be.
pub(super) const OUT_OF_PLACE_M: f64 = 0.04;
/// Speeds (m/s) and turning rates (rad/s) that the base tries.
const SPEEDS: [f64; 5] = [0.0, -0.15, 0.15, -0.3, 0.3];
const SIDEWAYS: [f64; 3] = [0.0, -0.2, 0.2];
const TURNS: [f64; 5] = [0.0, 0.5, -0.5, 1.0, -1.0];
/// How long each is kept, s.
const KEPT_S: f64 = 1.0;
/// The arm keeps this far off its limits at the end, rad (m).
const MARGIN: f64 = 0.1;
/// An angle (rad) by which the grasp is off counts as much as this distance, m.
const LEVER_M: f64 = 0.3;
/// A motion must bring the grasp nearer to its place than the path does by this distance, m, and by so much
/// more for every metre that the base rolls, and for every radian that it turns.
const GAIN_M: f64 = 0.01;
const GAIN_PER_M: f64 = 0.02;
const GAIN_PER_RAD: f64 = 0.01;
/// How far (m) the base may overlap an obstacle, as on its path.
const OVERLAP_M: f64 = 0.005;

/// A base whose arm does not reach the place of the grasp.
pub(super) struct Regain<'a> {
    pub manipulator: &'a Manipulator<'a>,
    pub configuration: &'a Configuration,
    /// Where the grasp should be.
    pub goal: Pose,
    /// The present inputs of the base.
    pub input: BaseInput,
    /// Largest acceleration of the rims, m/s^2.
    pub rim_acceleration: f64,
    /// Control period, s.
    pub period: f64,
}

impl Regain<'_> {
    /// The inputs, instead of those along its `path`, with which the base takes the arm to where it reaches
    /// best; `path` where nothing is better.
    pub fn inputs(&self, path: BaseInputs) -> BaseInputs {
        let mut chosen =
            (self.short(|t| path[t.min(path.len() - 1)]).unwrap_or(f64::INFINITY) - GAIN_M, path);
        let sideways = if self.manipulator.robot.drive.is_omnidirectional() { &SIDEWAYS[..] } else { &[0.0] };
        for &x in &SPEEDS {
            for &y in sideways {
                for &turn in &TURNS {
                    let twist = BaseTwist { velocity: Vector::new(x, y), turn };
                    let inputs = self.toward(&twist);
                    let effort = KEPT_S * (GAIN_PER_M * twist.velocity.norm() + GAIN_PER_RAD * turn.abs());
                    let Some(short) = self.short(|t| inputs[t.min(inputs.len() - 1)]) else { continue };
                    if short + effort < chosen.0 {
                        chosen = (short + effort, inputs);
                    }
                }
            }
        }
        chosen.1
    }

    /// Inputs that go over to a motion as fast as the wheels can.
    fn toward(&self, twist: &BaseTwist) -> BaseInputs {
        let drive = &self.manipulator.robot.drive;
        let wanted = drive.input(twist);
        let change = drive.accelerations(self.rim_acceleration) * self.period;
        let mut last = self.input;
        BaseInputs::default().map(|_| {
            last = BaseInput::from_fn(|i, _| wanted[i].clamp(last[i] - change[i], last[i] + change[i]));
            last
        })
    }

    /// How far the grasp stays from its place after these inputs, m; `None` if the base has no room.
    fn short(&self, input: impl Fn(usize) -> BaseInput) -> Option<f64> {
        let Manipulator { robot, obstacles, .. } = self.manipulator;
        let mut end = *self.configuration;
        for t in 0..(KEPT_S / self.period).round() as usize {
            end.base = robot.drive.roll(&end.base, &(input(t) * self.period));
            if !obstacles.has_room(&end.base, &robot.footprint, OVERLAP_M) {
                return None;
            }
        }
        let error = robot.out_of_reach(&end, &self.goal, KEPT_S, MARGIN);
        Some(error.fixed_rows::<3>(0).norm() + LEVER_M * error.fixed_rows::<3>(3).norm())
    }
}
