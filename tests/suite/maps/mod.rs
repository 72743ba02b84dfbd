//! Worlds from maps and floor plans, and outlines of obstacles that touch or are concave, each against the
//! same room written by hand.

mod drawings;

use crate::support::{cocarry, json, repository, stderr, stdout};
use cocarry::geometry::{Point, direction, left_of};
use cocarry::options::OptionSet;
use cocarry::world::World;
use cocarry_maps::Ends;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Side of a cell, m.
const CELL_M: f64 = 0.05;

/// A room of 9 m by 6 m with two doors in a wall and a pillar: boxes from corner to corner, m.
const ROOM: [[f64; 4]; 8] = [
    [0.0, 0.0, 9.0, 0.2],
    [0.0, 5.8, 9.0, 6.0],
    [0.0, 0.2, 0.2, 5.8],
    [8.8, 0.2, 9.0, 5.8],
    [4.0, 0.2, 4.2, 1.5],
    [4.0, 2.4, 4.2, 4.1],
    [4.0, 5.3, 4.2, 5.8],
    [6.0, 2.8, 6.4, 3.2],
];
const START: [f64; 2] = [1.5, 2.5];
const TARGET: [f64; 2] = [7.5, 3.1];

/// Where a map lies in the world: x, y (m) and yaw (rad).
type Origin = [f64; 3];

fn placed([x0, y0, yaw]: Origin, [x, y]: [f64; 2]) -> Point {
    Point::new(x0, y0) + direction(yaw) * x + left_of(direction(yaw)) * y
}

fn head(origin: Origin) -> String {
    let [a, b] = [START, TARGET].map(|p| placed(origin, p));
    format!(
        "name = \"Room\"\nrobot_width_m = 0.5\nstart_m = [{}, {}]\ntarget_m = [{}, {}]\n",
        a.x, a.y, b.x, b.y
    )
}

/// The room as a world file, box by box.
fn by_hand(origin: Origin) -> String {
    let boxes = ROOM.iter().enumerate().map(|(i, [x0, y0, x1, y1])| {
        let center = placed(origin, [(x0 + x1) / 2.0, (y0 + y1) / 2.0]);
        format!(
            "[[obstacle]]\nname = \"o{i}\"\nshape = \"box\"\ncenter_m = [{}, {}]\nsize_m = [{}, {}]\nyaw_deg = {}\nheight_m = 2\n",
            center.x,
            center.y,
            x1 - x0,
            y1 - y0,
            origin[2].to_degrees()
        )
    });
    head(origin) + &boxes.collect::<String>()
}

/// The shades of the room's cells, from the top row on: 0 occupied, 254 free, 205 unknown in a corner that
/// nobody has seen.
fn shades() -> (usize, usize, Vec<u8>) {
    let (width, height) = ((9.0 / CELL_M) as usize, (6.0 / CELL_M) as usize);
    let shade = |i: usize| {
        let at = [i % width, height - 1 - i / width].map(|k| (k as f64 + 0.5) * CELL_M);
        let is_in = |[x0, y0, x1, y1]: &[f64; 4]| (*x0..*x1).contains(&at[0]) && (*y0..*y1).contains(&at[1]);
        if ROOM.iter().any(is_in) { 0 } else { 254 }
    };
    (width, height, (0..width * height).map(shade).collect())
}

/// A folder with `map.yaml` and its image.
fn map(origin: Origin, image: &str) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let (width, height, shades) = shades();
    let bytes = match image {
        "room.pgm" => [format!("P5\n# a room\n{width} {height}\n255\n").as_bytes(), &shades].concat(),
        "plain.pgm" => {
            let text: String = shades.iter().map(|shade| format!("{shade}\n")).collect();
            format!("P2 {width} {height} 255\n{text}").into_bytes()
        }
        _ => unreachable!("{image}"),
    };
    std::fs::write(folder.path().join(image), bytes).unwrap();
    let yaml = format!(
        "image: {image}  # next to this file\nmode: trinary\nresolution: {CELL_M}\norigin: [{}, {}, {}]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n",
        origin[0], origin[1], origin[2]
    );
    let path = folder.path().join("map.yaml");
    std::fs::write(&path, yaml).unwrap();
    (folder, path)
}

fn ends(origin: Origin) -> Ends {
    Ends { start: placed(origin, START), target: placed(origin, TARGET), robot_width: None, tolerance: None }
}

