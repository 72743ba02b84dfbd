//! Random indoor worlds: rooms with doors and furniture, A and B in the open.

use cocarry::geometry::{Point, Vector, direction, left_of};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::fmt::Write;

/// The room (m) that A and B have all round.
pub const CLEAR_M: f64 = 1.2;

/// A rectangle that is longer than the first becomes two rooms, each at least as long as the second, m.
const MAX_ROOM_M: f64 = 5.0;
const MIN_ROOM_M: f64 = 2.6;
/// The room (m) in front of doors in which no furniture stands, and the distance of walls from doors.
const DOOR_ROOM_M: f64 = 1.1;
const DOOR_FRAME_M: f64 = 0.15;
/// The number of places for A and B that are tried in a floor plan.
const MAX_PLACES: u32 = 400;

/// A rectangle on the floor, m.
#[derive(Clone, Copy, Debug)]
struct Rectangle {
    min: [f64; 2],
    max: [f64; 2],
}

impl Rectangle {
    fn size(&self, axis: usize) -> f64 {
        self.max[axis] - self.min[axis]
    }
}

/// A box on the floor, turned.
struct Block {
    name: String,
    center: Point,
    size: [f64; 2],
    /// rad.
    yaw: f64,
}

impl Block {
    fn distance_to(&self, p: Point) -> f64 {
        let (along, offset): (Vector, Vector) = (direction(self.yaw), p - self.center);
        let outside = |offset: f64, size: f64| (offset.abs() - size / 2.0).max(0.0);
        let apart =
            [outside(offset.dot(&along), self.size[0]), outside(offset.dot(&left_of(along)), self.size[1])];
        Vector::from(apart).norm()
    }
}

/// A floor plan that is being drawn.
struct FloorPlan<'r> {
    rng: &'r mut ChaCha8Rng,
    blocks: Vec<Block>,
    rooms: Vec<Rectangle>,
    doors: Vec<Point>,
}

/// A random world file: a building of 9 to 18 m by 7 to 12 m with rooms, doors 0.75 to 1.2 m wide, and
/// furniture. A and B have [`CLEAR_M`] all round and are at least half the building's width apart.
pub fn indoor_world(rng: &mut ChaCha8Rng) -> String {
    loop {
        let size = [rng.random_range(9.0..18.0), rng.random_range(7.0..12.0)];
        let mut plan = FloorPlan { rng, blocks: Vec::new(), rooms: Vec::new(), doors: Vec::new() };
        plan.outer_walls(size);
        plan.divide(Rectangle { min: [0.0; 2], max: size });
        plan.furnish();
        if let Some([start, target]) = plan.ends(size) {
            return plan.written(start, target);
        }
    }
}

