//! Contacts with the sides of an opening, by the paper's risk S.

use crate::paper::contacts::{ANGLES, ContactRow, ContactStudy, RISKS};
use crate::paper::part::{Block, Figure, Finding, Part, Plan, Section, none};
use crate::parallel::OnDone;
use crate::table::{Cell, Columns, Table};
use cocarry::Error;
use cocarry::scenario::{Plant, PlantKind, RobotSetup};
use cocarry_output::drawing::{Curve, CurvePanel, curves};

/// The study of contacts.
pub(crate) const PART: Part = Part {
    id: "contacts",
    name: "contacts",
    episodes: |plan| RISKS.len() * ANGLES.len() * plan.walks,
    studies: none,
    run: contacts_section,
};

fn contacts_section(plan: &Plan, on_done: OnDone) -> Result<Section, Error> {
    let plant = Plant::new(PlantKind::Rapier, RobotSetup::new(plan.robot));
    let study = ContactStudy { plant: &plant, settings: &plan.settings, walks: plan.walks, seed: plan.seed };
    let rows = study.table(on_done)?;
    let text = "The paper takes S = d\u{1d63} / w as the risk of an opening of width w. Here a team with bodies walks through single openings, led by the human, \
                from three angles to the opening's axis.";
    Ok(Section {
        title: "Contacts at openings".to_owned(),
        finding: finding(&rows),
        blocks: vec![
            Block::Text(text.to_owned()),
            Block::Table(contact_table(&rows)),
            Block::Figure(Figure {
                name: "contacts".to_owned(),
                caption: "Share of walks in which a body touched a side of the opening, by the risk S and the angle of the walk to the opening's axis.".to_owned(),
                is_half: false,
                svg: curves(&[panel(&rows)])?,
            }),
        ],
    })
}

fn touched(row: &ContactRow) -> usize {
    row.touched.iter().sum()
}

fn percent(n: usize, of: usize) -> f64 {
    100.0 * n as f64 / of as f64
}

fn panel(rows: &[ContactRow]) -> CurvePanel {
    let curve = |(at, angle): (usize, f64)| Curve {
        label: format!("{angle}\u{b0}"),
        points: rows
            .iter()
            .map(|r| [r.risk, percent(r.touched_by_angle[at], r.walks / ANGLES.len())])
            .collect(),
    };
    CurvePanel {
        title: "walks with contact".to_owned(),
        axes: ["risk S".to_owned(), "%".to_owned()],
        ranges: [[RISKS[0], 1.0], [0.0, 105.0]],
        mark: None,
        curves: ANGLES.into_iter().enumerate().map(curve).collect(),
    }
}

/// The table of contacts, for people and for programs.
pub fn contact_table(rows: &[ContactRow]) -> Table {
    let mut columns = Columns::of(rows)
        .number("risk S", "risk", 2, |r| r.risk)
        .number("width (m)", "width_m", 3, |r| r.width)
        .count("walks", "walks", |r| r.walks as u64)
        .number("contact (%)", "contact_percent", 0, |r| percent(touched(r), r.walks))
        .count("robot", "touched_by_robot", |r| r.touched[0] as u64)
        .count("object", "touched_by_object", |r| r.touched[1] as u64)
        .count("human", "touched_by_human", |r| r.touched[2] as u64)
        .count("other", "ended_otherwise", |r| r.other as u64);
    for (at, angle) in ANGLES.into_iter().enumerate() {
        let share = move |r: &ContactRow| percent(r.touched_by_angle[at], r.walks / ANGLES.len());
        columns = columns.number(
            &format!("at {angle}\u{b0} (%)"),
            &format!("contact_at_{angle}_deg_percent"),
            0,
            share,
        );
    }
    columns
        .column("clear (cm)", false, &["clearance_m"], |r| match r.free {
            0 => Cell { shown: "-".to_owned(), values: vec![None::<f64>.into()] },
            _ => Cell { shown: format!("{:.1}", 100.0 * r.clearance), values: vec![r.clearance.into()] },
        })
        .table("contacts", "Contacts with the sides of one opening, of a team with bodies")
        .with_note("contact: walks in which a body touched a side; robot, object, human: which body did first; other: stuck, or out of time; at an angle: walks that begin at it to the opening's axis;")
        .with_note("clear: smallest clearance from a side in the walks without contact, mean.")
}

fn finding(rows: &[ContactRow]) -> Finding {
    let shares: Vec<f64> = rows.iter().map(|r| percent(touched(r), r.walks)).collect();
    let is_rising = shares.windows(2).all(|pair| pair[0] <= pair[1]);
    let ends = rows.first().zip(rows.last());
    Finding {
        claim: "The risk S = d_r / w of an opening orders openings by how often the team touches them (not tested in the paper)",
        verdict: match (shares.iter().all(|share| *share == 0.0), is_rising) {
            (true, _) => "no contact at any opening",
            (_, true) => "holds",
            (_, false) => "does not hold for all openings",
        }
        .to_owned(),
        figures: ends.map_or(String::new(), |(first, last)| {
            format!(
                "contact in {:.0} % of the walks at S = {}, in {:.0} % at S = {}",
                percent(touched(first), first.walks),
                first.risk,
                percent(touched(last), last.walks),
                last.risk
            )
        }),
    }
}
