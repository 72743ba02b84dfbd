//! The summary of a study against its definitions.

use super::*;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// The table against the definitions, from the rows.
#[test]
fn the_summary_is_that_of_the_rows() {
    let bench = Bench::new(STUDY);
    let told = bench.good(&["study.toml", "--json"]);
    let told: Value = serde_json::from_slice(&told.stdout).expect("JSON");
    let again = bench.good(&["--summary", "study.csv", "--json"]);
    assert_eq!(told, serde_json::from_slice::<Value>(&again.stdout).expect("JSON"));
    let summary = &told["summary"];
    assert_eq!(
        summary["varied"],
        serde_json::json!(["world", "humans", "humans_alpha", "humans_gamma", "eta", "method"])
    );
    assert_eq!(summary["groups"].as_array().map(Vec::len), Some(16));
    let rows = bench.rows("study.csv");
    let costs = |method: &str| -> Vec<f64> {
        let is_of = |row: &&Row| {
            row["world"] == "environment-4"
                && row["eta"] == "5"
                && row["humans"] == "all"
                && row["method"] == method
        };
        let cost = |row: &Row| row["accumulated_objective_cost_m"].parse().expect("a number");
        rows.iter().filter(is_of).map(cost).collect()
    };
    let (mutual, without) = (costs("mutual"), costs("without-model"));
    let is_same = |inputs: &Value| {
        [("world", "environment-4"), ("eta", "5"), ("humans", "all")].iter().all(|(key, v)| inputs[key] == *v)
    };
    let groups = summary["groups"].as_array().expect("groups");
    let group =
        groups.iter().find(|g| is_same(&g["inputs"]) && g["inputs"]["method"] == "mutual").expect("a group");
    let near = |value: &Value, expected: f64| {
        let value = value.as_f64().unwrap_or_else(|| panic!("{value}"));
        assert!((value - expected).abs() <= 1e-9 * expected.abs(), "{value} and {expected}");
    };
    let (mean, std) = mean_and_std(&mutual);
    let estimate = &group["accumulated_objective_cost_m"];
    near(&estimate["mean"], mean);
    near(&estimate["std"], std);
    // t(0.975, 5) = 2.5706
    let half = 2.570_582 * std / 6f64.sqrt();
    assert!((estimate["interval"][1].as_f64().expect("a number") - mean - half).abs() < 1e-5 * half);
    let compared = summary["comparisons"].as_array().expect("comparisons");
    let pair = compared.iter().find(|c| is_same(&c["inputs"])).expect("a comparison");
    assert_eq!((&pair["first"], &pair["second"]), (&"mutual".into(), &"without-model".into()));
    near(&pair["difference"]["mean"], mean - mean_and_std(&without).0);
    let paired = &pair["difference"];
    let differences: Vec<f64> = mutual.iter().zip(&without).map(|(a, b)| a - b).collect();
    let (mean, std) = mean_and_std(&differences);
    let students = StudentsT::new(0.0, 1.0, 5.0).expect("a distribution");
    near(&paired["p_value"], 2.0 * students.sf((mean / std).abs() * 6f64.sqrt()));
    near(&paired["effect_size"], paired["mean"].as_f64().unwrap() / paired["std"].as_f64().unwrap());
    let lower = mutual.iter().zip(&without).filter(|(a, b)| a < b).count();
    near(&pair["share_lower"], lower as f64 / 6.0);
}

