//! The log-normal distribution of a positive number that is known by intervals only.
//!
//! The median is estimated by integrating the likelihood over the spread. The prior is flat in the mean and
//! in the logarithm of the spread. For exactly known values this gives Student's interval, and with censored
//! values the interval has its nominal coverage (`book/src/results.md`, "Coverage of the fits"). The
//! likelihood alone is largest at a spread of 0 wherever all sets overlap, and its usual intervals are too
//! narrow for few draws.

use super::set::{Set, hull};
use cocarry::math;
use serde::Serialize;
use std::fmt;

/// A log-normal distribution.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LogNormal {
    /// exp of the mean of the logarithm.
    pub median: f64,
    /// Standard deviation of the logarithm.
    pub log_std: f64,
}

/// The reason why there is no 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoInterval {
    /// There are too few draws.
    Few {
        /// Number of informative draws.
        found: usize,
    },
    /// Too few draws are bounded from both sides: spread and median are confounded.
    Unbounded {
        /// Number of draws bounded from both sides.
        bounded: usize,
        /// Number of informative draws.
        of: usize,
    },
}

/// Number of draws that an interval needs. With two or three draws, the studies with enough bounded draws are
/// a selection, and intervals have too low a coverage.
pub const MIN_DRAWS: usize = 4;
/// Number of draws bounded from both sides that an estimate needs. With fewer, the likelihood does not limit
/// the spread.
pub const MIN_BOUNDED: usize = 2;

/// Ratio of consecutive spreads on the grid.
const SPREAD_RATIO: f64 = 1.3;
/// Ratio of consecutive scatters on the grid for repeated draws.
const SCATTER_RATIO: f64 = 1.4;
/// Width of the cells, in units of the scatter, on which the likelihood of a repeated draw is taken as
/// constant; and the largest number of cells.
const CELL_WIDTH: f64 = 0.8;
const MAX_CELLS: usize = 400;
/// Number of means on the grid for every spread.
const MEANS: usize = 41;
/// Means and spreads are included down to exp of minus this of the largest weight.
const MIN_LOG_WEIGHT: f64 = 14.0;
/// Probabilities below this are approximated.
const MIN_PROBABILITY: f64 = 1e-280;
/// The resolution (in the logarithm) of exactly known draws; smaller differences are ignored.
const EXACT_RESOLUTION: f64 = 1e-4;

impl fmt::Display for NoInterval {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Few { found } => {
                write!(f, "{found}; a 95 % interval needs at least {MIN_DRAWS}")
            }
            Self::Unbounded { bounded, of } => {
                write!(f, "{bounded} of {of} bounded on both sides, at least {MIN_BOUNDED} needed")
            }
        }
    }
}

