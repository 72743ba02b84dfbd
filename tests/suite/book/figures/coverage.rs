//! How often the intervals of the fits contain the true value.

use super::Figure;
use super::tables::{FigureRow, Tables, largest, line};

pub const FIGURES: &[Figure] = &[
    ("coverage.studies", |t| {
        format!("{:.0}", largest(&t.column("coverage-eta", &[], "censored_0_percent_stated")))
    }),
    ("coverage.rows", rows),
    ("coverage.risk-weight-studies", |t| {
        format!("{:.0}", largest(&t.column("coverage-risk-weight", &[], "likelihood_stated")))
    }),
    ("coverage.likelihood", |t| risk_weight(t, "likelihood")),
    ("coverage.least-squares", |t| risk_weight(t, "least_squares")),
];

fn percent(row: &FigureRow, of: &str) -> f64 {
    100.0 * row.number(&format!("{of}_holds")) / row.number(&format!("{of}_stated"))
}

fn rows(t: &Tables) -> String {
    let shares = ["0", "30", "50", "70", "90"];
    let mut text =
        line(["participants", "none censored", "30 %", "50 %", "70 %", "90 %"]) + &line(["---"; 6]);
    for row in t.rows("coverage-eta", &[]) {
        let cells = shares.map(|share| {
            let of = format!("censored_{share}_percent");
            match row.number(&format!("{of}_stated")) {
                0.0 => "not determined".to_owned(),
                stated => format!("{:.1} % ({stated:.0})", percent(row, &of)),
            }
        });
        text += &line([row.text("participants").to_owned()].into_iter().chain(cells));
    }
    text
}

fn risk_weight(t: &Tables, by: &str) -> String {
    let shares: Vec<String> =
        t.rows("coverage-risk-weight", &[]).iter().map(|row| format!("{:.0}", percent(row, by))).collect();
    let [first, second, third] = shares.as_slice() else { panic!("three true values") };
    format!("{first}, {second} and {third} %")
}
