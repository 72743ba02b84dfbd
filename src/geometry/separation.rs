//! Separation of a convex outline that moves, such as that of a base, from one that stands.
//!
//! Nothing is allocated. The distance of two polygons that are apart is the least distance between a corner of
//! one and the other. Where they overlap, it is the depth along the side, of either, with the shortest way out.

use super::footprint::edges;
use super::{Footprint, PlanarPose, Point, Vector, direction, left_of};

/// A corner of one outline with the part of the other that is nearest to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Witness {
    /// Signed distance, m; negative where the outlines overlap.
    pub distance: f64,
    /// The direction from the outline that stands to the one that moves: the gradient of the distance with
    /// the position of the latter. A unit vector.
    pub away: Vector,
    /// The vector from the origin of the outline that moves to its nearest point, in world axes, m.
    pub lever: Vector,
}

/// A convex outline in a frame of its own, at a pose in the world.
#[derive(Clone, Copy, Debug)]
pub struct Placed<'f> {
    outline: &'f Footprint,
    position: Point,
    /// The frame's x axis.
    ahead: Vector,
}

impl<'f> Placed<'f> {
    /// The outline with its frame at `pose`.
    pub fn new(outline: &'f Footprint, pose: &PlanarPose) -> Self {
        Self { outline, position: pose.position, ahead: direction(pose.yaw) }
    }

    /// A displacement of the outline's frame, in world axes.
    fn turned(&self, v: Vector) -> Vector {
        self.ahead * v.x + left_of(self.ahead) * v.y
    }

    /// A point of the world in the outline's frame.
    pub fn inside_frame(&self, p: Point) -> Point {
        let from = p - self.position;
        Point::new(from.dot(&self.ahead), from.dot(&left_of(self.ahead)))
    }

    /// Signed distance (m) from `other`, negative where the two overlap: the witness that is nearest.
    pub fn separation(&self, other: &Footprint) -> Witness {
        let mut nearest = Witness { distance: f64::INFINITY, away: Vector::zeros(), lever: Vector::zeros() };
        self.witnesses(other, |witness| {
            if witness.distance < nearest.distance {
                nearest = witness;
            }
        });
        nearest
    }

    /// Calls `on_witness` for every pair of a corner and the nearest part of the other outline, at least one.
    /// If the two are apart: for every corner of the moving outline, and for the corners of `other` that are
    /// next to one of its sides. If they overlap: for the corners along the direction of least penetration.
    /// With the pose of the moving outline, each distance changes by the motion of its nearest point along
    /// `away`.
    pub fn witnesses(&self, other: &Footprint, on_witness: impl FnMut(Witness)) {
        self.witnesses_on_motion(other, &[], on_witness);
    }

    /// As [`Placed::witnesses`], for an outline that is also at the poses of `motion`, before and after: where
    /// any of them overlaps `other`, the direction is the one of least penetration of all. So a corner that is
    /// in front of a wall now, and inside the wall's end at the next pose, has that end as its nearest part.
    pub fn witnesses_on_motion(
        &self,
        other: &Footprint,
        motion: &[Placed],
        mut on_witness: impl FnMut(Witness),
    ) {
        let corners = match self.outline {
            Footprint::Disc { center, radius } => {
                let lever = self.turned(center.coords);
                let (distance, away) = other.separation(self.position + lever);
                let lever = lever - away * *radius;
                return on_witness(Witness { distance: distance - radius, away, lever });
            }
            Footprint::Polygon(corners) => corners,
        };
        let side = match other {
            Footprint::Polygon(others) => self.overlap(corners, others, motion),
            Footprint::Disc { center, radius } => self.overlap_of_disc(*center, *radius, motion),
        };
        match (side, other) {
            (Some(Side::Other(a, outward)), _) => {
                for corner in corners {
                    let lever = self.turned(corner.coords);
                    let distance = (self.position + lever - a).dot(&outward);
                    on_witness(Witness { distance, away: outward, lever });
                }
            }
            (_, Footprint::Disc { center, radius }) => {
                let center = self.inside_frame(*center);
                let (distance, outward) = self.outline.separation(center);
                on_witness(self.seen(distance - radius, outward, center.coords - outward * distance));
            }
            (Some(Side::Own(a, outward)), Footprint::Polygon(others)) => {
                for q in others {
                    let q = self.inside_frame(*q);
                    let distance = (q - a).dot(&outward);
                    on_witness(self.seen(distance, outward, q.coords - outward * distance));
                }
            }
            (None, Footprint::Polygon(others)) => {
                for corner in corners {
                    let lever = self.turned(corner.coords);
                    let (distance, away) = other.separation(self.position + lever);
                    on_witness(Witness { distance, away, lever });
                }
                for (a, b) in edges(corners) {
                    let along = b - a;
                    let outward = -left_of(along.normalize());
                    for q in others {
                        let from = self.inside_frame(*q) - a;
                        let (distance, share) = (from.dot(&outward), from.dot(&along) / along.norm_squared());
                        // beyond its ends a corner is nearer
                        if distance >= 0.0 && share > 0.0 && share < 1.0 {
                            on_witness(self.seen(distance, outward, a.coords + along * share));
                        }
                    }
                }
            }
        }
    }

