//! The planning level: a team that is a point and walks its path exactly.

use super::{Command, HumanMotion, Plant, Seen};
use crate::geometry::Point;
use crate::saved::{RestoreError, Saved};

/// A team without extent and without a robot.
#[derive(Clone, Copy, Debug)]
pub struct PointPlant {
    position: Point,
}

impl PointPlant {
    /// A team at a position.
    pub fn at(position: Point) -> Self {
        Self { position }
    }
}

impl Plant for PointPlant {
    fn observe(&self) -> Seen<'_> {
        Seen { position: self.position, configuration: None, grasp: None, human: None, bodies: None }
    }

    fn step(&mut self, _: &Command, human: &HumanMotion, _: f64) {
        self.position = human.hand.map_or(self.position, |hand| hand.position);
    }

    fn save(&self) -> Saved {
        Saved::of(&self.position)
    }

    fn restore(&mut self, saved: &Saved) -> Result<(), RestoreError> {
        self.position = saved.read("plant")?;
        Ok(())
    }
}
