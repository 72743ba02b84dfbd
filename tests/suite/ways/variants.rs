//! Options do not depend on where a room is, nor on how it is written.

use super::HEAD;
use cocarry::geometry::{Vector, direction};
use cocarry::math;
use cocarry::options::OptionSet;
use cocarry::world::World;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// A room of the paper's kind: boxes, cylinders and polygons as (name, shape), which can be moved as a whole.
#[derive(Clone)]
enum Shape {
    Box([f64; 2], [f64; 2], f64),
    Cylinder([f64; 2], f64),
    Polygon(Vec<[f64; 2]>),
}

#[derive(Clone)]
struct Room {
    start: [f64; 2],
    target: [f64; 2],
    obstacles: Vec<(String, Shape)>,
}

impl Room {
    fn random(rng: &mut ChaCha8Rng) -> Self {
        let (length, height) = (rng.random_range(9.0..14.0), rng.random_range(7.0..11.0));
        let side =
            |name: &str, center: [f64; 2], size: [f64; 2]| (name.to_owned(), Shape::Box(center, size, 0.0));
        let mut obstacles = vec![
            side("S", [length / 2.0, -0.1], [length + 4.0, 0.2]),
            side("N", [length / 2.0, height + 0.1], [length + 4.0, 0.2]),
            side("W", [-1.9, height / 2.0], [0.2, height + 0.4]),
            side("E", [length + 1.9, height / 2.0], [0.2, height + 0.4]),
        ];
        for i in 0..rng.random_range(3..16) {
            let center = [rng.random_range(2.0..length - 2.0), rng.random_range(0.3..height - 0.3)];
            let shape = match rng.random_range(0..3) {
                0 => Shape::Cylinder(center, rng.random_range(0.2..0.9)),
                1 => Shape::Box(
                    center,
                    [rng.random_range(0.3..2.2), rng.random_range(0.2..1.0)],
                    rng.random_range(-90.0..90.0),
                ),
                _ => {
                    let (corners, radius) = (rng.random_range(3..8), rng.random_range(0.4..1.0));
                    let turn = rng.random_range(0.0..1.0);
                    let corner = |k: usize| {
                        let at =
                            direction(std::f64::consts::TAU * (k as f64 + turn) / corners as f64) * radius;
                        [center[0] + at.x, center[1] + at.y]
                    };
                    Shape::Polygon((0..corners).map(corner).collect())
                }
            };
            obstacles.push((format!("o{i}"), shape));
        }
        let y = |rng: &mut ChaCha8Rng| rng.random_range(2.0..height - 2.0);
        Self { start: [0.3, y(rng)], target: [length - 1.2, y(rng)], obstacles }
    }

    /// The room mirrored at the x axis or not, turned by `turn` (rad), then moved.
    fn placed(&self, is_mirrored: bool, turn: f64, by: [f64; 2]) -> Self {
        let point = |[x, y]: [f64; 2]| {
            let (sin, cos) = (math::sin(turn), math::cos(turn));
            let y = if is_mirrored { -y } else { y };
            [cos * x - sin * y + by[0], sin * x + cos * y + by[1]]
        };
        let shape = |shape: &Shape| match shape {
            Shape::Box(center, size, yaw) => {
                let yaw = if is_mirrored { -yaw } else { *yaw } + turn.to_degrees();
                Shape::Box(point(*center), *size, (yaw + 540.0).rem_euclid(360.0) - 180.0)
            }
            Shape::Cylinder(center, radius) => Shape::Cylinder(point(*center), *radius),
            Shape::Polygon(corners) => Shape::Polygon(corners.iter().copied().map(point).collect()),
        };
        let obstacles = self.obstacles.iter().map(|(name, s)| (name.clone(), shape(s))).collect();
        Self { start: point(self.start), target: point(self.target), obstacles }
    }

