//! What the lanes of an environment share: rewards, and the decisions that actions stand for.

use super::observation::{Number, inputs, turned_into, velocity};
use cocarry::episode::{Episode, LOSS_DISTANCE_M, Outcome, prospects};
use cocarry::geometry::{PlanarPose, Point};
use cocarry::math;
use cocarry::plant::Command;
use cocarry::policy::{Decision, Motion};
use cocarry::preference::{objective_cost, subjective_cost};
use cocarry::robot::InputVector;
use cocarry::scenario::{GivenPerception, PreferenceChanges, PreparedScenario};
use std::sync::Arc;

/// How many times the steps of the longest option an episode of an environment that prices its ending may take, by
/// default.
const STEPS_OF_LONGEST: u64 = 3;
/// The most that a step costs, as a multiple of the tracking cost at which the object is lost: more than any
/// step of the built-in controller in the paper's environments, which is 7.4 times that.
const MOST_OF_LOSS: f64 = 10.0;

/// The length (m) of an option without a path.
const MAX_LENGTH_M: f64 = 1e6;

/// What the actions decide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Task {
    /// The option on which the robot leads, or to follow.
    Options,
    /// That, and the human's option and response.
    Both,
    /// The inputs u.
    Inputs,
    /// The velocity of the reference of eq. (7).
    Reference,
    /// What is added to the inputs u of the built-in controller.
    Residual,
}

/// The tasks by their names.
pub(super) const TASKS: [(&str, Task); 5] = [
    ("options", Task::Options),
    ("both", Task::Both),
    ("inputs", Task::Inputs),
    ("reference", Task::Reference),
    ("residual", Task::Residual),
];

/// When a lane that has ended begins anew.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Autoreset {
    /// In the next step, whose action is ignored.
    NextStep,
    /// In the same step.
    SameStep,
}

/// The price of an episode that ends without arriving.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ending {
    /// The most that a step may cost; by default see [`Rules::bound`].
    pub(super) most_step_cost: Option<f64>,
}

/// The bound of what an episode may cost: [`Bound::price`] is its proof.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bound {
    /// m: the most that a step costs.
    pub(super) step_cost: f64,
    /// N: the most steps that it takes.
    pub(super) steps: u64,
}

impl Bound {
    /// The price of ending after `steps` steps without arriving: m (2 N - k).
    ///
    /// A step costs at most m, and there are at most N - k more. So whoever goes on from here, in any way, pays at
    /// most m (N - k) and arrives, or pays at most m (j - k) and then m (2 N - j), which is m (2 N - k). And an
    /// episode that arrives has cost at most m N, which is less than this price alone unless k = N, where it
    /// is equal.
    fn price(&self, steps: u64) -> f64 {
        self.step_cost * (2 * self.steps).saturating_sub(steps) as f64
    }

    /// The share of its steps that is left.
    fn time_left(&self, steps: u64) -> f64 {
        self.steps.saturating_sub(steps) as f64 / self.steps as f64
    }
}

/// What all lanes share.
#[derive(Clone, Debug)]
pub(super) struct Rules {
    pub(super) task: Task,
    /// The scenarios to draw from, one for every world.
    pub(super) bases: Vec<Arc<PreparedScenario>>,
    /// How many preference changes are drawn for an episode; `None`: those of the scenario.
    pub(super) changes: Option<PreferenceChanges>,
    pub(super) given: GivenPerception,
    /// The largest number of options of a world.
    pub(super) options: usize,
    /// What an action of 1 stands for; none for options.
    pub(super) limits: Vec<f64>,
    /// Weights of J, J^ and C in the reward.
    pub(super) weights: [f64; 3],
    /// The number of steps after which an episode is truncated.
    pub(super) max_steps: Option<u64>,
    /// The number of steps after which a caller truncates an episode, whatever its task is.
    pub(super) max_episode_steps: Option<u64>,
    /// The price of an episode that ends without arriving, if it has one.
    pub(super) ending: Option<Ending>,
    /// Whether the built-in controller's action is told.
    pub(super) tells_built_in: bool,
    /// When a lane that has ended begins anew; `None`: it waits for its reset.
    pub(super) autoreset: Option<Autoreset>,
}

