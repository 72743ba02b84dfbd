//! Closed forms, and issues that were.

use super::*;

#[test]
fn closed_form_reference_agrees_with_itself() {
    let (alpha, gamma) = paper_ranges();
    for pairs in [
        [(18.0658, 0.45596), (28.5424, 0.2021), (13.3412, 0.6894), (18.0649, 0.456)],
        [(0.3, 0.5), (0.7, 0.42), (0.9, 0.39), (2.5, 0.3)],
        [(0.1472298, 0.4864261), (0.4043068, 0.456244), (0.2, 0.48), (3.0, 0.4)],
        [(15.4348, 0.5423), (15.434801, 0.542299), (17.7575, 0.4069), (31.0082, 0.2019)],
    ] {
        let options = options_of(&pairs);
        let used = probabilities(&options, &alpha, &gamma, 256, 1e-13);
        let finer = probabilities(&options, &alpha, &gamma, 1024, 1e-14);
        assert!((used.iter().sum::<f64>() - 1.0).abs() < 1e-10);
        for (used, finer) in used.iter().zip(finer) {
            assert!((used - finer).abs() < 1e-10, "{options:?}: {used} and {finer}");
        }
    }
}

#[test]
fn closed_form_gamma_alone_decides_between_no_metre_and_one() {
    // Costs c_r S^(gamma) and 1: the first wins where (-ln S)^gamma > ln c_r.
    let risk = 0.0586f64;
    let turn = math::ln(math::ln(RISK_WEIGHT)) / math::ln(-math::ln(risk));
    let found = predicted(&options_of(&[(0.0, risk), (1.0, 0.0)]), Belief::default());
    assert!((found[0] - (1.1 - turn) / 0.6).abs() < 1e-10, "{found:?}");
}

#[test]
fn closed_form_alpha_alone_decides_between_certainties() {
    // Costs c_r and D^alpha.
    let turn = math::ln(RISK_WEIGHT) / math::ln(25f64);
    let found = predicted(&options_of(&[(0.0, 1.0), (25.0, 0.0)]), Belief::default());
    assert!((found[1] - (turn - 0.55) / 0.4).abs() < 1e-12, "{found:?}");
}

#[test]
fn closed_form_trivial_cases() {
    assert!(predicted(&[], Belief::default()).is_empty());
    assert_eq!(predicted(&options_of(&[(3.0, 0.2)]), Belief::default()), [1.0]);
    let same = (10.0, 0.4);
    assert_eq!(predicted(&options_of(&[(11.0, 0.4), same, same]), Belief::default()), [0.0, 0.5, 0.5]);
    let mut choice = ChoiceDistribution::default();
    let mut careless = Predictor::new(Belief::default(), 0.0).unwrap();
    careless.predict(&options_of(&[(2.0, 0.0), (0.5, 0.9), (0.5, 0.8)]), &mut choice);
    assert_eq!(choice.probabilities(), [0.0, 0.5, 0.5]);
    assert!(Predictor::new(Belief::default(), -1.0).is_err());
    assert!(Predictor::new(Belief::default(), f64::NAN).is_err());
}

/// Probabilities on a grid of midpoints: the options whose cost by eq. (2) is the least there, but for
/// rounding, share it.
fn on_a_grid(options: &[Prospect]) -> Vec<f64> {
    let points = 500;
    let mut shares = vec![0.0; options.len()];
    for i in 0..points * points {
        let part = |k: usize| (k as f64 + 0.5) / points as f64;
        let (alpha, gamma) = (0.55 + 0.4 * part(i % points), 0.5 + 0.6 * part(i / points));
        let cost = |option: &Prospect| subjective_cost(*option, RISK_WEIGHT, Perception { alpha, gamma });
        let least = options.iter().map(cost).fold(f64::INFINITY, f64::min);
        let winners: Vec<_> = (0..options.len()).filter(|&o| cost(&options[o]) < least + 1e-7).collect();
        winners.iter().for_each(|&o| shares[o] += 1.0 / (winners.len() * points * points) as f64);
    }
    shares
}

