//! A custom plant: a robot whose motors follow their inputs with a delay, and a human who walks exactly.
//!
//! ```text
//! cargo run --release --example own_plant
//! ```

use cocarry::geometry::PlanarPose;
use cocarry::math;
use cocarry::plant::{Command, HumanMotion, Plant, Seen};
use cocarry::robot::{Configuration, InputVector, Robot};
use cocarry::saved::{RestoreError, Saved};
use cocarry::scenario::{self, RobotSetup, Scenario};
use cocarry::simulation::KinematicPlant;
use cocarry::world::World;

const LAG: f64 = 0.1; // time constant of the motors, s
#[derive(Clone, Debug)]
struct Lagging<'a> {
    robot: &'a Robot,
    state: (Configuration, InputVector, PlanarPose),
}

impl Plant for Lagging<'_> {
    fn observe(&self) -> Seen<'_> {
        let (q, _, human) = &self.state;
        let (configuration, grasp) = (Some(q), Some(self.robot.grasp_pose(q)));
        Seen { position: human.position, configuration, grasp, human: Some(*human), bodies: None }
    }

    fn step(&mut self, command: &Command, motion: &HumanMotion, period: f64) {
        let (q, input, human) = &mut self.state;
        *input += (command.input - *input) * (1.0 - math::exp(-period / LAG));
        *q = self.robot.advance(q, &(*input + command.rates), period);
        *human = motion.hand.unwrap_or(*human);
    }

    fn save(&self) -> Saved {
        Saved::of(&self.state)
    }

    fn restore(&mut self, saved: &Saved) -> Result<(), RestoreError> {
        saved.read("plant").map(|state| self.state = state)
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (robot, world) = (Robot::built_in()?, World::find("environment-4".as_ref(), "environment-4")?);
    let plant = scenario::Plant::Kinematic { setup: RobotSetup::new(&robot) };
    let prepared = Scenario::new(world.into(), plant).prepare()?;
    let lagging = prepared.builder()?.with_plant(|start| {
        let q = *KinematicPlant::place(&robot, &robot.postures[0].joints, &start.pose).configuration();
        Lagging { robot: &robot, state: (q, InputVector::zeros(), start.pose) }
    });
    let mut episode = lagging.begin()?.ignoring_loss();
    while episode.step().is_none() {}
    let error = episode.summary().control.ok_or("a robot")?.largest_error;
    println!("{}; the grasp was off by {error:.3} m at most", episode.summary().outcome.name());
    Ok(())
}
