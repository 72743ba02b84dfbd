//! The belief against a fine grid of rows, closed forms and itself.

mod closed_forms;

use super::*;
use crate::preference::Marginal;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const RISK_WEIGHT: f64 = 10.0;

/// The observation at one place.
struct Seen {
    prospects: Vec<Prospect>,
    likelihoods: Vec<f64>,
}

/// The belief the slow way: rows of constant gamma, on each the parts of alpha between all changes of the
/// preferred option, found by bisection of eq. (3).
struct Grid {
    alpha: Marginal,
    /// gamma, from and to in alpha, prior probability, density.
    parts: Vec<(f64, f64, f64, f64, f64)>,
    evidence: Vec<f64>,
}

const COLUMNS: usize = 60;

fn changes(prospects: &[Prospect], gamma: f64, [low, high]: [f64; 2], cuts: &mut Vec<f64>) {
    let chosen = |alpha: f64| human_choice(prospects, RISK_WEIGHT, Perception { alpha, gamma }, None);
    let at = |i: usize| low + (high - low) * i as f64 / COLUMNS as f64;
    let mut open: Vec<_> =
        (0..COLUMNS).map(|i| (at(i), chosen(at(i)), at(i + 1), chosen(at(i + 1)))).collect();
    while let Some((from, left, to, right)) = open.pop() {
        if left != right && to - from < 1e-12 {
            cuts.push(to);
        } else if left != right {
            let middle = 0.5 * (from + to);
            let between = chosen(middle);
            open.extend([(from, left, middle, between), (middle, between, to, right)]);
        }
    }
}

impl Grid {
    fn new(belief: &Belief, seen: &[Seen], asked: &[Prospect], rate: f64, rows: usize) -> Self {
        let Belief::Independent { alpha, gamma } = belief else { panic!("independent") };
        let mut grid = Self { alpha: *alpha, parts: Vec::new(), evidence: Vec::new() };
        for row in 0..rows {
            let step = (gamma.upper() - gamma.lower()) / rows as f64;
            let at = gamma.lower() + step * (row as f64 + 0.5);
            let range = [alpha.lower(), alpha.upper()];
            // within a part the prior is nearly constant
            let mut cuts: Vec<f64> =
                (0..=COLUMNS).map(|i| range[0] + (range[1] - range[0]) * i as f64 / COLUMNS as f64).collect();
            for prospects in seen.iter().map(|s| s.prospects.as_slice()).chain([asked]) {
                changes(prospects, at, range, &mut cuts);
            }
            cuts.sort_unstable_by(f64::total_cmp);
            grid.parts.extend(cuts.windows(2).map(|cut| {
                let prior = gamma.density(at) * step * (alpha.cdf(cut[1]) - alpha.cdf(cut[0]));
                (at, cut[0], cut[1], prior, 1.0)
            }));
        }
        let all: f64 = grid.parts.iter().map(|part| part.3).sum();
        grid.parts.iter_mut().for_each(|part| part.3 /= all);
        for Seen { prospects, likelihoods } in seen {
            for (gamma, from, to, _, density) in &mut grid.parts {
                let middle = Perception { alpha: 0.5 * (*from + *to), gamma: *gamma };
                let chosen = human_choice(prospects, RISK_WEIGHT, middle, None);
                *density = ((1.0 - rate) * *density + rate) * likelihoods[chosen];
            }
            let total = grid.mean(|_, _| 1.0);
            grid.parts.iter_mut().for_each(|part| part.4 /= total);
            grid.evidence.push(total);
        }
        grid
    }

    /// The mean of a function of (alpha, gamma) that is smooth within parts.
    fn mean(&self, function: impl Fn(f64, f64) -> f64) -> f64 {
        let node = 0.6f64.sqrt();
        let nodes = [(-node, 5.0 / 18.0), (0.0, 8.0 / 18.0), (node, 5.0 / 18.0)];
        let of = |&(gamma, from, to, prior, density): &(f64, f64, f64, f64, f64)| {
            let (mut sum, mut total) = (0.0, 0.0);
            for (x, weight) in nodes {
                let alpha = 0.5 * (from + to) + 0.5 * (to - from) * x;
                sum += weight * self.alpha.density(alpha) * function(alpha, gamma);
                total += weight * self.alpha.density(alpha);
            }
            if total > 0.0 { prior * density * sum / total } else { 0.0 }
        };
        self.parts.iter().map(of).sum()
    }
}

