//! Figures of the belief against closed forms: samples, ties, steps, what is restored.

use super::*;
use crate::preference::WeightedSample;

#[test]
fn closed_form_the_figures_of_weighted_samples() {
    // each prefers another option: the short one with its risk, or the long one
    let samples = [(0.55, 1.1, 1.0), (0.56, 1.0, 2.0), (0.95, 0.5, 3.0), (0.94, 0.6, 2.0)];
    let weighted = samples
        .map(|(alpha, gamma, weight)| WeightedSample { perception: Perception { alpha, gamma }, weight });
    let mut posterior = Posterior::new(Belief::samples(weighted.to_vec()).unwrap(), RISK_WEIGHT).unwrap();
    let prospects = [Prospect::new(41.9, 0.2), Prospect::new(14.3, 0.6)];
    posterior.mix_with_prior(0.25).unwrap();
    let evidence = posterior.observe(&prospects, &Ways::default(), &[0.98, 0.02]).unwrap();
    assert!((evidence - (0.98 * 3.0 + 0.02 * 5.0) / 8.0).abs() < 1e-15);
    // the samples that prefer the first option have 97 % now, and had three of eight parts
    assert!((posterior.estimate().region_share - 0.375).abs() < 1e-15);
    assert!((posterior.estimate().region_density - 0.98 / evidence).abs() < 1e-12);
    posterior.mix_with_prior(0.25).unwrap();
    let mixed: Vec<f64> = samples
        .iter()
        .zip([0.98, 0.98, 0.02, 0.02])
        .map(|((.., prior), seen)| (0.75 * seen / evidence + 0.25) * prior / 8.0)
        .collect();
    let mean = |value: &dyn Fn((f64, f64, f64)) -> f64| -> f64 {
        samples.iter().zip(&mixed).map(|(sample, weight)| weight * value(*sample)).sum()
    };
    let [alpha, gamma] = [mean(&|s| s.0), mean(&|s| s.1)];
    let estimate = posterior.estimate();
    let wanted = [
        (estimate.mean[0], alpha),
        (estimate.mean[1], gamma),
        (estimate.covariance[0], mean(&|s| (s.0 - alpha) * (s.0 - alpha))),
        (estimate.covariance[1], mean(&|s| (s.0 - alpha) * (s.1 - gamma))),
        (estimate.covariance[2], mean(&|s| (s.1 - gamma) * (s.1 - gamma))),
        // the samples of the first option have 82 %, so the region has all
        (estimate.region_density, mixed[2] / 0.375),
        (estimate.information, (0..4).map(|i| mixed[i] * math_ln(mixed[i] / samples[i].2 * 8.0)).sum()),
        (posterior.density(Perception { alpha: 0.57, gamma: 1.0 }), mixed[1] / 0.25),
        (posterior.marginals(Perception { alpha: 0.56, gamma: 0.5 })[0], mixed[0] + mixed[1]),
        (posterior.marginals(Perception { alpha: 0.56, gamma: 0.5 })[1], mixed[2]),
        (posterior.credibility(mixed[1] / 0.25)[1], mixed[0] + mixed[1]),
        (posterior.credibility(mixed[1] / 0.25)[0], 0.0),
    ];
    for (i, (found, wanted)) in wanted.into_iter().enumerate() {
        assert!((found - wanted).abs() < 1e-12, "figure {i}: {found} and {wanted}");
    }
    assert!((estimate.region_share - 1.0).abs() < 1e-12);
    assert_eq!([estimate.alpha, estimate.gamma], [[0.55, 0.95], [0.5, 1.1]]);
    let mut costs = Vec::new();
    posterior.expected_costs(&prospects, &mut costs);
    for (found, prospect) in costs.iter().zip(prospects) {
        let of = |(alpha, gamma, _)| subjective_cost(prospect, RISK_WEIGHT, Perception { alpha, gamma });
        assert!((found - mean(&of)).abs() < 1e-12, "{found}");
    }
    // another number of samples is another prior
    let fewer = Posterior::new(Belief::samples(weighted[..3].to_vec()).unwrap(), RISK_WEIGHT).unwrap();
    assert!(!posterior.restore(&fewer.learned()));
    assert!(posterior.observe(&prospects, &Ways::default(), &[0.0, 0.0]).is_err());
}

