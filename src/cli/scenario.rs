//! The arguments that settle an episode in; its scenario out.

use super::model::{ModelArguments, initial_stubbornness, load_world, perception, positive};
use super::output::Failure;
use super::robot::RobotArguments;
use crate::coordination::{self, Method};
use crate::episode::Settings;
use crate::preference::{Belief, Perception};
use crate::scenario::{Scenario, drawn_human};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// World, human, team and plant.
#[derive(Args, Debug)]
pub(super) struct ScenarioArguments {
    /// World file (TOML), or a built-in world: environment-1 to environment-4
    #[arg(default_value = "environment-4")]
    world: PathBuf,
    /// Who decides the way
    #[arg(long, value_enum, default_value_t = MethodArgument::Mutual)]
    method: MethodArgument,
    /// The human's perception of distance (D^alpha); drawn from the belief if not given
    #[arg(long, value_parser = perception, allow_negative_numbers = true)]
    alpha: Option<f64>,
    /// The human's perception of risk (Prelec's gamma); drawn from the belief if not given
    #[arg(long, value_parser = perception, allow_negative_numbers = true)]
    gamma: Option<f64>,
    /// Tolerance of the human: the larger, the slower stubbornness grows (paper: 5, 10.5, 15)
    #[arg(long, default_value_t = coordination::Settings::default().eta, value_parser = positive, allow_negative_numbers = true)]
    eta: f64,
    /// Stubbornness at the start, in (0, 1]
    #[arg(long, value_name = "PHI", default_value_t = coordination::Settings::default().initial_stubbornness, value_parser = initial_stubbornness, allow_negative_numbers = true)]
    initial_stubbornness: f64,
    /// Seed from which the human is drawn
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Give up after this many steps of 0.2 s [default: ten times what the longest option takes]
    #[arg(long, value_name = "STEPS")]
    max_steps: Option<u64>,
    #[command(flatten)]
    model: ModelArguments,
    #[command(flatten)]
    carrier: RobotArguments,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum MethodArgument {
    /// The robot leads until the human's stubbornness passes 1, then follows
    Mutual,
    /// The human leads from start to end, on the option preferred at the start
    WithoutModel,
    /// The human leads from start to end, choosing anew at every step
    HumanLed,
    /// The robot leads from start to end
    RobotLed,
}

impl From<MethodArgument> for Method {
    fn from(argument: MethodArgument) -> Self {
        match argument {
            MethodArgument::Mutual => Self::Mutual,
            MethodArgument::WithoutModel => Self::WithoutModel,
            MethodArgument::HumanLed => Self::HumanLed,
            MethodArgument::RobotLed => Self::RobotLed,
        }
    }
}

impl ScenarioArguments {
    /// The scenario that they ask for, its files read.
    pub fn scenario(&self) -> Result<Scenario, Failure> {
        let world = load_world(&self.world)?;
        let predictor = self.model.predictor()?;
        let human = self.human(predictor.belief());
        let settings = Settings {
            predictor,
            coordination: coordination::Settings {
                initial_stubbornness: self.initial_stubbornness,
                eta: self.eta,
            },
            method: self.method.into(),
            tick_limit: self.max_steps,
            ..Settings::default()
        };
        let plant = self.carrier.plant()?;
        Ok(Scenario { seed: self.seed, world: world.into(), human, settings, plant })
    }

    /// The human: as given, the rest drawn from the seed.
    fn human(&self, belief: &Belief) -> Perception {
        let drawn = drawn_human(belief, self.seed);
        Perception { alpha: self.alpha.unwrap_or(drawn.alpha), gamma: self.gamma.unwrap_or(drawn.gamma) }
    }
}