/// Random options near those of the paper's environments.
fn options(rng: &mut ChaCha8Rng) -> Vec<Prospect> {
    let around = [(41.9, 0.66), (17.4, 0.363), (14.3, 0.547), (21.4, 0.247)];
    around
        .iter()
        .map(|(d, s)| Prospect::new(d * rng.random_range(0.7..1.3), s * rng.random_range(0.8..1.2)))
        .collect()
}

fn seen(
    rng: &mut ChaCha8Rng,
    count: usize,
    chosen: impl Fn(&[Prospect], &mut ChaCha8Rng) -> usize,
) -> Vec<Seen> {
    (0..count)
        .map(|_| {
            let prospects = options(rng);
            let option = chosen(&prospects, rng);
            let likelihoods = (0..4).map(|o| if o == option { 0.985 } else { 0.005 }).collect();
            Seen { prospects, likelihoods }
        })
        .collect()
}

fn learned(belief: &Belief, seen: &[Seen], rate: f64) -> (Posterior, Vec<f64>) {
    let mut posterior = Posterior::new(belief.clone(), RISK_WEIGHT).unwrap();
    let evidence = seen.iter().map(|Seen { prospects, likelihoods }| {
        posterior.mix_with_prior(rate).unwrap();
        posterior.observe(prospects, &Ways::default(), likelihoods).unwrap()
    });
    let evidence = evidence.collect();
    (posterior, evidence)
}

/// Asserts that everything a posterior says is what the grid says.
fn assert_is_grid(belief: &Belief, seen: &[Seen], rate: f64, rows: usize, tolerance: f64) {
    let asked = [(30.0, 0.3), (15.4, 0.54), (17.8, 0.41), (14.0, 0.6)].map(|(d, s)| Prospect::new(d, s));
    let grid = Grid::new(belief, seen, &asked, rate, rows);
    let (mut posterior, evidence) = learned(belief, seen, rate);
    for (found, wanted) in evidence.iter().zip(&grid.evidence) {
        assert!((found - wanted).abs() < tolerance * wanted.max(0.01), "evidence {found} and {wanted}");
    }
    let (mut choice, mut costs) = (ChoiceDistribution::default(), Vec::new());
    posterior.predict_from(&asked, &Ways::default(), &mut choice);
    posterior.expected_costs(&asked, &mut costs);
    for (option, prospect) in asked.iter().enumerate() {
        let is_chosen = |alpha: f64, gamma: f64| {
            human_choice(&asked, RISK_WEIGHT, Perception { alpha, gamma }, None) == option
        };
        let wanted = grid.mean(|alpha, gamma| f64::from(u8::from(is_chosen(alpha, gamma))));
        let found = choice.probabilities()[option];
        assert!((found - wanted).abs() < tolerance, "P of option {option}: {found} and {wanted}");
        let wanted =
            grid.mean(|alpha, gamma| subjective_cost(*prospect, RISK_WEIGHT, Perception { alpha, gamma }));
        assert!((costs[option] - wanted).abs() < 10.0 * tolerance, "cost {} and {wanted}", costs[option]);
    }
    let estimate = posterior.estimate();
    let [alpha, gamma] = estimate.mean;
    let wanted = [
        (alpha, grid.mean(|a, _| a)),
        (gamma, grid.mean(|_, g| g)),
        (estimate.covariance[0], grid.mean(|a, _| (a - alpha) * (a - alpha))),
        (estimate.covariance[1], grid.mean(|a, g| (a - alpha) * (g - gamma))),
        (estimate.covariance[2], grid.mean(|_, g| (g - gamma) * (g - gamma))),
    ];
    for (i, (found, wanted)) in wanted.into_iter().enumerate() {
        assert!((found - wanted).abs() < tolerance, "moment {i}: {found} and {wanted}");
    }
    let of =
        |part: &(f64, f64, f64, f64, f64)| if part.4 > 0.0 { part.3 * part.4 * math_ln(part.4) } else { 0.0 };
    let information: f64 = grid.parts.iter().map(of).sum();
    assert!(
        (estimate.information - information).abs() < 10.0 * tolerance,
        "{} {information}",
        estimate.information
    );
    let in_region = |part: &&(f64, f64, f64, f64, f64)| part.4 >= estimate.region_density * (1.0 - 1e-4);
    let share: f64 = grid.parts.iter().filter(in_region).map(|part| part.3).sum();
    let most = (100.0 * tolerance).min(2e-3);
    assert!((estimate.region_share - share).abs() < most, "{} {share}", estimate.region_share);
    let [above, from] = posterior.credibility(estimate.region_density);
    assert!(from >= 0.95 - 1e-9 && above < 0.95 + 1e-9, "{above} {from}");
    let ends = [0, 1].map(|end| Perception { alpha: estimate.alpha[end], gamma: estimate.gamma[end] });
    let [low, high] = ends.map(|end| posterior.marginals(end));
    for axis in [0, 1] {
        assert!((low[axis] - 0.025).abs() < 1e-6 && (high[axis] - 0.975).abs() < 1e-6, "{low:?} {high:?}");
    }
}

