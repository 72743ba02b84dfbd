//! Options as curves over `alpha`: which of them can win at all, and where two of them cross.

use super::Prospect;
use super::ties::Ties;
use crate::math;

/// An option whose perceived length is a curve `D^alpha` over the distance perception.
#[derive(Debug, Clone, Copy)]
pub(super) struct Curve {
    /// Index of the option among the prospects.
    pub option: usize,
    /// Remaining length `D`, metres.
    pub length: f64,
    /// `ln D`; minus infinity at the target.
    pub log_length: f64,
    /// Remaining risk `S`.
    pub risk: f64,
    /// `-ln S`, in `[0, infinity]`.
    pub surprise: f64,
    /// `ln(-ln S)`, so that Prelec's function is `exp(-exp(gamma * log_surprise))`.
    pub log_surprise: f64,
}

impl Curve {
    pub fn new(option: usize, prospect: Prospect) -> Self {
        let surprise = -math::ln(prospect.risk);
        Self {
            option,
            length: prospect.length,
            log_length: math::ln(prospect.length),
            risk: prospect.risk,
            surprise,
            log_surprise: math::ln(surprise),
        }
    }

    /// `D^alpha`.
    pub fn perceived_length(&self, alpha: f64) -> f64 {
        math::exp(alpha * self.log_length)
    }

    /// `exp(-(-ln S)^gamma)`.
    pub fn perceived_risk(&self, gamma: f64) -> f64 {
        math::exp(-math::exp(gamma * self.log_surprise))
    }

    /// Derivative of `D^alpha` with respect to `alpha`.
    pub fn slope(&self, alpha: f64) -> f64 {
        if self.length > 0.0 { self.perceived_length(alpha) * self.log_length } else { 0.0 }
    }
}

/// Fills `front` with the choices that no other one dominates, shortest first.
///
/// Both perceptions are monotone, so an option that is neither shorter nor safer than another never wins,
/// whatever `alpha` and `gamma` are. In the result lengths strictly rise and risks strictly fall.
pub(super) fn pareto_front(ties: &Ties, risk_matters: bool, front: &mut Vec<Curve>) {
    front.clear();
    let mut lowest = f64::INFINITY;
    front.extend(ties.leaders().filter_map(|(option, prospect)| {
        // The first option always stays; an option of infinite length stays only if it is the first.
        let first = lowest == f64::INFINITY;
        let stays = first || (prospect.risk < lowest && risk_matters && prospect.length.is_finite());
        stays.then(|| {
            lowest = prospect.risk;
            Curve::new(option, prospect)
        })
    }));
}

/// The `alpha` at which `D_i^alpha - D_j^alpha` turns around, for two lengths in `(0, 1)`; `None` where it is
/// monotone.
///
/// Two lengths of at least 1 m, or one on either side of it, cross at most once. Two options with less than 1
/// m left may cross once on each side of this point.
pub(super) fn turning_point(shorter: &Curve, longer: &Curve) -> Option<f64> {
    if !(shorter.length > 0.0 && longer.length < 1.0) {
        return None;
    }
    let ratio = log_ratio(longer, shorter);
    Some(math::ln_1p(ratio / -longer.log_length) / ratio)
}

/// The difference of logarithms below which it is computed from the difference of the numbers, to keep its
/// relative accuracy.
const CLOSE: f64 = 0.02;

/// `ln(D_long / D_short)`; infinite when the shorter length is 0.
fn log_ratio(longer: &Curve, shorter: &Curve) -> f64 {
    let ratio = longer.log_length - shorter.log_length;
    if ratio < CLOSE { math::ln_1p((longer.length - shorter.length) / shorter.length) } else { ratio }
}

/// `ln` of the ratio of `-ln S` of the two (larger for the safer option); infinite when a risk is 0 or 1.
fn log_surprise_ratio(riskier: &Curve, safer: &Curve) -> f64 {
    let ratio = safer.log_surprise - riskier.log_surprise;
    if ratio < CLOSE {
        math::ln_1p(math::ln_1p((riskier.risk - safer.risk) / safer.risk) / riskier.surprise)
    } else {
        ratio
    }
}

/// Two curves, the left one falling below the right one as `alpha` shrinks. Their crossing is solved
/// repeatedly for slowly changing risks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pair {
    /// Rank of the curve that is lower to the left of the crossing.
    pub left: usize,
    /// Rank of the curve that is lower to the right of the crossing.
    pub right: usize,
    /// Whether the left curve is the longer option: the length gap then grows with `alpha`, else it shrinks.
    pub rising: bool,
    long_log: f64,
    short_log: f64,
    /// `ln(D_long / D_short)`.
    ratio: f64,
    /// `ln` of the ratio of the two `-ln S`; infinite if one of them is 0 or infinite.
    surprise_ratio: f64,
    last: Option<Tangent>,
}

/// `H(alpha) = ln(D_long^alpha - D_short^alpha)` and its derivatives at one point.
#[derive(Debug, Clone, Copy)]
struct Tangent {
    alpha: f64,
    value: f64,
    first: f64,
    second: f64,
    third: f64,
}

/// A curve's risk as perceived at one value of `gamma`.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Level {
    /// `(-ln S)^gamma`.
    pub exponent: f64,
    /// `c_r exp(-exponent)`.
    pub cost: f64,
}

