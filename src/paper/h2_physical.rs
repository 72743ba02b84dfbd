//! Table II with bodies: the same humans on the planning level, where the team is a point, and on the physical plant.

use super::h2::{self, humans_at_random};
use super::{BuiltInError, COLUMNS, ENVIRONMENTS, Environment};
use super::{Way, way};
use crate::control::{self, RobotObstacles};
use crate::episode::{self, Episode, Manipulator, Outcome, Settings, Summary};
use crate::options::OptionSet;
use crate::parallel::{OnDone, in_parallel};
use crate::policy::Method;
use crate::preference::Perception;
use crate::robot::Robot;
use crate::simulation::{PhysicsError, PhysicsSettings};
use crate::statistics::{self, Paired, mean_and_std};
use crate::world::World;
use serde::Serialize;
use std::collections::BTreeSet;

/// What is run.
#[derive(Clone, Copy, Debug)]
pub struct Study<'a> {
    /// The robot, which starts from its first posture.
    pub robot: &'a Robot,
    /// The plant.
    pub physics: PhysicsSettings,
    /// The loop's settings, but for method and eta.
    pub episode: &'a Settings,
    /// Humans in each cell.
    pub humans: usize,
    /// Seed of the humans and of their gaits.
    pub seed: u64,
}

/// Costs that differ by no more than this are alike: a team with bodies starts gently.
const ALIKE: f64 = 0.05;

/// One cell of Table II.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Environment, 1 to 4.
    pub environment: u32,
    /// `mutual`, or `without-model`.
    pub method: Method,
    /// eta; none without the model.
    pub eta: Option<f64>,
    /// Episodes run.
    pub humans: usize,
    /// Episodes that arrived, without any contact with an obstacle.
    pub arrived: usize,
    /// How the others ended, in the order of the humans.
    pub lost: Vec<&'static str>,
    /// Mean accumulated objective cost of a team without bodies, m: of the humans who arrive with bodies, as all that follows.
    pub point_mean: f64,
    /// The same with bodies, m.
    pub physical_mean: f64,
    /// The cost with bodies less that without the model, of the humans who arrive both times, m; corrected for the comparisons of the table. None
    /// without the model.
    pub against_without: Option<Paired>,
    /// Mean of the ratios of the two, human by human.
    pub mean_ratio: f64,
    /// The ratio that is farthest from 1.
    pub farthest_ratio: f64,
    /// Episodes whose ratio is within 5 % of 1.
    pub alike: usize,
    /// Episodes that end on the same option.
    pub same_option: usize,
    /// The largest difference between the steps of the transitions.
    pub transition_difference: u64,
    /// Root mean square distance between grasp and reference over all steps, m.
    pub position_error_rms: f64,
    /// Mean and largest of the episodes' root mean square force of the human on the object, N.
    pub hand_force_rms: [f64; 2],
    /// Largest deflection of a grip, m.
    #[serde(rename = "largest_grip_deflection_m")]
    pub deflection: f64,
}

impl Study<'_> {
    /// Units of work, for a progress bar.
    pub fn units(&self) -> usize {
        ENVIRONMENTS.len() * COLUMNS.len() * self.humans
    }

    /// Every cell, in the order of Table II.
    ///
    /// # Errors
    /// If a built-in world is not valid, or the physical plant cannot be set up in it.
    pub fn table(&self, on_done: OnDone) -> Result<Vec<Row>, BuiltInError> {
        let humans = humans_at_random(self.episode.predictor.belief(), self.seed, self.humans);
        let mut rows = Vec::new();
        for environment in &ENVIRONMENTS {
            let world = environment.world()?;
            let options = OptionSet::new(&world, self.episode.predictor.risk_weight())?;
            let mut without = Vec::new();
            for eta in COLUMNS {
                let (mut row, costs) = self.cell(environment, &world, &options, eta, &humans, on_done)?;
                match eta {
                    None => without = costs,
                    Some(_) => row.against_without = against(&costs, &without),
                }
                rows.push(row);
            }
        }
        statistics::correct(rows.iter_mut().filter_map(|row| row.against_without.as_mut()));
        Ok(rows)
    }

    /// A cell's row, and what each human's episode with bodies has cost.
    fn cell(
        &self,
        environment: &Environment,
        world: &World,
        options: &OptionSet,
        eta: Option<f64>,
        humans: &[Perception],
        on_done: OnDone,
    ) -> Result<(Row, Vec<Cost>), BuiltInError> {
        let settings = h2::with_eta(self.episode, eta);
        let obstacles = RobotObstacles::new(world);
        let manipulator = Manipulator {
            robot: self.robot,
            posture: self.robot.postures[0].joints,
            control: control::Settings::default(),
            obstacles: &obstacles,
        };
        let ends = in_parallel(humans.len(), on_done, |i| {
            let point = episode::run(options, &settings, humans[i], |_| {});
            let seed = self.seed.wrapping_add(i as u64);
            let mut physical = Episode::new(options, &settings, humans[i]).with_physics(
                manipulator,
                world,
                &self.physics,
                seed,
            )?;
            while physical.step().is_none() {}
            Ok((point, physical.summary().clone()))
        });
        let ends = ends.into_iter().collect::<Result<Vec<_>, PhysicsError>>()?;
        let cost = |physical: &Summary| {
            (physical.outcome == Outcome::Arrived).then(|| (physical.accumulated_cost, way(physical)))
        };
        let costs = ends.iter().map(|(_, physical)| cost(physical)).collect();
        Ok((row(environment, &settings, eta, &ends), costs))
    }
}

