//! The description of an occupancy grid as ROS's map_server writes it (YAML): the image's name, resolution,
//! origin and thresholds.

use cocarry::error::{Error, Place};
use cocarry::guarded;
use cocarry::located::Source;
use saphyr_parser::{Event, Parser};
use std::collections::BTreeMap;

/// The description of a map.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Description {
    /// The image, relative to the description.
    pub image: String,
    /// Side of a cell, m.
    pub resolution: f64,
    /// The lower left corner of the image: x, y (m) and yaw (rad).
    pub origin: [f64; 3],
    /// Whether light cells are occupied.
    pub negate: bool,
    /// Cells that are occupied with a higher probability than this are obstacles.
    pub occupied: f64,
    /// Cells that are occupied with a lower probability than this are free.
    pub free: f64,
    pub mode: Mode,
}

/// The meaning of the values of an image's cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    /// The probability of being occupied, by darkness. What is between the thresholds is unknown.
    Shades,
    /// The probability in percent; above 100 is unknown.
    Percent,
}

/// A value with its line.
struct Written {
    values: Vec<String>,
    is_list: bool,
    line: usize,
}

impl Description {
    pub fn parse(source: Source) -> Result<Self, Error> {
        let written = guarded::on_thread(|| read(source));
        let written = written.map_err(|panic| source.invalid("map description (YAML)", panic))??;
        let values = Values { source, written };
        let known = ["image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh", "mode"];
        for (key, written) in &values.written {
            if !known.contains(&key.as_str()) {
                return Err(values.wrong(
                    key,
                    written,
                    "one of image, mode, resolution, origin, negate, occupied_thresh and free_thresh",
                    "unknown key",
                ));
            }
        }
        let probability = |key: &str, default: f64| {
            let expected = "a probability from 0 to 1";
            values.number(key, Some(default), expected, |p| (0.0..=1.0).contains(&p))
        };
        let origin = values.list("origin")?;
        let mode = match values.text("mode")?.as_deref() {
            None | Some("trinary" | "scale") => Mode::Shades,
            Some("raw") => Mode::Percent,
            Some(_) => return Err(values.wrong_value("mode", "trinary, scale or raw")),
        };
        let negate = match values.text("negate")?.as_deref() {
            None | Some("0" | "false" | "False") => false,
            Some("1" | "true" | "True") => true,
            Some(_) => return Err(values.wrong_value("negate", "0 or 1")),
        };
        Ok(Self {
            image: values
                .text("image")?
                .ok_or_else(|| values.missing("image", "the name of a PGM or PNG file"))?,
            resolution: values.number(
                "resolution",
                None,
                "the side of a cell from 0.001 to 10 (metres)",
                |r| (0.001..=10.0).contains(&r),
            )?,
            origin,
            negate,
            occupied: probability("occupied_thresh", 0.65)?,
            free: probability("free_thresh", 0.196)?,
            mode,
        })
    }
}

struct Values<'a> {
    source: Source<'a>,
    written: BTreeMap<String, Written>,
}

impl Values<'_> {
    fn text(&self, key: &str) -> Result<Option<String>, Error> {
        match self.written.get(key) {
            None => Ok(None),
            Some(Written { values, is_list: false, .. }) => Ok(values.first().cloned()),
            Some(_) => Err(self.wrong_value(key, "one value")),
        }
    }

    fn number(
        &self,
        key: &str,
        default: Option<f64>,
        expected: &str,
        is_allowed: impl Fn(f64) -> bool,
    ) -> Result<f64, Error> {
        let Some(text) = self.text(key)? else {
            return default.ok_or_else(|| self.missing(key, expected));
        };
        let number = text.parse().ok().filter(|number| is_allowed(*number));
        number.ok_or_else(|| self.wrong_value(key, expected))
    }

    fn list(&self, key: &str) -> Result<[f64; 3], Error> {
        let expected = "a list [x, y, yaw] in metres and radians, such as [-10.0, -10.0, 0.0]";
        let Some(written) = self.written.get(key) else { return Err(self.missing(key, expected)) };
        let numbers: Option<Vec<f64>> = written.values.iter().map(|v| v.parse().ok()).collect();
        let numbers = numbers.filter(|numbers| numbers.iter().all(|n| n.abs() <= 1e7));
        match numbers.as_deref() {
            Some(&[x, y]) => Ok([x, y, 0.0]),
            Some(&[x, y, yaw]) => Ok([x, y, yaw]),
            _ => Err(self.wrong_value(key, expected)),
        }
    }

    fn missing(&self, key: &str, expected: &str) -> Error {
        Error::bad(Place::item(self.source.file, "map"), format_args!("{key} is missing"), expected)
    }

    fn wrong_value(&self, key: &str, expected: &str) -> Error {
        match self.written.get(key) {
            Some(written) => self.wrong(key, written, expected, key),
            None => self.missing(key, expected),
        }
    }

    fn wrong(&self, key: &str, written: &Written, expected: &str, item: &str) -> Error {
        let place =
            Place { file: self.source.file.to_owned(), line: Some(written.line), item: "map".to_owned() };
        let values = written.values.join(", ");
        let value = if written.is_list { format!("[{values}]") } else { values };
        let found = if item == key { format!("{key} = {value}") } else { format!("{item} `{key}`") };
        Error::bad(place, found, expected)
    }
}

/// The top-level keys of a YAML mapping with their scalars or lists of scalars. Values that are mappings are
/// read as lists of their keys and values.
fn read(source: Source) -> Result<BTreeMap<String, Written>, Error> {
    let mut written: BTreeMap<String, Written> = BTreeMap::new();
    let mut depth = 0;
    let mut key: Option<String> = None;
    for event in Parser::new_from_str(source.text) {
        let (event, span) = event.map_err(|error| source.invalid("map description (YAML)", error))?;
        let line = span.start.line();
        match event {
            Event::Scalar(text, ..) if depth == 1 => match key.take() {
                None => key = Some(text.into_owned()),
                Some(key) => {
                    written.insert(key, Written { values: vec![text.into_owned()], is_list: false, line });
                }
            },
            Event::Scalar(text, ..) if depth > 1 => {
                if let Some(written) = key.as_ref().and_then(|key| written.get_mut(key)) {
                    written.values.push(text.into_owned());
                }
            }
            Event::SequenceStart(..) | Event::MappingStart(..) => {
                depth += 1;
                if depth == 2
                    && let Some(key) = &key
                {
                    written.insert(key.clone(), Written { values: Vec::new(), is_list: true, line });
                }
            }
            Event::SequenceEnd | Event::MappingEnd => {
                depth -= 1;
                if depth == 1 {
                    key = None;
                }
            }
            _ => {}
        }
    }
    Ok(written)
}
