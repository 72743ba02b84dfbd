//! Whole episodes: what must hold of every one of them.

use crate::support::{cocarry, load, repository, stderr, world_files};
use cocarry::coordination::{self, Mode};
use cocarry::episode::{Episode, EpisodeSettings, Outcome, PreferenceChange, Tick, run};
use cocarry::human::PreferenceHuman;
use cocarry::math;
use cocarry::policy::Method;
use cocarry::preference::{Perception, Prospect, RISK_WEIGHT, subjective_cost};
use cocarry::scenario::{Plant, PlantKind, RobotSetup};
use cocarry_studies::paper::EXAMPLE_HUMAN;
use cocarry_studies::paper::cycles::{Cause, Findings, Search};
use cocarry_studies::paper::placed::Placed;
use cocarry_studies::paper::starts;

fn settings(method: Method, eta: f64) -> EpisodeSettings {
    let coordination =
        coordination::StubbornnessSettings { eta, ..coordination::StubbornnessSettings::default() };
    EpisodeSettings { method, coordination, ..EpisodeSettings::default() }
}

fn ticks(
    world: &str,
    settings: &EpisodeSettings,
    human: Perception,
) -> (cocarry::episode::Summary, Vec<Tick>) {
    let (_, set) = load(&repository(world));
    let mut ticks = Vec::new();
    let summary = run(&set, settings, human, |t| ticks.push(t.clone()));
    (summary, ticks)
}

#[test]
fn property_every_episode_keeps_its_books() {
    for file in world_files() {
        let (_, set) = load(&file);
        for method in [Method::MUTUAL, Method::WITHOUT_MODEL, Method::ROBOT_LED] {
            for (alpha, gamma) in [(0.56, 1.05), (0.747, 0.765), (0.94, 0.55)] {
                let mut ticks: Vec<Tick> = Vec::new();
                let settings = settings(method, 5.0);
                let summary = run(&set, &settings, Perception { alpha, gamma }, |t| ticks.push(t.clone()));
                assert_eq!(summary.outcome, Outcome::Arrived, "{}", file.display());
                assert_eq!(summary.steps as usize, ticks.len());
                let total: f64 = ticks.iter().map(|t| t.objective_cost).sum();
                assert!((total - summary.accumulated_cost).abs() < 1e-9 * total);
                for (k, tick) in ticks.iter().enumerate() {
                    assert_eq!(tick.step as usize, k);
                    let sum: f64 = tick.options.iter().map(|o| o.probability).sum();
                    assert!((sum - 1.0).abs() < 1e-12, "P sums to {sum}");
                    let chosen = &tick.options[tick.executed];
                    assert_eq!(tick.objective_cost, chosen.remaining.length + 10.0 * chosen.remaining.risk);
                }
                for pair in ticks.windows(2) {
                    assert!(pair[1].stubbornness >= pair[0].stubbornness);
                    assert!(pair[0].mode == Mode::RobotLed || pair[1].mode == Mode::HumanLed);
                    assert!((pair[1].position - pair[0].position).norm() <= 0.1 + 1e-9);
                }
            }
        }
    }
}

/// g(k) of eq. (5), summed again from what the ticks say.
#[test]
fn property_discomfort_is_the_sum_of_the_misaligned_probabilities() {
    let (_, ticks) = ticks("worlds/environment-1.toml", &settings(Method::ROBOT_LED, 10.5), EXAMPLE_HUMAN);
    let mut g = 0.0;
    for tick in &ticks {
        g += tick.options.iter().filter(|o| o.misaligned).map(|o| o.probability).sum::<f64>();
        assert!((tick.discomfort - g).abs() < 1e-9);
        let phi = 0.1 * math::exp(g / 10.5);
        assert!((tick.stubbornness - phi).abs() < 1e-9 * phi);
    }
    assert!(g > 1.0);
    assert!(ticks[0].options.iter().all(|o| !o.misaligned), "g(0) = 0");
}

#[test]
fn closed_form_in_the_example_only_the_options_through_other_openings_are_misaligned() {
    let (_, ticks) = ticks("worlds/environment-4.toml", &settings(Method::MUTUAL, 15.0), EXAMPLE_HUMAN);
    let misaligned: Vec<bool> = ticks[1].options.iter().map(|o| o.misaligned).collect();
    assert_eq!(misaligned, [true, true, false, true]);
}