impl Serialize for NoInterval {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// A number that is known exactly.
#[cfg(test)]
fn exactly(value: f64) -> Set {
    vec![[value * math::exp(-EXACT_RESOLUTION), value * math::exp(EXACT_RESOLUTION)]]
}

/// Whether a set has a lower end above 0 and an upper end.
pub(super) fn is_bounded(set: &Set) -> bool {
    hull(set).is_some_and(|[low, high]| low > 0.0 && high.is_finite())
}

/// The distribution of draws that each lie in a set, and the 95 % interval of its median.
///
/// # Errors
/// For the interval, or both: [`NoInterval`].
pub fn fit(sets: &[Set]) -> Result<(LogNormal, Result<[f64; 2], NoInterval>), NoInterval> {
    fitted(sets.iter().filter(|set| is_bounded(set)).count(), sets.len(), || {
        let (draws, resolution) = (sets.iter().map(Draw::of).collect(), resolution(sets));
        Posterior { rows: Draws { draws, resolution }.rows() }
    })
}

/// The distribution of draws that are themselves medians. The numbers of a draw scatter around it
/// log-normally, and each lies in a set. The scatter is the same for all draws and unknown; it is integrated
/// out too.
///
/// # Errors
/// As [`fit`].
pub fn fit_repeated(draws: &[Vec<Set>]) -> Result<(LogNormal, Result<[f64; 2], NoInterval>), NoInterval> {
    fitted(draws.iter().filter(|sets| sets.iter().any(is_bounded)).count(), draws.len(), || {
        let all: Vec<Set> = draws.iter().flatten().cloned().collect();
        let (resolution, [low, high]) = (resolution(&all), ends(&all));
        let repeats = all.len() as f64 / draws.len() as f64;
        let mut rows: Vec<SpreadRow> = Vec::new();
        let mut best = f64::NEG_INFINITY;
        let mut scatter = (4.0 * (high - low)).max(resolution);
        while scatter > resolution / 8.0 {
            let variance = math::squared(scatter) / repeats + math::squared(resolution);
            let repeated = draws.iter().map(|sets| Draw::repeated(sets, scatter)).collect();
            let mut found = Draws { draws: repeated, resolution: variance.sqrt() }.rows();
            let prior = math::ln(share_above(scatter, resolution));
            found.iter_mut().for_each(|row| row.log_weight += prior);
            let most = found.iter().map(|row| row.log_weight).fold(f64::NEG_INFINITY, f64::max);
            if most < best - MIN_LOG_WEIGHT {
                break;
            }
            best = best.max(most);
            rows.extend(found);
            scatter /= SCATTER_RATIO;
        }
        Posterior { rows }
    })
}

fn fitted(
    bounded: usize,
    of: usize,
    posterior: impl FnOnce() -> Posterior,
) -> Result<(LogNormal, Result<[f64; 2], NoInterval>), NoInterval> {
    if bounded < MIN_BOUNDED {
        return Err(NoInterval::Unbounded { bounded, of });
    }
    let posterior = posterior();
    let [low, median, high] = [0.025, 0.5, 0.975].map(|share| math::exp(posterior.mean_at(share)));
    let interval = if of < MIN_DRAWS { Err(NoInterval::Few { found: of }) } else { Ok([low, high]) };
    Ok((LogNormal { median, log_std: posterior.median_spread() }, interval))
}

/// The smallest and the largest logarithm of an end that is neither 0 nor infinite.
fn ends(sets: &[Set]) -> [f64; 2] {
    let ends = sets.iter().flatten().flatten().map(|end| math::ln(*end)).filter(|end| end.is_finite());
    [ends.clone().fold(f64::INFINITY, f64::min), ends.fold(f64::NEG_INFINITY, f64::max)]
}

/// The standard deviation of (the logarithm of) a number within its set, for the bounded set of median width.
fn resolution(sets: &[Set]) -> f64 {
    let width = |set: &Set| hull(set).map(|[low, high]| math::ln(high) - math::ln(low));
    let mut widths: Vec<f64> = sets.iter().filter(|set| is_bounded(set)).filter_map(width).collect();
    widths.sort_by(f64::total_cmp);
    (widths.get(widths.len() / 2).copied().unwrap_or_default() / 12f64.sqrt()).max(EXACT_RESOLUTION)
}

/// A prior that is flat in the logarithm of the observed scatter, which combines spread and resolution.
fn share_above(spread: f64, resolution: f64) -> f64 {
    math::squared(spread) / (math::squared(spread) + math::squared(resolution))
}

/// The posterior of mean and spread of the logarithm.
struct Posterior {
    rows: Vec<SpreadRow>,
}

/// The posterior at one spread.
struct SpreadRow {
    log_spread: f64,
    /// The logarithm of its weight among the spreads.
    log_weight: f64,
    /// The first and the last mean of an equidistant grid.
    means: [f64; 2],
    /// Cumulative share of the means.
    cumulated: [f64; MEANS],
}

/// The likelihood of a draw's logarithm: piecewise constant on some intervals.
struct Draw {
    pieces: Vec<([f64; 2], f64)>,
}

struct Draws {
    draws: Vec<Draw>,
    /// Typical standard deviation of a draw within its likelihood.
    resolution: f64,
}

impl Posterior {
    /// The mean below which this share lies.
    fn mean_at(&self, share: f64) -> f64 {
        let weights = self.weights();
        let total: f64 = weights.iter().sum();
        let below = |mean: f64| -> f64 {
            self.rows.iter().zip(&weights).map(|(row, weight)| weight * row.below(mean)).sum::<f64>() / total
        };
        let mut low = self.rows.iter().map(|row| row.means[0]).fold(f64::INFINITY, f64::min);
        let mut high = self.rows.iter().map(|row| row.means[1]).fold(f64::NEG_INFINITY, f64::max);
        for _ in 0..60 {
            let middle = (low + high) / 2.0;
            if below(middle) < share { low = middle } else { high = middle }
        }
        (low + high) / 2.0
    }

