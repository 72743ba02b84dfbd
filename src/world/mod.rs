//! A validated [`World`] from a world file (TOML): obstacles, start, target, and openings, which are measured
//! or detected.
//!
//! World files describe scenes; controller gains are settings. The planar layout is extruded: every obstacle
//! stands upright on the floor z = 0. The carried object may have its own table. The default is the beam of
//! this example:
//!
//! ```toml
//! [object]
//! shape = "beam"            # a name only: beam, box or board; all are boxes
//! size_m = [1.2, 0.1, 0.1]  # length (from the robot's end to the human's), width, height
//! mass_kg = 4.0
//! ```

mod built_in;
mod file;
mod narrowest;
mod object;
mod obstacle;
mod opening;
mod values;

pub use built_in::{BUILT_IN_WORLDS, BuiltInWorld};
pub use object::{CarriedObject, ObjectShape};
pub use obstacle::{Obstacle, Part};
pub use opening::{FREE_PASSAGE, Opening};

use crate::bounds;
use crate::error::{Error, ErrorKind, Place};
use crate::geometry::{Bounds, Point, Solid, Vector, cross, squared_distance_to_segment};
use crate::located::{self, Source};
use crate::suggestion;
use file::{OptionEntry, WorldFile};
use obstacle::Check;
use opening::{Gaps, TOUCHING_M};
use std::collections::BTreeSet;
use std::path::Path;
use toml::Spanned;
use values::{Pair, Values};

/// Number of options to enumerate where a world lists none and sets no `option_limit`.
pub const DEFAULT_OPTION_LIMIT: usize = 8;
/// Largest value of `free_passage_robot_widths`.
const MAX_FREE_PASSAGE: f64 = 100.0;
/// Largest value of `option_limit`.
pub const MAX_OPTION_LIMIT: usize = 64;

/// Plausible widths of robots, m.
const USUAL_WIDTHS_M: std::ops::RangeInclusive<f64> = 0.1..=3.0;
/// The extent of a world in robot widths beyond which its unit is probably wrong.
const LARGE_WORLD: f64 = 1000.0;
/// Distance from A to B below which they are one point, m.
const SAME_PLACE_M: f64 = 0.01;

/// The least width (m) of a gap that an error states.
const MIN_NAMED_GAP_M: f64 = 1e-3;

/// The least distance (m) of a start or target from the line of a gap.
const OFF_GAP_M: f64 = 1e-6;

/// The least difference of a robot's width from that of its world that counts, m.
const WIDTH_TOLERANCE_M: f64 = 1e-6;

/// A scene: obstacles, openings, start and target, and the carried object.
#[derive(Clone, Debug)]
pub struct World {
    /// The file as the caller named it.
    pub file: String,
    /// Text of the file.
    pub text: String,
    /// Title.
    pub name: String,
    /// Note, as given in the file.
    pub note: String,
    /// Robot width d_r, m. Paths keep half of it clear of every obstacle.
    pub robot_width: f64,
    /// Whether that is the width of a robot that is wider than the file's `robot_width_m`.
    pub is_widened: bool,
    /// Start A. On the line of a gap it counts as on the target's side, and is moved there by a micrometre.
    pub start: Point,
    /// Target B, on the line of a gap on the start's side.
    pub target: Point,
    /// The direction in which a team with bodies faces at the start, rad; if not given, along its first path
    /// where there is room for that.
    pub start_heading: Option<f64>,
    /// The carried object.
    pub object: CarriedObject,
    /// The obstacles, in file order.
    pub obstacles: Vec<Obstacle>,
    /// The bodies that paths keep clear of: the obstacles, those that touch as one.
    pub(crate) solids: Vec<Solid>,
    /// The obstacles that each of these consists of.
    members: Vec<Vec<usize>>,
    /// The openings: as declared, in file order, or as detected, ordered by their obstacles.
    pub openings: Vec<Opening>,
    /// Whether the openings were detected because the file declares none.
    pub openings_detected: bool,
    /// The options that the file lists; empty if options are to be enumerated.
    pub listed_options: Vec<ListedOption>,
    /// Largest number of options to enumerate.
    pub option_limit: usize,
}