/// omega_o says where the team goes, whoever leads: discomfort grows by it under the robot's lead only.
#[test]
fn options_are_misaligned_under_the_human_s_lead_too() {
    let (_, ticks) = ticks("worlds/environment-4.toml", &settings(Method::MUTUAL, 5.0), EXAMPLE_HUMAN);
    let led: Vec<&Tick> = ticks.iter().filter(|tick| tick.mode == Mode::HumanLed).collect();
    // on the way to option 4's opening, all others are misaligned
    let misaligned: Vec<bool> = led[10].options.iter().map(|o| o.misaligned).collect();
    assert_eq!((led[10].executed, &misaligned[..]), (3, &[true, true, true, false][..]));
    assert!(led.windows(2).all(|pair| pair[0].discomfort == pair[1].discomfort));
}

#[test]
fn a_robot_that_leads_to_the_end_never_hands_over() {
    let settings = settings(Method::ROBOT_LED, 1.0);
    let (summary, ticks) = ticks("worlds/environment-4.toml", &settings, EXAMPLE_HUMAN);
    assert!(ticks.iter().all(|t| t.mode == Mode::RobotLed));
    assert!(ticks.last().unwrap().stubbornness > 1.0);
    assert_eq!(summary.transition, None);
}

#[test]
fn without_the_model_the_first_choice_is_kept() {
    let (summary, ticks) =
        ticks("worlds/environment-4.toml", &settings(Method::WITHOUT_MODEL, 5.0), EXAMPLE_HUMAN);
    assert!(ticks.iter().all(|t| t.mode == Mode::HumanLed && t.executed == ticks[0].preferred));
    assert_eq!(summary.option_changes, 0);
}

/// Sums over the ticks, with the perception that the human has in each.
#[test]
fn closed_form_what_an_episode_is_to_the_human() {
    let (_, set) = load(&repository("worlds/environment-4.toml"));
    let settings = settings(Method::MUTUAL, 5.0);
    let later = Perception { alpha: 0.55, gamma: 1.1 };
    let changes = [PreferenceChange { step: 10, perception: later }];
    let mut episode = Episode::builder(&set, &settings, EXAMPLE_HUMAN)
        .with_human(PreferenceHuman::new(EXAMPLE_HUMAN, settings.coordination).with_changes(&changes))
        .begin()
        .expect("a point has room");
    let (mut ticks, mut cost) = (Vec::<Tick>::new(), 0.0);
    while episode.step().is_none() {
        let tick = episode.tick();
        let perception = if tick.step < 10 { EXAMPLE_HUMAN } else { later };
        let remaining = tick.options[tick.executed].remaining;
        cost += subjective_cost(Prospect::new(remaining.length, remaining.risk), RISK_WEIGHT, perception);
        ticks.push(tick.clone());
    }
    let (human, steps) = (episode.summary().human, episode.summary().steps);
    let last = ticks.last().expect("a tick");
    let found = human.subjective_cost.unwrap();
    assert!((found - cost).abs() < 1e-9 * cost, "{found} {cost}");
    assert_eq!((human.stubbornness, human.discomfort), (last.stubbornness, last.discomfort));
    let off = ticks.iter().filter(|t| t.executed != t.preferred).count();
    assert_eq!(human.steps_off_preference, off as u64);
    assert!(off > 0 && off < ticks.len(), "{off} of {}", ticks.len());
    assert!((human.share_off_preference(steps) - off as f64 / ticks.len() as f64).abs() < 1e-15);
    let switches = ticks.windows(2).filter(|w| w[0].preferred != w[1].preferred).count();
    assert_eq!((human.preference_changes, human.preferred_option_switches as usize), (1, switches));
    assert!(switches > 0);
}

#[test]
fn an_episode_that_is_cut_short_says_so() {
    let settings = EpisodeSettings { tick_limit: Some(5), ..EpisodeSettings::default() };
    let (summary, ticks) = ticks("worlds/environment-4.toml", &settings, EXAMPLE_HUMAN);
    assert_eq!((summary.outcome, ticks.len()), (Outcome::OutOfTime, 5));
}

fn search(worlds: usize, seed: u64) -> Findings {
    let search = Search {
        plant: &Plant::Point,
        settings: &EpisodeSettings::default(),
        worlds,
        seed,
        placed: Placed::AsDrawn,
    };
    search.run(&|| ()).unwrap_or_else(|e| panic!("{e}"))
}

/// Sec. IV-B.2: no locked cycles. `cocarry reproduce cycles` does the same over 10,000 worlds.
#[test]
fn paper_no_locked_cycles_in_random_worlds() {
    let findings = search(1000, 0);
    assert_eq!(findings.lost, []);
    assert!(findings.with_choice > 500, "{} worlds had a choice", findings.with_choice);
    assert!(findings.dropped_soon.len() <= 2, "{:?}", findings.dropped_soon);
    assert!(findings.with_changes > 20 && findings.most_changes <= 8, "{}", findings.most_changes);
}