/// Every option's openings by their middles (to `grain` metres), length and risk.
fn options(world: &World, grain: f64) -> Vec<(Vec<[i64; 2]>, f64, f64)> {
    let set = OptionSet::new(world, 10.0).unwrap_or_else(|error| panic!("{error}"));
    let begin = set.begin();
    let option = |o: usize| {
        let left = set.remaining(&begin, o);
        let middle = |opening: usize| {
            let middle = world.openings[opening].center();
            [middle.x, middle.y].map(|c| (c / grain).round() as i64)
        };
        let crossings = set.options()[o].crossings.iter();
        (crossings.map(|crossing| middle(crossing.opening)).collect(), left.length, left.risk)
    };
    (0..set.options().len()).map(option).collect()
}

/// Compares the options of two worlds: the same openings, with lengths and risks within these bounds.
fn assert_same_options(a: &World, b: &World, [length, risk]: [f64; 2]) {
    let names = |world: &World| {
        let opening = |o: &cocarry::world::Opening| format!("{} {:.4} at {}", o.name, o.width, o.center());
        world.openings.iter().map(opening).collect::<Vec<_>>().join("\n")
    };
    let context = format!("{}\nand\n{}", names(a), names(b));
    assert_eq!(a.openings.len(), b.openings.len(), "{context}");
    for (a, b) in a.openings.iter().zip(&b.openings) {
        assert!((a.width - b.width).abs() <= risk && (a.center() - b.center()).norm() <= length, "{context}");
    }
    let (of_a, of_b) = (options(a, 1e3), options(b, 1e3));
    assert_eq!(of_a.len(), of_b.len(), "{context}\n{of_a:?}\n{of_b:?}");
    for ((ways_a, length_a, risk_a), (ways_b, length_b, risk_b)) in of_a.iter().zip(&of_b) {
        assert_eq!(ways_a.len(), ways_b.len(), "{context}");
        assert!(
            (length_a - length_b).abs() <= length && (risk_a - risk_b).abs() <= risk,
            "{of_a:?}\n{of_b:?}"
        );
    }
}

#[test]
fn a_traced_map_has_the_openings_and_options_of_the_room_drawn_by_hand() {
    for (origin, image) in [
        ([0.0; 3], "room.pgm"),
        ([-3.0, 1.5, 0.0], "plain.pgm"),
        ([2.0, -7.0, 0.4], "room.pgm"),
        ([0.5, 0.25, -2.0], "room.pgm"),
    ] {
        let (_folder, path) = map(origin, image);
        let traced = cocarry_maps::from_map(&path, &ends(origin)).unwrap_or_else(|error| panic!("{error}"));
        let drawn = World::parse("room", &by_hand(origin)).unwrap();
        assert_eq!(drawn.openings.len(), 4, "two doors, and the pillar's distances to the walls");
        // cells lie on the walls' sides, and coordinates are written to a micrometre
        assert_same_options(&traced, &drawn, [1e-5; 2]);
        assert_eq!(traced.obstacles.len(), 3, "the walls, the wall between the doors, and the pillar");
    }
}

#[test]
fn a_world_file_names_its_map_and_keeps_its_lines() {
    let (folder, _) = map([0.0; 3], "room.pgm");
    let path = folder.path().join("room.toml");
    let text = head([0.0; 3])
        + "\n[map]\nfile = \"map.yaml\"\nheight_m = 1.5\n\n[[option]]\nname = \"left\"\nopenings = [\"xi9\"]\n";
    std::fs::write(&path, &text).unwrap();
    let refused = cocarry(&["world", path.to_str().unwrap()]);
    let said = stderr(&refused);
    assert_eq!(refused.status.code(), Some(2));
    assert!(said.contains("room.toml:10: option `left`: unknown opening `xi9`"), "{said}");
    std::fs::write(&path, text.replace("xi9", "xi2")).unwrap();
    let shown = json(&["world", path.to_str().unwrap(), "--json"]);
    assert_eq!(shown["options"].as_array().unwrap().len(), 1);
    assert_eq!(shown["obstacles"][0]["height_m"], 1.5);
    assert_eq!(shown["obstacles"][0]["shape"], "room");

    // what it writes is complete: it needs no map
    let written = folder.path().join("written.toml");
    let arguments = ["world", path.to_str().unwrap(), "--write", written.to_str().unwrap()];
    assert!(cocarry(&arguments).status.success());
    std::fs::remove_file(folder.path().join("map.yaml")).unwrap();
    let again = json(&["world", written.to_str().unwrap(), "--json"]);
    assert_eq!(again["options"], shown["options"]);
    assert!(stderr(&cocarry(&["world", path.to_str().unwrap()])).contains("map.yaml: cannot be read"));
}

