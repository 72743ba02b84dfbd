//! An episode read back from its recording, for pictures and the player: the scenario, the poses over time,
//! the JSON messages of every step, and the events as the recording words them.

use super::decisions::{self, DECISIONS};
use super::frames::{HAND, HUMAN, OBJECT, TORSO, WORLD, link_frame};
use super::{Channel, Entry, ReadError, Reader, decode, scenario};
use cocarry::geometry::{PlanarPose, Point, Pose};
use cocarry::scenario::{Decisions, PreparedScenario};
use cocarry_output::bodies::{Bodies, torso_ahead_of};
use nalgebra::{Quaternion, Rotation3, Translation3, UnitQuaternion, Vector3};
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::Read;

/// The largest number of steps that are read: 100 minutes of planning steps of 0.2 s.
const MAX_STEPS: usize = 30_000;

/// The largest coordinate, m: that of a world.
const MAX_COORDINATE: f64 = 1e6;

/// An episode as its recording tells it.
#[derive(Clone, Debug)]
pub struct Playback {
    /// The scenario, with its world, options and robot.
    pub prepared: PreparedScenario,
    /// The poses of the bodies, in time order: at 0 and at the end of every step. At least one.
    pub frames: Vec<Frame>,
    /// The path ahead of the team, with its times (ns).
    pub ahead: Vec<(u64, Vec<Point>)>,
    /// The events, in time order.
    pub events: Vec<RecordedEvent>,
    /// How the episode ended; `None` where the recording ends before the episode did.
    pub outcome: Option<String>,
    /// The decisions of partners that the scenario does not describe, or that somebody steered; empty without any.
    pub decisions: Decisions,
    messages: BTreeMap<Channel, Vec<(u64, Value)>>,
}

/// The poses of the bodies at a time. On the planning level the human and the object are where they would be
/// around the point that is the team; on the kinematic plant they are at the grasp.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Simulated time, ns.
    pub time: u64,
    /// The links, in the order of the robot's; empty on the planning level.
    pub links: Vec<Pose>,
    /// Middle of the carried object.
    pub object: Pose,
    /// The human's hand.
    pub hand: Pose,
    /// Middle of the human's torso.
    pub torso: Pose,
}

/// An event of the recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordedEvent {
    /// Simulated time, ns.
    pub time: u64,
    /// Its subject: episode, human, preference, mode, option, contact or end.
    pub about: String,
    /// The event, as one sentence.
    pub sentence: String,
}

