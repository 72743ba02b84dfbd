//! The roadmap compared with a slow reference: a dense visibility graph around outlines made of many short
//! sides.

use super::*;
use crate::geometry::Path;
use crate::geometry::{Footprint, Solid, Vector, direction, left_of};
use crate::math;
use crate::options::{passages, straights};
use crate::world::World;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

const CLEARANCE: f64 = 0.25;
const SIDES: usize = 48;

fn random_space(rng: &mut ChaCha8Rng) -> Space {
    Space::new(&random_outlines(rng), Vec::new(), CLEARANCE)
}

fn random_outlines(rng: &mut ChaCha8Rng) -> Vec<Solid> {
    let outlines = (0..7).map(|_| {
        let center = Point::new(rng.random_range(1.0..9.0), rng.random_range(0.0..6.0));
        let radius = rng.random_range(0.2..1.2);
        if rng.random_bool(0.4) {
            return Footprint::Disc { center, radius };
        }
        let (corners, turn) = (rng.random_range(3..6), rng.random_range(0.0..TAU));
        let corner = |i: usize| center + direction(turn + TAU * i as f64 / corners as f64) * radius;
        Footprint::Polygon((0..corners).map(corner).collect())
    });
    outlines.map(Solid::single).collect()
}

fn roadmap(space: Space, sites: &[Point]) -> Roadmap {
    let sites: Vec<Straight> = sites.iter().copied().map(Straight::from).collect();
    Roadmap::new(space, &sites, &[]).expect("few lines")
}

/// The shortest path along straight lines between the corners of polygons circumscribed about the discs.
fn slow_distance(space: &Space, from: Point, to: Point) -> f64 {
    let mut points = vec![from, to];
    for disc in &space.discs {
        let outer = disc.radius / math::cos(PI / SIDES as f64);
        let corner = |s: usize| disc.center + direction(TAU * s as f64 / SIDES as f64) * outer;
        points.extend((0..SIDES).map(corner).filter(|p| space.is_clear(*p, *p)));
    }
    let mut left = vec![f64::INFINITY; points.len()];
    let mut done = vec![false; points.len()];
    left[0] = 0.0;
    while let Some(i) = (0..points.len()).filter(|&i| !done[i]).min_by(|&a, &b| left[a].total_cmp(&left[b])) {
        if i == 1 || left[i].is_infinite() {
            break;
        }
        done[i] = true;
        for j in 0..points.len() {
            let length = left[i] + (points[j] - points[i]).norm();
            if !done[j] && length < left[j] && space.is_clear(points[i], points[j]) {
                left[j] = length;
            }
        }
    }
    left[1]
}

#[test]
fn property_no_point_of_a_buried_disc_is_clear() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let (mut buried, mut open) = (0, 0);
    for _ in 0..60 {
        let outlines = [random_outlines(&mut rng), random_outlines(&mut rng)].concat();
        let space = Space::new(&outlines, Vec::new(), CLEARANCE);
        for disc in &space.discs {
            if !space.is_buried(disc) {
                open += 1;
                continue;
            }
            buried += 1;
            let angles = (0..1000).map(|i| TAU * f64::from(i) / 1000.0).filter(|&angle| disc.is_taut(angle));
            for p in angles.map(|angle| disc.at(angle)) {
                assert!(!space.is_clear(p, p), "{disc:?} at {p}");
            }
        }
    }
    assert!(buried > 500 && open > 500, "{buried} buried, {open} open");
}

#[test]
fn property_distances_agree_with_a_dense_visibility_graph() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let (mut compared, mut bent) = (0, 0);
    while compared < 25 {
        let space = random_space(&mut rng);
        let ends =
            [Point::new(0.0, rng.random_range(0.0..6.0)), Point::new(10.0, rng.random_range(0.0..6.0))];
        if ends.iter().any(|p| space.clearance_at(*p) < CLEARANCE) {
            continue;
        }
        let slow = slow_distance(&space, ends[0], ends[1]);
        let roadmap = roadmap(space, &ends);
        let exact = roadmap.leg(ends[0], 1).length;
        assert_eq!(exact, roadmap.between(0, 1).length, "the query and the table disagree");
        // the reference follows circumscribed polygons: never shorter, and longer by no more than their
        // excess
        assert!(exact <= slow + 1e-9, "exact {exact}, slow {slow}");
        assert!(slow <= exact * 1.003, "exact {exact}, slow {slow}");
        compared += 1;
        bent += usize::from(exact > (ends[1] - ends[0]).norm() + 1e-6);
    }
    assert!(bent > 15, "too few of the worlds were worth comparing: {bent}");
}

