//! Worlds from maps: occupancy grids as ROS's map_server has them (YAML with a PGM or PNG image), and floor
//! plans (GeoJSON, SVG).
//!
//! A world file names its map:
//!
//! ```toml
//! name = "Office"
//! robot_width_m = 0.5
//! start_m = [-2.0, -0.5]
//! target_m = [2.0, 0.5]
//!
//! [map]
//! file = "office.yaml"    # relative to this file
//! tolerance_m = 0.05      # how far outlines may be from the cells' sides; a cell if not given
//! height_m = 2.0          # of all obstacles
//! unknown = "occupied"    # or "free"
//! ```
//!
//! [`find`] reads it. The text of the world that it returns has the map's outlines as obstacles in place of the
//! `[map]`, so that a recording is complete without the map.

mod description;
mod grid;
mod image;
mod map;
mod plan;
mod request;
mod room;
mod simplify;
mod svg;
mod svg_bounds;
mod trace;

use cocarry::bounds;
use cocarry::error::{Error, Place};
use cocarry::geometry::Point;
use cocarry::located::{self, Source};
use cocarry::world::World;
use request::{HEIGHT_M, MapEntry, Request, Unknown};
use room::metres;
use serde::Deserialize;
use std::path::Path;

/// The robot width of a world made from a map alone, m.
const ROBOT_WIDTH_M: f64 = 0.5;

/// The world in the file `path`, or, if there is no such file, the built-in world `name`. A world file may
/// name a map.
///
/// # Errors
/// As [`World::find`], and where the map is at fault.
pub fn find(path: &Path, name: &str) -> Result<World, Error> {
    if !path.is_file() {
        return World::find(path, name);
    }
    if is_map(path) {
        let file = path.display();
        let sentence = format_args!(
            "a map has no start and no target; give --start and --target, or write a world file with them and `map = {{ file = \"{file}\" }}`"
        );
        return Err(Error::at(Place::file(file.to_string()), sentence));
    }
    let text = located::read(&bounds::WORLD, path)?;
    parse(&path.display().to_string(), &text, path.parent().unwrap_or(Path::new("")))
}

/// The world of this text, which errors call `file`. A map that it names is relative to `folder`.
///
/// # Errors
/// As [`World::parse`], and where the map is at fault.
pub fn parse(file: &str, text: &str, folder: &Path) -> Result<World, Error> {
    World::parse(file, &with_obstacles(Source { file, text }, folder)?)
}

/// Whether a file is a map by its extension: the YAML of map_server, GeoJSON or SVG.
pub fn is_map(path: &Path) -> bool {
    matches!(extension(path).as_str(), "yaml" | "yml" | "geojson" | "json" | "svg")
}

/// The extension of a file, in lower case.
fn extension(path: &Path) -> String {
    path.extension().map_or(String::new(), |extension| extension.to_string_lossy().to_lowercase())
}

/// The parts of a world that a map does not have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ends {
    /// The start A, m.
    pub start: Point,
    /// The target B, m.
    pub target: Point,
    /// The robot's width d_r, m; 0.5 if not given.
    pub robot_width: Option<f64>,
    /// How far outlines may be from the cells' sides, m; a cell if not given.
    pub tolerance: Option<f64>,
}

/// The world of a map between two points.
///
/// # Errors
/// As [`find`].
pub fn from_map(path: &Path, ends: &Ends) -> Result<World, Error> {
    let text =
        |path: Option<&std::ffi::OsStr>| path.map_or(String::new(), |s| s.to_string_lossy().into_owned());
    let quoted = |text: String| toml::Value::String(text).to_string();
    let point = |p: Point| format!("[{}, {}]", metres(p.x), metres(p.y));
    let tolerance = ends.tolerance.map(|tolerance| format!("tolerance_m = {}\n", metres(tolerance)));
    let world = format!(
        "name = {}\nrobot_width_m = {}\nstart_m = {}\ntarget_m = {}\n\n[map]\nfile = {}\n{}",
        quoted(text(path.file_stem())),
        metres(ends.robot_width.unwrap_or(ROBOT_WIDTH_M)),
        point(ends.start),
        point(ends.target),
        quoted(text(path.file_name())),
        tolerance.unwrap_or_default(),
    );
    let file = path.display().to_string();
    let folder = path.parent().unwrap_or(Path::new(""));
    World::parse(&file, &with_obstacles(Source { file: &file, text: &world }, folder)?)
}

/// The keys of a world file that a map is read with.
#[derive(Deserialize)]
struct Head {
    robot_width_m: f64,
    start_m: [f64; 2],
    target_m: [f64; 2],
    map: MapEntry,
}

/// The text of a world file with the obstacles of its map; unchanged where it names none. The lines about the
/// map become comments, so that all others keep their numbers.
fn with_obstacles(source: Source, folder: &Path) -> Result<String, Error> {
    let table = source.table("world file")?;
    let Some((key, value)) = table.get_ref().get_key_value("map") else {
        return Ok(source.text.to_owned());
    };
    let head: Head = source.parse("world file")?;
    let [start, target] = [head.start_m, head.target_m].map(Point::from);
    let request = Request {
        file: source.file.to_owned(),
        start,
        target,
        robot_width: head.robot_width_m,
        tolerance: head.map.tolerance_m,
        height: head.map.height_m.unwrap_or(HEIGHT_M),
        is_unknown_free: head.map.unknown == Unknown::Free,
        unit: head.map.unit,
    };
    let path = folder.join(&head.map.file);
    let obstacles = match extension(&path).as_str() {
        "geojson" | "json" => plan::obstacles(&path, &request),
        "svg" => svg::obstacles(&path, &request),
        _ => map::obstacles(&path, &request),
    }?;
    let mut lines = vec![key.span(), value.span()];
    if let Some(entries) = value.get_ref().as_table() {
        lines.extend(entries.iter().flat_map(|(key, value)| [key.span(), value.span()]));
    }
    let first = lines.iter().map(|span| source.line(span.start)).min().unwrap_or(1);
    let last = lines.iter().map(|span| source.line(span.end.saturating_sub(1))).max().unwrap_or(first);
    let mut text = String::with_capacity(source.text.len() + obstacles.len());
    for (i, line) in source.text.lines().enumerate() {
        if (first..=last).contains(&(i + 1)) && !line.trim().is_empty() {
            text += "# ";
        }
        text += line;
        text.push('\n');
    }
    Ok(text + &obstacles)
}
