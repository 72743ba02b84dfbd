//! The paths of options: that they do not double back, and that lengths change no more than the team moves.

use crate::support::{load, repository};
use cocarry::geometry::{Path, Piece, Point};
use cocarry::options::{OptionSet, Progress};
use cocarry::world::World;
use cocarry_studies::paper::cycles::{mixed_world, random_world};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// Random worlds that have options, with the number of their seed.
fn worlds(
    seeds: std::ops::Range<u64>,
    text: impl Fn(&mut ChaCha8Rng) -> String,
) -> impl Iterator<Item = (u64, World, OptionSet)> {
    seeds.filter_map(move |seed| {
        let text = text(&mut ChaCha8Rng::seed_from_u64(seed));
        let world = World::parse(&format!("random world {seed}"), &text).ok()?;
        let set = OptionSet::new(&world, 10.0).ok()?;
        Some((seed, world, set))
    })
}

/// Boxes by two corners, and one option through the openings between the first two and the next two.
fn world(walls: &[(&str, [f64; 2], [f64; 2])], start: [f64; 2], target: [f64; 2]) -> (World, OptionSet) {
    let mut text = format!("name = \"w\"\nrobot_width_m = 0.5\nstart_m = {start:?}\ntarget_m = {target:?}\n");
    for (name, [left, bottom], [right, top]) in walls {
        let (center, size) = ([(left + right) / 2.0, (bottom + top) / 2.0], [right - left, top - bottom]);
        text += &format!(
            "[[obstacle]]\nname = \"{name}\"\nshape = \"box\"\ncenter_m = {center:?}\nsize_m = {size:?}\nheight_m = 1\n"
        );
    }
    for (name, pair) in [("first", &walls[..2]), ("second", &walls[2..4])] {
        text += &format!("[[opening]]\nname = \"{name}\"\nbetween = [{:?}, {:?}]\n", pair[0].0, pair[1].0);
    }
    text += "[[option]]\nopenings = [\"first\", \"second\"]\n";
    let world = World::parse("w", &text).unwrap();
    let set = OptionSet::new(&world, 10.0).unwrap();
    (world, set)
}

fn degrees(path: &Path) -> f64 {
    path.sharpest_bend().to_degrees()
}

/// Every pair of consecutive pieces joins, and every point keeps the clearance.
fn assert_walkable(world: &World, path: &Path) {
    for pair in path.pieces().windows(2) {
        let gap = end(&pair[0]) - begin(&pair[1]);
        assert!(gap.norm() < 1e-9, "{}: the path jumps by {} m", world.file, gap.norm());
    }
    let steps = (path.length() / 0.02).ceil() as usize;
    for i in 0..=steps {
        let p = path.point_at(0.02 * i as f64).unwrap();
        for obstacle in &world.obstacles {
            let room = obstacle.distance_to_point(p);
            assert!(room > world.robot_width / 2.0 - 1e-5, "{}: {p} has {room} m", world.file);
        }
    }
}

fn begin(piece: &Piece) -> Point {
    Path::from(vec![*piece]).point_at(0.0).unwrap()
}

fn end(piece: &Piece) -> Point {
    Path::from(vec![*piece]).point_at(f64::INFINITY).unwrap()
}

fn mixed(rng: &mut ChaCha8Rng) -> String {
    let has_walls = rng.random_bool(0.5);
    mixed_world(rng, has_walls)
}

/// `tests/reproduction` has 1,000 worlds.
#[test]
fn property_no_option_doubles_back_in_random_worlds() {
    let walled = worlds(0..60, random_world);
    let (mut turned, mut options) = (0, 0);
    for (seed, world, set) in worlds(0..160, mixed).chain(walled) {
        let start = set.begin();
        for (o, option) in set.options().iter().enumerate() {
            let path = set.path(&start, o).expect("a path");
            assert!(degrees(&path) <= 100.0, "{seed}: option {}: {:.1}", option.name, degrees(&path));
            assert!((path.length() - set.remaining(&start, o).length).abs() < 1e-9, "{seed}");
            assert_walkable(&world, &path);
            options += 1;
            turned += usize::from(degrees(&path) > 60.0);
        }
    }
    assert!(options > 300 && turned > 50, "{turned} of {options} options have a turn worth looking at");
}

