//! The same world elsewhere: turned, mirrored or moved as a whole. What happens in it should not depend on
//! that.

use cocarry::math;
use serde::Serialize;
use toml::{Table, Value};

/// The angle of [`Placed::Turned`], degrees.
const TURN_DEG: f64 = 77.3;
/// The displacement of [`Placed::Moved`], m.
const MOVED_M: [f64; 2] = [1000.0, -2000.0];

/// Where a world lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Placed {
    /// As it was drawn.
    #[default]
    AsDrawn,
    /// Turned by 77.3 degrees about the origin.
    Turned,
    /// Mirrored at the x axis.
    Mirrored,
    /// Moved by a kilometre to the east and two to the south.
    Moved,
}

impl Placed {
    /// All of them with their names.
    pub const ALL: [(&str, Self); 4] = [
        ("as-drawn", Self::AsDrawn),
        ("turned", Self::Turned),
        ("mirrored", Self::Mirrored),
        ("moved", Self::Moved),
    ];

    /// A world file, placed. It must be one without headings or openings.
    ///
    /// # Panics
    /// If the text is not TOML.
    pub fn world(self, text: String) -> String {
        if self == Self::AsDrawn {
            return text;
        }
        let mut world = text.parse::<Table>().expect("a world file");
        for key in ["start_m", "target_m"] {
            world.get_mut(key).into_iter().for_each(|at| self.place(at));
        }
        let obstacles = world.get_mut("obstacle").and_then(Value::as_array_mut).into_iter().flatten();
        for obstacle in obstacles.filter_map(Value::as_table_mut) {
            obstacle.get_mut("center_m").into_iter().for_each(|at| self.place(at));
            let corners = obstacle.get_mut("vertices_m").and_then(Value::as_array_mut);
            corners.into_iter().flatten().for_each(|at| self.place(at));
            if obstacle.get("shape").and_then(Value::as_str) == Some("box") {
                let yaw = obstacle.get("yaw_deg").map_or(0.0, number);
                let yaw = match self {
                    Self::Turned => (yaw + TURN_DEG + 180.0).rem_euclid(360.0) - 180.0,
                    Self::Mirrored => -yaw,
                    Self::AsDrawn | Self::Moved => yaw,
                };
                obstacle.insert("yaw_deg".to_owned(), Value::Float(yaw));
            }
        }
        world.to_string()
    }

    fn place(self, at: &mut Value) {
        let Some([x, y]) = at.as_array().map(|at| [0, 1].map(|i| at.get(i).map_or(0.0, number))) else {
            return;
        };
        let [x, y] = match self {
            Self::AsDrawn => [x, y],
            Self::Turned => {
                let (sin, cos) = math::sin_cos(TURN_DEG.to_radians());
                [cos * x - sin * y, sin * x + cos * y]
            }
            Self::Mirrored => [x, -y],
            Self::Moved => [x + MOVED_M[0], y + MOVED_M[1]],
        };
        *at = Value::Array(vec![Value::Float(x), Value::Float(y)]);
    }
}

fn number(value: &Value) -> f64 {
    value.as_float().or_else(|| value.as_integer().map(|n| n as f64)).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper::cycles::mixed_world;
    use cocarry::options::OptionSet;
    use cocarry::world::World;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    #[test]
    fn a_placed_world_has_the_same_options() {
        let mut compared = 0;
        for seed in 0..40 {
            let text = mixed_world(&mut ChaCha8Rng::seed_from_u64(seed), true);
            let lengths = |placed: Placed| {
                let world = World::parse("w", &placed.world(text.clone())).ok()?;
                let set = OptionSet::new(&world, 10.0).ok()?;
                let begin = set.begin();
                Some((0..set.options().len()).map(|o| set.remaining(&begin, o).length).collect::<Vec<_>>())
            };
            let drawn = lengths(Placed::AsDrawn);
            for (name, placed) in Placed::ALL {
                let found = lengths(placed);
                assert_eq!(drawn.as_ref().map(Vec::len), found.as_ref().map(Vec::len), "{seed} {name}");
                for (a, b) in drawn.iter().flatten().zip(found.iter().flatten()) {
                    assert!((a - b).abs() < 1e-8, "{seed} {name}: {a} {b}");
                    compared += 1;
                }
            }
        }
        assert!(compared > 200, "{compared}");
    }
}
