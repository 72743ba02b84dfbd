//! The arguments that describe the plant and the robot in it; robot files loaded, choices checked against each other.

use super::output::{Failure, input};
use crate::control::{self, Avoid, CandidateSet, PoseCriterion};
use crate::robot::Robot;
use crate::scenario::{Carrier, Plant};
use crate::simulation::{HumanSettings, PhysicsSettings};
use anyhow::anyhow;
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// What carries, and how it is controlled.
#[derive(Args, Debug)]
pub(super) struct RobotArguments {
    /// What the controller acts on
    #[arg(long, value_enum, default_value_t = PlantArgument::Kinematic)]
    plant: PlantArgument,
    /// Robot file (TOML), or a URDF with a robot file of the same name beside it [default: the built-in carrier]
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// Posture to start from, by its name in the robot file [default: the first]
    #[arg(long, value_name = "NAME")]
    posture: Option<String>,
    /// Configurations that pose optimisation chooses among while the human leads [default: arm]
    #[arg(long, value_enum, value_name = "SET")]
    pose: Option<PoseArgument>,
    /// What pose optimisation chooses by [default: expected]
    #[arg(long, value_enum, value_name = "CRITERION")]
    pose_criterion: Option<CriterionArgument>,
    /// Optimise the pose also while the robot leads, for its own way; the paper does so only while it follows
    #[arg(long)]
    prepare_while_leading: bool,
    /// Leave obstacles out of the robot's MPC, as the paper does
    #[arg(long)]
    no_obstacles: bool,
    /// How far the human's hand sways to either side with the gait, in metres; half as far up and down (--plant rapier) [default: 0.01]
    #[arg(long, value_name = "M", value_parser = sway, allow_negative_numbers = true)]
    sway: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum PlantArgument {
    /// The planning level alone: the team is a point that walks its path exactly
    Point,
    /// The robot moves exactly as its inputs say, without dynamics
    Kinematic,
    /// Robot, object, human and obstacles as bodies, with dynamics and contacts (rapier)
    Rapier,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum PoseArgument {
    /// No pose optimisation
    None,
    /// Fifteen configurations of the arm
    Arm,
    /// Fifteen configurations of base and arm
    WholeBody,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum CriterionArgument {
    /// Eq. (8): costs of all options, weighted by P_o
    Expected,
    /// Costs of all options, equally weighted
    Uniform,
    /// The cost of the option that the robot takes the human to be on
    Tracked,
    /// Yoshikawa's manipulability of the arm instead of costs
    Manipulability,
}

impl RobotArguments {
    /// The plant with its robot, whose files are read and checked here.
    pub fn plant(&self) -> Result<Plant, Failure> {
        if self.plant == PlantArgument::Point {
            let given = [
                ("--robot", self.robot.is_some()),
                ("--posture", self.posture.is_some()),
                ("--pose", self.pose.is_some()),
                ("--pose-criterion", self.pose_criterion.is_some()),
                ("--no-obstacles", self.no_obstacles),
                ("--prepare-while-leading", self.prepare_while_leading),
                ("--sway", self.sway.is_some()),
            ];
            return match given.iter().find(|(_, is_given)| *is_given) {
                None => Ok(Plant::Point),
                Some((flag, _)) => {
                    Err(input(anyhow!("{flag} says something of a robot, but --plant point has none")))
                }
            };
        }
        if self.plant == PlantArgument::Kinematic && self.sway.is_some() {
            return Err(input(anyhow!(
                "--sway is for --plant rapier: the kinematic plant's human walks exactly"
            )));
        }
        let robot = load_robot(self.robot.as_deref())?;
        let posture = match &self.posture {
            None => robot.postures.first(),
            Some(name) => robot.posture(name),
        };
        let Some(posture) = posture.map(|p| p.name.clone()) else {
            let known: Vec<_> = robot.postures.iter().map(|p| format!("`{}`", p.name)).collect();
            let asked = self.posture.as_deref().unwrap_or_default();
            let (file, known) = (&robot.texts.file, known.join(", "));
            return Err(input(anyhow!(
                "--posture {asked}: {file} has no posture of that name; it has {known}"
            )));
        };
        let control = control::Settings {
            candidates: match self.pose.unwrap_or(PoseArgument::Arm) {
                PoseArgument::None => CandidateSet::None,
                PoseArgument::Arm => CandidateSet::Arm,
                PoseArgument::WholeBody => CandidateSet::WholeBody,
            },
            criterion: match self.pose_criterion.unwrap_or(CriterionArgument::Expected) {
                CriterionArgument::Expected => PoseCriterion::Expected,
                CriterionArgument::Uniform => PoseCriterion::Uniform,
                CriterionArgument::Tracked => PoseCriterion::Tracked,
                CriterionArgument::Manipulability => PoseCriterion::Manipulability,
            },
            prepare_while_leading: self.prepare_while_leading,
            avoid: if self.no_obstacles { Avoid::Nothing } else { Avoid::Robot },
            ..control::Settings::default()
        };
        let carrier = Carrier { posture, control, robot: robot.texts };
        Ok(match self.plant {
            PlantArgument::Rapier => Plant::Rapier { carrier, physics: physics(self.sway) },
            _ => Plant::Kinematic { carrier },
        })
    }
}

/// The physical plant with a human who sways so far (m).
fn physics(sway: Option<f64>) -> PhysicsSettings {
    let settings = PhysicsSettings::default();
    let human = settings.human;
    let human =
        sway.map_or(human, |sway| HumanSettings { sway_lateral: sway, sway_vertical: sway / 2.0, ..human });
    PhysicsSettings { human, ..settings }
}

fn sway(text: &str) -> Result<f64, String> {
    let good = |v: &f64| (0.0..=0.1).contains(v);
    text.parse().ok().filter(good).ok_or_else(|| "must be a number from 0 to 0.1".to_owned())
}

/// The robot in a file, or the built-in one.
pub(super) fn load_robot(file: Option<&std::path::Path>) -> Result<Robot, Failure> {
    file.map_or_else(Robot::built_in, Robot::load).map_err(input)
}
