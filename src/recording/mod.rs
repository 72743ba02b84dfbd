//! Recordings: episodes as MCAP files, and summaries, tables and pictures from them.
//!
//! A recording plays in Foxglove, and any MCAP reader opens it. It holds simulated time only, and its
//! [`Provenance`]: equal runs give equal bytes. Its name is `<name>.partial` until it is finished. It is
//! handed to the system at every whole simulated second; after a crash, [`recover`] makes a valid file of it.
//! With the cargo feature `live`, `LiveServer` serves the same messages to viewers while an episode runs.
//!
//! # Channels
//!
//! Times are simulated. Decisions have the time of the beginning of their step, motion and forces that of its
//! end. Lengths are in m, angles in Foxglove's messages in rad, forces in N, torques in Nm. JSON fields are
//! [quantities](crate::quantities): their names and the channel's JSON Schema have the unit, and missing
//! values are left out. All frames are in `world` (z up, the floor at 0).
//!
//! | topic | schema | rate | what |
//! | --- | --- | --- | --- |
//! | `/tf` | foxglove.FrameTransforms | every step, and at 0 | `robot/<link>` for every link; with physics `object`, `human/hand`, `human/torso`, otherwise `human`: the reference pose of the grasp |
//! | `/scene/world` | foxglove.SceneUpdate | once | obstacles, extruded; openings from green (no risk) to red; A and B |
//! | `/scene/team` | foxglove.SceneUpdate | once | shapes of robot, object and human, in their frames |
//! | `/scene/options` | foxglove.SceneUpdate | when P_o changes by 0.02 | every option from A to B; its width (2 to 20 cm) and opacity show P_o |
//! | `/scene/path` | foxglove.SceneUpdate | every step | the path walked, and the path of the executed option |
//! | `/joints` | foxglove.JointStates | every step, and at 0 | arm joints (rad or m, per s, Nm or N), then wheels (rad, rad/s) |
//! | `/log` | foxglove.Log | at the event | [`Event`](crate::quantities::Event)s: start, preference change, mode transition, change of option, reversal, contact, loss of the object, end |
//! | `/options` | JSON | every step | per option: D_o (m), S_o, J_o (m), J~_o, P_o, omega_o |
//! | `/coordination` | JSON | every step | phi, its threshold, g, mode, option executed and preferred, position (m), heading (deg) |
//! | `/control` | JSON | every step | tracking error (m, deg), cost terms, candidate of eq. (8), outcome of eq. (7), u (m/s, rad/s) |
//! | `/preparation` | JSON | every step | references s_o(1..H) with their weights, q*, the candidates of eq. (8) with their totals |
//! | `/interaction` | JSON | every step, with physics | mean wrenches of both grips on the object (N, Nm, world axes), peaks, work (J), distances (m) |
//! | `/cost` | JSON | every step | running totals: accumulated J (m), C and its parts, work (J) |
//! | `/outcome` | JSON | once, at the end | outcome and totals |
//!
//! A team that is a point has no `/tf`, `/scene/team`, `/joints`, `/control` and `/preparation`.
//!
//! ```
//! use cocarry::episode::Outcome;
//! use cocarry::paper;
//! use cocarry::recording::{Ending, Reader, Recorder};
//! use cocarry::scenario::{Plant, Scenario};
//! use std::io::Cursor;
//!
//! let scenario = Scenario {
//!     seed: 1,
//!     world: paper::ENVIRONMENTS[3].world()?.into(),
//!     human: paper::EXAMPLE_HUMAN,
//!     human_model: Default::default(),
//!     changes: Vec::new(),
//!     settings: Default::default(),
//!     plant: Plant::Point,
//! };
//! let stage = scenario.prepare()?;
//! let mut episode = stage.episode()?;
//! let file = Cursor::new(Vec::new());
//! let mut recorder = Recorder::new(file, "memory", &stage, &episode)?;
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
mod decode;
mod difference;
mod encoder;
mod ending;
mod error;
mod events;
mod fields;
mod file;
#[cfg(feature = "live")]
mod live;
mod motion;
mod playback;
mod provenance;
mod reader;
mod recorder;
mod records;
mod recover;
mod replay;
mod scene;
mod schema;
mod table;

pub use channel::{Channel, Message};
pub use contents::{ChannelContents, Contents};
pub use decode::{decode, flatten};
pub use difference::Difference;
pub use encoder::Encoder;
pub use ending::Ending;
pub use error::{ReadError, RecordingError};
#[cfg(feature = "live")]
pub use live::{LiveError, LiveServer};
pub use playback::{Frame, Happening, Playback};
pub use provenance::{METADATA, Provenance, RECOVERED, SCENARIO, scenario};
pub use reader::{Entry, Reader, Recorded};
pub use recorder::{FileRecorder, Recorder};
pub use records::Attachment;
pub use recover::{RecoverError, Recovered, recover};
pub use replay::{Replay, Verdict, replay};
pub use schema::{Definition, SchemaText};
pub use table::{columns, rows};
