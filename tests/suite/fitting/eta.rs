//! eta from the steps at which people take over.

use super::{File, refused};
use crate::support::{cocarry, json, stdout};
use cocarry::coordination;
use cocarry::episode::{Episode, EpisodeSettings, run};
use cocarry::math;
use cocarry::options::OptionSet;
use cocarry::policy::Method;
use cocarry::scenario::{Plant, Scenario};
use cocarry_studies::fit::Guidance;
use cocarry_studies::paper::{ENVIRONMENTS, EXAMPLE_HUMAN};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde_json::Value;

/// The step at which a human of this eta takes over from a robot that knows it.
fn transition(set: &OptionSet, eta: f64) -> Option<u64> {
    let coordination =
        coordination::StubbornnessSettings { eta, ..coordination::StubbornnessSettings::default() };
    let settings = EpisodeSettings { coordination, method: Method::MUTUAL, ..EpisodeSettings::default() };
    run(set, &settings, EXAMPLE_HUMAN, |_| ()).transition.map(|t| t.step)
}

fn step(step: Option<u64>) -> String {
    step.map_or(String::new(), |step| step.to_string())
}

fn interval(participant: &Value) -> [f64; 2] {
    let ends = participant["interval"].as_array().expect("an interval");
    [ends[0].as_f64().unwrap(), ends[1].as_f64().unwrap_or(f64::INFINITY)]
}

#[test]
fn eta_of_simulated_participants_lies_in_their_intervals() {
    let etas = [1.2, 3.0, 5.0, 7.3, 10.5, 15.0, 22.0, 90.0];
    let mut text = "participant,world,method,step\n".to_owned();
    for environment in &ENVIRONMENTS {
        let set = OptionSet::new(&environment.world().unwrap(), 10.0).unwrap();
        for eta in etas {
            text += &format!("{eta},{},mutual,{}\n", environment.name, step(transition(&set, eta)));
        }
    }
    let file = File::new("switches.csv", &text);
    let fit = json(&["fit", "eta", file.path(), "--json"]);
    let participants = fit["participants"].as_array().unwrap();
    assert_eq!(participants.len(), etas.len());
    for (eta, found) in etas.into_iter().zip(participants) {
        let [low, high] = interval(found);
        assert!(low <= eta && eta <= high, "{eta} is not in {low} to {high}");
        let is_censored = found["evidence"] == "censored";
        // with these, nobody switches before all ways are one
        assert_eq!(is_censored, eta >= 22.0, "{found}");
        assert!(is_censored || high / low < 1.1, "{eta}: {low} to {high}");
        assert!(found["eta"].as_f64().is_none_or(|e| (e / eta - 1.0).abs() < 0.05), "{found}");
    }
    // half of them have at most 7.3
    let median = fit["overall"]["median"].as_f64().unwrap();
    assert!((6.0..13.0).contains(&median), "{median}");
}

#[test]
fn eta_is_recovered_from_videos_of_single_options() {
    // phi(k) passes 1 for eta in a video: g(k) itself, by the same steps as the paper's eq. (5)
    let mut text = "participant,world,option,step\n".to_owned();
    let etas = [2.0, 6.5, 11.0, 40.0];
    for environment in &ENVIRONMENTS {
        let set = OptionSet::new(&environment.world().unwrap(), 10.0).unwrap();
        for (o, option) in set.options().iter().enumerate() {
            let Some(Guidance::Option { discomfort, .. }) =
                Guidance::along_option(&set, &EpisodeSettings::default(), o)
            else {
                panic!("{} has no way", option.name)
            };
            for eta in etas {
                let switch = discomfort.iter().position(|g| 0.1 * math::exp(g / eta) > 1.0);
                let switch = step(switch.map(|k| k as u64));
                text += &format!("{eta},{},{},{switch}\n", environment.name, option.name);
            }
        }
    }
    let file = File::new("switches.csv", &text);
    let fit = json(&["fit", "eta", file.path(), "--json"]);
    for (eta, found) in etas.into_iter().zip(fit["participants"].as_array().unwrap()) {
        let [low, high] = interval(found);
        assert!(low <= eta * (1.0 + 1e-12) && eta <= high * (1.0 + 1e-12), "{eta}: {low} to {high}");
        assert_eq!(found["evidence"], "bounded");
        assert!(high / low < 1.1, "{eta}: {low} to {high}");
    }
}

