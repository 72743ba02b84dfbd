//! The discs around obstacle corners and cylinders that taut strings bend around.

use crate::geometry::{Bend, Bounds, Corner, Footprint, Point, Solid, Vector, angle_of, cross, direction};
use crate::math;
use std::f64::consts::TAU;

/// Tolerance for comparing distances with the clearance, m. Paths touch discs exactly at the clearance.
pub(super) const CLEARANCE_TOLERANCE_M: f64 = 1e-9;

/// Angles closer than this are the same, rad.
pub(super) const SAME_ANGLE_RAD: f64 = 1e-9;

/// More than [`Disc::early`] for radii above 20 micrometres.
const EARLY_MARGIN: f64 = 0.01;

/// The longest arc (rad) that one triangle has within it.
const ARC_RAD: f64 = 0.2;

/// A disc that strings bend around.
#[derive(Clone, Debug)]
pub(in crate::options) struct Disc {
    /// The parts of obstacles around which it lies.
    pub parts: Vec<usize>,
    pub center: Point,
    pub radius: f64,
    /// For a corner, the outward normals of its two sides, counter-clockwise. A taut string touches between
    /// them.
    pub between: Option<[Vector; 2]>,
}

impl Disc {
    /// The discs of a solid, whose parts are numbered from `first`.
    pub fn all_of(first: usize, solid: &Solid, clearance: f64) -> Vec<Self> {
        let around = |(i, part): (usize, &Footprint)| match part {
            Footprint::Disc { center, radius } => Some(Self {
                parts: vec![first + i],
                center: *center,
                radius: radius + clearance,
                between: None,
            }),
            Footprint::Polygon(_) => None,
        };
        let corner = |corner: &Corner| {
            let parts = (0..solid.parts.len()).filter(|&i| corner.is_of(&solid.parts[i]));
            let parts = parts.map(|i| first + i).collect();
            Self { parts, center: corner.at, radius: clearance, between: Some(corner.normals) }
        };
        solid.parts.iter().enumerate().filter_map(around).chain(solid.corners.iter().map(corner)).collect()
    }

    /// The smallest rectangle around it.
    pub fn bounds(&self) -> Bounds {
        Bounds { min: self.center, max: self.center }.grown(self.radius)
    }

    /// Its circle, followed counter-clockwise where `turn` is 1 and clockwise where it is -1.
    pub fn bend(&self, turn: f64) -> Bend {
        Bend { center: self.center, radius: turn * self.radius }
    }

    /// The point of the circle at `angle`.
    pub fn at(&self, angle: f64) -> Point {
        self.center + direction(angle) * self.radius
    }

    /// Whether a taut string may touch the disc at `angle`.
    pub fn is_taut(&self, angle: f64) -> bool {
        self.between.is_none_or(|[first, last]| {
            let d = direction(angle);
            let early = self.early();
            cross(first, d) >= -early && cross(d, last) >= -early
        })
    }

    /// Triangles in which all points lie where [`Disc::is_taut`] lets a string touch the disc: the ends of an
    /// arc, and where the tangents at these meet.
    pub fn touched_within(&self) -> impl Iterator<Item = [Point; 3]> {
        let (from, sweep) = self.between.map_or((0.0, TAU), |[first, last]| {
            let sweep = (angle_of(last) - angle_of(first)).rem_euclid(TAU);
            (angle_of(first) - EARLY_MARGIN, sweep + 2.0 * EARLY_MARGIN)
        });
        let count = (sweep / ARC_RAD).ceil();
        let half = sweep / count / 2.0;
        (0..count as usize).map(move |i| {
            let middle = from + half * (2 * i + 1) as f64;
            let apex = self.center + direction(middle) * (self.radius / math::cos(half));
            [self.at(middle - half), self.at(middle + half), apex]
        })
    }

    /// Whether a taut string certainly does not touch the circle at its point `at`. This is quicker than
    /// [`Disc::is_taut`] and leaves cases within rounding to it.
    pub fn is_slack(&self, at: Point) -> bool {
        const ROUNDING: f64 = 1e-9;
        self.between.is_some_and(|[first, last]| {
            let d = (at - self.center) / self.radius;
            let early = self.early() + ROUNDING;
            cross(first, d) < -early || cross(d, last) < -early
        })
    }

