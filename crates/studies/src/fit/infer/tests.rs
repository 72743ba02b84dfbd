use super::*;
use crate::fit::Situation;
use cocarry::learning::TolerancePrior;
use cocarry::math;
use cocarry::preference::{
    ALTERNATIVES, Marginal, Perception, Prospect, RiskPerception, StevensPrelec, human_choice,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const RISK_WEIGHT: f64 = 10.0;

/// Four worlds whose regions cut the plane differently.
fn situations() -> Vec<Situation> {
    let worlds = [
        vec![(41.86, 0.66), (17.4, 0.363), (14.33, 0.547), (21.36, 0.247)],
        vec![(12.0, 0.5), (15.0, 0.3), (30.0, 0.05)],
        vec![(20.0, 0.7), (24.0, 0.45), (33.0, 0.2)],
        vec![(9.0, 0.25), (11.0, 0.1)],
    ];
    let of = |(w, options): (usize, &Vec<(f64, f64)>)| Situation {
        world: format!("world {w}"),
        options: (1..=options.len()).map(|o| o.to_string()).collect(),
        prospects: options.iter().map(|(length, risk)| Prospect::new(*length, *risk)).collect(),
    };
    worlds.iter().enumerate().map(of).collect()
}

fn model() -> InferenceModel {
    InferenceModel { belief: Belief::default(), risk_weight: RISK_WEIGHT }
}

/// One choice of each human in every world, with lapses.
fn answers(humans: &[Perception], lapse_rate: f64, rng: &mut ChaCha8Rng) -> Answers {
    let situations = situations();
    let mut answer = |human: &Perception, situation: &Situation| {
        let options = situation.options.len();
        let lapsed = rng.random_bool(lapse_rate);
        let drawn = rng.random_range(0..options);
        let chosen =
            if lapsed { drawn } else { human_choice(&situation.prospects, RISK_WEIGHT, *human, None) };
        Some((0..options).map(|o| f64::from(u8::from(o == chosen))).collect())
    };
    let shares = humans.iter().map(|human| situations.iter().map(|s| answer(human, s)).collect()).collect();
    Answers {
        file: "answers.csv".to_owned(),
        participants: (0..humans.len()).map(|p| format!("person {p}")).collect(),
        shares,
        scaled: Vec::new(),
        situations,
    }
}

fn inferred(answers: &Answers, settings: &InferenceSettings) -> Inference {
    infer(Some(answers), None, &[], &model(), settings, &|| ()).unwrap()
}

fn few_draws(lapse_rate: f64) -> InferenceSettings {
    InferenceSettings { lapse_rate, draws: 250, ..InferenceSettings::default() }
}

#[test]
fn property_brute_force_of_a_participant() {
    let mut answers =
        answers(&[Perception { alpha: 0.7, gamma: 0.8 }], 0.0, &mut ChaCha8Rng::seed_from_u64(1));
    answers.shares[0][0] = Some(vec![0.05, 0.5, 0.15, 0.3]);
    let lapse_rate = 0.1;
    let found = &inferred(&answers, &few_draws(lapse_rate)).people[0];
    let points = 500;
    let mut sums = [0.0; 5];
    for i in 0..points {
        for j in 0..points {
            let at =
                |low: f64, high: f64, i: i32| low + (high - low) * (f64::from(i) + 0.5) / f64::from(points);
            let human = Perception { alpha: at(0.55, 0.95, i), gamma: at(0.5, 1.1, j) };
            let mut likelihood = 1.0;
            for (situation, shares) in answers.situations.iter().zip(&answers.shares[0]) {
                let preferred = human_choice(&situation.prospects, RISK_WEIGHT, human, None);
                let even = lapse_rate / situation.options.len() as f64;
                for (o, share) in shares.as_ref().unwrap().iter().enumerate() {
                    let p = even + if o == preferred { 1.0 - lapse_rate } else { 0.0 };
                    likelihood *= math::pow(p, *share);
                }
            }
            let Perception { alpha, gamma } = human;
            let terms = [1.0, alpha, alpha * alpha, gamma, gamma * gamma];
            sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += likelihood * term);
        }
    }
    let [total, a, aa, g, gg] = sums;
    let std = |first: f64, second: f64| (second / total - math::squared(first / total)).sqrt();
    let near = |found: f64, wanted: f64, what: &str| {
        assert!((found - wanted).abs() < 2e-4, "{what}: {found}, not {wanted}");
    };
    near(found.alpha.mean, a / total, "mean of alpha");
    near(found.alpha.std, std(a, aa), "spread of alpha");
    near(found.gamma.mean, g / total, "mean of gamma");
    near(found.gamma.std, std(g, gg), "spread of gamma");
    near(found.log_evidence, math::ln(total / f64::from(points * points)), "evidence");
}