fn math_ln(x: f64) -> f64 {
    crate::math::ln(x)
}

/// The choice of one human.
fn of_human(perception: Perception) -> impl Fn(&[Prospect], &mut ChaCha8Rng) -> usize {
    move |prospects, _| human_choice(prospects, RISK_WEIGHT, perception, None)
}

#[test]
fn property_brute_force_a_human_of_the_model() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for count in [1, 9] {
        let human = Belief::default().sample(&mut rng);
        let seen = seen(&mut rng, count, of_human(human));
        assert_is_grid(&Belief::default(), &seen, 0.0, 1500, 1e-6);
        assert_is_grid(&Belief::default(), &seen, 0.01, 1500, 1e-6);
    }
}

#[test]
fn property_brute_force_a_human_who_chooses_by_chance() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let seen = seen(&mut rng, 8, |_, rng| rng.random_range(0..4));
    assert_is_grid(&Belief::default(), &seen, 1e-4, 4500, 1e-6);
}

#[test]
fn property_brute_force_a_hundred_sightings() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let human = Belief::default().sample(&mut rng);
    let seen = [seen(&mut rng, 100, of_human(human)), seen(&mut rng, 100, |_, rng| rng.random_range(0..4))];
    for seen in seen {
        assert_is_grid(&Belief::default(), &seen, 0.001, 150, 3e-4);
    }
}

#[test]
fn property_brute_force_other_priors_and_graded_evidence() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let normal = Belief::Independent {
        alpha: "normal(0.75,0.1,0.55,0.95)".parse().unwrap(),
        gamma: "normal(0.8,0.2,0.5,1.1)".parse().unwrap(),
    };
    let wide = Belief::uniform((0.2, 1.4), (0.3, 2.0)).unwrap();
    for belief in [normal, wide] {
        let graded: Vec<Seen> = (0..4)
            .map(|_| Seen {
                prospects: options(&mut rng),
                likelihoods: (0..4).map(|_| rng.random_range(0.05..1.0)).collect(),
            })
            .collect();
        assert_is_grid(&belief, &graded, 0.001, 2500, 1e-6);
    }
}

#[test]
fn closed_form_the_same_observation_again_and_again() {
    // every border coincides with those before it
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let prospects = options(&mut rng);
    let mut once = Posterior::new(Belief::default(), RISK_WEIGHT).unwrap();
    let mut often = once.clone();
    let likelihoods: [f64; 4] = [0.3, 0.5, 0.9, 0.7];
    for _ in 0..10 {
        often.observe(&prospects, &Ways::default(), &likelihoods).unwrap();
    }
    once.observe(&prospects, &Ways::default(), &likelihoods.map(|l| crate::math::pow(l, 10.0))).unwrap();
    let (mut a, mut b) = (ChoiceDistribution::default(), ChoiceDistribution::default());
    let asked = options(&mut rng);
    once.predict_from(&asked, &Ways::default(), &mut a);
    often.predict_from(&asked, &Ways::default(), &mut b);
    for (a, b) in a.probabilities().iter().zip(b.probabilities()) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }
    assert!((once.estimate().information - often.estimate().information).abs() < 1e-9);
}

#[test]
fn closed_form_without_observations_it_is_the_predictor() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut predictor = crate::preference::Predictor::default();
    let mut posterior = Posterior::new(Belief::default(), RISK_WEIGHT).unwrap();
    let mut close = options(&mut rng);
    close[0].length = 0.4;
    close[1].length = 0.7;
    for prospects in [options(&mut rng), options(&mut rng)[..1].to_vec(), close] {
        let (mut a, mut b) = (ChoiceDistribution::default(), ChoiceDistribution::default());
        predictor.predict(&prospects, &mut a);
        posterior.predict_from(&prospects, &Ways::default(), &mut b);
        let (mut c, mut d) = (Vec::new(), Vec::new());
        predictor.expected_costs(&prospects, &mut c);
        posterior.expected_costs(&prospects, &mut d);
        for (a, b) in a.probabilities().iter().zip(b.probabilities()).chain(c.iter().zip(&d)) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }
    assert!(posterior.estimate().information < 1e-12);
}