#[test]
fn a_run_on_a_map_is_recorded_with_the_outlines_and_replayed_without_the_map() {
    let (folder, _) = map([0.0; 3], "room.pgm");
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::write(file("room.toml"), head([0.0; 3]) + "map = { file = \"map.yaml\" }\n").unwrap();
    let run = cocarry(&["run", &file("room.toml"), "--plant", "point", "--record", &file("room.mcap")]);
    assert!(run.status.success(), "{}", stderr(&run));
    std::fs::remove_file(file("map.yaml")).unwrap();
    let replayed = cocarry(&["replay", &file("room.mcap")]);
    assert!(replayed.status.success(), "{}{}", stdout(&replayed), stderr(&replayed));
}

#[test]
fn maps_that_cannot_be_read_are_refused_by_place_and_value() {
    let (folder, path) = map([0.0; 3], "room.pgm");
    let yaml = std::fs::read_to_string(&path).unwrap();
    let name = path.to_str().unwrap();
    let world = |start: &str| stderr(&cocarry(&["world", name, "--start", start, "--target", "7.5,3.1"]));
    let spoil = |from: &str, to: &str, said: &[&str]| {
        assert!(yaml.contains(from), "{from}");
        std::fs::write(&path, yaml.replace(from, to)).unwrap();
        let found = world("1.5,2.5");
        said.iter().for_each(|said| assert!(found.contains(said), "{said}: {found}"));
        std::fs::write(&path, &yaml).unwrap();
    };
    let without_ends = cocarry(&["world", name]);
    assert_eq!(without_ends.status.code(), Some(2));
    assert!(stderr(&without_ends).contains("give --start and --target"), "{}", stderr(&without_ends));
    spoil(
        "resolution: 0.05",
        "resolution: 5 cm",
        &["map.yaml:3", "resolution = 5 cm", "0.001 to 10 (metres)"],
    );
    spoil("negate: 0", "negate: maybe", &["map.yaml:5", "negate = maybe", "0 or 1"]);
    spoil("image: room.pgm", "image: rom.pgm", &["rom.pgm", "cannot be read"]);
    spoil("free_thresh: 0.25", "free_tresh: 0.25", &["map.yaml:7", "unknown key `free_tresh`"]);
    spoil("mode: trinary", "mode: binary", &["mode = binary", "trinary, scale or raw"]);
    spoil("origin: [0, 0, 0]", "origin: [0, zero, 0]", &["origin = [0, zero, 0]", "[x, y, yaw]"]);
    spoil("image", "- image", &["map.yaml: not a valid map description"]);
    assert!(world("4.1,1.0").contains("is on an occupied cell"), "{}", world("4.1,1.0"));
    assert!(world("-4.1,1.0").contains("is on no cell"), "{}", world("-4.1,1.0"));
    assert!(
        world("3.9,1.0").contains("from obstacle `walls`; the team needs 0.25 m"),
        "{}",
        world("3.9,1.0")
    );
    let cut = std::fs::read(folder.path().join("room.pgm")).unwrap();
    std::fs::write(folder.path().join("room.pgm"), &cut[..cut.len() - 9]).unwrap();
    assert!(world("1.5,2.5").contains("cut short"), "{}", world("1.5,2.5"));
}