/// People drawn from populations that are drawn from their prior lie in their 95 % intervals 95 % of the time,
/// alone (drawn from the belief) and within the population.
#[test]
fn people_lie_in_their_intervals_as_often_as_said() {
    let (lapse_rate, studies, people) = (0.05, 60, 5);
    let mut inside = [0.0; 2];
    for study in 0..studies {
        let mut rng = ChaCha8Rng::seed_from_u64(100 + study);
        // the population's prior, as `population.rs` says
        let mut normal = |low: f64, high: f64| {
            let mean = low + (high - low) * rng.random::<f64>();
            let spread = (high - low) * 0.05 * math::pow(40.0, rng.random::<f64>());
            Marginal::truncated_normal(mean, spread, low, high).unwrap()
        };
        let (alpha, gamma) = (normal(0.55, 0.95), normal(0.5, 1.1));
        let crowd: Vec<Perception> = (0..people)
            .map(|_| Perception { alpha: alpha.sample(&mut rng), gamma: gamma.sample(&mut rng) })
            .collect();
        let loners: Vec<Perception> = (0..people).map(|_| model().belief.sample(&mut rng)).collect();
        let count = |figures: [Figure; 2], human: Perception| -> f64 {
            let holds = |f: Figure, value: f64| f.interval[0] <= value && value <= f.interval[1];
            f64::from(u8::from(holds(figures[0], human.alpha)) + u8::from(holds(figures[1], human.gamma)))
        };
        for (human, person) in loners
            .iter()
            .zip(inferred(&answers(&loners, lapse_rate, &mut rng), &few_draws(lapse_rate)).people)
        {
            inside[0] += count([person.alpha, person.gamma], *human);
        }
        for (human, person) in
            crowd.iter().zip(inferred(&answers(&crowd, lapse_rate, &mut rng), &few_draws(lapse_rate)).people)
        {
            inside[1] += count(person.within_population.unwrap(), *human);
        }
    }
    let shares = inside.map(|n| n / (2.0 * people as f64 * studies as f64));
    // 600 values: a standard error of 0.9 %, and more among people of one population
    assert!(shares.iter().all(|share| (0.92..=0.98).contains(share)), "{shares:?}");
}

#[test]
fn a_population_is_found_again() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let normal = |mean, low, high| Marginal::truncated_normal(mean, 0.04, low, high).unwrap();
    let (alpha, gamma) = (normal(0.65, 0.55, 0.95), normal(0.95, 0.5, 1.1));
    let crowd: Vec<Perception> = (0..60)
        .map(|_| Perception { alpha: alpha.sample(&mut rng), gamma: gamma.sample(&mut rng) })
        .collect();
    let population = inferred(&answers(&crowd, 0.02, &mut rng), &few_draws(0.02)).population.unwrap();
    // choices say less of gamma
    for (which, truth, narrower) in [(0, 0.65, 0.5), (2, 0.95, 0.9)] {
        let [low, high] = population.posterior[which].interval;
        assert!(low <= truth && truth <= high, "{truth} is not in {low} to {high}");
        assert!(population.posterior[which].std < narrower * population.prior[which].std, "{population:?}");
    }
    assert!(population.information > 1.0);
}