/// An option as a world file lists it.
#[derive(Clone, Debug, PartialEq)]
pub struct ListedOption {
    /// Name, unique in its world.
    pub name: String,
    /// Openings in the order of travel, as indices into the world's openings.
    pub openings: Vec<usize>,
    /// Line in the file.
    pub line: usize,
}

impl World {
    /// Reads and validates a world file.
    ///
    /// # Errors
    /// The file, the line, the item and the numbers; of [`ErrorKind::World`] where the file can be read.
    pub fn load(path: &Path) -> Result<Self, Error> {
        Self::parse(&path.display().to_string(), &located::read(&bounds::WORLD, path)?)
    }

    /// The world in the file `path`, or, if there is no such file, the built-in world `name`.
    ///
    /// # Errors
    /// As [`World::load`]; if there is neither, it suggests a name.
    pub fn find(path: &Path, name: &str) -> Result<Self, Error> {
        match BuiltInWorld::named(name) {
            _ if path.exists() => Self::load(path),
            Some(built_in) => Self::parse(built_in.name, built_in.text),
            None => {
                let hint = suggestion::hint(name, BUILT_IN_WORLDS.iter().map(|world| world.name));
                let hint = if hint.is_empty() { suggestion::hint_of_files(path) } else { hint };
                let known = built_in::names();
                Err(Error::new(format!(
                    "{name}: no such world; expected a world file, or one of the built-in worlds {known}{hint}"
                )))
            }
        }
    }

    /// Validates the text of a world file. Errors call it `file`.
    ///
    /// # Errors
    /// As [`World::load`].
    pub fn parse(file: &str, text: &str) -> Result<Self, Error> {
        Self::parse_for(file, text, 0.0)
    }

    /// As [`World::parse`], for a robot of at least this width (m): a wider robot takes the place of
    /// `robot_width_m`.
    ///
    /// # Errors
    /// As [`World::load`].
    pub fn parse_for(file: &str, text: &str, width: f64) -> Result<Self, Error> {
        Self::checked(Source { file, text }, width).map_err(|error| error.of_kind(ErrorKind::World))
    }

    fn checked(source: Source, width: f64) -> Result<Self, Error> {
        let entries: WorldFile = source.parse("world file")?;
        let top = |spanned: &Spanned<f64>, item: &str| source.place(spanned, item);
        if let Some(map) = &entries.map {
            return Err(Error::at(
                source.place(map, "map"),
                "the file of a map can be read only with the world file's folder; `cocarry world FILE --write` writes the world with the map's outlines",
            ));
        }
        let origin = entries.origin_m.as_ref().map(|entry| {
            let place = source.place(entry, "world");
            Check { place: &place, origin: Vector::zeros() }.origin(entry.get_ref().0)
        });
        let origin = origin.transpose()?.unwrap_or_default();
        let given = Check { place: &top(&entries.robot_width_m, "world"), origin }
            .size("robot_width_m", *entries.robot_width_m.get_ref())?;
        let is_widened = width > given + WIDTH_TOLERANCE_M;
        let robot_width = if is_widened { width } else { given };
        let object = entries.object.as_ref().map(|entry| CarriedObject::from_entry(source, entry));
        let object = object.transpose()?.unwrap_or_default();
        let obstacles = obstacles(source, &entries, origin)?;
        let endpoint = |field: &str, entry: &Spanned<Pair<f64>>| {
            let place = source.place(entry, "world");
            let point = Check { place: &place, origin }.point(field, entry.get_ref().0)?;
            unoccupied(point, source.place(entry, field), &obstacles, robot_width)
        };
        let [start, target] =
            [endpoint("start_m", &entries.start_m)?, endpoint("target_m", &entries.target_m)?];
        let heading = |entry: &Spanned<f64>| {
            Check { place: &top(entry, "world"), origin }.angle("start_heading_deg", *entry.get_ref())
        };
        let start_heading = entries.start_heading_deg.as_ref().map(heading).transpose()?.map(f64::to_radians);
        let openings_detected = entries.openings.is_empty();
        let alone = obstacles.iter().map(Obstacle::solid).collect();
        let (solids, members): (Vec<Solid>, Vec<Vec<usize>>) =
            Solid::joined(alone, TOUCHING_M).into_iter().unzip();
        let free_passage = free_passage(source, entries.free_passage_robot_widths.as_ref())?;
        let gaps = Gaps::between(&obstacles, &solids, &members);
        let widest = if openings_detected { free_passage.max(1.0) * robot_width } else { robot_width };
        if gaps.are_too_many(widest) {
            let sentence = format_args!(
                "too many walls and parts of outlines within {widest} m of each other; give fewer obstacles, or outlines with fewer corners"
            );
            return Err(Error::at(Place::file(source.file), sentence));
        }
        let mut openings = if openings_detected {
            numbered(gaps.detect(robot_width, free_passage * robot_width), [start, target], robot_width)
        } else {
            declared_openings(source, &entries, &obstacles, robot_width)?
        };
        openings.iter_mut().for_each(|opening| opening.free_passage = free_passage);
        let [start, target] =
            [[start, target], [target, start]].map(|[end, other]| off_gaps(end, other, &openings));
        let listed_options = listed_options(source, &entries.options, &openings)?;
        let option_limit = option_limit(source, entries.option_limit.as_ref())?;
        Ok(Self {
            file: source.file.to_owned(),
            text: source.text.to_owned(),
            name: entries.name,
            note: entries.note,
            robot_width,
            is_widened,
            start,
            target,
            start_heading,
            object,
            obstacles,
            solids,
            members,
            openings,
            openings_detected,
            listed_options,
            option_limit,
        })
    }

