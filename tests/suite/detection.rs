//! Openings of walls that are made of several obstacles, gaps as wide as the robot, and an independent flood
//! fill for what can be reached.

use crate::support::{cocarry, json, stderr, stdout};
use cocarry::geometry::Point;
use cocarry::math;
use cocarry::options::OptionSet;
use cocarry::world::{Opening, World};
use cocarry_studies::paper::cycles::{mixed_world, random_world};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::collections::VecDeque;

const HEAD: &str = "name = \"w\"\nrobot_width_m = 0.5\n";

/// A box from corner to corner, as a world file has it, turned about the origin.
fn wall(name: &str, [x0, y0, x1, y1]: [f64; 4], turn: f64) -> String {
    let (x, y) = ((x0 + x1) / 2.0, (y0 + y1) / 2.0);
    let (s, c) = (math::sin(turn), math::cos(turn));
    format!(
        "[[obstacle]]\nname = \"{name}\"\nshape = \"box\"\ncenter_m = [{}, {}]\nsize_m = [{}, {}]\nyaw_deg = {}\nheight_m = 1\n",
        c * x - s * y,
        s * x + c * y,
        x1 - x0,
        y1 - y0,
        turn.to_degrees(),
    )
}

/// How a wall is put together.
#[derive(Clone, Copy, Debug)]
enum Build {
    OneBox,
    /// One behind the other along the wall.
    Touching,
    Overlapping,
    /// Side by side, across the wall.
    Layers,
    OverlappingLayers,
    Twice,
}

const BUILDS: [Build; 5] =
    [Build::Touching, Build::Overlapping, Build::Layers, Build::OverlappingLayers, Build::Twice];

impl Build {
    fn boxes(self, [x0, y0, x1, y1]: [f64; 4], share: f64) -> Vec<[f64; 4]> {
        let is_along_x = x1 - x0 > y1 - y0;
        // the first box ends at `to`, the second begins at `from`, shares of the length or of the thickness
        let cut = |along_x: bool, to: f64, from: f64| match along_x {
            true => vec![[x0, y0, x0 + (x1 - x0) * to, y1], [x0 + (x1 - x0) * from, y0, x1, y1]],
            false => vec![[x0, y0, x1, y0 + (y1 - y0) * to], [x0, y0 + (y1 - y0) * from, x1, y1]],
        };
        match self {
            Self::OneBox => vec![[x0, y0, x1, y1]],
            Self::Touching => cut(is_along_x, share, share),
            Self::Overlapping => cut(is_along_x, share, share * 0.7),
            Self::Layers => cut(!is_along_x, share, share),
            Self::OverlappingLayers => cut(!is_along_x, share, share * 0.7),
            Self::Twice => vec![[x0, y0, x1, y1]; 2],
        }
    }
}

/// Two rooms side by side, each cut by a wall along y with doors, and a few pillars; every wall built in
/// one way.
fn rooms(seed: u64, build: Build) -> String {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let turn = if seed.is_multiple_of(3) { 0.0 } else { rng.random_range(-3.0..3.0) };
    let (s, c) = (math::sin(turn), math::cos(turn));
    let point = |x: f64, y: f64| format!("[{}, {}]", c * x - s * y, s * x + c * y);
    let mut text = format!("{HEAD}start_m = {}\ntarget_m = {}\n", point(1.0, 3.0), point(13.0, 3.0));
    let mut walls =
        vec![[-0.2, -0.2, 14.2, 0.0], [-0.2, 8.0, 14.2, 8.2], [-0.2, 0.0, 0.0, 8.0], [14.0, 0.0, 14.2, 8.0]];
    for x in [4.5, 9.5] {
        let thick = rng.random_range(0.1..0.5);
        // a door in the corner of the room, now and then
        let mut y = if rng.random_bool(0.5) { 0.0 } else { -rng.random_range(0.6..2.0) };
        while y < 8.0 {
            let door = rng.random_range(0.6..2.0);
            let end: f64 = y + door + rng.random_range(1.0..3.0);
            let from = if y < 0.0 { 0.0 } else { y + door };
            walls.push([x, from, x + thick, if end > 7.2 { 8.0 } else { end }]);
            y = if end > 7.2 { 9.0 } else { end };
        }
    }
    for (i, outline) in walls.into_iter().enumerate() {
        let share = rng.random_range(0.3..0.7);
        for (j, part) in build.boxes(outline, share).into_iter().enumerate() {
            text += &wall(&format!("wall-{i}-{j}"), part, turn);
        }
    }
    for i in 0..rng.random_range(0..4) {
        let (x, y) = (rng.random_range(6.0..9.0), rng.random_range(1.0..7.0));
        let radius = rng.random_range(0.1..0.5);
        text += &format!(
            "[[obstacle]]\nname = \"p{i}\"\nshape = \"cylinder\"\ncenter_m = {}\nradius_m = {radius}\nheight_m = 1\n",
            point(x, y)
        );
    }
    text
}