#[test]
fn closed_form_tied_ways_share_their_probability_and_what_is_seen_says_half_as_much() {
    let prospects = [Prospect::new(17.4, 0.36), Prospect::new(17.4, 0.36), Prospect::new(14.3, 0.55)];
    let samples = [(0.6, 0.7), (0.7, 0.8)]
        .map(|(alpha, gamma)| WeightedSample { perception: Perception { alpha, gamma }, weight: 1.0 });
    let mut ways = Ways::default();
    ways.find(3, Some(1), |a, b| (a, b) == (0, 1));
    for belief in [Belief::default(), Belief::samples(samples.to_vec()).unwrap()] {
        let mut posterior = Posterior::new(belief.clone(), RISK_WEIGHT).unwrap();
        let mut choice = ChoiceDistribution::default();
        // one way: option 1 stands for both, whatever was asked before
        posterior.predict_from(&prospects, &Ways::default(), &mut choice);
        let [first, second, _] = choice.probabilities() else { panic!("three options") };
        assert!(first == second && *first > 0.05, "{choice:?}");
        let whole = first + second;
        posterior.predict_from(&prospects, &ways, &mut choice);
        assert_eq!(choice.probabilities()[0], 0.0);
        assert!((choice.probabilities()[1] - whole).abs() < 1e-12, "{choice:?}");
        let likelihoods = [0.2, 0.8, 0.2];
        // the probability of what is seen is the sum of P_o times its likelihood
        for (ways, share) in [(Ways::default(), whole / 2.0), (ways.clone(), whole)] {
            let mut posterior = Posterior::new(belief.clone(), RISK_WEIGHT).unwrap();
            let evidence = posterior.observe(&prospects, &ways, &likelihoods).unwrap();
            assert!((evidence - (0.2 + 0.6 * share)).abs() < 1e-9, "{ways:?}: {evidence} {share}");
        }
    }
}

#[test]
fn an_option_that_everybody_prefers_says_nothing() {
    let mut posterior = Posterior::new(Belief::default(), RISK_WEIGHT).unwrap();
    let prospects = [Prospect::new(30.0, 0.6), Prospect::new(14.3, 0.2)];
    assert_eq!(posterior.observe(&prospects, &Ways::default(), &[0.9, 0.3]).unwrap(), 0.3);
    assert!(posterior.observe(&prospects, &Ways::default(), &[0.9, 0.0]).is_err());
    let mut choice = ChoiceDistribution::default();
    posterior.predict_from(&prospects, &Ways::default(), &mut choice);
    assert_eq!(choice.probabilities(), [0.0, 1.0]);
    assert_eq!(posterior.estimate().information, 0.0);
    // powers of these lengths overflow
    let endless = [Prospect::new(f64::MAX, 0.5), Prospect::new(f64::MAX, 0.3), Prospect::new(f64::MAX, 0.1)];
    let wide = Belief::uniform((1.2, 1.4), (0.5, 1.1)).unwrap();
    Posterior::new(wide, RISK_WEIGHT).unwrap().predict_from(&endless, &Ways::default(), &mut choice);
    assert!((choice.probabilities().iter().sum::<f64>() - 1.0).abs() < 1e-12, "{:?}", choice.probabilities());
}