    /// Whether it is as it would be parsed for a robot of this width (m).
    pub(crate) fn has_room_for(&self, width: f64) -> bool {
        !self.is_widened && width <= self.robot_width + WIDTH_TOLERANCE_M
    }

    /// Probable mistakes, such as lengths in millimetres, a sentence each.
    pub fn warnings(&self) -> Vec<String> {
        let Self { file, robot_width, start, target, .. } = self;
        let mut warnings = Vec::new();
        if !USUAL_WIDTHS_M.contains(robot_width) {
            warnings.push(format!(
                "{file}: robot_width_m = {robot_width}: mobile manipulators are {} to {} m wide; all lengths are in metres",
                USUAL_WIDTHS_M.start(),
                USUAL_WIDTHS_M.end()
            ));
        }
        let size = self.bounds().size();
        let extent = size.x.max(size.y);
        if extent > LARGE_WORLD * robot_width {
            let distance = |obstacle: &&Obstacle| obstacle.distance_to_point(*start);
            let farthest = self.obstacles.iter().max_by(|a, b| distance(a).total_cmp(&distance(b)));
            let named = farthest.map_or(String::new(), |o| {
                format!(", and obstacle `{}` is {:.0} m from A", o.name, distance(&o))
            });
            warnings.push(format!(
                "{file}: the world is {extent:.0} m across, {:.0} times robot_width_m{named}; all lengths are in metres",
                extent / robot_width
            ));
        }
        if (target - start).norm() < SAME_PLACE_M {
            warnings.push(format!(
                "{file}: start_m and target_m are the same point; the team has arrived at once"
            ));
        }
        warnings
    }

    /// The smallest rectangle around the obstacles, the start and the target.
    pub fn bounds(&self) -> Bounds {
        let corners = self.obstacles.iter().map(Obstacle::bounds).flat_map(|b| [b.min, b.max]);
        Bounds::around(corners.chain([self.start, self.target]))
            .unwrap_or(Bounds { min: self.start, max: self.target })
    }

    /// Gaps that the robot cannot pass, in the order of their obstacles.
    pub fn closed_gaps(&self) -> Vec<Opening> {
        Gaps::between(&self.obstacles, &self.solids, &self.members).impassable(self.robot_width)
    }

