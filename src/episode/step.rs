//! The loop: the paper's algorithm, one planning step at a time. Every value is made once and passed on.

use super::evaluated::{Evaluated, Predicted};
use super::now::Now;
use super::outcome::Done;
use super::robot_tick::{Period, RobotTick};
use super::{Episode, Outcome, Tick};
use crate::controller::Way;
use crate::human::HumanDecision;
use crate::policy::Decision;
use crate::preference::subjective_cost;
use crate::team::Step;

/// A step that has begun: its values before the robot's policy decides.
#[derive(Clone, Debug)]
pub(super) struct Begun {
    pub evaluated: Evaluated,
    pub predicted: Predicted,
    pub human: HumanDecision,
    /// phi(k) as the robot takes it.
    pub stubbornness: f64,
}

impl Episode<'_> {
    /// Takes one planning step. Returns the outcome once the episode has ended.
    pub fn step(&mut self) -> Option<Outcome> {
        let ended = self.begin_step();
        if ended.is_none() {
            let lead = self.ask_policy(); //                            mode, o*(k)         eq. (6)
            self.finish_step(&lead);
        }
        ended
    }

    /// The first part of a step, up to the human's decision; then the policy, or a caller in its place, may
    /// [see](Episode::robot_view) it. Returns the outcome once the episode has ended. Nothing happens if the
    /// step has begun. [`Episode::state`] is valid between whole steps only.
    pub fn begin_step(&mut self) -> Option<Outcome> {
        if self.begun.is_some() {
            return None;
        }
        if let Some(outcome) = self.ended() {
            self.summary.outcome = outcome;
            return Some(outcome);
        }
        self.learn_from_walk();
        self.begun = Some(self.begin(self.now()));
        None
    }

    pub(super) fn begin(&mut self, now: Now) -> Begun {
        let (evaluated, predicted) = std::mem::take(&mut self.memory);
        let evaluated = self.evaluate(now, evaluated); //                  D_o, S_o, J_o       eq. (1)
        let predicted = self.predict(now, &evaluated, predicted); //       P_o, J~_o           eq. (4), (6)
        let human = self.ask_human(now, &evaluated, &predicted.prior); //  o_h, g(k), phi(k)   eq. (3), (5)
        let stubbornness = self.learn_from_lead(now, &human, &predicted.prior);
        Begun { evaluated, predicted, human, stubbornness }
    }

    /// The second part of a step that has begun, by this decision. Without a first part nothing happens.
    pub fn finish_step(&mut self, lead: &Decision) {
        let now = self.now();
        let Some(begun) = self.begun.take() else { return };
        let (executed, reverses_for) = self.execute(now, &begun.human, lead);
        let (from, position) = (self.route.along, self.progress.position);
        let heading = self.route.path.heading_at(from).unwrap_or(self.tick.heading);
        let before = self.plant.observe().position;
        let (robot, walked) = self.carry(&begun, lead); //                 q*, u, x            eq. (8), (7)
        let Begun { mut evaluated, mut predicted, human, .. } = begun;
        let objective_cost = evaluated.costs[executed].objective;
        let tick = Tick {
            step: now.step,
            time: now.time,
            position,
            heading,
            mode: lead.mode(),
            stubbornness: human.stubbornness,
            discomfort: human.discomfort,
            executed,
            preferred: human.option,
            reverses_for,
            objective_cost,
            accumulated_cost: self.summary.accumulated_cost + objective_cost,
            options: std::mem::take(predicted.options()),
            robot,
        };
        let (prospect, risk_weight) = (evaluated.prospects[executed], self.predictor.risk_weight());
        self.summary.add(&Done {
            tick: &tick,
            before: (now.step > 0).then_some(&self.tick),
            subjective_cost: human.perception.map(|own| subjective_cost(prospect, risk_weight, own)),
            has_changed: self.human.change(now.step).is_some(),
            walked,
            bodies: self.plant.observe().bodies,
            ignores_loss: self.ignores_loss,
        });
        // a hand that is steered need not go along the path
        let moved = human.hand.map_or(0.0, |_| (self.plant.observe().position - before).norm());
        let came_on = (self.route.along - from).abs().max(moved);
        let came_on = came_on > 0.1 * self.settings.speed * self.settings.planning_step;
        self.steps_without_progress = if came_on { 0 } else { self.steps_without_progress + 1 };
        self.decided = Some((human, *lead));
        // memory for the next step
        *predicted.options() = std::mem::replace(&mut self.tick, tick).options;
        std::mem::swap(&mut self.prospects, &mut evaluated.prospects);
        std::mem::swap(&mut self.ways, &mut evaluated.ways);
        self.memory = (evaluated, predicted);
    }

    /// Moves everybody by one planning step, in control periods. The robot's part, and the distance walked, m.
    fn carry(&mut self, begun: &Begun, lead: &Decision) -> (Option<RobotTick>, f64) {
        let count = self.settings.control_periods().expect("a scenario's check has refused other periods");
        let (mut robot, mut walked): (Option<RobotTick>, _) = (None, 0.0);
        self.plant.begin();
        for period in 0..count {
            let (moved, tick) = self.carry_one_period(begun, lead, [period, count]);
            walked += moved;
            robot = match (robot, tick) {
                (Some(before), Some(tick)) => Some(before.and(&tick)),
                (_, tick) => tick,
            };
        }
        (robot.map(|robot| robot.mean_of(count)), walked)
    }

    fn carry_one_period(
        &mut self,
        begun: &Begun,
        lead: &Decision,
        period: [u32; 2],
    ) -> (f64, Option<RobotTick>) {
        let (mode, stance) = (lead.mode(), begun.human.stance);
        let to = self.to(mode, stance);
        let (position, hand) = (self.point_at(to), self.hand(&begun.human, period));
        let (options, progress) = (self.options, &self.progress);
        let (path, from, travel) = (&self.route.path, self.route.along, self.route.travel);
        let step = Step { mode, travel, stance, hand, path, from, to, position };
        let seen = self.plant.observe();
        let way = Way {
            mode,
            motion: &lead.motion,
            options,
            progress,
            path,
            along: from,
            travel,
            walk: self.walk.as_ref(),
            period,
        };
        let command = self.controller.command(&seen, &way, &begun.predicted.robots().choice);
        let goal = self.walk.grasp_goal(&seen);
        let begin = seen.configuration.map(|configuration| (*configuration, goal));
        let human = self.walk.advance(&step, &seen);
        self.plant.step(&command, &human, self.settings.control_period());
        let seen = self.plant.observe();
        let place = self.walk.locate(&step, &seen);
        let goal = self.walk.grasp_goal(&seen);
        let robot = self.manipulator.zip(begin).map(|(manipulator, begin)| {
            let intended = self.walk.intended_grasp(&step, &seen);
            let period = Period { begin, end: seen, goal, intended, place };
            RobotTick::of(&manipulator, &command, &period, &mut self.body_poses)
        });
        (self.come_to(place.along), robot)
    }
}