impl Rules {
    /// Whether actions are numbers that move a robot.
    pub(super) fn moves_robot(&self) -> bool {
        matches!(self.task, Task::Inputs | Task::Reference | Task::Residual)
    }

    /// Whether a world has fewer options than another.
    pub(super) fn is_masked(&self) -> bool {
        self.bases.iter().any(|base| base.options().options().len() != self.options)
    }

    /// What the numbers of an action of 1 are; none for options.
    pub(super) fn action_numbers(&self) -> Vec<Number> {
        match (self.task, self.bases.first().and_then(|base| base.robot())) {
            (Task::Reference, _) => velocity(),
            (Task::Inputs | Task::Residual, Some(robot)) => inputs(robot, "input"),
            _ => Vec::new(),
        }
    }

    /// Begins the next step; returns the outcome once the episode has ended. Where the human acts too, a copy looks
    /// ahead, since the human has not decided yet.
    pub(super) fn begin(
        &self,
        prepared: &PreparedScenario,
        episode: &mut Episode<'_>,
        bound: Option<&Bound>,
        into: &mut [f64],
    ) -> Option<Outcome> {
        let time_left = bound.map_or(0.0, |bound| bound.time_left(episode.summary().steps));
        if self.task == Task::Both {
            let mut ahead = episode.clone();
            let ended = ahead.begin_step();
            self.observe(prepared, &ahead, time_left, into);
            // asks nobody, and notes the outcome
            return ended.and_then(|_| episode.begin_step());
        }
        let ended = episode.begin_step();
        self.observe(prepared, episode, time_left, into);
        ended
    }

    /// The bound of an episode's cost, where its ending has a price. By default, a step costs at most
    /// [`MOST_OF_LOSS`] times the tracking cost at which the object is lost, Q (0.1 m)^2, and the largest J and J^ of
    /// the start, as far as they have a weight; it takes at most [`STEPS_OF_LONGEST`] times the steps of the longest
    /// option.
    pub(super) fn bound(&self, prepared: &PreparedScenario) -> Option<Bound> {
        let ending = self.ending?;
        let scenario = prepared.scenario();
        let risk_weight = scenario.settings.predictor.risk_weight();
        let mut options = prospects(prepared.options(), &prepared.options().begin());
        options.retain(|option| option.length < MAX_LENGTH_M);
        let largest = |costs: &mut dyn Iterator<Item = f64>| costs.fold(0.0, f64::max);
        let objective = largest(&mut options.iter().map(|option| objective_cost(*option, risk_weight)));
        let own = |option| subjective_cost(option, risk_weight, scenario.human);
        let subjective = largest(&mut options.iter().map(|option| own(*option)));
        let state_weight = scenario.plant.robot_setup().map_or(0.0, |setup| setup.control.state_weight);
        let costs = [objective, subjective, MOST_OF_LOSS * state_weight * LOSS_DISTANCE_M * LOSS_DISTANCE_M];
        let step_cost = ending.most_step_cost.unwrap_or_else(|| self.weighted(costs));
        let per_step = scenario.settings.speed * scenario.settings.planning_step;
        let longest = (largest(&mut options.iter().map(|option| option.length)) / per_step).ceil() as u64;
        let steps = self.max_steps.unwrap_or(STEPS_OF_LONGEST * longest.max(1));
        Some(Bound { step_cost, steps })
    }

    /// J, J^ and C by their weights.
    pub(super) fn weighted(&self, costs: [f64; 3]) -> f64 {
        self.weights.iter().zip(costs).map(|(weight, cost)| weight * cost).sum()
    }

