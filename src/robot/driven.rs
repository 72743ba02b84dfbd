//! The drive that a robot file names: its kind, its wheels and its limits.

use super::drive::DriveKind;
use super::file::{RobotFile, number};
use super::link::Link;
use super::urdf::Urdf;
use super::wheels::{Named, Omnidirectional};
use super::{MAX_LISTED, wheel_search};
use crate::error::{Error, Place};
use crate::located::Source;
use crate::suggestion::listed;
use toml::Spanned;

/// Track of a skid-steer drive as a multiple of the distance between its wheels, where the robot file gives
/// none. The published controllers of Jackal and Husky have 1.5 and 1.875.
pub(super) const SKID_MULTIPLIER: f64 = 1.5;

/// The wheels that the robot file names, or all faults.
pub(super) fn named(
    source: Source,
    urdf: Urdf,
    links: &[Link],
    entries: &RobotFile,
) -> Result<Named, Vec<Error>> {
    let kind = entries.drive.as_ref().map_or(DriveKind::Differential, |drive| *drive.get_ref());
    let mut reader = DriveReader { source, links, kind, faults: Vec::new() };
    reader.refuse_others(entries);
    let named = reader.read(entries);
    if reader.faults.is_empty()
        && let Some(named) = &named
    {
        reader.faults.extend(other_drive(source, urdf, links, entries, kind, &named.links()));
    }
    match named {
        Some(named) if reader.faults.is_empty() => Ok(named),
        _ => Err(reader.faults),
    }
}

/// The fault of a base that moves in another way than it is said to.
fn other_drive(
    source: Source,
    urdf: Urdf,
    links: &[Link],
    entries: &RobotFile,
    kind: DriveKind,
    named: &[usize],
) -> Option<Error> {
    if kind == DriveKind::Omnidirectional {
        return None;
    }
    let joint = |&i: &usize| links[i].joint.as_ref().map_or("", |joint| joint.name.as_str());
    let others = wheel_search::others(links, named);
    let place = match &entries.drive {
        Some(drive) => source.place(drive, "drive"),
        None => urdf.place(format!("joint `{}`", named.first().map_or("", joint))),
    };
    let all: Vec<usize> = named.iter().chain(&others).copied().collect();
    let mecanum: Vec<&str> = all.iter().filter(|&&i| wheel_search::is_mecanum(links, i)).map(joint).collect();
    if !mecanum.is_empty() {
        return Some(Error::at(
            place,
            format_args!(
                "this base has mecanum or omnidirectional wheels: {}; it is not a {} one; write drive = \"omnidirectional\"",
                listed(mecanum, MAX_LISTED),
                kind.name()
            ),
        ));
    }
    if entries.drive.is_none() && !others.is_empty() {
        return Some(Error::at(
            place,
            format_args!(
                "this base has other wheels that may be driven: {}; say which drive it has: drive = \"skid-steer\", \"omnidirectional\" (mecanum), or \"differential\" if they roll freely",
                listed(others.iter().map(joint), MAX_LISTED)
            ),
        ));
    }
    None
}

struct DriveReader<'a> {
    source: Source<'a>,
    links: &'a [Link],
    kind: DriveKind,
    faults: Vec<Error>,
}

