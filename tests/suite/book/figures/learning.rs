//! Figures of hypothesis H4, on the page of learning.

use super::Figure;
use super::tables::{FigureRow, Tables, grouped, line};

const BY_HUMAN: &str = "learning-by-human";
const BY_WORLD: &str = "learning-by-world";
const CONTROL: &str = "learning-control";

/// What the tables show: a robot in a task, or in both where nothing differs between them.
const ROWS: [(&[&str], &str); 5] = [
    (&["1", "2"], "prior"),
    (&["1"], "learns"),
    (&["2"], "learns"),
    (&["2"], "forgets"),
    (&["1", "2"], "knows"),
];

pub const FIGURES: &[Figure] = &[
    ("h4.model-rows", |t| {
        let titles = ["task", "robot", "regret", "difference", "human's cost", "difference"];
        let mut text = line(titles) + &line([":--", ":--", "--:", "--:", "--:", "--:"]);
        for (tasks, robot) in ROWS {
            let row = of_model(t, robot, tasks[0]);
            assert!(tasks.iter().all(|task| of_model(t, robot, task).text("regret") == row.text("regret")));
            text += &line([
                named(tasks),
                robot.to_owned(),
                format!("{:.2}", row.number("regret")),
                difference(row, "regret", 2),
                format!("{:.1}", row.number("human_cost")),
                difference(row, "human_cost", 2),
            ]);
        }
        text
    }),
    ("h4.regret-prior", |t| format!("{:.2}", of_model(t, "prior", "2").number("regret"))),
    ("h4.regret-learns", |t| format!("{:.2}", of_model(t, "learns", "2").number("regret"))),
    ("h4.human-cost-change-first", |t| change(t, "1", "human_cost")),
    ("h4.human-cost-change", |t| change(t, "2", "human_cost")),
    ("h4.objective-cost-change", |t| change(t, "2", "objective_cost_m")),
    ("h4.transitions-learns", |t| grouped(of_model(t, "learns", "2").number("transitions"))),
    ("h4.transitions-prior", |t| grouped(of_model(t, "prior", "2").number("transitions"))),
    ("h4.tasks", |t| grouped(of_model(t, "prior", "2").number("episodes"))),
    ("h4.regret-in-worlds", |t| {
        let of = |robot: &str| -> Vec<&FigureRow> { t.rows(BY_WORLD, &[("task", "2"), ("robot", robot)]) };
        let of_world = |(prior, learns): (&&FigureRow, &&FigureRow)| {
            let [before, now] = [prior, learns].map(|row| row.number("regret"));
            format!("{} {before:.2} and {now:.2}{}", prior.text("world"), significance(learns, "regret"))
        };
        of("prior").iter().zip(&of("learns")).map(of_world).collect::<Vec<_>>().join("; ")
    }),
    ("h4.human-cost-in-worlds", |t| {
        let rows = t.rows(BY_WORLD, &[("task", "2"), ("robot", "learns")]);
        let of_world =
            |row: &&FigureRow| format!("{} {}", row.text("world"), difference(row, "human_cost", 1));
        rows.iter().map(of_world).collect::<Vec<_>>().join("; ")
    }),
    ("h4.human-rows", |t| {
        let mut text = line(["humans", "prior", "learns", "forgets"]) + &line([":--", "--:", "--:", "--:"]);
        for (humans, title) in [
            ("model", "of the model"),
            ("lapses10", "a lapse in 10 % of the metres"),
            ("lapses30", "a lapse in 30 % of the metres"),
            ("outside-prior", "alpha and gamma outside the prior's ranges"),
            ("boltzmann", "Boltzmann, rationality 1"),
            ("change-of-mind", "other alpha and gamma in the second task"),
        ] {
            let cell = |robot: &str| {
                let row = t.row(BY_HUMAN, &[("humans", humans), ("task", "2"), ("robot", robot)]);
                format!("{:.2}{}", row.number("regret"), significance(row, "regret"))
            };
            text += &line([title.to_owned(), cell("prior"), cell("learns"), cell("forgets")]);
        }
        text
    }),
    ("h4.comparisons", |t| comparisons(t, BY_HUMAN, &["regret", "human_cost", "objective_cost"])),
    ("h4.comparisons-in-worlds", |t| comparisons(t, BY_WORLD, &["regret", "human_cost", "objective_cost"])),
    ("h4.comparisons-of-control", |t| comparisons(t, CONTROL, &["control_cost"])),
    ("h4.control-rows", |t| {
        let titles =
            ["method", "eq. (8)", "task", "robot", "C", "of which tracking", "difference", "grasp off"];
        let mut text = line(titles) + &line([":--", ":--", ":--", ":--", "--:", "--:", "--:", "--:"]);
        let weights = [
            ("human-led", "with-po", "P_o"),
            ("human-led", "uniform-weights", "equal weights"),
            ("human-led", "without-po", "none"),
            ("mutual", "with-po", "P_o"),
        ];
        for (method, pose, title) in weights {
            for (tasks, robot) in ROWS {
                let row = of_control(t, method, pose, tasks[0], robot);
                let cost = |task: &str| of_control(t, method, pose, task, robot).text("control_cost");
                assert!(tasks.iter().all(|task| cost(task) == row.text("control_cost")));
                text += &line([
                    method.to_owned(),
                    title.to_owned(),
                    named(tasks),
                    robot.to_owned(),
                    format!("{:.1}", row.number("control_cost")),
                    format!("{:.1}", row.number("tracking")),
                    difference(row, "control_cost", 1),
                    format!("{} of {}", row.text("lost_object"), row.text("episodes")),
                ]);
            }
        }
        text
    }),
    ("h4.c-prior", |t| cost(t, "with-po", "prior")),
    ("h4.c-learns", |t| cost(t, "with-po", "learns")),
    ("h4.c-uniform-prior", |t| cost(t, "uniform-weights", "prior")),
    ("h4.c-uniform-learns", |t| cost(t, "uniform-weights", "learns")),
    ("h4.c-none-prior", |t| cost(t, "without-po", "prior")),
    ("h4.c-none-learns", |t| cost(t, "without-po", "learns")),
    ("h4.tracking-prior", |t| {
        format!("{:.1}", of_control(t, "human-led", "with-po", "2", "prior").number("tracking"))
    }),
    ("h4.tracking-learns", |t| {
        format!("{:.1}", of_control(t, "human-led", "with-po", "2", "learns").number("tracking"))
    }),
    ("h4.lost-prior", |t| of_control(t, "human-led", "with-po", "2", "prior").text("lost_object").to_owned()),
    ("h4.lost-learns", |t| {
        of_control(t, "human-led", "with-po", "2", "learns").text("lost_object").to_owned()
    }),
    ("h4.tasks-with-arm", |t| {
        of_control(t, "human-led", "with-po", "2", "learns").text("episodes").to_owned()
    }),
];