    /// A witness on the outline itself, seen from the world.
    fn seen(&self, distance: f64, outward: Vector, foot: Vector) -> Witness {
        Witness { distance, away: -self.turned(outward), lever: self.turned(foot) }
    }

    /// The least coordinate along `n` of the corners, here and at the poses of `motion`, m.
    fn least(&self, corners: &[Point], motion: &[Placed], n: Vector) -> f64 {
        let places = std::iter::once(self).chain(motion);
        places.fold(f64::INFINITY, |least, place| {
            let n_inside = Vector::new(n.dot(&place.ahead), n.dot(&left_of(place.ahead)));
            let of = corners.iter().map(|c| c.coords.dot(&n_inside)).fold(f64::INFINITY, f64::min);
            least.min(place.position.coords.dot(&n) + of)
        })
    }

    /// The side along whose normal the outlines overlap least; `None` where a side separates them.
    fn overlap(&self, corners: &[Point], others: &[Point], motion: &[Placed]) -> Option<Side> {
        let mut best: Option<(f64, Side)> = None;
        let mut keep = |depth: f64, side: Side| match best {
            Some((least, _)) if depth <= least => {}
            _ => best = Some((depth, side)),
        };
        for (a, b) in edges(others) {
            let outward = -left_of((b - a).normalize());
            let depth = self.least(corners, motion, outward) - a.coords.dot(&outward);
            if depth >= 0.0 {
                return None;
            }
            keep(depth, Side::Other(a, outward));
        }
        for (a, b) in edges(corners) {
            let outward = -left_of((b - a).normalize());
            let toward = -self.turned(outward);
            let reach = others.iter().map(|q| q.coords.dot(&toward)).fold(f64::NEG_INFINITY, f64::max);
            let depth = self.least(corners, motion, toward) - reach;
            if depth >= 0.0 {
                return None;
            }
            keep(depth, Side::Own(a, outward));
        }
        best.map(|(_, side)| side)
    }

    /// As [`Placed::overlap`] for a disc, but `None` where it is not on the way, or least deep as it is here.
    fn overlap_of_disc(&self, center: Point, radius: f64, motion: &[Placed]) -> Option<Side> {
        let Footprint::Polygon(corners) = self.outline else { return None };
        let mut best: Option<(f64, Option<Side>)> = None;
        for place in std::iter::once(self).chain(motion) {
            let (_, outward) = self.outline.separation(place.inside_frame(center));
            let away = -place.turned(outward);
            let depth = self.least(corners, motion, away) - center.coords.dot(&away) - radius;
            if depth >= 0.0 {
                return None;
            }
            if best.as_ref().is_none_or(|(least, _)| depth > *least) {
                let is_here = std::ptr::eq(place, self);
                best = Some((depth, (!is_here).then(|| Side::Other(center + away * radius, away))));
            }
        }
        best.and_then(|(_, side)| side)
    }
}

/// A side by one of its points and its outward normal.
#[derive(Clone, Copy)]
enum Side {
    /// A side of the outline that stands, in the world.
    Other(Point, Vector),
    /// A side of the outline that moves, in its frame.
    Own(Point, Vector),
}

/// The corners of the convex hull of some points, counter-clockwise, no three on a line; fewer than three
/// where all points are on one.
pub fn convex_hull(points: &[Point]) -> Vec<Point> {
    /// Area (m^2) of a triangle that counts as a line, twice.
    const FLAT: f64 = 1e-12;
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    sorted.dedup();
    let mut hull: Vec<Point> = Vec::with_capacity(sorted.len() + 1);
    let mut chain = |points: &mut dyn Iterator<Item = &Point>| {
        let first = hull.len();
        for p in points {
            while let [.., a, b] = hull[first..]
                && super::cross(b - a, p - a) <= FLAT
            {
                hull.pop();
            }
            hull.push(*p);
        }
        // the last point begins the other half
        hull.pop();
    };
    chain(&mut sorted.iter());
    chain(&mut sorted.iter().rev());
    hull
}