    /// The median of the spread.
    fn median_spread(&self) -> f64 {
        let weights = self.weights();
        let half = weights.iter().sum::<f64>() / 2.0;
        let mut spreads: Vec<(f64, f64)> = self.rows.iter().map(|row| row.log_spread).zip(weights).collect();
        spreads.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut sum = 0.0;
        for same in spreads.chunk_by(|a, b| a.0 == b.0) {
            let weight: f64 = same.iter().map(|spread| spread.1).sum();
            if sum + weight >= half {
                // the row represents the spreads half a ratio to either side
                let part = (half - sum) / weight - 0.5;
                return math::exp(same[0].0 + part * math::ln(SPREAD_RATIO));
            }
            sum += weight;
        }
        f64::NAN
    }

    /// The rows' weights; the largest is 1.
    fn weights(&self) -> Vec<f64> {
        let most = self.rows.iter().map(|row| row.log_weight).fold(f64::NEG_INFINITY, f64::max);
        self.rows.iter().map(|row| math::exp(row.log_weight - most)).collect()
    }
}

impl SpreadRow {
    fn below(&self, mean: f64) -> f64 {
        let last = MEANS - 1;
        let at = (mean - self.means[0]) / (self.means[1] - self.means[0]) * last as f64;
        if at <= 0.0 {
            return 0.0;
        }
        let below = at as usize;
        match below < last {
            true => {
                let [from, to] = [self.cumulated[below], self.cumulated[below + 1]];
                from + at.fract() * (to - from)
            }
            false => 1.0,
        }
    }
}

impl Draw {
    fn of(set: &Set) -> Self {
        Self { pieces: set.iter().map(|piece| (piece.map(math::ln), 1.0)).collect() }
    }

    /// A draw around which numbers that lie in these sets scatter.
    fn repeated(sets: &[Set], scatter: f64) -> Self {
        let own: Vec<Self> = sets.iter().map(Self::of).collect();
        let [low, high] = ends(sets).map(|end| end / scatter);
        // in units of the scatter, from below the smallest end to above the largest
        let cells = (((high - low + 8.0) / CELL_WIDTH).ceil() as usize).clamp(1, MAX_CELLS);
        let width = (high - low + 8.0) / cells as f64;
        let edge = |i: usize| match i {
            0 => f64::NEG_INFINITY,
            _ if i == cells => f64::INFINITY,
            _ => (low - 4.0 + width * i as f64) * scatter,
        };
        let likelihood = |i: usize| -> f64 {
            let middle = (low - 4.0 + width * (i as f64 + 0.5)) * scatter;
            own.iter().map(|draw| draw.probability(middle, scatter)).product()
        };
        let mut pieces: Vec<_> = (0..cells).map(|i| ([edge(i), edge(i + 1)], likelihood(i))).collect();
        let most = pieces.iter().map(|piece| piece.1).fold(0.0, f64::max);
        pieces.retain(|piece| piece.1 >= 1e-4 * most && piece.1 > 0.0);
        Self { pieces }
    }

    /// Negative log-likelihood of a mean and a spread.
    fn loss(&self, mean: f64, spread: f64) -> f64 {
        let probability = self.probability(mean, spread);
        if probability > MIN_PROBABILITY {
            return -math::ln(probability);
        }
        // the likelihood underflows: let the loss grow with the distance, so that the search for the
        // likeliest mean has a slope
        let distance = |[low, high]: [f64; 2]| (low - mean).max(mean - high).max(0.0) / spread;
        let nearest = self.pieces.iter().map(|piece| distance(piece.0)).fold(f64::INFINITY, f64::min);
        (-math::ln(MIN_PROBABILITY)).max(math::squared(nearest) / 2.0)
    }

