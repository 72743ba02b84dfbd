//! Options that have become one way: they are aligned with it, and their probability is the executed
//! option's.

use crate::support::{cocarry, load, repository, stderr};
use cocarry::coordination::{Mode, StubbornnessSettings};
use cocarry::episode::{Episode, EpisodeSettings};
use cocarry::geometry::Path;
use cocarry::options::{OptionSet, Progress};
use cocarry::policy::Method;
use cocarry::preference::{Belief, Perception, Predictor, SampleSet, WeightedSample};
use cocarry::world::World;
use cocarry_studies::paper::EXAMPLE_HUMAN;
use cocarry_studies::paper::cycles::random_world;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

fn length_apart(a: &Path, b: &Path) -> f64 {
    let at = |i: u32| Some((a.point_at(0.1 * f64::from(i))? - b.point_at(0.1 * f64::from(i))?).norm());
    let steps = (10.0 * a.length().max(b.length())).ceil() as u32;
    let apart = (0..=steps).map_while(at).fold(0.0, f64::max);
    apart.max((a.length() - b.length()).abs())
}

/// Walks an episode. At every step, options whose path from here is the executed option's are aligned with it
/// and equal to it to the bit, and P_o is not theirs but the executed option's. Returns how many steps had
/// such options, and whether any P_o but the executed one's was 1.
fn check(set: &OptionSet, settings: &EpisodeSettings, human: Perception, context: &str) -> (u32, u32) {
    let mut episode = Episode::new(set, settings, human);
    let mut progress: Progress = set.begin();
    let (mut shared, mut certain_of_another) = (0, 0);
    let mut before = None;
    while episode.step().is_none() {
        let tick = episode.tick();
        set.advance(&mut progress, tick.position);
        // the option that the team was walking when P_o was evaluated
        let Some(walked) = before.replace(tick.executed) else { continue };
        let way = set.path(&progress, walked).expect("a way");
        for (o, option) in tick.options.iter().enumerate().filter(|(o, _)| *o != walked) {
            certain_of_another += u32::from(option.probability > 1.0 - 1e-12 && tick.executed != o);
            let is_the_same = set.path(&progress, o).is_some_and(|path| length_apart(&way, &path) < 1e-9);
            if !is_the_same {
                continue;
            }
            let at = format!("{context}, step {}, option {o} next to {walked}", tick.step);
            shared += 1;
            assert!(!option.misaligned, "{at}: misaligned");
            assert!(
                option.probability.is_nan() || option.probability == 0.0,
                "{at}: P = {}",
                option.probability
            );
            assert_eq!(option.objective.to_bits(), tick.options[walked].objective.to_bits(), "{at}: J");
            assert_eq!(option.expected.to_bits(), tick.options[walked].expected.to_bits(), "{at}: J~");
        }
    }
    (shared, certain_of_another)
}

fn settings(eta: f64, method: Method) -> EpisodeSettings {
    let coordination = StubbornnessSettings { eta, ..StubbornnessSettings::default() };
    EpisodeSettings { coordination, method, predict_while_human_leads: true, ..EpisodeSettings::default() }
}

#[test]
fn options_that_have_become_one_way_are_aligned_and_their_probability_is_the_executed_ones() {
    let mut shared = 0;
    for number in 1..=4 {
        let (world, set) = load(&repository(&format!("worlds/environment-{number}.toml")));
        for eta in [1.0, 2.0, 4.0, 5.0, 8.0, 10.5, 15.0, 20.0, 30.0] {
            for method in [Method::MUTUAL, Method::ROBOT_LED, Method::HUMAN_LED] {
                let context = format!("{}, eta {eta}, {}", world.file, method.name());
                let (steps, certain) = check(&set, &settings(eta, method), EXAMPLE_HUMAN, &context);
                assert_eq!(certain, 0, "{context}: P = 1 on an option that nobody walks");
                shared += steps;
            }
        }
    }
    assert!(shared > 1000, "{shared}");
}

/// The same in worlds with many openings one after the other, and with a belief made of samples.
#[test]
fn property_in_random_worlds_options_that_have_become_one_way_are_one() {
    let mut shared = 0;
    let samples: Vec<WeightedSample> = (0..6)
        .map(|i| Perception { alpha: 0.6 + 0.1 * f64::from(i), gamma: 0.9 - 0.05 * f64::from(i) })
        .map(|perception| WeightedSample { perception, weight: 1.0 })
        .collect();
    let samples = Belief::Samples(SampleSet::new(samples).unwrap());
    for seed in 0..60 {
        let text = random_world(&mut ChaCha8Rng::seed_from_u64(seed));
        let Ok(world) = World::parse("random", &text) else { continue };
        let Ok(set) = OptionSet::new(&world, 10.0) else { continue };
        let mut settings = settings(3.0, if seed % 3 == 0 { Method::HUMAN_LED } else { Method::MUTUAL });
        if seed % 2 == 0 {
            settings.predictor = Predictor::new(samples.clone(), 10.0).unwrap();
        }
        shared += check(&set, &settings, EXAMPLE_HUMAN, &format!("world {seed}")).0;
    }
    assert!(shared > 500, "{shared}");
}

/// Nobody wants to be elsewhere when all ways have become one: no transition behind the last opening.
#[test]
fn issue_a_transition_behind_the_last_opening() {
    for (world, eta) in [("environment-4", "20"), ("environment-3", "8")] {
        let output = cocarry(&["run", world, "--plant", "point", "--eta", eta, "--json"]);
        assert!(output.status.success(), "{}", stderr(&output));
        let run: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert!(run["transition_step"].is_null(), "{world}, eta {eta}: {}", run["transition_step"]);
    }
    let set = load(&repository("worlds/environment-4.toml")).1;
    for eta in 1..=30 {
        let settings = settings(f64::from(eta), Method::MUTUAL);
        let mut episode = Episode::new(&set, &settings, EXAMPLE_HUMAN);
        while episode.step().is_none() {
            let tick = episode.tick();
            let transition = episode.summary().transition.as_ref();
            if tick.mode == Mode::HumanLed && transition.is_some_and(|t| t.step == tick.step) {
                assert!(tick.options.iter().any(|o| o.remaining.risk > 0.0), "eta {eta}: step {}", tick.step);
                assert!(tick.position.x < 5.0, "eta {eta}: beyond the wall, at {}", tick.position);
            }
        }
    }
}