#[test]
fn the_discomfort_of_a_video_is_that_of_an_episode() {
    let settings = EpisodeSettings { method: Method::ROBOT_LED, ..EpisodeSettings::default() };
    let mut compared = 0;
    for environment in &ENVIRONMENTS {
        let set = OptionSet::new(&environment.world().unwrap(), 10.0).unwrap();
        let mut episode = Episode::new(&set, &settings, EXAMPLE_HUMAN);
        let mut ticks = Vec::new();
        while episode.step().is_none() {
            ticks.push(episode.tick().clone());
        }
        if episode.summary().option_changes > 0 {
            continue;
        }
        let option = episode.summary().first_option;
        let Some(Guidance::Option { discomfort, .. }) = Guidance::along_option(&set, &settings, option)
        else {
            panic!("no way")
        };
        let expected: Vec<f64> = ticks.iter().map(|t| t.discomfort).collect();
        assert_eq!(discomfort, expected, "{}", environment.name);
        compared += 1;
    }
    assert!(compared > 0);
}

#[test]
fn participants_who_contradict_themselves_scatter() {
    let text = "participant,world,option,step,trial\n\
        a,environment-4,1,30,1\na,environment-4,1,60,2\na,environment-4,1,45,3\na,environment-4,1,50,4\n";
    let fit = json(&["fit", "eta", File::new("switches.csv", text).path(), "--json"]);
    let found = &fit["participants"][0];
    assert_eq!((&found["evidence"], &fit["is_scattered"]), (&"scattered".into(), &true.into()));
    let bounds = found["bounds"].as_array().unwrap();
    let middle = |i: usize| (bounds[i][0][0].as_f64().unwrap() + bounds[i][0][1].as_f64().unwrap()) / 2.0;
    let [low, high] = interval(found);
    let eta = found["eta"].as_f64().unwrap();
    assert!(middle(0) < eta && eta < middle(1), "{found}");
    assert!(low < eta && eta < high && low < middle(2) && middle(2) < high, "{found}");
}

#[test]
fn what_the_switches_do_not_determine_is_said_in_text_json_and_picture() {
    // nine who never switched in a short world, and one switch in a long one
    let mut text = "participant,world,option,step,trial\nten,environment-4,1,70,1\n".to_owned();
    for person in 0..9 {
        text += &format!("{person},environment-4,3,,1\n");
    }
    // too few episodes for an interval of somebody whose eta scatters
    for (participant, reasons) in [
        ("", vec!["1 of 10 bounded on both sides, at least 2 needed"]),
        (
            "s,environment-4,1,30,1\ns,environment-4,1,60,2\n",
            vec!["episodes: 2; a 95 % interval needs at least 4"],
        ),
    ] {
        let file = File::new("switches.csv", &(text.clone() + participant));
        let fit = json(&["fit", "eta", file.path(), "--json"]);
        let picture = file.path.with_file_name("fit.svg");
        let said = stdout(&cocarry(&["fit", "eta", file.path(), "--svg", picture.to_str().unwrap()]));
        for reason in reasons {
            assert!(said.contains(reason) && said.contains("not determined"), "{said}");
            assert!(fit.to_string().contains(reason.trim_start_matches("episodes: ")), "{fit}");
        }
        if participant.is_empty() {
            assert!(
                fit["overall"].is_null()
                    && fit["median_interval"].is_null()
                    && said.contains("All: the median")
            );
            let picture = std::fs::read_to_string(&picture).unwrap();
            assert!(picture.contains("not determined: participants: 1 of 10"), "{picture}");
        } else {
            assert!(fit["participants"][10]["interval"].is_null());
        }
    }
}