    /// The likelihood of a mean and a spread.
    fn probability(&self, mean: f64, spread: f64) -> f64 {
        let share = |[low, high]: [f64; 2]| between((low - mean) / spread, (high - mean) / spread);
        match self.pieces.as_slice() {
            [(piece, weight)] => weight * share(*piece),
            // neighbours share an end
            pieces => {
                let mut last = (f64::NAN, 0.0);
                let mut above_end = |end: f64| {
                    if end != last.0 {
                        last = (end, above((end - mean) / spread));
                    }
                    last.1
                };
                let shares =
                    pieces.iter().map(|([low, high], weight)| weight * (above_end(*low) - above_end(*high)));
                shares.sum::<f64>().max(0.0)
            }
        }
    }
}

impl Draws {
    /// Rows for spreads from far below the resolution to far above the observed range.
    fn rows(&self) -> Vec<SpreadRow> {
        let ends = self.ends();
        let start = (ends[1] - ends[0]).max(self.resolution);
        let mut rows = Vec::new();
        let mut best = f64::NEG_INFINITY;
        for (first, ratio) in [(start, 1.0 / SPREAD_RATIO), (start * SPREAD_RATIO, SPREAD_RATIO)] {
            let mut spread = first;
            while spread > self.resolution / 50.0 && spread < start * 1e6 {
                let row = self.row(spread, ends);
                best = best.max(row.log_weight);
                let is_far = row.log_weight < best - MIN_LOG_WEIGHT;
                rows.push(row);
                if is_far {
                    break;
                }
                spread *= ratio;
            }
        }
        rows
    }

    /// The smallest and the largest finite end of a piece.
    fn ends(&self) -> [f64; 2] {
        let ends = self.draws.iter().flat_map(|draw| &draw.pieces).flat_map(|piece| piece.0);
        let ends = ends.filter(|end| end.is_finite());
        [ends.clone().fold(f64::INFINITY, f64::min), ends.fold(f64::NEG_INFINITY, f64::max)]
    }

    /// Negative log-likelihood of a mean and a spread.
    fn loss(&self, mean: f64, spread: f64) -> f64 {
        self.draws.iter().map(|draw| draw.loss(mean, spread)).sum()
    }