#[test]
fn property_paths_have_the_length_that_is_said_and_keep_clear() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    for _ in 0..60 {
        let space = random_space(&mut rng);
        let ends = [Point::new(0.0, 3.0), Point::new(10.0, rng.random_range(0.0..6.0))];
        if ends.iter().any(|p| space.clearance_at(*p) < CLEARANCE) {
            continue;
        }
        let roadmap = roadmap(space, &ends);
        let mut path = Path::default();
        assert_eq!(roadmap.extend(&mut path, ends[0], 1), Some(ends[1]));
        assert!((path.length() - roadmap.leg(ends[0], 1).length).abs() < 1e-9);
        let mut before = ends[0];
        for i in 0..=500 {
            let p = path.point_at(path.length() * f64::from(i) / 500.0).unwrap();
            assert!(roadmap.space.clearance_at(p) > CLEARANCE - 1e-5, "{p} has no room");
            assert!((p - before).norm() <= path.length() / 500.0 + 1e-9, "the path jumps at {p}");
            before = p;
        }
        assert!((before - ends[1]).norm() < 1e-9);
    }
}

#[test]
fn closed_form_a_string_around_a_pillar() {
    let pillar = Footprint::Disc { center: Point::new(0.0, 0.0), radius: 0.75 };
    let space = Space::new(&[Solid::single(pillar)], Vec::new(), CLEARANCE);
    let ends = [Point::new(-2.0, 0.0), Point::new(2.0, 0.0)];
    // two tangents of length sqrt(3) and an arc of pi / 3 on the unit circle
    let expected = 2.0 * 3f64.sqrt() + PI / 3.0;
    let roadmap = roadmap(space, &ends);
    assert!((roadmap.between(0, 1).length - expected).abs() < 1e-12);
}

#[test]
fn closed_form_a_barrier_is_walked_around() {
    let pillars =
        [Point::new(0.0, 1.0), Point::new(0.0, -1.0)].map(|center| Footprint::Disc { center, radius: 0.2 });
    let pillars = pillars.map(Solid::single);
    let ends = [Point::new(-3.0, 0.0), Point::new(3.0, 0.0)];
    let barrier = [Point::new(0.0, -0.8), Point::new(0.0, 0.8)];
    let open = roadmap(Space::new(&pillars, Vec::new(), CLEARANCE), &ends);
    let closed = roadmap(Space::new(&pillars, vec![barrier], CLEARANCE), &ends);
    assert_eq!(open.between(0, 1).length, 6.0);
    assert!(closed.between(0, 1).length > 6.3);
}

#[test]
fn issue_a_team_too_near_to_an_obstacle_still_finds_its_way() {
    let wall = Footprint::Polygon(
        [(-1.0, -0.1), (1.0, -0.1), (1.0, 0.1), (-1.0, 0.1)].map(|(x, y)| Point::new(x, y)).to_vec(),
    );
    let ends = [Point::new(0.0, -2.0), Point::new(0.0, 2.0)];
    let roadmap = roadmap(Space::new(&[Solid::single(wall)], Vec::new(), CLEARANCE), &ends);
    let near = ends[1] - Vector::new(0.0, 1.7);
    assert!((roadmap.leg(near, 1).length - 1.7).abs() < 1e-12);
    assert!(roadmap.leg(near, 0).length.is_finite());
}

/// A field of boxes and cylinders so far apart (m), with the target at this place.
fn field(rng: &mut ChaCha8Rng, columns: usize, pitch: f64, target: [f64; 2]) -> World {
    use std::fmt::Write;
    let mut text =
        format!("name = \"field\"\nrobot_width_m = 0.5\nstart_m = [-1, 6]\ntarget_m = {target:?}\n");
    for i in 0..columns * columns {
        let mut around = |k: usize| pitch * (k as f64 + rng.random_range(0.3..0.7));
        let [x, y] = [around(i % columns), around(i / columns)];
        let shape = match rng.random_bool(0.5) {
            true => format!("shape = \"cylinder\"\nradius_m = {:.3}", rng.random_range(0.2..0.6)),
            false => format!(
                "shape = \"box\"\nsize_m = [{:.3}, {:.3}]\nyaw_deg = {:.1}",
                rng.random_range(0.3..1.1),
                rng.random_range(0.3..1.1),
                rng.random_range(0.0..90.0)
            ),
        };
        let place = format!("center_m = [{x:.3}, {y:.3}]\nheight_m = 1\n{shape}");
        writeln!(text, "[[obstacle]]\nname = \"o{i}\"\n{place}").unwrap();
    }
    World::parse("field", &text).unwrap_or_else(|error| panic!("{error}"))
}

