//! Options along walks: a gap is behind the team for all options or for none, and the option that is walked
//! gets cheaper by every step. Both together exclude locked cycles while alpha, gamma and phi stay.

use cocarry::geometry::Path;
use cocarry::options::{Crossing, OptionSet, Progress, Waypoint};
use cocarry::world::World;
use cocarry_studies::paper::cycles::{mixed_world, random_world};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// The length of a step, m.
const STEP: f64 = 0.1;

/// The options of a random world; `None` where it has none, or one.
fn options(rng: &mut ChaCha8Rng) -> Option<OptionSet> {
    let (is_mixed, has_walls) = (rng.random_bool(0.3), rng.random_bool(0.5));
    let text = if is_mixed { mixed_world(rng, has_walls) } else { random_world(rng) };
    let set = OptionSet::new(&World::parse("random", &text).ok()?, 10.0).ok()?;
    (set.options().len() > 1).then_some(set)
}

/// A team that changes its option at random: `seen` has the progress before and after every step, with the
/// option walked and the last crossing. Steps end at the bends of paths too: a path may lead to the end of a
/// straight part and back.
fn walk(
    set: &OptionSet,
    rng: &mut ChaCha8Rng,
    mut seen: impl FnMut(&Progress, &Progress, usize, Option<Crossing>),
) {
    let mut progress = set.begin();
    let mut last = None;
    for _ in 0..8 {
        let option = rng.random_range(0..set.options().len());
        let Some(path) = set.path(&progress, option) else { continue };
        let until = path.length().min(STEP * f64::from(rng.random_range(1..30)));
        let mut bends: Vec<f64> = path
            .pieces()
            .iter()
            .scan(0.0, |along, piece| {
                *along += Path::from(vec![*piece]).length();
                Some(*along)
            })
            .collect();
        bends.retain(|along| *along < until);
        let mut stops: Vec<f64> =
            (1..30).map(|k| STEP * f64::from(k)).take_while(|along| *along < until).collect();
        stops.extend(bends);
        stops.sort_by(f64::total_cmp);
        for along in stops {
            let before = progress.clone();
            let to = path.point_at(along).expect("a point of the path");
            last = set.crossing(progress.position, to).or(last);
            set.advance(&mut progress, to);
            seen(&before, &progress, option, last);
        }
    }
}

#[test]
fn property_a_gap_is_behind_the_team_for_all_options_or_for_none() {
    let mut rng = ChaCha8Rng::seed_from_u64(37);
    let (mut worlds, mut positions) = (0, 0);
    while worlds < 1000 {
        let Some(set) = options(&mut rng) else { continue };
        worlds += 1;
        walk(&set, &mut rng, |_, progress, _, last| {
            let Some(crossing) = last else { return };
            let next = |o: usize| set.remaining(progress, o).next;
            let is_being_crossed = |o: &usize| next(*o) == Waypoint::Opening(crossing);
            let all = 0..set.options().len();
            if all.clone().any(|o| is_being_crossed(&o)) {
                positions += 1;
                for o in all {
                    let is_back = next(o) == Waypoint::Opening(crossing.back());
                    assert!(
                        is_being_crossed(&o) || is_back,
                        "option {o} at {}: {:?}",
                        progress.position,
                        next(o)
                    );
                }
            }
        });
    }
    assert!(positions > 2_000, "{positions} positions in straight parts");
}

#[test]
fn property_the_option_that_is_walked_gets_shorter_by_every_step_and_no_riskier() {
    let mut rng = ChaCha8Rng::seed_from_u64(38);
    let (mut worlds, mut steps) = (0, 0);
    while worlds < 300 {
        let Some(set) = options(&mut rng) else { continue };
        worlds += 1;
        walk(&set, &mut rng, |before, after, option, _| {
            let [was, is] = [before, after].map(|progress| set.remaining(progress, option));
            let (at, walked) = (after.position, (after.position - before.position).norm());
            // on an arc the step is up to 2 mm shorter than what is walked
            assert!(is.length < was.length - walked + 1e-6, "{at}: {} m, then {} m", was.length, is.length);
            assert!(is.risk <= was.risk + 1e-12, "{at}: risk {}, then {}", was.risk, is.risk);
            steps += 1;
        });
    }
    assert!(steps > 10_000, "{steps} steps");
}

/// D of every option, walked or not, changes with the team's position by no more than the rule of joining a
/// straight part can explain, but where a gap is crossed or left. Elsewhere it jumps only where two paths
/// round an obstacle are equally good and join a straight part at different positions.
#[test]
fn property_lengths_jump_little_between_crossings() {
    // off the axis of a straight part D falls by up to 1.55 m for every metre walked
    const STEEPEST: f64 = 1.6;
    let mut rng = ChaCha8Rng::seed_from_u64(39);
    let (mut worlds, mut lengths, mut jumps, mut largest) = (0, 0, 0, 0.0);
    while worlds < 1000 {
        let Some(set) = options(&mut rng) else { continue };
        worlds += 1;
        walk(&set, &mut rng, |before, after, _, _| {
            let step = (after.position - before.position).norm();
            if set.crossing(before.position, after.position).is_some() {
                return;
            }
            for o in 0..set.options().len() {
                let [was, is] = [before, after].map(|progress| set.remaining(progress, o));
                if was.next != is.next {
                    continue;
                }
                let jump = (was.length - is.length).abs() - STEEPEST * step;
                lengths += 1;
                jumps += usize::from(jump > 0.01);
                largest = f64::max(largest, jump);
            }
        });
    }
    println!("{jumps} of {lengths} lengths jump by more than 1 cm, at most {largest:.3} m");
    assert!(lengths > 100_000, "{lengths}");
    assert!(largest < 0.4 && jumps * 1000 < lengths, "{jumps} of {lengths}, at most {largest} m");
}