    /// Boxes as polygons, or the outlines of polygons the other way round.
    fn redrawn(&self, boxes: bool) -> Self {
        let shape = |shape: &Shape| match shape {
            Shape::Box([x, y], [length, width], yaw) if boxes => {
                let (along, across) =
                    (direction(yaw.to_radians()), direction(yaw.to_radians() + 0.5 * std::f64::consts::PI));
                let corner = |(u, v): (f64, f64)| {
                    let at = Vector::new(*x, *y) + along * (u * length / 2.0) + across * (v * width / 2.0);
                    [at.x, at.y]
                };
                Shape::Polygon([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(corner).to_vec())
            }
            Shape::Polygon(corners) if !boxes => Shape::Polygon(corners.iter().rev().copied().collect()),
            other => other.clone(),
        };
        let obstacles = self.obstacles.iter().map(|(name, s)| (name.clone(), shape(s))).collect();
        Self { obstacles, ..self.clone() }
    }

    fn reversed(&self) -> Self {
        Self { obstacles: self.obstacles.iter().rev().cloned().collect(), ..self.clone() }
    }

    fn text(&self) -> String {
        let mut text = format!("{HEAD}start_m = {:?}\ntarget_m = {:?}\n", self.start, self.target);
        for (name, shape) in &self.obstacles {
            let shape = match shape {
                Shape::Box(center, size, yaw) => {
                    format!("shape = \"box\"\ncenter_m = {center:?}\nsize_m = {size:?}\nyaw_deg = {yaw:?}")
                }
                Shape::Cylinder(center, radius) => {
                    format!("shape = \"cylinder\"\ncenter_m = {center:?}\nradius_m = {radius:?}")
                }
                Shape::Polygon(corners) => format!("shape = \"polygon\"\nvertices_m = {corners:?}"),
            };
            text += &format!("[[obstacle]]\nname = \"{name}\"\n{shape}\nheight_m = 1\n");
        }
        text
    }
}

/// The obstacles of an option's openings, its length (m) and its risk.
pub(super) type Offer = (Vec<[String; 2]>, f64, f64);

/// The options of a room in order; `None` where it is refused.
pub(super) fn offered(text: &str) -> Option<Vec<Offer>> {
    let world = World::parse("room", text).ok()?;
    let set = OptionSet::new(&world, 10.0).ok()?;
    let begin = set.begin();
    let option = |o: usize| {
        let between = set.options()[o].crossings.iter().map(|c| {
            let mut names = world.openings[c.opening].between.map(|i| world.obstacles[i].name.clone());
            names.sort();
            names
        });
        let left = set.remaining(&begin, o);
        (between.collect(), left.length, left.risk)
    };
    Some((0..set.options().len()).map(option).collect())
}

#[test]
fn property_options_do_not_depend_on_where_a_room_is_nor_on_how_it_is_written() {
    let mut rng = ChaCha8Rng::seed_from_u64(150);
    let (mut rooms, mut compared, mut worst) = (0, 0, 0.0);
    while rooms < 60 {
        let room = Room::random(&mut rng);
        let Some(expected) = offered(&room.text()) else { continue };
        rooms += 1;
        let variants = [
            ("turned by 90 degrees", room.placed(false, std::f64::consts::FRAC_PI_2, [0.0; 2])),
            ("turned by 30 degrees", room.placed(false, 30f64.to_radians(), [0.0; 2])),
            ("turned by -77.3 degrees", room.placed(false, -77.3f64.to_radians(), [0.0; 2])),
            ("mirrored", room.placed(true, 0.0, [0.0; 2])),
            ("mirrored and turned", room.placed(true, 0.2, [0.0; 2])),
            ("moved", room.placed(false, 0.0, [1000.0, -2000.0])),
            ("in reverse order", room.reversed()),
            ("boxes as polygons", room.redrawn(true)),
            ("polygons clockwise", room.redrawn(false)),
        ];
        for (variant, room) in variants {
            let found =
                offered(&room.text()).unwrap_or_else(|| panic!("{variant}: refused\n{}", room.text()));
            let ways = |options: &[(Vec<[String; 2]>, f64, f64)]| {
                options.iter().map(|o| o.0.clone()).collect::<Vec<_>>()
            };
            assert_eq!(ways(&found), ways(&expected), "{variant}\n{}", room.text());
            for ((_, length, risk), (_, expected_length, expected_risk)) in found.iter().zip(&expected) {
                let off = f64::max((length - expected_length).abs(), (risk - expected_risk).abs());
                worst = f64::max(worst, off);
                assert!(
                    off < 1e-9,
                    "{variant}: {length} m not {expected_length} m, {risk} not {expected_risk}\n{}",
                    room.text()
                );
                compared += 1;
            }
        }
    }
    assert!(compared > 2000, "{compared} compared, {worst} at most");
}