fn named(tasks: &[&str]) -> String {
    if tasks.len() > 1 { "both".to_owned() } else { tasks[0].to_owned() }
}

fn of_model<'a>(t: &'a Tables, robot: &str, task: &str) -> &'a FigureRow {
    t.row(BY_HUMAN, &[("humans", "model"), ("task", task), ("robot", robot)])
}

/// The robot that learns against the one with the prior.
fn change(t: &Tables, task: &str, column: &str) -> String {
    let [learns, prior] = ["learns", "prior"].map(|robot| of_model(t, robot, task).number(column));
    format!("{:+.1} %", 100.0 * (learns / prior - 1.0))
}

fn of_control<'a>(t: &'a Tables, method: &str, pose: &str, task: &str, robot: &str) -> &'a FigureRow {
    t.row(CONTROL, &[("method", method), ("pose", pose), ("world", "all"), ("task", task), ("robot", robot)])
}

/// C in the second task, where the human leads.
fn cost(t: &Tables, pose: &str, robot: &str) -> String {
    format!("{:.1}", of_control(t, "human-led", pose, "2", robot).number("control_cost"))
}

/// ", n.s." where a difference to the prior is not significant.
fn significance(row: &FigureRow, key: &str) -> &'static str {
    let p = row.maybe(&format!("{key}_against_prior_p_holm"));
    if p.is_some_and(|p| p >= 0.05) { ", n.s." } else { "" }
}

/// A difference to the prior, with its 95 % interval; empty for the prior itself.
fn difference(row: &FigureRow, key: &str, decimals: usize) -> String {
    let of = |part: &str| row.maybe(&format!("{key}_against_prior_{part}"));
    match (of("difference"), of("lower"), of("upper")) {
        (Some(mean), Some(low), Some(high)) => {
            format!("{mean:+.decimals$} ({low:+.decimals$} to {high:+.decimals$}){}", significance(row, key))
        }
        (Some(mean), ..) => format!("{mean:+.decimals$}"),
        _ => String::new(),
    }
}

/// Number of comparisons that were tested.
fn comparisons(t: &Tables, table: &str, keys: &[&str]) -> String {
    let tested = |key: &str| {
        let p = format!("{key}_against_prior_p_holm");
        t.rows(table, &[]).iter().filter(|row| row.maybe(&p).is_some()).count()
    };
    keys.iter().map(|key| tested(key)).sum::<usize>().to_string()
}