    /// Gaps that the robot cannot pass, widest first: the likely causes of an unreachable target.
    pub fn impassable_gaps(&self) -> Vec<Opening> {
        let mut gaps = self.closed_gaps();
        gaps.sort_by(|a, b| b.width.total_cmp(&a.width));
        gaps
    }
}

fn obstacles(source: Source, entries: &WorldFile, origin: Vector) -> Result<Vec<Obstacle>, Error> {
    let mut names = BTreeSet::new();
    entries
        .obstacles
        .iter()
        .map(|spanned| {
            let entry = spanned.get_ref();
            let place = source.place(spanned, format!("obstacle `{}`", entry.name));
            if !names.insert(&entry.name) {
                return Err(Error::duplicate(place, "obstacle"));
            }
            Obstacle::from_entry(entry, &place, origin)
        })
        .collect()
}

/// A start or target at `place`, if the team has room there.
fn unoccupied(point: Point, place: Place, obstacles: &[Obstacle], robot_width: f64) -> Result<Point, Error> {
    let needed = robot_width / 2.0;
    let nearest =
        obstacles.iter().map(|o| (o, o.distance_to_point(point))).min_by(|a, b| a.1.total_cmp(&b.1));
    match nearest {
        Some((obstacle, distance)) if distance < needed => {
            let (x, y, obstacle) = (point.x, point.y, &obstacle.name);
            let inside = if distance == 0.0 { ": it lies inside the obstacle" } else { "" };
            Err(Error::value(
                place,
                format_args!(
                    "({x}, {y}) is {distance:.4} m from obstacle `{obstacle}`; the team needs {needed} m (half of robot_width_m) around it{inside}"
                ),
            ))
        }
        _ => Ok(point),
    }
}

/// A start or target that is on the line of a gap, moved off that line by [`OFF_GAP_M`] to the side of
/// `other`, the target or start: it must be on one side.
fn off_gaps(point: Point, other: Point, openings: &[Opening]) -> Point {
    openings.iter().fold(point, |point, gap| {
        let [a, b] = gap.ends;
        if squared_distance_to_segment(point, a, b) >= OFF_GAP_M * OFF_GAP_M {
            return point;
        }
        let depth = |p: Point| (p - gap.center()).dot(&gap.axis());
        let side = if depth(other) < 0.0 { -OFF_GAP_M } else { OFF_GAP_M };
        point + gap.axis() * (side - depth(point))
    })
}

fn declared_openings(
    source: Source,
    entries: &WorldFile,
    obstacles: &[Obstacle],
    robot_width: f64,
) -> Result<Vec<Opening>, Error> {
    let mut names = BTreeSet::new();
    let numbers: Vec<usize> = (0..obstacles.len()).collect();
    let gaps = Gaps::of(obstacles, &numbers);
    let find = |name: &String, place: &Place| {
        obstacles.iter().position(|o| o.name == *name).ok_or_else(|| {
            let known = obstacles.iter().map(|o| o.name.as_str());
            Error::unknown(place.clone(), "obstacle", name, known, usize::MAX)
        })
    };
    let openings: Vec<Opening> = entries
        .openings
        .iter()
        .map(|spanned| {
            let entry = spanned.get_ref();
            let place = source.place(spanned, format!("opening `{}`", entry.name));
            if !names.insert(&entry.name) {
                return Err(Error::duplicate(place, "opening"));
            }
            let Values([first, second]) = &entry.between;
            let between = [find(first, &place)?, find(second, &place)?];
            if between[0] == between[1] {
                return Err(Error::at(
                    place,
                    format_args!("between names `{first}` twice; an opening lies between two obstacles"),
                ));
            }
            let gap = gaps.narrowest(between);
            let width = gap.as_ref().map_or(0.0, |g| g.width);
            let Some(gap) = gap.filter(|g| g.is_passable(robot_width)) else {
                let gap = match width < MIN_NAMED_GAP_M {
                    true => format!("`{first}` and `{second}` touch or are less than 1 mm apart"),
                    false => format!("the gap between `{first}` and `{second}` is {width:.4} m wide"),
                };
                let sentence = format_args!("{gap}, not more than the robot's {robot_width} m: impassable");
                return Err(Error::at(place, sentence));
            };
            if let Some((third, distance)) = gaps.obstructed(&gap) {
                let third = &obstacles[third].name;
                return Err(Error::at(
                    place,
                    format_args!(
                        "`{third}` stands {distance:.4} m from the middle of the gap between `{first}` and `{second}` ({width:.4} m wide); name the narrower gap next to it"
                    ),
                ));
            }
            Ok(Opening { name: entry.name.clone(), ..gaps.named(gap) })
        })
        .collect::<Result<_, _>>()?;
    for (i, same) in opening::same_gaps(&openings).into_iter().enumerate() {
        if let Some(&other) = same.first() {
            let place = source.place(&entries.openings[i], format!("opening `{}`", openings[i].name));
            let other = &openings[other].name;
            return Err(Error::at(
                place,
                format_args!("this is the same gap as opening `{other}`; declare it once"),
            ));
        }
    }
    Ok(openings)
}

