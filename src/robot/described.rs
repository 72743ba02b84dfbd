//! A base that the URDF lacks, as the robot file describes it: a box of a size and a mass.

use super::file::{RobotFile, number};
use super::link::{Geometry, Inertial, Link, Shape};
use super::load::fixed_link;
use crate::error::{Error, Place};
use crate::geometry::Pose;
use crate::located::Source;
use nalgebra::{Matrix3, Vector3};

/// The largest extent of a base, m, and the largest mass, kg.
const MAX_SIZE_M: f64 = 10.0;
const MAX_MASS_KG: f64 = 10_000.0;
/// Red, green, blue and opacity.
const COLOR: [f32; 4] = [0.55, 0.57, 0.6, 1.0];

/// A box on the floor.
pub(super) struct DescribedBase {
    /// Length, width and height, m.
    size: Vector3<f64>,
    /// Mass, kg.
    mass: f64,
    /// Height of the base link's origin above the floor, m.
    height: f64,
}

/// The base that the robot file describes, if it does.
pub(super) fn base(source: Source, entries: &RobotFile) -> Result<Option<DescribedBase>, Vec<Error>> {
    let (size, mass) = match (&entries.base_size_m, &entries.base_mass_kg) {
        (None, None) => return Ok(None),
        (Some(size), Some(mass)) => (size, mass),
        (size, _) => {
            let other = if size.is_some() { "base_mass_kg" } else { "base_size_m" };
            let needed = format!("{other}: a base that the URDF lacks has base_size_m and base_mass_kg");
            return Err(vec![Error::missing(Place::item(source.file, "robot"), needed)]);
        }
    };
    let mut faults = Vec::new();
    for (i, &value) in size.get_ref().iter().enumerate() {
        if !(value > 0.0 && value <= MAX_SIZE_M) {
            let expected = format!("greater than 0 and at most {MAX_SIZE_M} (metres)");
            faults.push(Error::number(
                source.place(size, "robot"),
                &format!("base_size_m[{i}]"),
                value,
                &expected,
            ));
        }
    }
    let expected = format!("greater than 0 and at most {MAX_MASS_KG} (kilograms)");
    let is_mass = |mass: f64| mass > 0.0 && mass <= MAX_MASS_KG;
    match number(source, "base_mass_kg", mass, is_mass, &expected) {
        Ok(mass) if faults.is_empty() => {
            let height = entries.base_height_m.as_ref().map_or(0.0, |height| *height.get_ref());
            Ok(Some(DescribedBase { size: Vector3::from(*size.get_ref()), mass, height }))
        }
        Ok(_) => Err(faults),
        Err(fault) => Err(faults.into_iter().chain([fault]).collect()),
    }
}

impl DescribedBase {
    /// Its link, fixed to the base's: drawn, colliding, and of its mass.
    pub fn link(&self, links: &[Link], base: usize) -> Link {
        let middle = Pose::translation(0.0, 0.0, self.size.z / 2.0 - self.height);
        let squares = self.size.component_mul(&self.size);
        let moments = Vector3::repeat(squares.sum()) - squares;
        let inertia = Matrix3::from_diagonal(&(moments * (self.mass / 12.0)));
        let shape = Geometry {
            link_from_shape: Pose::identity(),
            shape: Shape::Box { size: self.size },
            color: Some(COLOR),
        };
        Link {
            inertial: Some(Inertial { mass: self.mass, center: Pose::identity(), inertia }),
            visuals: vec![shape.clone()],
            collisions: vec![shape],
            ..fixed_link(links, base, "base", middle)
        }
    }
}
