//! Outlines of areas that need not be convex: what polygons that touch or overlap cover together, its corners,
//! and convex polygons that fill it.

mod triangles;

use super::footprint::{Bounds, Footprint, edges};
use super::{Nearby, Point, Vector, cross, left_of, nearest_on_segment};
use spade::Triangulation;
use std::collections::BTreeSet;
use triangles::{convex_parts, enclosed, point, rings, triangles};

/// A turn whose sine is below this does not count: its three corners are on a line.
const STRAIGHT_SINE: f64 = 1e-9;

/// The outline of an area: closed rings that do not cross, with the area on their left. Rings around it are
/// counter-clockwise, and rings around holes clockwise. Two rings may share a corner.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    rings: Vec<Vec<Point>>,
}

/// Why a ring encloses no area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RingFault {
    /// Fewer than three corners that are not on a line.
    Flat,
    /// A side crosses or touches another one.
    Crossing {
        /// Where the side begins.
        from: Point,
    },
}

/// A corner that points out of an area, where taut strings bend.
#[derive(Clone, Debug, PartialEq)]
pub struct Corner {
    /// Where it is.
    pub at: Point,
    /// The outward normals of its two sides, counter-clockwise.
    pub normals: [Vector; 2],
}

impl Corner {
    /// Whether a convex part of the area has this corner, too. Another part may touch it from outside, where
    /// the outline touches itself.
    pub fn is_of(&self, part: &Footprint) -> bool {
        let Some(corners) = part.corners() else { return false };
        let n = corners.len();
        let place = corners.iter().position(|corner| *corner == self.at);
        place.is_some_and(|i| {
            let is_inside = |p: Point| {
                let along = p - self.at;
                self.normals.iter().all(|normal| normal.dot(&along) <= STRAIGHT_SINE * along.norm())
            };
            is_inside(corners[(i + n - 1) % n]) && is_inside(corners[(i + 1) % n])
        })
    }
}

impl Outline {
    /// The area inside one ring, in either direction. Corners on a straight line, and a last corner equal to
    /// the first, are left out.
    ///
    /// # Errors
    /// [`RingFault`]: the ring crosses or touches itself, or all its corners are on a line.
    pub fn inside(ring: Vec<Point>) -> Result<Self, RingFault> {
        let mut ring = without_straight_corners(ring, 0.0);
        if ring.len() < 3 {
            return Err(RingFault::Flat);
        }
        if let Some(from) = crossing_side(std::slice::from_ref(&ring)) {
            return Err(RingFault::Crossing { from });
        }
        if doubled_area(&ring) < 0.0 {
            ring.reverse();
        }
        Ok(Self { rings: vec![ring] })
    }

    /// The area inside one ring and outside of others within it, in any direction.
    ///
    /// # Errors
    /// As [`Outline::inside`], also if rings cross or touch each other.
    pub fn with_holes(ring: Vec<Point>, holes: Vec<Vec<Point>>) -> Result<Self, RingFault> {
        let Self { mut rings } = Self::inside(ring)?;
        for hole in holes {
            let Self { rings: hole } = Self::inside(hole)?;
            rings.extend(hole.into_iter().map(|mut hole| {
                hole.reverse();
                hole
            }));
        }
        match crossing_side(&rings) {
            Some(from) => Err(RingFault::Crossing { from }),
            None => Ok(Self { rings }),
        }
    }

    /// The area around the inside of a ring, as far as a rectangle `margin` (m) away from it: the walls of a
    /// room.
    ///
    /// # Errors
    /// As [`Outline::inside`].
    pub fn around(ring: Vec<Point>, margin: f64) -> Result<Self, RingFault> {
        let Self { mut rings } = Self::inside(ring)?;
        let Bounds { min, max } =
            Bounds::around(rings[0].iter().copied()).ok_or(RingFault::Flat)?.grown(margin);
        rings[0].reverse();
        let rectangle = vec![min, Point::new(max.x, min.y), max, Point::new(min.x, max.y)];
        rings.insert(0, rectangle);
        Ok(Self { rings })
    }