impl DriveReader<'_> {
    fn keep<T>(&mut self, result: Result<T, Error>) -> Option<T> {
        result.map_err(|fault| self.faults.push(fault)).ok()
    }

    /// Refuses the keys of other drives.
    fn refuse_others(&mut self, entries: &RobotFile) {
        use DriveKind::{Differential, Omnidirectional, SkidSteer};
        let (two, skid, free) = (&[Differential][..], &[SkidSteer][..], &[Omnidirectional][..]);
        let rolling = &[Differential, SkidSteer][..];
        let span = |wheels: &Option<Vec<Spanned<String>>>| {
            wheels.as_ref().map(|w| w.first().map_or(0..0, Spanned::span))
        };
        let of = |number: &Option<Spanned<f64>>| number.as_ref().map(Spanned::span);
        let given = [
            ("left_wheel", two, entries.left_wheel.as_ref().map(Spanned::span)),
            ("right_wheel", two, entries.right_wheel.as_ref().map(Spanned::span)),
            ("left_wheels", skid, span(&entries.left_wheels)),
            ("right_wheels", skid, span(&entries.right_wheels)),
            ("wheel_separation_multiplier", skid, of(&entries.wheel_separation_multiplier)),
            ("wheel_separation_m", rolling, of(&entries.wheel_separation_m)),
            ("wheel_rate_limit_rad_s", rolling, of(&entries.wheel_rate_limit_rad_s)),
            ("mecanum_wheels", free, span(&entries.mecanum_wheels)),
            ("omni_wheels", free, span(&entries.omni_wheels)),
            ("base_speed_limit_m_s", free, of(&entries.base_speed_limit_m_s)),
            ("base_turn_limit_rad_s", free, of(&entries.base_turn_limit_rad_s)),
            ("base_height_m", free, of(&entries.base_height_m)),
            ("base_size_m", free, entries.base_size_m.as_ref().map(Spanned::span)),
            ("base_mass_kg", free, of(&entries.base_mass_kg)),
        ];
        let instead = match self.kind {
            Differential => "it has left_wheel and right_wheel",
            SkidSteer => "it has left_wheels, right_wheels and wheel_separation_multiplier",
            Omnidirectional => {
                "it has base_speed_limit_m_s, base_turn_limit_rad_s, base_height_m and mecanum_wheels or omni_wheels"
            }
        };
        for (key, drives, span) in given {
            if let Some(span) = span.filter(|_| !drives.contains(&self.kind)) {
                let place = self.source.place_at(span, "robot");
                let drive = self.kind.name();
                let sentence = format_args!("{key} does not apply to drive = \"{drive}\"; {instead}");
                self.faults.push(Error::at(place, sentence));
            }
        }
    }

    fn read(&mut self, entries: &RobotFile) -> Option<Named> {
        match self.kind {
            DriveKind::Differential => {
                let left = self.one("left_wheel", &entries.left_wheel);
                let right = self.one("right_wheel", &entries.right_wheel);
                Some(Named::Sides { wheels: [vec![left?], vec![right?]], multiplier: None })
            }
            DriveKind::SkidSteer => {
                let left = self.several("left_wheels", &entries.left_wheels);
                let right = self.several("right_wheels", &entries.right_wheels);
                let given = self.given(
                    "wheel_separation_multiplier",
                    &entries.wheel_separation_multiplier,
                    [1.0, 5.0],
                    "from 1 to 5 (1: the wheels do not skid)",
                );
                let (left, right) = (left?, right?);
                if left.len() != right.len() {
                    let needed = format!(
                        "a wheel: both sides need the same number of wheels (left {}, right {})",
                        left.len(),
                        right.len()
                    );
                    self.missing(needed);
                    return None;
                }
                Some(Named::Sides { wheels: [left, right], multiplier: given.or(Some(SKID_MULTIPLIER)) })
            }
            DriveKind::Omnidirectional => {
                let speed = "greater than 0 and at most 20 (m/s)";
                let speed = self.needed("base_speed_limit_m_s", &entries.base_speed_limit_m_s, 20.0, speed);
                let turn = "greater than 0 and at most 100 (rad/s)";
                let turn = self.needed("base_turn_limit_rad_s", &entries.base_turn_limit_rad_s, 100.0, turn);
                let height = "from -2 to 2 (metres)";
                let height = self.given("base_height_m", &entries.base_height_m, [-2.0, 2.0], height);
                let (wheels, is_mecanum) = match (&entries.mecanum_wheels, &entries.omni_wheels) {
                    (Some(_), Some(_)) => {
                        self.missing(
                            "one kind of wheels: mecanum_wheels or omni_wheels, not both".to_owned(),
                        );
                        return None;
                    }
                    (Some(_), None) => (self.several("mecanum_wheels", &entries.mecanum_wheels)?, true),
                    (None, Some(_)) => (self.several("omni_wheels", &entries.omni_wheels)?, false),
                    (None, None) => (Vec::new(), false),
                };
                let limits = [speed?, turn?];
                Some(Named::Omnidirectional(Omnidirectional { wheels, is_mecanum, height, limits }))
            }
        }
    }

    fn missing(&mut self, needed: String) {
        self.faults.push(Error::missing(Place::item(self.source.file, "robot"), needed));
    }

    fn one(&mut self, key: &str, name: &Option<Spanned<String>>) -> Option<usize> {
        let Some(name) = name else {
            self.missing(format!("{key}: a {} drive needs it", self.kind.name()));
            return None;
        };
        let found = carried_by(self.source, self.links, key, name);
        self.keep(found)
    }

    fn several(&mut self, key: &str, names: &Option<Vec<Spanned<String>>>) -> Option<Vec<usize>> {
        let Some(names) = names.as_ref().filter(|names| !names.is_empty()) else {
            self.missing(format!("{key}: a list of joints; a {} drive needs it", self.kind.name()));
            return None;
        };
        let mut found: Vec<usize> = Vec::with_capacity(names.len());
        let mut are_known = true;
        for name in names {
            let one = carried_by(self.source, self.links, key, name);
            let Some(one) = self.keep(one) else {
                are_known = false;
                continue;
            };
            if found.contains(&one) {
                let place = self.source.place(name, format!("`{}` in {key}", name.get_ref()));
                self.faults.push(Error::duplicate(place, "wheel"));
            }
            found.push(one);
        }
        are_known.then_some(found)
    }

    /// A number, if it is given.
    fn given(
        &mut self,
        key: &str,
        given: &Option<Spanned<f64>>,
        [least, most]: [f64; 2],
        expected: &str,
    ) -> Option<f64> {
        let read = number(self.source, key, given.as_ref()?, |n| (least..=most).contains(&n), expected);
        self.keep(read)
    }

    /// A number greater than 0 that must be given.
    fn needed(&mut self, key: &str, given: &Option<Spanned<f64>>, most: f64, expected: &str) -> Option<f64> {
        let Some(given) = given else {
            self.missing(format!("{key}: an {} drive needs it", self.kind.name()));
            return None;
        };
        let read = number(self.source, key, given, |n| n > 0.0 && n <= most, expected);
        self.keep(read)
    }
}

/// The child link of the joint of this name.
fn carried_by<'l>(
    source: Source,
    links: &'l [Link],
    key: &str,
    name: &Spanned<String>,
) -> Result<usize, Error> {
    let joint = |l: &'l Link| l.joint.as_ref().map(|joint| joint.name.as_str());
    links.iter().position(|l| joint(l) == Some(name.get_ref())).ok_or_else(|| {
        let known = links.iter().filter_map(joint);
        Error::unknown(source.place(name, key), "joint", name.get_ref(), known, MAX_LISTED)
    })
}