#[test]
fn issue_in_a_room_with_two_equal_ways_the_first_had_the_whole_probability() {
    let left = (4.92, 0.29);
    // the mirrored way, as geometry finds it
    for off in [0.0, 2e-15, -2e-15, 2e-7, -2e-7] {
        let right = (4.92 + off, 0.29 * (1.0 - 0.01 * off));
        assert_eq!(predicted(&options_of(&[left, right]), Belief::default()), [0.5, 0.5], "{off}");
    }
    // a tenth of a millimetre is a reason
    assert_eq!(predicted(&options_of(&[left, (4.9201, 0.29)]), Belief::default()), [1.0, 0.0]);
    let several =
        options_of(&[(17.4, 0.36), (14.3, 0.55), (17.4, 0.36), (21.4, 0.25), (14.3, 0.55), (17.4, 0.36)]);
    let exact = predicted(&several, Belief::default());
    for (exact, wanted) in exact.iter().zip(on_a_grid(&several)) {
        assert!((exact - wanted).abs() < 1e-3, "{exact} {wanted}");
    }
    assert!(exact[0] == exact[2] && exact[2] == exact[5] && exact[1] == exact[4], "{exact:?}");
}

#[test]
fn closed_form_ways_that_have_become_one_are_one_of_the_tied_choices() {
    // options 1 and 3 lead the same way; 0 is another way of the same length and risk
    let options = options_of(&[(5.0, 0.3), (5.0, 0.3), (9.0, 0.3), (5.0, 0.3)]);
    let (mut ways, mut choice) = (Ways::default(), ChoiceDistribution::default());
    let mut predictor = Predictor::default();
    for (current, wanted) in
        [(None, [0.5, 0.5, 0.0, 0.0]), (Some(3), [0.5, 0.0, 0.0, 0.5]), (Some(0), [0.5, 0.5, 0.0, 0.0])]
    {
        ways.find(4, current, |a, b| (a, b) == (1, 3));
        predictor.predict_from(&options, &ways, &mut choice);
        assert_eq!(choice.probabilities(), wanted, "{current:?}");
    }
    // ways of other options than these change nothing
    ways.find(4, None, |_, _| true);
    predictor.predict_from(&options_of(&[(5.0, 0.3), (6.0, 0.1)]), &ways, &mut choice);
    assert_eq!(choice.probabilities(), predicted(&options_of(&[(5.0, 0.3), (6.0, 0.1)]), Belief::default()));
}