/// A robot that follows does not change which options a team takes.
#[test]
fn paper_no_locked_cycles_with_a_robot() {
    let robot = cocarry::robot::Robot::built_in().unwrap();
    let plant = Plant::new(PlantKind::Kinematic, RobotSetup::new(&robot));
    let settings = EpisodeSettings::default();
    let placed = Placed::AsDrawn;
    let with_robot = Search { plant: &plant, settings: &settings, worlds: 40, seed: 0, placed };
    let with_robot = with_robot.run(&|| ()).unwrap();
    let point = search(40, 0);
    assert_eq!(with_robot.lost, []);
    assert_eq!(
        (with_robot.with_choice, with_robot.with_changes, with_robot.most_changes),
        (point.with_choice, point.with_changes, point.most_changes)
    );
}

/// Options that are dropped soon after they were taken up: phi grew past one that was best for a step, a gap
/// was crossed, or the perceived length of another one fell faster.
#[test]
fn options_that_are_dropped_soon_have_a_cause() {
    for (seed, cause, options) in [
        (6490, Cause::Stubbornness, ["1", "2", "3"]),
        (8969, Cause::Opening, ["2", "1", "2"]),
        (1571, Cause::Perception, ["1", "2", "1"]),
    ] {
        let findings = search(1, seed);
        let dropped = &findings.dropped_soon[0];
        assert_eq!((dropped.seed, dropped.cause), (seed, cause));
        assert_eq!(dropped.options, options);
        assert!(dropped.dropped - dropped.taken_up <= 5);
    }
}

/// Where A and B are in the open, a team with bodies starts: `cocarry reproduce starts` has 200 such worlds.
#[test]
fn a_team_starts_in_random_rooms() {
    let robot = cocarry::robot::Robot::built_in().unwrap();
    let plant = Plant::new(PlantKind::Rapier, RobotSetup::new(&robot));
    let settings = EpisodeSettings::default();
    let study = starts::StartStudy { plant: &plant, settings: &settings, worlds: 12, seed: 20 };
    let starts = study.run(&|| ()).unwrap();
    assert_eq!(starts.refused, []);
    assert!(starts.arrived >= 11, "{:?}", starts.lost);
}

/// A team that has room to stand but not to turn is told how much is missing, and a start that has it.
#[test]
fn a_refused_start_names_the_room_missing_and_a_start_that_has_it() {
    let robot = cocarry::robot::Robot::built_in().unwrap();
    let plant = Plant::new(PlantKind::Rapier, RobotSetup::new(&robot));
    let settings = EpisodeSettings::default();
    let study = starts::StartStudy { plant: &plant, settings: &settings, worlds: 1, seed: 1199 };
    let starts = study.run(&|| ()).unwrap();
    let [refused] = starts.refused.as_slice() else { panic!("{} refused", starts.refused.len()) };
    let (fault, instead) = refused.reason.split_once("; the nearest start with room is (").unwrap();
    assert!(fault.ends_with("obstacle `north` is too near (0.08 m are missing on either side)"), "{fault}");
    let instead = instead.strip_suffix(")").unwrap();
    let start = |line: &str| match line.starts_with("start_m") {
        true => format!("start_m = [{instead}]\n"),
        false => format!("{line}\n"),
    };
    let world: String = refused.world.lines().map(start).collect();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("elsewhere.toml");
    std::fs::write(&file, world).unwrap();
    let output = cocarry(&["run", file.to_str().unwrap(), "--max-steps", "1"]);
    // out of time, not refused
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
}

/// Worlds in which a team once turned round in every step for ever: the gap behind it counted for one option
/// and not for another.
#[test]
fn issue_a_team_that_turned_round_for_ever_arrives() {
    for seed in [2833, 3926, 5533] {
        let findings = search(1, seed);
        assert_eq!(findings.lost, [], "seed {seed}");
        assert!(findings.most_changes <= 2, "seed {seed}: {} changes", findings.most_changes);
    }
}

/// Random worlds in which a team once stood still: the end of a straight part lay exactly at the clearance,
/// or a line touched an obstacle exactly at an opening, and the way from there was lost or led around through
/// the opening's line.
#[test]
fn issue_no_way_from_the_edge_of_the_clearance() {
    for seed in [510, 2977, 4024, 4297, 4614, 6983, 8428, 9048] {
        let findings = search(1, seed);
        assert_eq!(findings.lost, [], "seed {seed}");
        assert!(findings.longest_detour < 2.0, "seed {seed}: {}", findings.longest_detour);
    }
}
