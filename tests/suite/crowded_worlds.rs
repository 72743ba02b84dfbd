//! Worlds of many obstacles: what can be reached is not refused, and what is refused is refused at once.

use crate::support::{cocarry, stderr};
use cocarry::options::OptionSet;
use cocarry::world::World;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::fmt::Write;

fn head(start: [f64; 2], target: [f64; 2]) -> String {
    format!("name = \"crowded\"\nrobot_width_m = 0.5\nstart_m = {start:?}\ntarget_m = {target:?}\n")
}

fn add_box(text: &mut String, [x, y]: [f64; 2], size: [f64; 2], yaw: f64) {
    let i = text.matches("[[obstacle]]").count();
    let place = format!("center_m = [{x:?}, {y:?}]\nsize_m = {size:?}\nyaw_deg = {yaw:?}\nheight_m = 1.0");
    writeln!(text, "\n[[obstacle]]\nname = \"o{i}\"\nshape = \"box\"\n{place}").unwrap();
}

/// A room from the origin to (x, y).
fn add_room(text: &mut String, [x, y]: [f64; 2]) {
    for (center, size) in [
        ([x / 2.0, -0.1], [x + 0.4, 0.2]),
        ([x / 2.0, y + 0.1], [x + 0.4, 0.2]),
        ([-0.1, y / 2.0], [0.2, y + 0.4]),
        ([x + 0.1, y / 2.0], [0.2, y + 0.4]),
    ] {
        add_box(text, center, size, 0.0);
    }
}

/// Walls 12 m long, 2 m apart, each with three doors about 1 m wide.
fn walls_with_doors(count: usize, rng: &mut ChaCha8Rng) -> String {
    let mut text = head([-1.0, 6.0], [2.0 * count as f64 + 1.0, 6.0]);
    for i in 0..count {
        let mut from = 0.0;
        for door in 1..=4 {
            let to = if door == 4 { 12.0 } else { 3.0 * f64::from(door) - rng.random_range(0.2..0.8) };
            add_box(&mut text, [2.0 * i as f64 + 1.0, (from + to) / 2.0], [0.2, to - from], 0.0);
            from = to + rng.random_range(0.8..1.2);
        }
    }
    text
}

/// Boxes near the points of a square grid with this pitch (m), from 2 m on.
fn clutter(count: usize, pitch: f64, target: [f64; 2], rng: &mut ChaCha8Rng) -> String {
    let columns = (count as f64).sqrt().ceil() as usize;
    let mut text = head([0.8, 2.0 + pitch * columns as f64 / 2.0], target);
    for i in 0..count {
        let mut around = |k: usize| 2.0 + pitch * (k as f64 + 0.5 + rng.random_range(-0.2..0.2));
        let center = [around(i % columns), around(i / columns)];
        let size = [rng.random_range(0.4..1.0), rng.random_range(0.4..1.0)];
        add_box(&mut text, center, size, rng.random_range(0.0..90.0));
    }
    text
}

fn options(text: &str) -> (World, Result<OptionSet, cocarry::Error>) {
    let world = World::parse("crowded", text).unwrap_or_else(|e| panic!("{e}"));
    let set = OptionSet::new(&world, 10.0);
    (world, set)
}

#[test]
fn a_way_around_walls_in_the_open_is_the_only_option() {
    let text = walls_with_doors(12, &mut ChaCha8Rng::seed_from_u64(1));
    let (world, set) = options(&text);
    let set = set.unwrap();
    assert!(world.openings.len() >= 36);
    assert_eq!(set.options().len(), 1);
    assert!(set.options()[0].crossings.is_empty() && !set.is_cut);
}

#[test]
fn options_into_a_room_behind_many_walls_are_found() {
    // from outside into the space between the last two walls, and from room to room
    let text = walls_with_doors(12, &mut ChaCha8Rng::seed_from_u64(2));
    let inside = text.replace("target_m = [25.0, 6.0]", "target_m = [22.0, 6.0]");
    let rooms = inside.replace("start_m = [-1.0, 6.0]", "start_m = [2.0, 6.0]");
    for text in [inside, rooms] {
        let (_, set) = options(&text);
        let set = set.unwrap();
        assert!(set.options().len() == 8 && set.is_cut && !set.is_search_cut);
    }
}