    /// The outline of what convex polygons (counter-clockwise) cover together. Polygons whose distance is at
    /// most `tolerance` (m) touch: the slit between them belongs to the area. Corners that are corners of a
    /// polygon keep their coordinates. `None` where the polygons differ by so little more than the tolerance
    /// that their sides cannot be told apart.
    pub fn covering(polygons: &[&[Point]], tolerance: f64) -> Option<Self> {
        let lines = Lines::new(polygons, tolerance);
        let (triangles, _) = triangles(&lines.points, lines.between.into_iter())?;
        let solids: Vec<Footprint> = polygons.iter().map(|p| Footprint::Polygon(p.to_vec())).collect();
        let near = Nearby::new(solids.iter().map(Footprint::bounds));
        let is_covered = |p: Point| {
            let here = Bounds { min: p, max: p }.grown(tolerance);
            near.any_meeting(here, |i| solids[i].distance_to_point(p) <= tolerance)
        };
        let is_solid: Vec<bool> = triangles
            .all_faces()
            .map(|face| face.as_inner().is_some_and(|inside| is_covered(point(inside.center()))))
            .collect();
        let rings = rings(&triangles, &is_solid);
        let rings = rings.into_iter().map(|ring| without_straight_corners(ring, tolerance));
        Some(Self { rings: rings.filter(|ring| ring.len() >= 3).collect() })
    }

    /// The rings, each without a repeated corner.
    pub fn rings(&self) -> &[Vec<Point>] {
        &self.rings
    }

    /// The smallest rectangle around it.
    pub fn bounds(&self) -> Option<Bounds> {
        Bounds::around(self.rings.iter().flatten().copied())
    }

    /// The corners that point out of the area, ring by ring.
    pub fn corners(&self) -> impl Iterator<Item = Corner> + '_ {
        self.rings.iter().flat_map(|ring| corners(ring))
    }

    /// Convex polygons (counter-clockwise, no three corners on a line) that fill the area, and have no
    /// corners but those of the outline. At most four times as many as necessary (S. Hertel and K. Mehlhorn,
    /// Fast triangulation of simple polygons, FCT 1983). `None` where rings cross.
    pub fn parts(&self) -> Option<Vec<Vec<Point>>> {
        let mut points = Vec::new();
        let mut sides = Vec::new();
        for ring in &self.rings {
            let first = points.len();
            points.extend(ring.iter().copied());
            sides.extend((0..ring.len()).map(|i| [first + i, first + (i + 1) % ring.len()]));
        }
        let (triangles, _) = triangles(&points, sides.into_iter())?;
        let is_solid = enclosed(&triangles);
        Some(convex_parts(&triangles, &is_solid))
    }
}

/// The corners of a ring that point out of the area on its left.
fn corners(ring: &[Point]) -> impl Iterator<Item = Corner> + '_ {
    let n = ring.len();
    let along = move |i: usize| ring[(i + 1) % n] - ring[i % n];
    let points_out = move |i: &usize| {
        let (before, after) = (along(i + n - 1), along(*i));
        cross(before, after) > STRAIGHT_SINE * before.norm() * after.norm()
    };
    let normal = move |i: usize| -left_of(along(i)).normalize();
    (0..n).filter(points_out).map(move |i| Corner { at: ring[i], normals: [normal(i + n - 1), normal(i)] })
}

/// Twice the area inside a ring, m^2: positive where it is counter-clockwise.
fn doubled_area(ring: &[Point]) -> f64 {
    // about a corner, since far from the origin the products would cancel
    edges(ring).map(|(a, b)| cross(a - ring[0], b - ring[0])).sum()
}

/// A ring without corners that lie within `tolerance` (m) of the line between the corners kept before and
/// after them, nor repeated ones.
fn without_straight_corners(mut ring: Vec<Point>, tolerance: f64) -> Vec<Point> {
    ring.dedup();
    while ring.len() > 1 && ring.first() == ring.last() {
        ring.pop();
    }
    let order = |a: &Point, b: &Point| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y));
    // the first corner is kept: the lowest of the leftmost ones points out
    if let Some(first) = (0..ring.len()).min_by(|i, j| order(&ring[*i], &ring[*j])) {
        ring.rotate_left(first);
    }
    let n = ring.len();
    let is_straight = |from: usize, to: usize| {
        let (a, b) = (ring[from], ring[to % n]);
        let along = b - a;
        (from + 1..to).all(|i| {
            let (p, off) = (ring[i], ring[i] - nearest_on_segment(ring[i], a, b));
            off.norm() <= tolerance
                || (cross(along, p - a).abs() <= STRAIGHT_SINE * along.norm() * (p - a).norm()
                    && along.dot(&(p - a)) > 0.0
                    && along.dot(&(b - p)) > 0.0)
        })
    };
    let mut kept: Vec<usize> = Vec::new();
    let mut from = 0;
    while from < n {
        kept.push(from);
        let mut to = from + 1;
        while to < n && is_straight(from, to + 1) {
            to += 1;
        }
        from = to;
    }
    kept.into_iter().map(|i| ring[i]).collect()
}

