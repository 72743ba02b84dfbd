//! The lengths of options against the shortest paths through the same openings, and worlds that are the same
//! room: moved, turned, mirrored, reordered, in the coordinates of a map.

mod variants;

use crate::support::{cocarry, json, load, stderr, stdout, world_files};
use cocarry::geometry::{Point, cross, direction};
use cocarry::math;
use cocarry::options::OptionSet;
use cocarry::world::World;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use variants::offered;

const HEAD: &str = "name = \"w\"\nrobot_width_m = 0.5\n";

/// Clearance of paths, m.
const CLEARANCE: f64 = 0.25;

fn wall(name: &str, [x0, y0, x1, y1]: [f64; 4]) -> String {
    format!(
        "[[obstacle]]\nname = \"{name}\"\nshape = \"box\"\ncenter_m = [{}, {}]\nsize_m = [{}, {}]\nheight_m = 1\n",
        (x0 + x1) / 2.0,
        (y0 + y1) / 2.0,
        x1 - x0,
        y1 - y0
    )
}

/// A field of 11 m by 9 m with pillars about 2.4 m apart: cylinders and narrow boxes.
fn pillars(rng: &mut ChaCha8Rng) -> String {
    let (start, target) = (rng.random_range(1.0..8.0), rng.random_range(1.0..8.0));
    let mut text = format!("{HEAD}start_m = [0.6, {start:.3}]\ntarget_m = [10.4, {target:.3}]\n");
    for (i, side) in
        [[-0.2, -0.2, 11.2, 0.0], [-0.2, 9.0, 11.2, 9.2], [-0.2, 0.0, 0.0, 9.0], [11.0, 0.0, 11.2, 9.0]]
            .into_iter()
            .enumerate()
    {
        text += &wall(&format!("wall-{i}"), side);
    }
    for i in 0..16 {
        let x = 1.9 + 2.4 * f64::from(i / 4) + rng.random_range(-0.4..0.4);
        let y = 0.9 + 2.4 * f64::from(i % 4) + rng.random_range(-0.4..0.4);
        let shape = match rng.random_bool(0.7) {
            true => format!("shape = \"cylinder\"\nradius_m = {:.3}", rng.random_range(0.2..0.55)),
            false => format!(
                "shape = \"box\"\nsize_m = [{:.3}, {:.3}]\nyaw_deg = {:.2}",
                rng.random_range(0.15..0.4),
                rng.random_range(0.15..0.4),
                rng.random_range(-90.0..90.0)
            ),
        };
        text +=
            &format!("[[obstacle]]\nname = \"p{i}\"\n{shape}\ncenter_m = [{x:.3}, {y:.3}]\nheight_m = 1\n");
    }
    text
}

/// The openings that a straight step goes through, in order, with the sides that it leads to.
fn gaps_on(world: &World, from: Point, to: Point) -> Vec<(usize, usize)> {
    let along = to - from;
    let mut met: Vec<(f64, usize, usize)> = Vec::new();
    for (i, opening) in world.openings.iter().enumerate() {
        let [a, b] = opening.ends;
        let (before, after) = (cross(b - a, from - a) < 0.0, cross(b - a, to - a) < 0.0);
        let (left, right) = (cross(along, a - from), cross(along, b - from));
        if before != after && left * right <= 0.0 {
            let t = cross(a - from, b - a) / cross(along, b - a);
            met.push((t, i, usize::from(before)));
        }
    }
    met.sort_by(|a, b| a.0.total_cmp(&b.0));
    met.into_iter().map(|(_, i, into)| (i, into)).collect()
}

/// The slow and obvious way: a visibility graph of the corners of polygons around every corner and cylinder,
/// at the clearance, in which a path also knows the openings that it has gone through.
fn slow_shortest(world: &World, route: &[(usize, usize)]) -> f64 {
    const SIDES: usize = 24;
    let mut points = vec![world.start, world.target];
    for obstacle in &world.obstacles {
        for outline in obstacle.footprints() {
            let discs: Vec<(Point, f64)> = match outline {
                cocarry::geometry::Footprint::Disc { center, radius } => vec![(*center, radius + CLEARANCE)],
                cocarry::geometry::Footprint::Polygon(corners) => {
                    corners.iter().map(|c| (*c, CLEARANCE)).collect()
                }
            };
            for (center, radius) in discs {
                let outer = radius / math::cos(std::f64::consts::PI / SIDES as f64);
                points
                    .extend((0..SIDES).map(|s| {
                        center + direction(std::f64::consts::TAU * s as f64 / SIDES as f64) * outer
                    }));
            }
        }
    }
    let is_clear =
        |a: Point, b: Point| world.obstacles.iter().all(|o| o.distance_to_segment(a, b) >= CLEARANCE - 1e-9);
    points.retain(|&p| is_clear(p, p));
    let layers = route.len() + 1;
    let mut left = vec![f64::INFINITY; points.len() * layers];
    let mut done = vec![false; left.len()];
    left[0] = 0.0;
    while let Some(state) = (0..left.len())
        .filter(|&s| !done[s] && left[s].is_finite())
        .min_by(|&a, &b| left[a].total_cmp(&left[b]))
    {
        done[state] = true;
        let (i, made) = (state / layers, state % layers);
        if i == 1 && made == route.len() {
            return left[state];
        }
        for j in 0..points.len() {
            let length = left[state] + (points[j] - points[i]).norm();
            if (made..layers).all(|m| length >= left[j * layers + m]) {
                continue;
            }
            let through = gaps_on(world, points[i], points[j]);
            let leads_there = route[made..].starts_with(&through);
            let reached = j * layers + made + through.len();
            if leads_there && length < left[reached] && is_clear(points[i], points[j]) {
                left[reached] = length;
            }
        }
    }
    f64::INFINITY
}