/// Holm's correction against its definition, for all comparisons of a summary; humans who are all the same
/// are one outcome.
#[test]
fn comparisons_are_corrected_and_only_made_where_humans_differ() {
    let bench = Bench::new(STUDY);
    let output = bench.good(&["study.toml", "--json"]);
    let told: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let compared = told["summary"]["comparisons"].as_array().expect("comparisons");
    let of = |c: &Value, key: &str| c["difference"][key].as_f64();
    let mut tested: Vec<[f64; 2]> =
        compared.iter().filter_map(|c| Some([of(c, "p_value")?, of(c, "p_holm")?])).collect();
    tested.sort_by(|a, b| a[0].total_cmp(&b[0]));
    assert!(tested.len() > 2);
    let mut largest = 0.0_f64;
    for (i, [p, holm]) in tested.iter().enumerate() {
        largest = largest.max((p * (tested.len() - i) as f64).min(1.0));
        assert_eq!(*holm, largest);
    }
    let mut alike = 0;
    for c in compared.iter().filter(|c| c["inputs"]["humans"] == "same") {
        assert_eq!(c["difference"]["n"], 6);
        for key in ["interval", "effect_size", "p_value", "p_holm"] {
            assert!(c["difference"][key].is_null(), "{c}");
        }
        alike += 1;
    }
    assert_eq!(alike, 4);
    let said = stdout(&bench.good(&["--summary", "study.csv"]));
    let said_of = format!("Holm's method for the {} comparisons tested", tested.len());
    assert!(said.contains(&said_of) && said.contains("all humans make the same choices"), "{said}");
}

/// With bodies, humans who all go the same way still cost differently, by the noise of their gait: that is no
/// sample of humans.
#[test]
fn the_noise_of_the_gait_is_not_tested() {
    let study = r#"worlds = "environment-1"
plants = "rapier"
methods = "human-led"
pose = ["none", "arm"]
seeds = 3
[[human]]
name = "same"
alpha = 0.747
gamma = 0.765
"#;
    let bench = Bench::new(study);
    let output = bench.good(&["study.toml", "--json"]);
    let told: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let compared = told["summary"]["comparisons"].as_array().expect("comparisons");
    let control = compared.iter().find(|c| c["cost"] == "accumulated_control_cost").expect("a comparison");
    let paired = &control["difference"];
    assert!(paired["n"] == 3 && paired["std"].as_f64().expect("noise") > 0.0, "{paired}");
    for key in ["interval", "effect_size", "p_value", "p_holm"] {
        assert!(paired[key].is_null(), "{paired}");
    }
    for group in told["summary"]["groups"].as_array().expect("groups") {
        assert!(
            group["accumulated_control_cost"]["interval"].is_null()
                && group["accumulated_control_cost"]["std"].is_f64()
        );
    }
}

