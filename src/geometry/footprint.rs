//! The outline of an upright obstacle or a base on the floor, with distances to points and segments.
//!
//! These are the innermost operations of every path query. They are therefore written out for the two kinds
//! of outline. `tests/suite` compares them with parry's general distance.

use super::{Point, Vector, cross, nearest_on_segment, segments_cross, squared_distance_to_segment};

/// A convex outline on the floor, metres in the world frame; that of a base in the frame of its drive.
#[derive(Clone, Debug, PartialEq)]
pub enum Footprint {
    /// Corners of a convex polygon, counter-clockwise, no three on a line.
    Polygon(Vec<Point>),
    /// A disc.
    Disc {
        /// Centre.
        center: Point,
        /// Radius, m, positive.
        radius: f64,
    },
}

/// An axis-aligned rectangle, metres in the world frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Corner with the least x and y.
    pub min: Point,
    /// Corner with the greatest x and y.
    pub max: Point,
}

impl Bounds {
    /// The smallest rectangle around `points`; `None` without points.
    pub fn around(points: impl IntoIterator<Item = Point>) -> Option<Self> {
        points.into_iter().fold(None, |bounds: Option<Self>, p| {
            Some(match bounds {
                None => Self { min: p, max: p },
                Some(b) => Self { min: b.min.inf(&p), max: b.max.sup(&p) },
            })
        })
    }

    /// The rectangle with every side moved outward by `margin` (m).
    pub fn grown(self, margin: f64) -> Self {
        let by = Vector::new(margin, margin);
        Self { min: self.min - by, max: self.max + by }
    }

    /// Whether `p` is in it or on its sides.
    pub fn contains(&self, p: Point) -> bool {
        p.x >= self.min.x && p.x <= self.max.x && p.y >= self.min.y && p.y <= self.max.y
    }

    /// Width along x and y, m.
    pub fn size(&self) -> Vector {
        self.max - self.min
    }

    /// Whether all of the segment `a b` lies beyond one of its sides.
    pub(super) fn misses_segment(&self, a: Point, b: Point) -> bool {
        (a.x < self.min.x && b.x < self.min.x)
            || (a.x > self.max.x && b.x > self.max.x)
            || (a.y < self.min.y && b.y < self.min.y)
            || (a.y > self.max.y && b.y > self.max.y)
    }
}

impl Footprint {
    /// The smallest axis-aligned rectangle around the outline.
    pub fn bounds(&self) -> Bounds {
        match self {
            Self::Polygon(corners) => Bounds::around(corners.iter().copied())
                .unwrap_or(Bounds { min: Point::origin(), max: Point::origin() }),
            Self::Disc { center, radius } => Bounds { min: *center, max: *center }.grown(*radius),
        }
    }

    /// The corners of a polygon, counter-clockwise; `None` for a disc.
    pub fn corners(&self) -> Option<&[Point]> {
        match self {
            Self::Polygon(corners) => Some(corners),
            Self::Disc { .. } => None,
        }
    }

    /// Whether `p` lies inside or on the outline.
    pub fn contains(&self, p: Point) -> bool {
        match self {
            Self::Polygon(corners) => edges(corners).all(|(a, b)| cross(b - a, p - a) >= 0.0),
            Self::Disc { center, radius } => (p - center).norm_squared() <= radius * radius,
        }
    }

    /// Distance (m) from `p` to the outline's area; 0 inside.
    pub fn distance_to_point(&self, p: Point) -> f64 {
        match self {
            Self::Polygon(_) if self.contains(p) => 0.0,
            Self::Polygon(corners) => edges(corners)
                .map(|(a, b)| squared_distance_to_segment(p, a, b))
                .fold(f64::INFINITY, f64::min)
                .sqrt(),
            Self::Disc { center, radius } => ((p - center).norm() - radius).max(0.0),
        }
    }

    /// Signed distance (m) from the outline to `p`, negative inside, and its gradient, a unit vector.
    pub fn separation(&self, p: Point) -> (f64, Vector) {
        match self {
            Self::Polygon(corners) => {
                // the edge whose line `p` is farthest outside of (or least inside of)
                let outside = edges(corners)
                    .map(|(a, b)| {
                        let outward = -super::left_of((b - a).normalize());
                        ((p - a).dot(&outward), outward)
                    })
                    .fold((f64::NEG_INFINITY, Vector::zeros()), |x, y| if y.0 > x.0 { y } else { x });
                let distance = self.distance_to_point(p);
                let nearest = edges(corners).map(|(a, b)| nearest_on_segment(p, a, b)).find(|n| {
                    // beyond a corner, the gradient points away from the corner
                    distance > 1e-9 && ((p - n).norm() - distance).abs() < 1e-12
                });
                nearest.map_or(outside, |n| (distance, (p - n) / distance))
            }
            Self::Disc { center, radius } => {
                let away = p - center;
                let direction = away.try_normalize(0.0).unwrap_or(Vector::x());
                (away.norm() - radius, direction)
            }
        }
    }