/// The width to 1e-6 m; the ends to 1e-3 m, since the closest points of cylinders are no better.
fn is_same_gap(a: &Opening, b: &Opening) -> bool {
    let near = |p: Point, q: Point| (p - q).norm() < 1e-3;
    let [p, q] = b.ends;
    let ends = |p, q| near(a.ends[0], p) && near(a.ends[1], q);
    (a.width - b.width).abs() < 1e-6 && (ends(p, q) || ends(q, p))
}

/// Every option's openings (by their middles, in mm), length and risk.
fn ways(world: &World, set: &OptionSet) -> Vec<(Vec<[i64; 2]>, f64, f64)> {
    let millimetres = |p: Point| [p.x, p.y].map(|c| (c * 1e3).round() as i64);
    let options = set.options().iter().enumerate();
    options
        .map(|(o, option)| {
            let left = set.remaining(&set.begin(), o);
            let middles = option.crossings.iter().map(|c| millimetres(world.openings[c.opening].center()));
            (middles.collect(), left.length, left.risk)
        })
        .collect()
}

/// Openings and options are the same whatever boxes a wall is made of.
#[test]
fn property_it_does_not_matter_of_how_many_boxes_a_wall_is_made() {
    let (mut openings, mut options, mut unreachable) = (0, 0, 0);
    for seed in 0..40 {
        let world = World::parse("rooms", &rooms(seed, Build::OneBox));
        let Ok(world) = world else { continue };
        let set = OptionSet::new(&world, 10.0);
        for build in BUILDS {
            let context = format!("world {seed}, {build:?}");
            let other =
                World::parse("rooms", &rooms(seed, build)).unwrap_or_else(|e| panic!("{context}: {e}"));
            let names = |w: &World| {
                w.openings
                    .iter()
                    .map(|o| format!("{:?} {:.4}", o.ends, o.width))
                    .collect::<Vec<_>>()
                    .join("\n")
            };
            assert_eq!(
                other.openings.len(),
                world.openings.len(),
                "{context}:\n{}\nnot\n{}",
                names(&other),
                names(&world)
            );
            for opening in &world.openings {
                let is_there = other.openings.iter().any(|o| is_same_gap(o, opening));
                assert!(is_there, "{context}: {opening:?} is not among\n{}", names(&other));
            }
            openings += world.openings.len();
            match (&set, OptionSet::new(&other, 10.0)) {
                (Ok(set), Ok(others)) => {
                    let (expected, found) = (ways(&world, set), ways(&other, &others));
                    assert_eq!(found.len(), expected.len(), "{context}");
                    for (found, expected) in found.iter().zip(&expected) {
                        assert_eq!(found.0.len(), expected.0.len(), "{context}: {found:?} not {expected:?}");
                        let (length, risk) = (found.1 - expected.1, found.2 - expected.2);
                        assert!(
                            length.abs() < 2e-3 && risk.abs() < 1e-5,
                            "{context}: {found:?} not {expected:?}"
                        );
                        options += 1;
                    }
                }
                (Err(_), Err(_)) => unreachable += 1,
                (expected, found) => panic!("{context}: {found:?}, not {expected:?}"),
            }
        }
    }
    assert!(openings > 500 && options > 500 && unreachable < 100, "{openings}, {options}, {unreachable}");
}

