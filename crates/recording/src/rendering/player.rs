//! The 3-D player: one self-contained HTML page, which is the built page of `viewer/` with the episode in it.

use super::learned::learned;
use crate::recording::{Channel, Frame, Playback, human_measures};
use base64::Engine;
use base64::prelude::BASE64_STANDARD as STANDARD;
use cocarry::Error;
use cocarry::bounds;
use cocarry::error::Place;
use cocarry::geometry::{Footprint, Point, Pose};
use cocarry::located::{self, unreadable};
use cocarry::quantities::{COORDINATION, COST, INTERACTION, Kind, Quantity};
use cocarry::robot::{Geometry, Link, Robot, Shape};
use cocarry::world::World;
use cocarry_output::drawing::{option_colour, option_dash, risk_colour};
use cocarry_output::palette::{self, hex};
use nalgebra::UnitQuaternion;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The built page. `viewer/build.mjs` makes it.
const PAGE: &str = include_str!("../../../../assets/player.html");
/// The largest total length of the mesh files of a page, bytes.
const MAX_MESHES: u64 = 256 << 20;
/// The place of the episode in the page.
const PLACE: &str = "__EPISODE__";
/// The largest distance of a drawn arc from its chords, m.
const SAGITTA: f64 = 0.01;

/// The page that plays an episode in three dimensions. `title` names the recording. `robot` is the recorded
/// robot loaded from its file, so that its meshes can be found; without it, links whose visual shapes are
/// meshes are drawn with their collision shapes. Equal recordings give equal bytes.
///
/// # Errors
/// The robot is another one, or a mesh cannot be read.
pub fn player(playback: &Playback, title: &str, robot: Option<&Robot>) -> Result<String, Error> {
    Ok(filled(&episode(playback, title, robot)?))
}

/// The page with what it shows.
pub(super) fn filled(episode: &Value) -> String {
    // inside a script element, `</script` would end it, and `<!--<script` would keep its end from ending it
    let text = episode.to_string().replace('<', "\\u003c");
    PAGE.replacen(PLACE, &text, 1)
}

/// The colours of bodies.
pub(super) fn colours() -> Value {
    json!({
        "robot": hex(palette::ROBOT),
        "object": hex(palette::OBJECT),
        "human": hex(palette::HUMAN),
        "hair": hex(palette::HAIR),
        "skin": hex(palette::SKIN),
        "trousers": hex(palette::TROUSERS),
        "shoes": hex(palette::SHOES),
    })
}

fn episode(playback: &Playback, title: &str, robot: Option<&Robot>) -> Result<Value, Error> {
    let prepared = &playback.prepared;
    let (world, scenario) = (prepared.world(), prepared.scenario());
    let mut meshes = Meshes::default();
    let recorded = prepared.robot();
    if let (Some(recorded), Some(found)) = (recorded, robot) {
        let texts = [
            (&recorded.texts.text, &found.texts.text, "robot file"),
            (&recorded.texts.urdf, &found.texts.urdf, "URDF"),
        ];
        if let Some((_, _, what)) = texts.into_iter().find(|(a, b, _)| a != b) {
            let sentence =
                format_args!("is not the robot of the recording: its {what} differs from the recorded one");
            return Err(Error::at(Place::file(&found.texts.file), sentence));
        }
        meshes.can_be_found = true;
    }
    let links = robot.filter(|_| meshes.can_be_found).or(recorded).map_or(&[][..], |robot| &robot.links);
    let shapes: Vec<Vec<Value>> =
        links.iter().map(|link| shapes(link, &mut meshes)).collect::<Result<_, _>>()?;
    let drawn: Vec<usize> = (0..links.len()).filter(|&link| !shapes[link].is_empty()).collect();
    let mut episode = json!({
        "title": title,
        "world": world_json(world),
        "facts": {
            "plant": scenario.plant.name(),
            "method": scenario.settings.method.name(),
            "seed": scenario.seed,
            "alpha": scenario.human.alpha,
            "gamma": scenario.human.gamma,
            "robot": recorded.map(|robot| &robot.name),
        },
        "colours": colours(),
        "measures": human_measures(),
        "period_s": scenario.settings.planning_step,
        "options": options(playback),
        "robot": drawn.iter().map(|&l| json!({ "name": links[l].name, "shapes": shapes[l] })).collect::<Vec<_>>(),
        "meshes": meshes.data,
        "frames": frames(&playback.frames, &drawn),
        "ahead": ahead(playback),
        "steps": steps(playback),
        "events": playback.events.iter().map(|event| json!({
            "time_s": seconds(event.time), "about": event.about, "sentence": event.sentence,
        })).collect::<Vec<_>>(),
        "outcome": playback.outcome,
    });
    if let Some(learned) = learned(playback) {
        episode["learned"] = learned;
    }
    Ok(episode)
}

