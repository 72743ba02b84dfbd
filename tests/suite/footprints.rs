//! Bases that are no discs: `base_footprint` of robot files, against parry and in episodes.

use crate::spoiled_robot::{Files, TOML, URDF, original};
use crate::support::{cocarry, repository, stdout};
use cocarry::geometry::{Footprint, Placed, PlanarPose, Point};
use cocarry::math;
use cocarry::robot::Robot;
use parry3d::math::{Pose, Vec3};
use parry3d::query::{contact, distance};
use parry3d::shape::ConvexPolyhedron;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::path::{Path, PathBuf};

const WIDTH: &str = "base_width_m = 0.5";
const CYLINDER: &str = "<geometry><cylinder radius=\"0.25\" length=\"0.36\"/></geometry>";
const BOX: &str = "<geometry><box size=\"0.9 0.5 0.36\"/></geometry>";

fn footprint(value: &str) -> String {
    format!("{WIDTH}\nbase_footprint = {value}")
}

fn corners(robot: &Robot) -> &[Point] {
    let Footprint::Polygon(corners) = &robot.footprint else { panic!("a disc") };
    corners
}

/// The carrier (or its like on mecanum wheels) on a base of 0.9 m by 0.5 m, with its own outline or with a
/// disc.
fn long(name: &str, folder: &Path, is_disc: bool) -> PathBuf {
    let urdf = original(&format!("{name}.urdf"));
    assert_eq!(urdf.matches(CYLINDER).count(), 2);
    std::fs::write(folder.join(format!("{name}.urdf")), urdf.replace(CYLINDER, BOX)).expect("a file");
    let toml = original(&format!("{name}.toml")).replace("assets/robots/", "");
    let toml = if is_disc { toml } else { toml.replace(WIDTH, &footprint("\"collision\"")) };
    let file = folder.join(format!("{name}.toml"));
    std::fs::write(&file, toml).expect("a file");
    file
}

#[test]
fn without_the_key_a_base_is_a_disc() {
    let robot = Robot::built_in().unwrap();
    assert_eq!(robot.footprint, Footprint::Disc { center: Point::origin(), radius: 0.25 });
    assert_eq!((robot.width(), robot.drive.base_radius), (0.5, 0.25));
}

/// In any order, with corners inside, and integers.
#[test]
fn closed_form_corners_give_their_hull() {
    let list = "[[0.5, 0.25], [-0.4, -0.25], [0.1, 0.0], [-0.4, 0.25], [0.5, -0.25], [0, 0]]";
    let robot = Files::new().with(TOML, WIDTH, &footprint(list)).load(TOML).expect("a robot");
    let expected = [(-0.4, -0.25), (0.5, -0.25), (0.5, 0.25), (-0.4, 0.25)];
    assert_eq!(corners(&robot), expected.map(|(x, y)| Point::new(x, y)));
    assert_eq!((robot.width(), robot.footprint_across()), (0.5, 0.5));
    assert!((robot.drive.base_radius - math::hypot(0.5, 0.25)).abs() < 1e-15);
}

/// A box next to the axle, and a disc with its wheels inside: no shape stands out, and no corner by more than
/// 2 mm and what a polygon of 24 corners takes.
#[test]
fn closed_form_the_footprint_around_collision_shapes() {
    let urdf = original(URDF).replace(CYLINDER, "<geometry><box size=\"0.9 0.5 0.36\"/></geometry>");
    let mut files = Files::new().with(TOML, WIDTH, &footprint("\"collision\""));
    files.urdf = urdf.replacen(
        "<origin xyz=\"0 0 0.21\"/>\n      <geometry><box",
        "<origin xyz=\"0.1 0 0.21\"/>\n      <geometry><box",
        2,
    );
    let robot = files.load(TOML).expect("a robot");
    let expected = [(-0.35, -0.25), (0.55, -0.25), (0.55, 0.25), (-0.35, 0.25)];
    let found = corners(&robot);
    assert_eq!(found.len(), 4, "{found:?}");
    for (found, (x, y)) in found.iter().zip(expected) {
        assert!((found - Point::new(x, y)).norm() < 1e-9, "{found}");
    }
    let round = Files::new().with(TOML, WIDTH, &footprint("\"collision\"")).load(TOML).expect("a robot");
    for corner in corners(&round) {
        let out = corner.coords.norm() - 0.25;
        assert!((0.0..0.005).contains(&out), "{corner}");
    }
    for i in 0..360 {
        let at = Point::from(cocarry::geometry::direction(f64::from(i).to_radians()) * 0.25);
        assert!(round.footprint.separation(at).0 < 1e-9, "{at}");
    }
}

#[test]
fn a_base_without_shapes_collides_as_its_corners() {
    let files = Files::new().without_base_shapes();
    let list = footprint("[[0.5, 0.25], [-0.4, -0.25], [-0.4, 0.25], [0.5, -0.25]]");
    let robot = files.with(TOML, WIDTH, &list).load(TOML).expect("a robot");
    let said: Vec<String> = robot.warnings.iter().map(ToString::to_string).collect();
    assert!(
        said.iter().any(|note| note.ends_with("the base collides as its base_footprint, 0.3 m high")),
        "{said:?}"
    );
    let extent = robot.base_extent().expect("a shape");
    assert!((extent - math::hypot(0.5, 0.25)).abs() < 1e-9, "{extent}");
}

