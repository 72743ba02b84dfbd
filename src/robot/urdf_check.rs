//! The check of the numbers of one item of a URDF.

use super::arm_limits::bad_limits;
use super::link::{Geometry, Inertial, JointKind, Limits, Shape};
use super::solid;
use super::urdf::Urdf;
use super::warning::RobotWarning;
use crate::error::Error;
use crate::geometry::Pose;
use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
use std::path::PathBuf;

/// The largest magnitude of a number in a URDF. Larger numbers are errors, and their squares would lose
/// digits; larger limits are none.
const MAX_NUMBER: f64 = 1e6;

/// Checks for the numbers of one item.
pub(super) struct Check<'a> {
    pub urdf: Urdf<'a>,
    pub item: String,
}

impl Check<'_> {
    fn number(&self, field: &str, value: f64, is_good: bool, expected: &str) -> Result<f64, Error> {
        match is_good {
            true => Ok(value),
            false => Err(Error::number(self.urdf.place(self.item.clone()), field, value, expected)),
        }
    }

    pub fn finite(&self, field: &str, value: f64) -> Result<f64, Error> {
        self.number(field, value, value.abs() <= MAX_NUMBER, "a number from -1000000 to 1000000")
    }

    fn positive(&self, field: &str, value: f64) -> Result<f64, Error> {
        self.number(field, value, value > 0.0 && value <= MAX_NUMBER, "greater than 0, at most 1000000")
    }

    fn vector(&self, field: &str, values: &[f64; 3]) -> Result<Vector3<f64>, Error> {
        for (name, value) in ["[0]", "[1]", "[2]"].iter().zip(values) {
            self.finite(&format!("{field}{name}"), *value)?;
        }
        Ok(Vector3::from(*values))
    }

    pub fn axis(&self, values: &[f64; 3]) -> Result<Unit<Vector3<f64>>, Error> {
        let axis = self.vector("axis xyz", values)?;
        let (norm, expected) = (axis.norm(), "greater than 0, to give the direction of motion");
        let bad = || Error::number(self.urdf.place(self.item.clone()), "length of axis xyz", norm, expected);
        Unit::try_new(axis, 1e-9).ok_or_else(bad)
    }

    pub fn pose(&self, origin: &urdf_rs::Pose) -> Result<Pose, Error> {
        let xyz = self.vector("origin xyz", &origin.xyz.0)?;
        let rpy = self.vector("origin rpy", &origin.rpy.0)?;
        Ok(Pose::from_parts(xyz.into(), Rotation3::from_euler_angles(rpy.x, rpy.y, rpy.z)))
    }

    /// The limits of a joint. A position or effort beyond [`MAX_NUMBER`] is not limited, and neither is a rate
    /// of 0 or so large.
    pub fn limits(&self, kind: JointKind, limit: &urdf_rs::JointLimit) -> Result<Limits, Error> {
        let [lower, upper] = match kind {
            JointKind::Revolute | JointKind::Prismatic => self.range(limit)?,
            JointKind::Continuous => [f64::NEG_INFINITY, f64::INFINITY],
            _ => [0.0, 0.0],
        };
        let at_least_0 = |field, value: f64| self.number(field, value, value >= 0.0, "at least 0");
        let unlimited = |value: f64| if value > MAX_NUMBER { f64::INFINITY } else { value };
        let rate = unlimited(at_least_0("limit velocity", limit.velocity)?);
        let effort = unlimited(at_least_0("limit effort", limit.effort)?);
        Ok(Limits { lower, upper, rate, effort: if effort > 0.0 { effort } else { f64::INFINITY } })
    }

    /// The lower and the upper limit; infinite if both are beyond [`MAX_NUMBER`].
    fn range(&self, limit: &urdf_rs::JointLimit) -> Result<[f64; 2], Error> {
        let (lower, upper) = (limit.lower, limit.upper);
        for (field, value) in [("limit lower", lower), ("limit upper", upper)] {
            self.number(field, value, !value.is_nan(), "a number")?;
        }
        if lower > upper {
            return Err(bad_limits(self.urdf.place(self.item.clone()), lower, upper));
        }
        let is_free = lower <= -MAX_NUMBER && upper >= MAX_NUMBER;
        Ok(match is_free {
            true => [f64::NEG_INFINITY, f64::INFINITY],
            false => [lower, upper].map(|limit| limit.clamp(-MAX_NUMBER, MAX_NUMBER)),
        })
    }

    /// The inertial, if there is one, and a warning about an inertia that no robot's link has.
    pub fn inertial(
        &self,
        inertial: &urdf_rs::Inertial,
    ) -> Result<(Option<Inertial>, Option<RobotWarning>), Error> {
        let mass = inertial.mass.value;
        self.number("mass", mass, (0.0..=MAX_NUMBER).contains(&mass), "from 0 to 1000000 kg")?;
        let i = &inertial.inertia;
        for (field, value) in
            [("ixx", i.ixx), ("ixy", i.ixy), ("ixz", i.ixz), ("iyy", i.iyy), ("iyz", i.iyz), ("izz", i.izz)]
        {
            self.number(field, value, value.is_finite(), "a number (kg m^2)")?;
        }
        let inertia = Matrix3::new(i.ixx, i.ixy, i.ixz, i.ixy, i.iyy, i.iyz, i.ixz, i.iyz, i.izz);
        let gyration = solid::gyration(mass, &inertia);
        let is_too_large = gyration > solid::MAX_GYRATION_M && (mass > 0.0 || inertia.amax() > MAX_NUMBER);
        let warning = is_too_large.then(|| {
            let density = solid::ball_density(mass, gyration);
            RobotWarning::new(format!(
                "{}: {mass} kg with an inertia of {:.3e} kg m^2 would be a ball of {density:.1e} kg/m^3; {}. Is it in kg mm^2 or g mm^2?",
                self.item,
                inertia.amax(),
                solid::BALL
            ))
        });
        let inertia = match is_too_large {
            true => Matrix3::from_diagonal_element(solid::ball_inertia(mass)),
            false => inertia,
        };
        let center = self.pose(&inertial.origin)?;
        let has_body = mass > 0.0 || inertia.amax() > 0.0;
        Ok((has_body.then_some(Inertial { mass, center, inertia }), warning))
    }

    pub fn geometry(
        &self,
        origin: &urdf_rs::Pose,
        geometry: &urdf_rs::Geometry,
        color: Option<[f32; 4]>,
        mesh: Option<PathBuf>,
    ) -> Result<Geometry, Error> {
        use urdf_rs::Geometry as G;
        let round = |radius: &f64, length: &f64| {
            Ok::<_, Error>((self.positive("radius", *radius)?, self.positive("length", *length)?))
        };
        let shape = match geometry {
            G::Box { size } => {
                size.iter().try_for_each(|s| self.positive("box size", *s).map(drop))?;
                Shape::Box { size: Vector3::from(size.0) }
            }
            G::Cylinder { radius, length } => {
                let (radius, length) = round(radius, length)?;
                Shape::Cylinder { radius, length }
            }
            G::Capsule { radius, length } => {
                let (radius, length) = round(radius, length)?;
                Shape::Capsule { radius, length }
            }
            G::Sphere { radius } => Shape::Sphere { radius: self.positive("radius", *radius)? },
            G::Mesh { scale, .. } => {
                let scale = self.vector("mesh scale", &scale.map_or([1.0; 3], |s| s.0))?;
                Shape::Mesh {
                    file: mesh.expect("a mesh was found before its shape is read"),
                    scale,
                    hull: Vec::new(),
                }
            }
        };
        Ok(Geometry { link_from_shape: self.pose(origin)?, shape, color })
    }
}
