//! Random and awkward options against the reference.

use super::*;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// Lengths and risks at which a quantity is 0, infinite, equal or turns around.
fn awkward() -> impl Strategy<Value = (f64, f64)> {
    let lengths = [0.0, 1e-300, 1e-9, 0.1, 0.5, 0.9999, 1.0, 1.0 + 1e-9, 1.5, 2.0, 10.0, 20.0, 20.000001];
    let risks = [0.0, 1e-12, 0.1, 0.10001, 0.3, 0.5, 0.9, 1.0 - 1e-12, 1.0];
    (prop::sample::select(lengths.to_vec()), prop::sample::select(risks.to_vec()))
}

/// Options on a noisy trade-off of length against risk: few are dominated, many can win.
fn trade_off(count: std::ops::RangeInclusive<usize>, scale: f64) -> impl Strategy<Value = Vec<Prospect>> {
    let option = (0.0..1.0, 0.0..0.02).prop_map(move |(u, noise)| (scale * (0.3 + u), 0.9 - 0.8 * u + noise));
    prop::collection::vec(option, count).prop_map(|pairs| options_of(&pairs))
}

fn config(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(1),
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(config(48))]

    #[test]
    fn property_random_options(pairs in prop::collection::vec((0.0..40.0, 0.0..=1.0), 1..=5)) {
        let (alpha, gamma) = paper_ranges();
        prop_assert!(error(&options_of(&pairs), alpha, gamma) < 1e-9);
    }

    #[test]
    fn property_nearly_there(pairs in prop::collection::vec((0.0..1.3, 0.0..=1.0), 2..=5)) {
        let (alpha, gamma) = paper_ranges();
        prop_assert!(error(&options_of(&pairs), alpha, gamma) < 1e-9);
    }

    #[test]
    fn property_nearly_there_trade_off(options in trade_off(2..=4, 0.7)) {
        let (alpha, gamma) = paper_ranges();
        prop_assert!(error(&options, alpha, gamma) < 1e-9);
    }

    #[test]
    fn property_trade_off(options in trade_off(2..=5, 25.0)) {
        let (alpha, gamma) = paper_ranges();
        prop_assert!(error(&options, alpha, gamma) < 1e-9);
    }

    #[test]
    fn property_awkward_options(pairs in prop::collection::vec(awkward(), 1..=5)) {
        let (alpha, gamma) = paper_ranges();
        prop_assert!(error(&options_of(&pairs), alpha, gamma) < 1e-9);
    }

    #[test]
    fn property_near_ties(
        pairs in prop::collection::vec((8.0..30.0, 0.2..0.9), 2..=3),
        longer in 0.0..2e-6,
        safer in 0.0..2e-7,
    ) {
        let mut options = options_of(&pairs);
        options.push(Prospect::new(pairs[0].0 + longer, pairs[0].1 - safer));
        let (alpha, gamma) = paper_ranges();
        prop_assert!(error(&options, alpha, gamma) < 1e-9);
    }

    #[test]
    fn property_near_ties_that_cross(
        length in 2.0..30.0f64,
        risk in 0.1..0.9f64,
        closeness in -5.9..-4.0f64,
        alpha in 0.55..0.95f64,
        gamma in 0.5..1.1f64,
        other in (8.0..30.0, 0.2..0.9),
    ) {
        // As much safer as makes up for being longer at this alpha and gamma.
        let longer = math::pow(10f64, closeness);
        let slope = (perceived_risk(risk + 1e-4, gamma) - perceived_risk(risk - 1e-4, gamma)) / 2e-4;
        let safer = longer * alpha * math::pow(length, alpha - 1.0) / (RISK_WEIGHT * slope);
        let options = options_of(&[(length, risk), (length + longer, risk - safer), other]);
        let (alpha, gamma) = paper_ranges();
        prop_assert!(error(&options, alpha, gamma) < 1e-9);
    }

    #[test]
    fn property_options_that_cross_twice(pairs in prop::collection::vec((0.12..0.45, -0.002..0.002), 2..=4)) {
        // Around a quarter of a metre the length gap turns in the middle of the range; the risks nearly match
        // it there.
        let options: Vec<_> = pairs.iter().map(|&(length, off)| Prospect::new(length, 0.5 - 0.104 * length + off)).collect();
        let (alpha, gamma) = paper_ranges();
        prop_assert!(error(&options, alpha, gamma) < 1e-9);
    }

    #[test]
    fn property_truncated_normals(options in trade_off(2..=4, 25.0), a in 0.01..0.3, b in 0.01..0.3, mean in 0.5..0.9) {
        let alpha = Marginal::truncated_normal(mean, a, 0.55, 0.95).unwrap();
        let gamma = Marginal::truncated_normal(0.8, b, 0.5, 1.1).unwrap();
        prop_assert!(error(&options, alpha, gamma) < 1e-9);
    }

    #[test]
    fn property_wide_ranges(options in trade_off(2..=4, 15.0)) {
        let (alpha, gamma) = (Marginal::uniform(0.1, 2.0).unwrap(), Marginal::uniform(0.1, 4.0).unwrap());
        prop_assert!(error(&options, alpha, gamma) < 1e-9);
    }

    #[test]
    fn property_order_does_not_matter(options in trade_off(2..=12, 25.0)) {
        let forward = predicted(&options, Belief::default());
        let reversed: Vec<_> = options.iter().rev().copied().collect();
        for (a, b) in forward.iter().zip(predicted(&reversed, Belief::default()).iter().rev()) {
            prop_assert!((a - b).abs() < 1e-12);
        }
    }

    #[test]
    fn property_any_floats_give_a_distribution(
        pairs in prop::collection::vec((prop::num::f64::ANY, prop::num::f64::ANY), 1..=6),
        weight in 0.0..1e300,
    ) {
        let (mut choice, mut costs) = (ChoiceDistribution::default(), Vec::new());
        let mut predictor = Predictor::new(Belief::default(), weight).unwrap();
        predictor.predict(&options_of(&pairs), &mut choice);
        predictor.expected_costs(&options_of(&pairs), &mut costs);
        prop_assert!((choice.probabilities().iter().sum::<f64>() - 1.0).abs() < 1e-12);
        prop_assert!(choice.probabilities().iter().all(|&p| p >= 0.0));
        prop_assert_eq!(choice.len(), pairs.len());
        prop_assert!(costs.iter().all(|cost| *cost >= 0.0));
    }
}

