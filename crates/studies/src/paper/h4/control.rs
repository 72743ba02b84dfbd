//! H4 with the robot's arm: the control cost when eqs. (7) and (8) use the belief about the person. Eq.
//! (7) follows the option that is most probable, eq. (8) weighs all of them; without pose optimisation, or
//! with equal weights, what was learned has an effect on eq. (7) only.

use super::{ALL_WORLDS, HumanKind, LearningStudy, PersonRow, RobotKind, Task, Tasks};
use crate::paper::h3::PoseMethod;
use crate::parallel::{OnDone, in_parallel};
use crate::statistics::{self, Paired, mean_and_std};
use cocarry::Error;
use cocarry::policy::Method;
use serde::Serialize;

/// The most humans in each world who carry with an arm; their control takes most of the time.
pub const MAX_HUMANS: usize = 100;

/// Who leads, and how the robot chooses its configuration. With `human-led`, the human's way is the same with
/// every robot, and only control differs.
pub const ROBOTS_WITH_ARM: [(Method, PoseMethod); 4] = [
    (Method::HUMAN_LED, PoseMethod::WithPo),
    (Method::HUMAN_LED, PoseMethod::UniformWeights),
    (Method::HUMAN_LED, PoseMethod::WithoutPo),
    (Method::MUTUAL, PoseMethod::WithPo),
];

/// One robot with humans of the model, in one of their tasks, on the kinematic plant.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ControlRow {
    /// The world, [`RANDOM_WORLDS`](super::RANDOM_WORLDS) or [`ALL_WORLDS`].
    pub world: String,
    /// Who leads.
    pub method: String,
    /// How the robot chooses its configuration.
    pub pose: PoseMethod,
    /// The task, from 1.
    pub task: usize,
    /// The robot.
    pub robot: RobotKind,
    /// Number of humans.
    pub episodes: usize,
    /// Episodes that did not arrive.
    pub not_arrived: usize,
    /// Episodes in which the grasp was off by more than 10 cm. They go on, since the paper simulates no object,
    /// and cost many times as much.
    pub lost_object: usize,
    /// Mean control cost C of all episodes.
    pub control_cost: f64,
    /// Its standard deviation.
    pub control_cost_std: f64,
    /// Mean parts of C: tracking, effort, pose.
    pub parts: [f64; 3],
    /// The difference to [`RobotKind::Prior`] with the same humans, of those who arrive both times; corrected
    /// for all comparisons of the table.
    pub control_cost_against_prior: Option<Paired>,
}

impl LearningStudy<'_> {
    fn humans_with_arm(&self) -> usize {
        self.humans.min(MAX_HUMANS)
    }

    pub(super) fn control_units(&self) -> usize {
        ROBOTS_WITH_ARM.len() * self.group_count() * self.humans_with_arm()
    }

    /// The control costs, by method, pose optimisation and world. Adds the rows of their people to `people`.
    pub(super) fn control(
        &self,
        people: &mut Vec<PersonRow>,
        on_done: OnDone,
    ) -> Result<Vec<ControlRow>, Error> {
        let n = self.humans_with_arm();
        let mut rows = Vec::new();
        for (method, pose) in ROBOTS_WITH_ARM {
            let mut plant = self.plant.clone();
            plant
                .robot_setup_mut()
                .into_iter()
                .for_each(|robot| robot.control = pose.choosing(&robot.control));
            let groups = self.groups(method, &plant)?;
            let person = |i: usize| self.person(i / n, HumanKind::Model, i % n);
            let all = in_parallel(groups.len() * n, on_done, |i| {
                let worlds = &groups[i / n].worlds;
                self.tasks_of(&worlds[i % n % worlds.len()], &person(i))
            });
            let all = all.into_iter().collect::<Result<Vec<Tasks>, Error>>()?;
            for (i, tasks) in all.iter().enumerate() {
                let (group, robot) = (&groups[i / n], (method, Some(pose)));
                people.extend(self.person_rows(robot, group, person(i), (i / n, i % n), tasks));
            }
            for (group, people) in groups.iter().zip(all.chunks(n)) {
                rows.extend(self.control_rows(&group.name, (method, pose), people));
            }
            rows.extend(self.control_rows(ALL_WORLDS, (method, pose), &all));
        }
        statistics::correct(rows.iter_mut().filter_map(|row| row.control_cost_against_prior.as_mut()));
        Ok(rows)
    }

    fn control_rows(
        &self,
        world: &str,
        (method, pose): (Method, PoseMethod),
        people: &[Tasks],
    ) -> Vec<ControlRow> {
        let of = |task: usize, robot: usize| people.iter().map(move |tasks| &tasks[robot][task]);
        let cells =
            (0..self.tasks).flat_map(|task| RobotKind::ALL.into_iter().enumerate().map(move |r| (task, r)));
        cells
            .map(|(task, (robot, kind))| {
                let costs: Vec<f64> = of(task, robot).map(Task::control_cost).collect();
                let both = of(task, robot).zip(of(task, 0)).filter(|(a, b)| a.arrived && b.arrived);
                let (first, second): (Vec<f64>, Vec<f64>) =
                    both.map(|(a, b)| (a.control_cost(), b.control_cost())).unzip();
                let (control_cost, control_cost_std) = mean_and_std(&costs);
                let part = |part: usize| {
                    mean_and_std(&of(task, robot).map(|t| t.control_cost[part]).collect::<Vec<f64>>()).0
                };
                ControlRow {
                    world: world.to_owned(),
                    method: method.to_string(),
                    pose,
                    task: task + 1,
                    robot: kind,
                    episodes: people.len(),
                    not_arrived: of(task, robot).filter(|t| !t.arrived).count(),
                    lost_object: of(task, robot).filter(|t| t.lost_object).count(),
                    control_cost,
                    control_cost_std,
                    parts: std::array::from_fn(part),
                    control_cost_against_prior: (robot > 0)
                        .then(|| Paired::of_lists(&first, &second, true))
                        .flatten(),
                }
            })
            .collect()
    }
}
