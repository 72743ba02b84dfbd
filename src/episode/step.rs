//! The loop: the paper's algorithm, one control period at a time.

use super::{Episode, OptionTick, Outcome, RobotTick, Transition, prospect};
use crate::coordination::{Mode, is_misaligned};
use crate::geometry::Pose;
use crate::human::{HumanDecision, Stance};
use crate::policy::{Decision, Lead};
use crate::preference::objective_cost;
use crate::simulation::Observation;
use crate::team::{Situation, Step, TurnOutcome};

impl Episode<'_> {
    /// Takes one planning step. Returns the outcome once the episode has ended.
    pub fn step(&mut self) -> Option<Outcome> {
        let ended = self.begin_step();
        if ended.is_none() {
            let decision = self.ask_policy(); //               mode, o*(k)              eq. (6)
            self.finish_step(&decision);
        }
        ended
    }

    /// The first part of a step, up to the human's decision; then the policy, or a caller in its place, may
    /// [see](Episode::robot_view) it. Returns the outcome once the episode has ended. Nothing happens if the
    /// step has begun. [`Episode::state`] is that of whole steps: take none in between.
    pub fn begin_step(&mut self) -> Option<Outcome> {
        if self.human_decision.is_some() {
            return None;
        }
        if let Some(outcome) = self.ended() {
            self.summary.outcome = outcome;
            return Some(outcome);
        }
        self.learn_from_walk();
        self.observe();
        self.evaluate_options(); //                            D_o, S_o, J_o            eq. (1)
        self.predict_choice(); //                              P_o, J~_o                eq. (4), (6)
        let human = self.ask_human(); //                       o_h, g(k), phi(k)        eq. (3), (5)
        self.human_decision = Some(self.learn_from_lead(human));
        None
    }

    /// The second part of a step that has begun, by this decision. Without a first part nothing happens.
    pub fn finish_step(&mut self, decision: &Decision) {
        let Some(human) = self.human_decision.take() else { return };
        self.decided = Some((human, *decision));
        self.lead(decision);
        self.execute(&human, decision);
        let robot = self.control(decision); //                 q*, u                    eq. (8), (7)
        self.walk(&human, robot);
    }

    fn observe(&mut self) {
        self.tick.step = self.summary.steps;
        self.tick.time = self.tick.step as f64 * self.settings.period;
        self.tick.position = self.progress.position;
    }

    fn evaluate_options(&mut self) {
        let toward = self.underway.then(|| self.options.next(&self.progress, self.tick.executed));
        self.tick.options.clear();
        self.prospects.clear();
        for o in 0..self.options.options().len() {
            let remaining = self.options.remaining(&self.progress, o);
            let prospect = prospect(remaining);
            self.prospects.push(prospect);
            self.tick.options.push(OptionTick {
                remaining,
                objective: objective_cost(prospect, self.predictor.risk_weight()),
                expected: f64::NAN,
                probability: f64::NAN,
                // g(0) = 0: before the first step the team has no next waypoint
                misaligned: self.mode == Mode::RobotLed
                    && toward.is_some_and(|toward| is_misaligned(toward, remaining.next)),
            });
        }
    }

    fn predict_choice(&mut self) {
        let robot_leads = self.mode == Mode::RobotLed;
        if self.predicts_choice() {
            let current = self.underway.then_some(self.tick.executed);
            self.predictor.predict_from(&self.prospects, current, &mut self.choice);
            for (tick, p) in self.tick.options.iter_mut().zip(self.choice.probabilities()) {
                tick.probability = *p;
            }
        }
        if robot_leads || self.policy.predicts() {
            self.predictor.expected_costs(&self.prospects, &mut self.expected);
            for (tick, cost) in self.tick.options.iter_mut().zip(&self.expected) {
                tick.expected = *cost;
            }
        }
    }

    /// Whether P_o is needed in this step.
    pub(super) fn predicts_choice(&self) -> bool {
        let is_needed = self.team.anticipates() || self.policy.predicts();
        self.mode == Mode::RobotLed || is_needed || self.settings.predict_while_human_leads
    }

    fn lead(&mut self, decision: &Decision) {
        if self.mode == Mode::RobotLed && decision.mode() == Mode::HumanLed && self.underway {
            self.summary.transition = Some(Transition { step: self.tick.step, position: self.tick.position });
        }
        self.mode = decision.mode();
        self.tick.mode = self.mode;
    }

    fn execute(&mut self, human: &HumanDecision, decision: &Decision) {
        let current = self.underway.then_some(self.tick.executed);
        let option = match decision.lead {
            Lead::Robot(option) => option.min(self.tick.options.len() - 1),
            Lead::Human => human.option,
            Lead::HumanKeepingOption => current.unwrap_or(human.option),
        };
        self.tick.reverses_for = None;
        match current {
            None => {
                let path = self.options.path(&self.progress, option).unwrap_or_default();
                self.route.begin(self.team.walkable(path, self.options));
                self.tick.executed = option;
                self.summary.first_option = option;
                self.underway = true;
            }
            Some(executed) if executed == option => self.route.keep(),
            Some(_) => {
                let team = self.team.as_mut();
                match self.route.turn_onto(option, team, self.options, &self.progress) {
                    TurnOutcome::Turned => {
                        self.tick.executed = option;
                        self.summary.option_changes += 1;
                    }
                    TurnOutcome::Reverses => self.tick.reverses_for = Some(option),
                    TurnOutcome::GoesOn => {}
                }
            }
        }
        let executed = self.tick.executed;
        self.tick.objective_cost = self.tick.options[executed].objective;
        self.tick.heading = self.route.path.heading_at(self.route.along).unwrap_or(self.tick.heading);
        let prospect = self.prospects[executed];
        self.summary.add_executed(executed, &self.tick, human, prospect, self.predictor.risk_weight());
        self.tick.accumulated_cost = self.summary.accumulated_cost;
    }

    fn control(&mut self, decision: &Decision) -> Option<RobotTick> {
        self.team.control(&Situation {
            mode: self.mode,
            travel: self.route.travel,
            options: self.options,
            progress: &self.progress,
            choice: &self.choice,
            path: &self.route.path,
            along: self.route.along,
            motion: &decision.motion,
        })
    }

    fn walk(&mut self, human: &HumanDecision, mut robot: Option<RobotTick>) {
        let (from, length) = (self.route.along, self.route.path.length());
        let per_step = self.settings.speed * self.settings.period;
        let resists = human.stance == Stance::Resist && self.mode == Mode::RobotLed;
        let to = if resists { from } else { from + per_step };
        // a remainder shorter than rounding is not a step of its own
        let to = if to >= length - 1e-9 { length } else { to };
        let step = Step {
            mode: self.mode,
            travel: self.route.travel,
            human,
            path: &self.route.path,
            from,
            to,
            position: self.point_at(to),
        };
        let before = self.team.observation().map(|seen| seen.object);
        let along = self.team.walk(&step, robot.as_mut());
        self.summary.add(robot.as_ref(), self.team.observation(), self.ignores_loss);
        self.tick.robot = robot;
        // a hand that is steered need not go along the path
        let strayed = human.hand.map_or(0.0, |_| self.moved(before));
        let came_on = (along - from).abs().max(strayed) > 0.1 * per_step;
        self.steps_without_progress = if came_on { 0 } else { self.steps_without_progress + 1 };
        let position = self.point_at(along);
        self.options.advance(&mut self.progress, position);
        self.summary.walked += (along - from).abs();
        self.route.along = along;
        self.summary.steps += 1;
    }

    /// How far the object has moved from its pose `before`, m.
    fn moved(&self, before: Option<Pose>) -> f64 {
        let moved = |(before, seen): (Pose, &Observation)| {
            (seen.object.translation.vector - before.translation.vector).xy().norm()
        };
        before.zip(self.team.observation()).map_or(0.0, moved)
    }
}
