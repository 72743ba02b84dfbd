//! What is drawn on a map already and where labels belong in; places for the labels that cover as little as possible out.

use super::scene::{BAR, View, rectangle};
use super::style::{INK, SMALL, number, stroke};
use super::text::{Align, Words};
use crate::geometry::{Bounds, Point, Vector, direction};
use crate::world::World;
use svg::node::element::Group;

/// A label covers nothing within this distance of its words, px.
const PADDING: f64 = 2.0;
/// Height of a line of a label, px.
const LEADING: f64 = SMALL * 1.08;
/// A label farther than this from its opening gets a line that leads there, px.
const NEAR: f64 = 16.0;

impl Line {
    /// Length of the part that meets an area.
    fn inside(&self, area: Bounds) -> f64 {
        length_inside(area.grown(self.half), self.ends)
    }
}

/// A straight line on a map.
struct Line {
    ends: [Point; 2],
    /// Half of its width.
    half: f64,
    /// What covering a pixel of its length costs.
    cost: f64,
}

/// What covering a pixel of an obstacle's outline costs: words are readable on a stout one; on a thin one, as on lines, they need paper.
const OUTLINE: f64 = 1.3;
const THIN: f64 = 2.5;

/// What lies on a map, in px.
pub(super) struct Ground {
    frame: Bounds,
    lines: Vec<Line>,
    /// Areas that must stay free.
    taken: Vec<Bounds>,
}

impl Ground {
    /// The obstacles, the openings, the start and the target of a world.
    pub fn of(view: &View, world: &World) -> Self {
        let mut ground = Self { frame: view.frame(), lines: Vec::new(), taken: Vec::new() };
        for obstacle in &world.obstacles {
            let mut outline = view.outline(&obstacle.footprint);
            outline.extend(outline.first().copied());
            let cost = if thickness(&outline) < LEADING { THIN } else { OUTLINE };
            ground.add(&outline, 0.8, cost);
        }
        for opening in &world.openings {
            ground.add(&opening.ends.map(|p| view.px(p)), BAR + 2.0, 12.0);
        }
        for place in [world.start, world.target] {
            let at = view.px(place);
            ground.taken.push(Bounds { min: at, max: at }.grown(super::scene::MARK));
        }
        ground
    }

    /// Adds a line of a width, with the cost of covering a pixel of its length.
    pub fn add(&mut self, points: &[Point], width: f64, cost: f64) {
        let half = width / 2.0;
        self.lines.extend(points.windows(2).map(|w| Line { ends: [w[0], w[1]], half, cost }));
    }

    /// The names of the openings, each with its width where `with_widths`.
    pub fn label_openings(&mut self, view: &View, world: &World, with_widths: bool) -> Group {
        let bars: Vec<[Point; 2]> = world.openings.iter().map(|o| o.ends.map(|p| view.px(p))).collect();
        let mut group = Group::new().set("class", "names");
        for (i, opening) in world.openings.iter().enumerate() {
            let name = Words::new().opening(&opening.name, 12);
            let width = Words::new().plain(format!("{} m", number(opening.width, 2)));
            let full = if with_widths { vec![name.clone(), width] } else { vec![name.clone()] };
            let mut words = full;
            let mut found = self.place(&words, i, &bars);
            // in a crowd the name alone may still find a place
            if found.1 > 160.0 && words.len() > 1 {
                let alone = self.place(std::slice::from_ref(&name), i, &bars);
                if alone.1 < found.1 - 70.0 {
                    (words, found) = (vec![name], alone);
                }
            }
            group = group.add(draw(&words, found.0, bars[i], self.is_bare(found.0)));
            self.taken.push(found.0);
        }
        group
    }

    /// Whether words in an area cover nothing but stout obstacles.
    fn is_bare(&self, area: Bounds) -> bool {
        self.lines.iter().all(|line| line.cost <= OUTLINE || line.inside(area.grown(-PADDING)) == 0.0)
    }

    /// The best place (px) for the words of the opening `own`, and what it costs.
    fn place(&self, words: &[Words], own: usize, bars: &[[Point; 2]]) -> (Bounds, f64) {
        let center = nalgebra::center(&bars[own][0], &bars[own][1]);
        let width = words.iter().enumerate().map(|(i, w)| w.width(size(i))).fold(0.0, f64::max);
        let half = Vector::new(width / 2.0 + PADDING, words.len() as f64 * LEADING / 2.0 + PADDING);
        let reach = half.norm() + 150.0;
        let near = Bounds { min: center, max: center }.grown(reach);
        let lines: Vec<_> = self.lines.iter().filter(|line| line.inside(near) > 0.0).collect();
        let mut best = (Bounds { min: center - half, max: center + half }, f64::INFINITY);
        for ring in 0..20 {
            for spoke in 0..32 {
                let away = direction(f64::from(spoke) * std::f64::consts::TAU / 32.0);
                let middle = center + away * (14.0 + 8.0 * f64::from(ring));
                let area = Bounds { min: middle - half, max: middle + half };
                let distance = gap(area, touch(area, bars[own]));
                let covered: f64 = lines.iter().map(|line| line.cost * line.inside(area)).sum();
                let shared: f64 = self.taken.iter().map(|t| overlap(area, t.grown(5.0))).sum();
                let outside = area_of(area) - overlap(area, self.frame);
                let nearer =
                    |(j, bar): (usize, &[Point; 2])| j != own && gap(area, touch(area, *bar)) < distance;
                let mistaken = bars.iter().enumerate().any(nearer);
                let cost = covered
                    + shared
                    + 4.0 * outside
                    + 0.7 * distance
                    + if distance > NEAR { 25.0 } else { 0.0 }
                    + if mistaken { 45.0 } else { 0.0 };
                if cost < best.1 {
                    best = (area, cost);
                }
            }
        }
        best
    }
}