/// Two doors at right angles in the corner of a room, 0.8 m of wall from the corner to either.
#[test]
fn closed_form_two_doors_in_a_corner_are_walked_where_their_middles_meet() {
    // a passage one metre wide leads from the door in the west to the door in the north
    let walls = [
        ("west-low", [-0.1, -4.0], [0.0, -0.5]),
        ("west-high", [-0.1, 0.5], [0.0, 0.84]),
        ("north-left", [0.0, 0.85], [0.3, 0.95]),
        ("north-right", [1.3, 0.85], [8.0, 0.95]),
    ];
    let (world, set) = world(&walls, [-3.0, 0.0], [0.8, 4.0]);
    let start = set.begin();
    let path = set.path(&start, 0).unwrap();
    assert!((degrees(&path) - 90.0).abs() < 1e-6, "{} degrees", degrees(&path));
    assert!((path.length() - (3.8 + 4.0)).abs() < 1e-9, "{} m", path.length());
    assert_walkable(&world, &path);
}

/// Doors in two parallel walls 1.2 m apart, the second 3 m to the side.
#[test]
fn closed_form_shifted_doors_in_close_walls_share_the_way_between() {
    let walls = [
        ("first-low", [0.0, -6.0], [0.1, -0.5]),
        ("first-high", [0.0, 0.5], [0.1, 6.0]),
        ("second-low", [1.3, -6.0], [1.4, 2.5]),
        ("second-high", [1.3, 3.5], [1.4, 6.0]),
        ("south", [-4.0, -6.1], [6.0, -6.0]),
        ("north", [-4.0, 6.0], [6.0, 6.1]),
    ];
    let (world, set) = world(&walls, [-3.0, 0.0], [4.0, 3.0]);
    let start = set.begin();
    let path = set.path(&start, 0).unwrap();
    // it turned by 103 degrees, and was 10.78 m long
    assert!((60.0..=100.0).contains(&degrees(&path)), "{} degrees", degrees(&path));
    assert!(path.length() < 10.4, "{} m", path.length());
    assert_walkable(&world, &path);
}

/// How much an option's length changes beyond the step, where the team walks off the straight part of an
/// opening.
#[test]
fn issue_leaving_a_straight_part_sideways_changes_lengths_by_no_more_than_the_step() {
    let (world, set) = load(&repository("worlds/environment-4.toml"));
    let option = 2;
    let center = world.openings[set.options()[option].crossings[0].opening].center();
    let mut progress = set.begin();
    let path = set.path(&progress, option).unwrap();
    // as far as 0.4 m before the gap, on the axis, then along the wall
    for k in 1.. {
        set.advance(&mut progress, path.point_at(0.1 * f64::from(k)).unwrap());
        if progress.position.x > center.x - 0.4 {
            break;
        }
    }
    let mut before = set.remaining(&progress, option).length;
    for _ in 0..12 {
        let to = progress.position + cocarry::geometry::Vector::new(0.0, 0.05);
        set.advance(&mut progress, to);
        let length = set.remaining(&progress, option).length;
        assert!((length - before).abs() < 0.1, "{to}: {before} m left, then {length} m");
        before = length;
    }
}

/// A team that walks at random among options, changing between them, in steps of 0.1 m. D of an option
/// changes by no more than a step, but for steps through a gap, after which other options lead back, and
/// where two ways round an obstacle are equally good: they may join a straight part in different places, at
/// most its length apart.
#[test]
fn property_lengths_are_continuous_as_the_team_moves() {
    let (mut steps, mut changes, mut jumps, mut largest) = (0, 0, 0, 0.0_f64);
    for (seed, _, set) in worlds(0..60, mixed).chain(worlds(0..30, random_world)) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let count = set.options().len();
        let lengths = |progress: &Progress| -> Vec<f64> {
            (0..count).map(|o| set.remaining(progress, o).length).collect()
        };
        for _ in 0..6 {
            let mut progress = set.begin();
            for _ in 0..6 {
                let Some(path) = set.path(&progress, rng.random_range(0..count)) else { continue };
                for k in 1..=rng.random_range(1..40) {
                    let Some(to) = path.point_at(0.1 * f64::from(k)) else { break };
                    let is_through = set.goes_through_opening(progress.position, to);
                    let before = lengths(&progress);
                    set.advance(&mut progress, to);
                    if is_through {
                        continue;
                    }
                    for (was, is) in before.into_iter().zip(lengths(&progress)) {
                        let change = (is - was).abs();
                        changes += 1;
                        jumps += usize::from(change > 0.3);
                        largest = largest.max(change);
                    }
                    steps += 1;
                }
            }
        }
    }
    println!("{steps} steps, {changes} lengths, {jumps} jumps, {largest} m");
    assert!(steps > 5000 && largest < 1.0, "{steps} steps, {largest} m in one");
    assert!(jumps * 1000 < changes, "{jumps} jumps among {changes} lengths");
}
