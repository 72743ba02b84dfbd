//! c_r and eta from what people answered: what was put in comes out, and what is wrong is named.

mod eta;
mod tables;

use crate::support::{cocarry, json, load, repository, stderr, stdout};
use cocarry::episode::prospects;
use cocarry::options::OptionSet;
use cocarry::preference::{Belief, ChoiceDistribution, Predictor};
use cocarry_studies::fit::LEAST_SQUARES_CAUTION;
use cocarry_studies::paper::ENVIRONMENTS;
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