/// The pictures of a study have a mark for every mean, difference and cell of it.
#[test]
fn results_are_drawn() {
    let bench = Bench::new(STUDY);
    bench.good(&["study.toml", "--output", "a.csv"]);
    let plot = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_cocarry"));
        let command = command.arg("plot").args(arguments).current_dir(bench.folder.path());
        command.output().expect("the program starts")
    };
    let drawn = |arguments: &[&str]| {
        let output = plot(&[&["a.csv", "-o", "a.svg", "--overwrite"], arguments].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        String::from_utf8(bench.read("a.svg")).expect("a picture")
    };
    // two worlds, two eta and two kinds of humans; two methods
    let means = drawn(&[]);
    assert_eq!(means.matches("class=\"row\"").count(), 8);
    assert_eq!(means.matches("class=\"mark\"").count(), 16 + 2);
    assert!(means.contains("accumulated objective cost (m)"));
    let differences = drawn(&["--kind", "differences"]);
    assert_eq!(differences.matches("class=\"row\"").count(), 8);
    assert!(differences.contains("environment-1: mutual - without-model"), "{differences}");
    let discomfort = drawn(&["--kind", "differences", "--by", "eta", "--quantity", "final_discomfort"]);
    assert!(discomfort.contains("environment-1: 5 - 10.5"), "{discomfort}");
    let map = drawn(&["--kind", "map", "--quantity", "final_discomfort", "--cells", "5"]);
    assert_eq!(map.matches("class=\"panel\"").count(), 16);
    for (arguments, said) in [
        (&["a.csv", "-o", "a.svg"][..], "--overwrite"),
        (
            &["a.csv", "-o", "b.svg", "--kind", "differences", "--quantity", "accumulated_control_cost"],
            "no differences of `accumulated_control_cost`",
        ),
        (&["a.csv", "-o", "b.svg", "--kind", "differences", "--by", "beta"], "unknown column `beta`"),
        (&["a.csv", "-o", "b.svg", "--quantity", "J"], "accumulated_objective_cost_m"),
        (&["a.csv", "-o", "b.gif"], "expected one of the extensions .svg, .pdf, .png"),
        (&["a.csv", "-o", "b.svg", "--width", "3.5cm"], "expected inches or pixels"),
        (&["a.csv", "-o", "b.svg", "--width", "1in"], "must be from 2in to 20in"),
        (&["study.toml", "-o", "b.svg"], "study.toml"),
        (&["a.csv", "-o", "b.svg", "--quantity", "accumulated_control_cost"], "cannot be drawn"),
    ] {
        let output = plot(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(stderr(&output).contains(said), "{arguments:?}: {}", stderr(&output));
    }
}

/// A picture 3.5 in wide has type of at least 7 pt, as SVG, PDF and PNG.
#[test]
fn results_are_drawn_at_the_width_of_a_column() {
    let bench = Bench::new(STUDY);
    bench.good(&["study.toml", "--output", "a.csv"]);
    let drawn = |kind: &str, file: &str| {
        let arguments = ["plot", "a.csv", "--kind", kind, "-o", file, "--width", "3.5in", "--overwrite"];
        let mut command = Command::new(env!("CARGO_BIN_EXE_cocarry"));
        let output = command.args(arguments).current_dir(bench.folder.path()).output().expect("it starts");
        assert!(output.status.success(), "{}", stderr(&output));
        bench.read(file)
    };
    for kind in ["means", "differences", "map"] {
        let svg = String::from_utf8(drawn(kind, "a.svg")).expect("a picture");
        let number = |text: &str| -> f64 { text.split(['"', ' ', 'i']).next().unwrap().parse().unwrap() };
        let attribute = |name: &str| svg.split(&format!("{name}=\"")).skip(1).map(number).collect::<Vec<_>>();
        assert!(svg.contains(" width=\"3.500in\""), "{kind}");
        let layout: f64 = svg.split_once("viewBox=\"0 0 ").map(|(_, rest)| number(rest)).unwrap();
        let sizes = attribute("font-size");
        assert!(sizes.len() > 10);
        for size in sizes {
            assert!(size * 3.5 * 72.0 / layout >= 7.0, "{kind}: {size} of {layout}");
        }
        // no text leaves the picture
        let texts = svg.split("<text ").skip(1);
        for text in texts.filter(|text| text.contains("text-anchor=\"middle\"")) {
            let x = number(text.split_once(" x=\"").or(text.split_once("x=\"")).unwrap().1);
            assert!(x > 0.0 && x < layout, "{text}");
        }
        let png = drawn(kind, "a.png");
        let image = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
        assert_eq!(image.info().width, 1050);
        // 300 px per inch, so that other programs show it 3.5 in wide
        let resolution = image.info().pixel_dims.expect("a resolution");
        let unit = png::Unit::Meter;
        assert_eq!((resolution.xppu, resolution.yppu, resolution.unit), (11_811, 11_811, unit));
        let aspect = f64::from(image.info().height) / 1050.0;
        let pdf = drawn(kind, "a.pdf");
        let text = String::from_utf8_lossy(&pdf);
        let (_, page) = text.split_once("/MediaBox [0 0 252 ").expect("3.5 in");
        let height: f64 = page.split(']').next().unwrap().parse().unwrap();
        assert!((height / 252.0 - aspect).abs() < 1e-3, "{height} {aspect}");
        assert_eq!(pdf, drawn(kind, "a.pdf"));
    }
}
