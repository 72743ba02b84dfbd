//! H4: whether it pays that the robot learns who it carries with.

use crate::paper::h3::PoseMethod;
use crate::paper::h4::{
    ALL_WORLDS, ControlRow, Findings, HumanKind, LearningRow, LearningStudy, PersonRow, ROBOTS_WITH_ARM,
    RobotKind, TASKS, WORLDS,
};
use crate::paper::pairs::{difference, is_significant, rounded};
use crate::paper::part::{Block, Figure, Finding, Part, Plan, Section, none};
use crate::parallel::OnDone;
use crate::statistics::Paired;
use crate::table::{Cell, Columns, Table};
use cocarry::Error;
use cocarry::policy::Method;
use cocarry::scenario::{Plant, PlantKind, RobotSetup};
use cocarry_output::drawing::{MeanPanel, MeanRow, Sheet, means};
use serde_json::Value;

/// H4.
pub(crate) const PART: Part = Part {
    id: "h4",
    name: "people to learn",
    episodes: |plan| with_study(plan, |study| study.units()),
    studies: none,
    run: learning_section,
};

fn with_study<T>(plan: &Plan, work: impl FnOnce(&LearningStudy) -> T) -> T {
    let plant = &Plant::new(PlantKind::Kinematic, RobotSetup::new(plan.robot));
    let (settings, humans, seed) = (&plan.settings, plan.people, plan.seed);
    work(&LearningStudy { settings, plant, humans, worlds: WORLDS, tasks: TASKS, seed })
}

fn learning_section(plan: &Plan, on_done: OnDone) -> Result<Section, Error> {
    let findings = with_study(plan, |study| study.run(on_done))?;
    let text = "The paper's robot keeps the prior over people for the whole task. Here, one person carries twice in a row with a robot that learns alpha, gamma \
                and \u{3b7} from what the person does, and keeps that for the second task. It is compared with the paper's robot and with one that knows the \
                person, with the same people. Some are not of the model that the robot learns with.";
    let [by_world, by_human, control] = learning_tables(&findings).map(Block::Table);
    let [regret, cost] = pictures(&findings)?.map(Block::Figure);
    Ok(Section {
        title: "H4: learning who the robot carries with (not in the paper)".to_owned(),
        finding: finding(&findings),
        blocks: vec![
            Block::Text(text.to_owned()),
            by_world,
            by_human,
            regret,
            Block::Text(reason(&findings)),
            control,
            cost,
        ],
    })
}

/// The sources of the saving in C, in figures of this run.
fn reason(findings: &Findings) -> String {
    let of = |pose: PoseMethod, robot: RobotKind| {
        let is_it = |row: &&ControlRow| row.world == ALL_WORLDS && row.task == TASKS && row.robot == robot;
        rows_of(findings, Method::HUMAN_LED, pose).find(is_it)
    };
    let saved = |pose: PoseMethod, cost: fn(&ControlRow) -> f64| {
        let both = of(pose, RobotKind::Prior).zip(of(pose, RobotKind::Learns));
        both.map_or(f64::NAN, |(prior, learns)| cost(prior) - cost(learns))
    };
    let cost = |row: &ControlRow| row.control_cost;
    format!(
        "Where the human leads, every robot carries along the same way. What was learned then saves {:.1} of C with P\u{2092} as weights of eq. (8), {:.1} with equal weights and {:.1} \
         without pose optimisation; tracking is {:.1} of the first. The saving comes from the option that eq. (7) tracks: eq. (8) is not needed for it.",
        saved(PoseMethod::WithPo, cost),
        saved(PoseMethod::UniformWeights, cost),
        saved(PoseMethod::WithoutPo, cost),
        saved(PoseMethod::WithPo, |row| row.parts[0]),
    )
}

