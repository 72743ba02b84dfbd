//! World files, what is measured in them, and the options that come of them.

use crate::support::{cocarry, load, repository, stderr, stdout, world_files};
use cocarry::geometry::Point;
use cocarry::options::{OptionSet, Progress, Waypoint};
use cocarry::world::World;
use cocarry_studies::paper::cycles::random_world;
use parry3d::math::{Pose, Vec3};
use parry3d::query::distance;
use parry3d::shape::Segment;
use proptest::prelude::*;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

#[test]
fn every_world_of_the_repository_loads_and_offers_options() {
    let files = world_files();
    assert!(files.len() >= 5, "{files:?}");
    for file in files {
        let (world, set) = load(&file);
        assert!(!set.options().is_empty(), "{}", world.file);
        let start = set.begin();
        for (i, option) in set.options().iter().enumerate() {
            let left = set.remaining(&start, i);
            let path = set.path(&start, i).expect("a path");
            assert!((path.length() - left.length).abs() < 1e-9, "{}: option {}", world.file, option.name);
            assert!((0.0..1.0).contains(&left.risk));
        }
    }
}

#[test]
fn the_free_form_world_declares_nothing_and_has_openings_and_options() {
    let (world, set) = load(&repository("worlds/free-form.toml"));
    assert!(world.openings_detected && world.listed_options.is_empty());
    assert!(world.openings.len() >= 8, "{} openings", world.openings.len());
    assert!(set.options().len() > 1 && set.is_cut);
    for opening in &world.openings {
        assert!(opening.width > 0.5 && opening.width <= 2.5, "{}", opening.width);
    }
}

#[test]
fn enumerated_options_come_cheapest_first_and_enter_no_region_twice() {
    let (world, set) = load(&repository("worlds/free-form.toml"));
    let start = set.begin();
    let costs: Vec<f64> = (0..set.options().len())
        .map(|o| set.remaining(&start, o))
        .map(|left| left.length + 10.0 * left.risk)
        .collect();
    assert!(costs.is_sorted(), "{costs:?}");
    for option in set.options() {
        let mut openings: Vec<usize> = option.crossings.iter().map(|c| c.opening).collect();
        openings.sort_unstable();
        openings.dedup();
        assert_eq!(openings.len(), option.crossings.len(), "an opening is crossed twice");
    }
    // the whole list, by a world file that allows for it, begins with the same ones
    let text = std::fs::read_to_string(repository("worlds/free-form.toml")).unwrap();
    let more = World::parse("more", &text.replace("option_limit = 8", "option_limit = 64")).unwrap();
    let more = OptionSet::new(&more, 10.0).unwrap();
    assert_eq!(world.option_limit, 8);
    for (few, many) in set.options().iter().zip(more.options()) {
        assert_eq!(few.crossings, many.crossings);
    }
}

#[test]
fn closed_form_the_paper_environments_have_the_widths_that_their_walls_leave() {
    for file in world_files().iter().filter(|f| f.to_string_lossy().contains("environment")) {
        let (world, _) = load(file);
        for opening in &world.openings {
            // both walls run along y
            let [a, b] = opening.between.map(|i| world.obstacles[i].bounds());
            let gap = (b.min.y - a.max.y).max(a.min.y - b.max.y);
            assert!((opening.width - gap).abs() < 1e-9, "{}: {} not {gap}", opening.name, opening.width);
            assert!((opening.center().x - (a.min.x + a.max.x) / 2.0).abs() < 1e-9);
            assert!(opening.axis().y.abs() < 1e-9);
        }
    }
}

/// The openings that the paper's environments declare are the ones that would be detected.
#[test]
fn openings_that_are_declared_are_also_detected() {
    for file in world_files().iter().filter(|f| f.to_string_lossy().contains("environment")) {
        let (declared, _) = load(file);
        let text = std::fs::read_to_string(file).unwrap();
        let detected = World::parse("stripped", &text[..text.find("[[opening]]").unwrap()]).unwrap();
        for opening in &declared.openings {
            let found = detected.openings.iter().any(|d| {
                let (mut a, mut b) = (d.between, opening.between);
                a.sort_unstable();
                b.sort_unstable();
                a == b && (d.width - opening.width).abs() < 1e-12
            });
            assert!(found, "{}: {} is not detected", declared.file, opening.name);
        }
    }
}

#[test]
fn closed_form_between_four_pillars_only_the_sides_count_as_openings() {
    let mut text =
        "name = \"pillars\"\nrobot_width_m = 0.5\nstart_m = [-5.0, 0.0]\ntarget_m = [5.0, 0.0]\n".to_owned();
    for (i, (x, y)) in [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)].iter().enumerate() {
        text += &format!(
            "[[obstacle]]\nname = \"p{i}\"\nshape = \"cylinder\"\ncenter_m = [{x}, {y}]\nradius_m = 0.3\nheight_m = 1\n"
        );
    }
    let world = World::parse("pillars", &text).unwrap();
    // from A toward B, then from left to right
    let pairs: Vec<_> = world.openings.iter().map(|o| o.between).collect();
    assert_eq!(pairs, [[1, 2], [0, 1], [2, 3], [0, 3]]);
    for opening in &world.openings {
        assert!((opening.width - 1.4).abs() < 1e-6, "{}", opening.width);
        assert!((opening.risk(0.5) - 0.5 / opening.width).abs() < 1e-15);
    }
}

