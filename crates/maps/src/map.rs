//! The obstacles of an occupancy grid: everything but the free cells that a team reaches from the start.

use crate::description::Description;
use crate::grid::{Cell, Grid};
use crate::image::Image;
use crate::request::Request;
use crate::room::{MAX_CORNERS, Obstacles};
use crate::simplify::simplified;
use crate::trace::{Vertex, doubled_area, rings, without_pinches};
use cocarry::bounds;
use cocarry::error::{Error, ErrorKind, Place};
use cocarry::geometry::Point;
use cocarry::located::{self, Source};
use std::path::Path;

/// Passages that are narrower than the robot by more than this (cells) are not followed.
const NARROWER_CELLS: f64 = 2.0;

/// The obstacles of the map described in a file, for a team from A to B.
pub(crate) fn obstacles(path: &Path, request: &Request) -> Result<String, Error> {
    let file = path.display().to_string();
    let text = located::read(&bounds::GRID, path)?;
    let description = Description::parse(Source { file: &file, text: &text })?;
    let image = Image::read(&path.parent().unwrap_or(Path::new("")).join(&description.image))?;
    let grid = Grid::new(&description, &image);
    drop(image);
    let rings = rings(&floor(&grid, &file, request)?, grid.width);
    let tolerance = request.tolerance.map_or(1.0, |tolerance| tolerance / grid.resolution);
    let simple = simplified(&rings, tolerance);
    let corners: usize = simple.iter().map(Vec::len).sum();
    if corners > MAX_CORNERS {
        let tolerance = tolerance * grid.resolution;
        let sentence = format_args!(
            "its outlines have {corners} corners within {tolerance} m, more than {MAX_CORNERS}; set a larger tolerance_m, or cut the map to the floor that the team walks on"
        );
        return Err(Error::at(Place::file(file), sentence));
    }
    Ok(written(&grid, simple, request.height))
}

/// The outlines as obstacles: the walls around the floor, then what stands on it, by place.
fn written(grid: &Grid, rings: Vec<Vec<Vertex>>, height: f64) -> String {
    let points = |ring: &[Vertex]| -> Vec<Point> {
        ring.iter().map(|[x, y]| grid.point(f64::from(*x), f64::from(*y))).collect()
    };
    let (around, mut within): (Vec<_>, Vec<_>) = rings.into_iter().partition(|ring| doubled_area(ring) > 0);
    within.sort_by_key(|ring| ring.iter().map(|[x, y]| [*y, *x]).min());
    let mut obstacles = Obstacles::default();
    for ring in &around {
        obstacles.add("walls", "room", &points(ring), &[], height);
    }
    for (i, ring) in within.iter().enumerate() {
        obstacles.add(&format!("obstacle-{}", i + 1), "polygon", &points(ring), &[], height);
    }
    obstacles.text
}

/// The free cells that belong to the floor on which the team walks: those near a place where the robot's
/// middle gets to. What lies behind a crack in a wall does not belong to it.
fn floor(grid: &Grid, map: &str, request: &Request) -> Result<Vec<bool>, Error> {
    let is_free = |i: usize| match grid.cells[i] {
        Cell::Free => true,
        Cell::Unknown => request.is_unknown_free,
        Cell::Occupied => false,
    };
    let [start, target] = [("start_m", request.start), ("target_m", request.target)].map(|(item, at)| {
        let cell = grid.cell_at(at).map(|cell| grid.index(cell));
        cell.filter(|i| is_free(*i)).ok_or_else(|| {
            let cell = cell.map_or("no cell", |i| match grid.cells[i] {
                Cell::Occupied => "an occupied cell",
                _ => "an unknown cell",
            });
            let sentence =
                format_args!("({}, {}) is on {cell} of {map}; choose a point on free floor", at.x, at.y);
            Error::value(Place::item(&request.file, item), sentence).of_kind(ErrorKind::World)
        })
    });
    let (start, target) = (start?, target?);
    let radius = request.robot_width / 2.0 / grid.resolution;
    let room = (radius - NARROWER_CELLS / 2.0).max(0.0);
    let blocked = grid.within(|i| !is_free(i), room);
    // a start too close to an obstacle is refused with the world that is made here
    let is_open = |i: usize| is_free(i) && (!blocked[i] || blocked[start]);
    let reached = grid.connected([start], is_open);
    drop(blocked);
    // a square corner is this far from where the robot's middle gets to
    let corner = radius * std::f64::consts::SQRT_2 + NARROWER_CELLS;
    let near = grid.within(|i| reached[i], corner);
    let from = (0..reached.len()).filter(|i| reached[*i]);
    let mut is_floor = grid.connected(from, |i| near[i] && is_free(i));
    without_pinches(&mut is_floor, grid.width);
    // what hung together by a corner is not connected now
    let is_floor = grid.connected([start], |i| is_floor[i]);
    if !is_floor[target] {
        let (Point { coords: a }, Point { coords: b }) = (request.start, request.target);
        let width = 2.0 * room * grid.resolution;
        let sentence = format_args!(
            "no way of free cells leads from ({}, {}) to ({}, {}), not even one {width:.2} m wide; if the floor between them is unknown, `unknown = \"free\"` opens it",
            a.x, a.y, b.x, b.y
        );
        return Err(Error::at(Place::file(map), sentence).of_kind(ErrorKind::World));
    }
    Ok(is_floor)
}