fn route(set: &OptionSet, option: usize) -> Vec<(usize, usize)> {
    set.options()[option].crossings.iter().map(|c| (c.opening, c.into)).collect()
}

#[test]
fn oracle_the_shortest_paths_through_openings_are_those_of_a_visibility_graph() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let (mut compared, mut world_count) = (0, 0);
    while world_count < 4 {
        let Ok(world) = World::parse("pillars", &pillars(&mut rng)) else { continue };
        let Ok(set) = OptionSet::new(&world, 10.0) else { continue };
        world_count += 1;
        let shortest = set.shortest_lengths(&world).expect("few corners");
        for (option, exact) in shortest.into_iter().enumerate().take(2) {
            let slow = slow_shortest(&world, &route(&set, option));
            assert!(exact <= slow + 1e-6 && slow <= 1.01 * exact, "option {option}: {exact}, not {slow}");
            assert!(set.remaining(&set.begin(), option).length >= exact - 1e-9);
            compared += 1;
        }
    }
    assert!(compared >= 6, "{compared}");
}

#[test]
fn property_between_pillars_options_are_hardly_longer_than_the_shortest_paths() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let mut excess = Vec::new();
    while excess.len() < 400 {
        let Ok(world) = World::parse("pillars", &pillars(&mut rng)) else { continue };
        let Ok(set) = OptionSet::new(&world, 10.0) else { continue };
        let shortest = set.shortest_lengths(&world).expect("few corners");
        let lengths = (0..set.options().len()).map(|o| set.remaining(&set.begin(), o).length / shortest[o]);
        excess.extend(lengths.map(|ratio| ratio - 1.0));
    }
    excess.sort_by(f64::total_cmp);
    let above = excess.iter().filter(|excess| **excess > 0.05).count();
    let largest = excess[excess.len() - 1];
    println!("{above} of {} above 5 %, at most {:.1} %", excess.len(), 100.0 * largest);
    assert!(largest < 0.05, "{above} of {} options, up to {:.1} %", excess.len(), 100.0 * largest);
}

/// Two rooms with a door of 1 m between them at x = 4.9 to 5.1, y = 2 to 3.
fn two_rooms(start: [f64; 2], target: [f64; 2], top: &str) -> String {
    let sides = [
        [-0.2, -0.2, 10.2, 0.0],
        [-0.2, 5.0, 10.2, 5.2],
        [-0.2, 0.0, 0.0, 5.0],
        [10.0, 0.0, 10.2, 5.0],
        [4.9, 0.0, 5.1, 2.0],
        [4.9, 3.0, 5.1, 5.0],
    ];
    let sides: String = sides.iter().enumerate().map(|(i, side)| wall(&format!("w{i}"), *side)).collect();
    format!("{HEAD}start_m = {start:?}\ntarget_m = {target:?}\n{top}{sides}")
}

#[test]
fn a_point_on_the_line_of_a_door_is_on_the_side_of_the_other_one() {
    let length = |start, target| {
        let world = World::parse("w", &two_rooms(start, target, "")).unwrap();
        let set = OptionSet::new(&world, 10.0).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(set.options().len(), 1);
        (set.options()[0].crossings.len(), set.remaining(&set.begin(), 0).length)
    };
    for x in [5.0, 5.0 - 1e-9, 5.0 + 1e-9] {
        for (other, distance) in [([8.0, 2.5], 3.0), ([1.0, 2.5], 4.0)] {
            for (start, target) in [([x, 2.5], other), (other, [x, 2.5])] {
                let (crossings, length) = length(start, target);
                assert_eq!(crossings, 0, "from {start:?} to {target:?}");
                assert!((length - distance).abs() < 3e-6, "from {start:?} to {target:?}: {length} m");
            }
        }
    }
    // the team arrives, from the line and on it
    let folder = tempfile::tempdir().unwrap();
    for (start, target) in [([5.0, 2.5], [8.0, 2.5]), ([2.0, 2.5], [5.0, 2.5])] {
        let file = folder.path().join("door.toml");
        std::fs::write(&file, two_rooms(start, target, "")).unwrap();
        let run = cocarry(&["run", file.to_str().unwrap(), "--plant", "point"]);
        assert!(stdout(&run).contains("arrived"), "{}{}", stdout(&run), stderr(&run));
    }
}

