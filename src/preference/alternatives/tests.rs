use super::*;
use crate::preference::{Belief, ChoiceDistribution, Perception, Predictor, WeightedSample};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed};

/// The paper's environments, rounded to four digits.
const ENVIRONMENTS: [[(f64, f64); 4]; 4] = [
    [(41.8638, 0.6598), (17.4006, 0.3626), (14.3308, 0.5474), (21.3552, 0.2474)],
    [(12.7239, 0.9737), (14.2601, 0.9332), (23.0, 0.9131), (19.3294, 0.7824)],
    [(31.0082, 0.2019), (15.4348, 0.5423), (17.7575, 0.4069), (36.1109, 0.6077)],
    [(18.0658, 0.456), (28.5424, 0.2021), (13.3412, 0.6894), (18.0649, 0.456)],
];

fn environments() -> Vec<Vec<Prospect>> {
    let options =
        |options: &[(f64, f64); 4]| options.map(|(length, risk)| Prospect::new(length, risk)).to_vec();
    ENVIRONMENTS.iter().map(options).collect()
}

fn paper() -> StevensPrelec {
    StevensPrelec::new(Belief::default())
}

/// P_o by brute force: a grid of midpoints.
fn slow(
    perception: &dyn RiskPerception,
    prospects: &[Prospect],
    risk_weight: f64,
    points: usize,
) -> Vec<f64> {
    let middle = |i: usize| (i as f64 + 0.5) / points as f64;
    let seconds = if perception.parameters().len() > 1 { points } else { 1 };
    let mut sum = vec![0.0; prospects.len()];
    for i in 0..points {
        for j in 0..seconds {
            let quantiles = [middle(i), middle(j)];
            let [chosen] = choices(perception, &[prospects], risk_weight, &quantiles)[..] else {
                panic!("one situation has one choice")
            };
            sum[chosen] += 1.0 / (points * seconds) as f64;
        }
    }
    sum
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn closed_form_without_distortion_every_cost_is_the_expected_one() {
    let prospect = Prospect::new(14.33, 0.5474);
    let expected = 14.33 + 5.474;
    for (perception, neutral) in ALTERNATIVES.into_iter().zip([&[1.0, 1.0][..], &[1.0], &[]]) {
        let cost = perception.perceived_cost(prospect, 10.0, neutral);
        assert!((cost - expected).abs() < 1e-12, "{}: {cost}", perception.name());
    }
    assert!((paper().perceived_cost(prospect, 10.0, &[1.0, 1.0]) - expected).abs() < 1e-12);
}

#[test]
fn closed_form_two_options_by_conditional_value_at_risk() {
    // 10 + 10 min(1, 0.2 / t) < 12 + 10 min(1, 0.1 / t): where both rise, 2 / t < 2 + 1 / t, so t > 1 / 2;
    // for t from 0.2 down to 0.1 / 0.8 the first one stays at 20 and the second one rises to 20: the first
    // one is cheaper below
    let options = [Prospect::new(10.0, 0.2), Prospect::new(12.0, 0.1)];
    let shares = CONDITIONAL_VALUE_AT_RISK.probabilities(&options, 10.0);
    assert!((shares[0] - (0.5 + 0.125)).abs() < 1e-12, "{shares:?}");
    assert!((shares[1] - (0.5 - 0.125)).abs() < 1e-12, "{shares:?}");
}

#[test]
fn closed_form_ties_share_and_unreachable_options_have_nobody() {
    let option = Prospect::new(10.0, 0.4);
    let options = [option, Prospect::new(f64::INFINITY, 0.0), option, Prospect::new(20.0, 0.9)];
    for perception in ALTERNATIVES {
        assert_eq!(perception.probabilities(&options, 10.0), [0.5, 0.0, 0.5, 0.0], "{}", perception.name());
        assert!(perception.probabilities(&[], 10.0).is_empty());
    }
}

#[test]
fn groups_of_all_environments_are_those_of_each() {
    let all = environments();
    let situations: Vec<&[Prospect]> = all.iter().map(Vec::as_slice).collect();
    let paper = paper();
    for perception in ALTERNATIVES.into_iter().chain([&paper as &dyn RiskPerception]) {
        let groups = perception.groups(&situations, 10.0);
        assert!((groups.iter().map(|group| group.share).sum::<f64>() - 1.0).abs() < 1e-12);
        for (s, prospects) in situations.iter().enumerate() {
            let alone = perception.probabilities(prospects, 10.0);
            let of = |o: usize| groups.iter().map(|group| group.share * group.preferred[s][o]).sum::<f64>();
            let together: Vec<f64> = (0..prospects.len()).map(of).collect();
            assert!(largest_difference(&alone, &together) < 1e-6, "{} {s}", perception.name());
        }
    }
}

#[test]
fn the_papers_groups_are_near_its_exact_probabilities() {
    let mut predictor = Predictor::new(Belief::default(), 10.0).unwrap();
    let mut choice = ChoiceDistribution::default();
    for prospects in environments() {
        predictor.predict(&prospects, &mut choice);
        let difference = largest_difference(&paper().probabilities(&prospects, 10.0), choice.probabilities());
        assert!(difference < 1e-3, "{difference}");
    }
    // a belief of samples is exact
    let sample = |alpha, gamma, weight| WeightedSample { perception: Perception { alpha, gamma }, weight };
    let belief =
        Belief::samples(vec![sample(0.6, 0.7, 1.0), sample(0.9, 0.6, 2.0), sample(0.7, 1.1, 4.0)]).unwrap();
    let mut predictor = Predictor::new(belief.clone(), 10.0).unwrap();
    for prospects in environments() {
        predictor.predict(&prospects, &mut choice);
        let found = StevensPrelec::new(belief.clone()).probabilities(&prospects, 10.0);
        assert!(largest_difference(&found, choice.probabilities()) < 1e-12);
    }
}

#[test]
fn cumulative_prospects_groups_are_those_of_a_fine_grid_and_of_many_rows() {
    let mut split = 0;
    for (prospects, risk_weight) in
        environments().into_iter().flat_map(|prospects| [20.0, 40.0, 80.0].map(|c| (prospects.clone(), c)))
    {
        let found = CUMULATIVE_PROSPECT.probabilities(&prospects, risk_weight);
        split += usize::from(found.iter().filter(|share| **share > 0.05).count() > 1);
        // a grid misses each boundary by half a point
        let fine = slow(&CUMULATIVE_PROSPECT, &prospects, risk_weight, 300);
        assert!(largest_difference(&found, &fine) < 4e-3, "{found:?} {fine:?}");
        let groups = groups_in_rows(&CUMULATIVE_PROSPECT, &[&prospects], risk_weight, 32 * ROWS);
        let of = |o: usize| groups.iter().map(|group| group.share * group.preferred[0][o]).sum::<f64>();
        let exact: Vec<f64> = (0..prospects.len()).map(of).collect();
        let difference = largest_difference(&found, &exact);
        assert!(difference < 5e-4, "{difference}");
    }
    // people do differ
    assert!(split >= 9, "{split}");
}

proptest! {
    #![proptest_config(Config { cases: 24, rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Config::default() })]

    #[test]
    fn probabilities_are_those_of_a_fine_grid(
        options in prop::collection::vec((5.0..40.0, 0.0..1.0), 1..6),
        risk_weight in 1.0..40.0,
    ) {
        let options: Vec<Prospect> = options.into_iter().map(|(length, risk)| Prospect::new(length, risk)).collect();
        // a grid misses each end of an interval by half a point
        let fine = slow(&CONDITIONAL_VALUE_AT_RISK, &options, risk_weight, 20_000);
        let found = CONDITIONAL_VALUE_AT_RISK.probabilities(&options, risk_weight);
        prop_assert!(largest_difference(&found, &fine) < 3e-4, "{found:?} {fine:?}");
        let fine = slow(&CUMULATIVE_PROSPECT, &options, risk_weight, 300);
        let found = CUMULATIVE_PROSPECT.probabilities(&options, risk_weight);
        prop_assert!(largest_difference(&found, &fine) < 4e-3, "{found:?} {fine:?}");
    }
}
