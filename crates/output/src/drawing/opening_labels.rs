//! The labels of a map's openings, at positions where they cover as little as possible.

use super::kit::{Align, Clutter, INK, TEXT_SIZE, Text, around, nearest, number, overlap, stroke};
use super::map_view::{BAR, END, MapView, paper};
use cocarry::geometry::{Bounds, Point, Vector, direction};
use cocarry::world::World;
use svg::node::element::Group;

/// Free margin around the words of a label, px.
const PADDING: f64 = 2.0;
/// Line height of a label, px.
const LINE_HEIGHT: f64 = TEXT_SIZE * 1.08;
/// Distance from its opening beyond which a label gets a leader line, px.
const LEADER_DISTANCE: f64 = 16.0;
/// Cost of a leader line, apart from what it crosses.
const LEADER_COST: f64 = 25.0;
/// Labels are tried on rings around their opening: number of rings, radius of the first one, and the step to
/// the next one, px.
const RINGS: i32 = 20;
const FIRST_RING: f64 = 14.0;
const RING_STEP: f64 = 8.0;
/// Largest width of a name, px.
const NAME_WIDTH: f64 = 120.0;

/// Costs of covering a pixel of length: of a path or a leader line, of an obstacle's outline, of an opening.
pub(super) const PATH_COST: f64 = 4.0;
const OUTLINE_COST: f64 = 6.0;
const OPENING_COST: f64 = 12.0;
/// A label that costs more than `CROWDED_COST` omits the width of its opening where that saves
/// `MIN_SAVING`.
const CROWDED_COST: f64 = 200.0;
const MIN_SAVING: f64 = 60.0;

/// The clutter of a map before labels and paths.
pub(super) fn clutter(view: &MapView, world: &World) -> Clutter {
    let mut clutter = Clutter::new(view.frame());
    for obstacle in &world.obstacles {
        obstacle.footprints().for_each(|footprint| clutter.add_body(view.outline(footprint)));
        for mut outline in view.outlines(obstacle) {
            outline.extend(outline.first().copied());
            clutter.add(&outline, 0.8, OUTLINE_COST);
        }
    }
    for opening in &world.openings {
        clutter.add(&opening.ends.map(|p| view.px(p)), BAR + 2.4, OPENING_COST);
    }
    for end in [world.start, world.target].map(|p| view.px(p)) {
        clutter.take(Bounds { min: end, max: end }.grown(END));
    }
    clutter
}

/// The labels of a map's openings.
pub(super) struct OpeningLabels {
    pub group: Group,
    /// Number of openings whose width is left out, for want of space.
    pub without_width: usize,
}

/// The labels of the openings: the name, and the width where `with_widths`. They are added to the clutter.
pub(super) fn opening_labels(
    view: &MapView,
    world: &World,
    with_widths: bool,
    clutter: &mut Clutter,
) -> OpeningLabels {
    let bars: Vec<[Point; 2]> = world.openings.iter().map(|o| o.ends.map(|p| view.px(p))).collect();
    let mut group = Group::new().set("class", "names");
    let mut without_width = 0;
    for (i, opening) in world.openings.iter().enumerate() {
        let mut lines = vec![Text::opening(&opening.name).within(NAME_WIDTH, TEXT_SIZE)];
        let (mut area, cost) = best_place(&lines, i, &bars, clutter);
        if with_widths {
            let full = vec![lines[0].clone(), Text::new(format!("{} m", number(opening.width, 2)))];
            let found = best_place(&full, i, &bars, clutter);
            // in a crowded place, only the name is shown
            if found.1 < CROWDED_COST || found.1 < cost + MIN_SAVING {
                (lines, area) = (full, found.0);
            } else {
                without_width += 1;
            }
        }
        if let Some(leader) = leader(bars[i], area) {
            clutter.add(&leader, 0.9, PATH_COST);
            group = group.add(stroke(&leader, INK, 0.9));
        }
        if clutter.covers_a_line(area.grown(-PADDING)) {
            group = group.add(paper(area.grown(-1.0)));
        }
        let middle = nalgebra::center(&area.min, &area.max).x;
        for (i, line) in lines.iter().enumerate() {
            let baseline = area.min.y + PADDING + (i as f64 + 0.8) * LINE_HEIGHT;
            let at = Point::new(middle, baseline);
            group = group.add(line.lettered(view.letters, at, TEXT_SIZE, Align::Middle));
        }
        clutter.take(area);
    }
    OpeningLabels { group, without_width }
}