    /// The weights of the means at one spread.
    fn row(&self, spread: f64, ends: [f64; 2]) -> SpreadRow {
        let near = spread / (self.draws.len() as f64).sqrt();
        let loss = |mean: f64| self.loss(mean, spread);
        let ends = [ends[0] - 6.0 * spread, ends[1] + 6.0 * spread];
        let mode = super::minimum::golden(ends, 0.05 * near, loss);
        let least = loss(mode);
        // the distance at which the loss is no longer relevant
        let reach = |sign: f64| {
            let is_near = |distance: f64| loss(mode + sign * distance) < least + MIN_LOG_WEIGHT;
            let (mut inside, mut outside) = (0.0, 0.5 * near);
            while is_near(outside) && outside < 1e4 * (spread + ends[1] - ends[0]) {
                inside = outside;
                outside *= 2.0;
            }
            for _ in 0..4 {
                let middle = (inside + outside) / 2.0;
                if is_near(middle) { inside = middle } else { outside = middle }
            }
            outside
        };
        let means = [mode - reach(-1.0), mode + reach(1.0)];
        let step = (means[1] - means[0]) / (MEANS - 1) as f64;
        let density = |i: usize| math::exp(least - loss(means[0] + step * i as f64));
        let mut cumulated = [0.0; MEANS];
        let mut before = density(0);
        for i in 1..MEANS {
            let here = density(i);
            cumulated[i] = cumulated[i - 1] + 0.5 * step * (before + here);
            before = here;
        }
        let total = cumulated[MEANS - 1];
        cumulated.iter_mut().for_each(|share| *share /= total);
        let log_weight = math::ln(share_above(spread, self.resolution) * total) - least;
        SpreadRow { log_spread: math::ln(spread), log_weight, means, cumulated }
    }
}

/// Probability that a standard normal number lies between `a` and `b`; either may be infinite.
fn between(a: f64, b: f64) -> f64 {
    // in the upper tail, where small probabilities are accurate
    let (a, b) = if a + b < 0.0 { (-b, -a) } else { (a, b) };
    if b - a < 1e-4 {
        // where rounding would dominate
        let middle = (a + b) / 2.0;
        return (b - a) * math::exp(-middle * middle / 2.0) / std::f64::consts::TAU.sqrt();
    }
    if a <= 0.0 { 1.0 - above(-a) - above(b) } else { above(a) - above(b) }
}

/// Probability that a standard normal number is above `x`.
fn above(x: f64) -> f64 {
    0.5 * math::erfc(x / std::f64::consts::SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

    fn interval(sets: &[Set]) -> [f64; 2] {
        fit(sets).unwrap().1.unwrap()
    }

    #[test]
    fn closed_form_exact_draws_give_students_interval() {
        for values in [vec![4.0f64, 8.0, 10.0, 14.0], vec![5.0, 5.5, 6.0, 9.0, 12.0, 30.0, 31.0]] {
            let sets: Vec<Set> = values.iter().map(|v| exactly(*v)).collect();
            let (found, interval) = fit(&sets).unwrap();
            let logs: Vec<f64> = values.iter().map(|v| math::ln(*v)).collect();
            let (mean, std) = crate::statistics::mean_and_std(&logs);
            let n = values.len() as f64;
            let half = StudentsT::new(0.0, 1.0, n - 1.0).unwrap().inverse_cdf(0.975) * std / n.sqrt();
            let [low, high] = interval.unwrap().map(math::ln);
            assert!((math::ln(found.median) - mean).abs() < 0.01 * half, "{found:?}");
            assert!((low - (mean - half)).abs() < 0.02 * half, "{low}, not {}", mean - half);
            assert!((high - (mean + half)).abs() < 0.02 * half, "{high}, not {}", mean + half);
            assert!(found.log_std > std && found.log_std < 1.2 * std, "{found:?}, {std}");
        }
    }

    #[test]
    fn closed_form_a_censored_draw_raises_the_median() {
        let two = [exactly(4.0), exactly(8.0)];
        let three = [exactly(4.0), exactly(8.0), vec![[8.0, f64::INFINITY]]];
        let median = |sets: &[Set]| fit(sets).unwrap().0.median;
        assert!(median(&three) > 1.1 * median(&two));
    }

    #[test]
    fn draws_that_do_not_determine_the_median_say_why() {
        let never = || vec![[8.0, f64::INFINITY]];
        let at_once = || vec![[0.0, 1.0]];
        let one = [never(), exactly(9.0), never(), never()];
        assert_eq!(fit(&one), Err(NoInterval::Unbounded { bounded: 1, of: 4 }));
        assert_eq!(fit(&[at_once(), never()]), Err(NoInterval::Unbounded { bounded: 0, of: 2 }));
        let (_, interval) = fit(&[exactly(4.0), exactly(8.0), never()]).unwrap();
        assert_eq!(interval, Err(NoInterval::Few { found: 3 }));
        assert!(fit(&[exactly(4.0), exactly(8.0), never(), never()]).unwrap().1.is_ok());
    }

    #[test]
    fn sets_that_overlap_have_a_spread() {
        let sets = [[3.0, 6.0], [5.0, f64::INFINITY], [4.0, 7.0], [4.5, 6.5]].map(|set| vec![set]);
        let (found, _) = fit(&sets).unwrap();
        let [low, high] = interval(&sets);
        assert!(found.log_std > 0.05 && low < 5.0 && high > 6.0, "{found:?}, {low} to {high}");
    }

    #[test]
    fn sets_that_meet_in_a_point_have_an_interval() {
        // with a small spread, only means near 5 are likely at all
        let sets = [[3.0, 5.0], [3.0, 5.0], [5.0, 8.0], [5.0, 8.0]].map(|set| vec![set]);
        let [low, high] = interval(&sets);
        assert!((2.0..5.0).contains(&low) && high > 5.0 && high < 12.0, "{low} to {high}");
    }

    #[test]
    fn spreads_have_no_cap() {
        let sets: Vec<Set> = [0.001, 0.5, 30.0, 9e4, 7e5].map(exactly).to_vec();
        let (found, _) = fit(&sets).unwrap();
        assert!(found.log_std > 8.0, "{found:?}");
    }

    #[test]
    fn golden_probabilities_agree_with_statrs() {
        let normal = Normal::new(0.0, 1.0).unwrap();
        for (a, b) in
            [(-1.0, 1.0), (0.3, 0.300_05), (-2.0, f64::INFINITY), (3.0, 9.0), (f64::NEG_INFINITY, -5.0)]
        {
            let expected = if a > 0.0 { normal.sf(a) - normal.sf(b) } else { normal.cdf(b) - normal.cdf(a) };
            assert!((between(a, b) / expected - 1.0).abs() < 1e-9, "{a}, {b}");
        }
    }
}
