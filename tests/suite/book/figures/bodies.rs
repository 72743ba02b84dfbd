//! Figures of teams with bodies.

use super::Figure;
use super::results::{cells, ratio};
use super::tables::{FigureRow, Tables, counted, grouped, largest, least, line, mean};

pub const FIGURES: &[Figure] = &[
    ("bodies.worlds", |t| grouped(t.row("worlds-with-bodies", &[]).number("worlds"))),
    ("bodies.with-choice", |t| grouped(t.row("worlds-with-bodies", &[]).number("with_choice"))),
    ("bodies.arrived", |t| grouped(t.row("worlds-with-bodies", &[]).number("arrived"))),
    ("bodies.touched", |t| {
        let row = t.row("worlds-with-bodies", &[]);
        let by = ["touched_by_robot", "touched_by_object", "touched_by_human"];
        counted(by.iter().map(|column| row.number(column)).sum())
    }),
    ("bodies.ended-otherwise", |t| counted(t.row("worlds-with-bodies", &[]).number("ended_otherwise"))),
    ("bodies.detour", |t| format!("{:.1}", t.row("worlds-with-bodies", &[]).number("longest_detour"))),
    ("bodies-table-2.arrived", |t| {
        let sum = |column| t.column("table-2-bodies", &[], column).iter().sum::<f64>();
        format!("{:.0} of {:.0}", sum("arrived"), sum("humans"))
    }),
    ("bodies-table-2.same-option", |t| {
        format!("{:.0}", t.column("table-2-bodies", &[], "same_option").iter().sum::<f64>())
    }),
    ("bodies-table-2.within-5-percent", |t| {
        format!("{:.0}", t.column("table-2-bodies", &[], "within_5_percent").iter().sum::<f64>())
    }),
    ("bodies-table-2.grip-cm", |t| {
        format!("{:.1} cm", 100.0 * largest(&t.column("table-2-bodies", &[], "largest_grip_deflection_m")))
    }),
    ("bodies-table-2.dearer", |t| {
        let ratios = t.column("table-2-bodies", &[], "mean_ratio");
        format!("{:.1} to {:.1} %", 100.0 * (least(&ratios) - 1.0), 100.0 * (largest(&ratios) - 1.0))
    }),
    ("bodies-table-2.transition-steps", |t| {
        let steps: Vec<f64> = transitions(t).iter().map(|steps| steps.abs()).collect();
        format!("{:.0}", largest(&steps))
    }),
    ("bodies-table-2.same-transition", |t| {
        let steps = transitions(t);
        format!("{} of {}", steps.iter().filter(|steps| **steps == 0.0).count(), steps.len())
    }),
    ("bodies-table-2.dearest", |t| {
        let ratios = t.column("table-2-bodies", &[], "farthest_ratio");
        format!("{:.0} %", 100.0 * (largest(&ratios) - 1.0))
    }),
    ("contacts.walks", |t| grouped(t.column("contacts", &[], "walks").iter().sum())),
    ("contacts.walks-per-opening", |t| grouped(largest(&t.column("contacts", &[], "walks")))),
    ("contacts.touched", |t| {
        let by = ["touched_by_robot", "touched_by_object", "touched_by_human"];
        counted(by.iter().flat_map(|column| t.column("contacts", &[], column)).sum())
    }),
    ("contacts.rows", |t| {
        let cell = |value: f64| format!("{:.1}", 100.0 * value);
        let rows = t.rows("contacts", &[]);
        let of = |title: &str, cells: Vec<String>| line([title.to_owned()].into_iter().chain(cells));
        let risks = rows.iter().map(|row| row.text("risk").to_owned()).collect();
        let free = |risk: f64, width: f64| cell(0.5 * width * (1.0 - risk));
        of("S", risks)
            + &line(vec!["---"; rows.len() + 1])
            + &of(
                "half of the free width, (w - d_r) / 2, cm",
                rows.iter().map(|row| free(row.number("risk"), row.number("width_m"))).collect(),
            )
            + &of(
                "smallest clearance of the team, mean, cm",
                rows.iter().map(|row| cell(row.number("clearance_m"))).collect(),
            )
    }),
    ("slots.arrived", |t| {
        let [walks, arrived] = ["walks", "arrived"].map(|column| sum(&t.rows("slots", &[]), column));
        if arrived == walks { format!("all {walks}") } else { format!("{arrived} of {walks}") }
    }),
    ("starts.worlds", |t| grouped(t.row("starts", &[]).number("worlds"))),
    ("starts.started", |t| grouped(t.row("starts", &[]).number("started"))),
    ("starts.arrived", |t| grouped(t.row("starts", &[]).number("arrived"))),
    ("arrivals.rows", arrivals),
    ("arrivals.episodes", |t| grouped(sum(&paper(t), "episodes"))),
    ("arrivals.arrived", |t| grouped(sum(&paper(t), "arrived"))),
    ("arrivals.worst-error", |t| format!("{:.0} mm", 1e3 * most(&paper(t), "error_rms_largest_m"))),
    ("arrivals.grip", |t| format!("{:.2} cm", 100.0 * most(&paper(t), "largest_grip_deflection_m"))),
    ("arrivals.hand", |t| span(t, "hand_force_rms", 0)),
    ("arrivals.peak", |t| format!("{:.0} N", most(&paper(t), "peak_force_N"))),
    ("arrivals.noise", |t| span(t, "force_noise", 2)),
    ("arrivals.led", |t| arrived(&t.rows("arrivals", &[("method", "human-led")]))),
    ("arrivals.changing", |t| arrived(&changing(t))),
    ("arrivals.grip-of-others", |t| {
        let others = [t.rows("arrivals", &[("method", "human-led")]), changing(t)].concat();
        format!("{:.2} cm", 100.0 * most(&others, "largest_grip_deflection_m"))
    }),
    ("bodies-table-3.pairs", |t| format!("{:.0}", wins(t, "episodes"))),
    ("bodies-table-3.wins", |t| format!("{:.0}", wins(t, "wins"))),
    ("bodies-table-3.ratio", |t| ratio(t, UP, "with_po")),
    ("bodies-table-3.ratio-from-elbow-out", |t| ratio(t, OUT, "with_po")),
    ("bodies-table-3.cells", |t| cheaper(t, UP)),
    ("bodies-table-3.cells-from-elbow-out", |t| cheaper(t, OUT)),
    ("bodies-table-3.significant", |t| {
        let tested = |row: &&&FigureRow| row.maybe("with_po_p_holm").is_some_and(|p| p < 0.05);
        let rows = t.rows(UP, &[]);
        let named: Vec<String> = rows
            .iter()
            .filter(tested)
            .map(|row| format!("Environment {}, {}", row.text("environment"), row.text("setting")))
            .collect();
        if named.is_empty() { "none".to_owned() } else { named.join("; ") }
    }),
    ("bodies-table-3.saving", |t| saving(t, UP)),
    ("bodies-table-3.saving-without-bodies", |t| saving(t, "table-3-ratios-elbow-up")),
    ("bodies-table-3.others", |t| {
        let of = |method: &str| format!("{} and {}", ratio(t, UP, method), ratio(t, OUT, method));
        let [uniform, tracked] = ["uniform_weights", "tracked_option"].map(of);
        format!(
            "equal weights: {uniform}; the tracked option alone: {tracked}; manipulability: {}",
            of("manipulability")
        )
    }),
    ("bodies-table-3.parts", parts),
    ("bodies-table-3.wheels-share", |t| {
        let of = |part| mean(&t.column(BODIES_PARTS, &[("method", "with-po")], part));
        format!("{:.0} %", 100.0 * of("wheels") / of("mean"))
    }),
    ("guide.rows", guides),
    ("guide.episodes", |t| format!("{:.0}", largest(&t.column("guide-arrivals", &[], "episodes")))),
    ("guide.worlds", |t| format!("{:.0}", t.row("guide-arrivals", DEFAULT_GUIDE).number("worlds"))),
    ("guide.saving", |t| {
        let of = |guide: &str| t.row("guide-costs", &[("guide", guide)]).number("cost_with_po");
        format!("{:.0} %", 100.0 * (1.0 - of(&format!("price {}", least_price(t))) / of("price 10000")))
    }),
    ("guide.least", least_price),
];