fn seconds(time: u64) -> f64 {
    time as f64 / 1e9
}

/// The largest magnitude of a figure that the page shows: what is beyond is no figure of an episode.
const MAX_FIGURE: f64 = 1e9;

/// A figure of a recording; null where it is not a number that the page can show.
pub(super) fn figure(value: Option<f64>) -> Value {
    value.filter(|value| value.abs() <= MAX_FIGURE).into()
}

/// A coordinate (m) or a part of a quaternion, to a tenth of a millimetre: of a picture, not of a figure.
fn rounded(value: f64) -> f64 {
    // not to -0
    (value * 1e4).round() / 1e4 + 0.0
}

fn point(p: Point) -> Value {
    json!([rounded(p.x), rounded(p.y)])
}

/// Position (m) and quaternion (x, y, z, w).
pub(super) fn pose(pose: &Pose) -> [f64; 7] {
    let (at, q) = (pose.translation.vector, UnitQuaternion::from_rotation_matrix(&pose.rotation));
    [at.x, at.y, at.z, q.i, q.j, q.k, q.w].map(rounded)
}

fn world_json(world: &World) -> Value {
    let parts =
        world.obstacles.iter().flat_map(|obstacle| obstacle.footprints().map(move |part| (obstacle, part)));
    let obstacles = parts.map(|(obstacle, part)| {
        let mut drawn = json!({ "name": obstacle.name, "height_m": obstacle.height });
        match part {
            Footprint::Polygon(corners) => {
                drawn["corners"] = corners.iter().map(|c| point(*c)).collect();
            }
            Footprint::Disc { center, radius } => {
                (drawn["center"], drawn["radius"]) = (point(*center), rounded(*radius).into());
            }
        }
        drawn
    });
    let openings = world.openings.iter().map(|opening| {
        let risk = opening.risk(world.robot_width);
        json!({
            "name": opening.name,
            "ends": opening.ends.map(point),
            "width_m": opening.width,
            "risk": risk,
            "colour": risk_colour(risk),
        })
    });
    json!({
        "name": world.name,
        "robot_width_m": world.robot_width,
        "start": point(world.start),
        "target": point(world.target),
        "object_m": world.object.size,
        "obstacles": obstacles.collect::<Vec<_>>(),
        "openings": openings.collect::<Vec<_>>(),
    })
}

/// The options with the colours of every picture, as they are at the start, and their P_o by step.
fn options(playback: &Playback) -> Vec<Value> {
    let options = playback.prepared.options();
    let (begin, world) = (options.begin(), playback.prepared.world());
    let probability = |name: &str| -> Vec<Value> {
        let steps = playback.messages(Channel::Options).iter();
        let of_step = |(_, step): &(u64, Value)| {
            let found = step["options"].as_array()?.iter().find(|o| o["name"] == name)?;
            Some(figure(found["probability"].as_f64()))
        };
        steps.map(|step| of_step(step).unwrap_or_default()).collect()
    };
    let drawn = options.options().iter().enumerate().map(|(o, option)| {
        let path = options.path(&begin, o).expect("an option has a path from the start").polyline(SAGITTA);
        let openings = option.crossings.iter().map(|c| &world.openings[c.opening].name);
        json!({
            "name": option.name,
            "openings": openings.collect::<Vec<_>>(),
            "colour": option_colour(o),
            "dash": option_dash(o),
            "path": path.into_iter().map(point).collect::<Vec<_>>(),
            "probability": probability(&option.name),
        })
    });
    drawn.collect()
}

/// The poses of the bodies, one list of numbers for each, and their times.
fn frames(frames: &[Frame], links: &[usize]) -> Value {
    let of = |body: &dyn Fn(&Frame) -> Pose| -> Vec<f64> {
        frames.iter().flat_map(|frame| pose(&body(frame))).collect()
    };
    json!({
        "time_s": frames.iter().map(|frame| seconds(frame.time)).collect::<Vec<_>>(),
        "links": links.iter().map(|&link| of(&|frame| frame.links[link])).collect::<Vec<_>>(),
        "object": of(&|frame| frame.object),
        "hand": of(&|frame| frame.hand),
        "torso": of(&|frame| frame.torso),
    })
}

/// The path ahead at the times at which it begins to hold.
fn ahead(playback: &Playback) -> Value {
    let line =
        |points: &Vec<Point>| points.iter().flat_map(|p| [p.x, p.y]).map(centimetres).collect::<Vec<_>>();
    playback.ahead.iter().map(|(time, points)| json!([seconds(*time), line(points)])).collect()
}

fn centimetres(value: f64) -> f64 {
    (value * 1e2).round() / 1e2 + 0.0
}