    /// Whether a taut line may leave this disc and touch another, both followed in the direction of these
    /// turns. A quick test of where the corners' sides face; most pairs of corners fail it.
    pub fn may_lead(&self, turn: f64, other: &Self, other_turn: f64) -> bool {
        let v = other.center - self.center;
        let faces = |disc: &Self, turn: f64| {
            disc.between.is_none_or(|[first, last]| {
                // the line's direction is between the tangents at the two normals; its ends lie at most both
                // radii to the side of the line from centre to centre
                let least = -(self.radius + other.radius + EARLY_MARGIN * (v.x.abs() + v.y.abs()));
                -turn * first.dot(&v) >= least && turn * last.dot(&v) >= least
            })
        };
        faces(self, turn) && faces(other, other_turn)
    }

    /// The sine of the angle by which a string that dips by [`CLEARANCE_TOLERANCE_M`] along a side meets the
    /// corner's circle too early.
    fn early(&self) -> f64 {
        (2.0 * CLEARANCE_TOLERANCE_M / self.radius).sqrt()
    }

    /// `angle`, or the nearest angle at which a taut string may touch the disc.
    pub fn nearest_taut(&self, angle: f64) -> f64 {
        match self.between {
            Some([first, last]) if !self.is_taut(angle) => {
                let d = direction(angle);
                angle_of(if d.dot(&first) >= d.dot(&last) { first } else { last })
            }
            _ => angle,
        }
    }
}

/// +1 on counter-clockwise rings, -1 on clockwise ones.
pub(super) fn turn(ring: usize) -> f64 {
    if ring.is_multiple_of(2) { 1.0 } else { -1.0 }
}

/// Whether the arc crosses or touches the segment `a b`.
pub(super) fn arc_crosses(disc: &Disc, from_angle: f64, sweep: f64, a: Point, b: Point) -> bool {
    let (d, f) = (b - a, a - disc.center);
    let (qa, qb, qc) = (d.norm_squared(), f.dot(&d), f.norm_squared() - disc.radius * disc.radius);
    let discriminant = qb * qb - qa * qc;
    if discriminant <= 0.0 || qa == 0.0 {
        return false;
    }
    let root = discriminant.sqrt();
    [(-qb - root) / qa, (-qb + root) / qa].into_iter().filter(|t| (0.0..=1.0).contains(t)).any(|t| {
        let angle = angle_of(f + d * t);
        let ahead = ((angle - from_angle) * sweep.signum()).rem_euclid(TAU);
        ahead <= sweep.abs() + SAME_ANGLE_RAD || ahead >= TAU - SAME_ANGLE_RAD
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    #[test]
    fn property_every_taut_line_may_lead_from_disc_to_disc() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let (mut taut, mut spared) = (0, 0);
        for _ in 0..2000 {
            let mut disc = || {
                let corner = Point::new(rng.random_range(-3.0..3.0), rng.random_range(-3.0..3.0));
                let first = rng.random_range(0.0..TAU);
                let normals = [first, first + rng.random_range(0.1..3.0)].map(direction);
                Disc { parts: vec![0], center: corner, radius: 0.25, between: Some(normals) }
            };
            let discs = [disc(), disc()];
            for [from, to] in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
                let Some(ends) = discs[0].bend(from).line_to(&discs[1].bend(to)) else { continue };
                let is_taut = |i: usize| discs[i].is_taut(angle_of(ends[i] - discs[i].center));
                if is_taut(0) && is_taut(1) {
                    taut += 1;
                    assert!(discs[0].may_lead(from, &discs[1], to), "{discs:?}, {from}, {to}");
                }
                spared += usize::from(!discs[0].may_lead(from, &discs[1], to));
            }
        }
        assert!(taut > 300 && spared > 3000, "{taut} taut lines, {spared} spared");
    }
}