#[test]
fn a_room_in_map_coordinates_is_read_relative_to_its_origin() {
    let moved = two_rooms([1.0, 2.5], [9.0, 1.0], "");
    let expected = offered(&moved).unwrap();
    let [east, north] = [691_000.25, 5_334_000.5];
    let written = {
        let sides: Vec<String> = moved.split("[[obstacle]]").map(str::to_owned).collect();
        let shift = |line: &str| {
            let Some((key, pair)) = line.split_once(" = [") else { return line.to_owned() };
            if !["start_m", "target_m", "center_m"].contains(&key) {
                return line.to_owned();
            }
            let (x, y) = pair.trim_end_matches(']').split_once(", ").unwrap();
            let [x, y] = [x, y].map(|number| number.parse::<f64>().unwrap());
            format!("{key} = [{}, {}]", x + east, y + north)
        };
        let lines = |part: &String| part.lines().map(shift).collect::<Vec<_>>().join("\n");
        sides.iter().map(lines).collect::<Vec<_>>().join("\n[[obstacle]]")
    };
    let refused = World::parse("map", &written).unwrap_err().to_string();
    assert!(refused.contains("map:") && refused.contains("origin_m = [x, y]"), "{refused}");
    let with_origin = written.replacen("start_m", &format!("origin_m = [{east}, {north}]\nstart_m"), 1);
    let found = offered(&with_origin).expect("a world");
    assert_eq!(found.len(), expected.len());
    assert!((found[0].1 - expected[0].1).abs() < 1e-8 && (found[0].2 - expected[0].2).abs() < 1e-8);
    let spoiled = written.replacen("start_m", "origin_m = [0, nan]\nstart_m", 1);
    let refused = World::parse("map", &spoiled).unwrap_err().to_string();
    assert!(refused.contains("origin_m[1] = NaN"), "{refused}");
}

#[test]
fn the_width_of_free_passage_is_a_key_of_the_world() {
    let text = |key: &str| two_rooms([1.0, 2.5], [9.0, 2.5], key);
    let openings = |key: &str| World::parse("w", &text(key)).unwrap().openings.len();
    // the door is two robots wide
    assert_eq!(openings(""), 1);
    assert_eq!(openings("free_passage_robot_widths = 2.1\n"), 1);
    assert_eq!(openings("free_passage_robot_widths = 1.9\n"), 0);
    let declared = |key: &str| {
        let text = text(key) + "[[opening]]\nname = \"door\"\nbetween = [\"w4\", \"w5\"]\n";
        World::parse("w", &text).unwrap().openings[0].risk(0.5)
    };
    assert!((declared("") - 0.5).abs() < 1e-9);
    assert_eq!(declared("free_passage_robot_widths = 1.9\n"), 0.0);
    let refused = World::parse("w.toml", &text("free_passage_robot_widths = 0.5\n")).unwrap_err().to_string();
    assert!(refused.contains("w.toml:5") && refused.contains("from 1 to 100"), "{refused}");
}

#[test]
fn no_refusal_names_a_gap_of_no_width() {
    // the doorway closed by a box that leaves a crack
    let crack =
        |width: f64| two_rooms([1.0, 2.5], [9.0, 2.5], "") + &wall("door", [4.9, 2.0, 5.1, 3.0 - width]);
    let refused = |width: f64| {
        let world = World::parse("w", &crack(width)).unwrap();
        let error = OptionSet::new(&world, 10.0).map(|set| set.options().len()).unwrap_err();
        assert!(error.to_string().contains("cannot be reached from the start"), "{error}");
        error.to_string()
    };
    assert!(refused(0.3).contains("0.3000 m wide, between `w5` and `door`"), "{}", refused(0.3));
    for width in [0.0, 2e-6, 4e-5] {
        assert!(refused(width).contains("obstacles enclose it"), "{}", refused(width));
        let text = crack(width) + "[[opening]]\nname = \"crack\"\nbetween = [\"w5\", \"door\"]\n";
        let error = World::parse("w", &text).unwrap_err().to_string();
        assert!(error.contains("less than 1 mm apart") && !error.contains("0.0000"), "{error}");
    }
}

