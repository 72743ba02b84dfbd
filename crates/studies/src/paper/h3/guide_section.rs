//! H3 with bodies by how much the base is guided: tables, picture and finding.

use super::guide::{Guide, GuideRow, GuideStudy};
use crate::paper::part::{Block, Figure, Finding, Part, Plan, Section, none};
use crate::parallel::OnDone;
use crate::table::{Cell, Columns, Table};
use cocarry::Error;
use cocarry::math;
use cocarry_output::drawing::{Curve, CurvePanel, curves};

/// The study of the guide.
pub(crate) const PART: Part = Part {
    id: "h3-guide",
    name: "Table III, by the guide",
    episodes: |plan| study(plan).units(),
    studies: none,
    run: guide_section,
};

/// Half of the humans and worlds of the parts with bodies: there are many guides.
fn study<'a>(plan: &'a Plan) -> GuideStudy<'a> {
    GuideStudy {
        robot: plan.robot,
        settings: &plan.settings,
        guides: plan.guides,
        episodes: plan.episodes_with_bodies.div_ceil(2),
        worlds: plan.worlds_with_bodies.div_ceil(2),
        seed: plan.seed,
    }
}

fn guide_section(plan: &Plan, on_done: OnDone) -> Result<Section, Error> {
    let rows = study(plan).table(on_done)?;
    let text = "With bodies, the base follows the path of the grasp: the squared deviation of its inputs from those of pure pursuit is part of the cost of eq. (7). \
                Here its price falls, or there is none within a width of where pursuit would take the base; then eqs. (7) and (8) decide the inputs of the base as well. \
                The intended walk is that of a human who does not wait for the robot.";
    let [arrivals, costs] = guide_tables(&rows);
    Ok(Section {
        title: "H3 with bodies, by the guide of the base".to_owned(),
        finding: finding(&rows),
        blocks: vec![
            Block::Text(text.to_owned()),
            Block::Table(arrivals),
            Block::Table(costs),
            Block::Figure(Figure {
                name: "table-3-guide".to_owned(),
                caption: "Share of episodes with bodies that arrive, and the ratio of C with to C without pose optimisation, by the price of the guide (none at the left end)."
                    .to_owned(),
                is_half: false,
                svg: guide_picture(&rows)?,
            }),
        ],
    })
}

/// The least price down to which no fewer episodes arrive than by default.
fn least(rows: &[GuideRow]) -> Option<&GuideRow> {
    let default = rows.iter().find(|row| row.guide == Guide::DEFAULT)?;
    let mut priced: Vec<&GuideRow> = rows.iter().filter(|row| row.guide.price().is_some()).collect();
    priced.sort_by(|a, b| b.guide.price().partial_cmp(&a.guide.price()).unwrap_or(std::cmp::Ordering::Equal));
    priced.into_iter().take_while(|row| row.arrivals()[1] >= default.arrivals()[1]).last()
}

fn finding(rows: &[GuideRow]) -> Finding {
    let arrived = rows.iter().filter(|row| row.guide != Guide::Free).map(|row| {
        let [episodes, arrived] = row.arrivals();
        format!("{}: {arrived} of {episodes}", row.guide.name())
    });
    let arrived = arrived.collect::<Vec<_>>().join(", ");
    let least = least(rows);
    Finding {
        claim: "With bodies, eqs. (7) and (8) decide the inputs of the base (not in the paper)",
        verdict: match least {
            Some(row) if row.guide.price() == Some(0.0) => "holds".to_owned(),
            _ => "only with a guide".to_owned(),
        },
        figures: least.map_or(String::new(), |row| {
            format!(
                "no fewer episodes than by default arrive down to {}, where the ratio of C is {}; arrived: {arrived}",
                row.guide.name(),
                shown(row.ratio)
            )
        }),
    }
}

fn shown(ratio: Option<f64>) -> String {
    ratio.map_or("-".to_owned(), |ratio| format!("{ratio:.3}"))
}

/// The tables of all guides: arrivals, and costs.
pub fn guide_tables(rows: &[GuideRow]) -> [Table; 2] {
    [arrivals(rows), costs(rows)]
}