/// Differences to the robot with the prior in the last task: regret by kind of human, control cost by world.
fn pictures(findings: &Findings) -> Result<[Figure; 2], Error> {
    let last = |task: usize| task == TASKS;
    let by_human = findings.by_human.iter().filter(|row| last(row.task));
    let regret = by_human.map(|row| (row.humans.name(), row.robot, row.regret_against_prior));
    let control = ROBOTS_WITH_ARM.map(|(method, pose)| {
        let rows = rows_of(findings, method, pose).filter(|row| last(row.task));
        let cells = rows.map(|row| (row.world.as_str(), row.robot, row.control_cost_against_prior));
        panel(&format!("{method}, {}", pose.name()), cells)
    });
    let series: Vec<String> = RobotKind::ALL[1..].iter().map(|robot| robot.name().to_owned()).collect();
    let figure = |name: &str, caption: &str, panels: &[MeanPanel], axis: &str| {
        let (name, caption) = (name.to_owned(), caption.to_owned());
        Ok::<_, Error>(Figure {
            name,
            caption,
            is_half: false,
            svg: means(panels, &series, axis, Sheet::default())?,
        })
    };
    Ok([
        figure(
            "learning-regret",
            "H4, all worlds, second task: regret minus that with the prior, the same people; left of 0, learning pays. 95 % intervals.",
            &[panel("kind of human", regret)],
            "regret minus that with the prior",
        )?,
        figure(
            "learning-control",
            "H4, humans of the model, second task: control cost C minus that with the prior, the same people; left of 0, learning pays. 95 % intervals.",
            &control,
            "C minus that with the prior",
        )?,
    ])
}

/// The control costs of robots with an arm that lead, and choose their configuration, like this.
fn rows_of(findings: &Findings, method: Method, pose: PoseMethod) -> impl Iterator<Item = &ControlRow> {
    let name = method.to_string();
    findings.control.iter().filter(move |row| row.method == name && row.pose == pose)
}

/// The rows of one label after the other, each with the robots but the one with the prior.
fn panel<'a>(title: &str, cells: impl Iterator<Item = (&'a str, RobotKind, Option<Paired>)>) -> MeanPanel {
    let mut rows: Vec<MeanRow> = Vec::new();
    for (label, robot, paired) in cells {
        if robot == RobotKind::Prior {
            rows.push(MeanRow { label: label.to_owned(), means: Vec::new() });
        } else if let Some(row) = rows.last_mut() {
            row.means.push(paired.map(|p| (p.difference.mean, p.difference.interval)));
        }
    }
    MeanPanel { title: title.to_owned(), rows }
}

fn finding(findings: &Findings) -> Finding {
    let last = findings.by_human.iter().map(|row| row.task).max().unwrap_or(1);
    let of = |robot: RobotKind| {
        let is_it = move |row: &&LearningRow| {
            row.robot == robot && row.task == last && row.humans == HumanKind::Model
        };
        findings.by_human.iter().find(is_it)
    };
    let pays = |paired: Option<Paired>| {
        paired.is_some_and(|paired| is_significant(&paired) && paired.difference.mean < 0.0)
    };
    let learns = of(RobotKind::Learns);
    let regret = learns.is_some_and(|row| pays(row.regret_against_prior));
    let human = learns.is_some_and(|row| pays(row.human_cost_against_prior));
    let costs = ROBOTS_WITH_ARM.map(|(method, pose)| {
        let cost = |robot: RobotKind| {
            let is_it = |row: &&ControlRow| row.world == ALL_WORLDS && row.task == last && row.robot == robot;
            rows_of(findings, method, pose).find(is_it).map_or(f64::NAN, |row| row.control_cost)
        };
        let [learns, prior] = [RobotKind::Learns, RobotKind::Prior].map(cost);
        format!("{learns:.1} instead of {prior:.1} ({method}, {})", pose.name())
    });
    let costs = format!("control cost {}", costs.join(", "));
    Finding {
        claim: "H4: with a person met before, a robot that learns does better than one with the prior (not in the paper)",
        verdict: match (regret, human) {
            (true, true) => "holds for regret and the human's cost",
            (true, false) => "holds for regret, not for the human's cost",
            (false, true) => "holds for the human's cost, not for regret",
            (false, false) => "does not hold",
        }
        .to_owned(),
        figures: of(RobotKind::Prior).zip(learns).map_or(String::new(), |(prior, learns)| {
            format!(
                "task {last}, people of the model: mean regret {:.2} instead of {:.2}, the human's cost {:.1} instead of {:.1}; {costs}",
                learns.regret, prior.regret, learns.human_cost, prior.human_cost
            )
        }),
    }
}