/// The figures of every step as they were recorded, with unit and meaning.
fn steps(playback: &Playback) -> Value {
    const DECIDED: [&str; 7] =
        ["x_m", "y_m", "heading_deg", "stubbornness", "stubbornness_threshold", "discomfort", "step"];
    const SUMMED: [&str; 2] = ["walked_m", "accumulated_objective_cost_m"];
    const FELT: [&str; 2] = ["grip_force_n", "hand_force_n"];
    let words = |key: &str| {
        let steps = playback.messages(Channel::Coordination).iter();
        steps.map(|(_, step)| step[key].as_str().into()).collect::<Vec<Value>>()
    };
    let mut figures = serde_json::Map::new();
    let tables: [(Channel, &[Quantity], &[&str]); 3] = [
        (Channel::Coordination, COORDINATION, &DECIDED),
        (Channel::Cost, COST, &SUMMED),
        (Channel::Interaction, INTERACTION, &FELT),
    ];
    for (channel, table, keys) in tables {
        if playback.messages(channel).is_empty() {
            continue;
        }
        for quantity in table.iter().filter(|quantity| keys.contains(&quantity.key)) {
            let unit = if let Kind::Number(unit) = quantity.kind { unit } else { "" };
            let values = playback.column(channel, quantity.key);
            let values: Vec<Value> = values.into_iter().map(|value| figure(Some(value))).collect();
            figures.insert(
                quantity.key.to_owned(),
                json!({
                    "unit": unit,
                    "description": quantity.description,
                    "values": values,
                }),
            );
        }
    }
    json!({
        "decided_s": playback.times(Channel::Coordination),
        "done_s": playback.times(Channel::Cost),
        "mode": words("mode"),
        "executed": words("executed"),
        "preferred": words("preferred"),
        "figures": figures,
    })
}

/// The meshes of a robot: the bytes of each file once.
#[derive(Default)]
pub(super) struct Meshes {
    pub can_be_found: bool,
    known: BTreeMap<PathBuf, usize>,
    /// The total length of the files, bytes.
    bytes: u64,
    /// Format and base64 of each.
    pub data: Vec<Value>,
}

impl Meshes {
    /// The index of a file's data.
    fn index(&mut self, file: &Path) -> Result<usize, Error> {
        if let Some(&index) = self.known.get(file) {
            return Ok(index);
        }
        let format = file.extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
        if !["stl", "obj", "dae"].contains(&&*format) {
            let sentence = "a mesh of an unknown format; expected .stl, .obj or .dae";
            return Err(Error::at(Place::file(file.display().to_string()), sentence));
        }
        let bytes = located::read_bytes(&bounds::MESH, file);
        let bytes = bytes.map_err(|source| unreadable(file.display(), source))?;
        self.bytes += bytes.len() as u64;
        if self.bytes > MAX_MESHES {
            let sentence = format_args!("it and the meshes to draw before it exceed {MAX_MESHES} bytes");
            return Err(Error::at(Place::file(file.display().to_string()), sentence));
        }
        self.data.push(json!({ "format": format, "base64": STANDARD.encode(&bytes) }));
        self.known.insert(file.to_owned(), self.data.len() - 1);
        Ok(self.data.len() - 1)
    }
}

/// The shapes of a link to draw: the visual ones; the collision shapes where those are meshes that cannot be
/// found.
pub(super) fn shapes(link: &Link, meshes: &mut Meshes) -> Result<Vec<Value>, Error> {
    let can_be_found = meshes.can_be_found;
    let is_drawn = |g: &&Geometry| can_be_found || !matches!(g.shape, Shape::Mesh { .. });
    let shown = if link.visuals.iter().any(|g| is_drawn(&g)) { &link.visuals } else { &link.collisions };
    shown.iter().filter(is_drawn).map(|geometry| shape(geometry, meshes)).collect()
}

pub(super) fn shape(geometry: &Geometry, meshes: &mut Meshes) -> Result<Value, Error> {
    let mut drawn = match &geometry.shape {
        Shape::Box { size } => json!({ "box": [size.x, size.y, size.z] }),
        Shape::Cylinder { radius, length } => json!({ "cylinder": [radius, length] }),
        Shape::Capsule { radius, length } => json!({ "capsule": [radius, length] }),
        Shape::Sphere { radius } => json!({ "sphere": radius }),
        Shape::Mesh { file, scale, .. } => {
            json!({ "mesh": meshes.index(file)?, "scale": [scale.x, scale.y, scale.z] })
        }
    };
    drawn["pose"] = pose(&geometry.link_from_shape).to_vec().into();
    drawn["colour"] = geometry.color.map(|colour| colour.to_vec()).into();
    Ok(drawn)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_has_one_place_for_the_episode() {
        assert_eq!(PAGE.matches(PLACE).count(), 1);
    }
}
