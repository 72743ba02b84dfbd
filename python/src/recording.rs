//! Recordings: MCAP files of episodes.

use crate::arguments;
use crate::error::{RecordingError, guarded, raise};
use crate::scenario::Scenario;
use crate::table::Table;
use crate::value;
use cocarry_recording::recording::{self, Contents, Playback, ReadError, Reader, Verdict, columns, rows};
use cocarry_recording::rendering;
use numpy::{PyArray1, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Cursor, Read};
use std::path::PathBuf;

/// A recording (MCAP). Shows itself as the 3-D player in a notebook.
#[pyclass(frozen, module = "cocarry", name = "Recording")]
pub struct Recording {
    file: PathBuf,
    contents: Contents,
}

fn refused(error: &ReadError) -> PyErr {
    raise::<RecordingError>(error)
}

impl Recording {
    fn open(&self) -> PyResult<Reader<BufReader<File>>> {
        Reader::open(&self.file).map_err(|error| refused(&error))
    }
}

/// The 3-D player of a recording.
pub fn page(recording: impl Read, name: &str, title: &str) -> PyResult<String> {
    let playback = Playback::read(&mut Reader::new(recording, name).map_err(|e| refused(&e))?);
    let playback = playback.map_err(|e| refused(&e))?;
    rendering::player(&playback, title, None, &rendering::demo_address())
        .map_err(|e| raise::<RecordingError>(&e))
}

/// A page in a frame of a notebook.
pub fn framed(page: &str) -> String {
    let page = page.replace('&', "&amp;").replace('"', "&quot;");
    format!(
        "<iframe srcdoc=\"{page}\" style=\"width:100%;height:560px;border:0\" title=\"cocarry player\"></iframe>"
    )
}

/// Opens a recording (MCAP). Raises RecordingError with the file, the place and what would be right.
#[pyfunction]
pub fn read(py: Python<'_>, #[pyo3(from_py_with = arguments::file)] file: PathBuf) -> PyResult<Recording> {
    let contents = py.detach(|| Contents::read(&mut Reader::open(&file)?));
    Ok(Recording { contents: contents.map_err(|error| refused(&error))?, file })
}

/// The 3-D player of a recording's bytes.
#[pyfunction]
pub fn player(py: Python<'_>, recording: &[u8], title: &str) -> PyResult<String> {
    py.detach(|| page(Cursor::new(recording), "the episode", title))
}

/// The last picture of a recording's bytes, (height, width, 3).
#[pyfunction]
pub fn picture<'py>(py: Python<'py>, recording: &[u8], width: u32) -> PyResult<Bound<'py, PyArray3<u8>>> {
    let drawn = py.detach(|| {
        let playback = Playback::read(&mut Reader::new(Cursor::new(recording), "the episode")?);
        let drawn =
            playback.map(|playback| rendering::last_picture(&playback, rendering::Width::Pixels(width)));
        drawn.map(|drawn| drawn.map_err(|error| raise::<RecordingError>(&error)))
    });
    let drawn = drawn.map_err(|error| refused(&error))??;
    PyArray1::from_vec(py, drawn.colours).reshape([drawn.height as usize, drawn.width as usize, 3])
}

#[pymethods]
impl Recording {
    /// Its origin: crate_version, arithmetic (its stamp), seed, world, plant and method, by key.
    #[getter]
    fn provenance(&self) -> BTreeMap<String, String> {
        self.contents.provenance.clone()
    }

    /// The number of messages by topic.
    #[getter]
    fn topics(&self) -> BTreeMap<String, u64> {
        self.contents.channels.iter().map(|(topic, channel)| (topic.clone(), channel.messages)).collect()
    }

    /// The figures of the episode; None in an incomplete recording.
    #[getter]
    fn outcome<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.contents.outcome.as_ref().map(|outcome| value::json_to_python(py, outcome)).transpose()
    }

    /// The scenario.
    #[getter]
    fn scenario(&self) -> PyResult<Scenario> {
        recording::scenario(&mut self.open()?).map(Scenario::of).map_err(|error| refused(&error))
    }

    /// The messages on a topic, one a row, after their simulated time (s). Raises RecordingError.
    fn table(&self, py: Python<'_>, topic: &str) -> PyResult<Table> {
        let (mut first, mut second) = (self.open()?, self.open()?);
        let read = py.detach(|| {
            let names = columns(&mut first, topic)?;
            let (mut times, mut cells) = (Vec::new(), Vec::new());
            rows(&mut second, topic, &names, |time, row| {
                times.push(time as f64 / 1e9);
                cells.push(row.iter().map(|cell| cell.cloned()).collect::<Vec<Option<Value>>>());
                Ok::<_, ReadError>(())
            })?;
            Ok::<_, ReadError>(Table::of_messages(&names, times, &cells))
        });
        read.map_err(|error| refused(&error))
    }

    /// Runs the scenario again and compares every message: verdict, same_messages, difference.
    ///
    /// The decisions of custom partners are repeated from the recording's log.
    fn replay<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (first, second) = (self.open()?, self.open()?);
        let replay = py.detach(|| guarded(|| recording::replay(first, second)))?;
        let replay = replay.map_err(|error| refused(&error))?;
        let dict = PyDict::new(py);
        let (verdict, difference) = match &replay.verdict {
            Verdict::Identical => ("identical", None),
            Verdict::IdenticalUntilCut => ("identical-until-cut", None),
            Verdict::Different(difference) => ("different", Some(format!("{difference:?}"))),
        };
        dict.set_item("verdict", verdict)?;
        dict.set_item("same_messages", replay.same)?;
        dict.set_item("difference", difference)?;
        Ok(dict)
    }

    /// The 3-D player, as one page.
    #[pyo3(signature = (title = None))]
    fn to_html(&self, py: Python<'_>, title: Option<&str>) -> PyResult<String> {
        let name = self.file.display().to_string();
        let title = title.unwrap_or(&name);
        py.detach(|| {
            let file = cocarry::located::open(&self.file)
                .map_err(|error| RecordingError::new_err(format!("{name}: {error}")))?;
            page(BufReader::new(file), &name, title)
        })
    }

    fn _repr_html_(&self, py: Python<'_>) -> PyResult<String> {
        Ok(framed(&self.to_html(py, None)?))
    }

    fn __repr__(&self) -> String {
        let messages: u64 = self.contents.channels.values().map(|channel| channel.messages).sum();
        format!("<cocarry.Recording {:?}, {messages} messages>", self.file.display().to_string())
    }
}