/// Two walls along x with a door of 1 m from x = 4 to 5, and what else is given; start in the south, target
/// in the north, closed around.
fn hall(parts: &[[f64; 4]]) -> String {
    let mut text = format!("{HEAD}start_m = [4.5, -3]\ntarget_m = [4.5, 3]\n");
    let around =
        [[-0.2, -5.0, 0.0, 5.0], [9.0, -5.0, 9.2, 5.0], [-0.2, -5.2, 9.2, -5.0], [-0.2, 5.0, 9.2, 5.2]];
    for (i, part) in around.iter().chain(parts).enumerate() {
        text += &wall(&format!("o{i}"), *part, 0.0);
    }
    text
}

#[test]
fn closed_form_a_door_is_found_once_however_its_sides_are_made() {
    let sides = [[0.0, 0.0, 4.0, 0.2], [5.0, 0.0, 9.0, 0.2]];
    let frames = [[3.9, -0.05, 4.0, 0.25], [5.0, -0.05, 5.1, 0.25]];
    // where two walls of a room meet: the eastern wall from the south, the northern one that goes on
    let corner = [[0.0, 0.0, 4.0, 0.2], [5.0, -5.0, 5.2, 0.0], [5.0, 0.0, 9.0, 0.2]];
    let layers = [[0.0, 0.0, 4.0, 0.1], [0.0, 0.1, 4.0, 0.2], [5.0, 0.0, 9.0, 0.1], [5.0, 0.1, 9.0, 0.2]];
    let cases = [
        ("plain", sides.to_vec()),
        ("frames flush with the walls' ends", [sides, frames].concat()),
        ("one frame", [&sides[..], &frames[..1]].concat()),
        ("a corner", corner.to_vec()),
        ("a corner, the other way round", vec![corner[1], corner[0], corner[2]]),
        ("two layers", layers.to_vec()),
        ("one side in two layers", vec![layers[0], layers[1], sides[1]]),
        ("a wall listed twice", [&sides[..], &sides[..1]].concat()),
        ("both listed twice", [sides, sides].concat()),
    ];
    for (case, parts) in cases {
        let world = World::parse("hall", &hall(&parts)).unwrap();
        assert_eq!(world.openings.len(), 1, "{case}: {:?}", world.openings);
        let opening = &world.openings[0];
        assert!((opening.width - 1.0).abs() < 1e-9, "{case}: {}", opening.width);
        assert!((opening.center() - Point::new(4.5, 0.1)).norm() < 1e-9, "{case}: {}", opening.center());
        let set = OptionSet::new(&world, 10.0).unwrap();
        assert_eq!(set.options().len(), 1, "{case}");
        assert!((set.remaining(&set.begin(), 0).risk - 0.5).abs() < 1e-9, "{case}");
    }
}

/// An opening may be declared between any two of the obstacles that make its sides.
#[test]
fn closed_form_a_declared_opening_is_the_one_detected() {
    let parts = [[0.0, 0.0, 4.0, 0.2], [3.9, -0.1, 4.0, 0.1], [5.0, 0.0, 9.0, 0.2]];
    let text = hall(&parts);
    let detected = World::parse("hall", &text).unwrap().openings;
    for side in ["o4", "o5"] {
        let text = format!("{text}[[opening]]\nname = \"door\"\nbetween = [\"{side}\", \"o6\"]\n");
        let declared = World::parse("hall", &text).unwrap().openings;
        assert!(is_same_gap(&declared[0], &detected[0]), "{side}: {:?}, {:?}", declared[0], detected[0]);
    }
}