#[test]
fn clutter_of_hundreds_of_obstacles_is_crossed() {
    for (count, closed) in [(289, false), (600, true)] {
        let rng = &mut ChaCha8Rng::seed_from_u64(count as u64);
        let side = 2.0 * (count as f64).sqrt().ceil() + 4.0;
        let mut text = clutter(count, 2.0, [side - 0.8, side / 2.0], rng);
        if closed {
            add_room(&mut text, [side, side]);
        }
        let (world, set) = options(&text);
        let set = set.unwrap();
        assert!(world.openings.len() > count);
        let costs: Vec<f64> = (0..set.options().len())
            .map(|o| set.remaining(&set.begin(), o))
            .map(|left| left.length + 10.0 * left.risk)
            .collect();
        assert!(costs.is_sorted() && costs[0].is_finite(), "{costs:?}");
        assert!(!set.is_search_cut);
    }
}

#[test]
fn a_team_beside_an_opening_that_no_option_uses_still_has_a_path() {
    // a chamber above the hall, with a door that leads nowhere
    let mut text = head([1.0, 2.0], [9.0, 2.0]);
    add_room(&mut text, [10.0, 8.0]);
    add_box(&mut text, [2.0, 4.0], [4.0, 0.2], 0.0);
    add_box(&mut text, [7.6, 4.0], [4.8, 0.2], 0.0);
    let (world, set) = options(&text);
    let set = set.unwrap();
    assert!(!set.uses(0) && world.openings.len() == 1);
    let mut progress = set.begin();
    for to in [[4.6, 2.0], [4.6, 3.5], [4.6, 4.6], [4.6, 6.0], [3.0, 6.5]] {
        set.advance(&mut progress, to.into());
        let left = set.remaining(&progress, 0);
        let path = set.path(&progress, 0).expect("a path back");
        assert!((path.length() - left.length).abs() < 1e-9 && left.length.is_finite());
    }
    assert!((set.remaining(&progress, 0).risk - world.openings[0].risk(0.5)).abs() < 1e-12);
}

#[test]
fn a_gap_declared_twice_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = head([1.0, 2.0], [9.0, 2.0]);
    add_room(&mut text, [10.0, 4.0]);
    add_box(&mut text, [5.0, 0.75], [0.2, 1.5], 0.0);
    add_box(&mut text, [5.0, 3.25], [0.2, 1.5], 0.0);
    for i in 0..1000 {
        writeln!(text, "[[opening]]\nname = \"d{i}\"\nbetween = [\"o4\", \"o5\"]").unwrap();
    }
    let path = folder.path().join("twice.toml");
    std::fs::write(&path, text).unwrap();
    let output = cocarry(&["world", path.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("opening `d1`: this is the same gap as opening `d0`"), "{output:?}");
}

#[test]
fn a_world_too_large_to_be_searched_is_refused_before_the_search() {
    let rng = &mut ChaCha8Rng::seed_from_u64(4);
    let (_, set) = options(&clutter(4000, 4.0, [260.0, 130.0], rng));
    let error = set.map(|set| set.options().len()).unwrap_err();
    assert!(error.to_string().contains("too many obstacles in an open world (4000)"), "{error}");
    assert!(!error.to_string().contains("cannot be reached"), "{error}");
}

/// A wall with doors a metre wide, every two metres, between two halls.
fn doors(count: usize) -> String {
    let length = 2.0 * count as f64;
    let mut text = head([0.0, length / 2.0], [8.0, length / 2.0 + 3.0]);
    for i in 0..=count {
        add_box(&mut text, [4.0, 2.0 * i as f64], [0.2, 1.0], 0.0);
    }
    for (center, size) in [
        ([4.0, -0.6], [30.0, 0.2]),
        ([4.0, length + 0.6], [30.0, 0.2]),
        ([-11.0, length / 2.0], [0.2, length + 1.4]),
        ([19.0, length / 2.0], [0.2, length + 1.4]),
    ] {
        add_box(&mut text, center, size, 0.0);
    }
    text
}

#[test]
fn the_nearest_of_many_doors_are_the_options() {
    let (world, set) = options(&doors(40));
    let set = set.unwrap();
    assert_eq!((world.openings.len(), set.options().len(), set.is_cut), (40, 8, true));
    let risk = world.openings[0].risk(0.5);
    for (o, option) in set.options().iter().enumerate() {
        let [crossing] = option.crossings[..] else { panic!("{option:?}") };
        let left = set.remaining(&set.begin(), o);
        assert!((world.openings[crossing.opening].center().y - 41.5).abs() < 9.0 && left.risk <= risk + 1e-9);
    }
    // so many that paths along the wall would take gigabytes
    let error = options(&doors(1000)).1.map(|set| set.options().len()).unwrap_err();
    let expected = "crowded: too many obstacles in an open world (1005): more than 4000000 clear lines between \
                    their corners, which is the limit; use fewer obstacles, or fewer corners (a cylinder has none)";
    assert_eq!(error.to_string(), expected);
}
