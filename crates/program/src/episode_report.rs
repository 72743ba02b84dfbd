//! The report of an episode that `cocarry run` prints, as text and as JSON.

use super::output::{OPTION_HEADINGS, option_json, table, table_text};
use super::terminal::{ATTENTION, BAD, BOLD, GOOD, Text};
use anstyle::Style;
use cocarry::coordination;
use cocarry::episode::{Episode, EpisodeSettings, OptionTick, Outcome, PreferenceChange, Summary, Tick};
use cocarry::geometry::Point;
use cocarry::preference::Perception;
use cocarry::quantities::{EPISODE, Event, Severity, View};
use cocarry::robot::Robot;
use cocarry::scenario::{PreparedScenario, RobotSetup};
use cocarry_output::drawing::Track;
use serde_json::{Value, json};

/// The report of a finished episode.
pub(super) struct EpisodeReport<'a> {
    pub prepared: &'a PreparedScenario,
    pub episode: &'a Episode<'a>,
    /// The custom policy in place of the scenario's method.
    pub policy: Option<&'a str>,
    /// The step at which the episode was resumed; `None` if it ran from its beginning.
    pub resumed: Option<u64>,
    /// The ticks of the steps from there on.
    pub ticks: Vec<Tick>,
}

/// The style of an event in a terminal.
fn style(event: &Event) -> Option<Style> {
    match (event.severity, event.about) {
        (Severity::Error, _) => Some(BAD),
        (Severity::Info, "end") => Some(GOOD),
        (Severity::Warning, "mode") => Some(BOLD),
        _ => None,
    }
}