/// The set of a step is compared with a scan a hundred times finer than the one that used to find its ends.
#[test]
fn golden_no_eta_that_switches_at_a_step_is_missed() {
    for environment in [&ENVIRONMENTS[0], &ENVIRONMENTS[3]] {
        let world = environment.world().unwrap();
        let set = OptionSet::new(&world, 10.0).unwrap();
        let prepared = Scenario::new(world.into(), Plant::Point).prepare().unwrap();
        let guidance = Guidance::mutual(&prepared).unwrap();
        let Guidance::Mutual { pieces, .. } = &guidance else { panic!("not mutual") };
        assert!(pieces.windows(2).all(|p| p[0].upper == p[1].lower && p[0].lower < p[0].upper));
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        for _ in 0..2000 {
            let eta = math::exp(rng.random_range(-1.0..4.2));
            let step = transition(&set, eta);
            let holds = guidance.etas(step).iter().any(|[low, high]| *low <= eta && eta < *high);
            assert!(holds, "{}: {eta} switches at {step:?}", environment.name);
        }
    }
}

#[test]
fn who_never_switches_has_a_lower_bound_only() {
    let text = "participant,world,option,step\na,environment-4,1,\n";
    let file = File::new("switches.csv", text);
    let fit = json(&["fit", "eta", file.path(), "--json"]);
    let found = &fit["participants"][0];
    assert_eq!(found["evidence"], "censored");
    assert!(found["eta"].is_null() && fit["overall"].is_null());
    assert!(found["interval"][0].as_f64().unwrap() > 5.0 && found["interval"][1].is_null());
    assert!(stdout(&cocarry(&["fit", "eta", file.path()])).contains("at least"));
}

#[test]
fn a_switch_without_discomfort_is_left_out_and_said_so() {
    let text = "participant,world,option,step\na,environment-4,3,0\na,environment-4,1,40\n";
    let fit = json(&["fit", "eta", File::new("switches.csv", text).path(), "--json"]);
    assert_eq!(fit["unexplained_lines"], serde_json::json!([2]));
    assert_eq!(fit["participants"][0]["unexplained"], 1);
    assert_eq!(fit["participants"][0]["evidence"], "bounded");
}

#[test]
fn wrong_switches_are_named_by_line() {
    let good = "participant,world,option,method,step\na,environment-4,1,,40\nb,environment-1,,mutual,\n";
    let check = |from: &str, to: &str, said: &[&str]| {
        assert_eq!(good.matches(from).count(), 1, "{from:?}");
        let file = File::new("switches.csv", &good.replace(from, to));
        refused(&["fit", "eta", file.path()], &[&["switches.csv"], said].concat());
    };
    assert!(cocarry(&["fit", "eta", File::new("switches.csv", good).path()]).status.success());
    check("1,,40", "1,,4.5", &[":2:", "step = \"4.5\"", "whole number"]);
    check("1,,40", "1,,4000", &[":2:", "step = \"4000\"", "at most", "option 1"]);
    check("mutual,\n", "mutual,4000\n", &[":3:", "step = \"4000\"", "mutual in environment-1"]);
    check("1,,40", "9,,40", &[":2:", "option = \"9\"", "`1`, `2`"]);
    check("1,,40", ",,40", &[":2:", "option = \"\""]);
    check("1,,40", "1,mutual,40", &[":2:", "method = \"mutual\"", "empty"]);
    check("mutual", "human-led", &[":3:", "method = \"human-led\"", "mutual"]);
    check("environment-1", "environment-9", &[":3:", "environment-9", "no such world"]);
    check("b,environment-1,,mutual,", "a,environment-4,1,,50", &[":3:", "line 2", "trial"]);
    check("method,step", "method,k", &[":1:", "no column `step`"]);
    let file = File::new("switches.csv", good);
    refused(&["fit", "eta", file.path(), "--initial-stubbornness", "1"], &["less than 1"]);
}