/// Font size of a line of a label, px: the first one is the name.
fn size(line: usize) -> f64 {
    if line == 0 { SMALL } else { 14.5 }
}

fn draw(words: &[Words], area: Bounds, bar: [Point; 2], is_bare: bool) -> Group {
    let paper = rectangle(area.grown(-1.0)).set("fill", "#ffffff").set("fill-opacity", 0.78).set("rx", 3);
    let mut group = Group::new();
    let to = touch(area, bar);
    if gap(area, to) > NEAR {
        let from = nearest(area, to);
        group = group.add(stroke(&[from, to], INK, 0.9));
    }
    if !is_bare {
        group = group.add(paper);
    }
    let middle = nalgebra::center(&area.min, &area.max).x;
    words.iter().enumerate().fold(group, |group, (i, line)| {
        let baseline = area.min.y + PADDING + (i as f64 + 0.8) * LEADING;
        group.add(line.at(Point::new(middle, baseline), size(i), Align::Middle))
    })
}

fn nearest(area: Bounds, p: Point) -> Point {
    Point::from(p.coords.sup(&area.min.coords).inf(&area.max.coords))
}

/// The point of an opening's bar, away from its ends, that is nearest to an area.
fn touch(area: Bounds, [a, b]: [Point; 2]) -> Point {
    let points = (2..=8).map(|i| a + (b - a) * (f64::from(i) / 10.0));
    points.min_by(|p, q| gap(area, *p).total_cmp(&gap(area, *q))).unwrap_or(a)
}

fn gap(area: Bounds, p: Point) -> f64 {
    (nearest(area, p) - p).norm()
}

/// Area over half of the perimeter: about the thickness of a long outline.
fn thickness(outline: &[Point]) -> f64 {
    let pairs = || outline.windows(2).map(|w| (w[0].coords, w[1].coords));
    let doubled: f64 = pairs().map(|(a, b)| crate::geometry::cross(a, b)).sum();
    let perimeter: f64 = pairs().map(|(a, b)| (b - a).norm()).sum();
    if perimeter > 0.0 { doubled.abs() / perimeter } else { 0.0 }
}

fn area_of(area: Bounds) -> f64 {
    area.size().product()
}

/// Area that two areas have in common.
pub(super) fn overlap(a: Bounds, b: Bounds) -> f64 {
    let size = a.max.coords.inf(&b.max.coords) - a.min.coords.sup(&b.min.coords);
    if size.min() <= 0.0 { 0.0 } else { size.product() }
}

/// Length of the part of a line that lies inside an area.
pub(super) fn length_inside(area: Bounds, [a, b]: [Point; 2]) -> f64 {
    let along = b - a;
    let (mut enter, mut leave) = (0.0f64, 1.0f64);
    for axis in 0..2 {
        let (low, high) = (area.min[axis] - a[axis], area.max[axis] - a[axis]);
        if along[axis] == 0.0 {
            if low > 0.0 || high < 0.0 {
                return 0.0;
            }
        } else {
            let (t, u) = (low / along[axis], high / along[axis]);
            enter = enter.max(t.min(u));
            leave = leave.min(t.max(u));
        }
    }
    if leave > enter { (leave - enter) * along.norm() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_length_inside_and_overlap() {
        let area = |x: f64, y: f64| Bounds { min: Point::new(x, y), max: Point::new(x + 2.0, y + 2.0) };
        let line = |a: [f64; 2], b: [f64; 2]| [Point::from(a), Point::from(b)];
        let inside = |a, b| length_inside(area(0.0, 0.0), line(a, b));
        assert!((inside([-1.0, 1.0], [9.0, 1.0]) - 2.0).abs() < 1e-12);
        assert!((inside([1.0, 1.0], [4.0, 4.0]) - 2f64.sqrt()).abs() < 1e-12);
        assert_eq!(inside([-1.0, 3.0], [9.0, 3.0]), 0.0);
        assert_eq!(
            [overlap(area(0.0, 0.0), area(1.0, 0.5)), overlap(area(0.0, 0.0), area(3.0, 0.0))],
            [1.5, 0.0]
        );
    }
}