impl Playback {
    /// Reads a recording to its end.
    ///
    /// # Errors
    /// [`ReadError`]: also where the scenario cannot be prepared, a message cannot be decoded, there are no
    /// steps or too many.
    pub fn read<R: Read>(reader: &mut Reader<R>) -> Result<Self, ReadError> {
        let file = reader.name().to_owned();
        let lacks = |what: String| ReadError::Lacks { file: file.clone(), what };
        let prepared = scenario(reader)?.prepare();
        let prepared = prepared.map_err(|source| ReadError::Scenario { file: file.clone(), source })?;
        let mut transforms = Vec::new();
        let mut ahead = Vec::new();
        let mut events = Vec::new();
        let mut outcome = None;
        let mut log = Decisions::default();
        let mut messages: BTreeMap<Channel, Vec<(u64, Value)>> = BTreeMap::new();
        while let Some(entry) = reader.next()? {
            if let Entry::Attachment(attachment) = &entry {
                if attachment.name == DECISIONS {
                    log = decisions::read(reader, attachment)?;
                }
                continue;
            }
            let Some(message) = entry.message() else { continue };
            let Some(channel) = Channel::of_topic(&message.channel.topic) else { continue };
            let time = message.time;
            match channel {
                Channel::World
                | Channel::Team
                | Channel::OptionLines
                | Channel::Joints
                | Channel::Control
                | Channel::Preparation => continue,
                // a path that is too long to decode is not drawn
                Channel::Path => {
                    ahead.extend(
                        decode(message.channel, message.data).and_then(|v| Some((time, path_ahead(&v)?))),
                    );
                    continue;
                }
                _ => {}
            }
            let damaged = || {
                let at = time as f64 / 1e9;
                lacks(format!("the message on {} at {at} s is damaged", channel.topic()))
            };
            let value = decode(message.channel, message.data).ok_or_else(damaged)?;
            match channel {
                Channel::Transforms => transforms.push((time, poses(&value).ok_or_else(damaged)?)),
                Channel::Log => events.push(RecordedEvent {
                    time,
                    about: value["name"].as_str().unwrap_or_default().to_owned(),
                    sentence: value["message"].as_str().ok_or_else(damaged)?.to_owned(),
                }),
                Channel::Outcome => outcome = value["outcome"].as_str().map(str::to_owned),
                _ => {
                    let channel = messages.entry(channel).or_default();
                    if channel.len() == MAX_STEPS || transforms.len() > MAX_STEPS {
                        return Err(lacks(format!("has more than {MAX_STEPS} steps, too many to draw")));
                    }
                    channel.push((time, value));
                }
            }
        }
        let mut playback =
            Self { prepared, frames: Vec::new(), ahead, events, outcome, decisions: log, messages };
        playback.frames = match playback.prepared.robot() {
            None => playback.frames_of_a_point(),
            Some(_) => transforms.iter().filter_map(|(time, poses)| playback.frame(*time, poses)).collect(),
        };
        // as written, unless the file is forged
        playback.frames.sort_by_key(|frame| frame.time);
        playback.ahead.sort_by_key(|(time, _)| *time);
        playback.events.sort_by_key(|event| event.time);
        // before its first step an episode has one frame; several at one time are forged
        let is_empty = match playback.frames.as_slice() {
            [] => true,
            [_] => false,
            [.., last] => last.time == 0,
        };
        match is_empty || playback.messages(Channel::Coordination).is_empty() {
            true => Err(lacks("has no complete step, so there is nothing to draw".to_owned())),
            false => Ok(playback),
        }
    }

    /// The messages of a step's channel with their times (ns), in time order; none for the channels that
    /// hold scenes, poses and events.
    pub fn messages(&self, channel: Channel) -> &[(u64, Value)] {
        self.messages.get(&channel).map_or(&[], Vec::as_slice)
    }

    /// The numbers with this key on a channel, by message; NaN where one is missing.
    pub fn column(&self, channel: Channel, key: &str) -> Vec<f64> {
        let number = |(_, value): &(u64, Value)| value[key].as_f64().unwrap_or(f64::NAN);
        self.messages(channel).iter().map(number).collect()
    }

    /// The times (s) of a channel's messages.
    pub fn times(&self, channel: Channel) -> Vec<f64> {
        self.messages(channel).iter().map(|(time, _)| *time as f64 / 1e9).collect()
    }

    /// The frame of a recorded set of poses; `None` where one is missing.
    fn frame(&self, time: u64, poses: &BTreeMap<String, Pose>) -> Option<Frame> {
        let robot = self.prepared.robot()?;
        let links = robot.links.iter().map(|link| poses.get(&link_frame(&link.name)).copied());
        let links: Vec<Pose> = links.collect::<Option<_>>()?;
        if let Some((&object, (&hand, &torso))) = poses.get(OBJECT).zip(poses.get(HAND).zip(poses.get(TORSO)))
        {
            return Some(Frame { time, links, object, hand, torso });
        }
        // earlier versions gave the human of the kinematic plant as the pose that the grasp should have
        let length = self.prepared.world().object.size[0];
        let Bodies { object, hand, torso } =
            Bodies::around(&links[robot.grasp_link], poses.get(HUMAN)?, length);
        Some(Frame { time, links, object, hand, torso })
    }

