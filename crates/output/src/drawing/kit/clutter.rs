//! The lines and areas already on a picture, and the cost of covering them with a label.

use cocarry::geometry::{Bounds, Footprint, Point, Vector, segments_cross};

/// Free margin around reserved areas, px.
const TAKEN_MARGIN: f64 = 5.0;
/// Cost of a label that lies on bodies.
const ON_BODY: f64 = 90.0;
/// Cost of a leader line that lies on bodies.
const LEADER_ON_BODY: f64 = 240.0;
/// A leader line that crosses a line costs as much as a label that covers so much of it, px.
const CROSSING: f64 = 5.0;

/// Lines, and areas that must stay free, inside a frame.
pub(in super::super) struct Clutter {
    frame: Bounds,
    lines: Vec<ClutterLine>,
    taken: Vec<Bounds>,
    bodies: Vec<(Bounds, Footprint)>,
}

#[derive(Clone)]
struct ClutterLine {
    ends: [Point; 2],
    /// Half of its width, px.
    half: f64,
    /// Cost of covering a pixel of its length.
    cost: f64,
}

impl ClutterLine {
    fn inside(&self, area: Bounds) -> f64 {
        length_inside(area.grown(self.half), self.ends)
    }
}

impl Clutter {
    pub fn new(frame: Bounds) -> Self {
        Self { frame, lines: Vec::new(), taken: Vec::new(), bodies: Vec::new() }
    }

    /// Adds a line, with the cost of covering a pixel of its length.
    pub fn add(&mut self, points: &[Point], width: f64, cost: f64) {
        let half = width / 2.0;
        self.lines.extend(points.windows(2).map(|w| ClutterLine { ends: [w[0], w[1]], half, cost }));
    }

    /// What there is within an area or touches it: costs there are the same.
    pub fn near(&self, area: Bounds) -> Self {
        let meets = |other: Bounds| overlap(area, other) > 0.0;
        Self {
            frame: self.frame,
            lines: self.lines.iter().filter(|l| meets(around(l.ends).grown(l.half))).cloned().collect(),
            taken: self.taken.iter().copied().filter(|taken| meets(taken.grown(TAKEN_MARGIN))).collect(),
            bodies: self.bodies.iter().filter(|(bounds, _)| meets(*bounds)).cloned().collect(),
        }
    }

    /// Reserves an area.
    pub fn take(&mut self, area: Bounds) {
        self.taken.push(area);
    }

    /// Adds a convex body with these corners, on which a label would be read as the body's name.
    pub fn add_body(&mut self, mut corners: Vec<Point>) {
        // counter-clockwise, though y points down
        corners.reverse();
        let body = Footprint::Polygon(corners);
        self.bodies.push((body.bounds(), body));
    }

    /// The cost of a label in this area: covered lines by their cost, reserved areas per pixel, four times the
    /// area outside, and the share on bodies.
    pub fn cost(&self, area: Bounds) -> f64 {
        let covered: f64 = self.lines.iter().map(|line| line.cost * line.inside(area)).sum();
        let shared: f64 = self.taken.iter().map(|t| overlap(area, t.grown(TAKEN_MARGIN))).sum();
        let samples = (0..15).map(|i| {
            let share = Vector::new(f64::from(i % 5) / 4.0, f64::from(i / 5) / 2.0);
            area.min + area.size().component_mul(&share)
        });
        let outside = area.size().product() - overlap(area, self.frame);
        covered + shared + 4.0 * outside + ON_BODY * self.on_bodies(area, samples) as f64 / 15.0
    }

    /// The number of these points of an area that lie on bodies.
    fn on_bodies(&self, area: Bounds, points: impl Iterator<Item = Point>) -> usize {
        let near: Vec<&Footprint> = self
            .bodies
            .iter()
            .filter(|(bounds, _)| overlap(area, *bounds) > 0.0)
            .map(|(_, body)| body)
            .collect();
        points.filter(|p| near.iter().any(|body| body.contains(*p))).count()
    }

    /// The cost of a leader line: lines that it crosses, what it covers of reserved areas, and its share on
    /// bodies.
    pub fn leader_cost(&self, leader: [Point; 2]) -> f64 {
        let [from, to] = leader;
        let crossed =
            self.lines.iter().filter(|ClutterLine { ends: [a, b], .. }| segments_cross(from, to, *a, *b));
        let covered: f64 = self.taken.iter().map(|area| length_inside(*area, leader)).sum();
        let samples = (0..12).map(|i| from + (to - from) * ((f64::from(i) + 0.5) / 12.0));
        let on_bodies = LEADER_ON_BODY * self.on_bodies(around(leader).grown(1.0), samples) as f64 / 12.0;
        CROSSING * (crossed.map(|line| line.cost).sum::<f64>() + covered) + on_bodies
    }

    /// Whether a label in this area covers a line.
    pub fn covers_a_line(&self, area: Bounds) -> bool {
        self.lines.iter().any(|line| line.inside(area) > 0.0)
    }
}

/// The bounds of a line.
pub(in super::super) fn around([a, b]: [Point; 2]) -> Bounds {
    Bounds { min: a.inf(&b), max: a.sup(&b) }
}

/// Area that two areas have in common.
pub(in super::super) fn overlap(a: Bounds, b: Bounds) -> f64 {
    let size = a.max.coords.inf(&b.max.coords) - a.min.coords.sup(&b.min.coords);
    if size.min() <= 0.0 { 0.0 } else { size.product() }
}

/// The point of an area that is nearest to `p`.
pub(in super::super) fn nearest(area: Bounds, p: Point) -> Point {
    p.sup(&area.min).inf(&area.max)
}

/// Length of the part of a line that lies inside an area.
fn length_inside(area: Bounds, [a, b]: [Point; 2]) -> f64 {
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

    #[test]
    fn closed_form_covering_costs() {
        let square = |x: f64, side: f64| Bounds { min: Point::new(x, 0.0), max: Point::new(x + side, side) };
        let mut clutter = Clutter::new(square(0.0, 100.0));
        clutter.add(&[Point::new(5.0, -50.0), Point::new(5.0, 50.0)], 2.0, 3.0);
        clutter.take(square(60.0, 10.0));
        assert_eq!([square(0.0, 10.0), square(20.0, 10.0)].map(|a| clutter.cost(a)), [36.0, 0.0]);
        assert_eq!([square(60.0, 10.0), square(95.0, 10.0)].map(|a| clutter.cost(a)), [100.0, 200.0]);
        clutter.add_body(vec![
            Point::new(20.0, 90.0),
            Point::new(40.0, 90.0),
            Point::new(40.0, 40.0),
            Point::new(20.0, 40.0),
        ]);
        let on_body = [20.0, 30.0, 41.0]
            .map(|x| clutter.cost(Bounds { min: Point::new(x, 50.0), max: Point::new(x + 20.0, 60.0) }));
        assert_eq!(on_body, [ON_BODY, ON_BODY * 0.6, 0.0]);
        let through = [Point::new(10.0, 60.0), Point::new(50.0, 60.0)];
        assert_eq!(clutter.leader_cost(through), LEADER_ON_BODY / 2.0);
        let leader = |x: f64| [Point::new(x, 5.0), Point::new(x + 30.0, 5.0)];
        let costs = [0.0, 10.0, 45.0].map(|x| clutter.leader_cost(leader(x)));
        assert!(
            costs.iter().zip([15.0, 0.0, 50.0]).all(|(cost, expected)| (cost - expected).abs() < 1e-9),
            "{costs:?}"
        );
    }
}