/// The lines that are left out, because something hides the end, against all lines.
#[test]
fn oracle_no_line_is_missed_behind_what_hides_the_rest_of_a_view() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    // crowded, where most gaps are too narrow, and with room, but for the straight parts of many gaps
    for (columns, pitch, target) in [(10, 1.0, [14.0, 6.0]), (10, 1.0, [14.0, 6.0]), (8, 2.5, [11.25, 10.0])]
    {
        let world = field(&mut rng, columns, pitch, target);
        let barriers: Vec<[Point; 2]> = world.openings.iter().map(|gap| gap.ends).collect();
        let closed: Vec<[Point; 2]> = world.closed_gaps().iter().map(|gap| gap.ends).collect();
        let space = || Space::new(&world.solids, barriers.clone(), CLEARANCE);
        let sites = straights([world.start, world.target], &passages(&world, &space()));
        let sights = [Sight::new(&space(), &closed), Sight::open()];
        let [fast, all] = sights.each_ref().map(|sight| Roadmap::in_sight(sight, space(), &sites).unwrap());
        assert_eq!(fast.graph.edge_count(), all.graph.edge_count(), "a line is missing");
        let discs = &all.space.discs;
        let lines = sights.map(|sight| Reachable::new(&sight, &space(), discs, &sites).lines());
        assert!(lines[0] < lines[1] / 2, "{lines:?}");
        let mut found = 0;
        for to in 0..sites.len() {
            for from in 0..sites.len() {
                let [a, b] = [&fast, &all].map(|roadmap| roadmap.between(from, to));
                assert_eq!([a.length, a.depth], [b.length, b.depth], "from {from} to {to}");
                found += usize::from(a.length.is_finite());
            }
        }
        assert!(found > 2 * sites.len(), "{found} paths between {} sites", sites.len());
    }
}

/// Where a path joins a straight part, against places along it: 2 cm apart, then half a millimetre about the
/// best of these.
#[test]
fn oracle_a_path_joins_a_straight_part_where_its_cost_is_least() {
    const REACH: f64 = 0.8;
    const APART: f64 = 0.02;
    let mut rng = ChaCha8Rng::seed_from_u64(21);
    let (mut compared, mut blocked) = (0, 0);
    while compared < 40 {
        let outlines = random_outlines(&mut rng);
        let mut point = || Point::new(rng.random_range(1.0..9.0), rng.random_range(0.0..6.0));
        let [p, center] = [point(), point()];
        let outward = direction(rng.random_range(0.0..TAU));
        let straight = Straight { center, outward, reach: REACH, barrier: Some(0) };
        let gap = left_of(outward) * 20.0;
        let space = || Space::new(&outlines, vec![[center - gap, center + gap]], CLEARANCE);
        let is_in_front = straight.depth(p) > 0.0 && space().clearance_at(p) == CLEARANCE;
        if !is_in_front || !space().is_clear_of_obstacles(center, straight.portal()) {
            continue;
        }
        let cost = |length: f64, depth: f64| length + straight::MAX_BACKWARD * (REACH - depth);
        let cheapest = |depths: &[f64]| {
            let sites: Vec<Straight> = depths.iter().map(|depth| straight.at(*depth).into()).collect();
            let roadmap = Roadmap::new(space(), &sites, &[]).expect("few lines");
            let costs = depths.iter().enumerate().map(|(i, d)| (cost(roadmap.leg(p, i).length, *d), *d));
            costs.min_by(|a, b| a.0.total_cmp(&b.0)).expect("there are depths")
        };
        let steps = |from: f64, by: f64| (1..=40).map(move |i| (from + by * f64::from(i)).clamp(1e-6, REACH));
        let (_, near) = cheapest(&steps(0.0, APART).collect::<Vec<_>>());
        let (slow, _) = cheapest(&steps(near - APART, APART / 20.0).collect::<Vec<_>>());
        let roadmap = Roadmap::new(space(), std::slice::from_ref(&straight), &[]).expect("few lines");
        let Leg { length, depth } = roadmap.leg(p, 0);
        if slow.is_infinite() {
            assert!(length.is_infinite());
            continue;
        }
        let fast = cost(length, depth);
        assert!((fast - slow).abs() <= 0.001, "from {p} to {center}: {fast} m, not {slow} m");
        compared += 1;
        blocked += usize::from(
            straight.best_join(p).is_none_or(|join| !roadmap.space.can_join(p, join.to, &straight)),
        );
    }
    assert!(blocked > 10, "too few of the joins were worth comparing: {blocked}");
}
