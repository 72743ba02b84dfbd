//! A row for every person, task and robot of H4.

use super::{HumanKind, Person, RobotKind, Tasks};
use crate::paper::h3::PoseMethod;
use cocarry::policy::Method;
use serde::Serialize;

/// One task of one person with one robot.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PersonRow {
    /// Who leads.
    pub method: String,
    /// The robot's pose optimisation; `None` where the team is a point.
    pub pose: Option<PoseMethod>,
    /// The world, or [`RANDOM_WORLDS`](super::RANDOM_WORLDS).
    pub world: String,
    /// Its number among the worlds of this name, from 0.
    pub world_number: usize,
    /// How the person decides.
    pub humans: HumanKind,
    /// The stream of the seed's generator from which the person is drawn. People of one stream are the same,
    /// as far as their kinds let them.
    pub stream: u64,
    /// The task, from 1.
    pub task: usize,
    /// The robot.
    pub robot: RobotKind,
    /// alpha in this task.
    pub alpha: f64,
    /// gamma in this task.
    pub gamma: f64,
    /// eta.
    pub eta: f64,
    /// Its result.
    #[serde(flatten)]
    pub result: Task,
}

/// The result of a task.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Task {
    /// Whether the team arrived.
    pub arrived: bool,
    /// Regret over the steps that the robot leads.
    pub regret: f64,
    /// Sum of J^ of the executed option, with the person's alpha and gamma.
    pub human_cost: f64,
    /// Sum of J of the executed option, m.
    #[serde(rename = "objective_cost_m")]
    pub objective_cost: f64,
    /// Share of the steps on another option than the person prefers.
    pub share_off_preference: f64,
    /// Whether the person took over.
    pub took_over: bool,
    /// Parts of C: tracking, effort, pose; 0 where the team is a point.
    pub control_cost: [f64; 3],
    /// Whether the grasp was off by more than 10 cm.
    pub lost_object: bool,
}

impl Task {
    /// Control cost C.
    pub fn control_cost(&self) -> f64 {
        self.control_cost.iter().sum()
    }
}

/// Where, and with which robots, a group of people carries.
#[derive(Clone, Copy)]
pub(super) struct Setting<'a> {
    pub method: Method,
    pub pose: Option<PoseMethod>,
    pub world: &'a str,
    pub world_number: usize,
    pub stream: u64,
}

/// The rows of one person.
pub(super) fn rows<'a>(
    setting: Setting<'a>,
    person: &'a Person,
    all: &'a Tasks,
) -> impl Iterator<Item = PersonRow> + 'a {
    let Setting { method, pose, world, world_number, stream } = setting;
    RobotKind::ALL.into_iter().zip(all).flat_map(move |(robot, tasks)| {
        tasks.iter().enumerate().map(move |(task, result)| PersonRow {
            method: method.to_string(),
            pose,
            world: world.to_owned(),
            world_number,
            humans: person.kind,
            stream,
            task: task + 1,
            robot,
            alpha: person.perceptions[task].alpha,
            gamma: person.perceptions[task].gamma,
            eta: person.eta,
            result: *result,
        })
    })
}
