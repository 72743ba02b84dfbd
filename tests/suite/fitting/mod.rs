//! c_r and eta from what people answered: what was put in comes out, and what is wrong is named.

use crate::support::{cocarry, json, load, repository, stderr, stdout};
use cocarry::coordination;
use cocarry::episode::{Episode, Settings, prospects, run};
use cocarry::math;
use cocarry::options::OptionSet;
use cocarry::policy::Method;
use cocarry::preference::{Belief, ChoiceDistribution, Predictor};
use cocarry::scenario::{Plant, Scenario};
use cocarry_studies::fit::{Guidance, LEAST_SQUARES_CAUTION};
use cocarry_studies::paper::{ENVIRONMENTS, EXAMPLE_HUMAN};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde_json::Value;
use std::path::{Path, PathBuf};

const TABLE_1: &str = "docs/data/table-1-humans.csv";

struct File {
    _folder: tempfile::TempDir,
    path: PathBuf,
}

impl File {
    fn new(name: &str, text: &str) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("a temporary file");
        Self { _folder: folder, path }
    }

    fn path(&self) -> &str {
        self.path.to_str().expect("UTF-8")
    }
}

fn refused(arguments: &[&str], said: &[&str]) {
    let output = cocarry(arguments);
    let error = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
    assert!(output.stdout.is_empty() && error.starts_with("error: "), "{error}");
    for part in said {
        assert!(error.contains(part), "{part:?} is missing from: {error}");
    }
}

/// Answers of people who behave as the model with this c_r, and a little around it.
fn answers(risk_weight: f64, people: usize, scatter: f64) -> String {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut text = "participant,world,option,percent\n".to_owned();
    for environment in &ENVIRONMENTS {
        let set = OptionSet::new(&environment.world().unwrap(), 10.0).unwrap();
        let mut predictor = Predictor::new(Belief::default(), risk_weight).unwrap();
        let mut choice = ChoiceDistribution::default();
        predictor.predict(&prospects(&set, &set.begin()), &mut choice);
        for person in 0..people {
            let p = choice.probabilities();
            let mut shares: Vec<f64> = p.iter().map(|p| p + scatter * rng.random::<f64>()).collect();
            let sum: f64 = shares.iter().sum();
            shares.iter_mut().for_each(|share| *share *= 100.0 / sum);
            for (option, share) in set.options().iter().zip(shares) {
                text += &format!("person {person},{},{},{share}\n", environment.name, option.name);
            }
        }
    }
    text
}

#[test]
fn closed_form_answers_of_the_model_give_its_risk_weight_back() {
    for risk_weight in [4.0, 10.0, 23.0] {
        let file = File::new("answers.csv", &answers(risk_weight, 2, 0.0));
        let fit = json(&["fit", "risk-weight", file.path(), "--resamples", "40", "--json"]);
        for by in ["least_squares", "likelihood"] {
            let found = fit[by]["risk_weight_m"].as_f64().unwrap();
            assert!((found / risk_weight - 1.0).abs() < 1e-3, "{by}: {found}, not {risk_weight}");
            assert!(fit[by]["fitted"]["largest"].as_f64().unwrap() < 0.01, "{by}");
        }
        assert!(fit["likelihood"]["lapse"].as_f64().unwrap() < 1e-6);
    }
}

#[test]
fn the_likelihood_is_recommended_and_what_least_squares_leave_out_is_said() {
    let arguments = ["fit", "risk-weight", TABLE_1, "--normalise"];
    let said = stdout(&cocarry(&arguments));
    let [first, second] = ["likelihood (recommended)", "least squares"].map(|by| said.find(by).unwrap());
    assert!(first < second && said.contains(LEAST_SQUARES_CAUTION), "{said}");
    let fit = json(&[&arguments[..], &["--json"]].concat());
    assert_eq!(fit["recommended"], "likelihood");
    assert_eq!(fit["least_squares_caution"], LEAST_SQUARES_CAUTION);
}

