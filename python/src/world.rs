//! Worlds.

use crate::error::{WorldError, raise};
use crate::value::repr;
use cocarry::geometry::Point;
use cocarry::options::OptionSet;
use cocarry::preference::{Predictor, RISK_WEIGHT};
use cocarry::world;
use cocarry_maps::Ends;
use cocarry_output::drawing;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use std::path::{Path, PathBuf};

/// A world: obstacles, openings, start and target.
#[pyclass(frozen, module = "cocarry", name = "World")]
pub struct World {
    pub world: world::World,
}

/// The world in a file, or a built-in one by its name.
pub fn load_world(path: &Path) -> PyResult<world::World> {
    cocarry_maps::find(path, &path.to_string_lossy()).map_err(|error| raise::<WorldError>(&error))
}

#[pymethods]
impl World {
    #[new]
    #[pyo3(signature = (world = PathBuf::from("environment-4")))]
    fn new(world: PathBuf) -> PyResult<Self> {
        Ok(Self { world: load_world(&world)? })
    }

    #[staticmethod]
    #[pyo3(signature = (text, name = "world"))]
    fn parse(text: &str, name: &str) -> PyResult<Self> {
        world::World::parse(name, text).map(|world| Self { world }).map_err(|e| raise::<WorldError>(&e))
    }

    /// The world of a map between two points.
    #[staticmethod]
    #[pyo3(signature = (map, start, target, *, robot_width_m = None, tolerance_m = None))]
    fn from_map(
        map: PathBuf,
        start: [f64; 2],
        target: [f64; 2],
        robot_width_m: Option<f64>,
        tolerance_m: Option<f64>,
    ) -> PyResult<Self> {
        let [start, target] = [start, target].map(Point::from);
        let ends = Ends { start, target, robot_width: robot_width_m, tolerance: tolerance_m };
        let world = cocarry_maps::from_map(&map, &ends).map_err(|error| raise::<WorldError>(&error))?;
        Ok(Self { world })
    }

    #[getter]
    fn name(&self) -> &str {
        &self.world.name
    }

    #[getter]
    fn text(&self) -> &str {
        &self.world.text
    }

    #[getter]
    fn start<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.world.start.coords.as_slice())
    }

    #[getter]
    fn target<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.world.target.coords.as_slice())
    }

    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let bounds = self.world.bounds();
        let corners = [bounds.min, bounds.max].map(|corner| vec![corner.x, corner.y]);
        Ok(PyArray2::from_vec2(py, &corners)?)
    }

    /// The names of its options, with the risk weight c_r (m).
    #[pyo3(signature = (risk_weight_m = RISK_WEIGHT))]
    fn options(&self, risk_weight_m: f64) -> PyResult<Vec<String>> {
        Ok(self.option_set(risk_weight_m)?.options().iter().map(|option| option.name.clone()).collect())
    }

    fn _repr_svg_(&self) -> PyResult<String> {
        let options = self.option_set(RISK_WEIGHT)?;
        let mut predictor = Predictor::default();
        let mut choice = Default::default();
        let prospects = cocarry::episode::prospects(&options, &options.begin());
        predictor.predict(&prospects, &mut choice);
        drawing::world_map(&self.world, &options, choice.probabilities()).map_err(|e| raise::<WorldError>(&e))
    }

    fn __repr__(&self) -> String {
        format!("<cocarry.World {:?}>", self.world.name)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (String, String))> {
        let this = slf.get();
        Ok((slf.get_type().getattr("parse")?, (this.world.text.clone(), this.world.file.clone())))
    }
}

impl World {
    pub fn option_set(&self, risk_weight: f64) -> PyResult<OptionSet> {
        OptionSet::new(&self.world, risk_weight).map_err(|e| raise::<WorldError>(&e))
    }
}

/// The world of an argument: a name, a file or a world.
pub fn world_of(given: &Bound<'_, PyAny>) -> PyResult<world::World> {
    if let Ok(world) = given.cast::<World>() {
        return Ok(world.get().world.clone());
    }
    match given.extract::<PathBuf>() {
        Ok(path) => load_world(&path),
        Err(_) => Err(WorldError::new_err(format!(
            "world = {}; it must be a world file, a built-in world ({}) or a cocarry.World",
            repr(given),
            world::BUILT_IN_WORLDS.iter().map(|world| world.name).collect::<Vec<_>>().join(", ")
        ))),
    }
}
