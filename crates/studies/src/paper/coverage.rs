//! How often the intervals of the fits of eta and c_r hold what simulated studies were made from.

use super::part::{Block, Finding, Part, Plan, Section, none};
use crate::fit::{Coverage, EtaDesign, MEDIAN, risk_weight_coverage};
use crate::parallel::OnDone;
use crate::table::{Cell, Columns, Table};
use cocarry::Error;

/// The coverage of the fits.
pub(crate) const PART: Part =
    Part { id: "coverage", name: "coverage of the fits", episodes: none, studies, run: coverage_section };

/// Numbers of participants.
const PEOPLE: [usize; 9] = [2, 3, 4, 5, 6, 8, 12, 20, 50];
/// Percent of the episodes in which nobody would switch before the end, and the length of the longest episode
/// that leaves that many, standard deviations above the median.
const CENSORED: [(u32, f64); 5] = [
    (0, f64::INFINITY),
    (30, 0.524_400_512_708_041),
    (50, 0.0),
    (70, -0.524_400_512_708_041),
    (90, -1.281_551_565_544_600_4),
];
/// True values of c_r, m.
const RISK_WEIGHTS: [f64; 3] = [5.0, 10.0, 20.0];

/// Studies of c_r for each true value: a fit with its bootstrap takes as long as many of eta.
fn risk_weight_studies(plan: &Plan) -> usize {
    (2 * plan.fits / 5).max(1)
}

fn studies(plan: &Plan) -> usize {
    PEOPLE.len() * CENSORED.len() * plan.fits + RISK_WEIGHTS.len() * risk_weight_studies(plan)
}

/// Coverage of the median of eta with a number of participants, for each of [`CENSORED`].
struct EtaRow {
    people: usize,
    cells: [Coverage; CENSORED.len()],
}

/// Coverage of a true c_r by likelihood and by least squares.
struct RiskWeightRow {
    risk_weight: f64,
    cells: [Coverage; 2],
}

fn coverage_section(plan: &Plan, on_done: OnDone) -> Result<Section, Error> {
    let eta = PEOPLE.map(|people| EtaRow {
        people,
        cells: CENSORED.map(|(_, longest)| {
            let design =
                EtaDesign { people, episodes: 1, longest, spread: 0.4, scatter: 0.0, resolution: 0.04 };
            design.coverage(plan.fits, on_done)[0]
        }),
    });
    let mut risk_weight = Vec::new();
    for truth in RISK_WEIGHTS {
        let cells = risk_weight_coverage(truth, risk_weight_studies(plan), on_done)?;
        risk_weight.push(RiskWeightRow { risk_weight: truth, cells });
    }
    let text = format!(
        "Simulated studies, fitted as answers of people are: whether the 95 % interval holds the value that the study was made from. *eta*: {} studies in each cell; ln(eta) is \
         normally distributed between people, with a median of {MEDIAN} and a spread of 0.4; steps are 4 % apart. *c_r*: {} studies in each row, of 20 people each, who choose \
         20 times in each environment, with 30 % random answers and 80 resamples.",
        plan.fits,
        risk_weight_studies(plan)
    );
    Ok(Section {
        title: "Coverage of the fits".to_owned(),
        finding: finding(&eta, &risk_weight),
        blocks: vec![
            Block::Text(text),
            Block::Table(eta_table(&eta)),
            Block::Table(risk_weight_table(&risk_weight)),
        ],
    })
}

fn cell(coverage: &Coverage) -> Cell {
    let Coverage { stated, holds, above, below } = *coverage;
    let shown = match stated {
        0 => "-".to_owned(),
        _ => format!("{:.1} ({stated})", coverage.percent()),
    };
    Cell { shown, values: [stated, holds, above, below].map(Into::into).to_vec() }
}

fn keys(of: &str) -> [String; 4] {
    ["stated", "holds", "above", "below"].map(|part| format!("{of}_{part}"))
}

fn eta_table(rows: &[EtaRow]) -> Table {
    let mut columns = Columns::of(rows).count("participants", "participants", |r| r.people as u64);
    for (at, (percent, _)) in CENSORED.into_iter().enumerate() {
        let keys = keys(&format!("censored_{percent}_percent"));
        columns = columns.column(
            &format!("{percent} % censored"),
            false,
            &keys.each_ref().map(String::as_str),
            |r| cell(&r.cells[at]),
        );
    }
    columns.table("coverage-eta", "Studies whose interval of the median of eta holds it, percent").with_note(
        "censored: episodes that end without a switch; in brackets: studies whose data determine the median.",
    )
}

fn risk_weight_table(rows: &[RiskWeightRow]) -> Table {
    let mut columns = Columns::of(rows).number("c_r (m)", "risk_weight_m", 0, |r| r.risk_weight);
    for (at, (heading, key)) in
        [("by likelihood", "likelihood"), ("by least squares", "least_squares")].into_iter().enumerate()
    {
        let keys = keys(key);
        columns =
            columns.column(heading, false, &keys.each_ref().map(String::as_str), |r| cell(&r.cells[at]));
    }
    columns
        .table("coverage-risk-weight", "Studies whose interval of c_r holds it, percent")
        .with_note("in brackets: studies whose data determine c_r.")
}

fn finding(eta: &[EtaRow], risk_weight: &[RiskWeightRow]) -> Finding {
    // cells in which most studies state an interval: the others are a selection
    let of_most = |cells: &[Coverage], of: usize| -> Vec<f64> {
        cells.iter().filter(|c| 2 * c.stated >= of).map(Coverage::percent).collect()
    };
    let most = eta.iter().flat_map(|row| &row.cells).map(|c| c.stated).max().unwrap_or(0);
    let eta: Vec<f64> = eta.iter().flat_map(|row| of_most(&row.cells, most)).collect();
    let least = eta.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = eta.iter().copied().fold(0.0, f64::max);
    let by = |at: usize| {
        let cells = risk_weight.iter().map(|row| format!("{:.0}", row.cells[at].percent()));
        cells.collect::<Vec<_>>().join(", ")
    };
    Finding {
        claim: "95 % intervals of the fits hold the true value in 95 % of studies (not in the paper)",
        verdict: if least >= 92.0 { "holds" } else { "does not hold in all cells" }.to_owned(),
        figures: format!(
            "median of eta: {least:.0} to {largest:.0} % where at least half of the studies determine it; c\u{1d63} = 5, 10, 20 m: {} % by likelihood, {} % by least squares",
            by(0),
            by(1)
        ),
    }
}
