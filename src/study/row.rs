//! A row of results: a column for every input and every figure of an episode, with its unit.

use super::names::{AVOID, BOOLEANS, CRITERIA, METHODS, PLANTS, POSES, Plants, name};
use super::{Cell, Study};
use crate::arithmetic;
use crate::control::CandidateSet;
use crate::episode::{ControlSummary, InteractionSummary, Loss, Outcome, Summary};
use crate::scenario::{Scenario, Stage};
use crate::simulation::{Contact, Failure};

/// A column: its name, and its value for a cell; none where it does not apply.
type InputColumn = (&'static str, fn(&Inputs) -> Option<String>);
/// The same for an episode that is over.
type ResultColumn = (&'static str, fn(&End) -> Option<String>);

/// What tells rows and studies apart.
pub(super) const IDENTITY: [&str; 4] = ["episode", "episodes", "study", "arithmetic"];

/// A combination of values.
struct Inputs<'a> {
    study: &'a Study,
    cell: &'a Cell,
}

/// The inputs but for the seed and what is drawn from it.
const INPUTS: &[InputColumn] = &[
    ("world", |r| Some(r.study.contents.worlds[r.cell.world].0.clone())),
    ("plant", |r| word(name(PLANTS, r.cell.plant))),
    ("method", |r| word(name(METHODS, r.cell.method))),
    ("eta", |r| some(r.cell.eta)),
    ("initial_stubbornness", |r| some(r.cell.initial_stubbornness)),
    ("risk_weight_m", |r| some(r.cell.risk_weight)),
    ("humans", |r| Some(r.study.contents.humans[r.cell.humans].0.clone())),
    ("humans_alpha", |r| some(r.study.contents.humans[r.cell.humans].1.alpha)),
    ("humans_gamma", |r| some(r.study.contents.humans[r.cell.humans].1.gamma)),
    ("redraws", |r| some(r.cell.redraws)),
    ("belief", |r| Some(r.study.contents.beliefs[r.cell.belief].0.clone())),
    ("belief_alpha", |r| r.belief()[0].clone()),
    ("belief_gamma", |r| r.belief()[1].clone()),
    ("period_s", |r| some(r.cell.period)),
    ("speed_m_per_s", |r| some(r.cell.speed)),
    ("yaw_rate_rad_per_s", |r| some(r.cell.yaw_rate)),
    ("max_steps", |r| r.cell.max_steps.map(|steps| steps.to_string())),
    ("robot", |r| r.with_robot(|r| r.study.contents.robots[r.cell.robot].0.clone())),
    ("posture", |r| r.with_robot(|r| r.study.posture(r.cell).to_owned())),
    ("avoid", |r| r.with_robot(|r| name(AVOID, r.cell.avoid).to_owned())),
    ("pose", |r| r.with_robot(|r| name(POSES, r.cell.candidates).to_owned())),
    ("pose_criterion", |r| r.with_choice(|r| name(CRITERIA, r.cell.criterion).to_owned())),
    ("prepare_while_leading", |r| r.with_choice(|r| name(BOOLEANS, r.cell.prepare_while_leading).to_owned())),
    ("sway_m", |r| (r.cell.plant == Plants::Rapier).then(|| r.cell.sway.to_string())),
];

/// An episode that is over.
struct End<'a> {
    scenario: &'a Scenario,
    stage: &'a Stage,
    /// The option that the human preferred at the first step.
    preferred: Option<usize>,
    /// None if the episode could not begin.
    summary: Option<Summary>,
    refusal: Option<String>,
}

