//! The arguments that define a scenario.

use super::model::{ModelArguments, change, initial_stubbornness, load_world, perception, positive};
use super::output::{Failure, input};
use super::robot::RobotArguments;
use crate::coordination;
use crate::episode::{PreferenceChange, Settings};
use crate::human::ModelName;
use crate::options::OptionSet;
use crate::policy::Method;
use crate::preference::{Belief, Perception};
use crate::scenario::{Redraws, Scenario, drawn_changes, drawn_human};
use crate::world::World;
use anyhow::anyhow;
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use std::path::PathBuf;

/// World, human, team and plant.
#[derive(Args, Debug)]
pub(super) struct ScenarioArguments {
    /// World file (TOML), or a built-in world: environment-1 to environment-4
    #[arg(default_value = "environment-4")]
    world: PathBuf,
    /// Who decides the way
    #[arg(long, default_value_t = Method::MUTUAL, value_parser = methods())]
    method: Method,
    /// The human's perception of distance (D^alpha); drawn from the belief if not given
    #[arg(long, value_parser = perception, allow_negative_numbers = true)]
    alpha: Option<f64>,
    /// The human's perception of risk (Prelec's gamma); drawn from the belief if not given
    #[arg(long, value_parser = perception, allow_negative_numbers = true)]
    gamma: Option<f64>,
    /// The human changes their mind: from step STEP (from 0) on, alpha and gamma are these. May be given several times; of two at the same
    /// step, the later stands. The robot is not told. Makes no difference to the way while the robot leads, nor after the start with
    /// --method without-model
    #[arg(long, value_name = "STEP:ALPHA,GAMMA", value_parser = change, conflicts_with = "redraws")]
    change: Vec<PreferenceChange>,
    /// The human changes their mind so often, 0 to 8 times, or once-or-twice (a fair coin, as in Table III): alpha and gamma are drawn from
    /// the seed again (but for one that is given), each time at a random step up to half of what the way preferred at the start takes. As
    /// with --change, not every method minds
    #[arg(long, value_name = "N", default_value_t = Redraws::NONE, allow_negative_numbers = true)]
    redraws: Redraws,
    /// Tolerance of the human: the larger, the slower stubbornness grows (paper: 5, 10.5, 15)
    #[arg(long, default_value_t = coordination::Settings::default().eta, value_parser = positive, allow_negative_numbers = true)]
    eta: f64,
    /// Stubbornness at the start, in (0, 1]
    #[arg(long, value_name = "PHI", default_value_t = coordination::Settings::default().initial_stubbornness, value_parser = initial_stubbornness, allow_negative_numbers = true)]
    initial_stubbornness: f64,
    /// How the human decides: preference, boltzmann(RATIONALITY) or scripted(STEP:OPTION,...)
    #[arg(long, value_name = "MODEL", default_value_t = ModelName::default())]
    human: ModelName,
    /// Seed from which the human, and what they change their mind to, is drawn
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
            method: self.method,
            tick_limit: self.max_steps,
            ..Settings::default()
        };
        let changes = self.changes(&world, human, &settings)?;
        let plant = self.carrier.plant()?;
        Ok(Scenario {
            seed: self.seed,
            world: world.into(),
            human,
            human_model: self.human.clone(),
            changes,
            settings,
            plant,
        })
    }

    /// The human: as given, the rest drawn from the seed.
    fn human(&self, belief: &Belief) -> Perception {
        self.given_or(drawn_human(belief, self.seed))
    }

    fn given_or(&self, drawn: Perception) -> Perception {
        Perception { alpha: self.alpha.unwrap_or(drawn.alpha), gamma: self.gamma.unwrap_or(drawn.gamma) }
    }

    /// The human's changes of mind: those given, or drawn from the seed.
    fn changes(
        &self,
        world: &World,
        human: Perception,
        settings: &Settings,
    ) -> Result<Vec<PreferenceChange>, Failure> {
        if self.redraws == Redraws::NONE {
            return Ok(self.change.clone());
        }
        if self.alpha.is_some() && self.gamma.is_some() {
            return Err(input(anyhow!(
                "--redraws {} draws alpha and gamma again, but both are given: --change says when they become what",
                self.redraws
            )));
        }
        let predictor = &settings.predictor;
        let options = OptionSet::new(world, predictor.risk_weight()).map_err(input)?;
        let drawn = drawn_changes(self.redraws, predictor.belief(), self.seed, human, &options, settings);
        let changes = drawn.into_iter().map(|change| {
            let perception = self.given_or(change.perception);
            PreferenceChange { perception, ..change }
        });
        Ok(changes.collect())
    }
}

/// The names of the methods, with what each does.
fn methods() -> impl TypedValueParser<Value = Method> {
    let names = Method::all().map(|method| PossibleValue::new(method.name()).help(method.about()));
    PossibleValuesParser::new(names).try_map(|name| name.parse::<Method>())
}
