//! The functions of the WebAssembly module as a host calls them, on this machine.

use crate::support::repository;
use cocarry::geometry::{PlanarPose, Point};
use cocarry::robot::{Configuration, Robot};
use cocarry_web::host::{output, state, write};
use cocarry_web::*;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Files that follow from others are written anew with this variable set.
const UPDATE: &str = "COCARRY_UPDATE_WEB";

fn text() -> String {
    String::from_utf8(output()).expect("UTF-8")
}

fn answer(done: u32) -> Value {
    assert_eq!(done, 1, "{}", text());
    serde_json::from_str(&text()).expect("JSON")
}

fn asked(request: &Value, of: extern "C" fn() -> u32) -> Value {
    write(request.to_string().as_bytes());
    answer(of())
}

fn refused(request: &[u8], of: extern "C" fn() -> u32) -> String {
    write(request);
    assert_eq!(of(), 0, "{}", String::from_utf8_lossy(request));
    text()
}

/// The handle of the episode of these parts.
fn open(parts: &Value) -> u32 {
    let scenario = asked(parts, cocarry_scenario)["scenario"].as_str().unwrap().to_owned();
    write(scenario.as_bytes());
    let handle = cocarry_open();
    assert!(handle > 0, "{}", text());
    handle
}

/// The numbers of a field of the state.
fn part(handle: u32, name: &str) -> Vec<f64> {
    let described = answer(cocarry_describe(handle))["state"].clone();
    let fields = described["fields"].as_array().unwrap();
    let field = fields.iter().find(|field| field["name"] == name).unwrap_or_else(|| panic!("{name}"));
    let [offset, count] = ["offset", "count"].map(|key| field[key].as_u64().unwrap() as usize);
    assert!(!cocarry_state(handle).is_null());
    let numbers = state(handle).unwrap();
    assert_eq!(numbers.len() as u64, described["length"].as_u64().unwrap());
    numbers[offset..offset + count].to_vec()
}

fn digest(handle: u32) -> String {
    assert_eq!(cocarry_digest(handle), 1, "{}", text());
    text()
}

#[test]
fn the_table_of_the_state_is_the_one_in_javascript() {
    let file = repository("crates/web/state.js");
    if std::env::var_os(UPDATE).is_some() {
        std::fs::write(&file, javascript()).unwrap();
    }
    let written = std::fs::read_to_string(&file).unwrap();
    assert!(written == javascript(), "renew state.js: {UPDATE}=1 cargo test --test suite web");
    let readme = std::fs::read_to_string(repository("crates/web/README.md")).unwrap();
    for line in javascript().lines().filter_map(|line| line.trim().strip_prefix("{ name: \"")) {
        let (name, _) = line.split_once('"').unwrap();
        assert!(readme.contains(&format!("\n| `{name}` |")), "README.md does not have {name}");
    }
}

