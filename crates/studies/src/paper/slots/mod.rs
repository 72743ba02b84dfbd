//! Deep openings: whether a team with bodies comes through slots in thick walls, with a turn before or after.

pub(crate) mod section;

use super::{prepared, run_prepared};
use crate::parallel::{OnDone, in_parallel};
use cocarry::Error;
use cocarry::episode::{EpisodeSettings, Outcome};
use cocarry::policy::Method;
use cocarry::scenario::{Plant, Scenario};
use cocarry::simulation::BodyKind;
use cocarry::world::World;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::Serialize;

/// Widths of the slots, m.
pub const WIDTHS: [f64; 4] = [0.55, 0.6, 0.7, 0.85];
/// Depths of the slots along the way, m.
pub const DEPTHS: [f64; 4] = [0.4, 1.0, 1.66, 2.4];
/// Lateral offsets of A and B from the slot's axis, m: with them the team turns before or after it.
pub const OFFSETS_M: [[f64; 2]; 5] = [[0.0, 0.0], [0.0, -1.8], [0.0, -2.6], [1.3, -2.6], [1.3, 1.8]];
/// Default number of walks for each slot and turn, each with its own gait.
pub const WALKS: usize = 2;
/// d_r, m.
const ROBOT_WIDTH: f64 = 0.5;
/// The distances of A from the slot's middle and of B from its end along the axis, m.
const BEFORE_M: f64 = 3.4;
const BEYOND_M: f64 = 1.65;

/// The study of slots.
#[derive(Clone, Copy, Debug)]
pub struct SlotStudy<'a> {
    /// The physical plant.
    pub plant: &'a Plant,
    /// The episode's settings; the method is replaced by robot-led.
    pub settings: &'a EpisodeSettings,
    /// Lateral offsets of A and B from the slot's axis, m.
    pub turns: &'a [[f64; 2]],
    /// Walks for each slot and turn.
    pub walks: usize,
    /// Seed of the first gait of each; the others follow it.
    pub seed: u64,
}

/// All walks through slots of one width.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SlotRow {
    /// w, m.
    pub width: f64,
    /// Number of walks.
    pub walks: usize,
    /// Walks that arrived without contact.
    pub arrived: usize,
    /// Walks in which the robot, the object or the human touched a side.
    pub touched: [usize; 3],
    /// Walks in which the object was lost.
    pub lost: usize,
    /// Walks with another outcome.
    pub other: usize,
}

impl SlotStudy<'_> {
    /// Units of work, for a progress bar.
    pub fn units(&self) -> usize {
        WIDTHS.len() * DEPTHS.len() * self.turns.len() * self.walks
    }

    /// The table, one row for each of [`WIDTHS`].
    ///
    /// # Errors
    /// If the physical plant cannot be set up.
    pub fn table(&self, on_done: OnDone) -> Result<Vec<SlotRow>, Error> {
        WIDTHS.iter().map(|width| self.row(*width, on_done)).collect()
    }

    fn row(&self, width: f64, on_done: OnDone) -> Result<SlotRow, Error> {
        let per_depth = self.turns.len() * self.walks;
        let walks = DEPTHS.len() * per_depth;
        let ends = in_parallel(walks, on_done, |i| {
            let turn = self.turns[i % per_depth / self.walks];
            self.walk(&world(width, DEPTHS[i / per_depth], turn), (i % self.walks) as u64)
        });
        let mut row = SlotRow { width, walks, arrived: 0, touched: [0; 3], lost: 0, other: 0 };
        for end in ends {
            match end? {
                (Some(kind), _) => row.touched[kind as usize] += 1,
                (None, Outcome::Arrived) => row.arrived += 1,
                (None, Outcome::ObjectLost) => row.lost += 1,
                _ => row.other += 1,
            }
        }
        Ok(row)
    }

    /// The body that touched a side, if any, and the outcome.
    fn walk(&self, world: &str, walk: u64) -> Result<(Option<BodyKind>, Outcome), Error> {
        let settings = EpisodeSettings { method: Method::ROBOT_LED, ..self.settings.clone() };
        let human = settings.predictor.belief().sample(&mut ChaCha8Rng::seed_from_u64(self.seed));
        let prepared = prepared(World::parse("slot", world)?, &settings, self.plant)?;
        let seed = self.seed.wrapping_add(walk);
        let summary = run_prepared(
            &prepared.prepare(Scenario { seed, human, ..prepared.scenario().clone() })?,
            |_| (),
        )?;
        Ok((summary.collision.map(|contact| contact.between[0].kind), summary.outcome))
    }
}

/// A world file with a slot through a thick wall.
fn world(width: f64, depth: f64, [start, target]: [f64; 2]) -> String {
    let (middle, beyond) = (width / 2.0 + 4.0, depth / 2.0 + BEYOND_M);
    let side = |name: &str, y: f64| {
        format!(
            "[[obstacle]]\nname = \"{name}\"\nshape = \"box\"\ncenter_m = [0.0, {y:?}]\nsize_m = [{depth:?}, 8.0]\nheight_m = 2.2\n"
        )
    };
    format!(
        "name = \"Slot\"\nrobot_width_m = {ROBOT_WIDTH:?}\nstart_m = [{:?}, {start:?}]\ntarget_m = [{beyond:?}, {target:?}]\n{}{}\
         [[opening]]\nname = \"slot\"\nbetween = [\"right\", \"left\"]\n[[option]]\nname = \"through\"\nopenings = [\"slot\"]\n",
        -BEFORE_M,
        side("right", -middle),
        side("left", middle)
    )
}