    /// The reward of a step that took an episode to this many `steps`, with whether it then ended, and arrived.
    pub(super) fn reward(
        &self,
        costs: [f64; 3],
        bound: Option<&Bound>,
        (steps, is_over, has_arrived): (u64, bool, bool),
    ) -> f64 {
        let cost = self.weighted(costs);
        match bound {
            None => -cost,
            Some(bound) => {
                // a state that is no longer finite costs the most
                let cost = if cost.is_nan() { bound.step_cost } else { cost.min(bound.step_cost) };
                let ending = if is_over && !has_arrived { bound.price(steps) } else { 0.0 };
                -(cost + ending)
            }
        }
    }

    /// Whether an episode is cut short after this number of steps.
    pub(super) fn is_long(&self, steps: u64, bound: Option<&Bound>) -> bool {
        let most = bound.map(|bound| bound.steps).or(self.max_steps);
        [most, self.max_episode_steps].into_iter().flatten().any(|most| steps >= most)
    }

    /// The decision of an action. The last number of an action that moves a robot is the planning step, s.
    pub(super) fn decision(&self, episode: &mut Episode, action: &[f64]) -> Decision {
        if !self.moves_robot() {
            let option = action[0] as usize;
            return if option >= self.options { Decision::follow() } else { Decision::lead(option) };
        }
        let grasp =
            episode.robot_view().and_then(|view| view.grasp).map(|pose| PlanarPose::from_above(&pose));
        let decision = episode.ask_policy();
        let scaled = |i: usize| action[i] * self.limits[i];
        match (self.task, grasp) {
            (Task::Reference, Some(grasp)) => {
                // a constant velocity in the grasp's frame
                let period = action[action.len() - 1];
                let (sin, cos) = (math::sin(grasp.yaw), math::cos(grasp.yaw));
                let (ahead, left, turn) = (scaled(0), scaled(1), scaled(2));
                let poses = std::array::from_fn(|i| {
                    let time = (i + 1) as f64 * period;
                    let (x, y) = (cos * ahead - sin * left, sin * ahead + cos * left);
                    let position = Point::new(grasp.position.x + x * time, grasp.position.y + y * time);
                    PlanarPose { position, yaw: grasp.yaw + turn * time }
                });
                decision.with_motion(Motion::Reference(poses))
            }
            _ => {
                let mut u = InputVector::zeros();
                (0..self.limits.len()).for_each(|i| u[i] = scaled(i));
                let motion =
                    if self.task == Task::Residual { Motion::Residual(u) } else { Motion::Inputs(u) };
                decision.with_motion(motion)
            }
        }
    }

    /// What the built-in controller would do in a step that has begun: as an action, within the box, and as inputs u
    /// with the rates of eq. (8). Zeros once the episode is over.
    pub(super) fn built_in(&self, prepared: &PreparedScenario, episode: &Episode) -> BuiltIn {
        let count = prepared.robot().map_or(0, |robot| robot.drive.inputs() + robot.joint_count());
        let u = episode
            .controllers_command()
            .map_or_else(InputVector::zeros, |Command { rates, input, .. }| rates + input);
        let inputs = u.as_slice()[..count].to_vec();
        let physical = match self.task {
            Task::Residual => vec![0.0; count],
            Task::Reference => self.grasp_velocity(prepared, episode, &u),
            _ => inputs.clone(),
        };
        let action =
            physical.iter().zip(&self.limits).map(|(number, limit)| (number / limit).clamp(-1.0, 1.0));
        BuiltIn { action: action.collect(), inputs }
    }

    /// The velocity that inputs give the grasp, in its frame.
    fn grasp_velocity(&self, prepared: &PreparedScenario, episode: &Episode, u: &InputVector) -> Vec<f64> {
        let Some((robot, q)) = prepared.robot().zip(episode.configuration()) else { return vec![0.0; 3] };
        let at = robot.kinematics(q);
        let twist = at.jacobian * u;
        let [ahead, left] = turned_into(&PlanarPose::from_above(&at.grasp), [twist[0], twist[1]]);
        vec![ahead, left, twist[5]]
    }
}

/// What the built-in controller would do.
#[derive(Clone, Debug, Default)]
pub(super) struct BuiltIn {
    pub(super) action: Vec<f64>,
    pub(super) inputs: Vec<f64>,
}