/// The seed, what is drawn from it, and what came of it.
const RESULTS: &[ResultColumn] = &[
    ("seed", |r| some(r.scenario.seed)),
    ("alpha", |r| some(r.scenario.human.alpha)),
    ("gamma", |r| some(r.scenario.human.gamma)),
    ("preference_changes", |r| some(r.changes())),
    ("outcome", |r| word(r.summary.as_ref().map_or("not-begun", |s| s.outcome.name()))),
    ("steps", |r| r.of(|s| s.steps)),
    ("time_s", |r| r.of(|s| r.seconds(s.steps))),
    ("walked_m", |r| r.of(|s| s.walked)),
    ("accumulated_objective_cost_m", |r| r.of(|s| s.accumulated_cost)),
    ("final_stubbornness", |r| r.of(|s| s.human.stubbornness)),
    ("final_discomfort", |r| r.of(|s| s.human.discomfort)),
    ("share_off_preference", |r| r.of(|s| s.human.share_off_preference(s.steps))),
    ("accumulated_subjective_cost", |r| r.of(|s| s.human.subjective_cost)),
    ("changes_of_mind", |r| r.of(|s| s.human.changes_of_mind)),
    ("preference_switches", |r| r.of(|s| s.human.preference_switches)),
    ("preferred_at_start", |r| r.preferred.map(|option| r.option(option))),
    ("first_option", |r| r.summary.as_ref().map(|s| r.option(s.first_option))),
    ("last_option", |r| r.summary.as_ref().map(|s| r.option(s.last_option))),
    ("option_changes", |r| r.of(|s| s.changes)),
    ("transition_step", |r| r.summary.as_ref()?.transition.map(|t| t.step.to_string())),
    ("transition_time_s", |r| r.summary.as_ref()?.transition.map(|t| r.seconds(t.step).to_string())),
    ("transition_x_m", |r| r.summary.as_ref()?.transition.map(|t| t.position.x.to_string())),
    ("transition_y_m", |r| r.summary.as_ref()?.transition.map(|t| t.position.y.to_string())),
    ("control_cost", |r| r.control(|c, _| c.cost())),
    ("control_tracking", |r| r.control(|c, _| c.tracking)),
    ("control_effort", |r| r.control(|c, _| c.effort)),
    ("control_pose", |r| r.control(|c, _| c.pose)),
    ("position_error_rms_m", |r| r.control(|c, steps| c.error_rms(steps))),
    ("largest_position_error_m", |r| r.control(|c, _| c.largest_error)),
    ("constrained_steps", |r| r.control(|c, _| c.constrained_steps as f64)),
    ("fallback_steps", |r| r.control(|c, _| c.fallback_steps as f64)),
    ("pose_changes", |r| r.control(|c, _| c.pose_changes as f64)),
    ("overlapping_steps", |r| r.control(|c, _| c.overlapping_steps as f64)),
    ("least_base_clearance_m", |r| r.control(|c, _| c.least_clearance)),
    ("hand_force_mean_n", |r| r.interaction(InteractionSummary::mean_force)),
    ("hand_force_rms_n", |r| r.interaction(InteractionSummary::rms_force)),
    ("peak_force_n", |r| r.interaction(|i| i.peak_force)),
    ("robot_work_j", |r| r.interaction(|i| i.work[0])),
    ("human_work_j", |r| r.interaction(|i| i.work[1])),
    ("squared_jerk_m2_per_s5", |r| r.interaction(|i| i.squared_jerk)),
    ("force_noise_rms_n", |r| r.interaction(InteractionSummary::force_noise)),
    ("largest_stretch_m", |r| r.interaction(|i| i.stretch)),
    ("largest_effort_share", |r| r.interaction(|i| i.effort_share)),
    ("lost_by", |r| r.loss(|l| l.by.name().to_owned())),
    ("lost_at_step", |r| r.loss(|l| l.step.to_string())),
    ("lost_distance_m", |r| r.loss(|l| l.distance.to_string())),
    ("collision_of", |r| r.collision(|c| c.between[0].kind.name().to_owned())),
    ("collision_part", |r| r.collision(|c| c.between[0].name.clone())),
    ("collision_with", |r| r.collision(|c| c.between[1].kind.name().to_owned())),
    ("collision_with_part", |r| r.collision(|c| c.between[1].name.clone())),
    ("collision_x_m", |r| r.collision(|c| c.point.x.to_string())),
    ("collision_y_m", |r| r.collision(|c| c.point.y.to_string())),
    ("collision_z_m", |r| r.collision(|c| c.point.z.to_string())),
    ("collision_depth_m", |r| r.collision(|c| c.depth.to_string())),
    ("collision_force_n", |r| r.collision(|c| c.force.to_string())),
    ("failure", |r| r.failure()),
];

/// Names of all columns, in their order.
pub(super) fn columns() -> Vec<&'static str> {
    let inputs = INPUTS.iter().map(|(name, _)| *name);
    IDENTITY.into_iter().chain(inputs).chain(RESULTS.iter().map(|(name, _)| *name)).collect()
}

/// Names of the columns that settle a combination.
pub(super) fn input_columns() -> impl Iterator<Item = &'static str> {
    INPUTS.iter().map(|(name, _)| *name)
}

/// The first line of a file of results.
pub(super) fn header() -> Vec<u8> {
    line(columns().into_iter().map(str::to_owned))
}

/// The values of a cell's input columns.
pub(super) fn inputs(study: &Study, cell: usize) -> Vec<String> {
    let inputs = Inputs { study, cell: &study.cells[cell] };
    INPUTS.iter().map(|(_, value)| value(&inputs).unwrap_or_default()).collect()
}

/// A cell, for errors.
pub(super) fn inputs_in_words(study: &Study, cell: usize) -> String {
    let values = inputs(study, cell);
    let pairs = input_columns().zip(&values).filter(|(_, value)| !value.is_empty());
    pairs.map(|(name, value)| format!("{name} {value}")).collect::<Vec<_>>().join(", ")
}