#[test]
fn a_map_whose_rooms_are_not_connected_is_refused() {
    let (folder, path) = map([0.0; 3], "room.pgm");
    let (width, height, mut shades) = shades();
    // both doors closed: one by a wall, one but for a crack of two cells; beyond the crack is no floor
    for row in 0..height {
        let y = (height - 1 - row) as f64 * CELL_M;
        if !(1.55..1.65).contains(&y) {
            shades[row * width + 80..row * width + 84].fill(0);
        }
    }
    let bytes = [format!("P5 {width} {height} 255\n").as_bytes(), &shades].concat();
    std::fs::write(folder.path().join("room.pgm"), bytes).unwrap();
    let refused = cocarry(&["world", path.to_str().unwrap(), "--start", "1.5,2.5", "--target", "7.5,3.1"]);
    assert!(stderr(&refused).contains("no way of free cells leads from (1.5, 2.5)"), "{}", stderr(&refused));
    // a target in the same room: the other room is no part of the world
    let near = cocarry(&["world", path.to_str().unwrap(), "--start", "1.5,2.5", "--target", "3,1", "--json"]);
    let shown: serde_json::Value = serde_json::from_slice(&near.stdout).expect("JSON");
    assert_eq!(shown["obstacles"].as_array().unwrap().len(), 1);
    let corners = shown["obstacles"][0]["outline"]["vertices_m"].as_array().unwrap();
    assert!(corners.iter().all(|corner| corner[0].as_f64().unwrap() < 4.3), "{corners:?}");
}

/// One after the other, from corner to corner: a wall of `n` boxes.
fn row(n: usize, [x0, y0, x1, y1]: [f64; 4], turn: f64) -> String {
    let boxes = (0..n).map(|i| {
        let step = (y1 - y0) / n as f64;
        let center = placed([0.0, 0.0, turn], [(x0 + x1) / 2.0, y0 + step * (i as f64 + 0.5)]);
        format!(
            "[[obstacle]]\nname = \"k{i}\"\nshape = \"box\"\ncenter_m = [{}, {}]\nsize_m = [{}, {step}]\nyaw_deg = {}\nheight_m = 1\n",
            center.x,
            center.y,
            x1 - x0,
            turn.to_degrees()
        )
    });
    boxes.collect()
}

#[test]
fn issue_a_wall_of_many_boxes_is_the_wall_in_one_piece() {
    for turn in [0.0, 0.6] {
        let end = |x, y| placed([0.0, 0.0, turn], [x, y]);
        let (a, b) = (end(1.0, 2.0), end(9.0, 2.5));
        let head = format!(
            "name = \"w\"\nrobot_width_m = 0.5\nstart_m = [{}, {}]\ntarget_m = [{}, {}]\n",
            a.x, a.y, b.x, b.y
        );
        let top = row(1, [4.9, 4.0, 5.1, 8.0], turn).replace("k0", "top");
        let sides =
            [[-1.0, -0.2, 11.0, 0.0], [-1.0, 8.0, 11.0, 8.2], [-1.0, 0.0, -0.8, 8.0], [10.8, 0.0, 11.0, 8.0]];
        let sides =
            sides.iter().enumerate().map(|(i, side)| row(1, *side, turn).replace("k0", &format!("s{i}")));
        let room = head + &sides.collect::<String>() + &top;
        let world = |n| World::parse("w", &(room.clone() + &row(n, [4.9, 0.0, 5.1, 3.0], turn))).unwrap();
        // more would take a minute if boxes were apart
        assert_same_options(&world(1), &world(800), [1e-9; 2]);
    }
}

#[test]
fn concave_outlines_are_what_boxes_make_of_them() {
    let boxes = by_hand([0.0; 3]);
    let inside = "[[0.2, 0.2], [4.0, 0.2], [4.0, 1.5], [4.2, 1.5], [4.2, 0.2], [8.8, 0.2], [8.8, 5.8], [4.2, 5.8], \
                  [4.2, 5.3], [4.0, 5.3], [4.0, 5.8], [0.2, 5.8], [0.2, 0.2]]";
    let floor = |shape: &str| format!("[[obstacle]]\nname = \"walls\"\nshape = \"{shape}\"\nheight_m = 2\n");
    let within = "[[obstacle]]\nname = \"wall\"\nshape = \"polygon\"\nheight_m = 2\n\
                  vertices_m = [[4.0, 2.4], [4.1, 2.4], [4.2, 2.4], [4.2, 4.1], [4.0, 4.1], [4.0, 2.4]]\n\
                  [[obstacle]]\nname = \"pillar\"\nshape = \"box\"\nheight_m = 2\ncenter_m = [6.2, 3.0]\nsize_m = [0.4, 0.4]\n";
    let room = head([0.0; 3]) + &floor("room") + "vertices_m = " + inside + "\n" + within;
    // the same as a polygon around the walls, with the floor as a hole
    let around = "vertices_m = [[0, 0], [9, 0], [9, 6], [0, 6]]\nholes_m = [";
    let ring = head([0.0; 3]) + &floor("polygon") + around + inside + "]\n" + within;
    let drawn = World::parse("boxes", &boxes).unwrap();
    for text in [room, ring] {
        let world = World::parse("outline", &text).unwrap_or_else(|error| panic!("{error}"));
        assert_same_options(&drawn, &world, [1e-9; 2]);
    }
}

