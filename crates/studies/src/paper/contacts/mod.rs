//! Contacts with the sides of an opening: how often a team with bodies touches them, by the paper's risk
//! S = d_r / w.

pub mod section;

use super::{prepared, run_prepared};
use crate::parallel::{OnDone, in_parallel};
use cocarry::Error;
use cocarry::episode::{EpisodeSettings, Outcome};
use cocarry::math;
use cocarry::policy::Method;
use cocarry::scenario::{Plant, Scenario};
use cocarry::simulation::BodyKind;
use cocarry::world::World;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::Serialize;

/// The risks S of the openings.
pub const RISKS: [f64; 9] = [0.4, 0.6, 0.7, 0.75, 0.8, 0.85, 0.9, 0.93, 0.96];
/// The angles of the walks to the opening's axis, degrees.
pub const ANGLES: [f64; 3] = [0.0, 30.0, 60.0];
/// Default number of walks through each opening from each angle.
pub const WALKS: usize = 30;
/// d_r, m.
const ROBOT_WIDTH: f64 = 0.5;
/// The distance of A and B from the opening, m.
const APPROACH_M: f64 = 4.0;

/// The study of contacts.
#[derive(Clone, Copy, Debug)]
pub struct ContactStudy<'a> {
    /// The physical plant, with the human's sway.
    pub plant: &'a Plant,
    /// The episode's settings; the method is replaced by human-led.
    pub settings: &'a EpisodeSettings,
    /// Walks through each opening from each angle, each with its own gait.
    pub walks: usize,
    /// Seed of the gaits.
    pub seed: u64,
}

/// All walks through openings of one risk.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContactRow {
    /// S = d_r / w.
    pub risk: f64,
    /// w, m.
    pub width: f64,
    /// Number of walks.
    pub walks: usize,
    /// Walks that arrived without contact.
    pub free: usize,
    /// Walks in which the robot, the object or the human touched a side first.
    pub touched: [usize; 3],
    /// Walks with another outcome.
    pub other: usize,
    /// Walks with contact by angle, in the order of [`ANGLES`].
    pub touched_by_angle: [usize; ANGLES.len()],
    /// Smallest clearance of the team from a side, m, mean over the walks without contact.
    pub clearance: f64,
}

impl ContactStudy<'_> {
    /// Units of work, for a progress bar.
    pub fn units(&self) -> usize {
        RISKS.len() * ANGLES.len() * self.walks
    }

    /// The table, one row for each of [`RISKS`].
    ///
    /// # Errors
    /// If the physical plant cannot be set up.
    pub fn table(&self, on_done: OnDone) -> Result<Vec<ContactRow>, Error> {
        RISKS.iter().map(|risk| self.row(*risk, on_done)).collect()
    }

    fn row(&self, risk: f64, on_done: OnDone) -> Result<ContactRow, Error> {
        let mut row = ContactRow {
            risk,
            width: ROBOT_WIDTH / risk,
            walks: ANGLES.len() * self.walks,
            free: 0,
            touched: [0; 3],
            other: 0,
            touched_by_angle: [0; ANGLES.len()],
            clearance: 0.0,
        };
        for (angle, touched) in ANGLES.iter().zip(&mut row.touched_by_angle) {
            for end in self.walks(risk, *angle, on_done)? {
                match end {
                    WalkEnd::Free(clearance) => {
                        row.free += 1;
                        row.clearance += clearance;
                    }
                    WalkEnd::Touched(kind) => {
                        *touched += 1;
                        row.touched[kind as usize] += 1;
                    }
                    WalkEnd::Other => row.other += 1,
                }
            }
        }
        row.clearance /= row.free as f64;
        Ok(row)
    }

    fn walks(&self, risk: f64, angle: f64, on_done: OnDone) -> Result<Vec<WalkEnd>, Error> {
        let world = World::parse("opening", &world(ROBOT_WIDTH / risk, angle.to_radians()))?;
        let settings = EpisodeSettings { method: Method::WITHOUT_MODEL, ..self.settings.clone() };
        let human = settings.predictor.belief().sample(&mut ChaCha8Rng::seed_from_u64(self.seed));
        let prepared = prepared(world, &settings, self.plant)?;
        let ends = in_parallel(self.walks, on_done, |i| {
            let seed = self.seed.wrapping_add(i as u64);
            let walk = prepared.prepare(Scenario { seed, human, ..prepared.scenario().clone() })?;
            let mut clearance = f64::INFINITY;
            let summary = run_prepared(&walk, |tick| {
                let physics = tick.robot.and_then(|robot| robot.physics);
                clearance = physics.map_or(clearance, |p| clearance.min(p.obstacle_distance));
            })?;
            Ok(match (&summary.collision, summary.outcome) {
                (Some(contact), _) => WalkEnd::Touched(contact.between[0].kind),
                (None, Outcome::Arrived) => WalkEnd::Free(clearance),
                _ => WalkEnd::Other,
            })
        });
        ends.into_iter().collect::<Result<Vec<_>, Error>>()
    }
}

/// The end of a walk: its smallest clearance, m, or the body that touched a side.
enum WalkEnd {
    Free(f64),
    Touched(BodyKind),
    Other,
}

/// A world file with a wall and one opening of this width (m) at the origin. The team walks at this angle
/// (rad) to the opening's axis.
fn world(width: f64, angle: f64) -> String {
    let (x, y) = (APPROACH_M * math::cos(angle).max(0.6), APPROACH_M * math::sin(angle));
    let middle = width / 2.0 + 5.0;
    format!(
        "name = \"One opening\"\nrobot_width_m = {ROBOT_WIDTH:?}\nstart_m = [{:?}, {:?}]\ntarget_m = [{x:?}, {:?}]\n\
         [[obstacle]]\nname = \"left\"\nshape = \"box\"\ncenter_m = [0.0, {middle:?}]\nsize_m = [0.1, 10.0]\nheight_m = 1.2\n\
         [[obstacle]]\nname = \"right\"\nshape = \"box\"\ncenter_m = [0.0, {:?}]\nsize_m = [0.1, 10.0]\nheight_m = 1.2\n\
         [[opening]]\nname = \"gap\"\nbetween = [\"left\", \"right\"]\n\
         [[option]]\nname = \"1\"\nopenings = [\"gap\"]\n",
        -x, y, y, -middle
    )
}
