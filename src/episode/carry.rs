//! How a step is carried out: everybody moves, one control period at a time.

use super::outcome::{Before, Done};
use super::robot_tick::{Period, RobotTick};
use super::step::Begun;
use super::{EndMotions, Episode, Tick};
use crate::controller::Way;
use crate::geometry::Point;
use crate::plant::Command;
use crate::policy::{Decision, Motion};
use crate::team::Step;

/// A step that is being carried out.
#[derive(Clone, Debug)]
pub(super) struct Carried {
    pub begun: Begun,
    lead: Decision,
    executed: usize,
    reverses_for: Option<usize>,
    /// Position along the path (m), position (m) and heading (rad) of the team at the beginning, and what the
    /// plant showed as its position.
    from: f64,
    position: Point,
    heading: f64,
    seen_at: Point,
    /// The motion of both ends up to the beginning.
    ends: Option<EndMotions>,
    /// The number of control periods done, and the number of periods in the step.
    pub periods: [u32; 2],
    walked: f64,
}

impl Episode<'_> {
    /// Starts to carry out the decision `lead` of the robot's policy in a step that has
    /// [begun](Episode::begin_step); then [`Episode::carry_period`] moves everybody. Use it in place of
    /// [`Episode::finish_step`] to look at the episode, or to steer the hand, between control periods. Does
    /// nothing if no step has begun.
    pub fn lead_step(&mut self, lead: &Decision) {
        if let Some(carried) = self.led(lead) {
            self.carried = Some(carried);
        }
    }

    /// The rest of a step that has begun, to be carried out by the decision `lead`.
    pub(super) fn led(&mut self, lead: &Decision) -> Option<Carried> {
        let now = self.now();
        let begun = self.begun.take()?;
        let (executed, reverses_for) = self.execute(now, &begun.human, lead);
        let (from, position) = (self.route.along, self.progress.position);
        let heading = self.route.path.heading_at(from).unwrap_or(self.tick.heading);
        let seen = self.plant.observe();
        let (seen_at, ends) = (seen.position, self.tick.ends.or_else(|| EndMotions::at_rest(&seen)));
        let count = self.settings.control_periods().expect("a scenario's check has refused other periods");
        self.plant.begin();
        self.carried_robot = None;
        Some(Carried {
            begun,
            lead: *lead,
            executed,
            reverses_for,
            from,
            position,
            heading,
            seen_at,
            ends,
            periods: [0, count],
            walked: 0.0,
        })
    }

    /// Moves everybody by one control period of a step that is being [carried out](Episode::lead_step).
    /// Returns true if the step has further periods, and false after its last one. Without such a step it
    /// does nothing and returns false.
    pub fn carry_period(&mut self) -> bool {
        let Some(mut carried) = self.carried.take() else { return false };
        let goes_on = self.carry_on(&mut carried);
        if goes_on {
            self.carried = Some(carried);
        }
        goes_on
    }

    /// Moves everybody by one control period. Returns whether the step has further periods; after the last one
    /// it has ended.
    pub(super) fn carry_on(&mut self, carried: &mut Carried) -> bool {
        carried.walked += self.carry_one_period(&carried.begun, &carried.lead, carried.periods);
        carried.periods[0] += 1;
        let goes_on = carried.periods[0] < carried.periods[1];
        if !goes_on {
            self.end_step(carried);
        }
        goes_on
    }

    /// The number of control periods done in the present step, and the number of periods in a step; zeros
    /// between steps.
    pub fn periods(&self) -> [u32; 2] {
        self.carried.as_ref().map_or([0; 2], |carried| carried.periods)
    }

    /// Ends a step after its last control period.
    fn end_step(&mut self, carried: &mut Carried) {
        let now = self.now();
        let Carried { executed, reverses_for, from, position, heading, seen_at, ends, walked, .. } = *carried;
        let Carried { begun: Begun { evaluated, predicted, human, .. }, lead, periods: [_, count], .. } =
            carried;
        let objective_cost = evaluated.costs[executed].objective;
        let Tick { executed: last, preferred, mode, .. } = self.tick;
        let before = (now.step > 0).then_some(Before { executed: last, preferred, mode });
        // memory for the next step
        let options = std::mem::replace(predicted.options(), std::mem::take(&mut self.tick.options));
        self.tick = Tick {
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
            options,
            robot: None,
            ends: ends.and_then(|ends| ends.then(&self.plant.observe(), self.settings.planning_step)),
        };
        // what is large is copied only where there is a robot
        if let Some(robot) = &self.carried_robot {
            self.tick.robot = Some(robot.mean_of(*count));
            self.carried_robot = None;
        }
        let (prospect, risk_weight) = (evaluated.prospects[executed], self.predictor.risk_weight());
        let perceived = &mut self.perceived;
        let subjective_cost =
            human.perception.map(|own| perceived.subjective_cost(executed, prospect, risk_weight, own));
        self.summary.add(&Done {
            tick: &self.tick,
            before,
            subjective_cost,
            has_changed: self.human.change(now.step).is_some(),
            walked,
            shortest: evaluated.prospects.iter().map(|option| option.length).fold(f64::INFINITY, f64::min),
            speed: self.settings.speed,
            bodies: self.plant.observe().bodies,
            ignores_loss: self.ignores_loss,
        });
        // a hand that is steered need not go along the path
        let moved = human.hand.map_or(0.0, |_| (self.plant.observe().position - seen_at).norm());
        let came_on = (self.route.along - from).abs().max(moved);
        let came_on = came_on > 0.1 * self.settings.speed * self.settings.planning_step;
        self.steps_without_progress = if came_on { 0 } else { self.steps_without_progress + 1 };
        self.decided = Some((*human, *lead));
        std::mem::swap(&mut self.prospects, &mut evaluated.prospects);
        std::mem::swap(&mut self.ways, &mut evaluated.ways);
        self.memory = (std::mem::take(evaluated), std::mem::take(predicted));
    }

    /// The command that the controller, eqs. (8) and (7), would give in the first control period of a step that
    /// has [begun](Episode::begin_step), if the policy decided who leads and moved nothing itself; `None` between
    /// steps and without a robot. The episode stays as it is.
    pub fn controllers_command(&self) -> Option<Command> {
        self.begun.as_ref().and(self.manipulator)?;
        let mut copy = self.clone();
        let lead = copy.ask_policy().with_motion(Motion::Controlled);
        let Carried { begun, lead, periods, .. } = copy.led(&lead)?;
        Some(copy.command(&begun, &lead, periods))
    }

    /// The controller's command in a control period.
    fn command(&mut self, begun: &Begun, lead: &Decision, period: [u32; 2]) -> Command {
        let way = Way {
            mode: lead.mode(),
            motion: &lead.motion,
            options: self.options,
            progress: &self.progress,
            path: &self.route.path,
            along: self.route.along,
            travel: self.route.travel,
            walk: self.walk.as_ref(),
            period,
        };
        self.controller.command(&self.plant.observe(), &way, &begun.predicted.robots().choice)
    }

    /// Moves everybody by one control period: first the controller's command, then the human, then the plant.
    /// Adds the robot's part of the tick, if there is a robot. Returns how far the team came along the path, m.
    /// `period`: as [`Episode::periods`].
    fn carry_one_period(&mut self, begun: &Begun, lead: &Decision, period: [u32; 2]) -> f64 {
        let (mode, stance) = (lead.mode(), begun.human.stance);
        let to = self.to(mode, stance);
        let (position, hand) = (self.point_at(to), self.hand(&begun.human, period));
        let command = self.command(begun, lead, period);
        let (path, from, travel) = (&self.route.path, self.route.along, self.route.travel);
        let step = Step { mode, travel, stance, hand, path, from, to, position };
        let seen = self.plant.observe();
        let goal = self.walk.grasp_goal(&seen);
        let begin = seen.configuration.map(|configuration| (*configuration, goal));
        let human = self.walk.advance(&step, &seen);
        self.plant.step(&command, &human, self.settings.control_period());
        let seen = self.plant.observe();
        let place = self.walk.locate(&step, &seen);
        let goal = self.walk.grasp_goal(&seen);
        // what is large is copied only where there is a robot
        if let (Some(manipulator), Some(begin)) = (&self.manipulator, begin) {
            let intended = self.walk.intended_grasp(&step, &seen);
            let period = Period { begin, end: seen, goal, intended, place };
            let tick = RobotTick::of(manipulator, &command, &period, &mut self.body_poses);
            match &mut self.carried_robot {
                Some(before) => *before = before.and(&tick),
                none => *none = Some(tick),
            }
        }
        let came_to = if place.along == to { position } else { self.point_at(place.along) };
        self.come_to(place.along, came_to)
    }
}