#[test]
fn closed_form_risk_is_zero_in_free_passage_and_one_where_nothing_passes() {
    let (world, _) = load(&repository("worlds/environment-4.toml"));
    let opening = &world.openings[0];
    assert_eq!(opening.risk(opening.width / 6.0), 0.0);
    assert_eq!(opening.risk(opening.width * 2.0), 1.0);
}

/// The hand-written distances to outlines against parry's to the solids that are made of the same entries.
#[test]
fn property_footprints_agree_with_parry() {
    let (world, _) = load(&repository("worlds/free-form.toml"));
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let coordinate = || -1.0..15.0f64;
    let points = (coordinate(), coordinate(), coordinate(), coordinate());
    runner
        .run(&points, |(ax, ay, bx, by)| {
            for obstacle in &world.obstacles {
                let (pose, shape) = obstacle.parts[0].solid();
                let height = obstacle.height / 2.0;
                let segment = Segment::new(Vec3::new(ax, ay, height), Vec3::new(bx, by, height));
                let parry = distance(&Pose::IDENTITY, &segment, &pose, shape).expect("supported").distance;
                let ours = obstacle.distance_to_segment(Point::new(ax, ay), Point::new(bx, by));
                prop_assert!((parry - ours).abs() < 1e-5, "{}: {parry} and {ours}", obstacle.name);
            }
            Ok(())
        })
        .unwrap();
}

/// Walks an option to its end: D falls by the step, S never rises, and the openings are crossed in order.
fn walk(world: &World, set: &OptionSet, o: usize) {
    let option = &set.options()[o];
    let context = || format!("{}: option {}", world.file, option.name);
    let mut progress = set.begin();
    let path = set.path(&progress, o).unwrap_or_else(|| panic!("{}: no path", context()));
    let mut before = set.remaining(&progress, o);
    assert!((path.length() - before.length).abs() < 1e-9, "{}", context());
    let mut passed = Vec::new();
    let steps = (path.length() / 0.1).ceil() as usize;
    for k in 1..=steps {
        let from = progress.position;
        set.advance(&mut progress, path.point_at(0.1 * k as f64).unwrap());
        let left = set.remaining(&progress, o);
        let step = if k == steps { before.length } else { 0.1 };
        let (was, is, at) = (before.length, left.length, progress.position);
        assert!((was - is - step).abs() < 1e-6, "{} at {at}: {was} m left, then {is} m", context());
        assert!(left.risk <= before.risk + 1e-12, "{} at {at}", context());
        passed.extend(set.crossings(from, at));
        // next is the opening that was crossed last, until its straight part is left, or the one after it
        let crossed = passed.last().map(|&crossing| Waypoint::Opening(crossing));
        let onward = option.crossings.get(passed.len()).map_or(Waypoint::Target, |&c| Waypoint::Opening(c));
        assert!(left.next == onward || Some(left.next) == crossed, "{} at {at}: {:?}", context(), left.next);
        before = left;
    }
    assert_eq!(passed, option.crossings, "{}", context());
}

#[test]
fn property_what_is_left_of_an_option_shrinks_as_it_is_walked() {
    for file in world_files() {
        let (world, set) = load(&file);
        for o in 0..set.options().len() {
            walk(&world, &set, o);
        }
    }
}

#[test]
fn property_options_of_random_worlds_can_be_walked() {
    let mut walked = 0;
    for seed in 0..120 {
        let text = random_world(&mut ChaCha8Rng::seed_from_u64(seed));
        let Ok(world) = World::parse(&format!("random world {seed}"), &text) else { continue };
        let Ok(set) = OptionSet::new(&world, 10.0) else { continue };
        for o in 0..set.options().len() {
            walk(&world, &set, o);
            walked += 1;
        }
    }
    assert!(walked > 200, "only {walked} options were walked");
}

/// Whatever numbers stand in a world file, it is a world or it is refused.
#[test]
fn property_no_numbers_make_a_world_file_panic() {
    let text = std::fs::read_to_string(repository("worlds/free-form.toml")).unwrap();
    let is_digit = |c: char| c.is_ascii_digit() || c == '.' || c == '-';
    let spots: Vec<(usize, usize)> = text
        .match_indices(['[', ' '])
        .map(|(at, _)| at + 1)
        .filter(|&at| text[at..].starts_with(|c: char| c.is_ascii_digit() || c == '-'))
        .map(|at| (at, at + text[at..].find(|c| !is_digit(c)).unwrap_or(0)))
        .collect();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let values =
        ["0.0", "-1.0", "1e-9", "0.001", "0.5", "3.0", "6.9", "1e4", "1e5", "nan", "inf", "-0.0", "1e300"];
    let (mut worlds, mut refused) = (0, 0);
    for _ in 0..600 {
        let mut spoiled = text.clone();
        for _ in 0..rng.random_range(1..4) {
            let (from, to) = spots[rng.random_range(0..spots.len())];
            let value = values[rng.random_range(0..values.len())];
            // only where the earlier replacements left the length alone
            if spoiled.len() == text.len() {
                spoiled.replace_range(from..to, value);
            }
        }
        match World::parse("spoiled", &spoiled) {
            Err(error) => {
                assert!(error.to_string().contains("spoiled"), "{error}");
                refused += 1;
            }
            Ok(world) => {
                let _ = OptionSet::new(&world, 10.0).map(|set| set.remaining(&set.begin(), 0));
                worlds += 1;
            }
        }
    }
    assert!(worlds > 50 && refused > 50, "{worlds} worlds, {refused} refused");
}

