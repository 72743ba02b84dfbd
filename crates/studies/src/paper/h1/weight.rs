//! The risk weight c_r (Sec. V-A): fitted to Table I's human column, as in the paper, and validated in
//! Environment 4.

use crate::fit::{
    Answers, CELL_ERROR, Estimate, RiskWeightFit, RiskWeightSettings, Situation, fit_risk_weight,
};
use crate::paper::ENVIRONMENTS;
use crate::paper::part::{Block, Figure, Finding, Part, Plan, Section, none};
use crate::parallel::OnDone;
use crate::table::{Columns, Table};
use cocarry::Error;
use cocarry::options::OptionSet;
use cocarry::preference::RISK_WEIGHT;
use cocarry_output::drawing::{self, AnswerPanel, AnswerRow, RiskWeightMark};

/// The fit of c_r.
pub(crate) const PART: Part =
    Part { id: "risk-weight", name: "fit of c_r", episodes: none, studies: none, run: risk_weight_section };

/// Answers and fits, and the error over c_r.
///
/// # Errors
/// If a percentage or a c_r cannot be drawn.
pub fn answers_picture(fit: &RiskWeightFit) -> Result<String, Error> {
    let panels: Vec<AnswerPanel> = fit
        .rows
        .chunk_by(|a, b| a.world == b.world)
        .map(|rows| AnswerPanel {
            title: format!("{}{}", rows[0].world, if rows[0].is_held_out { ", held out" } else { "" }),
            rows: rows
                .iter()
                .map(|row| AnswerRow {
                    option: row.option.clone(),
                    answers: row.answers_percent.clone(),
                    mean: row.mean_percent,
                    fits: [row.likelihood_percent, row.least_squares_percent],
                })
                .collect(),
        })
        .collect();
    let by_likelihood =
        if fit.is_determined() { "likelihood (recommended)" } else { "likelihood (undetermined)" };
    let marks = [(by_likelihood, &fit.likelihood), ("least squares", &fit.least_squares)]
        .map(|(name, e)| RiskWeightMark { name, at: e.risk_weight, interval: e.interval });
    drawing::answers(&panels, &fit.curve, &marks, &fit.caution())
}

fn risk_weight_section(plan: &Plan, on_done: OnDone) -> Result<Section, Error> {
    let predictor = &plan.settings.predictor;
    let mut situations = Vec::new();
    let mut shares = Vec::new();
    for environment in &ENVIRONMENTS {
        let set = OptionSet::new(&environment.world()?, predictor.risk_weight())?;
        situations.push(Situation::new(environment.name.to_owned(), &set));
        let sum: f64 = environment.human_percent.iter().sum();
        shares.push(Some(environment.human_percent.map(|percent| percent / sum).to_vec()));
    }
    let answers = Answers {
        file: "Table I".to_owned(),
        situations,
        participants: vec!["mean".to_owned()],
        shares: vec![shares],
        scaled: Vec::new(),
    };
    let held_out = ENVIRONMENTS[3].name.to_owned();
    let settings = RiskWeightSettings { held_out: vec![held_out], ..RiskWeightSettings::default() };
    let fit = fit_risk_weight(&answers, predictor, &settings, on_done)?;
    let text = "Fitted to the mean answers in Environments 1 to 3 (scaled to 100 % each) and validated with Environment 4's. The paper finds 10. The answers of single \
                participants are not published, so there is no interval.";
    Ok(Section {
        title: "H1: the weight of risk".to_owned(),
        finding: finding(&fit),
        blocks: vec![
            Block::Text(text.to_owned()),
            Block::Table(table(&fit)),
            Block::Figure(Figure {
                name: "risk-weight".to_owned(),
                caption: "Mean answers and the model's, by likelihood and by least squares; below, the error for every c\u{1d63}.".to_owned(),
                is_half: false,
                svg: answers_picture(&fit)?,
            }),
        ],
    })
}

fn table(fit: &RiskWeightFit) -> Table {
    let [low, high] = fit.nearly_as_good;
    let held_out = |e: &Estimate| e.held_out.map_or(f64::NAN, |e| e.rms);
    Columns::of(&[("likelihood", &fit.likelihood), ("least squares", &fit.least_squares)])
        .text("by", "by", |(by, _)| *by)
        .number("c_r (m)", "risk_weight_m", 2, |(_, e)| e.risk_weight)
        .data("lapse", |(_, e)| e.lapse)
        .number("paper (m)", "paper_m", 0, |_| RISK_WEIGHT)
        .number("rms error, fitted (pp)", "fitted_rms_points", 2, |(_, e)| e.fitted.rms)
        .number("Environment 4, held out (pp)", "held_out_rms_points", 2, |(_, e)| held_out(e))
        .table("risk-weight", "c_r, fitted to the human column of Table I")
        .with_note(format!(
            "From {low:.2} to {high:.2} m, the rms error is at most {CELL_ERROR} percentage points (pp) above the least. {}",
            fit.caution()
        ))
}

fn finding(fit: &RiskWeightFit) -> Finding {
    let [low, high] = fit.nearly_as_good;
    let held_out = fit.likelihood.held_out.map_or(f64::NAN, |e| e.rms);
    Finding {
        claim: "The humans' answers give c\u{1d63} = 10 m",
        verdict: format!("{:.1} m", fit.likelihood.risk_weight),
        figures: format!(
            "by likelihood; {:.1} m by least squares, as in the paper, and nearly as good from {low:.1} to {high:.1} m; by likelihood {:.1} percentage points off in the \
             fitted environments and {held_out:.1} in the held-out Environment 4 (rms)",
            fit.least_squares.risk_weight, fit.likelihood.fitted.rms,
        ),
    }
}