/// The line of a file of results with all fields; none of them breaks it.
fn line(fields: impl Iterator<Item = String>) -> Vec<u8> {
    let mut writer = csv::WriterBuilder::new().buffer_capacity(1024).from_writer(Vec::with_capacity(1024));
    let fields = fields.map(|field| field.replace(['\n', '\r'], " "));
    // a vector takes all that is written to it
    writer.write_record(fields).and_then(|()| Ok(writer.flush()?)).unwrap_or_default();
    writer.into_inner().unwrap_or_default()
}

impl Study {
    /// Runs an episode to its end: its line of results. Empty beyond the last episode.
    pub(super) fn run(&self, episode: u64) -> Vec<u8> {
        let Some((cell, seed)) = self.place(episode) else { return Vec::new() };
        let basis = &self.stages[self.stage_of[cell]];
        let scenario = self.drawn(cell, seed);
        let end = match basis.prepare(scenario.clone()) {
            Ok(stage) => carry_out(&stage),
            Err(error) => (None, None, Some(words(&error))),
        };
        let (preferred, summary, refusal) = end;
        let end = End { scenario: &scenario, stage: basis, preferred, summary, refusal };
        let (digest, arithmetic) = (self.digest.clone(), arithmetic::stamp().to_owned());
        let identity = [episode.to_string(), self.episodes.to_string(), digest, arithmetic];
        let results = RESULTS.iter().map(|(_, value)| value(&end).unwrap_or_default());
        line(identity.into_iter().chain(inputs(self, cell)).chain(results))
    }
}

fn carry_out(stage: &Stage) -> (Option<usize>, Option<Summary>, Option<String>) {
    let mut episode = match stage.episode() {
        Ok(episode) => episode,
        Err(error) => return (None, None, Some(words(&error))),
    };
    let mut preferred = None;
    while episode.step().is_none() {
        preferred = preferred.or(Some(episode.tick().preferred));
    }
    (preferred, Some(episode.summary().clone()), None)
}

/// An error with its causes, in one line.
fn words(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text += &format!(": {error}");
        cause = error.source();
    }
    text
}

fn some(value: impl ToString) -> Option<String> {
    Some(value.to_string())
}

fn word(word: &str) -> Option<String> {
    Some(word.to_owned())
}

impl Inputs<'_> {
    fn belief(&self) -> [Option<String>; 2] {
        match &self.study.contents.beliefs[self.cell.belief].1 {
            crate::preference::Belief::Independent { alpha, gamma } => [some(alpha), some(gamma)],
            crate::preference::Belief::Samples(_) => [None, None],
        }
    }

    fn with_robot(&self, value: impl Fn(&Self) -> String) -> Option<String> {
        (self.cell.plant != Plants::Point).then(|| value(self))
    }

    fn with_choice(&self, value: impl Fn(&Self) -> String) -> Option<String> {
        self.with_robot(value).filter(|_| self.cell.candidates != CandidateSet::None)
    }
}

impl End<'_> {
    fn of<T: ToString>(&self, value: impl Fn(&Summary) -> T) -> Option<String> {
        self.summary.as_ref().map(|summary| value(summary).to_string())
    }

    fn seconds(&self, steps: u64) -> f64 {
        steps as f64 * self.scenario.settings.period
    }

    /// As `cocarry run --change` takes them, with spaces between, by their steps; empty without.
    fn changes(&self) -> String {
        let mut changes = self.scenario.changes.clone();
        changes.sort_by_key(|change| change.step);
        changes.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")
    }

    fn option(&self, option: usize) -> String {
        self.stage.options().options().get(option).map_or(String::new(), |o| o.name.clone())
    }

    fn control(&self, value: impl Fn(&ControlSummary, u64) -> f64) -> Option<String> {
        let summary = self.summary.as_ref()?;
        let value = value(summary.control.as_ref()?, summary.steps);
        value.is_finite().then(|| value.to_string())
    }

    fn interaction(&self, value: impl Fn(&InteractionSummary) -> f64) -> Option<String> {
        self.summary.as_ref()?.interaction.as_ref().map(|i| value(i).to_string())
    }

    fn loss(&self, value: impl Fn(&Loss) -> String) -> Option<String> {
        self.summary.as_ref()?.loss.as_ref().map(value)
    }

    fn collision(&self, value: impl Fn(&Contact) -> String) -> Option<String> {
        self.summary.as_ref()?.collision.as_ref().map(value)
    }

    fn failure(&self) -> Option<String> {
        let failure = self.summary.as_ref().and_then(|s| s.failure.as_ref()).map(|failure| match failure {
            Failure::NonFinite { body } => format!("{body} stopped being a number"),
            Failure::Dropped => "the object fell".to_owned(),
        });
        failure.or_else(|| self.refusal.clone())
    }
}

/// The outcome that counts as success.
pub(super) fn arrived() -> &'static str {
    Outcome::Arrived.name()
}

/// The plant on which the same choices may cost differently, by noise.
pub(super) fn with_bodies() -> &'static str {
    name(PLANTS, Plants::Rapier)
}
