//! eta's distribution, from the steps at which participants would have stopped following.

use super::MAX_DRAWN;
use cocarry::Error;
use cocarry::math;
use cocarry_output::drawing::{Curve, CurvePanel, curves};
use cocarry_studies::fit::{Eta, EtaFit, LogNormal, Switch};
use cocarry_studies::report::{Block, Figure, no_interval, tolerances_picture};
use cocarry_studies::table::{Cell, Columns, Table};
use std::f64::consts::SQRT_2;

pub(super) fn blocks(fit: &EtaFit, switches: &[Switch]) -> Result<Vec<Block>, Error> {
    let drawn =
        EtaFit { participants: fit.participants.iter().take(MAX_DRAWN).cloned().collect(), ..fit.clone() };
    let few = match fit.participants.len() > MAX_DRAWN {
        true => format!(" The first {MAX_DRAWN} of {} participants.", fit.participants.len()),
        false => String::new(),
    };
    let everyone = Figure {
        name: "eta".to_owned(),
        caption: format!(
            "The \u{3b7} that agree with each walk (thin; an arrow where the participant followed to the end), every participant's \u{3b7}, and the distribution of all.{few}"
        ),
        is_half: false,
        svg: tolerances_picture(&drawn)?,
    };
    let mut blocks =
        vec![Block::Text(overall(fit)), Block::Table(walks(switches)), Block::Table(people(fit))];
    blocks.push(Block::Figure(everyone));
    blocks.extend(distribution(fit)?.map(Block::Figure));
    Ok(blocks)
}

/// The distribution of all in words.
fn overall(fit: &EtaFit) -> String {
    let mut text = match &fit.overall {
        None => String::new(),
        Some(LogNormal { median, log_std }) => {
            let interval = fit.median_interval.map_or("no interval".to_owned(), |[low, high]| {
                format!("95 % interval {low:.2} to {high:.2}")
            });
            let factor = math::exp(*log_std);
            format!(
                "Log-normal distribution of everybody's \u{3b7}: median {median:.2} ({interval}), spread a factor of {factor:.2}. "
            )
        }
    };
    if let Some(reason) = no_interval(fit) {
        text += &format!("All participants: {reason}. ");
    }
    if fit.is_cautious {
        text += "So few participants switched that the interval is wider than it need be. ";
    }
    if !fit.unexplained_lines.is_empty() {
        let count = fit.unexplained_lines.len();
        text += &format!(
            "Left out: walks that were stopped before any discomfort, which no \u{3b7} explains: {count}. "
        );
    }
    text + "\u{3b7} counts in planning steps of 0.2 s; a participant's is known up to an interval, and only from below where they followed to the end (censored)."
}

/// Walks, and how many were not stopped, by world and option.
fn walks(switches: &[Switch]) -> Table {
    let mut rows: Vec<(String, String, u64, u64)> = Vec::new();
    for switch in switches {
        let (world, executed) = (&switch.world, switch.executed.name());
        let at = rows.iter().position(|row| row.0 == *world && row.1 == executed).unwrap_or_else(|| {
            rows.push((world.clone(), executed, 0, 0));
            rows.len() - 1
        });
        rows[at].2 += 1;
        rows[at].3 += u64::from(switch.step.is_none());
    }
    rows.sort();
    rows.push((
        "all".to_owned(),
        String::new(),
        rows.iter().map(|row| row.2).sum(),
        rows.iter().map(|row| row.3).sum(),
    ));
    Columns::of(&rows)
        .text("world", "world", |row| row.0.clone())
        .text("robot leads on", "executed", |row| row.1.clone())
        .count("walks", "walks", |row| row.2)
        .count("stopped", "stopped", |row| row.2 - row.3)
        .count("followed to the end (censored)", "censored", |row| row.3)
        .table("walks", "Walks of a robot that leads")
}

fn people(fit: &EtaFit) -> Table {
    let end = |eta: &Eta, which: usize| eta.interval.map(|ends| ends[which]);
    let shown = |eta: &Eta| match eta.interval {
        None => "-".to_owned(),
        Some([low, high]) if high.is_infinite() => format!("at least {low:.2}"),
        Some([low, high]) => format!("{low:.2} to {high:.2}"),
    };
    Columns::of(&fit.participants)
        .text("participant", "participant", |eta| eta.participant.clone())
        .column("eta", false, &["eta"], |eta| Cell {
            shown: eta.eta.map_or("-".to_owned(), |eta| format!("{eta:.2}")),
            values: vec![eta.eta.into()],
        })
        .column("interval", false, &["eta_low", "eta_high"], |eta| Cell {
            shown: shown(eta),
            values: vec![end(eta, 0).into(), end(eta, 1).into()],
        })
        .text("evidence", "evidence", |eta| eta.evidence.name())
        .count("walks", "walks", |eta| eta.episodes as u64)
        .count("stopped", "stopped", |eta| eta.switches as u64)
        .count("censored", "censored", |eta| (eta.episodes - eta.switches) as u64)
        .table("eta", "eta of each participant, as `cocarry fit eta` estimates it")
        .with_note("bounded: all walks agree. censored: the participant never stopped a walk. scattered: walks contradict each other; a median with its 95 % interval.")
}

/// The distribution over participants: what their intervals leave open, and the log-normal one.
fn distribution(fit: &EtaFit) -> Result<Option<Figure>, Error> {
    let known: Vec<[f64; 2]> = fit.participants.iter().filter_map(|eta| eta.interval).collect();
    let (Some(overall), [_, _, ..]) = (fit.overall, known.as_slice()) else { return Ok(None) };
    let spread = math::exp(2.5 * overall.log_std);
    let ends = known.iter().flatten().copied().filter(|end| end.is_finite());
    let most = ends.fold(overall.median * spread.min(4.0), f64::max);
    let steps = |end: usize| {
        let mut ends: Vec<f64> = known.iter().map(|ends| ends[end]).filter(|end| end.is_finite()).collect();
        ends.sort_by(f64::total_cmp);
        let share = |count: usize| count as f64 / known.len() as f64;
        let mut points = vec![[0.0, 0.0]];
        for (i, end) in ends.iter().enumerate() {
            points.extend([[*end, share(i)], [*end, share(i + 1)]]);
        }
        points.push([most, share(ends.len())]);
        points
    };
    let below = |eta: f64| {
        let at = (math::ln(eta) - math::ln(overall.median)) / overall.log_std;
        0.5 * math::erfc(-at / SQRT_2)
    };
    let smooth = (1..=200).map(|i| most * f64::from(i) / 200.0).map(|eta| [eta, below(eta)]).collect();
    let curve = |label: &str, points| Curve { label: label.to_owned(), points };
    let panel = CurvePanel {
        title: "participants up to \u{3b7}".to_owned(),
        axes: ["tolerance \u{3b7}".to_owned(), "share".to_owned()],
        ranges: [[0.0, most], [0.0, 1.0]],
        mark: Some(0.5),
        curves: vec![
            curve("log-normal", smooth),
            curve("at least (upper ends)", steps(1)),
            curve("at most (lower ends)", steps(0)),
        ],
    };
    Ok(Some(Figure {
        name: "eta-distribution".to_owned(),
        caption: "Share of participants up to each \u{3b7}: between the two steps, by their intervals, and the fitted log-normal distribution."
            .to_owned(),
        is_half: false,
        svg: curves(&[panel])?,
    }))
}