impl Pair {
    pub fn new(left: usize, left_curve: &Curve, right: usize, right_curve: &Curve) -> Self {
        let rising = left_curve.length > right_curve.length;
        let (long, short) = if rising { (left_curve, right_curve) } else { (right_curve, left_curve) };
        Self {
            left,
            right,
            rising,
            long_log: long.log_length,
            short_log: short.log_length,
            ratio: log_ratio(long, short),
            surprise_ratio: log_surprise_ratio(short, long),
            last: None,
        }
    }

    /// The cost of the shorter, riskier option's risk minus that of the longer option's, which the length gap
    /// must make up for.
    pub fn risk_gap(&self, levels: &[Level], gamma: f64, risk_weight: f64) -> f64 {
        let (long, short) = if self.rising { (self.left, self.right) } else { (self.right, self.left) };
        let (long, short) = (levels[long], levels[short]);
        let gap = short.cost - long.cost;
        if gap > 1e-3 * risk_weight {
            return gap;
        }
        // The two costs share most of their digits: subtract before the exponential instead of after it.
        let excess = if short.exponent > 0.0 && self.surprise_ratio.is_finite() {
            short.exponent * math::exp_m1(gamma * self.surprise_ratio)
        } else {
            long.exponent - short.exponent
        };
        short.cost * -math::exp_m1(-excess)
    }

    /// `D_long^alpha - D_short^alpha`.
    pub fn length_gap(&self, alpha: f64) -> f64 {
        let short = math::exp(alpha * self.short_log);
        let stretch = alpha * self.ratio;
        if stretch < 0.1 { short * math::exp_m1(stretch) } else { math::exp(alpha * self.long_log) - short }
    }

    /// Cost of the left curve minus that of the right one.
    pub fn difference(&self, alpha: f64, risk_gap: f64) -> f64 {
        let excess = self.length_gap(alpha) - risk_gap;
        if self.rising { excess } else { -excess }
    }

    /// The `alpha` in `[lower, upper]` where the two curves cost the same; the nearer bound if they do not
    /// cross in between.
    ///
    /// Solves `alpha ln D_long + ln(1 - exp(-alpha ratio)) = ln risk_gap`, which is nearly linear and concave
    /// in `alpha`. Halley steps inside a shrinking bracket start from the expansion around the last solution.
    pub fn crossing(&mut self, risk_gap: f64, lower: f64, upper: f64) -> f64 {
        let target = math::ln(risk_gap);
        if target == f64::NEG_INFINITY {
            return if self.rising { lower } else { upper };
        }
        let (mut below, mut above) = (lower, upper);
        let mut alpha = match self.last {
            Some(last) => last.expand(target),
            None => 0.5 * (lower + upper),
        };
        alpha = if alpha.is_nan() { 0.5 * (lower + upper) } else { alpha.clamp(lower, upper) };
        for _ in 0..80 {
            let tangent = self.tangent(alpha);
            let excess = tangent.value - target;
            let to_the_right = (excess < 0.0) == self.rising;
            if to_the_right {
                below = alpha;
            } else {
                above = alpha;
            }
            if (to_the_right && alpha == upper) || (!to_the_right && alpha == lower) {
                return alpha;
            }
            let Tangent { first, second, .. } = tangent;
            let step = excess * first / (first * first - 0.5 * excess * second);
            let next = alpha - step;
            let bend = (second / first).abs().max(1.0);
            if step.abs() * (step * bend) * (step * bend) < 1e-14 && step.is_finite() {
                self.last = Some(tangent);
                return next.clamp(lower, upper);
            }
            let inside = next > below && next < above;
            alpha = if inside {
                next
            } else if next <= lower && below == lower && alpha != lower {
                lower
            } else if next >= upper && above == upper && alpha != upper {
                upper
            } else {
                0.5 * (below + above)
            };
            if above - below <= 1e-15 * above {
                return alpha;
            }
        }
        alpha
    }

    fn tangent(&self, alpha: f64) -> Tangent {
        let shrunk = math::exp(-alpha * self.ratio);
        let rest = if alpha * self.ratio < 0.1 { -math::exp_m1(-alpha * self.ratio) } else { 1.0 - shrunk };
        let value = alpha * self.long_log + math::ln(rest);
        if shrunk == 0.0 {
            return Tangent { alpha, value, first: self.long_log, second: 0.0, third: 0.0 };
        }
        let pull = self.ratio / rest;
        let bent = pull * shrunk;
        let second = -bent * pull;
        Tangent { alpha, value, first: self.long_log + bent, second, third: -second * pull * (1.0 + shrunk) }
    }

    /// Starts from the last solution of the same pair.
    pub fn warm(&mut self, earlier: &Self) {
        self.last = earlier.last;
    }
}

impl Tangent {
    /// Where `H` reaches `target`, by the inverse series up to third order.
    fn expand(&self, target: f64) -> f64 {
        let step = (target - self.value) / self.first;
        let (bend, twist) = (self.second / self.first, self.third / self.first);
        self.alpha + step * (1.0 - step * (0.5 * bend - step * (0.5 * bend * bend - twist / 6.0)))
    }
}