/// What an episode that arrived has cost, and the way it went.
type Cost = Option<(f64, Way)>;

/// The comparison of the humans who arrive both times. Where all of them go the same ways, they differ by the noise of the gait alone.
fn against(costs: &[Cost], without: &[Cost]) -> Option<Paired> {
    let both: Vec<_> = costs.iter().zip(without).filter_map(|(a, b)| Some(((*a)?, (*b)?))).collect();
    let ways: BTreeSet<(Way, Way)> = both.iter().map(|(a, b)| (a.1, b.1)).collect();
    let [first, second]: [Vec<f64>; 2] =
        [both.iter().map(|(a, _)| a.0).collect(), both.iter().map(|(_, b)| b.0).collect()];
    Paired::of_lists(&first, &second, ways.len() > 1)
}

fn row(environment: &Environment, settings: &Settings, eta: Option<f64>, ends: &[(Summary, Summary)]) -> Row {
    let arrived = || ends.iter().filter(|(_, physical)| physical.outcome == Outcome::Arrived);
    let of = |value: &dyn Fn(&(Summary, Summary)) -> f64| arrived().map(value).collect::<Vec<f64>>();
    let ratios = of(&|(point, physical)| physical.accumulated_cost / point.accumulated_cost);
    let off = |ratio: &f64| (ratio - 1.0).abs();
    let forces = of(&|(_, physical)| physical.interaction.map_or(f64::NAN, |i| i.rms_force()));
    let step = |summary: &Summary| summary.transition.map(|t| t.step);
    let differences = arrived().map(|(point, physical)| match (step(point), step(physical)) {
        (Some(a), Some(b)) => a.abs_diff(b),
        (None, None) => 0,
        _ => u64::MAX,
    });
    let squared: f64 = of(&|(_, p)| p.control.map_or(0.0, |c| c.squared_error)).iter().sum();
    let steps: u64 = arrived().map(|(_, physical)| physical.steps).sum();
    Row {
        environment: environment.number,
        method: settings.method,
        eta,
        humans: ends.len(),
        arrived: arrived().count(),
        lost: ends
            .iter()
            .filter(|(_, physical)| physical.outcome != Outcome::Arrived)
            .map(|(_, physical)| physical.outcome.name())
            .collect(),
        point_mean: mean_and_std(&of(&|(point, _)| point.accumulated_cost)).0,
        physical_mean: mean_and_std(&of(&|(_, physical)| physical.accumulated_cost)).0,
        against_without: None,
        mean_ratio: mean_and_std(&ratios).0,
        farthest_ratio: ratios.iter().copied().max_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(f64::NAN),
        alike: ratios.iter().filter(|ratio| off(ratio) <= ALIKE).count(),
        same_option: arrived().filter(|(point, physical)| point.last_option == physical.last_option).count(),
        transition_difference: differences.max().unwrap_or(0),
        position_error_rms: (squared / steps as f64).sqrt(),
        hand_force_rms: [mean_and_std(&forces).0, forces.iter().copied().fold(0.0, f64::max)],
        deflection: of(&|(_, p)| p.interaction.map_or(0.0, |i| i.deflection)).into_iter().fold(0.0, f64::max),
    }
}
