//! What participants see of a world: its map, and the walk of a robot that leads on an option.

use crate::study::StudyWorld;
use cocarry::episode::EpisodeSettings;
use cocarry::geometry::{PlanarPose, Point, Tandem, Vector, direction};
use cocarry::simulation::TORSO_AHEAD;
use cocarry_output::drawing::{Letters, Moment, STAND_IN, Shown, Stimulus, stand_in};
use cocarry_studies::fit::Guidance;
use serde::Serialize;

/// Width of the maps, px.
const WIDTH: f64 = 560.0;
/// Frames of a planning step; the page draws between them.
const FRAMES_PER_STEP: u64 = 4;

/// A world as the page shows it.
#[derive(Clone, Debug, Serialize)]
pub struct Shots {
    /// The map, as SVG. It is a file of the page.
    #[serde(skip)]
    pub map: String,
    /// Width and height, px.
    pub size: [f64; 2],
    /// The team at rest, as elements of SVG; about `anchor` it is turned and from there it is moved.
    pub team: String,
    /// The object's centre in `team`, px.
    pub anchor: [f64; 2],
    /// Pixels of a metre.
    pub scale_px: f64,
    /// A, which is at `anchor`, m.
    pub start_m: [f64; 2],
    /// Length and breadth of the object, m.
    pub object_m: [f64; 2],
    /// The walk on each option.
    pub walks: Vec<LedWalk>,
}

/// The walk of a robot that leads on an option from A to B.
#[derive(Clone, Debug, Serialize)]
pub struct LedWalk {
    /// Number of planning steps, in which `cocarry fit eta` counts.
    pub steps: u64,
    /// Length of a planning step, ms.
    pub step_ms: f64,
    /// Interval between two frames, ms.
    pub frame_ms: f64,
    /// The object's centre (px) and its heading (degrees, clockwise from the right).
    pub frames: Vec<[f64; 3]>,
}

impl Shots {
    /// What is shown of a world. The team is a point that walks along the option's path, which is the walk
    /// that `cocarry fit eta` takes: a step that was recorded is a step of its g(k). It is drawn as bodies
    /// around the object.
    pub fn of(world: &StudyWorld, shows_openings: bool) -> Self {
        let shown = Shown { openings: shows_openings, options: true };
        let stimulus = Stimulus::new(&world.world, &world.set, shown, WIDTH, Letters::Text);
        let length = world.world.object.size[0];
        let rest = PlanarPose { position: world.world.start, yaw: 0.0 };
        let anchor = stimulus.pixel(rest.position);
        let team = stimulus.team(&STAND_IN, &at_rest(rest, length));
        let walks =
            (0..world.options.len()).filter_map(|option| LedWalk::of(world, &stimulus, option)).collect();
        let size = stimulus.size();
        let scale = (stimulus.pixel(rest.position + Vector::new(1.0, 0.0)) - anchor).x;
        Self {
            map: stimulus.map(),
            size: pair(Point::from(size)),
            team,
            anchor: pair(anchor),
            scale_px: scale,
            start_m: [rest.position.x, rest.position.y],
            object_m: [length, world.world.object.size[1]],
            walks,
        }
    }
}

/// The team around an object, without figures.
fn at_rest(object: PlanarPose, length: f64) -> Moment {
    let (base, grasp) = stand_in(&object, length);
    let position = object.position + direction(object.yaw) * (length / 2.0 + TORSO_AHEAD);
    Moment {
        time: 0.0,
        base,
        grasp,
        object,
        human: PlanarPose { position, yaw: object.yaw },
        stubbornness: 0.0,
        human_leads: false,
        probabilities: Vec::new(),
        sentence: String::new(),
    }
}

impl LedWalk {
    /// `None` where the option has no path.
    fn of(world: &StudyWorld, stimulus: &Stimulus, option: usize) -> Option<Self> {
        let settings = EpisodeSettings::default();
        let steps = Guidance::along_option(&world.set, &settings, option)?.steps();
        let path = world.set.path(&world.set.begin(), option)?;
        let heading = path.heading_at(0.0)?;
        let tandem = Tandem::new(world.world.object.size[0], world.world.start, heading);
        let interval = settings.planning_step / FRAMES_PER_STEP as f64;
        let frame = |at: u64| {
            let walked = (settings.speed * interval * at as f64).min(path.length());
            let pose = tandem.pose(&path, walked);
            let [x, y] = pair(stimulus.pixel(pose.position));
            [x, y, rounded(-pose.yaw.to_degrees())]
        };
        Some(Self {
            steps,
            step_ms: 1000.0 * settings.planning_step,
            frame_ms: 1000.0 * interval,
            frames: (0..=steps * FRAMES_PER_STEP).map(frame).collect(),
        })
    }
}

fn pair(point: Point) -> [f64; 2] {
    [rounded(point.x), rounded(point.y)]
}

/// A number with two decimals.
fn rounded(number: f64) -> f64 {
    (100.0 * number).round() / 100.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::{PeopleStudy, TEMPLATE};

    #[test]
    fn a_walk_begins_at_a_and_ends_at_b_at_the_robots_speed() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("study.toml");
        std::fs::write(&file, TEMPLATE).unwrap();
        let study = PeopleStudy::read(&file).unwrap();
        for world in &study.worlds {
            let shots = Shots::of(world, false);
            assert!(!shots.map.contains("risk") && shots.map.starts_with("<svg"), "{}", shots.map);
            assert_eq!(shots.walks.len(), world.options.len());
            for (walk, prospect) in shots.walks.iter().zip(&world.prospects) {
                let duration = walk.steps as f64 * walk.step_ms / 1000.0;
                assert!((0.5 * duration - prospect.length).abs() <= 0.1 + 1e-9, "{duration}");
                let [x, y] = shots.anchor;
                // corners are rounded, within the object's length
                let off = cocarry::math::hypot(walk.frames[0][0] - x, walk.frames[0][1] - y);
                assert!(off < 0.3 * shots.scale_px, "{off} px");
                assert_eq!(walk.frames.len() as u64, 4 * walk.steps + 1);
            }
        }
    }
}