#[test]
fn closed_form_with_lapses_any_option_is_taken() {
    let options = options_of(&[(17.4, 0.36), (14.3, 0.55), (21.4, 0.25), (90.0, 0.9)]);
    let plain = predicted(&options, Belief::default());
    let (mut predictor, mut choice) = (Predictor::default(), ChoiceDistribution::default());
    for lapse_rate in [0.0, 0.02, 0.5] {
        predictor.set_lapse_rate(lapse_rate).unwrap();
        predictor.predict(&options, &mut choice);
        for (found, plain) in choice.probabilities().iter().zip(&plain) {
            assert_eq!(*found, (1.0 - lapse_rate) * plain + lapse_rate / 4.0);
        }
        assert!((choice.probabilities().iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }
    predictor.predict(&[], &mut choice);
    assert!(choice.is_empty());
    for bad in [-0.1, 0.51, f64::NAN] {
        let error = predictor.set_lapse_rate(bad).unwrap_err().to_string();
        assert!(error.contains("lapse rate") && error.contains("from 0 to 0.5"), "{error}");
    }
}

#[test]
fn closed_form_samples_are_counted() {
    let options = options_of(&[(17.4006, 0.3626), (14.3308, 0.5474), (21.3552, 0.2474)]);
    let mut samples = Vec::new();
    for i in 0..150 {
        for j in 0..150 {
            let alpha = 0.55 + 0.4 * (f64::from(i) + 0.5) / 150.0;
            let gamma = 0.5 + 0.6 * (f64::from(j) + 0.5) / 150.0;
            samples.push(WeightedSample { perception: Perception { alpha, gamma }, weight: 3.0 });
        }
    }
    let sampled = Belief::samples(samples).unwrap();
    let exact = predicted(&options, Belief::default());
    for (found, exact) in predicted(&options, sampled.clone()).iter().zip(exact) {
        assert!((found - exact).abs() < 1e-3, "{found} and {exact}");
    }
    let (mut from_samples, mut from_ranges) = (Vec::new(), Vec::new());
    Predictor::new(sampled, RISK_WEIGHT).unwrap().expected_costs(&options, &mut from_samples);
    Predictor::new(Belief::default(), RISK_WEIGHT).unwrap().expected_costs(&options, &mut from_ranges);
    for (found, exact) in from_samples.iter().zip(from_ranges) {
        assert!((found - exact).abs() < 1e-3, "{found} and {exact}");
    }
}

#[test]
fn closed_form_a_used_predictor_gives_the_bits_of_a_new_one() {
    // A walk toward the target, so that every call differs slightly from the previous one, and another set of
    // options in between.
    let other = options_of(&[(0.4, 0.6), (0.9, 0.5), (0.5, 0.55), (3.0, 0.1), (31.0, 0.0)]);
    let mut used = Predictor::new(Belief::default(), RISK_WEIGHT).unwrap();
    let mut choice = ChoiceDistribution::default();
    for step in 0..120 {
        let walked = 0.1 * f64::from(step);
        let options =
            options_of(&[(17.4006 - walked, 0.3626), (14.3308 - walked, 0.5474), (21.3552 - walked, 0.2474)]);
        used.predict(&options, &mut choice);
        assert_eq!(choice.probabilities(), predicted(&options, Belief::default()));
        if step % 10 == 0 {
            used.predict(&other, &mut choice);
            assert_eq!(choice.probabilities(), predicted(&other, Belief::default()));
        }
    }
}

#[test]
fn issue_touch_between_end_and_first_node_was_missed() {
    // The second option wins on 3e-8 of the range only, around gamma = 0.512, next to its lower end.
    let (alpha, gamma) = paper_ranges();
    let pairs = [(11.46225353379041, 0.9729145490859513), (22.794765248922726, 0.8534584620330853)];
    assert!(error(&options_of(&pairs), alpha, gamma) < 1e-9);
}

#[test]
fn issue_event_found_across_another_one_was_believed() {
    // Assuming the first change of sign to be the only event cost accuracy or hundreds of nodes here.
    let pairs = [
        (24.66036713517763, 0.5417497202441988),
        (11.432153350600233, 0.8094370988258288),
        (12.675196972644013, 0.8508608580591442),
        (20.214207106267956, 0.6217578555626991),
    ];
    let (mut predictor, mut choice) = (Predictor::default(), ChoiceDistribution::default());
    predictor.predict(&options_of(&pairs), &mut choice);
    assert!(predictor.nodes_evaluated() < 100, "{} nodes", predictor.nodes_evaluated());
    let (alpha, gamma) = paper_ranges();
    assert!(error(&options_of(&pairs), alpha, gamma) < 1e-9);
}

#[test]
fn issue_density_of_gamma_was_not_integrated_exactly_under_a_constant_winner() {
    // The rule alone was 2e-9 off on a bell curve of six deviations, and no breakpoint showed the error.
    let alpha = Marginal::truncated_normal(0.75, 0.06633881619431867, 0.55, 0.95).unwrap();
    let gamma = Marginal::truncated_normal(0.8, 0.10148977757982867, 0.5, 1.1).unwrap();
    assert!(
        error(
            &options_of(&[(17.28920826675762, 0.1725286036739735), (3.730772506952258, 0.8972220009505301)]),
            alpha,
            gamma
        ) < 1e-10
    );
}

#[test]
fn closed_form_strips_are_halved_until_the_rule_is_good() {
    let (alpha, gamma) = (Marginal::uniform(0.05, 3.0).unwrap(), Marginal::uniform(0.02, 6.0).unwrap());
    for pairs in [[(1.5, 0.9), (6.0, 0.05)], [(1.05, 0.6), (2.0, 0.2)], [(0.2, 0.505), (0.35, 0.49)]] {
        assert!(error(&options_of(&pairs), alpha, gamma) < 1e-9, "{pairs:?}");
    }
}