/// The least price down to which no fewer episodes arrive than by default.
fn least_price(t: &Tables) -> String {
    let all = |row: &FigureRow| row.number("arrived") + row.number("worlds_arrived");
    let default = all(t.row("guide-arrivals", DEFAULT_GUIDE));
    let priced = t.rows("guide-arrivals", &[]);
    let priced = priced.into_iter().filter(|row| row.text("guide").starts_with("price"));
    let least = priced.take_while(|row| all(row) >= default).last();
    least.expect("the default arrives").text("guide").replace("price ", "")
}

/// The table of the parts of C.
const BODIES_PARTS: &str = "table-3-bodies-parts-elbow-up";
const DEFAULT_GUIDE: &[(&str, &str)] = &[("guide", "price 10000")];

/// The parts of C on both plants, means over the cells.
fn parts(t: &Tables) -> String {
    let mut text =
        line(["plant", "", "C", "tracking", "wheels", "arm", "pose", "C, intended walk"]) + &line(["---"; 8]);
    for (guide, plant) in [("kinematic, free", "kinematic"), ("price 10000", "with bodies")] {
        let row = t.row("guide-costs", &[("guide", guide)]);
        for (method, title) in [("without_po", "without PO"), ("with_po", "with PO")] {
            let parts = ["cost", "tracking", "wheels", "arm", "pose", "intended_cost"];
            let cells = parts.map(|part| format!("{:.1}", row.number(&format!("{part}_{method}"))));
            text += &line([plant.to_owned(), title.to_owned()].into_iter().chain(cells));
        }
    }
    text
}