/// Two options in one world: every c_r from that of the model on gives these answers with lapses of its own.
#[test]
fn a_c_r_that_the_likelihood_does_not_determine_is_not_recommended() {
    let obstacle = |name: &str, y: f64, size: [f64; 2]| {
        format!(
            "[[obstacle]]\nname = \"{name}\"\nshape = \"box\"\ncenter_m = [4.0, {y:?}]\nsize_m = {size:?}\nheight_m = 1.0\n"
        )
    };
    let way = |option: u32, between: &str| {
        format!(
            "[[opening]]\nname = \"xi{option}\"\nbetween = [{between}]\n[[option]]\nname = \"{option}\"\nopenings = [\"xi{option}\"]\n"
        )
    };
    let world = "name = \"two ways\"\nrobot_width_m = 0.5\nstart_m = [0, 1.4]\ntarget_m = [8, 1.4]\n"
        .to_owned()
        + &obstacle("island", 0.0, [0.8, 2.4])
        + &obstacle("north", 52.0, [0.2, 100.0])
        + &obstacle("south", -52.6, [0.2, 100.0])
        + &way(1, "\"island\", \"north\"")
        + &way(2, "\"south\", \"island\"");
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("w.toml"), world).unwrap();
    let (_, set) = load(&folder.path().join("w.toml"));
    let model = |c_r: f64| {
        let mut choice = ChoiceDistribution::default();
        let mut predictor = Predictor::new(Belief::default(), c_r).unwrap();
        predictor.predict(&prospects(&set, &set.begin()), &mut choice);
        choice.probabilities().to_vec()
    };
    let truth = 6.0;
    let p = model(truth);
    assert!(p.len() == 2 && p.iter().all(|p| (0.1..0.9).contains(p)), "{p:?}");
    let mut text = "participant,world,option,percent\n".to_owned();
    for (person, share) in [("a", 0.5), ("b", -0.5)] {
        let off = share * p[0].min(p[1]);
        for (option, p) in set.options().iter().zip([p[0] + off, p[1] - off]) {
            text += &format!("{person},w.toml,{},{}\n", option.name, 100.0 * p);
        }
    }
    let file = folder.path().join("answers.csv");
    std::fs::write(&file, text).unwrap();
    let svg = folder.path().join("fit.svg");
    let arguments = ["fit", "risk-weight", file.to_str().unwrap(), "--svg", svg.to_str().unwrap()];
    let fit = json(&[&arguments[..], &["--json"]].concat());
    assert!(fit["recommended"].is_null(), "{fit}");
    let likelihood = &fit["likelihood"];
    let [low, high] = [0, 1].map(|i| likelihood["undetermined_m"][i].as_f64().unwrap());
    // lapses bring the rarer option nearer to a half: the model must give it less than its share
    let rarer = usize::from(p[1] < p[0]);
    assert!(model(2.0 * truth)[rarer] < p[rarer] && model(0.7 * truth)[rarer] > p[rarer]);
    assert!((low - truth).abs() < 0.01 && high == 1000.0, "{low} to {high}");
    assert!(
        (likelihood["risk_weight_m"].as_f64().unwrap() - truth).abs() < 0.01,
        "the fewest lapses: {likelihood}"
    );
    assert!(
        likelihood["lapse"].as_f64().unwrap() < 1e-3 && likelihood["interval_m"].is_null(),
        "{likelihood}"
    );
    assert_eq!(likelihood["other_optima_m"], Value::Array(Vec::new()));
    assert!(fit["least_squares"]["undetermined_m"].is_null());
    let said = stdout(&cocarry(&[&arguments[..], &["--overwrite"]].concat()));
    let drawn = std::fs::read_to_string(&svg).unwrap();
    let range = format!("does not determine c_r: every c_r from {low:.2} to 1000.00 m");
    for text in [&said, &drawn] {
        assert!(!text.contains("(recommended)") && text.contains("likelihood (undetermined)"), "{text}");
    }
    assert!(said.contains(&range), "{said}");
    assert!(drawn.contains("does not determine"), "{drawn}");
}