    /// Distance (m) from the segment `a b` to the outline's area; 0 where they meet.
    pub fn distance_to_segment(&self, a: Point, b: Point) -> f64 {
        match self {
            Self::Polygon(corners) => {
                if self.contains(a) || edges(corners).any(|(p, q)| segments_cross(a, b, p, q)) {
                    return 0.0;
                }
                edges(corners)
                    .map(|(p, q)| {
                        squared_distance_to_segment(a, p, q)
                            .min(squared_distance_to_segment(b, p, q))
                            .min(squared_distance_to_segment(p, a, b))
                    })
                    .fold(f64::INFINITY, f64::min)
                    .sqrt()
            }
            Self::Disc { center, radius } => {
                (squared_distance_to_segment(*center, a, b).sqrt() - radius).max(0.0)
            }
        }
    }

    /// The closest points of this outline and another one; the same point twice where they meet.
    pub fn closest_points(&self, other: &Self) -> [Point; 2] {
        match (self, other) {
            (Self::Polygon(corners), Self::Polygon(others)) => {
                if other.contains(corners[0]) {
                    return [corners[0]; 2];
                }
                let mut best = ([others[0]; 2], f64::INFINITY);
                let mut keep = |pair: [Point; 2]| {
                    let distance = (pair[1] - pair[0]).norm_squared();
                    if distance < best.1 {
                        best = (pair, distance);
                    }
                };
                for (a, b) in edges(corners) {
                    others.iter().for_each(|p| keep([nearest_on_segment(*p, a, b), *p]));
                    if other.distance_to_segment(a, b) == 0.0 {
                        keep([nearest_on_segment(others[0], a, b); 2]);
                    }
                }
                for (a, b) in edges(others) {
                    corners.iter().for_each(|p| keep([*p, nearest_on_segment(*p, a, b)]));
                }
                best.0
            }
            (Self::Disc { center, radius }, _) => {
                let (distance, away) = other.separation(*center);
                let distance = distance.max(*radius);
                [center - away * *radius, center - away * distance]
            }
            (_, Self::Disc { .. }) => {
                let [second, first] = other.closest_points(self);
                [first, second]
            }
        }
    }

    /// The unit vector from the outline to the segment `a b` at their nearest points; `None` where they meet.
    pub fn toward_segment(&self, a: Point, b: Point) -> Option<Vector> {
        if self.distance_to_segment(a, b) <= 0.0 {
            return None;
        }
        let away = match self {
            Self::Polygon(corners) => {
                let from_edges =
                    edges(corners).flat_map(|(p, q)| [a, b].map(|end| end - nearest_on_segment(end, p, q)));
                let from_corners = corners.iter().map(|c| nearest_on_segment(*c, a, b) - c);
                let away = from_edges.chain(from_corners);
                away.min_by(|v, w| v.norm_squared().total_cmp(&w.norm_squared()))?
            }
            Self::Disc { center, .. } => nearest_on_segment(*center, a, b) - center,
        };
        away.try_normalize(0.0)
    }

    /// The largest coordinate of the outline along the unit vector `toward`, m from the world's origin.
    pub fn reach(&self, toward: Vector) -> f64 {
        match self {
            Self::Polygon(corners) => {
                corners.iter().map(|c| c.coords.dot(&toward)).fold(f64::NEG_INFINITY, f64::max)
            }
            Self::Disc { center, radius } => center.coords.dot(&toward) + radius,
        }
    }

    /// Whether the segment `a b` keeps at least `clearance` (m) from the outline. `bounds` must be the
    /// outline's [`Footprint::bounds`].
    pub fn clears_segment(&self, bounds: Bounds, a: Point, b: Point, clearance: f64) -> bool {
        bounds.grown(clearance).misses_segment(a, b) || self.distance_to_segment(a, b) >= clearance
    }

    /// The face that lies farthest along the unit vector `toward`: the farthest corner, and what lies within
    /// `tolerance` (m) of it along sides that are perpendicular to `toward` up to `slope` (rad). Returned as
    /// an interval on the axis to the left of `toward`, m from the world's origin.
    ///
    /// It changes continuously with the outline: the tolerance decreases to 0 at `slope`.
    pub fn farthest_face(&self, toward: Vector, tolerance: f64, slope: f64) -> [f64; 2] {
        let left = super::left_of(toward);
        let corners = match self {
            Self::Polygon(corners) => corners,
            Self::Disc { center, .. } => return [center.coords.dot(&left); 2],
        };
        let reach = self.reach(toward);
        let mut face = [f64::INFINITY, f64::NEG_INFINITY];
        let mut add = |along: f64| face = [face[0].min(along), face[1].max(along)];
        for (a, b) in edges(corners) {
            let [from, to] = [a, b].map(|c| (reach - c.coords.dot(&toward), c.coords.dot(&left)));
            let (near, far) = if from.0 <= to.0 { (from, to) } else { (to, from) };
            let (rise, length) = (far.0 - near.0, (b - a).norm());
            let within = tolerance * (1.0 - rise / (length * slope)).max(0.0) - near.0;
            if within >= 0.0 {
                add(near.1);
                add(if rise <= within { far.1 } else { near.1 + (far.1 - near.1) * (within / rise) });
            }
        }
        face
    }