#[test]
fn the_catalogue_has_the_tables_of_the_program() {
    let catalogue = answer(cocarry_catalogue());
    let names = |key: &str| -> Vec<String> {
        let all = catalogue[key].as_array().unwrap().iter();
        all.map(|one| one["name"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(names("worlds").len(), 5);
    assert_eq!(names("robots"), ["carrier", "omni-carrier", "porter", "shuttle"]);
    assert_eq!(names("plants"), ["point", "kinematic", "rapier"]);
    assert!(names("methods").contains(&"follow-hand".to_owned()));
    assert_eq!(catalogue["settings"].as_array().unwrap().len(), cocarry::scenario::SETTINGS.len());
    let eta =
        catalogue["settings"].as_array().unwrap().iter().find(|setting| setting["key"] == "eta").unwrap();
    assert_eq!(
        (&eta["kind"], &eta["least_is_open"], &eta["least"]),
        (&json!("number"), &json!(true), &json!(0.0))
    );
}

#[test]
fn a_world_that_is_dragged_has_options_and_regions() {
    let text = cocarry::world::BuiltInWorld::named("environment-4").unwrap().text;
    let world = asked(&json!({ "text": text, "file": "mine.toml", "regions": true }), cocarry_world);
    let options = world["options"].as_array().unwrap();
    let sum: f64 = options.iter().map(|option| option["probability"].as_f64().unwrap()).sum();
    assert!(options.len() == 4 && (sum - 1.0).abs() < 1e-12, "{options:?}");
    // the areas of the regions are the probabilities of a uniform belief
    let shares = areas(&world["regions"], options.len());
    for (share, option) in shares.iter().zip(options) {
        assert!((share - option["probability"].as_f64().unwrap()).abs() < 1e-3, "{shares:?}");
    }
    // an error has its place
    let bad = text.replacen("robot_width_m", "robot_wdth_m", 1);
    let error = refused(json!({ "text": bad, "file": "mine.toml" }).to_string().as_bytes(), cocarry_world);
    assert!(error.starts_with("mine.toml") && error.contains("robot_wdth_m"), "{error}");
    // the world of a wider robot
    let wide = asked(&json!({ "name": "environment-4", "robot_width_m": 0.6 }), cocarry_world);
    assert_eq!((&wide["is_widened"], &wide["robot_width_m"]), (&json!(true), &json!(0.6)));
    let error = refused(br#"{"name":"environment-4","robot_width_m":1.2}"#, cocarry_world);
    assert!(error.contains("xi1") && error.contains("impassable"), "{error}");
}

/// By option, the area of its regions over that of the plane.
fn areas(regions: &Value, options: usize) -> Vec<f64> {
    let range = |key: &str| [0, 1].map(|i| regions[key][i].as_f64().unwrap());
    let all = (range("alpha")[1] - range("alpha")[0]) * (range("gamma")[1] - range("gamma")[0]);
    let mut areas = vec![0.0; options];
    for region in regions["parts"].as_array().unwrap() {
        let corners = region["outline"].as_array().unwrap();
        let at = |i: usize, k: usize| corners[i % corners.len()][k].as_f64().unwrap();
        let doubled: f64 =
            (0..corners.len()).map(|i| at(i, 0) * at(i + 1, 1) - at(i + 1, 0) * at(i, 1)).sum();
        areas[region["option"].as_u64().unwrap() as usize] += doubled.abs() / 2.0 / all;
    }
    areas
}

#[test]
fn the_regions_have_the_areas_of_p_o_all_along_a_walk() {
    let parts = json!({
        "world": "environment-4", "plant": "point", "alpha": 0.747, "gamma": 0.765, "settings": { "control_period_s": 0.1 },
    });
    let handle = open(&parts);
    let (mut steps, mut joined) = (0, 0);
    // within a planning step, where the page asks, and between two
    while cocarry_period(handle) != 0 {
        let probabilities = part(handle, "option_probability");
        let areas = areas(&answer(cocarry_regions(handle)), probabilities.len());
        for (area, probability) in areas.iter().zip(&probabilities) {
            assert!((area - probability).abs() < 1e-3, "step {steps}: {areas:?}, {probabilities:?}");
        }
        // options that have become one way with another: the first of them would have its area
        let lengths = part(handle, "option_length");
        joined += usize::from((1..lengths.len()).any(|o| lengths[..o].contains(&lengths[o])));
        steps += 1;
    }
    assert!(joined > 20 && steps > 100, "{joined} of {steps} after options became one way");
}

#[test]
fn the_parts_of_the_arithmetic_are_those_that_the_module_is_compared_with() {
    let file = repository("crates/web/test/arithmetic.json");
    let mut parts = answer(cocarry_arithmetic())["parts"].clone();
    // the only part with the system's functions
    assert!(parts.as_object_mut().unwrap().remove("principal inertias").is_some());
    let text = serde_json::to_string_pretty(&parts).unwrap() + "\n";
    if std::env::var_os(UPDATE).is_some() {
        std::fs::write(&file, &text).unwrap();
    } else {
        let there = std::fs::read_to_string(&file).unwrap();
        assert!(there == text, "{text}: renew with {UPDATE}=1 cargo test --test suite web");
    }
}

/// The episode of `crates/web/test/episodes.mjs` that is there for the fallback takes it.
#[test]
fn the_weights_of_the_fallback_need_it() {
    let settings = json!({ "state_weight": 1e6, "input_weight": 1e-6, "control_period_s": 0.05 });
    let parts = json!({ "world": "environment-1", "plant": "kinematic", "settings": settings });
    let scenario = asked(&parts, cocarry_scenario)["scenario"].as_str().unwrap().to_owned();
    let prepared = cocarry::scenario::Scenario::parse(&scenario).unwrap().prepare().unwrap();
    let mut episode = prepared.episode().unwrap();
    while episode.step().is_none() {}
    // a solver of clarabel is made for the first program of each size
    let shown = format!("{episode:?}");
    let mut solvers = shown.split("Qp { sizes: [").skip(1);
    assert!(solvers.any(|sizes| sizes.starts_with(|c: char| c.is_ascii_digit())), "clarabel was not asked");
}

#[test]
fn every_robot_is_drawn_and_is_the_exported_one() {
    for (robot, has_meshes) in
        [("carrier", false), ("omni-carrier", false), ("porter", true), ("shuttle", true)]
    {
        let drawn = asked(&json!({ "robot": robot }), cocarry_robot);
        let links = drawn["links"].as_array().unwrap();
        assert!(links.iter().any(|link| !link["shapes"].as_array().unwrap().is_empty()), "{robot}");
        assert_eq!(!drawn["meshes"].as_array().unwrap().is_empty(), has_meshes, "{robot}");
        let scenario = asked(&json!({ "world": "environment-1", "robot": robot }), cocarry_scenario);
        let scenario = cocarry::scenario::Scenario::parse(scenario["scenario"].as_str().unwrap()).unwrap();
        let ours = scenario.plant.robot_setup().unwrap().robot.robot().unwrap();
        if robot != "carrier" {
            let loaded = Robot::load(&repository(&format!("assets/robots/{robot}.toml"))).unwrap();
            let poses = |robot: &Robot| {
                let base = PlanarPose { position: Point::origin(), yaw: 0.3 };
                robot.link_poses(&Configuration { base, joints: robot.postures[0].joints })
            };
            assert_eq!(poses(&ours), poses(&loaded), "{robot}");
            assert_eq!(ours.footprint, loaded.footprint, "{robot}");
        }
    }
}

#[test]
fn hulls_are_those_of_the_mesh_files() {
    for (name, text) in HULLS {
        let robot = Robot::load(&repository(&format!("assets/robots/{name}.toml"))).unwrap();
        let exact = json!(robot.texts)["hulls"].clone();
        let single: BTreeMap<String, Vec<[f32; 3]>> = serde_json::from_value(exact.clone()).unwrap();
        let widened: BTreeMap<_, Vec<_>> = single
            .iter()
            .map(|(name, hull)| (name, hull.iter().map(|p| p.map(f64::from)).collect()))
            .collect();
        assert_eq!(json!(widened), exact, "{name}: of single precision");
        let hulls = serde_json::to_string(&single).unwrap() + "\n";
        if std::env::var_os(UPDATE).is_some() {
            std::fs::write(repository(&format!("crates/web/robots/{name}.json")), &hulls).unwrap();
        } else {
            assert!(hulls == text, "{name}: renew with {UPDATE}=1 cargo test --test suite web");
        }
    }
}

#[test]
fn steps_periods_and_seconds_come_to_the_same() {
    let parts =
        json!({ "world": "environment-1", "plant": "kinematic", "settings": { "control_period_s": 0.05 } });
    let [by_step, by_period, by_second] = [0; 3].map(|_| open(&parts));
    for _ in 0..10 {
        assert_eq!(cocarry_step(by_step), 2);
    }
    for i in 1..=40 {
        assert_eq!(cocarry_period(by_period), if i % 4 == 0 { 2 } else { 1 }, "{i}");
        assert_eq!(part(by_period, "period"), [f64::from(i % 4)]);
        assert!((part(by_period, "time")[0] - 0.05 * f64::from(i)).abs() < 1e-9);
    }
    assert_eq!((cocarry_run(by_second, 1.9), cocarry_run(by_second, 0.1)), (1, 2));
    let digests = [by_step, by_period, by_second].map(digest);
    assert!(digests[0].len() == 16 && digests.iter().all(|other| *other == digests[0]), "{digests:?}");
    assert_eq!(part(by_step, "links"), part(by_second, "links"));
    assert!(part(by_step, "links").iter().all(|number| number.is_finite()));
    // within a step there is no digest
    assert_eq!(cocarry_period(by_period), 1);
    assert_eq!(cocarry_digest(by_period), 0);
    assert!(text().contains("within a planning step"), "{}", text());
}

#[test]
fn an_episode_tells_its_events_and_its_end() {
    let handle = open(&json!({ "world": "environment-4", "plant": "point", "alpha": 0.747, "gamma": 0.765 }));
    assert_eq!(part(handle, "outcome"), [-1.0]);
    let probabilities: f64 = part(handle, "option_probability").iter().sum();
    assert!((probabilities - 1.0).abs() < 1e-12, "options are there before the first step");
    assert_eq!(cocarry_run(handle, 3600.0), 0);
    assert_eq!(part(handle, "outcome"), [0.0]);
    let events = answer(cocarry_events(handle));
    let about: Vec<&str> = events.as_array().unwrap().iter().map(|e| e["about"].as_str().unwrap()).collect();
    assert_eq!((about.first(), about.last()), (Some(&"episode"), Some(&"end")));
    assert!(about.contains(&"mode"), "{about:?}");
    assert_eq!(answer(cocarry_events(handle)), json!([]));
    let summary = answer(cocarry_summary(handle));
    assert_eq!(summary["outcome"], "arrived");
    assert!(summary["text"].as_str().unwrap().contains("accumulated objective cost"), "{summary}");
    let steps =
        summary["figures"].as_array().unwrap().iter().find(|figure| figure["key"] == "steps").unwrap();
    assert_eq!(steps["value"].as_f64().unwrap(), part(handle, "step")[0]);
    assert_eq!((cocarry_step(handle), cocarry_period(handle)), (0, 0));
}

#[test]
fn decisions_from_outside_change_the_episode_and_its_log_repeats_them() {
    let parts = json!({ "world": "environment-4", "plant": "kinematic", "seed": 1 });
    let (own, steered) = (open(&parts), open(&parts));
    assert!(answer(cocarry_log(own)).get("decisions").is_none());
    assert_eq!(cocarry_human(steered, 0, 2), 1);
    assert_eq!(cocarry_policy(steered, 1, -1), 1);
    for _ in 0..20 {
        assert_eq!((cocarry_step(own), cocarry_step(steered)), (2, 2));
    }
    assert_eq!((part(steered, "mode"), part(steered, "executed")), (vec![1.0], vec![0.0]));
    assert_ne!(digest(own), digest(steered));
    let log = answer(cocarry_log(steered));
    assert_eq!(log["digests"].as_array().unwrap().len(), 4);
    write(log.to_string().as_bytes());
    let again = cocarry_replay();
    assert!(again > 0, "{}", text());
    for _ in 0..20 {
        cocarry_step(again);
    }
    assert_eq!(digest(again), digest(steered));
    assert_eq!(answer(cocarry_log(again)), log);
    // no more of its decisions are repeated than steps are asked for: here none
    let mut none = log.clone();
    none["steps"] = 0.into();
    write(none.to_string().as_bytes());
    let none = cocarry_replay();
    for _ in 0..20 {
        cocarry_step(none);
    }
    assert_eq!(digest(none), digest(own));
    // after the log, decisions from outside are possible again
    assert_eq!(cocarry_human(again, 1, 2), 1);
    cocarry_step(again);
    assert_eq!(part(again, "preferred"), [1.0]);
}

#[test]
fn a_hand_that_is_steered_goes_where_it_is_told_within_its_limits() {
    let settings = json!({ "method": "follow-hand", "control_period_s": 0.05 });
    let handle = open(&json!({ "world": "environment-1", "settings": settings }));
    let begin = part(handle, "hand");
    let limit = part(handle, "hand_limits")[0];
    let mut last = begin.clone();
    for _ in 0..60 {
        assert_eq!(cocarry_hand(handle, begin[0] + 5.0, begin[1]), 1);
        assert!(cocarry_period(handle) > 0);
        let hand = part(handle, "hand");
        // the gait's sway is added to the hand
        let moved = cocarry::math::hypot(hand[0] - last[0], hand[1] - last[1]);
        assert!(moved < 0.05 * limit + 0.01, "{last:?} {hand:?}");
        last = hand;
    }
    assert!(last[0] - begin[0] > 0.5, "{begin:?} {last:?}");
    assert_eq!(part(handle, "hand_target"), [begin[0] + 5.0, begin[1]]);
    assert!(part(handle, "hand_wrench").iter().all(|number| number.is_finite()));
    assert_eq!(cocarry_hand(handle, f64::NAN, 0.0), 1);
    assert!(part(handle, "hand_target")[0].is_nan());
}

#[test]
fn a_snapshot_continues_with_the_same_bits() {
    let handle = open(&json!({ "world": "environment-1", "seed": 3 }));
    assert_eq!(cocarry_run(handle, 2.0), 2);
    assert_eq!(cocarry_snapshot(handle), 1);
    let snapshot = output();
    write(&snapshot);
    let restored = cocarry_restore();
    assert!(restored > 0, "{}", text());
    assert_eq!(digest(restored), digest(handle));
    assert_eq!((cocarry_run(handle, 1.0), cocarry_run(restored, 1.0)), (2, 2));
    assert_eq!(digest(restored), digest(handle));
    assert_eq!(cocarry_log(restored), 0);
    assert!(text().contains("no log"), "{}", text());
    // damaged bytes are refused
    let mut damaged = snapshot.clone();
    damaged[snapshot.len() / 2] ^= 1;
    assert!(refused(&damaged, cocarry_restore).contains("snapshot"));
    assert!(refused(&snapshot[..100], cocarry_restore).contains("snapshot"));
}

#[test]
fn wrong_handles_and_numbers_are_refused_in_a_sentence() {
    let handle = open(&json!({ "world": "environment-1", "plant": "point" }));
    for handle in [0, handle + 1, u32::MAX] {
        assert_eq!((cocarry_step(handle), cocarry_period(handle), cocarry_run(handle, 1.0)), (-1, -1, -1));
        let texts = [
            cocarry_describe,
            cocarry_events,
            cocarry_path,
            cocarry_regions,
            cocarry_summary,
            cocarry_log,
            cocarry_digest,
            cocarry_snapshot,
            cocarry_close,
        ];
        for of in texts {
            assert_eq!(of(handle), 0);
            assert_eq!(text(), format!("{handle} is not the handle of an open episode"));
        }
        assert!(cocarry_state(handle).is_null());
    }
    for (done, words) in [
        (cocarry_human(handle, 99, -1), "option = 99; it must be an index"),
        (cocarry_human(handle, -2, -1), "option = -2"),
        (cocarry_human(handle, 0, 3), "stance = 3"),
        (cocarry_policy(handle, 0, -1), "needs an option"),
        (cocarry_policy(handle, 7, 0), "lead = 7"),
        (cocarry_hand(handle, f64::INFINITY, 0.0), "beyond"),
    ] {
        assert_eq!(done, 0);
        // the last sentence is that of the last call
        assert!(text().contains("beyond") || text().contains(words), "{}", text());
    }
    assert_eq!(cocarry_run(handle, f64::NAN), -1);
    assert!(text().contains("seconds = NaN"), "{}", text());
    assert_eq!(cocarry_run(handle, -1.0), -1);
    assert!(cocarry_input(usize::MAX).is_null());
    assert!(text().contains("bytes"), "{}", text());
    assert_eq!((cocarry_close(handle), cocarry_close(handle)), (1, 0));
    let handles: Vec<u32> =
        (0..64).map(|_| open(&json!({ "world": "environment-1", "plant": "point" }))).collect();
    let scenario = asked(&json!({ "world": "environment-1", "plant": "point" }), cocarry_scenario);
    let error = refused(scenario["scenario"].as_str().unwrap().as_bytes(), cocarry_open);
    assert!(error.contains("64 episodes are open"), "{error}");
    handles.iter().for_each(|handle| assert_eq!(cocarry_close(*handle), 1));
}

#[test]
fn hostile_texts_are_refused_in_a_sentence() {
    let scenario = asked(&json!({ "world": "environment-1" }), cocarry_scenario);
    let scenario = scenario["scenario"].as_str().unwrap().as_bytes();
    let handle = open(&json!({ "world": "environment-1", "plant": "point" }));
    cocarry_human(handle, 1, 2);
    cocarry_run(handle, 3.0);
    let log = answer(cocarry_log(handle)).to_string();
    let request = json!({ "name": "environment-4", "regions": true }).to_string();
    let parts = json!({ "world": "environment-1", "plant": "point", "settings": { "eta": 3 } }).to_string();
    let readers: [(&[u8], extern "C" fn() -> u32, bool); 5] = [
        (scenario, cocarry_open, true),
        (log.as_bytes(), cocarry_replay, true),
        (request.as_bytes(), cocarry_world, false),
        (parts.as_bytes(), cocarry_scenario, false),
        (br#"{"robot":"porter"}"#, cocarry_robot, false),
    ];
    // a small generator, so that a failure repeats
    let mut seed = 7_u64;
    let mut random = |below: usize| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (seed >> 33) as usize % below.max(1)
    };
    for (good, read, opens) in readers {
        for _ in 0..60 {
            let mut bytes = good.to_vec();
            for _ in 0..=random(3) {
                match random(4) {
                    0 => bytes.truncate(random(bytes.len())),
                    1 if !bytes.is_empty() => {
                        let at = random(bytes.len());
                        bytes[at] = random(256) as u8;
                    }
                    2 => {
                        let at = random(bytes.len());
                        bytes.splice(at..at, b"-1e999,NaN".iter().copied());
                    }
                    _ => {
                        let (a, b) = (random(bytes.len()), random(bytes.len()));
                        let part = bytes[a.min(b)..a.max(b)].to_vec();
                        bytes.extend(part);
                    }
                }
            }
            write(&bytes);
            let done = read();
            if done == 0 {
                let sentence = text();
                assert!(!sentence.trim().is_empty(), "{}", String::from_utf8_lossy(&bytes));
            } else if opens {
                assert!(cocarry_run(done, 0.4) >= 0);
                assert_eq!(cocarry_close(done), 1);
            }
        }
    }
    assert!(refused(&[0xff, 0xfe], cocarry_open).contains("UTF-8"));
    assert!(refused(&b"[".repeat(100_000), cocarry_world).contains("not valid"));
}