#[test]
fn draws_have_the_moments_of_the_posterior() {
    let humans = [(0.6, 0.6), (0.9, 1.0), (0.75, 0.8)];
    let humans = humans.map(|(alpha, gamma)| Perception { alpha, gamma });
    let answers = answers(&humans, 0.0, &mut ChaCha8Rng::seed_from_u64(1));
    let settings = InferenceSettings { has_population: false, draws: 2500, ..InferenceSettings::default() };
    let inference = inferred(&answers, &settings);
    for (p, person) in inference.people.iter().enumerate() {
        let all =
            [(&inference.posterior.alpha[p], person.alpha), (&inference.posterior.gamma[p], person.gamma)];
        for (draws, figure) in all {
            let (mean, std) = crate::statistics::mean_and_std(draws);
            // 10 000 draws
            assert!((mean - figure.mean).abs() < 0.04 * figure.std, "{mean} {figure:?}");
            assert!((std / figure.std - 1.0).abs() < 0.03, "{std} {figure:?}");
        }
    }
    assert_eq!(inference.posterior.log_density.len(), 10_000);
}

/// A population held to the belief's uniform by few answers changes little; answers of one sort of people
/// change the posterior of somebody who did not answer much.
#[test]
fn a_participant_with_few_answers_leans_on_the_others() {
    let humans = vec![Perception { alpha: 0.58, gamma: 0.6 }; 12];
    let mut answers = answers(&humans, 0.0, &mut ChaCha8Rng::seed_from_u64(1));
    answers.shares[11] = vec![None, None, None, answers.shares[11][3].clone()];
    let person = inferred(&answers, &few_draws(0.02)).people[11].clone();
    let within = person.within_population.unwrap();
    assert!(within[0].std < 0.9 * person.alpha.std, "{person:?}");
    assert!((within[0].mean - 0.58).abs() < (person.alpha.mean - 0.58).abs(), "{person:?}");
}

#[test]
fn closed_form_contradictions_are_named() {
    let mut answers =
        answers(&[Perception { alpha: 0.7, gamma: 0.8 }], 0.0, &mut ChaCha8Rng::seed_from_u64(1));
    answers.shares[0][0] = Some(vec![1.0, 0.0, 0.0, 0.0]);
    let settings = few_draws(0.0);
    let error = infer(Some(&answers), None, &[], &model(), &settings, &|| ()).unwrap_err().to_string();
    for part in ["answers.csv", "`person 0`", "world 0", "--lapse-rate"] {
        assert!(error.contains(part), "{error}");
    }
    let error = infer_means(&answers, 20, &model(), &settings, &|| ()).unwrap_err().to_string();
    assert!(error.contains("answers.csv") && error.contains("--lapse-rate"), "{error}");
}

#[test]
fn mean_answers_find_the_population_of_their_options() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let normal = |mean, low, high| Marginal::truncated_normal(mean, 0.05, low, high).unwrap();
    let (alpha, gamma) = (normal(0.65, 0.55, 0.95), normal(0.95, 0.5, 1.1));
    let crowd: Vec<Perception> = (0..400)
        .map(|_| Perception { alpha: alpha.sample(&mut rng), gamma: gamma.sample(&mut rng) })
        .collect();
    let mut answers = answers(&crowd, 0.0, &mut rng);
    let worlds = answers.situations.len();
    let mean = |w: usize| -> Vec<f64> {
        let options = answers.situations[w].options.len();
        let share = |o: usize| answers.shares.iter().map(|s| s[w].as_ref().unwrap()[o]).sum::<f64>() / 400.0;
        (0..options).map(share).collect()
    };
    answers.shares = vec![(0..worlds).map(|w| Some(mean(w))).collect()];
    answers.participants.truncate(1);
    let means = infer_means(&answers, 400, &model(), &few_draws(0.02), &|| ()).unwrap();
    for row in &means.rows {
        assert!((row.posterior_percent - row.answered_percent).abs() < 5.0, "{row:?}");
    }
    for (which, truth) in [(0, 0.65), (2, 0.95)] {
        let [low, high] = means.population.posterior[which].interval;
        assert!(low <= truth && truth <= high, "{truth} is not in {low} to {high}");
    }
}

