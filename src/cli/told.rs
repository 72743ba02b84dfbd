//! The report of an episode that `cocarry run` prints, as text and as JSON.

use super::output::{OPTION_HEADINGS, table, table_text};
use crate::coordination;
use crate::drawing::Track;
use crate::episode::{
    ControlSummary, GRASP_WARNING_RMS_M, HumanSummary, Loss, Outcome, PreferenceChange, Settings, Summary,
    Tick, Transition,
};
use crate::geometry::Point;
use crate::policy::Method;
use crate::preference::Perception;
use crate::robot::Robot;
use crate::scenario::{Carrier, Stage};
use crate::simulation::BodyKind;
use serde_json::{Value, json};
use std::fmt::Write;

/// An episode that is over, with all that is told of it.
pub(super) struct Told<'a> {
    pub stage: &'a Stage,
    /// The step that it went on from; none if it was run from its beginning.
    pub resumed: Option<u64>,
    pub summary: Summary,
    /// Its ticks, from there on.
    pub ticks: Vec<Tick>,
}

impl Told<'_> {
    fn settings(&self) -> &Settings {
        &self.stage.scenario().settings
    }

    fn method(&self) -> Method {
        self.settings().method
    }

    /// The robot, and how it was asked to carry.
    fn carrier(&self) -> Option<(&Robot, &Carrier)> {
        self.stage.robot().zip(self.stage.scenario().plant.carrier())
    }

    fn option_name(&self, option: usize) -> &str {
        &self.stage.options().options()[option].name
    }

    fn openings(&self, option: usize) -> Vec<&str> {
        let crossings = &self.stage.options().options()[option].crossings;
        crossings.iter().map(|c| self.stage.world().openings[c.opening].name.as_str()).collect()
    }

    /// Ticks at which the executed option changed, with the option before.
    fn changes(&self) -> impl Iterator<Item = (usize, &Tick)> {
        self.ticks.windows(2).filter(|w| w[0].executed != w[1].executed).map(|w| (w[0].executed, &w[1]))
    }

    /// The tick of a step, if it is among those that are told.
    fn tick(&self, step: u64) -> Option<&Tick> {
        let first = self.ticks.first()?.step;
        self.ticks.get(usize::try_from(step.checked_sub(first)?).ok()?)
    }

    /// The human's changes of mind that came about, in their order.
    fn changes_of_mind(&self) -> Vec<PreferenceChange> {
        let mut standing = PreferenceChange::in_force(&self.stage.scenario().changes);
        standing.retain(|change| change.step < self.summary.steps);
        standing
    }

    fn place(&self, step: u64, at: Point) -> String {
        format!("{} at ({:.2}, {:.2}) m", self.when(step), at.x, at.y)
    }

    fn when(&self, step: u64) -> String {
        format!("step {step:>4} ({:5.1} s)", self.seconds(step))
    }

    fn seconds(&self, step: u64) -> f64 {
        step as f64 * self.settings().period
    }

    pub fn track(&self) -> Track {
        Track::new(self.method().name().to_owned(), &self.ticks, self.end())
    }

    /// The target, if the team arrived there.
    fn end(&self) -> Option<Point> {
        (self.summary.outcome == Outcome::Arrived).then(|| self.stage.options().target())
    }

    pub fn as_text(&self) -> String {
        let (world, summary) = (self.stage.world(), &self.summary);
        let coordination::Settings { eta, initial_stubbornness } = self.settings().coordination;
        let mut text = format!("{} ({})\n", world.name, world.file);
        let method = self.method().name();
        let from =
            self.resumed.map_or("the start".to_owned(), |step| format!("step {step}, where it went on"));
        let Perception { alpha, gamma } = self.stage.scenario().human;
        text += &format!(
            "human: alpha {alpha:.4}, gamma {gamma:.4}; method {method}, eta {eta}, phi(0) {initial_stubbornness}\n\nOptions at {from}\n"
        );
        let mut options = table(OPTION_HEADINGS, 2);
        for (o, option) in self.ticks.first().into_iter().flat_map(|t| t.options.iter().enumerate()) {
            options.add_row([
                self.option_name(o).to_owned(),
                self.openings(o).join(" "),
                format!("{:.2}", option.remaining.length),
                format!("{:.3}", option.remaining.risk),
                format!("{:.2}", option.objective),
                number_or_dash(option.expected, 2),
                format!("{:.1}", 100.0 * option.probability),
            ]);
        }
        text += &table_text(&options);
        text += "\nWhat happened\n";
        for event in self.events() {
            let _ = writeln!(text, "  {event}");
        }
        text += &format!("  accumulated objective cost {:.2} m\n", summary.accumulated_cost);
        let HumanSummary { stubbornness, discomfort, subjective_cost, .. } = summary.human;
        let _ = writeln!(
            text,
            "  to the human: final phi {stubbornness:.3}, discomfort g {discomfort:.2}; {:.0} % of the steps off the option preferred; accumulated \
             subjective cost {subjective_cost:.2}",
            100.0 * summary.human.share_off_preference(summary.steps)
        );
        if let (Some((robot, carrier)), Some(control)) = (self.carrier(), &summary.control) {
            text += &self.control_text(robot, &carrier.posture, control);
        }
        for warning in self.warnings() {
            let _ = writeln!(text, "\nwarning: {warning}");
        }
        text
    }

    fn control_text(&self, robot: &Robot, posture: &str, control: &ControlSummary) -> String {
        let steps = self.summary.steps;
        let mut text = format!(
            "\nThe robot ({}, starting from `{}`)\n  control cost C {:.1}: tracking {:.1}, effort {:.1}, pose {:.1}\n",
            robot.name,
            posture,
            control.cost(),
            control.tracking,
            control.effort,
            control.pose
        );
        let _ = writeln!(
            text,
            "  tracking error {:.1} mm rms, {:.1} mm at most; limits active in {} of {steps} steps, configuration changed in {}",
            1e3 * control.error_rms(steps),
            1e3 * control.largest_error,
            control.constrained_steps,
            control.pose_changes
        );
        if control.least_clearance.is_finite() {
            let _ = writeln!(
                text,
                "  base at least {:.3} m clear of obstacles{}",
                control.least_clearance,
                if control.overlapping_steps > 0 {
                    ": it overlaps one; this plant does not stop it"
                } else {
                    ""
                }
            );
        }
        if let Some(interaction) = &self.summary.interaction {
            let _ = writeln!(
                text,
                "  the human's force on the object: mean {:.1} N, rms {:.1} N; either grip at most {:.0} N, yielding at most {:.1} cm",
                interaction.mean_force(),
                interaction.rms_force(),
                interaction.peak_force,
                100.0 * interaction.stretch
            );
            let _ = writeln!(
                text,
                "  the arm's motors exert at most {:.0} % of their effort limits",
                100.0 * interaction.effort_share
            );
        }
        if control.fallback_steps > 0 {
            let _ =
                writeln!(text, "  no solution of eq. (7) in {} steps: see --ticks", control.fallback_steps);
        }
        text
    }

    /// What is to be doubted: of the scenario, and of how it went.
    fn warnings(&self) -> Vec<String> {
        let rms = self.summary.control.map(|control| control.error_rms(self.summary.steps));
        let off = rms.filter(|rms| *rms >= GRASP_WARNING_RMS_M).map(|rms| {
            format!(
                "the grasp is {:.1} cm (rms) off where it should be, {:.0} cm or more: the robot does not keep up",
                100.0 * rms,
                100.0 * GRASP_WARNING_RMS_M
            )
        });
        self.stage.slow_drive().map(|slow| slow.to_string()).into_iter().chain(off).collect()
    }

    fn events(&self) -> Vec<String> {
        let summary = &self.summary;
        if summary.steps == 0 {
            return vec!["no step was taken".to_owned()];
        }
        let leader = |tick: &Tick| match tick.mode {
            coordination::Mode::RobotLed => "the robot leads",
            coordination::Mode::HumanLed => "the human leads",
        };
        let at = |tick: &Tick| self.place(tick.step, tick.position);
        let begin = self.ticks.first().map(|first| {
            (
                first.step,
                format!(
                    "{}: {} on option {}; this human prefers option {}",
                    at(first),
                    leader(first),
                    self.option_name(first.executed),
                    self.option_name(first.preferred)
                ),
            )
        });
        let mut events: Vec<_> = begin.into_iter().collect();
        for change in self.changes_of_mind() {
            let Perception { alpha, gamma } = change.perception;
            let tick = self.tick(change.step);
            let place = tick.map_or_else(|| self.when(change.step), at);
            let prefers = tick.map_or(String::new(), |tick| {
                format!("; they prefer option {} from here", self.option_name(tick.preferred))
            });
            let words = format!("the human's mind changes: alpha {alpha:.4}, gamma {gamma:.4}");
            events.push((change.step, format!("{place}: {words}{prefers}")));
        }
        let mind_changes = self.changes_of_mind();
        for pair in self.ticks.windows(2).filter(|w| w[0].preferred != w[1].preferred) {
            let [before, now] = [&pair[0], &pair[1]];
            // told with the change itself
            if mind_changes.iter().any(|change| change.step == now.step) {
                continue;
            }
            let [from, to] = [before, now].map(|tick| self.option_name(tick.preferred));
            events.push((
                now.step,
                format!("{}: this human now prefers option {to} to option {from}", at(now)),
            ));
        }
        if let Some(Transition { step, position }) = summary.transition {
            let told = self.tick(step);
            let stubbornness = told.map_or(String::new(), |tick| format!(" ({:.3})", tick.stubbornness));
            let place = self.place(step, position);
            events.push((
                step,
                format!("{place}: stubbornness passes 1{stubbornness}, the human takes the lead"),
            ));
        }
        for (before, tick) in self.changes() {
            let (from, to) = (self.option_name(before), self.option_name(tick.executed));
            events.push((
                tick.step,
                format!("{}: {} from option {from} to option {to}", at(tick), leader(tick)),
            ));
        }
        let begins = |w: &&[Tick]| w[0].steps_back_for.is_none();
        for back in self.ticks.windows(2).filter(begins) {
            if let Some(option) = back[1].steps_back_for {
                let words = format!("the team steps back, to turn onto option {}", self.option_name(option));
                events.push((back[1].step, format!("{}: {words}", at(&back[1]))));
            }
        }
        events.sort_by_key(|(step, _)| *step);
        let mut events: Vec<String> = events.into_iter().map(|(_, event)| event).collect();
        let end = match summary.outcome {
            Outcome::Arrived => "arrived at B",
            Outcome::OutOfTime => "did not arrive: the step limit is reached",
            Outcome::NoWay => "did not arrive: no way leads on from here",
            Outcome::Collided => "did not arrive: collided",
            Outcome::Stuck => "did not arrive: stuck for ten seconds",
            Outcome::Dropped => "did not arrive: the object fell",
            Outcome::ObjectLost => "did not arrive: the object was lost",
            Outcome::NonFinite => "did not arrive: the physics broke down",
        };
        if let Some(Loss { by, step, distance }) = summary.loss {
            let words = match by {
                BodyKind::Human => "the human's grip yielded by",
                _ => "the robot's grasp was off by",
            };
            events.push(format!(
                "{}: {words} {:.1} cm: it lost the object",
                self.when(step),
                100.0 * distance
            ));
        }
        if let Some(contact) = &summary.collision {
            let [first, second] = &contact.between;
            events.push(format!(
                "the {}'s {} touched {} at ({:.2}, {:.2}, {:.2}) m, {:.1} mm deep, {:.0} N",
                first.kind.name(),
                first.name,
                second.name,
                contact.point.x,
                contact.point.y,
                contact.point.z,
                1e3 * contact.depth,
                contact.force
            ));
        }
        events.push(format!(
            "{}: {end} on option {} after {:.2} m",
            self.when(summary.steps),
            self.option_name(summary.last_option),
            summary.walked
        ));
        events
    }

    pub fn as_json(&self) -> Value {
        let (world, scenario, settings) = (self.stage.world(), self.stage.scenario(), self.settings());
        let summary = &self.summary;
        let mut told = json!({
            "world": world.name,
            "file": world.file,
            "human": { "alpha": scenario.human.alpha, "gamma": scenario.human.gamma },
            "preference_changes": self.changes_as_json(),
            "method": settings.method.name(),
            "eta": settings.coordination.eta,
            "initial_stubbornness": settings.coordination.initial_stubbornness,
            "risk_weight_m": settings.predictor.risk_weight(),
            "seed": scenario.seed,
            "period_s": settings.period,
            "speed_m_per_s": settings.speed,
            "options": self.ticks.first().into_iter().flat_map(|t| t.options.iter().enumerate()).map(|(o, option)| json!({
                "name": self.option_name(o),
                "openings": self.openings(o),
                "length_m": option.remaining.length,
                "risk": option.remaining.risk,
                "objective": option.objective,
                "expected_subjective": option.expected,
                "probability": option.probability,
            })).collect::<Vec<_>>(),
            "preferred_at_start": self.ticks.first().map(|t| self.option_name(t.preferred)),
            "first_option": self.option_name(summary.first_option),
            "last_option": self.option_name(summary.last_option),
            "option_changes": self.changes().map(|(before, tick)| json!({
                "step": tick.step,
                "from": self.option_name(before),
                "to": self.option_name(tick.executed),
            })).collect::<Vec<_>>(),
            "transition": summary.transition.map(|t| json!({
                "step": t.step,
                "time_s": self.seconds(t.step),
                "position_m": [t.position.x, t.position.y],
            })),
            "outcome": summary.outcome.name(),
            "steps": summary.steps,
            "time_s": self.seconds(summary.steps),
            "walked_m": summary.walked,
            "accumulated_objective_cost_m": summary.accumulated_cost,
            "robot": self.carrier().map(|(robot, c)| json!({
                "name": robot.name,
                "file": robot.texts.file,
                "posture": c.posture,
                "candidates": c.control.candidates,
                "criterion": c.control.criterion,
                "avoid": c.control.avoid,
            })),
            "control": summary.control.map(|c| json!({
                "cost": c.cost(),
                "tracking": c.tracking,
                "effort": c.effort,
                "pose": c.pose,
                "position_error_rms_m": c.error_rms(summary.steps),
                "largest_position_error_m": c.largest_error,
                "constrained_steps": c.constrained_steps,
                "fallback_steps": c.fallback_steps,
                "pose_changes": c.pose_changes,
                "overlapping_steps": c.overlapping_steps,
                "least_base_clearance_m": c.least_clearance,
            })),
            "interaction": summary.interaction.map(|i| json!({
                "hand_force_mean_n": i.mean_force(),
                "hand_force_rms_n": i.rms_force(),
                "peak_force_n": i.peak_force,
                "robot_work_j": i.work[0],
                "human_work_j": i.work[1],
                "squared_jerk_m2_per_s5": i.squared_jerk,
                "force_noise_rms_n": i.force_noise(),
                "largest_stretch_m": i.stretch,
                "largest_effort_share": i.effort_share,
            })),
            "loss": summary.loss.map(|loss| json!({
                "by": loss.by.name(),
                "step": loss.step,
                "time_s": self.seconds(loss.step),
                "distance_m": loss.distance,
            })),
            "collision": summary.collision.as_ref().map(|c| json!({
                "between": c.between.each_ref().map(|part| json!({
                    "party": part.kind.name(),
                    "name": part.name,
                })),
                "point_m": [c.point.x, c.point.y, c.point.z],
                "depth_m": c.depth,
                "force_n": c.force,
            })),
        });
        let human = &summary.human;
        for (key, value) in [
            ("final_stubbornness", json!(human.stubbornness)),
            ("final_discomfort", json!(human.discomfort)),
            ("share_off_preference", json!(human.share_off_preference(summary.steps))),
            ("accumulated_subjective_cost", json!(human.subjective_cost)),
            ("changes_of_mind", json!(human.changes_of_mind)),
            ("preference_switches", json!(human.preference_switches)),
            ("warnings", json!(self.warnings())),
        ] {
            told[key] = value;
        }
        if let Some(step) = self.resumed {
            told["resumed_at_step"] = json!(step);
        }
        told
    }

    /// All changes of mind that the scenario has, by their steps; which came about, and what the human preferred from there on, where that is
    /// known: not before the step that the episode went on from.
    fn changes_as_json(&self) -> Vec<Value> {
        let came_about = self.changes_of_mind();
        let mut given = self.stage.scenario().changes.clone();
        given.sort_by_key(|change| change.step);
        let is_last = |i: usize| given.get(i + 1).is_none_or(|next| next.step != given[i].step);
        let told = given.iter().enumerate().map(|(i, change)| {
            let is_applied = is_last(i) && came_about.contains(change);
            let tick = self.tick(change.step).filter(|_| is_applied);
            json!({
                "step": change.step,
                "time_s": self.seconds(change.step),
                "alpha": change.perception.alpha,
                "gamma": change.perception.gamma,
                "applied": is_applied,
                "preferred": tick.map(|tick| self.option_name(tick.preferred)),
            })
        });
        told.collect()
    }
}

fn number_or_dash(value: f64, digits: usize) -> String {
    if value.is_finite() { format!("{value:.digits$}") } else { "-".to_owned() }
}