#[test]
fn lapses_are_told_from_risk() {
    // a fifth of every answer is spread evenly
    let text = answers(10.0, 3, 0.0);
    let lapsed: Vec<String> = text
        .lines()
        .map(|line| match line.rsplit_once(',').map(|(head, p)| (head, p.parse::<f64>())) {
            Some((head, Ok(percent))) => format!("{head},{}", 0.8 * percent + 5.0),
            _ => line.to_owned(),
        })
        .collect();
    let file = File::new("answers.csv", &lapsed.join("\n"));
    let fit = json(&["fit", "risk-weight", file.path(), "--resamples", "40", "--json"]);
    let likelihood = &fit["likelihood"];
    assert!((likelihood["lapse"].as_f64().unwrap() - 0.2).abs() < 1e-3, "{likelihood}");
    assert!((likelihood["risk_weight_m"].as_f64().unwrap() - 10.0).abs() < 0.01, "{likelihood}");
}

#[test]
fn the_interval_holds_what_was_put_in_and_narrows_with_people() {
    let width = |people: usize| {
        let file = File::new("answers.csv", &answers(10.0, people, 0.3));
        let fit = json(&["fit", "risk-weight", file.path(), "--resamples", "200", "--json"]);
        let ends = fit["likelihood"]["interval_m"].as_array().expect("an interval").clone();
        let [low, high] = [0, 1].map(|i| ends[i].as_f64().unwrap());
        let found = fit["likelihood"]["risk_weight_m"].as_f64().unwrap();
        assert!(low < found && found < high);
        assert!(low < 10.3 && high > 9.7, "{low} to {high}");
        high - low
    };
    let [few, many] = [width(12), width(192)];
    assert!(many < 0.5 * few, "{few} with 12 people, {many} with 192");
}

#[test]
fn a_fit_depends_on_its_seed_and_on_nothing_else() {
    let file = File::new("answers.csv", &answers(10.0, 6, 0.3));
    let fit = |more: &[&str]| {
        let arguments = [&["fit", "risk-weight", file.path(), "--resamples", "60"], more].concat();
        stdout(&cocarry(&arguments))
    };
    assert_eq!(fit(&["--threads", "1"]), fit(&["--threads", "2"]));
    assert_ne!(fit(&["--seed", "1"]), fit(&["--seed", "2"]));
}

#[test]
fn a_world_held_out_is_predicted_not_fitted() {
    let arguments = ["fit", "risk-weight", TABLE_1, "--normalise", "--json"];
    let all = json(&arguments);
    let some = json(&[&arguments[..], &["--validate", "environment-4"]].concat());
    let c = |fit: &Value| fit["least_squares"]["risk_weight_m"].as_f64().unwrap();
    assert_ne!(c(&all), c(&some));
    assert!(all["least_squares"]["held_out"].is_null() && some["least_squares"]["held_out"]["rms"].is_f64());
    let rows = some["rows"].as_array().unwrap();
    let held_out: Vec<&Value> = rows.iter().filter(|r| r["is_held_out"] == true).collect();
    assert_eq!((rows.len(), held_out.len()), (16, 4));
    assert!(held_out.iter().all(|r| r["world"] == "environment-4"));
    refused(
        &[&arguments[..], &["--validate", "environment-5"]].concat(),
        &["environment-5", "environment-1"],
    );
}

#[test]
fn wrong_answers_are_named_by_line() {
    let good = std::fs::read_to_string(repository(TABLE_1)).unwrap();
    let check = |from: &str, to: &str, said: &[&str]| {
        assert_eq!(good.matches(from).count(), 1, "{from:?}");
        let file = File::new("answers.csv", &good.replace(from, to));
        refused(&["fit", "risk-weight", file.path()], &[&["answers.csv"], said].concat());
    };
    let sum = &["sums to 95", "lines 13 to 16", "`mean`", "environment-3", ":16:", "--normalise"];
    check("mean,environment-1,1,5\n", "mean,environment-1,1,5.5\n", sum);
    check("1,2,45", "1,2,many", &[":6:", "percent = \"many\"", "from 0 to 100"]);
    check("1,2,45", "1,2,-45", &[":6:", "percent = \"-45\""]);
    check("1,2,45", "1,2,\"45,0\"", &[":6:", "percent = \"45,0\"", "decimal point"]);
    check("1,2,45", "1,2,", &[":6:", "percent = \"\""]);
    check("1,2,45", "1,7,45", &[":6:", "option = \"7\"", "`1`, `2`, `3`, `4`"]);
    check("1,2,45", "1,1,45", &[":6:", "option `1`", "line 5"]);
    check("1,2,45", "1,2,45,x", &[":6:", "5 fields", "4"]);
    check("environment-1,2,45", "nowhere,2,45", &[":6:", "world = \"nowhere\"", "no such world"]);
    check("mean,environment-2,4,35\n", "", &[":11:", "environment-2", "option `4`", "0 percent included"]);
    check("mean,environment-2,4,35", ",environment-2,4,35", &[":12:", "participant = \"\""]);
    check("option,percent", "option,share", &[":4:", "no column `percent`", "share"]);
    check("option,percent", "option,option", &[":4:", "more than one column `option`"]);
    let empty = File::new("answers.csv", "participant,world,option,percent\n");
    refused(&["fit", "risk-weight", empty.path()], &["answers.csv", "no rows"]);
    refused(&["fit", "risk-weight", "no-such.csv"], &["no-such.csv: cannot be read"]);
}