/// Parry's distances and depths of prisms, which reach 10 m up and down so that they overlap sidewards.
#[test]
fn property_separations_of_footprints_agree_with_parry() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let polygon = |rng: &mut ChaCha8Rng| loop {
        let corner = |_| Point::new(rng.random_range(-0.6..0.6), rng.random_range(-0.5..0.5));
        let hull = cocarry::geometry::convex_hull(&(0..8).map(corner).collect::<Vec<_>>());
        if hull.len() >= 3 {
            return hull;
        }
    };
    let solid = |corners: &[Point]| {
        let ends = [-10.0, 10.0].into_iter();
        let points = ends.flat_map(|z| corners.iter().map(move |c| Vec3::new(c.x, c.y, z)));
        ConvexPolyhedron::from_convex_hull(&points.collect::<Vec<_>>()).expect("a prism")
    };
    let [mut apart, mut deep] = [0, 0];
    for _ in 0..300 {
        let [base, other] = [polygon(&mut rng), polygon(&mut rng)];
        let at = PlanarPose {
            position: Point::new(rng.random_range(-1.5..1.5), rng.random_range(-1.5..1.5)),
            yaw: rng.random_range(-3.0..3.0),
        };
        let solids = [&base, &other].map(|corners| solid(corners));
        let placed = Pose::new(Vec3::new(at.position.x, at.position.y, 0.0), Vec3::new(0.0, 0.0, at.yaw));
        let [base, other] = [base, other].map(Footprint::Polygon);
        let found = Placed::new(&base, &at).separation(&other);
        if found.distance > 0.0 {
            let parry = distance(&placed, &solids[0], &Pose::IDENTITY, &solids[1]).expect("supported");
            let parry = parry.distance;
            assert!((found.distance - parry).abs() < 1e-5, "{found:?} {parry}");
            apart += 1;
        } else {
            let parry = contact(&placed, &solids[0], &Pose::IDENTITY, &solids[1], 0.0).expect("supported");
            let parry = parry.expect("a contact").dist;
            assert!((found.distance - parry).abs() < 1e-4, "{found:?} {parry}");
            deep += 1;
        }
    }
    assert!(apart > 60 && deep > 60, "{apart} {deep}");
}

fn check_text(file: &Path) -> String {
    stdout(&cocarry(&["robot", "check", &file.display().to_string()]))
}

#[test]
fn robot_check_tells_the_footprint_and_one_that_is_too_wide() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = long("carrier", folder.path(), false);
    let said = check_text(&file);
    assert!(
        said.contains("base   0.50 m wide and 0.90 m long, a polygon of 4 corners for clearances"),
        "{said}"
    );
    assert!(!said.contains("base_footprint"), "{said}");
    let json = stdout(&cocarry(&["robot", "check", &file.display().to_string(), "--json"]));
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!(json["base"]["footprint_m"].as_array().expect("corners").len(), 4);
    let text = std::fs::read_to_string(&file).expect("text").replace(WIDTH, "base_width_m = 0.4");
    std::fs::write(&file, text).expect("a file");
    let said = check_text(&file);
    assert!(said.contains("base_width_m = 0.4, but base_footprint is 0.50 m wide"), "{said}");
}

/// A draft has the polygon where the disc about the axle is much wider; else the disc.
#[test]
fn a_draft_of_a_long_base_has_its_footprint() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let draft = |urdf: &Path| {
        let (urdf, file) = (urdf.display().to_string(), folder.path().join("draft.toml"));
        stdout(&cocarry(&["robot", "init", &urdf, "-o", &file.display().to_string(), "--overwrite"]));
        std::fs::read_to_string(file).expect("a draft")
    };
    let said = draft(&long("carrier", folder.path(), false).with_extension("urdf"));
    assert!(said.contains("base_width_m = 0.50\nbase_footprint = \"collision\"\n"), "{said}");
    let said = draft(&repository("assets/robots/carrier.urdf"));
    assert!(!said.contains("base_footprint") && said.contains("base_width_m = 0.50"), "{said}");
}

fn outcomes(folder: &Path, robots: &[PathBuf], worlds: &[&str], plants: &[&str]) -> Vec<(String, f64)> {
    let (study, out) = (folder.join("study.toml"), folder.join("rows.csv"));
    let robots: Vec<String> = robots.iter().map(|file| file.display().to_string()).collect();
    let text = format!("worlds = {worlds:?}\nplants = {plants:?}\nrobots = {robots:?}\nseeds = 2\n");
    std::fs::write(&study, text).expect("a file");
    let [study, out] = [study, out].map(|file| file.display().to_string());
    cocarry(&["sweep", &study, "--output", &out, "--overwrite"]);
    let mut rows = csv::Reader::from_path(&out).expect("rows");
    let of = |row: std::collections::BTreeMap<String, String>| {
        let clearance = row["least_base_clearance_m"].parse().expect("a number");
        (row["outcome"].clone(), clearance)
    };
    rows.deserialize().map(|row| of(row.expect("a row"))).collect()
}

/// 0.9 m by 0.5 m on two wheels and on four mecanum wheels, round corners and through openings.
#[test]
fn a_base_that_is_longer_than_wide_arrives_without_touching_anything() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let robots = ["carrier", "omni-carrier"].map(|name| long(name, folder.path(), false));
    let worlds = ["environment-1", "environment-2", "environment-3", "environment-4"];
    let rows = outcomes(folder.path(), &robots, &worlds, &["kinematic", "rapier"]);
    assert_eq!(rows.len(), 32);
    for (outcome, clearance) in rows {
        assert_eq!(outcome, "arrived");
        assert!(clearance > -0.02, "{clearance} m");
    }
}