#[test]
fn a_floor_plan_in_millimetres_is_the_room_in_metres() {
    let folder = tempfile::tempdir().unwrap();
    let areas = ROOM.iter().enumerate().map(|(i, corners)| {
        let [x0, y0, x1, y1] = corners.map(|c| (c * 1000.0).round());
        format!(
            "{{\"type\": \"Feature\", \"properties\": {{\"name\": \"o{i}\", \"height_m\": 2}}, \"geometry\": {{\"type\": \"Polygon\", \
             \"coordinates\": [[[{x0}, {y0}], [{x1}, {y0}], [{x1}, {y1}], [{x0}, {y1}], [{x0}, {y0}]]]}}}}"
        )
    });
    let plan = format!(
        "{{\"type\": \"FeatureCollection\", \"features\": [{}]}}",
        areas.collect::<Vec<_>>().join(",\n")
    );
    let file = |name: &str| folder.path().join(name);
    std::fs::write(file("plan.geojson"), &plan).unwrap();
    std::fs::write(file("room.toml"), head([0.0; 3]) + "[map]\nfile = \"plan.geojson\"\nunit = \"mm\"\n")
        .unwrap();
    let find = || cocarry_maps::find(&file("room.toml"), "room.toml");
    let world = find().unwrap_or_else(|error| panic!("{error}"));
    assert_same_options(&world, &World::parse("room", &by_hand([0.0; 3])).unwrap(), [1e-9; 2]);
    assert_eq!(world.obstacles[7].name, "o7");
    let lines = plan.replacen("Polygon", "LineString", 1).replacen("[[[", "[[", 1).replacen("]]]", "]]", 1);
    std::fs::write(file("plan.geojson"), lines).unwrap();
    let refused = find().unwrap_err().to_string();
    assert!(refused.contains("feature 1: its geometry is a LineString"), "{refused}");
}

#[test]
fn detected_openings_are_numbered_by_place() {
    let text = by_hand([0.0; 3]);
    let (head, obstacles) = text.split_once("[[obstacle]]").unwrap();
    let mut obstacles: Vec<&str> = obstacles.split("[[obstacle]]").collect();
    let names = |obstacles: &[&str]| -> Vec<(String, [i64; 2])> {
        let text = format!("{head}[[obstacle]]{}", obstacles.join("[[obstacle]]"));
        let world = World::parse("room", &text).unwrap();
        let millimetres = |p: Point| [p.x, p.y].map(|c| (c * 1e3).round() as i64);
        world.openings.iter().map(|o| (o.name.clone(), millimetres(o.center()))).collect()
    };
    let before = names(&obstacles);
    assert!(before[0].0 == "xi1" && before.is_sorted_by_key(|(_, middle)| middle[0]), "{before:?}");
    obstacles.reverse();
    assert_eq!(names(&obstacles), before);
}

#[test]
fn a_world_in_millimetres_is_warned_about() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mm.toml");
    let world = "name = \"mm\"\nrobot_width_m = 500\nstart_m = [0, 0]\ntarget_m = [8000, 0]\n[[obstacle]]\nname = \"o\"\n\
                 shape = \"cylinder\"\ncenter_m = [4000, 10]\nradius_m = 300\nheight_m = 1\n[[opening]]\nname = \"a\"\nbetween = [\"o\", \"p\"]\n\
                 [[obstacle]]\nname = \"p\"\nshape = \"cylinder\"\ncenter_m = [4000, 1500]\nradius_m = 300\nheight_m = 1\n[[option]]\nopenings = [\"a\"]\n";
    std::fs::write(&path, world).unwrap();
    let said = stderr(&cocarry(&["world", path.to_str().unwrap()]));
    assert!(said.contains("robot_width_m = 500") && said.contains("all lengths are in metres"), "{said}");
    for name in ["environment-1", "free-form"] {
        let path = repository(&format!("worlds/{name}.toml"));
        assert_eq!(World::load(Path::new(&path)).unwrap().warnings(), [""; 0]);
    }
}