/// A gap as wide as the robot is impassable, as a narrower one is, however its width is written.
#[test]
fn closed_form_a_gap_as_wide_as_the_robot_is_impassable() {
    for (low, gap) in [(4.0, 0.5), (0.1 + 0.2, 0.5), (3.3, 0.499_999), (3.3, 0.5 + 1e-7), (2.7, 0.5 - 1e-9)] {
        let text = hall(&[[0.0, 0.0, low, 0.2], [low + gap, 0.0, 9.0, 0.2]]);
        let world = World::parse("hall", &text).unwrap();
        assert!(world.openings.is_empty(), "{gap}: {:?}", world.openings);
        let error = OptionSet::new(&world, 10.0).map(|set| set.options().len()).unwrap_err();
        assert!(error.to_string().contains("cannot be reached from the start"), "{gap}: {error}");
        assert!(error.to_string().contains("between `o4` and `o5`"), "{gap}: {error}");
        let declared = format!("{text}[[opening]]\nname = \"door\"\nbetween = [\"o4\", \"o5\"]\n");
        let error = World::parse("hall", &declared).unwrap_err();
        assert!(error.to_string().ends_with("m: impassable"), "{gap}: {error}");
    }
    // a corridor of that width, and one next to a door
    let corridor = hall(&[[0.0, -1.0, 4.0, 1.0], [4.5, -1.0, 9.0, 1.0]]);
    assert!(OptionSet::new(&World::parse("hall", &corridor).unwrap(), 10.0).is_err());
    let near_door = hall(&[[0.0, 0.0, 4.0, 0.2], [4.5, 0.0, 7.0, 0.2], [7.8, 0.0, 9.0, 0.2]]);
    let set = OptionSet::new(&World::parse("hall", &near_door).unwrap(), 10.0).unwrap();
    assert_eq!(set.options().len(), 1);
    assert!((set.remaining(&set.begin(), 0).risk - 0.5 / 0.8).abs() < 1e-9);
    let wider = hall(&[[0.0, 0.0, 4.0, 0.2], [4.5001, 0.0, 9.0, 0.2]]);
    let set = OptionSet::new(&World::parse("hall", &wider).unwrap(), 10.0).unwrap();
    assert!(set.remaining(&set.begin(), 0).risk > 0.999);
}

/// What can be reached by a flood fill over a grid of squares of side `h` (m), whose middles keep `clearance`
/// (m), diagonally or not.
fn floods(world: &World, h: f64, clearance: f64, diagonally: bool) -> bool {
    let bounds = world.bounds().grown(1.0);
    let (columns, rows) = ((bounds.size().x / h) as usize + 1, (bounds.size().y / h) as usize + 1);
    let middle = |i: usize, j: usize| Point::new(bounds.min.x + h * i as f64, bounds.min.y + h * j as f64);
    let cell =
        |p: Point| [((p.x - bounds.min.x) / h).round() as usize, ((p.y - bounds.min.y) / h).round() as usize];
    let is_free = |p: Point| world.obstacles.iter().all(|o| o.distance_to_point(p) >= clearance);
    let (start, target) = (cell(world.start), cell(world.target));
    let mut seen = vec![false; columns * rows];
    let mut queue = VecDeque::from([start]);
    seen[start[1] * columns + start[0]] = true;
    while let Some([i, j]) = queue.pop_front() {
        if [i, j] == target {
            return true;
        }
        for (di, dj) in (-1..=1).flat_map(|di| (-1..=1).map(move |dj| (di, dj))) {
            let is_beside = i32::abs(di) + i32::abs(dj) == 1;
            let (Some(i), Some(j)) = (i.checked_add_signed(di as isize), j.checked_add_signed(dj as isize))
            else {
                continue;
            };
            if !(is_beside || diagonally) || i >= columns || j >= rows || seen[j * columns + i] {
                continue;
            }
            seen[j * columns + i] = true;
            if is_free(middle(i, j)) {
                queue.push_back([i, j]);
            }
        }
    }
    false
}

