//! The minimum of a function of one positive number: a scan for the valley, then golden-section search.

use cocarry::math;

/// Number of values that a scan tries.
pub(super) const SCANNED: usize = 401;

/// Values from `lower` to `upper` in equal ratios.
pub(super) fn scanned([lower, upper]: [f64; 2]) -> Vec<f64> {
    let ratio = math::ln(upper / lower) / (SCANNED - 1) as f64;
    (0..SCANNED).map(|i| if i + 1 == SCANNED { upper } else { lower * math::exp(ratio * i as f64) }).collect()
}

/// Index of the least value; the first of several.
pub(super) fn least(values: &[f64]) -> usize {
    (0..values.len()).fold(0, |best, i| if values[i] < values[best] { i } else { best })
}

/// Indices of valleys: no neighbour is lower, and where several in a row are equal, the first.
pub(super) fn valleys(values: &[f64]) -> Vec<usize> {
    let falls_to = |i: usize| i == 0 || values[i] < values[i - 1];
    let rises_after = |i: usize| values[i..].iter().find(|v| **v != values[i]).is_none_or(|v| *v > values[i]);
    (0..values.len()).filter(|&i| falls_to(i) && rises_after(i)).collect()
}

/// The least and the largest number at which `value` is at most `limit`, between the first and the last of
/// those scanned and their neighbours beyond; `None` if fewer than two of those scanned are that low.
/// `values` are those at the numbers scanned.
pub(super) fn level(
    scanned: &[f64],
    values: &[f64],
    limit: f64,
    mut value: impl FnMut(f64) -> f64,
) -> Option<[f64; 2]> {
    let is_low = |v: &f64| *v <= limit;
    let [first, last] = [values.iter().position(is_low)?, values.iter().rposition(is_low)?];
    // the last low number on the way from `low` to `high`
    let mut end = |low: f64, high: f64| {
        let [mut low, mut high] = [low, high].map(math::ln);
        while (high - low).abs() > 1e-6 {
            let middle = (low + high) / 2.0;
            if value(math::exp(middle)) <= limit { low = middle } else { high = middle }
        }
        math::exp(low)
    };
    let ends = [
        if first == 0 { scanned[first] } else { end(scanned[first], scanned[first - 1]) },
        if last + 1 == scanned.len() { scanned[last] } else { end(scanned[last], scanned[last + 1]) },
    ];
    (first < last).then_some(ends)
}

/// The value between the neighbours of the number at `index` at which `value` is least, to a millionth.
pub(super) fn refined(scanned: &[f64], index: usize, mut value: impl FnMut(f64) -> f64) -> f64 {
    let ends = [index.saturating_sub(1), (index + 1).min(scanned.len() - 1)].map(|i| math::ln(scanned[i]));
    let found = math::exp(golden(ends, 1e-6, |x| value(math::exp(x))));
    // where the function has kinks, the scan may have found a lower value than the search
    if value(found) <= value(scanned[index]) { found } else { scanned[index] }
}

/// The number between two ends at which `value`, which has one valley there, is least, to `tolerance`, by
/// golden-section search.
pub(super) fn golden(
    [mut low, mut high]: [f64; 2],
    tolerance: f64,
    mut value: impl FnMut(f64) -> f64,
) -> f64 {
    const SECTION: f64 = 0.618_033_988_749_894_9;
    let mut at = [high - SECTION * (high - low), low + SECTION * (high - low)];
    let mut values = at.map(&mut value);
    while high - low > tolerance {
        if values[0] <= values[1] {
            high = at[1];
            at = [high - SECTION * (high - low), at[0]];
            values = [value(at[0]), values[0]];
        } else {
            low = at[0];
            at = [at[1], low + SECTION * (high - low)];
            values = [values[1], value(at[1])];
        }
    }
    (low + high) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_the_deeper_of_two_valleys_is_found() {
        let value = |x: f64| (math::squared(math::ln(x) - 1.0) + 0.1).min((math::ln(x) - 3.0).abs());
        let numbers = scanned([0.1, 1000.0]);
        let values: Vec<f64> = numbers.iter().map(|x| value(*x)).collect();
        let found = refined(&numbers, least(&values), value);
        assert!((math::ln(found) - 3.0).abs() < 1e-6, "{found}");
        assert_eq!(valleys(&values).len(), 2);
    }

    #[test]
    fn closed_form_a_level_has_its_ends() {
        let numbers = scanned([0.1, 1000.0]);
        let ends = |value: fn(f64) -> f64| {
            let values: Vec<f64> = numbers.iter().map(|x| value(*x)).collect();
            level(&numbers, &values, 1e-9, value)
        };
        let [low, high] = ends(|x| (6.08 - x).max(0.0)).unwrap();
        assert!((low - 6.08).abs() < 1e-5 && high == 1000.0, "{low} to {high}");
        let [low, high] = ends(|x| (x - 20.0).max(0.0)).unwrap();
        assert!(low == 0.1 && (high - 20.0).abs() < 1e-4, "{low} to {high}");
        assert_eq!(ends(|x| math::squared(x - 5.0)), None);
    }

    #[test]
    fn closed_form_a_plain_is_one_valley() {
        assert_eq!(valleys(&[3.0, 1.0, 1.0, 1.0, 2.0]), [1]);
        assert_eq!(valleys(&[1.0, 1.0]), [0]);
        assert_eq!(valleys(&[3.0, 1.0, 1.0, 0.5]), [3]);
    }
}
