//! H4: what it pays to learn who the robot carries with.

use super::pairs::{difference, rounded};
use crate::paper::h4::{Findings, LearningRow, RobotKind};
use crate::statistics::Paired;
use crate::table::{Cell, Columns, Table};
use serde_json::Value;

/// The tables of H4: humans of the model by world, and all worlds by kind of human.
pub fn learning_tables(findings: &Findings) -> [Table; 2] {
    let by_world = table(&findings.by_world, "world", |row| row.world.clone())
        .table("learning-by-world", "H4, humans of the model: regret and costs by world, task and robot");
    let by_human = table(&findings.by_human, "humans", |row| row.humans.name().to_owned())
        .table("learning-by-human", "H4, all worlds: regret and costs by kind of human, task and robot");
    let tested = |rows: &[LearningRow]| {
        let of = |r: &LearningRow| {
            [r.regret_against_prior, r.human_cost_against_prior, r.objective_cost_against_prior]
        };
        rows.iter().flat_map(of).filter(|paired| paired.is_some_and(|p| p.p_value.is_some())).count()
    };
    [explained(by_world, tested(&findings.by_world)), explained(by_human, tested(&findings.by_human))]
}

fn table<'a>(
    rows: &'a [LearningRow],
    heading: &str,
    name: impl Fn(&LearningRow) -> String,
) -> Columns<'a, LearningRow> {
    let columns = Columns::of(rows)
        .text(heading, heading, name)
        .count("task", "task", |r| r.task as u64)
        .text("robot", "robot", |r| r.robot.name())
        .count("episodes", "episodes", |r| r.episodes as u64)
        .data("not_arrived", |r| r.not_arrived as u64)
        .number("regret", "regret", 2, |r| r.regret)
        .data("regret_std", |r| r.regret_std);
    let columns = against(columns, "regret - prior's", "regret", |r| r.regret_against_prior);
    let columns = columns.number("human's cost", "human_cost", 1, |r| r.human_cost);
    let columns = against(columns, "- prior's", "human_cost", |r| r.human_cost_against_prior);
    let columns = columns.number("objective (m)", "objective_cost_m", 1, |r| r.objective_cost);
    against(columns, "- prior's (m)", "objective_cost", |r| r.objective_cost_against_prior)
        .number("off preference (%)", "share_off_preference_percent", 1, |r| 100.0 * r.share_off_preference)
        .count("transitions", "transitions", |r| r.transitions as u64)
}

/// A difference to the robot with the prior, with its interval and corrected p-value.
fn against<'a>(
    columns: Columns<'a, LearningRow>,
    heading: &str,
    key: &str,
    of: impl Fn(&LearningRow) -> Option<Paired>,
) -> Columns<'a, LearningRow> {
    let keys = ["pairs", "difference", "lower", "upper", "effect_size", "p_value", "p_holm"]
        .map(|figure| format!("{key}_against_prior_{figure}"));
    columns.column(heading, false, &keys.each_ref().map(String::as_str), |row| {
        let paired = of(row);
        let interval = paired.and_then(|p| p.difference.interval);
        let shown = match paired {
            None => "-".to_owned(),
            Some(p) if p.p_holm.is_none() && p.difference.mean == 0.0 => "0".to_owned(),
            Some(p) => format!("{}, p {}", difference(&p, 2), rounded(p.p_holm)),
        };
        let figures = [
            paired.map(|p| p.difference.mean),
            interval.map(|i| i[0]),
            interval.map(|i| i[1]),
            paired.and_then(|p| p.effect_size),
            paired.and_then(|p| p.p_value),
            paired.and_then(|p| p.p_holm),
        ];
        let pairs: Value = paired.map(|p| p.difference.n).into();
        Cell { shown, values: [pairs].into_iter().chain(figures.map(Value::from)).collect() }
    })
}

fn explained(table: Table, tested: usize) -> Table {
    table
        .with_note(format!(
            "{}: the paper's robot, which has the prior and knows phi(k); {}: the default rates; {}: larger lapse and change rates; {}: alpha, gamma and eta.",
            RobotKind::Prior.name(),
            RobotKind::Learns.name(),
            RobotKind::Forgets.name(),
            RobotKind::Knows.name(),
        ))
        .with_note("regret: sum over the robot-led steps of the cost of eq. (6), with the person's true alpha, gamma and phi(k), above the least one there;")
        .with_note("human's cost: sum of J^ of the executed option with the person's alpha and gamma; objective: sum of J; off preference: steps on another option than the human prefers;")
        .with_note(format!(
            "differences: mean of the same humans, 95 % interval (Student's t), p of the paired t-test corrected by Holm's method for the {tested} comparisons tested."
        ))
}