/// Where the first side begins that meets another one other than at a corner that they share.
fn crossing_side(rings: &[Vec<Point>]) -> Option<Point> {
    // the ring of every side, and its place there
    let sides: Vec<([usize; 2], [Point; 2])> = rings
        .iter()
        .enumerate()
        .flat_map(|(r, ring)| edges(ring).enumerate().map(move |(i, (a, b))| ([r, i], [a, b])))
        .collect();
    let bounds = |[a, b]: [Point; 2]| Bounds { min: a.inf(&b), max: a.sup(&b) };
    let near = Nearby::new(sides.iter().map(|(_, side)| bounds(*side)));
    let meets_another = |&&([ring, i], [a, b]): &&([usize; 2], [Point; 2])| {
        near.any_meeting(bounds([a, b]), |other| {
            let ([other_ring, j], [c, d]) = sides[other];
            let n = rings[ring].len();
            match (j + n - i) % n {
                _ if other_ring != ring => super::segments_meet(a, b, c, d, 0.0),
                0 => false,
                // back along the side before
                1 => cross(b - a, d - c) == 0.0 && (b - a).dot(&(d - c)) < 0.0,
                last if last == n - 1 => false,
                _ => super::segments_meet(a, b, c, d, 0.0),
            }
        })
    };
    sides.iter().find(meets_another).map(|(_, [a, _])| *a)
}

/// The sides of polygons, cut where they cross or touch.
struct Lines {
    points: Vec<Point>,
    /// Pairs of points, the lower first, without repetition.
    between: BTreeSet<[usize; 2]>,
}

impl Lines {
    fn new(polygons: &[&[Point]], tolerance: f64) -> Self {
        let sides: Vec<[Point; 2]> =
            polygons.iter().flat_map(|polygon| edges(polygon).map(|(a, b)| [a, b])).collect();
        let near = Nearby::new(sides.iter().map(|[a, b]| Bounds { min: a.inf(b), max: a.sup(b) }));
        let mut candidates: Vec<Point> = sides.iter().map(|[a, _]| *a).collect();
        for (i, [a, b]) in sides.iter().copied().enumerate() {
            for j in near.meeting(Bounds { min: a.inf(&b), max: a.sup(&b) }) {
                if j > i {
                    candidates.extend(crossing([a, b], sides[j]));
                }
            }
        }
        let points = distinct(candidates, tolerance);
        let here = |p: Point| Bounds { min: p, max: p };
        let near = Nearby::new(points.iter().map(|p| here(*p)));
        let mut between = BTreeSet::new();
        for [a, b] in sides {
            let mut along: Vec<(f64, usize)> = Vec::new();
            near.any_along(a, b, tolerance, |i| {
                if (points[i] - nearest_on_segment(points[i], a, b)).norm() <= tolerance {
                    along.push(((points[i] - a).dot(&(b - a)), i));
                }
                false
            });
            along.sort_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
            between.extend(along.windows(2).map(|pair| {
                let [p, q] = [pair[0].1, pair[1].1];
                [p.min(q), p.max(q)]
            }));
        }
        Self { points, between }
    }
}

/// Where the insides of two segments cross.
fn crossing([a, b]: [Point; 2], [c, d]: [Point; 2]) -> Option<Point> {
    let (ab, cd) = (b - a, d - c);
    let slope = cross(ab, cd);
    if slope.abs() <= STRAIGHT_SINE * ab.norm() * cd.norm() {
        return None;
    }
    let (t, u) = (cross(c - a, cd) / slope, cross(c - a, ab) / slope);
    ((0.0..=1.0).contains(&t) && (0.0..=1.0).contains(&u)).then(|| a + ab * t)
}