/// A target is refused exactly where a flood fill does not come to it, and no option leads through an
/// obstacle. Between a fill that keeps a little too much clear and one that keeps a little too little, either
/// answer is right.
#[test]
fn property_what_can_be_reached_agrees_with_a_flood_fill() {
    const H: f64 = 0.05;
    let (mut reached, mut closed, mut open_to_doubt) = (0, 0, 0);
    for seed in 0..150 {
        let mut rng = ChaCha8Rng::seed_from_u64(1000 + seed);
        let mut text =
            if seed % 3 == 0 { mixed_world(&mut rng, seed % 2 == 0) } else { random_world(&mut rng) };
        if seed.is_multiple_of(2) {
            // a wall across, with a gap that the robot may or may not fit through
            let gap: f64 = rng.random_range(0.3..0.9);
            text += &wall("across-1", [3.0, -1.0, 3.2, 3.0], 0.0);
            text += &wall("across-2", [3.0, 3.0 + gap, 3.2, 14.0], 0.0);
        }
        let Ok(world) = World::parse("random", &text) else { continue };
        let half = world.robot_width / 2.0;
        let set = OptionSet::new(&world, 10.0);
        if floods(&world, H, half + H / 2.0 + 1e-6, false) {
            let set = set.unwrap_or_else(|e| panic!("world {seed}: {e}\n{text}"));
            for o in 0..set.options().len() {
                let path = set.path(&set.begin(), o).unwrap();
                for p in (0..)
                    .map(|i| 0.05 * f64::from(i))
                    .take_while(|s| *s < path.length())
                    .filter_map(|s| path.point_at(s))
                {
                    let room = world.obstacles.iter().map(|o| o.distance_to_point(p)).fold(9.0, f64::min);
                    assert!(
                        room > half - 1e-6,
                        "world {seed}: option {o} is {room} m off an obstacle at {p}"
                    );
                }
            }
            reached += 1;
        } else if !floods(&world, H, half - H, true) {
            assert!(set.is_err(), "world {seed} is closed\n{text}");
            closed += 1;
        } else {
            open_to_doubt += 1;
        }
    }
    assert!(reached > 60 && closed > 10, "{reached} reached, {closed} closed, {open_to_doubt} open to doubt");
}

/// Openings that no option uses are told, in words and in JSON.
#[test]
fn openings_that_no_option_uses_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let unused = |path: &str| {
        let json = json(&["world", path, "--json"]);
        let openings = json["openings"].as_array().unwrap().clone();
        let unused = openings.into_iter().filter(|o| o["used"] == false);
        unused
            .map(|o| (o["name"].as_str().unwrap().to_owned(), o["leads_nowhere_new"].as_bool().unwrap()))
            .collect::<Vec<_>>()
    };
    // two pillars in the open: the way between them is a way around either
    let pillar = |name: &str, y: f64| wall(name, [4.0, y - 0.2, 4.4, y + 0.2], 0.0);
    let open =
        format!("{HEAD}start_m = [0, 0]\ntarget_m = [9, 0]\n{}{}", pillar("a", -0.7), pillar("b", 0.7));
    let path = write("open.toml", &open);
    assert_eq!(unused(&path), [("xi1".to_owned(), true)]);
    let text = stdout(&cocarry(&["world", &path]));
    assert!(text.contains("1 opening leads nowhere new (xi1)"), "{text}");
    // named, it is used
    let named = format!("{open}[[option]]\nopenings = [\"xi1\"]\n");
    assert_eq!(unused(&write("named.toml", &named)), []);
    // a chamber next to the way: an opening into it, and none out
    let chamber =
        hall(&[[0.0, 0.0, 4.0, 0.2], [5.0, 0.0, 9.0, 0.2], [6.0, -5.0, 6.2, -3.5], [6.0, -2.5, 6.2, 0.0]]);
    let path = write("chamber.toml", &chamber);
    assert_eq!(unused(&path).iter().map(|u| u.1).collect::<Vec<_>>(), [false]);
    let text = stdout(&cocarry(&["world", &path]));
    assert!(text.contains("1 opening is on none of these options"), "{text}");
    assert!(!stdout(&cocarry(&["world", "environment-1"])).contains("nowhere new"));
}