#[test]
fn sums_off_by_rounding_are_scaled() {
    let good = std::fs::read_to_string(repository(TABLE_1)).unwrap();
    let whole = good.replace("environment-3,4,5", "environment-3,4,9.2");
    let file = File::new("answers.csv", &whole);
    let fit = json(&["fit", "risk-weight", file.path(), "--json"]);
    assert_eq!(fit["scaled"].as_array().unwrap().len(), 0);
    let fit = json(&["fit", "risk-weight", TABLE_1, "--normalise", "--json"]);
    assert_eq!(fit["scaled"][0]["sum_percent"], 95.0);
}

#[test]
fn answers_that_tell_nothing_are_refused() {
    let world = "name = \"w\"\nrobot_width_m = 0.5\nstart_m = [0, 0]\ntarget_m = [9, 0]\n";
    let file = File::new("answers.csv", "participant,world,option,percent\na,w.toml,1,100\n");
    std::fs::write(file.path.with_file_name("w.toml"), world).unwrap();
    refused(&["fit", "risk-weight", file.path()], &["do not determine c_r", "0.1 to 1000 m"]);
}

/// The step at which a human of this eta takes over from a robot that knows it.
fn transition(set: &OptionSet, eta: f64) -> Option<u64> {
    let coordination = coordination::Settings { eta, ..coordination::Settings::default() };
    let settings = Settings { coordination, method: Method::MUTUAL, ..Settings::default() };
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
                Guidance::along_option(&set, &Settings::default(), o)
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
    let settings = Settings { method: Method::ROBOT_LED, ..Settings::default() };
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
        let stage = Scenario::new(world.into(), Plant::Point).prepare().unwrap();
        let guidance = Guidance::mutual(&stage).unwrap();
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

#[test]
fn pictures_of_fits_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let switches = File::new("switches.csv", "participant,world,option,step\na,environment-4,1,40\n");
    let cases = [
        (vec!["fit", "risk-weight", TABLE_1, "--normalise"], "recommended"),
        (vec!["fit", "eta", switches.path()], "participant"),
    ];
    for (arguments, said) in cases {
        let path = folder.path().join("fit.svg");
        let output = cocarry(&[&arguments[..], &["--overwrite", "--svg", path.to_str().unwrap()]].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        assert!(std::fs::read_to_string(&path).unwrap().contains(said));
    }
    let missing = Path::new("/no-such-folder/fit.svg");
    let output = cocarry(&["fit", "eta", switches.path(), "--svg", missing.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(4));
}

#[test]
fn worlds_lie_beside_the_file_that_names_them() {
    let (_, set) = load(&repository("worlds/free-form.toml"));
    let mut text = "participant,world,option,percent\n".to_owned();
    let n = set.options().len();
    for (o, option) in set.options().iter().enumerate() {
        text += &format!("a,mine.toml,{},{}\n", option.name, if o == 0 { 100 - 5 * (n - 1) } else { 5 });
    }
    let file = File::new("answers.csv", &text);
    std::fs::copy(repository("worlds/free-form.toml"), file.path.with_file_name("mine.toml")).unwrap();
    let output = cocarry(&["fit", "risk-weight", file.path()]);
    assert!(output.status.success(), "{}", stderr(&output));
}