/// The points without those that are within `tolerance` (m) of one before them.
fn distinct(points: Vec<Point>, tolerance: f64) -> Vec<Point> {
    let near = Nearby::new(points.iter().map(|p| Bounds { min: *p, max: *p }));
    let mut is_kept = vec![true; points.len()];
    for (i, p) in points.iter().enumerate() {
        let here = Bounds { min: *p, max: *p }.grown(tolerance);
        let is_known = near.any_meeting(here, |j| j < i && is_kept[j] && (points[j] - p).norm() <= tolerance);
        is_kept[i] = !is_known;
    }
    points.into_iter().zip(is_kept).filter_map(|(p, is_kept)| is_kept.then_some(p)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::direction;
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    const TOLERANCE_M: f64 = 1e-6;

    fn turned_box(center: Point, [x, y]: [f64; 2], yaw: f64) -> Vec<Point> {
        let (along, across) = (direction(yaw) * (x / 2.0), left_of(direction(yaw)) * (y / 2.0));
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(s, t)| center + along * s + across * t)
            .to_vec()
    }

    fn covering(polygons: &[Vec<Point>]) -> Outline {
        let polygons: Vec<&[Point]> = polygons.iter().map(Vec::as_slice).collect();
        Outline::covering(&polygons, TOLERANCE_M).expect("an outline")
    }

    fn area(outline: &Outline) -> f64 {
        outline.rings().iter().map(|ring| doubled_area(ring) / 2.0).sum()
    }

    fn points(corners: &[(f64, f64)]) -> Vec<Point> {
        corners.iter().map(|&(x, y)| Point::new(x, y)).collect()
    }

    #[test]
    fn closed_form_a_row_of_touching_boxes_is_one_box() {
        for yaw in [0.0, 0.7, -2.1] {
            for n in [2, 7, 100] {
                let (length, along) = (3.0, direction(yaw));
                let at = |i: usize| Point::new(5.0, 1.0) + along * ((i as f64 + 0.5) * length / n as f64);
                let row: Vec<Vec<Point>> =
                    (0..n).map(|i| turned_box(at(i), [length / n as f64, 0.2], yaw)).collect();
                let outline = covering(&row);
                let [ring] = outline.rings() else { panic!("{} rings", outline.rings().len()) };
                assert_eq!(ring.len(), 4, "{yaw} {n}");
                assert!((area(&outline) - 0.6).abs() < 1e-12);
                let corners: Vec<Corner> = outline.corners().collect();
                assert!(corners.len() == 4 && outline.parts().unwrap().len() == 1);
                // ends keep their coordinates
                assert!(row[0].iter().filter(|c| ring.contains(c)).count() >= 2);
            }
        }
    }

    #[test]
    fn closed_form_four_walls_enclose_a_hole() {
        let walls =
            [(5.0, 0.1, 10.0, 0.2), (5.0, 7.9, 10.0, 0.2), (0.1, 4.0, 0.2, 8.0), (9.9, 4.0, 0.2, 8.0)];
        let walls: Vec<Vec<Point>> =
            walls.iter().map(|&(x, y, w, h)| turned_box(Point::new(x, y), [w, h], 0.0)).collect();
        let outline = covering(&walls);
        let areas: Vec<f64> = outline.rings().iter().map(|ring| doubled_area(ring) / 2.0).collect();
        assert_eq!(areas.iter().map(|a| (a * 1e9).round() / 1e9).collect::<Vec<_>>(), [80.0, -9.6 * 7.6]);
        // only the outside has corners to bend around
        assert_eq!(outline.corners().count(), 4);
        let parts = outline.parts().unwrap();
        assert!(parts.len() <= 6, "{} parts", parts.len());
    }

    #[test]
    fn closed_form_boxes_that_share_a_corner_bend_strings_at_both() {
        let boxes = [
            turned_box(Point::new(0.5, 0.5), [1.0; 2], 0.0),
            turned_box(Point::new(1.5, 1.5), [1.0; 2], 0.0),
        ];
        let outline = covering(&boxes);
        assert_eq!((outline.rings().len(), outline.corners().count()), (2, 8));
        let shared: Vec<Corner> = outline.corners().filter(|c| c.at == Point::new(1.0, 1.0)).collect();
        let parts: Vec<Footprint> = outline.parts().unwrap().into_iter().map(Footprint::Polygon).collect();
        for corner in &shared {
            assert_eq!(parts.iter().filter(|part| corner.is_of(part)).count(), 1, "{corner:?}");
        }
    }

    #[test]
    fn closed_form_rings_that_enclose_nothing_are_refused() {
        let flat = points(&[(0.0, 0.0), (1.0, 0.0), (3.0, 0.0), (2.0, 0.0)]);
        assert_eq!(Outline::inside(flat), Err(RingFault::Flat));
        let crossed = points(&[(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0)]);
        assert!(matches!(Outline::inside(crossed), Err(RingFault::Crossing { .. })));
        // a spike, there and back
        let spike = points(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (1.0, 3.0), (1.0, 1.0), (0.0, 1.0)]);
        assert!(Outline::inside(spike).is_err());
        let square = points(&[(0.0, 0.0), (0.5, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)]);
        assert_eq!(Outline::inside(square).unwrap().rings()[0].len(), 4);
    }

    /// The inside of a star with random corners, against the number of sides that a ray crosses.
    #[test]
    fn property_parts_are_convex_and_fill_the_outline() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for _ in 0..100 {
            let n = rng.random_range(3..40);
            let corner = |i: usize, radius: f64| {
                Point::origin() + direction(i as f64 / n as f64 * std::f64::consts::TAU) * radius
            };
            let mut ring: Vec<Point> = (0..n).map(|i| corner(i, rng.random_range(0.3..2.0))).collect();
            if rng.random_bool(0.5) {
                ring.reverse();
            }
            for outline in [Outline::inside(ring.clone()), Outline::around(ring.clone(), 0.5)] {
                let outline = outline.unwrap();
                let parts = outline.parts().unwrap();
                let filled: f64 = parts.iter().map(|part| doubled_area(part) / 2.0).sum();
                assert!((filled - area(&outline)).abs() < 1e-9, "{filled} {}", area(&outline));
                let reflex = outline.rings().iter().map(Vec::len).sum::<usize>() - outline.corners().count();
                assert!(parts.len() <= 4 * (reflex + 1), "{} parts, {reflex} reflex corners", parts.len());
                for part in &parts {
                    assert!(corners(part).count() == part.len(), "not convex: {part:?}");
                }
                for _ in 0..50 {
                    let p = Point::new(rng.random_range(-2.5..2.5), rng.random_range(-2.5..2.5));
                    let crossed = outline.rings().iter().flat_map(|ring| edges(ring)).filter(|(a, b)| {
                        (a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y)
                    });
                    let is_inside = crossed.count() % 2 == 1;
                    let parts = parts.iter().map(|part| Footprint::Polygon(part.clone()));
                    assert_eq!(parts.filter(|part| part.contains(p)).count() > 0, is_inside, "{p}");
                }
            }
        }
    }

    /// Random boxes, some of which touch or share sides, against their union point by point.
    #[test]
    fn property_an_outline_covers_what_its_polygons_cover() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let mut holes = 0;
        for round in 0..200 {
            let yaw = if round % 2 == 0 { 0.0 } else { rng.random_range(-3.0..3.0) };
            let cell = |k: i32| f64::from(k) * 0.25;
            let polygons: Vec<Vec<Point>> = (0..rng.random_range(2..14))
                .map(|_| {
                    let [x, y] = [(); 2].map(|()| cell(rng.random_range(-6..6)));
                    let size = [(); 2].map(|()| cell(rng.random_range(1..6)));
                    let on_grid = direction(yaw) * x + left_of(direction(yaw)) * y;
                    let own = if rng.random_bool(0.8) { yaw } else { rng.random_range(-3.0..3.0) };
                    turned_box(Point::from(on_grid), size, own)
                })
                .collect();
            let outline = covering(&polygons);
            let parts: Vec<Footprint> =
                outline.parts().unwrap().into_iter().map(Footprint::Polygon).collect();
            let polygons: Vec<Footprint> = polygons.into_iter().map(Footprint::Polygon).collect();
            holes += outline.rings().iter().filter(|ring| doubled_area(ring) < 0.0).count();
            for _ in 0..200 {
                let p = Point::new(rng.random_range(-3.0..3.0), rng.random_range(-3.0..3.0));
                let distance = |all: &[Footprint]| {
                    all.iter().map(|part| part.distance_to_point(p)).fold(f64::INFINITY, f64::min)
                };
                assert!((distance(&parts) - distance(&polygons)).abs() < 1e-6, "{p} in round {round}");
            }
        }
        assert!(holes > 5, "{holes} holes");
    }
}