/// The tables of H4: humans of the model by world, all worlds by kind of human, and control costs.
pub fn learning_tables(findings: &Findings) -> [Table; 3] {
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
    [
        explained(by_world, tested(&findings.by_world)),
        explained(by_human, tested(&findings.by_human)),
        control(&findings.control),
    ]
}

fn control(rows: &[ControlRow]) -> Table {
    let columns = Columns::of(rows)
        .text("method", "method", |r| r.method.clone())
        .text("pose", "pose", |r| r.pose.name())
        .text("world", "world", |r| r.world.clone())
        .count("task", "task", |r| r.task as u64)
        .text("robot", "robot", |r| r.robot.name())
        .count("episodes", "episodes", |r| r.episodes as u64)
        .data("not_arrived", |r| r.not_arrived as u64)
        .count("lost", "lost_object", |r| r.lost_object as u64)
        .number("C", "control_cost", 1, |r| r.control_cost)
        .data("control_cost_std", |r| r.control_cost_std)
        .number("tracking", "tracking", 1, |r| r.parts[0])
        .number("effort", "effort", 1, |r| r.parts[1])
        .number("change of pose", "pose_change", 1, |r| r.parts[2]);
    let tested = |r: &&ControlRow| r.control_cost_against_prior.is_some_and(|p| p.p_value.is_some());
    let tested = rows.iter().filter(tested).count();
    against(columns, "C - prior's", "control_cost", |r| r.control_cost_against_prior)
        .table("learning-control", "H4, humans of the model: control cost C on the kinematic plant")
        .with_note("lost: episodes in which the grasp was off by more than 10 cm, which go on here and cost many times as much;")
        .with_note("human-led: the way is the human's with every robot. What was learned decides which option eq. (7) tracks, and with-po the weights of")
        .with_note("eq. (8), too; uniform-weights: eq. (8) with equal weights; without-po: no pose optimisation; differences and p-values: as above,")
        .with_note(format!("corrected for the {tested} comparisons tested here."))
}

/// Every person in every task with every robot.
pub fn people_table(rows: &[PersonRow]) -> Table {
    Columns::of(rows)
        .text("method", "method", |r| r.method.clone())
        .data("pose", |r| r.pose.map(PoseMethod::name))
        .text("world", "world", |r| r.world.clone())
        .count("world number", "world_number", |r| r.world_number as u64)
        .text("humans", "humans", |r| r.humans.name())
        .count("stream", "stream", |r| r.stream)
        .count("task", "task", |r| r.task as u64)
        .text("robot", "robot", |r| r.robot.name())
        .data("alpha", |r| r.alpha)
        .data("gamma", |r| r.gamma)
        .data("eta", |r| r.eta)
        .data("arrived", |r| r.result.arrived)
        .data("regret", |r| r.result.regret)
        .data("human_cost", |r| r.result.human_cost)
        .data("objective_cost_m", |r| r.result.objective_cost)
        .data("share_off_preference", |r| r.result.share_off_preference)
        .data("took_over", |r| r.result.took_over)
        .data("control_cost", |r| r.pose.map(|_| r.result.control_cost()))
        .data("tracking", |r| r.pose.map(|_| r.result.control_cost[0]))
        .data("effort", |r| r.pose.map(|_| r.result.control_cost[1]))
        .data("pose_change", |r| r.pose.map(|_| r.result.control_cost[2]))
        .data("lost_object", |r| r.pose.map(|_| r.result.lost_object))
        .table("learning-people", "H4: every person in every task with every robot")
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
fn against<'a, R>(
    columns: Columns<'a, R>,
    heading: &str,
    key: &str,
    of: impl Fn(&R) -> Option<Paired>,
) -> Columns<'a, R> {
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