/// A convex polygon (counter-clockwise) around this one of fewer corners: sides are left out, and those
/// next to them continued, as long as no corner moves out by more than `most_out` (m) or more than
/// `most_corners` remain.
pub fn with_fewer_corners(mut corners: Vec<Point>, most_corners: usize, most_out: f64) -> Vec<Point> {
    while corners.len() > 3 {
        let n = corners.len();
        let without = |i: usize| {
            let [a, b, c, d] = [n - 1, 0, 1, 2].map(|k| corners[(i + k) % n]);
            let (along, back) = (b - a, c - d);
            let turn = super::cross(along, back);
            // sides that meet ahead of both
            let share = super::cross(c - b, back) / turn;
            let meets = turn.abs() > 1e-9 && share >= 0.0 && super::cross(c - b, along) / turn >= 0.0;
            meets.then(|| b + along * share)
        };
        let out = |i: usize, at: Point| {
            let (b, c) = (corners[i], corners[(i + 1) % n]);
            super::squared_distance_to_segment(at, b, c).sqrt()
        };
        let candidates = (0..n).filter_map(|i| without(i).map(|at| (i, at, out(i, at))));
        let Some((i, at, out)) = candidates.min_by(|a, b| a.2.total_cmp(&b.2)) else { break };
        if out > most_out && n <= most_corners {
            break;
        }
        corners[i] = at;
        corners.remove((i + 1) % n);
    }
    corners
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

    fn rectangle(length: f64, width: f64) -> Footprint {
        let (x, y) = (length / 2.0, width / 2.0);
        Footprint::Polygon([(-x, -y), (x, -y), (x, y), (-x, y)].map(|(x, y)| Point::new(x, y)).to_vec())
    }

    fn at(x: f64, y: f64, yaw: f64) -> PlanarPose {
        PlanarPose { position: Point::new(x, y), yaw }
    }

    /// A random convex polygon about a point.
    fn polygon(rng: &mut ChaCha8Rng, center: Point) -> Footprint {
        loop {
            let points: Vec<Point> = (0..rng.random_range(3..9))
                .map(|_| center + direction(rng.random_range(-3.0..3.0)) * rng.random_range(0.1..0.6))
                .collect();
            let corners = convex_hull(&points);
            if corners.len() >= 3 {
                return Footprint::Polygon(corners);
            }
        }
    }

    #[test]
    fn closed_form_a_rectangle_beside_a_wall() {
        let (base, wall) = (rectangle(0.9, 0.5), rectangle(4.0, 2.0));
        // its end, its side, a corner; and each pushed into the wall
        for (x, yaw, distance, lever) in [
            (2.75, 0.0, 0.3, -0.45),
            (2.75, FRAC_PI_2, 0.5, -0.25),
            (2.75, FRAC_PI_4, 0.75 - 0.7 / 2f64.sqrt(), -0.7 / 2f64.sqrt()),
            (2.35, 0.0, -0.1, -0.45),
            (2.15, FRAC_PI_2, -0.1, -0.25),
        ] {
            let found = Placed::new(&base, &at(x, 0.2, yaw)).separation(&wall);
            assert!((found.distance - distance).abs() < 1e-12, "{x} {yaw}: {found:?}");
            assert!((found.away - Vector::x()).norm() < 1e-12, "{x} {yaw}: {found:?}");
            assert!((found.lever.x - lever).abs() < 1e-12, "{x} {yaw}: {found:?}");
        }
    }

    #[test]
    fn closed_form_a_rectangle_beside_the_corner_of_a_wall_and_a_pillar() {
        let base = rectangle(0.9, 0.5);
        // the wall's corner at (2, 1) is next to the middle of a side
        let found = Placed::new(&base, &at(2.3, 1.3, 3.0 * FRAC_PI_4)).separation(&rectangle(4.0, 2.0));
        let slanted = Vector::new(0.5f64.sqrt(), 0.5f64.sqrt());
        assert!((found.distance - (0.3 * 2f64.sqrt() - 0.25)).abs() < 1e-12, "{found:?}");
        assert!((found.away - slanted).norm() < 1e-12 && (found.lever + slanted * 0.25).norm() < 1e-12);
        let pillar = Footprint::Disc { center: Point::new(1.0, 0.1), radius: 0.2 };
        let found = Placed::new(&base, &at(0.0, 0.0, 0.0)).separation(&pillar);
        assert!((found.distance - 0.35).abs() < 1e-12, "{found:?}");
        assert!((found.away + Vector::x()).norm() < 1e-12);
        assert!((found.lever - Vector::new(0.45, 0.1)).norm() < 1e-12, "{found:?}");
    }

    #[test]
    fn closed_form_a_disc_is_as_far_as_its_centre_less_its_radius() {
        let disc = Footprint::Disc { center: Point::origin(), radius: 0.25 };
        for (x, y) in [(2.5, 0.3), (3.0, 2.0), (1.9, 0.0)] {
            let wall = rectangle(4.0, 2.0);
            let found = Placed::new(&disc, &at(x, y, 0.4)).separation(&wall);
            let (distance, away) = wall.separation(Point::new(x, y));
            assert_eq!((found.distance, found.away), (distance - 0.25, away));
        }
    }

    /// Against the slow way: points along both outlines, and for overlaps the shortest way out in many
    /// directions.
    #[test]
    fn property_separations_agree_with_brute_force() {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let (mut apart, mut overlapping) = (0, 0);
        for _ in 0..400 {
            let base = polygon(&mut rng, Point::origin());
            let center = Point::new(rng.random_range(-1.2..1.2), rng.random_range(-1.2..1.2));
            let other = match rng.random_range(0..4) {
                0 => Footprint::Disc { center, radius: rng.random_range(0.1..0.4) },
                _ => polygon(&mut rng, center),
            };
            let pose = at(rng.random_range(-0.3..0.3), 0.1, rng.random_range(-3.0..3.0));
            let placed = Placed::new(&base, &pose);
            let found = placed.separation(&other);
            let Footprint::Polygon(corners) = &base else { unreachable!() };
            let moved: Vec<Point> = corners.iter().map(|c| pose.position + placed.turned(c.coords)).collect();
            let moved = Footprint::Polygon(moved);
            // the nearest point of one is `lever`, of the other `distance` further; and the plane between them
            // has each on its side
            let way = found.away;
            let gap = -moved.reach(-way) - other.reach(way);
            assert!((gap - found.distance).abs() < 1e-9, "{gap} {found:?}");
            let touches = pose.position + found.lever;
            assert!(moved.distance_to_point(touches) < 1e-9, "{found:?}");
            let directions = (0..3600).map(|i| direction(f64::from(i) * std::f64::consts::TAU / 3600.0));
            let best =
                directions.map(|n| -moved.reach(-n) - other.reach(n)).fold(f64::NEG_INFINITY, f64::max);
            assert!(
                (best - found.distance).abs() < 2e-3 && best <= found.distance + 1e-12,
                "{best} {found:?}"
            );
            if found.distance > 0.0 { apart += 1 } else { overlapping += 1 }
        }
        assert!(apart > 50 && overlapping > 50, "{apart} {overlapping}");
    }

    /// Every witness's distance changes with the pose as its nearest point does along its direction.
    #[test]
    fn property_the_gradient_of_a_separation_agrees_with_finite_differences() {
        let mut rng = ChaCha8Rng::seed_from_u64(12);
        let mut compared = 0;
        for _ in 0..300 {
            let base = polygon(&mut rng, Point::origin());
            let center = Point::new(rng.random_range(-1.2..1.2), rng.random_range(-1.2..1.2));
            let other = match rng.random_range(0..4) {
                0 => Footprint::Disc { center, radius: 0.3 },
                _ => polygon(&mut rng, center),
            };
            let pose = at(0.0, 0.1, rng.random_range(-3.0..3.0));
            let of = |pose: &PlanarPose| Placed::new(&base, pose).separation(&other);
            let here = of(&pose);
            const STEP: f64 = 1e-6;
            let moves = [
                (at(STEP, 0.0, 0.0), here.away.x),
                (at(0.0, STEP, 0.0), here.away.y),
                (at(0.0, 0.0, STEP), here.away.dot(&left_of(here.lever))),
            ];
            for (by, stated) in moves {
                let moved = |sign: f64| {
                    let position = pose.position + by.position.coords * sign;
                    of(&PlanarPose { position, yaw: pose.yaw + by.yaw * sign })
                };
                let (up, down) = (moved(1.0), moved(-1.0));
                // where another corner becomes the nearest, there is no gradient
                if up.away.dot(&down.away) > 1.0 - 1e-6 && (up.lever - down.lever).norm() < 1e-4 {
                    let slope = (up.distance - down.distance) / (2.0 * STEP);
                    assert!((slope - stated).abs() < 1e-4, "{slope} {stated} {here:?}");
                    compared += 1;
                }
            }
        }
        assert!(compared > 700, "{compared}");
    }

    /// A corner 2 cm before the face of a wall's end, 1 cm too far to its side: a step later it is in the end.
    #[test]
    fn closed_form_a_corner_on_its_way_into_the_end_of_a_wall_is_beside_the_end() {
        let (base, wall) = (rectangle(0.9, 0.5), rectangle(0.1, 2.0));
        let poses = [-0.62, -0.52, -0.42].map(|x| at(x, 1.24, 0.0));
        let [before, here, after] = poses.map(|pose| Placed::new(&base, &pose));
        assert!((here.separation(&wall).away + Vector::x()).norm() < 1e-12);
        let mut lowest = f64::INFINITY;
        here.witnesses_on_motion(&wall, &[before, after], |witness| {
            assert!((witness.away - Vector::y()).norm() < 1e-12, "{witness:?}");
            lowest = lowest.min(witness.distance);
        });
        assert!((lowest + 0.01).abs() < 1e-12, "{lowest}");
        // on its way along the wall's face, and straight into it, it is before the face
        for (by, x) in [(at(0.0, 0.1, 0.0), -0.52), (at(0.1, 0.0, 0.0), -0.52)] {
            let straight = at(x, 0.3, 0.0);
            let moved = PlanarPose { position: straight.position + by.position.coords, yaw: 0.0 };
            let here = Placed::new(&base, &straight);
            here.witnesses_on_motion(&wall, &[Placed::new(&base, &moved)], |witness| {
                assert!(witness.distance > 0.3 || (witness.away + Vector::x()).norm() < 1e-12, "{witness:?}");
            });
        }
        // a pillar that the corner comes into from the side
        let pillar = Footprint::Disc { center: Point::new(0.05, 0.0), radius: 0.05 };
        let [here, after] = [-0.46, -0.36].map(|x| Placed::new(&base, &at(x, 0.29, 0.0)));
        assert!(here.separation(&pillar).distance > 0.0);
        here.witnesses_on_motion(&pillar, &[after], |witness| {
            assert!(witness.away.y > 0.9, "{witness:?}");
        });
    }

    #[test]
    fn closed_form_the_hull_of_points_leaves_out_those_inside_and_between() {
        let points = [(0., 0.), (2., 0.), (1., 0.), (2., 2.), (0., 2.), (1., 1.), (0., 1.), (0., 0.)];
        let hull = convex_hull(&points.map(|(x, y)| Point::new(x, y)));
        assert_eq!(hull, [(0., 0.), (2., 0.), (2., 2.), (0., 2.)].map(|(x, y)| Point::new(x, y)));
        assert!(convex_hull(&[(0., 0.), (1., 1.), (2., 2.)].map(|(x, y)| Point::new(x, y))).len() < 3);
    }

    #[test]
    fn property_a_polygon_of_fewer_corners_has_the_other_inside() {
        let circle: Vec<Point> = (0..200)
            .map(|i| Point::from(direction(f64::from(i) * std::f64::consts::TAU / 200.0) * 0.3))
            .collect();
        for (most_corners, most_out) in [(64, 0.002), (200, 0.005), (8, 1e-6), (3, 0.0)] {
            let fewer = with_fewer_corners(circle.clone(), most_corners, most_out);
            assert!(fewer.len() <= most_corners, "{}", fewer.len());
            let outline = Footprint::Polygon(fewer.clone());
            assert!(circle.iter().all(|p| outline.separation(*p).0 < 1e-12));
            let out = fewer.iter().map(|p| math::hypot(p.x, p.y) - 0.3).fold(0.0, f64::max);
            assert!(most_corners < 64 || out <= 2.0 * most_out, "{out}");
        }
        let square = vec![(0., 0.), (2., 0.), (2., 2.), (0., 2.)];
        let square: Vec<Point> = square.into_iter().map(|(x, y)| Point::new(x, y)).collect();
        assert_eq!(with_fewer_corners(square.clone(), 64, 0.5), square);
    }
}