/// On the physical plant the human walks on beyond the target: where something stands there, the team comes to
/// the target in an arc; where there is no room for that, it is named before the run.
#[test]
fn a_target_without_room_for_the_human_is_reached_in_an_arc_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let run = |shelf: f64, sides: &str, plant: &str| {
        let text = format!(
            "{HEAD}start_m = [0, 0]\ntarget_m = [3, 0]\n{}{sides}",
            wall("shelf", [shelf, -1.0, shelf + 0.3, 1.0], 0.0)
        );
        let path = folder.path().join("shelf.toml");
        std::fs::write(&path, text).unwrap();
        cocarry(&["run", path.to_str().unwrap(), "--plant", plant])
    };
    // a blind alley
    let sides = wall("left", [1.5, 0.6, 4.5, 0.8], 0.0) + &wall("right", [1.5, -0.8, 4.5, -0.6], 0.0);
    let refused = run(4.1, &sides, "rapier");
    assert_eq!(refused.status.code(), Some(2));
    let error = stderr(&refused);
    assert!(
        error.contains("no room at the target") && error.contains("`shelf`") && error.contains("option `1`"),
        "{error}"
    );
    // where the message says that there is room, a team arrives
    let (fault, nearest) = error.split_once("; a target with room is (").expect(&error);
    assert!(fault.ends_with(" m are missing)"), "{error}");
    let nearest = nearest.trim_end().strip_suffix(')').expect(&error);
    let file = folder.path().join("shelf.toml");
    let moved = std::fs::read_to_string(&file)
        .unwrap()
        .replace("target_m = [3, 0]", &format!("target_m = [{nearest}]"));
    std::fs::write(&file, moved).unwrap();
    let arrives = cocarry(&["run", file.to_str().unwrap(), "--plant", "rapier"]);
    assert!(stdout(&arrives).contains("arrived"), "{nearest}: {}{}", stdout(&arrives), stderr(&arrives));
    assert!(run(4.1, &sides, "point").status.success(), "a point needs no room beyond its target");
    for shelf in [4.25, 4.1, 3.6] {
        let arrives = run(shelf, "", "rapier");
        assert!(
            arrives.status.success() && stdout(&arrives).contains("arrived"),
            "{shelf}: {}{}",
            stdout(&arrives),
            stderr(&arrives)
        );
    }
}

/// A path that bends shortly before its end: the room that is checked is where the human comes to stand, and
/// where that is taken, the team comes to the end in another arc, if there is room for one.
#[test]
fn the_room_at_the_end_of_a_bend_is_where_the_human_stands() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("bend.toml");
    let cylinder = |name: &str, [x, y]: [f64; 2], radius: f64| {
        format!(
            "[[obstacle]]\nname = \"{name}\"\nshape = \"cylinder\"\ncenter_m = [{x}, {y}]\nradius_m = {radius}\nheight_m = 1\n"
        )
    };
    let open =
        format!("{HEAD}start_m = [0, 0]\ntarget_m = [4, 0.9]\n") + &cylinder("pillar", [3.5, 0.55], 0.25);
    let corner = wall("top", [1.5, 2.0, 6.0, 2.2], 0.0) + &wall("east", [5.1, -2.0, 5.3, 2.0], 0.0);
    let run = |text: &str| {
        std::fs::write(&file, text).unwrap();
        let ticks = folder.path().join("ticks.csv");
        let name = ticks.to_str().unwrap();
        let output = cocarry(&["run", file.to_str().unwrap(), "--ticks", name, "--overwrite"]);
        if output.status.code() == Some(2) {
            return Err(stderr(&output));
        }
        assert!(stdout(&output).contains("arrived"), "{text}: {}", stdout(&output));
        let mut rows = csv::Reader::from_path(&ticks).unwrap();
        let headers = rows.headers().unwrap().clone();
        let last = rows.records().last().unwrap().unwrap();
        let column = |key| headers.iter().position(|name| name == key).unwrap();
        Ok(["torso_x_m", "torso_y_m"].map(|key| last[column(key)].parse::<f64>().unwrap()))
    };
    let stands = run(&(open.clone() + &corner)).expect("room in the corner");
    let error = run(&(open.clone() + &corner + &cylinder("post", stands, 0.1))).expect_err("no room");
    assert!(error.contains("`post`"), "{error}");
    let (_, place) = error.split_once("walks on to (").expect("the place");
    let named: Vec<f64> =
        place.split(')').next().unwrap().split(", ").map(|number| number.parse().unwrap()).collect();
    let off = cocarry::math::hypot(stands[0] - named[0], stands[1] - named[1]);
    assert!(off < 0.04, "{named:?} is {off} m from {stands:?}");

    let straight_on = run(&open).expect("room in the open");
    let turned = run(&(open + &cylinder("post", [4.784, -0.161], 0.1))).expect("room for an arc");
    let aside = cocarry::math::hypot(turned[0] - straight_on[0], turned[1] - straight_on[1]);
    assert!(aside > 0.3, "{turned:?} is {aside} m from {straight_on:?}");
}
