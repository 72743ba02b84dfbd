//! The motor log: a CSV file with a row for every physics step of an episode.

use super::output::Failure;
use anyhow::{Context, Error};
use cocarry::geometry::Pose;
use cocarry::simulation::PhysicsStep;
use cocarry_output::output_file::OutputFile;
use nalgebra::UnitQuaternion;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The columns between the controls and the forces: poses at the end of the step, world_from_body.
const BODIES: [&str; 3] = ["hand", "torso", "object"];
const POSE: [&str; 7] = ["x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"];
/// Forces on the object, in world axes, means over the step.
const GRIPS: [&str; 2] = ["gripper", "hand"];
const WRENCH: [&str; 6] =
    ["force_x_n", "force_y_n", "force_z_n", "torque_x_nm", "torque_y_nm", "torque_z_nm"];

/// A motor log that is being written.
pub(super) struct MotorLog {
    rows: Arc<Mutex<Rows>>,
    file: PathBuf,
}

struct Rows {
    table: csv::Writer<OutputFile>,
    /// The number of arm joints.
    joints: usize,
    steps: u64,
    failure: Option<csv::Error>,
}

impl MotorLog {
    /// A log with the names of its columns: time, controls of these actuators, poses, wrenches. `joints` is the
    /// number of arm joints.
    pub fn begin(
        output: OutputFile,
        file: &Path,
        controls: &[String],
        joints: usize,
    ) -> Result<Self, Failure> {
        let poses = BODIES.iter().flat_map(|body| POSE.map(|key| format!("{body}_{key}")));
        let wrenches = GRIPS.iter().flat_map(|grip| WRENCH.map(|key| format!("{grip}_{key}")));
        let names = ["time_s".to_owned()].into_iter().chain(controls.iter().cloned());
        let mut table = csv::Writer::from_writer(output);
        let written = table.write_record(names.chain(poses).chain(wrenches));
        written.with_context(|| file.display().to_string()).map_err(Failure::Output)?;
        let rows = Arc::new(Mutex::new(Rows { table, joints, steps: 0, failure: None }));
        Ok(Self { rows, file: file.to_owned() })
    }

    /// What adds a row for every physics step.
    pub fn observer(&self) -> impl FnMut(&PhysicsStep) + Send + Sync + use<> {
        let rows = Arc::clone(&self.rows);
        move |step| lock(&rows).add(step)
    }

    /// Whether a row could not be written.
    pub fn has_failed(&self) -> bool {
        lock(&self.rows).failure.is_some()
    }

    /// The number of rows, and the file, which is complete but does not have its name yet.
    pub fn finish(self) -> Result<(u64, OutputFile), Failure> {
        let failed = |error: Error| Failure::Output(error.context(self.file.display().to_string()));
        // the episode, which has the observer, is over
        let rows =
            Arc::into_inner(self.rows).ok_or_else(|| failed(anyhow::anyhow!("still being written")))?;
        let rows = rows.into_inner().unwrap_or_else(PoisonError::into_inner);
        match rows.failure {
            Some(error) => Err(failed(error.into())),
            None => {
                let output = rows.table.into_inner().map_err(|error| failed(error.into_error().into()))?;
                Ok((rows.steps, output))
            }
        }
    }
}

fn lock(rows: &Mutex<Rows>) -> MutexGuard<'_, Rows> {
    rows.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Rows {
    fn add(&mut self, step: &PhysicsStep) {
        if self.failure.is_some() {
            return;
        }
        let [linear, angular] = &step.hand_velocity;
        let rests = step.rests.iter().take(self.joints);
        let controls = step.base_rates.iter().chain(rests).chain(linear).chain(angular);
        let poses = [&step.hand, &step.torso, &step.object].map(numbers);
        let wrenches = step.grips.iter().flat_map(|grip| grip.force.iter().chain(&grip.torque));
        let row = [&step.time].into_iter().chain(controls).chain(poses.iter().flatten()).chain(wrenches);
        self.failure = self.table.write_record(row.map(f64::to_string)).err();
        self.steps += 1;
    }
}

/// Position, m, and quaternion of a pose.
fn numbers(pose: &Pose) -> [f64; 7] {
    let (at, turn) = (pose.translation, UnitQuaternion::from_rotation_matrix(&pose.rotation));
    [at.x, at.y, at.z, turn.w, turn.i, turn.j, turn.k]
}
