//! The outlines of a world's obstacles, as the robot sees them.

use crate::geometry::{Bounds, Footprint, Placed, PlanarPose, Point, Vector, Witness};
use crate::world::World;

/// Additional distance (m) of base and arm from obstacles, because a soft bound may be violated by
/// millimetres.
pub(super) const MARGIN_M: f64 = 0.01;

/// The parts of the robot that are kept off obstacles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Avoid {
    /// None, as in the paper's eq. (7).
    Nothing,
    /// The base.
    Base,
    /// Base and arm.
    Robot,
}

/// The outlines that the robot must keep off.
#[derive(Clone, Debug)]
pub struct RobotObstacles {
    pub(super) outlines: Vec<Outline>,
    /// The largest number of corners of an outline.
    pub(super) most_corners: usize,
}

#[derive(Clone, Debug)]
pub(super) struct Outline {
    pub footprint: Footprint,
    bounds: Bounds,
    /// Height, m.
    pub height: f64,
}

impl Outline {
    /// Signed distance (m) to `p` and its gradient, if the distance is no more than `reach` (m, not
    /// negative).
    pub fn near(&self, p: Point, reach: f64) -> Option<(f64, Vector)> {
        if !self.bounds.grown(reach).contains(p) {
            return None;
        }
        Some(self.footprint.separation(p)).filter(|(distance, _)| *distance <= reach)
    }
}

impl RobotObstacles {
    /// The outlines of a world.
    pub fn new(world: &World) -> Self {
        let outline = |footprint: &Footprint, height| Outline {
            footprint: footprint.clone(),
            bounds: footprint.bounds(),
            height,
        };
        let outlines: Vec<Outline> =
            world.obstacles.iter().flat_map(|o| o.footprints().map(|part| outline(part, o.height))).collect();
        let corners = outlines.iter().map(|o| o.footprint.corners().map_or(1, <[Point]>::len));
        let most_corners = corners.max().unwrap_or(0);
        Self { outlines, most_corners }
    }

    /// Distance (m) between a base at this pose and the nearest obstacle, negative where they overlap; infinite
    /// without obstacles.
    pub fn clearance(&self, base: &PlanarPose, footprint: &Footprint) -> f64 {
        let placed = Placed::new(footprint, base);
        let separations = self.outlines.iter().map(|o| placed.separation(&o.footprint).distance);
        separations.fold(f64::INFINITY, f64::min)
    }

    /// Whether a base at this pose overlaps no obstacle by `tolerance` (m) or more.
    pub fn has_room(&self, base: &PlanarPose, footprint: &Footprint, tolerance: f64) -> bool {
        let (corners, radius) = match footprint {
            Footprint::Disc { radius, .. } => return self.is_clear(base.position, radius - tolerance),
            Footprint::Polygon(corners) => (corners, 0.0),
        };
        let radius = corners.iter().map(|c| c.coords.norm_squared()).fold(radius, f64::max).sqrt();
        let placed = Placed::new(footprint, base);
        self.outlines.iter().all(|o| {
            o.near(base.position, radius).is_none() || placed.separation(&o.footprint).distance > -tolerance
        })
    }

    /// Calls `on_near` with the signed distance (m) and its gradient of every obstacle within `reach` (m, not
    /// negative) of `p`.
    pub fn near_point(&self, p: Point, reach: f64, mut on_near: impl FnMut(f64, Vector)) {
        self.outlines
            .iter()
            .filter_map(|o| o.near(p, reach))
            .for_each(|(distance, away)| on_near(distance, away));
    }

    /// Calls `on_near` for every obstacle within `reach` (m, not negative) of a polygon at this pose, with
    /// the nearest point of the polygon. `radius` is the radius of the polygon's circle, m.
    pub fn near_outline(
        &self,
        pose: &PlanarPose,
        (outline, radius): (&Footprint, f64),
        reach: f64,
        on_near: impl FnMut(Witness),
    ) {
        let placed = Placed::new(outline, pose);
        let is_near = |o: &&Outline| o.near(pose.position, radius + reach).is_some();
        let witnesses = self.outlines.iter().filter(is_near).map(|o| placed.separation(&o.footprint));
        witnesses.filter(|witness| witness.distance <= reach).for_each(on_near);
    }

    /// Whether every obstacle is farther than `room` (m, not negative) from `p`.
    pub fn is_clear(&self, p: Point, room: f64) -> bool {
        self.outlines.iter().all(|o| o.near(p, room).is_none())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    #[test]
    fn property_what_is_clear_is_farther_than_that_from_every_outline() {
        let world = World::parse("w.toml", include_str!("../../../worlds/free-form.toml")).unwrap();
        let obstacles = RobotObstacles::new(&world);
        let mut rng = ChaCha8Rng::seed_from_u64(6);
        let mut clear = 0;
        for _ in 0..5000 {
            let at = Point::new(rng.random_range(-2.0..12.0), rng.random_range(-6.0..6.0));
            let room = rng.random_range(0.0..1.0);
            let is_clear = obstacles.is_clear(at, room);
            let pose = PlanarPose { position: at, yaw: 0.0 };
            let disc = Footprint::Disc { center: Point::origin(), radius: 0.0 };
            assert_eq!(is_clear, obstacles.clearance(&pose, &disc) > room, "{at} {room}");
            clear += u32::from(is_clear);
        }
        assert!((500..4500).contains(&clear), "{clear}");
    }
}