/// The team after walking an option from the start until it is `beyond` metres past the first opening.
fn past_first_opening(world: &World, set: &OptionSet, option: usize, beyond: f64) -> Progress {
    let mut progress = set.begin();
    let path = set.path(&progress, option).unwrap();
    let center = world.openings[set.options()[option].crossings[0].opening].center();
    let steps = (path.length() / 0.1) as usize;
    for k in 1..steps {
        set.advance(&mut progress, path.point_at(0.1 * k as f64).unwrap());
        if progress.position.x >= center.x + beyond {
            return progress;
        }
    }
    panic!("the opening is not passed");
}

/// Two options that meet in a region share their rest.
#[test]
fn closed_form_options_that_meet_share_their_rest() {
    let (world, set) = load(&repository("worlds/environment-4.toml"));
    let progress = past_first_opening(&world, &set, 2, 1.5);
    assert_eq!(set.remaining(&progress, 2).risk, 0.0);
    assert_eq!(set.remaining(&progress, 2).next, Waypoint::Target);
    assert_eq!(set.remaining(&progress, 3), set.remaining(&progress, 2));
}

/// The opening under way counts, at its risk, until the team is out of its straight part.
#[test]
fn closed_form_an_opening_counts_until_its_straight_part_is_left() {
    let (world, set) = load(&repository("worlds/environment-4.toml"));
    let opening = &world.openings[set.options()[2].crossings[0].opening];
    let inside = past_first_opening(&world, &set, 2, 0.5);
    assert!((set.remaining(&inside, 2).risk - opening.risk(0.5)).abs() < 1e-12);
    // another option goes on to the end of the straight part as well, then shares the rest
    assert_eq!(set.remaining(&inside, 3).length, set.remaining(&inside, 2).length);
}

/// An option that the team has left leads back through the opening just crossed, at its length and risk.
#[test]
fn closed_form_an_option_that_was_left_leads_back() {
    let (world, set) = load(&repository("worlds/environment-1.toml"));
    let (through_2, direct) = (1, 3);
    let crossing = set.options()[through_2].crossings[0];
    let center = world.openings[crossing.opening].center();
    let progress = past_first_opening(&world, &set, through_2, 1.2);
    let left = set.remaining(&progress, direct);
    assert_eq!(left.next, Waypoint::Opening(crossing.back()));
    let risks =
        [crossing.opening, set.options()[direct].crossings[0].opening].map(|i| world.openings[i].risk(0.5));
    assert!((left.risk - (1.0 - (1.0 - risks[0]) * (1.0 - risks[1]))).abs() < 1e-12);
    let back = (progress.position - center).norm() + (center - world.start).norm();
    assert!(left.length > back, "{} m is shorter than the way back, {back} m", left.length);
}

#[test]
fn what_is_carried_is_a_beam_unless_the_file_says_otherwise() {
    let text = "name = \"w\"\nrobot_width_m = 0.5\nstart_m = [0, 0]\ntarget_m = [9, 0]\n";
    let object = World::parse("w.toml", text).unwrap().object;
    assert_eq!((object.shape.name(), object.size, object.mass), ("beam", [1.2, 0.1, 0.1], 4.0));
    let text = format!("{text}[object]\nshape = \"board\"\nsize_m = [2, 0.8, 0.03]\nmass_kg = 9\n");
    let object = World::parse("w.toml", &text).unwrap().object;
    assert_eq!((object.shape.name(), object.size, object.mass), ("board", [2.0, 0.8, 0.03], 9.0));
}

#[test]
fn a_gap_that_is_too_narrow_is_told_where_openings_are_detected() {
    let folder = tempfile::tempdir().unwrap();
    let made = cocarry(&["new", folder.path().join("lab").to_str().unwrap()]);
    assert!(made.status.success(), "{}", stderr(&made));
    let file = folder.path().join("lab/world.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    let told = |text: &str| {
        std::fs::write(&file, text).unwrap();
        stdout(&cocarry(&["world", file.to_str().unwrap()]))
    };
    assert!(!told(&text).contains("too narrow"));
    // the island is longer by 0.8 m
    let longer = told(&text.replace("size_m = [0.8, 2.4]", "size_m = [0.8, 3.2]"));
    let line = "too narrow for a robot 0.5 m wide: island to partition north (0.40 m)";
    assert!(longer.contains(line), "{longer}");
}
