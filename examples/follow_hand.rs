//! A human who steers: for a minute, the hand goes at 0.5 m/s on a circle of 1.4 m radius to the right of the
//! start of each environment, then up and down the hall there, and wiggles by 50 degrees to either side. The
//! robot follows it.
//!
//! ```text
//! cargo run --release --example follow_hand
//! ```

use cocarry::control::{self, RobotObstacles};
use cocarry::episode::{Episode, EpisodeSettings, Manipulator, Summary};
use cocarry::geometry::{Point, angle_of, direction, wrap_angle};
use cocarry::human::{Human, HumanDecision, HumanView, Stance};
use cocarry::math;
use cocarry::options::OptionSet;
use cocarry::policy::Method;
use cocarry::robot::Robot;
use cocarry::simulation::PhysicsSettings;
use cocarry_studies::paper::{ENVIRONMENTS, EXAMPLE_HUMAN, Environment};

/// The way of a hand, about which it wiggles.
#[derive(Clone, Copy, Debug)]
pub enum Way {
    /// A circle to the right of the start.
    Circle,
    /// To these places (m), one after the other and round again.
    Through(&'static [[f64; 2]]),
}

/// Up and down the hall in which Environments 1, 3 and 4 have their start.
pub const HALL: Way = Way::Through(&[[1.0, 3.0], [0.5, 9.5], [-2.0, 9.5], [-2.2, 0.0]]);

/// Steers the hand, wherever the options lead.
#[derive(Clone, Debug)]
pub struct Steering {
    way: Way,
    next: usize,
    heading: Option<f64>,
    target: Option<Point>,
}

/// Speed of the hand, m/s; planning step, s; amplitude (rad) and duration (s) of a wiggle.
const SPEED: f64 = 0.5;
const STEP: f64 = 0.2;
const WIGGLE: f64 = 50.0 / 180.0 * std::f64::consts::PI;
const WIGGLE_S: f64 = 8.0;
/// The rate at which the circle turns, and the largest one on the way to a place, rad/s.
const TURN_RATES: [f64; 2] = [0.3, 0.4];

impl Steering {
    /// A human who goes this way.
    pub fn on(way: Way) -> Self {
        Self { way, next: 0, heading: None, target: None }
    }
}

impl Human for Steering {
    fn decide(&mut self, view: &HumanView<'_>) -> HumanDecision {
        let mut decision = HumanDecision { stance: Stance::TakeOver, ..HumanDecision::following(0) };
        let Some(hand) = view.hand else { return decision };
        let target = self.target.get_or_insert(hand.translation.vector.xy().into());
        let (_, _, yaw) = hand.rotation.euler_angles();
        let heading = self.heading.get_or_insert(yaw);
        match self.way {
            Way::Circle => *heading -= STEP * TURN_RATES[0],
            Way::Through(places) => {
                let [x, y] = places[self.next % places.len()];
                let to_place = Point::new(x, y) - *target;
                let most = STEP * TURN_RATES[1];
                *heading += wrap_angle(angle_of(to_place) - *heading).clamp(-most, most);
                self.next += usize::from(to_place.norm() < 1.0);
            }
        }
        let wiggle = WIGGLE * math::sin(view.time * std::f64::consts::TAU / WIGGLE_S);
        let speed = SPEED * (view.time / 2.0).min(1.0);
        *target += direction(*heading + wiggle) * (STEP * speed);
        decision.hand = Some(*target);
        decision
    }
}

/// What comes of a minute with the built-in robot in one of the environments.
pub fn followed(environment: &Environment, way: Way) -> Result<Summary, Box<dyn std::error::Error>> {
    let world = environment.world()?;
    let robot = Robot::built_in()?;
    let settings =
        EpisodeSettings { method: Method::FOLLOW_HAND, tick_limit: Some(300), ..EpisodeSettings::default() };
    let options = OptionSet::new(&world, settings.predictor.risk_weight())?;
    let manipulator = Manipulator {
        robot: &robot,
        posture: robot.postures[0].joints,
        control: control::ControlSettings::default(),
        obstacles: &RobotObstacles::new(&world),
    };
    let mut episode = Episode::builder(&options, &settings, EXAMPLE_HUMAN)
        .with_physics(manipulator, &world, &PhysicsSettings::default(), 1)
        .with_human(Steering::on(way))
        .begin()?;
    while episode.step().is_none() {}
    Ok(episode.summary().clone())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for (i, environment) in ENVIRONMENTS.iter().enumerate() {
        // that of Environment 2 is too narrow for a human who wiggles
        let ways = [("circle", Way::Circle), ("hall", HALL)];
        for (name, way) in ways.into_iter().take(if i == 1 { 1 } else { 2 }) {
            let summary = followed(environment, way)?;
            let interaction = summary.interaction.ok_or("a team without bodies")?;
            println!(
                "{} of Environment {}: {} after {:.0} s; the hand's force {:.1} N in the mean, deflections {:.1} cm at most",
                name,
                environment.number,
                summary.outcome.name(),
                STEP * summary.steps as f64,
                interaction.mean_force(),
                100.0 * interaction.deflection,
            );
        }
    }
    Ok(())
}