impl EpisodeReport<'_> {
    fn view(&self) -> View<'_> {
        View::new(self.prepared, self.episode)
    }

    fn summary(&self) -> &Summary {
        self.episode.summary()
    }

    fn settings(&self) -> &EpisodeSettings {
        &self.prepared.scenario().settings
    }

    fn method(&self) -> &str {
        self.policy.unwrap_or_else(|| self.settings().method.name())
    }

    /// The robot and its setup; `None` on the planning level alone.
    fn robot_setup(&self) -> Option<(&Robot, &RobotSetup)> {
        self.prepared.robot().zip(self.prepared.scenario().plant.robot_setup())
    }

    fn option_name(&self, option: usize) -> &str {
        &self.prepared.options().options()[option].name
    }

    fn openings(&self, option: usize) -> Vec<&str> {
        let crossings = &self.prepared.options().options()[option].crossings;
        crossings.iter().map(|c| self.prepared.world().openings[c.opening].name.as_str()).collect()
    }

    /// The options at the first reported step: name, openings, and quantities.
    fn options(&self) -> impl Iterator<Item = (&str, Vec<&str>, &OptionTick)> {
        let options = self.ticks.first().into_iter().flat_map(|tick| tick.options.iter().enumerate());
        options.map(|(o, option)| (self.option_name(o), self.openings(o), option))
    }

    /// The ticks at which the executed option changed, each with the option before.
    fn changes(&self) -> impl Iterator<Item = (usize, &Tick)> {
        self.ticks.windows(2).filter(|w| w[0].executed != w[1].executed).map(|w| (w[0].executed, &w[1]))
    }

    /// The tick of a step; `None` for steps before the report begins and after the end.
    fn tick(&self, step: u64) -> Option<&Tick> {
        let first = self.ticks.first()?.step;
        self.ticks.get(usize::try_from(step.checked_sub(first)?).ok()?)
    }

    /// The human's preference changes that were applied, by step.
    fn preference_changes(&self) -> Vec<PreferenceChange> {
        let mut standing = PreferenceChange::in_force(&self.prepared.scenario().changes);
        standing.retain(|change| change.step < self.summary().steps);
        standing
    }

    fn seconds(&self, step: u64) -> f64 {
        step as f64 * self.settings().planning_step
    }

    pub fn track(&self) -> Track {
        Track::new(self.method().to_owned(), &self.ticks, self.end())
    }

    /// The target, if the team arrived there.
    fn end(&self) -> Option<Point> {
        (self.summary().outcome == Outcome::Arrived).then(|| self.prepared.options().target())
    }

    pub fn as_text(&self) -> Text {
        let (world, summary) = (self.prepared.world(), self.summary());
        let coordination::StubbornnessSettings { eta, initial_stubbornness } = self.settings().coordination;
        let mut text = format!("{} ({})\n", world.name, world.file);
        let method = self.method();
        let from =
            self.resumed.map_or("the start".to_owned(), |step| format!("step {step}, where the run resumed"));
        let Perception { alpha, gamma } = self.prepared.scenario().human;
        text += &format!(
            "human: alpha {alpha:.4}, gamma {gamma:.4}; method {method}, eta {eta}, phi(0) {initial_stubbornness}\n\nOptions at {from}\n"
        );
        let mut options = table(OPTION_HEADINGS, 2);
        for (name, openings, option) in self.options() {
            options.add_row([
                name.to_owned(),
                openings.join(" "),
                format!("{:.2}", option.remaining.length),
                format!("{:.3}", option.remaining.risk),
                format!("{:.2}", option.objective),
                number_or_dash(option.expected, 2),
                format!("{:.1}", 100.0 * option.probability),
            ]);
        }
        text += &table_text(&options);
        text += "\nEvents\n";
        let mut report = Text::default();
        report.plain(&text);
        for event in self.events() {
            let line = self.line(&event);
            match style(&event) {
                None => report.plain(&line),
                Some(style) => report.styled(style, &line),
            }
        }
        if summary.steps == 0 {
            report.plain("  no step was taken\n");
        }
        report.plain(&self.view().conclusion());
        for warning in self.view().warnings() {
            report.plain("\n");
            report.styled(ATTENTION, &format!("warning: {warning}\n"));
        }
        report
    }

    /// The events; none if no step was taken. In a resumed episode, earlier preference changes and the
    /// transition are included.
    fn events(&self) -> Vec<Event> {
        let (summary, options) = (self.summary(), self.prepared.options());
        if summary.steps == 0 {
            return Vec::new();
        }
        let first = self.ticks.first();
        let begin = first.map_or(summary.steps, |tick| tick.step);
        let changes = self.preference_changes();
        let change_at = |step| changes.iter().find(|change| change.step == step);
        let before = changes.iter().filter(|change| change.step < begin);
        let mut events: Vec<_> =
            before.map(|change| Event::preference_change(change, None, options)).collect();
        if let Some(transition) = summary.transition.filter(|t| t.step <= begin) {
            let phi = self.tick(transition.step).map(|tick| tick.stubbornness);
            events.push(Event::transition(&transition, phi));
        }
        events.sort_by_key(|event| event.step);
        events
            .extend(first.into_iter().flat_map(|tick| Event::decided(None, tick, change_at(begin), options)));
        for pair in self.ticks.windows(2) {
            events.extend(Event::decided(Some(&pair[0]), &pair[1], change_at(pair[1].step), options));
        }
        events.extend(summary.loss.as_ref().map(Event::loss));
        let touched = summary.collision.as_ref();
        events.extend(touched.map(|contact| Event::contact(summary.steps - 1, contact)));
        events.push(Event::end(&self.view()));
        events
    }

    fn line(&self, Event { step, position, sentence, .. }: &Event) -> String {
        let place = position.map_or(String::new(), |at| format!(" at ({:.2}, {:.2}) m", at.x, at.y));
        format!("  step {step:>4} ({:5.1} s){place}: {sentence}\n", self.seconds(*step))
    }

    pub fn as_json(&self) -> Value {
        let (world, scenario, settings) = (self.prepared.world(), self.prepared.scenario(), self.settings());
        let warnings = [self.prepared.warnings(), self.view().warnings()].concat();
        let mut report = json!({
            "world": world.name,
            "file": world.file,
            "human": { "alpha": scenario.human.alpha, "gamma": scenario.human.gamma },
            "preference_changes": self.changes_as_json(),
            "method": self.method(),
            "eta": settings.coordination.eta,
            "initial_stubbornness": settings.coordination.initial_stubbornness,
            "risk_weight_m": settings.predictor.risk_weight(),
            "seed": scenario.seed,
            "planning_step_s": settings.planning_step,
            "control_period_s": settings.control_period(),
            "speed_m_per_s": settings.speed,
            "options": self.options().map(|(name, openings, option)| option_json(name, &openings, option)).collect::<Vec<_>>(),
            "option_changes": self.changes().map(|(before, tick)| json!({
                "step": tick.step,
                "from": self.option_name(before),
                "to": self.option_name(tick.executed),
            })).collect::<Vec<_>>(),
            "robot": self.robot_setup().map(|(robot, c)| json!({
                "name": robot.name,
                "file": robot.texts.file,
                "posture": c.posture,
                "pose": c.control.candidates,
                "pose_criterion": c.control.criterion,
                "avoid": c.control.avoid,
            })),
            "warnings": warnings,
        });
        for (key, value) in self.view().read(EPISODE) {
            report[key] = json!(value);
        }
        if let Some(step) = self.resumed {
            report["resumed_at_step"] = json!(step);
        }
        report
    }

    /// All preference changes of the scenario, by step: whether each was applied, and the option preferred
    /// from then on, which is not known for steps before the resumed one.
    fn changes_as_json(&self) -> Vec<Value> {
        let applied = self.preference_changes();
        let mut given = self.prepared.scenario().changes.clone();
        given.sort_by_key(|change| change.step);
        let is_last = |i: usize| given.get(i + 1).is_none_or(|next| next.step != given[i].step);
        let changes = given.iter().enumerate().map(|(i, change)| {
            let is_applied = is_last(i) && applied.contains(change);
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
        changes.collect()
    }
}

fn number_or_dash(value: f64, digits: usize) -> String {
    if value.is_finite() { format!("{value:.digits$}") } else { "-".to_owned() }
}
