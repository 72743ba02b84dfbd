//! The arguments that define a scenario.

use super::model::{BeliefArguments, change, load_world, perception};
use super::output::{Failure, input};
use super::robot::RobotArguments;
use super::settings::SettingArguments;
use anyhow::anyhow;
use clap::Args;
use cocarry::episode::{EpisodeSettings, PreferenceChange};
use cocarry::preference::RISK_WEIGHT;
use cocarry::scenario::{GivenPerception, PreferenceChanges, Scenario, SettingGroup, drawn_changes};
use std::path::{Path, PathBuf};

const HUMAN: &str = SettingGroup::Human.title();
const ROBOT: &str = SettingGroup::Robot.title();

/// World, human, team and plant.
#[derive(Args, Debug)]
pub(super) struct ScenarioArguments {
    /// World file (TOML), a built-in world (see `cocarry worlds`), or - for a world file on standard input
    #[arg(default_value = "environment-4")]
    world: PathBuf,
    #[command(flatten)]
    team: TeamArguments,
}

/// Human, team and plant.
#[derive(Args, Debug)]
pub(super) struct TeamArguments {
    /// The human's perception of distance: alpha in D^alpha [default: drawn from the belief]
    #[arg(long, value_parser = perception, allow_negative_numbers = true, help_heading = HUMAN)]
    alpha: Option<f64>,
    /// The human's perception of risk: Prelec's gamma [default: drawn from the belief]
    #[arg(long, value_parser = perception, allow_negative_numbers = true, help_heading = HUMAN)]
    gamma: Option<f64>,
    /// Preference change: ALPHA and GAMMA apply from step STEP on (the first step is 0), as in 40:0.6,0.9.
    /// May be given several times; of two at the same step, the last one given applies. The robot's belief
    /// stays the same. A change has no effect on the path while the robot leads, nor with --method
    /// without-model after the start
    #[arg(long, value_name = "STEP:ALPHA,GAMMA", value_parser = change, conflicts_with = "preference_changes", help_heading = HUMAN)]
    change: Vec<PreferenceChange>,
    /// Number of preference changes drawn from the seed: 0 to 8, or once-or-twice (a fair coin, as in Table
    /// III). Each draws alpha and gamma again, unless they are given, at a random step from 1 to half of the
    /// steps that the option preferred at the start takes. Some methods ignore preference changes: see
    /// --change
    #[arg(long, value_name = "N", default_value_t = PreferenceChanges::NONE, allow_negative_numbers = true, help_heading = HUMAN)]
    preference_changes: PreferenceChanges,
    /// Seed of the human, of the human's preference changes and of the gait
    #[arg(long, default_value_t = 0, allow_negative_numbers = true, help_heading = HUMAN)]
    seed: u64,
    #[command(flatten, next_help_heading = "Robot's belief")]
    belief: BeliefArguments,
    #[command(flatten, next_help_heading = ROBOT)]
    robot: RobotArguments,
    #[command(flatten)]
    settings: SettingArguments,
}

impl std::ops::Deref for ScenarioArguments {
    type Target = TeamArguments;

    fn deref(&self) -> &TeamArguments {
        &self.team
    }
}

impl ScenarioArguments {
    /// The scenario of these arguments; reads its files.
    pub fn scenario(&self) -> Result<Scenario, Failure> {
        self.team.scenario_in(&self.world)
    }
}

impl TeamArguments {
    /// The file of samples that the belief is read from.
    pub fn belief_samples(&self) -> Option<&PathBuf> {
        self.belief.belief_samples.as_ref()
    }

    /// The robot's file, if it is not the built-in robot.
    pub fn robot(&self) -> Option<&Path> {
        self.robot.robot.as_deref()
    }

    /// The custom policy that takes the place of the scenario's method.
    pub fn custom_policy(&self) -> Option<&str> {
        self.settings.custom_policy.as_deref()
    }

    /// The scenario of these arguments in a world: a file, a built-in one, or - for standard input.
    pub fn scenario_in(&self, world: &Path) -> Result<Scenario, Failure> {
        let world = load_world(world)?;
        let plant = self.robot.plant(&self.settings)?;
        let settings =
            EpisodeSettings { predictor: self.belief.predictor(RISK_WEIGHT)?, ..EpisodeSettings::default() };
        let belief = &settings.predictor.belief().clone();
        let given = GivenPerception { alpha: self.alpha, gamma: self.gamma };
        let mut scenario = Scenario::of_seed(self.seed, world.into(), plant, settings, belief, given);
        self.settings.apply(&mut scenario);
        scenario.changes = self.change.clone();
        let count = self.preference_changes;
        if count != PreferenceChanges::NONE {
            if given.is_complete() {
                return Err(input(anyhow!(
                    "--preference-changes {count} draws alpha and gamma again, but both are given; use --change to set the changes"
                )));
            }
            let settings = &scenario.settings;
            let options = scenario.world.options(settings.predictor.risk_weight()).map_err(input)?;
            scenario.changes = drawn_changes(count, belief, given, self.seed, &options, settings);
        }
        Ok(scenario)
    }
}

/// The files of world and robot that a scenario was read from.
pub(super) fn inputs_of(scenario: &Scenario) -> impl Iterator<Item = &Path> {
    let robot = scenario.plant.robot_setup().map(|setup| setup.robot.texts());
    let robot = robot.into_iter().flat_map(|robot| [robot.file.as_str(), &robot.urdf_file]);
    [scenario.world.file()].into_iter().chain(robot).map(Path::new)
}