/// The openings among these gaps, named in the order in which they lie on the way from A to B, and from left
/// to right where they lie side by side.
fn numbered(mut openings: Vec<Opening>, [start, target]: [Point; 2], robot_width: f64) -> Vec<Opening> {
    let along = (target - start).try_normalize(0.0).unwrap_or(Vector::x());
    // up to rounding, so that a room that is moved or turned has the same order
    let micrometres = |length: f64| (length * 1e6).round() as i64;
    openings.sort_by_cached_key(|opening| {
        let from_start = opening.center() - start;
        (micrometres(from_start.dot(&along)), micrometres(cross(from_start, along)))
    });
    let mut openings = narrowest::narrowest(openings, robot_width);
    for (i, opening) in openings.iter_mut().enumerate() {
        opening.name = format!("xi{}", i + 1);
    }
    openings
}

fn listed_options(
    source: Source,
    entries: &[Spanned<OptionEntry>],
    openings: &[Opening],
) -> Result<Vec<ListedOption>, Error> {
    let mut names = BTreeSet::new();
    entries
        .iter()
        .enumerate()
        .map(|(i, spanned)| {
            let entry = spanned.get_ref();
            let name = entry.name.clone().unwrap_or_else(|| (i + 1).to_string());
            let place = source.place(spanned, format!("option `{name}`"));
            if !names.insert(name.clone()) {
                return Err(Error::duplicate(place, "option"));
            }
            let find = |name: &String| {
                openings.iter().position(|o| o.name == *name).ok_or_else(|| {
                    let known = openings.iter().map(|o| o.name.as_str());
                    Error::unknown(place.clone(), "opening", name, known, usize::MAX)
                })
            };
            let openings = entry.openings.iter().map(find).collect::<Result<_, _>>()?;
            Ok(ListedOption { name, openings, line: source.line(spanned.span().start) })
        })
        .collect()
}

fn option_limit(source: Source, entry: Option<&Spanned<i64>>) -> Result<usize, Error> {
    let Some(spanned) = entry else {
        return Ok(DEFAULT_OPTION_LIMIT);
    };
    let value = *spanned.get_ref();
    usize::try_from(value).ok().filter(|n| (1..=MAX_OPTION_LIMIT).contains(n)).ok_or_else(|| {
        let place = source.place(spanned, "world");
        Error::number(place, "option_limit", value as f64, "a whole number from 1 to 64")
    })
}

/// The width in robot widths above which openings are free passage.
fn free_passage(source: Source, entry: Option<&Spanned<f64>>) -> Result<f64, Error> {
    let Some(spanned) = entry else {
        return Ok(FREE_PASSAGE);
    };
    let value = *spanned.get_ref();
    if (1.0..=MAX_FREE_PASSAGE).contains(&value) {
        return Ok(value);
    }
    let (place, expected) = (source.place(spanned, "world"), "a number of robot widths from 1 to 100");
    Err(Error::number(place, "free_passage_robot_widths", value, expected))
}