    /// The distances (m) from `p` along the unit vector `toward` between which that ray is in the outline's
    /// area; `None` where it misses it.
    pub fn along_ray(&self, p: Point, toward: Vector) -> Option<[f64; 2]> {
        let [mut enters, mut leaves] = [0.0, f64::INFINITY];
        match self {
            Self::Polygon(corners) => {
                for (a, b) in edges(corners) {
                    // inside is left of every side
                    let (inside, slope) = (cross(b - a, p - a), cross(b - a, toward));
                    if slope > 0.0 {
                        enters = f64::max(enters, -inside / slope);
                    } else if slope < 0.0 {
                        leaves = f64::min(leaves, inside / -slope);
                    } else if inside < 0.0 {
                        return None;
                    }
                }
            }
            Self::Disc { center, radius } => {
                let (along, across) = ((center - p).dot(&toward), cross(toward, center - p));
                let half = (radius * radius - across * across).max(0.0).sqrt();
                if across.abs() > *radius {
                    return None;
                }
                [enters, leaves] = [f64::max(0.0, along - half), along + half];
            }
        }
        (enters <= leaves).then_some([enters, leaves])
    }
}

/// The sides of a polygon, in order.
pub(super) fn edges(corners: &[Point]) -> impl Iterator<Item = (Point, Point)> + '_ {
    (0..corners.len()).map(|i| (corners[i], corners[(i + 1) % corners.len()]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Footprint {
        Footprint::Polygon(vec![
            Point::new(0.0, 0.0),
            Point::new(2.0, 0.0),
            Point::new(2.0, 2.0),
            Point::new(0.0, 2.0),
        ])
    }

    #[test]
    fn closed_form_distances_to_a_square() {
        let s = square();
        assert_eq!(s.distance_to_point(Point::new(1.0, 1.0)), 0.0);
        assert_eq!(s.distance_to_point(Point::new(3.0, 1.0)), 1.0);
        assert_eq!(s.distance_to_point(Point::new(5.0, 6.0)), 5.0);
        assert_eq!(s.distance_to_segment(Point::new(3.0, -5.0), Point::new(3.0, 5.0)), 1.0);
        assert_eq!(s.distance_to_segment(Point::new(-1.0, 1.0), Point::new(3.0, 1.0)), 0.0);
        assert_eq!(s.distance_to_segment(Point::new(0.5, 1.0), Point::new(0.6, 1.0)), 0.0);
    }

    #[test]
    fn closed_form_the_side_of_a_square_on_which_a_segment_is() {
        let (s, disc) = (square(), Footprint::Disc { center: Point::new(1.0, 1.0), radius: 1.0 });
        for outline in [&s, &disc] {
            let toward = outline.toward_segment(Point::new(-9.0, 2.5), Point::new(9.0, 2.5));
            assert_eq!(toward, Some(Vector::y()));
            assert_eq!(outline.reach(Vector::y()), 2.0);
            assert_eq!(outline.toward_segment(Point::new(-9.0, 1.5), Point::new(9.0, 1.5)), None);
        }
        // an end next to a side, a corner next to the middle of the segment
        assert_eq!(s.toward_segment(Point::new(3.0, 1.0), Point::new(9.0, 1.0)), Some(Vector::x()));
        let past_corner = s.toward_segment(Point::new(2.0, 4.0), Point::new(4.0, 2.0)).unwrap();
        assert!((past_corner - Vector::new(0.5_f64.sqrt(), 0.5_f64.sqrt())).norm() < 1e-12);
    }

    #[test]
    fn closed_form_the_farthest_part_of_a_square_is_its_side() {
        assert_eq!(square().farthest_face(Vector::new(1.0, 0.0), 1e-9, 1e-3), [0.0, 2.0]);
        // turned a little: the part of the side within the tolerance, then the corner alone
        let face = |turn: f64| square().farthest_face(crate::geometry::direction(turn), 1e-5, 1e-3);
        let length = |turn: f64| face(turn)[1] - face(turn)[0];
        assert!((length(4e-6) - 2.0).abs() < 1e-9 && length(1e-3).abs() < 1e-6 && length(0.3) == 0.0);
        assert!((length(1e-4) - 0.09).abs() < 1e-6, "{}", length(1e-4));
    }

    #[test]
    fn closed_form_rays_through_a_square_and_a_disc() {
        let (s, disc) = (square(), Footprint::Disc { center: Point::new(1.0, 1.0), radius: 1.0 });
        for outline in [&s, &disc] {
            assert_eq!(outline.along_ray(Point::new(-1.0, 1.0), Vector::x()), Some([1.0, 3.0]));
            assert_eq!(outline.along_ray(Point::new(1.0, 1.0), -Vector::y()), Some([0.0, 1.0]));
            assert_eq!(outline.along_ray(Point::new(3.0, 1.0), Vector::x()), None);
            assert_eq!(outline.along_ray(Point::new(-1.0, 2.5), Vector::x()), None);
        }
    }
}