impl FloorPlan<'_> {
    fn outer_walls(&mut self, [width, depth]: [f64; 2]) {
        for (name, center, size) in [
            ("south", [width / 2.0, -0.1], [width + 0.4, 0.2]),
            ("north", [width / 2.0, depth + 0.1], [width + 0.4, 0.2]),
            ("west", [-0.1, depth / 2.0], [0.2, depth]),
            ("east", [width + 0.1, depth / 2.0], [0.2, depth]),
        ] {
            self.add(name, Point::from(center), size, 0.0);
        }
    }

    fn add(&mut self, name: &str, center: Point, size: [f64; 2], yaw: f64) {
        let name = match self.blocks.iter().any(|block| block.name == name) {
            true => format!("{name}-{}", self.blocks.len()),
            false => name.to_owned(),
        };
        self.blocks.push(Block { name, center, size, yaw });
    }

    /// Divides a rectangle into rooms by walls across its longer side.
    fn divide(&mut self, rectangle: Rectangle) {
        let axis = usize::from(rectangle.size(1) > rectangle.size(0));
        let across = 1 - axis;
        let [from, to] = [rectangle.min[axis] + MIN_ROOM_M, rectangle.max[axis] - MIN_ROOM_M];
        if rectangle.size(axis) <= MAX_ROOM_M || from >= to {
            self.rooms.push(rectangle);
            return;
        }
        // a wall that ends in a door is drawn elsewhere
        let ends = |at: f64| {
            [rectangle.min[across], rectangle.max[across]].map(|end| {
                let mut p = [at; 2];
                p[across] = end;
                Point::from(p)
            })
        };
        let at = (0..10).map(|_| self.rng.random_range(from..to)).collect::<Vec<f64>>();
        let is_free = |at: &f64| {
            let is_far = |end: &Point| self.doors.iter().all(|door| (door - end).norm() > 0.9);
            ends(*at).iter().all(is_far)
        };
        let Some(at) = at.into_iter().find(is_free) else {
            self.rooms.push(rectangle);
            return;
        };
        self.wall(rectangle, axis, at);
        let (mut first, mut second) = (rectangle, rectangle);
        (first.max[axis], second.min[axis]) = (at, at);
        self.divide(first);
        self.divide(second);
    }

    /// A wall across a rectangle at this place on an axis, with a door or two.
    fn wall(&mut self, rectangle: Rectangle, axis: usize, at: f64) {
        let across = 1 - axis;
        let thickness = self.rng.random_range(0.08..0.2);
        let (low, high) = (rectangle.min[across], rectangle.max[across]);
        let count = if high - low > 5.0 && self.rng.random_bool(0.5) { 2 } else { 1 };
        let share = (high - low) / f64::from(count);
        let mut from = low;
        for i in 0..=count {
            let to = if i == count { high } else { 0.0 };
            let (to, next) = if i < count {
                let width = self.rng.random_range(0.75..1.2);
                let [first, last] = [low + share * f64::from(i), low + share * f64::from(i + 1)];
                let begin = self.rng.random_range(first + DOOR_FRAME_M..last - width - DOOR_FRAME_M);
                let mut door = [at; 2];
                door[across] = begin + width / 2.0;
                self.doors.push(Point::from(door));
                (begin, begin + width)
            } else {
                (to, to)
            };
            let (mut center, mut size) = ([at; 2], [thickness; 2]);
            center[across] = (from + to) / 2.0;
            size[across] = to - from;
            self.add("wall", Point::from(center), size, 0.0);
            from = next;
        }
    }

    /// Tables, cabinets along walls, chairs and pillars.
    fn furnish(&mut self) {
        for room in self.rooms.clone() {
            for _ in 0..self.rng.random_range(0..6) {
                let yaw = if self.rng.random_bool(0.5) { 0.0 } else { std::f64::consts::FRAC_PI_2 };
                let (name, size, is_at_wall, turn) = match self.rng.random_range(0..4) {
                    0 => ("table", [1.2..1.8, 0.6..0.9], false, 0.1),
                    1 => ("cabinet", [0.8..2.0, 0.35..0.6], true, 0.0),
                    2 => ("chair", [0.4..0.5, 0.4..0.5], false, 1.5),
                    _ => ("pillar", [0.25..0.5, 0.25..0.5], false, 0.0),
                };
                let size = size.map(|range| self.rng.random_range(range));
                let yaw = yaw + self.rng.random_range(-turn..=turn);
                let mut place = [0, 1].map(|i| self.rng.random_range(room.min[i] + 0.3..room.max[i] - 0.3));
                if is_at_wall {
                    // its back at the wall that it is along
                    let across = usize::from(yaw == 0.0);
                    place[across] = match self.rng.random_bool(0.5) {
                        true => room.min[across] + size[1] / 2.0 + 0.1,
                        false => room.max[across] - size[1] / 2.0 - 0.1,
                    };
                }
                let center = Point::from(place);
                let block = Block { name: String::new(), center, size, yaw };
                if self.doors.iter().all(|door| block.distance_to(*door) >= DOOR_ROOM_M) {
                    self.add(name, center, size, yaw);
                }
            }
        }
    }

    /// A and B; `None` where there are no such places.
    fn ends(&mut self, size: [f64; 2]) -> Option<[Point; 2]> {
        let mut place = || {
            (0..MAX_PLACES).find_map(|_| {
                let p = Point::from(size.map(|size| self.rng.random_range(CLEAR_M..size - CLEAR_M)));
                // coordinates are written to a millimetre
                self.blocks.iter().all(|block| block.distance_to(p) >= CLEAR_M + 0.001).then_some(p)
            })
        };
        let start = place()?;
        (0..10)
            .find_map(|_| place().filter(|target| (target - start).norm() > size[0] / 2.0))
            .map(|target| [start, target])
    }

    fn written(&self, start: Point, target: Point) -> String {
        let mut text = format!(
            "name = \"random rooms\"\nrobot_width_m = 0.5\nstart_m = [{:.3}, {:.3}]\ntarget_m = [{:.3}, {:.3}]\n",
            start.x, start.y, target.x, target.y
        );
        for Block { name, center, size: [length, width], yaw } in &self.blocks {
            // writing into a string cannot fail
            let _ = writeln!(
                text,
                "\n[[obstacle]]\nname = \"{name}\"\nshape = \"box\"\ncenter_m = [{:.3}, {:.3}]\nsize_m = [{length:.3}, {width:.3}]\nyaw_deg = {:.2}\nheight_m = 1.0",
                center.x,
                center.y,
                yaw.to_degrees()
            );
        }
        text
    }
}
