//! Recordings: episodes as MCAP files, and summaries, tables and pictures from them.
//!
//! A recording plays in Foxglove, and any MCAP reader opens it. It holds simulated time only, and its
//! [`Provenance`]: equal runs give equal bytes. Its name is `<name>.partial` until it is finished. It is
//! handed to the system at every whole simulated second; after a crash, [`recover`] makes a valid file of it.
//! With the cargo feature `live`, `LiveServer` serves the same messages to viewers while an episode runs.
//!
//! Times are simulated. JSON fields are [quantities](cocarry::quantities), and missing values are left out.
//! The channels are those of [`Channel`]; `book/src/recordings.md` has a table of all, with rates and
//! contents.
//!
//! ```
//! use cocarry::episode::Outcome;
//! use cocarry::scenario::{Plant, Scenario};
//! use cocarry::world::World;
//! use cocarry_recording::recording::{Ending, Reader, Recorder};
//! use std::io::Cursor;
//!
//! let world = World::load("../../worlds/environment-4.toml".as_ref())?;
//! let scenario = Scenario::new(world.into(), Plant::Point);
//! let prepared = scenario.prepare()?;
//! let mut episode = prepared.episode()?;
//! let file = Cursor::new(Vec::new());
//! let mut recorder = Recorder::new(file, "memory", &prepared, &episode)?;
//! while episode.step().is_none() {
//!     recorder.step(&episode)?;
//! }
//! let file = recorder.finish(&episode, Ending::Over(Outcome::Arrived))?;
//!
//! let mut reader = Reader::new(Cursor::new(file.into_inner()), "memory")?;
//! let mut messages = 0;
//! while let Some(entry) = reader.next()? {
//!     messages += u32::from(entry.message().is_some());
//! }
//! assert!(messages > 100);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod channel;
mod contents;
mod decisions;
mod decode;
mod difference;
mod encoder;
mod ending;
mod error;
mod events;
mod file;
mod frames;
mod human;
mod json_schema;
#[cfg(feature = "live")]
mod live;
mod meshes;
mod motion;
#[cfg(feature = "live")]
mod origin_proxy;
mod overview;
mod playback;
mod provenance;
mod reader;
mod recorder;
mod records;
mod recover;
mod replay;
mod scene;
mod schema;
mod shapes;
mod table;

pub use channel::{Channel, Message};
pub use contents::{ChannelContents, Contents};
pub use decisions::DECISIONS;
pub use decode::{decode, flatten};
pub use difference::Difference;
pub use encoder::Encoder;
pub use ending::Ending;
pub use error::{ReadError, RecordingError};
#[cfg(feature = "live")]
pub use live::{LiveError, LiveServer};
pub use overview::{FIELD_OF_VIEW_DEG, Overview};
pub use playback::{Frame, Playback, RecordedEvent};
pub use provenance::{METADATA, Provenance, RECOVERED, SCENARIO, VERSION, scenario};
pub use reader::{Entry, Reader, Recorded};
pub use recorder::{FileRecorder, Recorder};
pub use records::Attachment;
pub use recover::{RecoverError, Recovered, recover};
pub use replay::{Replay, Verdict, replay, rerun};
pub use schema::{Definition, SchemaText};
pub use table::{columns, rows};
