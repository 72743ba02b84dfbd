//! The figures that a baseline keeps of an episode.

use super::{Figures, Tolerance};
use crate::episode::Summary;
use crate::geometry::{Point, cross};
use crate::options::Crossing;
use crate::scenario::Stage;

/// A figure of a run.
#[derive(Clone, Debug, PartialEq)]
pub enum Figure {
    /// A word.
    Text(String),
    /// A whole number.
    Count(i64),
    /// A number.
    Number(f64),
}

/// The names of all figures, in the order in which they are recorded: those of `cocarry run --json`, with `control_` and `interaction_` before
/// what stands inside `control` and `interaction` there; beside these, the way: `openings`, each with its middle, in the order in which the team went
/// through them, and `mean_offset_m`, how far to the left of the straight line from start to target. What a run does not have is left out;
/// `transition_step` is then `"never"`, `openings` and `collision` are `"none"`.
pub const FIGURES: [&str; 31] = [
    "outcome",
    "steps",
    "first_option",
    "last_option",
    "option_changes",
    "transition_step",
    "openings",
    "mean_offset_m",
    "walked_m",
    "accumulated_objective_cost_m",
    "final_stubbornness",
    "final_discomfort",
    "share_off_preference",
    "accumulated_subjective_cost",
    "changes_of_mind",
    "preference_switches",
    "control_cost",
    "control_tracking",
    "control_effort",
    "control_pose",
    "control_position_error_rms_m",
    "control_largest_position_error_m",
    "control_constrained_steps",
    "control_fallback_steps",
    "control_pose_changes",
    "control_overlapping_steps",
    "interaction_hand_force_rms_n",
    "interaction_peak_force_n",
    "interaction_human_work_j",
    "interaction_largest_effort_share",
    "collision",
];

impl Figure {
    /// Whether `now` is this figure still: words must be the same, numbers may differ by the tolerance.
    pub fn is_near(&self, now: &Self, tolerance: Tolerance) -> bool {
        match (self.number(), now.number()) {
            (Some(before), Some(now)) => {
                let most = tolerance.absolute + tolerance.relative * before.abs();
                // infinite ones, and those that are no numbers, must be the same
                let is_same = before == now || before.is_nan() && now.is_nan();
                is_same || before.is_finite() && (now - before).abs() <= most
            }
            _ => self == now,
        }
    }

    /// As a number; none for words.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Text(_) => None,
            Self::Count(count) => Some(*count as f64),
            Self::Number(number) => Some(*number),
        }
    }
}

impl std::fmt::Display for Figure {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::Text(text) => f.write_str(text),
            Self::Count(count) => count.fmt(f),
            Self::Number(number) => number.fmt(f),
        }
    }
}

/// The way that a team went: on which side, which the names of options do not say.
#[derive(Clone, Debug)]
pub struct Way {
    position: Point,
    crossings: Vec<Crossing>,
    /// Sum over the steps of the distance to the left of the straight line from start to target, m.
    offsets: f64,
    steps: u64,
}

impl Way {
    /// At the start.
    pub fn new(stage: &Stage) -> Self {
        Self { position: stage.world().start, crossings: Vec::new(), offsets: 0.0, steps: 0 }
    }

    /// One step on.
    pub fn step(&mut self, stage: &Stage, to: Point) {
        let world = stage.world();
        self.crossings.extend(stage.options().crossing(self.position, to));
        let ahead = world.target - world.start;
        self.offsets += cross(ahead, to - world.start) / ahead.norm();
        self.steps += 1;
        self.position = to;
    }

    fn openings(&self, stage: &Stage) -> String {
        let names = self.crossings.iter().map(|crossing| {
            let opening = &stage.world().openings[crossing.opening];
            // to the centimetre; no negative zero
            let [x, y] = [opening.center().x, opening.center().y].map(|c| (c * 100.0).round() / 100.0 + 0.0);
            format!("{} ({x:.2}, {y:.2})", opening.name)
        });
        let names = names.collect::<Vec<_>>().join(", ");
        if names.is_empty() { "none".to_owned() } else { names }
    }
}

/// The figures of an episode that is over.
pub fn figures(stage: &Stage, summary: &Summary, way: &Way) -> Figures {
    let option = |o: usize| Figure::Text(stage.options().options()[o].name.clone());
    let count = |n: u64| Figure::Count(i64::try_from(n).unwrap_or(i64::MAX));
    let transition = summary.transition.map(|t| count(t.step));
    let mut values = vec![
        Figure::Text(summary.outcome.name().to_owned()),
        count(summary.steps),
        option(summary.first_option),
        option(summary.last_option),
        count(u64::from(summary.changes)),
        transition.unwrap_or_else(|| Figure::Text("never".to_owned())),
        Figure::Text(way.openings(stage)),
        Figure::Number(way.offsets / way.steps.max(1) as f64),
        Figure::Number(summary.walked),
        Figure::Number(summary.accumulated_cost),
        Figure::Number(summary.human.stubbornness),
        Figure::Number(summary.human.discomfort),
        Figure::Number(summary.human.share_off_preference(summary.steps)),
        Figure::Number(summary.human.subjective_cost),
        count(u64::from(summary.human.changes_of_mind)),
        count(u64::from(summary.human.preference_switches)),
    ];
    if let Some(control) = &summary.control {
        values.extend([
            Figure::Number(control.cost()),
            Figure::Number(control.tracking),
            Figure::Number(control.effort),
            Figure::Number(control.pose),
            Figure::Number(control.error_rms(summary.steps)),
            Figure::Number(control.largest_error),
            count(control.constrained_steps),
            count(control.fallback_steps),
            count(control.pose_changes),
            count(control.overlapping_steps),
        ]);
    }
    if let Some(interaction) = &summary.interaction {
        let touched = summary.collision.as_ref().map(|c| {
            let [first, second] = &c.between;
            format!("{} on {}", first.name, second.name)
        });
        values.extend([
            Figure::Number(interaction.rms_force()),
            Figure::Number(interaction.peak_force),
            Figure::Number(interaction.work[1]),
            Figure::Number(interaction.effort_share),
            Figure::Text(touched.unwrap_or_else(|| "none".to_owned())),
        ]);
    }
    // the planning level has the first, the kinematic plant those of the controller too
    FIGURES.into_iter().zip(values).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_tolerances_add_up() {
        let tolerance = Tolerance { relative: 0.01, absolute: 0.5 };
        let is_near = |a: f64, b: f64| Figure::Number(a).is_near(&Figure::Number(b), tolerance);
        assert!(is_near(100.0, 101.5) && is_near(100.0, 98.5));
        assert!(!is_near(100.0, 101.500_1) && !is_near(100.0, f64::NAN));
        assert!(is_near(f64::INFINITY, f64::INFINITY) && is_near(f64::NAN, f64::NAN));
        assert!(!is_near(f64::INFINITY, 1.0) && !is_near(1.0, f64::INFINITY));
    }

    #[test]
    fn words_and_numbers_differ() {
        let exact = Tolerance { relative: 0.0, absolute: 0.0 };
        let never = Figure::Text("never".to_owned());
        assert!(never.is_near(&never, exact));
        assert!(!never.is_near(&Figure::Count(42), exact) && !Figure::Count(42).is_near(&never, exact));
        assert!(Figure::Count(2).is_near(&Figure::Number(2.0), exact));
    }
}
