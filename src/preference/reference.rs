//! A slow reference for the probabilities; tests of the fast method against it are in the files below.
//!
//! At one `gamma`: all pairwise crossings by bisection, and the cheapest option in the middle between
//! neighbouring crossings. Over `gamma`: Simpson's rule, halved until it agrees with itself. The reference
//! shares nothing with the code under test.

mod closed_forms;
mod properties;

use super::*;
use crate::math;

const RISK_WEIGHT: f64 = 10.0;

/// Cost of option `i` minus that of option `j`; differences of similar numbers are taken before the
/// exponentials.
fn difference(i: Prospect, j: Prospect, alpha: f64, gamma: f64) -> f64 {
    let power = |base: f64, other: f64| {
        if other > 0.0 && (base - other).abs() < 1e-2 * other {
            math::pow(other, alpha) * math::exp_m1(alpha * math::ln_1p((base - other) / other))
        } else {
            math::pow(base, alpha) - math::pow(other, alpha)
        }
    };
    let (p, q) = (-math::ln(i.risk), -math::ln(j.risk));
    let risks = if i.risk == j.risk {
        0.0
    } else if (i.risk - j.risk).abs() < 1e-2 * j.risk.min(1.0 - j.risk) {
        let excess = math::pow(q, gamma)
            * math::exp_m1(gamma * math::ln_1p(-math::ln_1p((i.risk - j.risk) / j.risk) / q));
        math::exp(-math::pow(q, gamma)) * math::exp_m1(-excess)
    } else {
        math::exp(-math::pow(p, gamma)) - math::exp(-math::pow(q, gamma))
    };
    power(i.length, j.length) + RISK_WEIGHT * risks
}

/// Probability over `alpha` that each option is the cheapest at `gamma`.
fn shares(options: &[Prospect], alpha: &Marginal, gamma: f64) -> Vec<f64> {
    let (lower, upper) = (alpha.lower(), alpha.upper());
    let mut cuts = vec![lower, upper];
    for i in 0..options.len() {
        for j in 0..i {
            let f = |alpha: f64| difference(options[i], options[j], alpha, gamma);
            let (a, b) = (math::ln(options[i].length), math::ln(options[j].length));
            // Where the derivative a exp(a x) - b exp(b x) changes sign.
            let turn = (math::ln(b / a) / (a - b)).clamp(lower, upper);
            let turn = if turn.is_nan() { upper } else { turn };
            for (mut from, mut to) in [(lower, turn), (turn, upper)] {
                if (f(from) < 0.0) == (f(to) < 0.0) {
                    continue;
                }
                let rises = f(from) < 0.0;
                for _ in 0..50 {
                    let middle = 0.5 * (from + to);
                    if (f(middle) < 0.0) == rises { from = middle } else { to = middle }
                }
                cuts.push(0.5 * (from + to));
            }
        }
    }
    cuts.sort_by(f64::total_cmp);
    let mut shares = vec![0.0; options.len()];
    for piece in cuts.windows(2) {
        let middle = 0.5 * (piece[0] + piece[1]);
        let mut best = 0;
        for i in 1..options.len() {
            if difference(options[i], options[best], middle, gamma) < 0.0 {
                best = i;
            }
        }
        let share = alpha.cdf(piece[1]) - alpha.cdf(piece[0]);
        let winners: Vec<usize> = (0..options.len()).filter(|&i| is_tie(options[i], options[best])).collect();
        winners.iter().for_each(|&i| shares[i] += share / winners.len() as f64);
    }
    shares
}

/// Whether two options are tied: within 1 um in length and 1e-8 of the risk.
fn is_tie(i: Prospect, j: Prospect) -> bool {
    let rare = i.risk.min(j.risk).min(1.0 - i.risk).min(1.0 - j.risk);
    (i.length - j.length).abs() <= 1e-6 && (i.risk - j.risk).abs() <= 1e-8 * rare
}

/// Probability of each option, with at least `panels` panels over `gamma`, halved until Simpson's rule
/// changes by `tolerance`.
fn probabilities(
    options: &[Prospect],
    alpha: &Marginal,
    gamma: &Marginal,
    panels: usize,
    tolerance: f64,
) -> Vec<f64> {
    type Point = (f64, Vec<f64>);
    let at =
        |x: f64| -> Point { (x, shares(options, alpha, x).iter().map(|s| s * gamma.density(x)).collect()) };
    let simpson =
        |a: &Point, m: &Point, b: &Point, o: usize| (b.0 - a.0) / 6.0 * (a.1[o] + 4.0 * m.1[o] + b.1[o]);
    let grid = |k: usize| gamma.lower() + (gamma.upper() - gamma.lower()) * k as f64 / panels as f64;
    let mut todo: Vec<(Point, Point, Point)> = Vec::new();
    for k in 0..panels {
        todo.push((at(grid(k)), at(0.5 * (grid(k) + grid(k + 1))), at(grid(k + 1))));
    }
    let mut sums = vec![0.0; options.len()];
    while let Some((a, m, b)) = todo.pop() {
        let (p, q) = (at(0.5 * (a.0 + m.0)), at(0.5 * (m.0 + b.0)));
        let coarse: Vec<f64> = (0..options.len()).map(|o| simpson(&a, &m, &b, o)).collect();
        let fine: Vec<f64> =
            (0..options.len()).map(|o| simpson(&a, &p, &m, o) + simpson(&m, &q, &b, o)).collect();
        let change = coarse.iter().zip(&fine).map(|(c, f)| (c - f).abs()).fold(0.0, f64::max);
        if change <= tolerance || b.0 - a.0 < 1e-11 {
            sums.iter_mut()
                .zip(coarse.iter().zip(&fine))
                .for_each(|(sum, (c, f))| *sum += f + (f - c) / 15.0);
        } else {
            todo.push((a, p, m.clone()));
            todo.push((m, q, b));
        }
    }
    sums
}

fn predicted(options: &[Prospect], belief: Belief) -> Vec<f64> {
    let mut choice = ChoiceDistribution::default();
    Predictor::new(belief, RISK_WEIGHT).unwrap().predict(options, &mut choice);
    choice.probabilities().to_vec()
}

fn error(options: &[Prospect], alpha: Marginal, gamma: Marginal) -> f64 {
    let reference = probabilities(options, &alpha, &gamma, 256, 1e-13);
    let found = predicted(options, Belief::Independent { alpha, gamma });
    found.iter().zip(&reference).map(|(f, r)| (f - r).abs()).fold(0.0, f64::max)
}

fn paper_ranges() -> (Marginal, Marginal) {
    (Marginal::uniform(0.55, 0.95).unwrap(), Marginal::uniform(0.5, 1.1).unwrap())
}

fn options_of(pairs: &[(f64, f64)]) -> Vec<Prospect> {
    pairs.iter().map(|&(length, risk)| Prospect::new(length, risk)).collect()
}
