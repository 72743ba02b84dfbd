//! The table and the picture of H3 with bodies by how much the base is guided.

use super::guide::{Guide, GuideRow};
use crate::table::{Cell, Columns, Table};
use cocarry_output::drawing::{Curve, CurvePanel, DrawingError, curves};

fn shown(ratio: Option<f64>) -> String {
    ratio.map_or("-".to_owned(), |ratio| format!("{ratio:.3}"))
}

/// The table of all guides.
pub fn guide_table(rows: &[GuideRow]) -> Table {
    let rows: Vec<&GuideRow> = rows.iter().collect();
    let ratio = |ratio: Option<f64>| Cell { shown: shown(ratio), values: vec![ratio.into()] };
    let cost = |row: &GuideRow, method: usize| row.parts[method].iter().sum::<f64>();
    Columns::of(&rows)
        .text("guide", "guide", |row| row.guide.name())
        .column("arrived", false, &["arrived", "episodes"], |row| Cell {
            shown: format!("{} of {}", row.arrived, row.episodes),
            values: vec![row.arrived.into(), row.episodes.into()],
        })
        .count("contacts", "collided", |row| row.collided as u64)
        .count("lost", "lost_object", |row| row.lost_object as u64)
        .number("clearance (cm)", "least_clearance_cm", 1, |row| 100.0 * row.least_clearance)
        .number("C without PO", "cost_without_po", 1, move |row| cost(row, 0))
        .number("with PO", "cost_with_po", 1, move |row| cost(row, 1))
        .number("tracking", "tracking_with_po", 1, |row| row.parts[1][0])
        .number("wheels", "wheels_with_po", 1, |row| row.parts[1][1])
        .number("arm", "arm_with_po", 1, |row| row.parts[1][2])
        .number("pose", "pose_with_po", 2, |row| row.parts[1][3])
        .column("ratio", false, &["ratio"], move |row| ratio(row.ratio))
        .number("C intended, without PO", "intended_cost_without_po", 1, |row| {
            row.intended_tracking[0] + row.parts[0][1..].iter().sum::<f64>()
        })
        .number("with PO", "intended_cost_with_po", 1, |row| {
            row.intended_tracking[1] + row.parts[1][1..].iter().sum::<f64>()
        })
        .column("ratio", false, &["intended_ratio"], move |row| ratio(row.intended_ratio))
        .data("tracking_without_po", |row| row.parts[0][0])
        .data("wheels_without_po", |row| row.parts[0][1])
        .data("arm_without_po", |row| row.parts[0][2])
        .data("pose_without_po", |row| row.parts[0][3])
        .table("table-3-guide", "Table III with bodies, by the guide of the base; means over the cells")
        .with_note("contacts: episodes that ended because something touched an obstacle; kinematic: in which the base overlapped one, as eq. (7) has no obstacles there.")
        .with_note("clearance: the smallest between base and obstacle; tracking, wheels, arm and pose: the parts of C with PO.")
        .with_note("C intended: tracking against the walk of a human who does not wait for the robot. Pairs in which either episode did not arrive are left out of ratios.")
}

/// Arrivals and ratios over the price of the guide.
///
/// # Errors
/// If a figure is not a number.
pub fn guide_picture(rows: &[GuideRow]) -> Result<String, DrawingError> {
    // the decades of the price; none at -1
    let price = |row: &GuideRow| match row.guide {
        Guide::Price { price } => Some(if price > 0.0 { price.log10() } else { -1.0 }),
        _ => None,
    };
    let curve = |label: &str, value: &dyn Fn(&GuideRow) -> Option<f64>| Curve {
        label: label.to_owned(),
        points: rows.iter().filter_map(|row| Some([price(row)?, value(row)?])).collect(),
    };
    let panel = |title: &str, unit: &str, range: [f64; 2], curves| CurvePanel {
        title: title.to_owned(),
        axes: ["log10 of the guide's price".to_owned(), unit.to_owned()],
        ranges: [[-1.0, 4.0], range],
        mark: None,
        curves,
    };
    let percent = |n: usize, row: &GuideRow| Some(100.0 * n as f64 / row.episodes as f64);
    let arrivals = vec![
        curve("arrived", &|row| percent(row.arrived, row)),
        curve("contacts", &|row| percent(row.collided, row)),
    ];
    let ratios = vec![
        curve("today's C", &|row| row.ratio),
        curve("against the intended walk", &|row| row.intended_ratio),
    ];
    curves(&[
        panel("episodes", "%", [0.0, 105.0], arrivals),
        panel("C with over without pose optimisation", "ratio", [0.5, 1.2], ratios),
    ])
}
