//! The obstacles of a floor plan: the areas of a GeoJSON file.

use crate::request::Request;
use crate::room::Obstacles;
use cocarry::bounds;
use cocarry::error::{Error, Place};
use cocarry::geometry::Point;
use cocarry::guarded;
use cocarry::located::{self, Source};
use geojson::{Feature, GeoJson, GeometryValue, JsonObject};
use std::collections::BTreeMap;
use std::path::Path;

/// The obstacles of the plan in a file: its polygons. Properties `name`, `height_m` and `shape` of a feature
/// apply to its obstacles.
pub(crate) fn obstacles(path: &Path, request: &Request) -> Result<String, Error> {
    let file = path.display().to_string();
    let text = located::read(&bounds::PLAN, path)?;
    let source = Source { file: &file, text: &text };
    let plan = guarded::on_thread(|| text.parse::<GeoJson>());
    let plan = plan.map_err(|panic| source.invalid("GeoJSON file", panic))?;
    let plan = plan.map_err(|error| source.invalid("GeoJSON file", error))?;
    let features = match plan {
        GeoJson::FeatureCollection(collection) => collection.features,
        GeoJson::Feature(feature) => vec![feature],
        GeoJson::Geometry(geometry) => vec![Feature { geometry: Some(geometry), ..Feature::default() }],
    };
    let mut plan = Plan { file: &file, request, names: BTreeMap::new(), obstacles: Obstacles::default() };
    for (i, feature) in features.into_iter().enumerate() {
        let Some(geometry) = feature.geometry else { continue };
        plan.add(i + 1, &feature.properties.unwrap_or_default(), &geometry.value)?;
    }
    Ok(plan.obstacles.text)
}

struct Plan<'a> {
    file: &'a str,
    request: &'a Request,
    /// How often each name was used.
    names: BTreeMap<String, usize>,
    obstacles: Obstacles,
}

impl Plan<'_> {
    fn add(&mut self, number: usize, properties: &JsonObject, geometry: &GeometryValue) -> Result<(), Error> {
        match geometry {
            GeometryValue::Polygon { coordinates } => self.add_polygon(number, properties, coordinates),
            GeometryValue::MultiPolygon { coordinates } => {
                coordinates.iter().try_for_each(|rings| self.add_polygon(number, properties, rings))
            }
            GeometryValue::GeometryCollection { geometries } => {
                geometries.iter().try_for_each(|geometry| self.add(number, properties, &geometry.value))
            }
            other => Err(self.wrong(
                number,
                format!("its geometry is a {}", other.type_name()),
                "a Polygon or MultiPolygon: an obstacle is an area (give lines their thickness)",
            )),
        }
    }

    fn add_polygon(
        &mut self,
        number: usize,
        properties: &JsonObject,
        rings: &[Vec<geojson::Position>],
    ) -> Result<(), Error> {
        let text = |key: &str| properties.get(key).and_then(|value| value.as_str());
        let height = properties.get("height_m").map(|value| value.as_f64());
        let height = height.unwrap_or(Some(self.request.height)).ok_or_else(|| {
            self.wrong(number, "its height_m is not a number".to_owned(), "a height in metres")
        })?;
        let shape = match text("shape") {
            None | Some("polygon") => "polygon",
            Some("room") => "room",
            Some(other) => {
                return Err(self.wrong(number, format!("its shape is {other:?}"), "polygon or room"));
            }
        };
        let name = text("name").map_or_else(|| format!("area-{number}"), str::to_owned);
        let used = self.names.entry(name.clone()).or_default();
        *used += 1;
        let name = if *used == 1 { name } else { format!("{name}-{used}") };
        let scale = self.request.unit.metres();
        let points = |ring: &Vec<geojson::Position>| -> Vec<Point> {
            let mut points: Vec<Point> =
                ring.iter().filter(|p| p.len() >= 2).map(|p| Point::new(p[0], p[1]) * scale).collect();
            if points.len() > 1 && points.first() == points.last() {
                points.pop();
            }
            points
        };
        let mut rings = rings.iter().map(points);
        let outer = rings.next().unwrap_or_default();
        self.obstacles.add(&name, shape, &outer, &rings.collect::<Vec<_>>(), height);
        Ok(())
    }

    fn wrong(&self, number: usize, found: String, expected: &str) -> Error {
        Error::bad(Place::item(self.file, format!("feature {number}")), found, expected)
    }
}