#[test]
fn every_change_of_the_belief_is_in_its_next_estimate() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let seen = seen(&mut rng, 3, of_human(Perception { alpha: 0.6, gamma: 1.0 }));
    let mut posterior = Posterior::new(Belief::default(), RISK_WEIGHT).unwrap();
    let prior = posterior.learned();
    for Seen { prospects, likelihoods } in &seen {
        posterior.observe(prospects, &Ways::default(), likelihoods).unwrap();
        let observed = posterior.estimate();
        let fresh = |learned: &Learned| {
            let mut other = Posterior::new(Belief::default(), RISK_WEIGHT).unwrap();
            assert!(other.restore(learned));
            other.estimate()
        };
        assert_eq!(observed, fresh(&posterior.learned()));
        posterior.mix_with_prior(0.1).unwrap();
        assert_eq!(posterior.estimate(), fresh(&posterior.learned()));
        assert_ne!(posterior.estimate(), observed);
    }
    assert!(posterior.restore(&prior));
    assert_eq!(posterior.estimate().information, 0.0);
    assert!((posterior.estimate().mean[0] - 0.75).abs() < 1e-12);
}

#[test]
fn the_density_at_a_place_is_the_sum_of_the_steps_before_it() {
    let mut rng = ChaCha8Rng::seed_from_u64(10);
    let seen = seen(&mut rng, 6, of_human(Perception { alpha: 0.7, gamma: 0.8 }));
    let (posterior, _) = learned(&Belief::default(), &seen, 0.01);
    for gamma in [0.5, 0.63, 0.8, 1.1] {
        let steps = posterior.steps_at(gamma);
        assert!(steps.len() > 3 && steps.windows(2).all(|pair| pair[0].0 <= pair[1].0), "{steps:?}");
        assert_eq!(steps[0].0, 0.55);
        for alpha in [0.55, 0.6, 0.731, 0.95] {
            let sum: f64 = steps.iter().filter(|(at, _)| *at <= alpha).map(|(_, step)| step).sum();
            let density = posterior.density(Perception { alpha, gamma });
            assert!(density > 0.0 && (density - sum).abs() < 1e-12, "{alpha} {gamma}: {density} {sum}");
        }
    }
    for (alpha, gamma) in [(0.54, 0.8), (0.96, 0.8), (0.7, 0.49), (0.7, 1.11)] {
        assert_eq!(posterior.density(Perception { alpha, gamma }), 0.0, "{alpha} {gamma}");
    }
}

#[test]
fn a_belief_with_a_step_on_a_line_that_is_not_there_is_not_restored() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let seen = seen(&mut rng, 2, of_human(Perception { alpha: 0.7, gamma: 0.8 }));
    let (mut posterior, _) = learned(&Belief::default(), &seen, 0.01);
    let before = posterior.learned();
    let Learned(Contents::Plane { lines, segments }) = &before else { panic!("a plane") };
    for fault in 0..3 {
        let mut segments = segments.clone();
        let last = segments.last_mut().unwrap();
        match fault {
            0 => last.line = lines.len() as u32,
            1 => last.step = f64::NAN,
            _ => last.to = f64::INFINITY,
        }
        assert!(!posterior.restore(&Learned(Contents::Plane { lines: lines.clone(), segments })), "{fault}");
        assert_eq!(posterior.learned(), before);
    }
}

#[test]
fn lines_without_a_step_are_not_kept() {
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    let mut posterior = Posterior::new(Belief::default(), RISK_WEIGHT).unwrap();
    let human = of_human(Perception { alpha: 0.7, gamma: 0.8 });
    for _ in 0..12 {
        let prospects = options(&mut rng);
        let chosen = human(&prospects, &mut rng);
        let likelihoods: Vec<f64> = (0..4).map(|option| f64::from(u8::from(option == chosen))).collect();
        posterior.observe(&prospects, &Ways::default(), &likelihoods).unwrap();
        let Learned(Contents::Plane { lines, segments }) = posterior.learned() else { panic!("a plane") };
        let has_step = |line: usize| segments.iter().any(|segment| segment.line as usize == line);
        assert!((0..lines.len()).all(has_step), "{} lines, {} steps", lines.len(), segments.len());
    }
}
