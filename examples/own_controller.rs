//! A custom controller on the physical plant: the grasp moves to its next reference by damped least
//! squares, without horizon, limits or pose optimisation, in place of eqs. (8) and (7).
//!
//! ```text
//! cargo run --release --example own_controller
//! ```

use cocarry::controller::{Controller, References, Way};
use cocarry::episode::Manipulator;
use cocarry::plant::{Command, Seen};
use cocarry::preference::ChoiceDistribution;
use cocarry::robot::{InputVector, Robot};
use cocarry::scenario::{Plant, PlantKind, RobotSetup, Scenario};
use cocarry::team::Pace;
use cocarry::world::World;
use nalgebra::Matrix6;

/// Damping of singular directions.
const DAMPING: f64 = 0.02;

#[derive(Clone, Debug)]
struct DampedLeastSquares<'a> {
    manipulator: Manipulator<'a>,
    references: References,
    pace: Pace,
}

impl Controller for DampedLeastSquares<'_> {
    fn command(&mut self, seen: &Seen<'_>, way: &Way<'_>, belief: &ChoiceDistribution) -> Command {
        let Some(q) = seen.configuration else { return Command::none() };
        let at = self.manipulator.robot.kinematics(q);
        self.references.set(seen, way, belief, &at.grasp, &self.manipulator);
        let twist = self.references.to_track().column(0) / self.pace.period;
        let j = at.jacobian;
        let damped = (j * j.transpose() + Matrix6::identity() * DAMPING).cholesky();
        let input = damped.map_or_else(InputVector::zeros, |damped| j.transpose() * damped.solve(&twist));
        let limits = self.manipulator.robot.input_limits();
        Command::inputs(q, input.zip_map(&limits, |rate, limit| rate.clamp(-limit, limit)))
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let plant = Plant::new(PlantKind::Rapier, RobotSetup::new(&Robot::built_in()?));
    let prepared =
        Scenario::new(World::find("environment-1".as_ref(), "environment-1")?.into(), plant).prepare()?;
    let (manipulator, pace) = (prepared.manipulator().ok_or("a robot")?, prepared.scenario().settings.pace());
    let options = prepared.options().options().len();
    let references = References::new(manipulator.control.direction_concentration, pace, options);
    let controller = DampedLeastSquares { manipulator, references, pace };
    let mut episode = prepared.builder()?.with_controller(controller).begin()?;
    while episode.step().is_none() {}
    let (end, force) =
        (episode.summary(), episode.summary().interaction.map_or(0.0, |forces| forces.mean_force()));
    println!("{} after {} steps, {force:.1} N at the human's hand", end.outcome.name(), end.steps);
    Ok(())
}
