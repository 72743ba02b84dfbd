//! The paper's tables, within the tolerances that the book states.

mod coverage;

use cocarry::episode::{EpisodeSettings, Outcome};
use cocarry::options::OptionSet;
use cocarry::policy::Method;
use cocarry::preference::Predictor;
use cocarry::robot::Robot;
use cocarry::scenario::{Plant, PlantKind, RobotSetup};
use cocarry::world::World;
use cocarry_studies::fit::{AnswerFile, RiskWeightSettings, Situation, fit_risk_weight};
use cocarry_studies::paper::cycles::mixed_world;
use cocarry_studies::paper::h3::{PoseMethod, PoseStudy};
use cocarry_studies::paper::{self, h1, h2};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::path::Path;

#[test]
fn paper_table_1() {
    let rows = h1::table(&Predictor::default()).expect("built-in worlds");
    assert_eq!(rows.len(), 16);
    let (mean, worst) = h1::differences(&rows);
    assert!(worst <= 2.5, "largest difference {worst} percentage points");
    assert!(mean <= 1.0, "mean difference {mean} percentage points");
    for environment in rows.chunks(4) {
        let ranking = |value: fn(&h1::ChoiceRow) -> f64| {
            let mut order: Vec<usize> = (0..4).collect();
            order.sort_by(|&a, &b| value(&environment[b]).total_cmp(&value(&environment[a])));
            order
        };
        let (ours, paper) = (ranking(|r| r.ours_percent), ranking(|r| r.paper_percent));
        assert_eq!(ours, paper, "environment {}", environment[0].environment);
    }
}

/// Sec. V-A: c_r fitted to the mean answers in Environments 1 to 3 (the paper: 10), validated in Environment
/// 4.
#[test]
fn paper_risk_weight() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/data/table-1-humans.csv");
    let file = AnswerFile::read(&file).expect("the answers of Table I");
    let situations = file.worlds().into_iter().map(|(name, _)| {
        let world = World::find(std::path::Path::new(""), &name).expect("a valid one");
        Situation::new(name, &OptionSet::new(&world, 10.0).expect("its options"))
    });
    let answers = file.matched(situations.collect(), true).expect("complete answers");
    for (w, environment) in paper::ENVIRONMENTS.iter().enumerate() {
        let sum: f64 = environment.human_percent.iter().sum();
        let shares = answers.shares[0][w].as_ref().expect("an answer");
        let same = shares.iter().zip(environment.human_percent).all(|(s, p)| (s - p / sum).abs() < 1e-12);
        assert!(same, "{}: the file is not Table I's human column", environment.name);
    }
    let settings = RiskWeightSettings { held_out: vec!["environment-4".into()], ..Default::default() };
    let fit = fit_risk_weight(&answers, &Predictor::default(), &settings, &|| ()).expect("a fit");
    assert!((9.0..=11.0).contains(&fit.least_squares.risk_weight), "{:?}", fit.least_squares);
    assert!((9.0..=11.0).contains(&fit.likelihood.risk_weight), "{:?}", fit.likelihood);
    // percentage points; the paper's own model column is off by 4.4 (rms) in Environment 4
    let held_out = fit.least_squares.held_out.expect("Environment 4");
    assert!(held_out.rms < 5.0 && held_out.largest < 7.0, "{held_out:?}");
    assert!(!fit.least_squares.is_at_end && fit.least_squares.other_optima.is_empty());
}

#[test]
fn paper_table_2() {
    let rows = h2::table(&EpisodeSettings::default(), 0, &|| ()).expect("built-in worlds");
    assert_eq!(rows.len(), 16);
    for row in &rows {
        let tolerance = if row.environment == 2 { 0.10 } else { 0.08 };
        let off = row.ours_mean / row.paper_mean - 1.0;
        assert!(off.abs() <= tolerance, "{row:?}: {:.1} %", 100.0 * off);
        assert_eq!(row.not_arrived, 0, "{row:?}");
    }
    for environment in rows.chunks(4) {
        assert_eq!(environment[0].method, Method::WITHOUT_MODEL);
        let costs: Vec<f64> = environment.iter().map(|r| r.ours_mean).collect();
        assert!(costs.is_sorted_by(|a, b| a >= b), "{costs:?}");
        assert!(costs[0] > costs[3], "{costs:?}");
    }
}

/// Random worlds of 3 to 20 mixed obstacles: no path turns by more than 100 degrees at an end of a straight
/// part, anywhere.
#[test]
fn property_no_option_doubles_back_in_1000_random_worlds() {
    let worlds = (0..).filter_map(|seed| {
        let text = mixed_world(&mut ChaCha8Rng::seed_from_u64(seed), seed % 2 == 0);
        let world = World::parse("random world", &text).ok()?;
        Some((seed, OptionSet::new(&world, 10.0).ok()?))
    });
    let mut options = 0;
    for (seed, set) in worlds.take(1000) {
        for o in 0..set.options().len() {
            let path = set.path(&set.begin(), o).expect("a path");
            let degrees = path.sharpest_bend().to_degrees();
            assert!(degrees <= 100.0, "random world {seed}, option {o}: {degrees:.1} degrees");
            options += 1;
        }
    }
    assert!(options > 2000, "{options} options");
}

#[test]
fn paper_environment_4_example() {
    let (_, runs) =
        h2::example(paper::EXAMPLE_ENVIRONMENT, &EpisodeSettings::default()).expect("a built-in world");
    for run in &runs {
        assert_eq!(run.summary.outcome, Outcome::Arrived);
        let Some((step, option)) = run.paper else { continue };
        assert_eq!(run.ended_on, option, "eta {:?}", run.eta);
        if let Some(step) = step {
            let ours = run.summary.transition.expect("a transition").step;
            assert!(ours.abs_diff(step) <= 8, "eta {:?}: step {ours}, paper {step}", run.eta);
        }
    }
    // the human starts out preferring option 4
    assert!(runs.iter().all(|run| run.ticks[0].preferred == 3));
}

/// `cocarry reproduce h3` does the same with 100 humans a cell and from every posture.
#[test]
fn paper_table_3() {
    let robot = Robot::built_in().expect("the built-in robot");
    let study = PoseStudy {
        plant: &Plant::new(PlantKind::Kinematic, RobotSetup::new(&robot)),
        starts: &[&robot.postures[0].name],
        methods: &PoseMethod::ALL,
        episodes: 3,
        seed: 0,
        settings: &EpisodeSettings::default(),
    };
    let rows = study.table(&|| ()).expect("built-in worlds");
    assert_eq!(rows.len(), 16 * PoseMethod::ALL.len());
    assert!(rows.iter().all(|r| r.not_arrived == 0 && r.fallback_steps == 0));
    let ratios =
        |method| -> Vec<f64> { rows.iter().filter(|r| r.method == method).map(|r| r.ratio).collect() };
    let mean = |method| ratios(method).iter().sum::<f64>() / 16.0;
    let with_po = ratios(PoseMethod::WithPo);
    assert!(with_po.iter().all(|r| *r < 1.0), "{with_po:?}");
    assert!(mean(PoseMethod::WithPo) <= 0.80, "{}", mean(PoseMethod::WithPo));
    // what the book says beyond the paper
    assert!(mean(PoseMethod::Manipulability) > mean(PoseMethod::WithPo) + 0.1);
    assert!((mean(PoseMethod::UniformWeights) - mean(PoseMethod::WithPo)).abs() < 0.01);
    assert!(mean(PoseMethod::WithPoObstacles) <= 0.80);
}