#[test]
fn the_length_of_every_option_is_shown_beside_the_shortest_one() {
    let shown = json(&["world", "environment-2", "--json"]);
    for option in shown["options"].as_array().unwrap() {
        let [length, shortest] = ["length_m", "shortest_length_m"].map(|key| option[key].as_f64().unwrap());
        assert!(shortest <= length && shortest > 0.8 * length, "{option}");
    }
    assert!(stdout(&cocarry(&["world", "environment-2"])).contains("shortest (m)"));
    // in free space the two are one
    let free = World::parse("w", &format!("{HEAD}start_m = [0, 0]\ntarget_m = [3, 4]\n")).unwrap();
    let set = OptionSet::new(&free, 10.0).unwrap();
    assert_eq!(set.shortest_lengths(&free), Some(vec![5.0]));
    for file in world_files() {
        let (world, set) = load(&file);
        for (o, shortest) in set.shortest_lengths(&world).expect("few corners").into_iter().enumerate() {
            let length = set.remaining(&set.begin(), o).length;
            assert!(shortest <= length + 1e-9, "{}: {length} m, {shortest} m", world.file);
        }
    }
}

/// A room cut by a wall with doors of 0.9 m and 1.0 m; the nearer one has ribs in its jambs, each of this place
/// and thickness (m) along the way.
fn ribbed(ribs: &[[f64; 2]]) -> World {
    let sides = [
        [-3.0, -0.2, 13.0, 0.0],
        [-3.0, 8.0, 13.0, 8.2],
        [-3.0, -0.2, -2.8, 8.2],
        [12.8, -0.2, 13.0, 8.2],
        [4.9, 0.0, 5.1, 2.0],
        [4.9, 3.0, 5.1, 5.5],
        [4.9, 6.5, 5.1, 8.0],
    ];
    let mut text = format!("{HEAD}start_m = [1.0, 3.2]\ntarget_m = [9.0, 3.2]\n");
    for (i, side) in sides.iter().enumerate() {
        text += &wall(&format!("w{i}"), *side);
    }
    for (i, [x, thick]) in ribs.iter().enumerate() {
        text += &wall(&format!("low-{i}"), [x - thick / 2.0, 2.0, x + thick / 2.0, 2.05]);
        text += &wall(&format!("high-{i}"), [x - thick / 2.0, 2.95, x + thick / 2.0, 3.0]);
    }
    World::parse("ribbed", &text).unwrap()
}

fn first_risk(world: &World) -> f64 {
    let set = OptionSet::new(world, 10.0).unwrap();
    let risk = |o: usize| set.remaining(&set.begin(), o).risk;
    let through = |o: usize| world.openings[set.options()[o].crossings[0].opening].center().y < 4.0;
    (0..set.options().len()).find(|&o| through(o)).map(risk).expect("the nearer door")
}

#[test]
fn grooves_and_ribs_in_a_doorway_are_one_opening() {
    let plain = first_risk(&ribbed(&[[5.0, 0.11]]));
    assert!((plain - 0.5 / 0.9).abs() < 1e-9);
    let groove = ribbed(&[[4.97, 0.05], [5.03, 0.05]]);
    assert_eq!(groove.openings.len(), 2);
    assert!((first_risk(&groove) - plain).abs() < 1e-9);
    assert!((first_risk(&ribbed(&[[4.93, 0.02], [5.0, 0.02], [5.07, 0.02]])) - plain).abs() < 1e-9);
}

#[test]
fn property_the_risk_of_two_frames_is_continuous_in_their_distance() {
    // two walls with a door each, the second at growing distances
    let risk = |distance: f64| {
        let mut text = format!("{HEAD}start_m = [1.0, 2.5]\ntarget_m = [9.0, 2.5]\n");
        let mut sides = vec![
            [-0.2, -0.2, 10.2, 0.0],
            [-0.2, 5.0, 10.2, 5.2],
            [-0.2, 0.0, 0.0, 5.0],
            [10.0, 0.0, 10.2, 5.0],
        ];
        for x in [4.0, 4.0 + distance] {
            sides.extend([[x, 0.0, x + 0.02, 2.0], [x, 3.0, x + 0.02, 5.0]]);
        }
        for (i, side) in sides.iter().enumerate() {
            text += &wall(&format!("w{i}"), *side);
        }
        first_risk(&World::parse("frames", &text).unwrap())
    };
    let risks: Vec<f64> = (3..160).map(|i| risk(0.01 * f64::from(i))).collect();
    assert!((risks[0] - 0.5).abs() < 1e-9 && (risks[risks.len() - 1] - 0.75).abs() < 1e-9, "{risks:?}");
    assert!(risks.is_sorted() && risks.windows(2).all(|pair| pair[1] - pair[0] < 0.01), "{risks:?}");
}
