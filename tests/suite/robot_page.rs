//! The page of `robot check --render`: every link, posture and colliding shape; the rules of output files.

use crate::starting::{run_in, succeeds};
use crate::support::{repository, stderr};
use cocarry::robot::{Robot, Shape};
use serde_json::Value;
use std::path::Path;

fn page(folder: &Path, robot: &Path) -> Value {
    let robot = robot.display().to_string();
    let said = succeeds(folder, &["robot", "check", &robot, "--render", "page.html", "--overwrite"]);
    assert!(said.ends_with("\nwrote page.html\n"), "{said}");
    let page = std::fs::read_to_string(folder.join("page.html")).expect("a page");
    assert!(page.contains("default-src 'none'; script-src 'unsafe-inline'"));
    let (_, rest) = page.split_once("id=\"episode\">").expect("its data");
    serde_json::from_str(rest.split_once("</script>").expect("its end").0).expect("JSON")
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|v| v.as_f64().expect("a number")).collect()
}

#[test]
fn a_robots_page_has_every_link_posture_and_colliding_shape() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for name in ["carrier", "omni-carrier", "porter", "shuttle"] {
        let file = repository("assets/robots").join(format!("{name}.toml"));
        let robot = Robot::load(&file).unwrap_or_else(|e| panic!("{e}"));
        let shown = page(folder.path(), &file);
        let links = shown["robot"].as_array().expect("links");
        assert_eq!(links.len(), robot.links.len());
        let times = numbers(&shown["frames"]["time_s"]);
        for (i, (link, drawn)) in robot.links.iter().zip(links).enumerate() {
            assert_eq!(drawn["name"], link.name.as_str());
            assert_eq!(
                drawn["shapes"].as_array().expect("shapes").len(),
                link.visuals.len(),
                "{}",
                link.name
            );
            let collisions = drawn["collisions"].as_array().expect("shapes");
            assert_eq!(collisions.len(), link.collisions.len(), "{}", link.name);
            for (drawn, shape) in collisions.iter().zip(&link.collisions) {
                if let Shape::Mesh { hull, .. } = &shape.shape {
                    assert_eq!(drawn["hull"].as_array().expect("a hull").len(), hull.len(), "{}", link.name);
                }
            }
            assert_eq!(shown["frames"]["links"][i].as_array().expect("poses").len(), 7 * times.len());
        }
        let postures: Vec<&str> = shown["events"]
            .as_array()
            .expect("postures")
            .iter()
            .filter_map(|e| e["sentence"].as_str())
            .collect();
        assert_eq!(postures, robot.postures.iter().map(|p| p.name.as_str()).collect::<Vec<_>>());
        // the grasp and the joints are in the posture at its time
        for (posture, begin) in robot.postures.iter().zip(numbers(&shown["steps"]["decided_s"])) {
            let frame = times.iter().position(|time| *time == begin).expect("its frame");
            let grasp = robot.drive_from_grasp(&posture.joints).translation;
            let drawn = numbers(&shown["frames"]["object"]);
            let off = (0..3).map(|k| (drawn[7 * frame + k] - grasp.vector[k]).abs()).fold(0.0, f64::max);
            assert!(off < 1e-4, "{name}, {}: {off}", posture.name);
            let at = numbers(&shown["postures"]["at"][frame]);
            assert_eq!(at, posture.joints.as_slice()[..robot.joint_count()]);
        }
        assert!(times.windows(2).all(|pair| pair[0] < pair[1]), "{name}");
        let joints = shown["postures"]["joints"].as_array().expect("joints");
        assert_eq!(joints.len(), robot.joint_count());
        assert_eq!(joints[0]["upper"].is_null(), !robot.joints[0].upper.is_finite());
    }
}

/// What stands in for a shape that is missing is on the page, and a mesh that is missing is not.
#[test]
fn a_robots_page_shows_what_stands_in() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    succeeds(folder.path(), &["export", "porter"]);
    for mesh in ["base.stl", "upper_arm.stl", "upper_arm_white.obj"] {
        std::fs::remove_file(folder.path().join("porter").join(mesh)).expect("removed");
    }
    let shown = page(folder.path(), &folder.path().join("porter.toml"));
    let link = |name: &str| {
        let links = shown["robot"].as_array().expect("links");
        links.iter().find(|link| link["name"] == name).cloned().expect("the link")
    };
    let has = |name: &str, shape: &str| {
        link(name)["collisions"].as_array().expect("shapes").iter().any(|s| s.get(shape).is_some())
    };
    assert!(has("base_link", "cylinder") && !has("base_link", "hull"), "{}", link("base_link"));
    assert!(has("upper_arm_link", "capsule"), "{}", link("upper_arm_link"));
    assert_eq!(link("upper_arm_link")["shapes"].as_array().expect("shapes").len(), 1);
    let remarks = shown["postures"]["remarks"].to_string();
    assert!(remarks.contains("capsule") && remarks.contains("cylinder"), "{remarks}");
}

#[test]
fn a_robots_page_replaces_nothing_and_needs_a_valid_robot() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    succeeds(folder.path(), &["export", "carrier"]);
    let refused = |arguments: &[&str], said: &str| {
        let output = run_in(folder.path(), &[&["robot", "check"], arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        assert!(stderr(&output).contains(said), "{}", stderr(&output));
    };
    refused(&["carrier.toml", "--render", "page.png"], ".html");
    std::fs::write(folder.path().join("page.html"), "mine").expect("a file");
    refused(&["carrier.toml", "--render", "page.html"], "exists already");
    assert_eq!(std::fs::read(folder.path().join("page.html")).expect("a file"), b"mine");
    // the inputs are never replaced, whatever they are called
    for (input, end) in [("carrier.urdf", "urdf"), ("carrier.toml", "toml")] {
        let page = folder.path().join(format!("{end}.html"));
        std::fs::hard_link(folder.path().join(input), &page).expect("a link");
        let before = std::fs::read(&page).expect("a file");
        refused(&["carrier.toml", "--render", &format!("{end}.html"), "--overwrite"], "is an input");
        assert_eq!(std::fs::read(&page).expect("a file"), before);
    }
    let text = std::fs::read_to_string(folder.path().join("carrier.toml")).expect("text");
    std::fs::write(folder.path().join("bad.toml"), text.replace("grasp_link", "missing")).expect("a file");
    refused(&["bad.toml", "--render", "new.html"], "missing");
    assert!(!folder.path().join("new.html").exists());
}
