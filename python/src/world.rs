//! Worlds.

use crate::arguments;
use crate::error::{WorldError, raise};
use crate::value::repr;
use cocarry::geometry::{Footprint, Point};
use cocarry::options::OptionSet;
use cocarry::preference::{Predictor, RISK_WEIGHT};
use cocarry::world;
use cocarry_maps::Ends;
use cocarry_output::drawing::{self, Sheet};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};
use std::path::{Path, PathBuf};

/// A world: obstacles, openings, start and target. Shows itself as its map in a notebook.
///
/// Reads a world file (TOML), or takes a built-in world: environment-1 to environment-4, or free-form.
///
/// Raises WorldError with the file, the line, the item and the numbers.
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
    #[pyo3(signature = (world = None))]
    fn new(world: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let world = world.map_or_else(|| load_world(Path::new("environment-4")), world_of)?;
        Ok(Self { world })
    }

    /// Reads the text of a world file; errors call it ``name``.
    #[staticmethod]
    #[pyo3(signature = (text, name = "world"))]
    fn parse(
        #[pyo3(from_py_with = arguments::contents)] text: &str,
        #[pyo3(from_py_with = arguments::name)] name: &str,
    ) -> PyResult<Self> {
        world::World::parse(name, text).map(|world| Self { world }).map_err(|e| raise::<WorldError>(&e))
    }

    /// Reads a map: an occupancy grid (the YAML of ROS's map_server, with a PGM or PNG image) or a floor
    /// plan (GeoJSON, SVG). A and B are given in metres. ``text`` is the world with the map's outlines.
    ///
    /// Raises WorldError with the file and the value.
    #[staticmethod]
    #[pyo3(signature = (map, start, target, *, robot_width_m = None, tolerance_m = None))]
    fn from_map(
        #[pyo3(from_py_with = arguments::map)] map: PathBuf,
        #[pyo3(from_py_with = arguments::start)] start: [f64; 2],
        #[pyo3(from_py_with = arguments::target)] target: [f64; 2],
        #[pyo3(from_py_with = arguments::robot_width)] robot_width_m: Option<f64>,
        #[pyo3(from_py_with = arguments::tolerance)] tolerance_m: Option<f64>,
    ) -> PyResult<Self> {
        let [start, target] = [start, target].map(Point::from);
        let ends = Ends { start, target, robot_width: robot_width_m, tolerance: tolerance_m };
        let world = cocarry_maps::from_map(&map, &ends).map_err(|error| raise::<WorldError>(&error))?;
        Ok(Self { world })
    }

    /// Title.
    #[getter]
    fn name(&self) -> &str {
        &self.world.name
    }

    /// Text of the file.
    #[getter]
    fn text(&self) -> &str {
        &self.world.text
    }

    /// A, (2,), m.
    #[getter]
    fn start<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.world.start.coords.as_slice())
    }

    /// B, (2,), m.
    #[getter]
    fn target<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.world.target.coords.as_slice())
    }

    /// The corners of the smallest rectangle around everything, (2, 2), m.
    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let bounds = self.world.bounds();
        let corners = [bounds.min, bounds.max].map(|corner| vec![corner.x, corner.y]);
        Ok(PyArray2::from_vec2(py, &corners)?)
    }

    /// The obstacles, in the order of the file.
    #[getter]
    fn obstacles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let class = py.import("cocarry._world")?.getattr("Obstacle")?;
        let list = PyList::empty(py);
        for obstacle in &self.world.obstacles {
            list.append(class.call((), Some(&fields(py, obstacle)?))?)?;
        }
        Ok(list)
    }

    /// The names of its options: the openings in the order in which they are passed.
    #[pyo3(signature = (risk_weight_m = RISK_WEIGHT))]
    fn options(
        &self,
        #[pyo3(from_py_with = arguments::risk_weight)] risk_weight_m: f64,
    ) -> PyResult<Vec<String>> {
        Ok(self.option_set(risk_weight_m)?.options().iter().map(|option| option.name.clone()).collect())
    }

    fn _repr_svg_(&self) -> PyResult<String> {
        let options = self.option_set(RISK_WEIGHT)?;
        let mut predictor = Predictor::default();
        let mut choice = Default::default();
        let prospects = cocarry::episode::prospects(&options, &options.begin());
        predictor.predict(&prospects, &mut choice);
        drawing::world_map(&self.world, &options, choice.probabilities(), Sheet::default())
            .map_err(|e| raise::<WorldError>(&e))
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

/// The fields of an obstacle's Python class.
fn fields<'py>(py: Python<'py>, obstacle: &world::Obstacle) -> PyResult<Bound<'py, PyDict>> {
    let point = |[x, y]: [f64; 2]| PyArray1::from_slice(py, &[x, y]);
    let disc = obstacle.footprints().find_map(|part| match part {
        Footprint::Disc { center, radius } => Some((*center, *radius)),
        Footprint::Polygon(_) => None,
    });
    let rectangle = obstacle.rectangle();
    let center = rectangle.map(|(center, ..)| center).or(disc.map(|(center, _)| center));
    let parts: Vec<_> = obstacle.footprints().filter_map(Footprint::corners).map(<[Point]>::to_vec).collect();
    // an outline is there of a concave one alone
    let rings = obstacle.outline.as_ref().map_or(parts.as_slice(), |outline| outline.rings());
    let fields = PyDict::new(py);
    fields.set_item("name", &obstacle.name)?;
    fields.set_item("shape", obstacle.shape_name())?;
    fields.set_item("height_m", obstacle.height)?;
    fields.set_item("center", center.map(|center| point([center.x, center.y])))?;
    fields.set_item("size", rectangle.map(|(_, size, _)| point(size)))?;
    fields.set_item("yaw_rad", rectangle.map(|(.., yaw)| yaw))?;
    fields.set_item("radius_m", disc.map(|(_, radius)| radius))?;
    fields.set_item("rings", corners(py, rings)?)?;
    fields.set_item("parts", corners(py, &parts)?)?;
    Ok(fields)
}

/// The corners of polygons, each (n, 2).
fn corners<'py>(py: Python<'py>, polygons: &[Vec<Point>]) -> PyResult<Bound<'py, PyTuple>> {
    let array = |polygon: &Vec<Point>| {
        let rows: Vec<_> = polygon.iter().map(|corner| vec![corner.x, corner.y]).collect();
        PyArray2::from_vec2(py, &rows)
    };
    PyTuple::new(py, polygons.iter().map(array).collect::<Result<Vec<_>, _>>()?)
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