/// Arrivals and costs by the guide of the base.
fn guides(t: &Tables) -> String {
    let titles = [
        "guide",
        "Table III arrives",
        "worlds arrive",
        "contacts",
        "lost",
        "clearance, cm",
        "C, with PO",
        "tracking",
        "wheels",
        "arm",
        "ratio",
        "C, intended walk",
        "its ratio",
    ];
    let mut text = line(titles) + &line(["---"; 13]);
    for (arrivals, costs) in t.rows("guide-arrivals", &[]).into_iter().zip(t.rows("guide-costs", &[])) {
        let number = |row: &FigureRow, column: &str, decimals: usize| {
            row.maybe(column).map_or("-".to_owned(), |number| format!("{number:.decimals$}"))
        };
        let sum = |columns: [&str; 2]| {
            format!("{:.0}", columns.map(|column| arrivals.maybe(column).unwrap_or(0.0)).iter().sum::<f64>())
        };
        let has_worlds = arrivals.maybe("worlds").is_some();
        text += &line([
            arrivals.text("guide").to_owned(),
            format!("{} of {}", arrivals.text("arrived"), arrivals.text("episodes")),
            match has_worlds {
                true => format!("{} of {}", arrivals.text("worlds_arrived"), arrivals.text("worlds")),
                false => "-".to_owned(),
            },
            sum(["collided", "worlds_collided"]),
            sum(["lost_object", "worlds_lost_object"]),
            number(arrivals, "least_clearance_cm", 1),
            number(costs, "cost_with_po", 0),
            number(costs, "tracking_with_po", 0),
            number(costs, "wheels_with_po", 0),
            number(costs, "arm_with_po", 0),
            number(costs, "ratio", 3),
            number(costs, "intended_cost_with_po", 0),
            number(costs, "intended_ratio", 3),
        ]);
    }
    text
}

/// The tables of ratios with bodies, by start.
const UP: &str = "table-3-bodies-ratios-elbow-up";
const OUT: &str = "table-3-bodies-ratios-elbow-out";

fn sum(rows: &[&FigureRow], column: &str) -> f64 {
    rows.iter().map(|row| row.number(column)).sum()
}

fn most(rows: &[&FigureRow], column: &str) -> f64 {
    largest(&rows.iter().map(|row| row.number(column)).collect::<Vec<_>>())
}

/// The rows with the methods of Table II.
fn paper(t: &Tables) -> Vec<&FigureRow> {
    let rows = t.rows("arrivals", &[("changes", "none")]);
    rows.into_iter().filter(|row| row.text("method") != "human-led").collect()
}

fn changing(t: &Tables) -> Vec<&FigureRow> {
    t.rows("arrivals", &[("method", "mutual"), ("changes", "once or twice")])
}

fn arrived(rows: &[&FigureRow]) -> String {
    format!("{} of {}", sum(rows, "arrived"), sum(rows, "episodes"))
}

/// From the least to the largest of a force.
fn span(t: &Tables, force: &str, decimals: usize) -> String {
    let of = |end: &str| -> Vec<f64> {
        paper(t).iter().map(|row| row.number(&format!("{force}_{end}_N"))).collect()
    };
    format!("{:.decimals$} to {:.decimals$} N", least(&of("least")), largest(&of("largest")))
}

/// Arrivals and errors by world and method.
fn arrivals(t: &Tables) -> String {
    let mut text = line(["world", "eta 5", "eta 10.5", "eta 15", "without model"]) + &line(["---"; 5]);
    let mut worlds: Vec<&str> = t.rows("arrivals", &[]).iter().map(|row| row.text("world")).collect();
    worlds.dedup();
    for world in worlds {
        let cells = ["5.0", "10.5", "15.0", ""].map(|eta| {
            let rows: Vec<&FigureRow> = paper(t)
                .into_iter()
                .filter(|row| (row.text("world"), row.text("eta")) == (world, eta))
                .collect();
            let row = rows[0];
            format!("{}, {:.1} mm", row.text("arrived"), 1e3 * row.number("error_rms_mean_m"))
        });
        text += &line([world.to_owned()].into_iter().chain(cells));
    }
    text
}

fn wins(t: &Tables, column: &str) -> f64 {
    t.column("table-3-bodies-elbow-up", &[], column).iter().sum()
}

fn cheaper(t: &Tables, table: &str) -> String {
    let ratios = cells(t, table, "with_po");
    format!("{} of {}", ratios.iter().filter(|ratio| **ratio < 1.0).count(), ratios.len())
}

fn saving(t: &Tables, table: &str) -> String {
    let ratios = cells(t, table, "with_po");
    format!("{:.0} %", 100.0 * (1.0 - ratios.iter().sum::<f64>() / ratios.len() as f64))
}

fn transitions(t: &Tables) -> Vec<f64> {
    t.rows("table-2-bodies", &[]).iter().filter_map(|row| row.maybe("transition_difference_steps")).collect()
}
