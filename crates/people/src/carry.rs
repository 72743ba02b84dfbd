//! The episodes in which participants carry: their scenarios, and the logs that the page makes of them.

use crate::study::{PeopleStudy, StudyWorld};
use cocarry::Error;
use cocarry::episode::EpisodeSettings;
use cocarry::geometry::Footprint;
use cocarry::policy::Method;
use cocarry::preference::Belief;
use cocarry::robot::Robot;
use cocarry::scenario::{GivenPerception, Plant, PlantKind, RobotSetup, Scenario};
use serde_json::{Value, json};
use std::f64::consts::TAU;

/// The control period, s: a person's hand is taken up as often.
const CONTROL_PERIOD_S: f64 = 0.05;
/// Corners of a base that is a disc.
const CORNERS: u32 = 24;

/// The scenario in which a participant carries in a world, with the built-in robot and its bodies.
///
/// # Errors
/// The scenario cannot be written as text.
pub fn carry_scenario(world: &StudyWorld, method: Method) -> Result<Scenario, Error> {
    let settings =
        EpisodeSettings { method, control_period: Some(CONTROL_PERIOD_S), ..EpisodeSettings::default() };
    let plant = Plant::new(PlantKind::Rapier, RobotSetup::new(&Robot::built_in()?));
    let given = GivenPerception::default();
    Ok(Scenario::of_seed(0, world.world.clone().into(), plant, settings, &Belief::default(), given))
}

/// The file of a scenario of the page.
pub(crate) fn scenario_file(world: usize, method: Method) -> String {
    format!("carries/{}-{}.toml", world + 1, method.name())
}

/// The texts of all scenarios, with their files.
pub(crate) fn scenarios(study: &PeopleStudy) -> Result<Vec<(String, String)>, Error> {
    let all = study
        .worlds
        .iter()
        .enumerate()
        .flat_map(|(at, world)| study.methods.iter().map(move |m| (at, world, *m)));
    all.map(|(at, world, method)| Ok((scenario_file(at, method), carry_scenario(world, method)?.text()?)))
        .collect()
}

/// What the page draws the team with: the outline of the robot's base about its place, x ahead (m), and the
/// colours.
pub(crate) fn drawing() -> Result<Value, Error> {
    let corners: Vec<[f64; 2]> = match Robot::built_in()?.footprint {
        Footprint::Polygon(corners) => corners.iter().map(|corner| [corner.x, corner.y]).collect(),
        Footprint::Disc { center, radius } => {
            let corner = |i: u32| {
                let (sin, cos) = cocarry::math::sin_cos(TAU * f64::from(i) / f64::from(CORNERS));
                [center.x + radius * cos, center.y + radius * sin]
            };
            (0..CORNERS).map(corner).collect()
        }
    };
    Ok(json!({ "base_m": corners, "colours": cocarry_output::player::colours() }))
}