proptest! {
    #![proptest_config(config(6))]

    #[test]
    fn property_twelve_options(options in trade_off(6..=12, 25.0)) {
        let (alpha, gamma) = paper_ranges();
        prop_assert!(error(&options, alpha, gamma) < 1e-9);
    }

    #[test]
    fn property_option_that_barely_touches(options in trade_off(2..=3, 25.0), length in 10.0..30.0, off in -1e-5..1e-5) {
        let steps = |lower: f64, upper: f64, count: u32| {
            (0..=count).map(move |k| lower + (upper - lower) * f64::from(k) / f64::from(count))
        };
        let wins = |risk: f64| {
            steps(0.5, 1.1, 200).any(|gamma| steps(0.55, 0.95, 40).any(|alpha| {
                let cost = |option| subjective_cost(option, RISK_WEIGHT, Perception { alpha, gamma });
                options.iter().all(|&option| cost(Prospect::new(length, risk)) < cost(option))
            }))
        };
        // The risk up to which the option still wins somewhere, and a little off it.
        let (mut below, mut above) = (0.0f64, 1.0f64);
        for _ in 0..20 {
            let middle = 0.5 * (below + above);
            if wins(middle) { below = middle } else { above = middle }
        }
        let mut all = options.clone();
        all.push(Prospect::new(length, f64::clamp(below + off, 0.0, 1.0)));
        let (alpha, gamma) = paper_ranges();
        prop_assert!(error(&all, alpha, gamma) < 1e-9);
    }
}