#[test]
fn closed_form_samples_are_weighted_by_what_they_choose() {
    let sample =
        |alpha, gamma| super::super::WeightedSample { perception: Perception { alpha, gamma }, weight: 1.0 };
    let belief = Belief::samples(vec![sample(0.55, 1.1), sample(0.95, 0.5)]).unwrap();
    let mut posterior = Posterior::new(belief, RISK_WEIGHT).unwrap();
    let prospects = [Prospect::new(41.9, 0.2), Prospect::new(14.3, 0.6)];
    let chosen = [sample(0.55, 1.1), sample(0.95, 0.5)]
        .map(|s| human_choice(&prospects, RISK_WEIGHT, s.perception, None));
    assert_eq!(chosen, [0, 1]);
    let evidence = posterior.observe(&prospects, &Ways::default(), &[0.9, 0.1]).unwrap();
    assert!((evidence - 0.5).abs() < 1e-15);
    let mut choice = ChoiceDistribution::default();
    posterior.predict_from(&prospects, &Ways::default(), &mut choice);
    assert!((choice.probabilities()[0] - 0.9).abs() < 1e-15);
    assert!((posterior.estimate().mean[0] - (0.9 * 0.55 + 0.1 * 0.95)).abs() < 1e-15);
}

#[test]
fn closed_form_bad_observations_are_refused_and_change_nothing() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let mut posterior = Posterior::new(Belief::default(), RISK_WEIGHT).unwrap();
    let prospects = options(&mut rng);
    let before = posterior.learned();
    for bad in [&[1.0, 0.5, 0.5][..], &[1.0, f64::NAN, 1.0, 1.0], &[1.0, -0.1, 1.0, 1.0], &[]] {
        let refused = posterior.observe(&prospects, &Ways::default(), bad).unwrap_err().to_string();
        assert!(refused.contains("every option needs a finite one"), "{refused}");
    }
    let impossible = posterior.observe(&prospects, &Ways::default(), &[0.0; 4]).unwrap_err();
    assert!(impossible.to_string().starts_with("the observation is impossible under the belief: "));
    let refused = posterior.mix_with_prior(1.5).unwrap_err().to_string();
    assert_eq!(refused, "change rate 1.5 must be a number from 0 to 1");
    assert_eq!(posterior.learned(), before);
}

#[test]
fn a_restored_belief_is_the_same_to_the_bit() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let human = Belief::default().sample(&mut rng);
    let seen = seen(&mut rng, 8, of_human(human));
    let (mut posterior, _) = learned(&Belief::default(), &seen, 0.001);
    let mut restored = Posterior::new(Belief::default(), RISK_WEIGHT).unwrap();
    assert!(restored.restore(&posterior.learned()));
    let prospects = options(&mut rng);
    for belief in [&mut posterior, &mut restored] {
        belief.observe(&prospects, &Ways::default(), &[0.2, 0.9, 0.2, 0.2]).unwrap();
    }
    assert_eq!(posterior.learned(), restored.learned());
    assert_eq!(posterior.estimate(), restored.estimate());
    let other = Posterior::new(Belief::uniform((0.5, 0.9), (0.5, 1.1)).unwrap(), RISK_WEIGHT).unwrap();
    let before = posterior.learned();
    assert!(!posterior.restore(&other.learned()));
    assert_eq!(posterior.learned(), before);
}

#[test]
fn a_warm_observation_allocates_nothing() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let human = Belief::default().sample(&mut rng);
    let seen = seen(&mut rng, 200, of_human(human));
    let mut posterior = Posterior::new(Belief::default(), RISK_WEIGHT).unwrap();
    let (mut choice, mut costs) = (ChoiceDistribution::default(), Vec::new());
    let mut largest = 0;
    for (index, Seen { prospects, likelihoods }) in seen.iter().enumerate() {
        let allocated = allocation_counter::measure(|| {
            posterior.mix_with_prior(0.001).unwrap();
            posterior.observe(prospects, &Ways::default(), likelihoods).unwrap();
            posterior.predict_from(prospects, &Ways::default(), &mut choice);
            posterior.expected_costs(prospects, &mut costs);
        });
        largest = largest.max(posterior.size());
        assert!(index < 100 || allocated.count_total == 0, "observation {index}: {allocated:?}");
    }
    assert!((10..500).contains(&largest), "{largest} steps");
    // the belief has come close to the human
    let estimate = posterior.estimate();
    assert!(estimate.alpha[0] <= human.alpha && human.alpha <= estimate.alpha[1], "{estimate:?} {human:?}");
    assert!(estimate.region_share < 0.1, "{estimate:?}");
}