/// The best position (px) for the lines of the opening `own`, and its cost.
fn best_place(lines: &[Text], own: usize, bars: &[[Point; 2]], clutter: &Clutter) -> (Bounds, f64) {
    let center = nalgebra::center(&bars[own][0], &bars[own][1]);
    let width = lines.iter().map(|line| line.width(TEXT_SIZE)).fold(0.0, f64::max);
    let half = Vector::new(width / 2.0 + PADDING, lines.len() as f64 * LINE_HEIGHT / 2.0 + PADDING);
    let places = (0..RINGS).flat_map(|ring| (0..32).map(move |spoke| (f64::from(ring), f64::from(spoke))));
    let areas = places.map(|(ring, spoke)| {
        let middle =
            center + direction(spoke * std::f64::consts::TAU / 32.0) * (FIRST_RING + RING_STEP * ring);
        Bounds { min: middle - half, max: middle + half }
    });
    // what is farther changes no cost
    let reach = FIRST_RING + RING_STEP * f64::from(RINGS) + 2.0 * half.norm();
    let clutter = clutter.near(around(bars[own]).grown(reach));
    let is_other = |(i, bar): (usize, &[Point; 2])| {
        let is_near = overlap(around(*bar).grown(1.0), around(bars[own]).grown(2.0 * reach)) > 0.0;
        (i != own && is_near).then_some(*bar)
    };
    let others: Vec<[Point; 2]> = bars.iter().enumerate().filter_map(is_other).collect();
    let mut best: Option<(Bounds, f64)> = None;
    for area in areas {
        let is_beaten = |cost: f64| best.is_some_and(|(_, least)| cost >= least);
        let distance = |bar: [Point; 2]| gap(area, nearest_on(bar, area));
        let (own_distance, leader) = (distance(bars[own]), leader(bars[own], area));
        // no part of the cost is negative: what costs too much already is not looked at further
        let mut cost = 0.7 * own_distance + if leader.is_some() { LEADER_COST } else { 0.0 };
        if is_beaten(cost) {
            continue;
        }
        cost += clutter.cost(area);
        if is_beaten(cost) {
            continue;
        }
        cost += leader.map_or(0.0, |leader| clutter.leader_cost(leader));
        if others.iter().any(|bar| distance(*bar) < own_distance) {
            cost += 45.0;
        }
        if !is_beaten(cost) {
            best = Some((area, cost));
        }
    }
    best.unwrap_or((Bounds { min: center - half, max: center + half }, f64::INFINITY))
}

/// The line from a label to the side of its opening's bar, if the label is not next to it.
fn leader(bar: [Point; 2], area: Bounds) -> Option<[Point; 2]> {
    let touch = nearest_on(bar, area);
    let from = nearest(area, touch);
    let along = touch - from;
    let length = along.norm();
    (length > LEADER_DISTANCE).then(|| [from, touch - along * (BAR / 2.0 / length)])
}

/// The point of an opening's bar, away from its ends, that is nearest to an area.
fn nearest_on([a, b]: [Point; 2], area: Bounds) -> Point {
    let points = (2..=8).map(|i| a + (b - a) * (f64::from(i) / 10.0));
    points.min_by(|p, q| gap(area, *p).total_cmp(&gap(area, *q))).unwrap_or(a)
}

fn gap(area: Bounds, p: Point) -> f64 {
    (nearest(area, p) - p).norm()
}