#[test]
fn issue_a_mean_outside_its_interval_was_all_that_was_told() {
    // a press of a button: a narrow interval of eta, but for lapses
    let mut tolerance = Tolerance::new(TolerancePrior::default(), 0.02).unwrap();
    tolerance.begin_task();
    tolerance.set_task([27.4, 27.64]);
    let [mean, variance] = tolerance.moments();
    let figure = Figure::new([mean, variance.sqrt()], |share| tolerance.quantile(share));
    assert!(figure.mean < figure.interval[0], "{figure:?}");
    let ends = [figure.interval, figure.interval_80, figure.interval_50, [figure.median; 2]];
    for (outer, inner) in ends.iter().zip(&ends[1..]) {
        assert!(outer[0] <= inner[0] && inner[1] <= outer[1], "{figure:?}");
    }
    assert!(figure.interval[0] > 27.4 && figure.interval[1] < 27.64, "{figure:?}");
}

/// One choice of people with this perception of risk in every world, with lapses.
fn answers_by(
    perception: &dyn RiskPerception,
    people: usize,
    risk_weight: f64,
    lapse_rate: f64,
    rng: &mut ChaCha8Rng,
) -> Answers {
    let mut answers = answers(&vec![Perception { alpha: 1.0, gamma: 1.0 }; people], 0.0, rng);
    for worlds in &mut answers.shares {
        let parameters = perception.at(&[rng.random(), rng.random()]);
        for (shares, situation) in worlds.iter_mut().zip(&answers.situations) {
            let prefers = perception.choice(&situation.prospects, risk_weight, &parameters, None);
            let drawn = rng.random_range(0..situation.options.len());
            let chosen = if rng.random_bool(lapse_rate) { drawn } else { prefers };
            *shares = Some((0..situation.options.len()).map(|o| f64::from(u8::from(o == chosen))).collect());
        }
    }
    answers
}

#[test]
fn answers_follow_the_perception_of_risk_that_made_them() {
    let paper = StevensPrelec::new(Belief::default());
    // with 10 m, cumulative prospect theory and expected risk have everybody choose the same
    let model = InferenceModel { risk_weight: 40.0, ..model() };
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for perception in ALTERNATIVES.into_iter().chain([&paper as &dyn RiskPerception]) {
        let answers = answers_by(perception, 200, model.risk_weight, 0.02, &mut rng);
        let rows = compare_perceptions(&answers, &model, &few_draws(0.02), &|| ()).unwrap();
        let mut scores: Vec<_> = rows.iter().map(|row| (row.posterior.log_score, &row.perception)).collect();
        scores.sort_by(|a, b| b.0.partial_cmp(&a.0).unwrap());
        assert_eq!(scores[0].1, perception.name(), "{scores:?}");
        // the c_r that the answers were made with is found, to a step of 26 %
        let own = rows.iter().find(|row| row.perception == perception.name()).unwrap();
        let [low, high] = own.fitted_risk_weights;
        assert!(low > 25.0 && high < 64.0, "{}: {low} to {high}", perception.name());
    }
}

#[test]
fn the_papers_row_of_perceptions_is_the_exact_prediction_of_held_out_worlds() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let answers = answers_by(&StevensPrelec::new(Belief::default()), 40, RISK_WEIGHT, 0.1, &mut rng);
    let exact = inferred(&answers, &few_draws(0.1));
    let exact = exact.held_out.iter().find(|row| row.world.is_none()).unwrap();
    let rows = compare_perceptions(&answers, &model(), &few_draws(0.1), &|| ()).unwrap();
    let paper = rows.iter().find(|row| row.perception == "stevens-prelec").unwrap();
    for (found, wanted) in [(paper.posterior, exact.posterior), (paper.prior, exact.prior)] {
        let difference = found.log_score.unwrap() - wanted.log_score.unwrap();
        assert!(difference.abs() < 1e-3 && found.hits == wanted.hits, "{found:?} {wanted:?}");
    }
}