fn arrivals(rows: &[GuideRow]) -> Table {
    let worlds = |row: &GuideRow| match row.worlds {
        Some(worlds) => Cell {
            shown: format!("{} of {}", worlds.arrived, worlds.worlds),
            values: vec![worlds.arrived.into(), worlds.worlds.into()],
        },
        None => Cell { shown: "-".to_owned(), values: vec![None::<f64>.into(); 2] },
    };
    Columns::of(rows)
        .text("guide", "guide", |row| row.guide.name())
        .column("arrived", false, &["arrived", "episodes"], |row| Cell {
            shown: format!("{} of {}", row.arrived, row.episodes),
            values: vec![row.arrived.into(), row.episodes.into()],
        })
        .count("contacts", "collided", |row| row.collided as u64)
        .count("lost", "lost_object", |row| row.lost_object as u64)
        .number("clearance (cm)", "least_clearance_cm", 1, |row| 100.0 * row.least_clearance)
        .column("worlds", false, &["worlds_arrived", "worlds"], worlds)
        .count("contacts", "worlds_collided", |row| row.worlds.map(|worlds| worlds.collided as u64))
        .count("lost", "worlds_lost_object", |row| row.worlds.map(|worlds| worlds.lost_object as u64))
        .table("guide-arrivals", "Episodes of Table III with bodies, and random walled worlds, by the guide of the base")
        .with_note("contacts: episodes that ended because something touched an obstacle; kinematic: in which the base overlapped one, as eq. (7) has no obstacles there.")
        .with_note("clearance: the smallest between base and obstacle in the episodes of Table III.")
}

fn costs(rows: &[GuideRow]) -> Table {
    let ratio = |ratio: Option<f64>| Cell { shown: shown(ratio), values: vec![ratio.into()] };
    Columns::of(rows)
        .text("guide", "guide", |row| row.guide.name())
        .number("C without PO", "cost_without_po", 1, |row| row.costs()[0])
        .number("with PO", "cost_with_po", 1, |row| row.costs()[1])
        .number("tracking", "tracking_with_po", 1, |row| row.parts[1][0])
        .number("wheels", "wheels_with_po", 1, |row| row.parts[1][1])
        .number("arm", "arm_with_po", 1, |row| row.parts[1][2])
        .number("pose", "pose_with_po", 2, |row| row.parts[1][3])
        .column("ratio", false, &["ratio"], move |row| ratio(row.ratio))
        .number("C intended, without PO", "intended_cost_without_po", 1, |row| row.intended_costs()[0])
        .number("with PO", "intended_cost_with_po", 1, |row| row.intended_costs()[1])
        .column("ratio", false, &["intended_ratio"], move |row| ratio(row.intended_ratio))
        .data("tracking_without_po", |row| row.parts[0][0])
        .data("wheels_without_po", |row| row.parts[0][1])
        .data("arm_without_po", |row| row.parts[0][2])
        .data("pose_without_po", |row| row.parts[0][3])
        .table("guide-costs", "C of Table III with bodies, by the guide of the base; means over the cells")
        .with_note("tracking, wheels, arm and pose: the parts of C with PO.")
        .with_note("C intended: tracking against the walk of a human who does not wait for the robot. Pairs in which either episode did not arrive are left out.")
}

/// Arrivals and ratios over the price of the guide.
///
/// # Errors
/// If a figure is not a number.
pub fn guide_picture(rows: &[GuideRow]) -> Result<String, Error> {
    // the decades of the price; none at -1
    let decade =
        |row: &GuideRow| row.guide.price().map(|price| if price > 0.0 { math::log10(price) } else { -1.0 });
    let curve = |label: &str, value: &dyn Fn(&GuideRow) -> Option<f64>| Curve {
        label: label.to_owned(),
        points: rows.iter().filter_map(|row| Some([decade(row)?, value(row)?])).collect(),
    };
    let panel = |title: &str, unit: &str, range: [f64; 2], curves| CurvePanel {
        title: title.to_owned(),
        axes: ["log10 of the price (-1: no price)".to_owned(), unit.to_owned()],
        ranges: [[-1.0, 4.0], range],
        mark: None,
        curves,
    };
    let percent = |n: usize, of: usize| (of > 0).then(|| 100.0 * n as f64 / of as f64);
    let arrivals = vec![
        curve("Table III", &|row| percent(row.arrived, row.episodes)),
        curve("random worlds", &|row| row.worlds.and_then(|w| percent(w.arrived, w.worlds))),
    ];
    let ratios = vec![
        curve("the human waits", &|row| row.ratio),
        // a team that does not arrive makes the cost of a human who walks on as large as one likes
        curve("the intended walk, if all arrive", &|row| {
            row.intended_ratio.filter(|_| row.arrived == row.episodes)
        }),
    ];
    curves(&[
        panel("episodes that arrive", "%", [0.0, 105.0], arrivals),
        panel("ratio of C", "with / without PO", [0.5, 1.3], ratios),
    ])
}