    /// The frames of a team that is a point: the object around it, level, at a usual height.
    fn frames_of_a_point(&self) -> Vec<Frame> {
        const CARRYING_HEIGHT_M: f64 = 0.7;
        let length = self.prepared.world().object.size[0];
        let steps = self.messages(Channel::Coordination);
        let frame = |time, x: f64, y: f64, yaw: f64| {
            let turned = Rotation3::from_axis_angle(&Vector3::z_axis(), yaw);
            let object = Pose::from_parts(Translation3::new(x, y, CARRYING_HEIGHT_M), turned);
            let hand = object * Translation3::new(length / 2.0, 0.0, 0.0);
            Frame { time, links: Vec::new(), object, hand, torso: torso_ahead_of(&hand) }
        };
        let mut frames: Vec<Frame> = steps
            .iter()
            .filter_map(|(time, step)| {
                let number = |key: &str| step[key].as_f64().filter(|number| is_near(*number));
                Some(frame(*time, number("x_m")?, number("y_m")?, number("heading_deg")?.to_radians()))
            })
            .collect();
        // the last step's end is known where the team arrived
        let arrived = self.outcome.as_deref() == Some("arrived");
        let end = self.messages(Channel::Cost).last().filter(|_| arrived).map(|(time, _)| *time);
        if let (Some(end), Some(last)) = (end, frames.last()) {
            let target = self.prepared.world().target;
            let yaw = PlanarPose::from_above(&last.object).yaw;
            frames.push(frame(end, target.x, target.y, yaw));
        }
        frames
    }
}

/// Whether a coordinate (m, deg) is one of an episode.
fn is_near(number: f64) -> bool {
    number.abs() <= MAX_COORDINATE
}

/// The path ahead in a `/scene/path` message.
fn path_ahead(message: &Value) -> Option<Vec<Point>> {
    let ahead = message["entities"].as_array()?.iter().find(|entity| entity["id"] == "ahead")?;
    let points = ahead["lines"][0]["points"].as_array()?;
    let number = |value: &Value| value.as_f64().filter(|number| is_near(*number));
    points.iter().map(|p| Some(Point::new(number(&p["x"])?, number(&p["y"])?))).collect()
}

/// The poses in the world of a `/tf` message's frames; `None` where they are not a tree, or a number is
/// missing.
fn poses(message: &Value) -> Option<BTreeMap<String, Pose>> {
    let transform = |t: &Value| {
        let number = |part: &str, key: &str| t[part][key].as_f64();
        let vector = |part| Some((number(part, "x")?, number(part, "y")?, number(part, "z")?));
        let (x, y, z) = vector("translation")?;
        if ![x, y, z].into_iter().all(is_near) {
            return None;
        }
        let (i, j, k) = vector("rotation")?;
        // those of limbs are rounded
        let turned = UnitQuaternion::try_new(Quaternion::new(number("rotation", "w")?, i, j, k), 1e-6)?;
        let pose = Pose::from_parts(Translation3::new(x, y, z), turned.to_rotation_matrix());
        let name = |key: &str| Some(t[key].as_str()?.to_owned());
        Some((name("child_frame_id")?, (name("parent_frame_id")?, pose)))
    };
    let given = message["transforms"].as_array()?.iter().map(transform);
    let given: BTreeMap<String, (String, Pose)> = given.collect::<Option<_>>()?;
    let mut known: BTreeMap<String, Pose> = BTreeMap::new();
    for frame in given.keys() {
        let mut below: Vec<&str> = Vec::new();
        let mut next = frame.as_str();
        while next != WORLD && !known.contains_key(next) {
            // a circle is not a tree
            if below.len() == given.len() {
                return None;
            }
            below.push(next);
            next = given.get(next)?.0.as_str();
        }
        let mut pose = known.get(next).copied().unwrap_or_default();
        for frame in below.into_iter().rev() {
            pose *= given.get(frame)?.1;
            known.insert(frame.to_owned(), pose);
        }
    }
    Some(known)
}
