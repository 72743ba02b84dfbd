//! The channels of a recording: topic, schema and encoding of each.

use super::json_schema::schema;
use cocarry::quantities::{
    self, BASE, CONTROL, COORDINATION, COST, EPISODE, Fields, INTERACTION, JOINTS, LEARNED, OPTIONS,
    PREPARATION, Quantity, Record, STEP, headings,
};
use foxglove::messages::{FrameTransforms, JointStates, Log, SceneUpdate};
use foxglove::{Encode, Schema};
use serde::Serializer;
use serde_json::Value;

/// A channel of a recording. [The module's documentation](super) describes the contents of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Channel {
    /// Poses of links, object and human.
    Transforms,
    /// The fixed scene: obstacles, openings, start, target.
    World,
    /// Shapes of robot, object and human.
    Team,
    /// Options as lines.
    OptionLines,
    /// The path walked, and the path ahead.
    Path,
    /// Joints and wheels.
    Joints,
    /// Events.
    Log,
    /// D, S, J, J~ and P of every option.
    Options,
    /// phi, g, mode and choices.
    Coordination,
    /// The controller's decision and its tracking error.
    Control,
    /// The inputs of an omnidirectional base.
    Base,
    /// The controller's inputs: references, and the candidates of eq. (8).
    Preparation,
    /// The robot's belief about the human.
    Learned,
    /// Forces.
    Interaction,
    /// Running totals.
    Cost,
    /// The outcome.
    Outcome,
}

impl Channel {
    /// All channels, in the order in which files define them.
    pub const ALL: [Self; 16] = [
        Self::Transforms,
        Self::World,
        Self::Team,
        Self::OptionLines,
        Self::Path,
        Self::Joints,
        Self::Log,
        Self::Options,
        Self::Coordination,
        Self::Control,
        Self::Base,
        Self::Preparation,
        Self::Learned,
        Self::Interaction,
        Self::Cost,
        Self::Outcome,
    ];

    /// The channel of that topic.
    pub fn of_topic(topic: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|c| c.topic() == topic)
    }

    /// Its topic.
    pub fn topic(self) -> &'static str {
        match self {
            Self::Transforms => "/tf",
            Self::World => "/scene/world",
            Self::Team => "/scene/team",
            Self::OptionLines => "/scene/options",
            Self::Path => "/scene/path",
            Self::Joints => "/joints",
            Self::Log => "/log",
            Self::Options => "/options",
            Self::Coordination => "/coordination",
            Self::Control => "/control",
            Self::Base => "/base",
            Self::Preparation => "/preparation",
            Self::Learned => "/learned",
            Self::Interaction => "/interaction",
            Self::Cost => "/cost",
            Self::Outcome => "/outcome",
        }
    }

    /// Name, encoding and text of the schema.
    pub fn schema(self) -> Schema {
        let known = match self {
            Self::Transforms => FrameTransforms::get_schema(),
            Self::World | Self::Team | Self::OptionLines | Self::Path => SceneUpdate::get_schema(),
            Self::Joints => JointStates::get_schema(),
            Self::Log => Log::get_schema(),
            _ => None,
        };
        known.unwrap_or_else(|| {
            let name = self.topic().trim_start_matches('/');
            let text = self.json_schema().to_string();
            Schema::new(format!("cocarry.{name}"), "jsonschema", text.into_bytes())
        })
    }

    /// The quantities in its messages; none for the channels of Foxglove's types.
    pub(super) fn quantities(self) -> &'static [&'static [Quantity]] {
        match self {
            Self::Options => &[STEP, OPTIONS],
            Self::Coordination => &[STEP, COORDINATION],
            Self::Control => &[STEP, CONTROL, JOINTS],
            Self::Base => &[STEP, BASE],
            Self::Preparation => &[STEP, PREPARATION],
            Self::Learned => &[STEP, LEARNED],
            Self::Interaction => &[STEP, INTERACTION],
            Self::Cost => &[STEP, COST],
            Self::Outcome => &[EPISODE],
            _ => &[],
        }
    }

    /// The JSON Schema of its messages. Foxglove reads one plain type a field and refuses lists of types: a
    /// field without a value is left out of the message, and the schema does not require it.
    fn json_schema(self) -> Value {
        let mut schema = schema(headings(self.quantities().iter().copied().flatten()));
        schema["$schema"] = "https://json-schema.org/draft/2020-12/schema".into();
        schema["title"] = self.topic().trim_start_matches('/').into();
        schema
    }

    /// The encoding of its messages: `protobuf` or `json`.
    pub fn encoding(self) -> &'static str {
        match self.quantities() {
            [] => "protobuf",
            _ => "json",
        }
    }
}

/// An encoded message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// Its channel.
    pub channel: Channel,
    /// Simulated time, ns.
    pub time: u64,
    /// The data, in the channel's encoding.
    pub data: Vec<u8>,
}

impl Message {
    /// A message of a Foxglove type.
    pub(super) fn of(channel: Channel, time: u64, message: &impl Encode) -> Self {
        let mut data = Vec::with_capacity(message.encoded_len().unwrap_or(0));
        let encoded = message.encode(&mut data);
        debug_assert!(encoded.is_ok(), "writing to a vector does not fail");
        Self { channel, time, data }
    }

    /// A JSON message, without the fields that are missing.
    pub(super) fn json(channel: Channel, time: u64, record: Record) -> Self {
        let mut fields = record;
        fields.retain(|(_, value)| *value != quantities::Value::Missing);
        fields.iter_mut().for_each(|(_, value)| leave_out_missing_in(value));
        // in the order of their keys, as nested ones are
        fields.sort_unstable_by_key(|(key, _)| *key);
        let mut data = Vec::new();
        serde_json::Serializer::new(&mut data)
            .collect_map(fields)
            .expect("texts, numbers and maps with text keys are JSON");
        Self { channel, time, data }
    }
}

fn leave_out_missing(fields: &mut Fields) {
    fields.retain(|_, value| *value != quantities::Value::Missing);
    fields.values_mut().for_each(leave_out_missing_in);
}

fn leave_out_missing_in(value: &mut quantities::Value) {
    match value {
        quantities::Value::Record(fields) => leave_out_missing(fields),
        quantities::Value::List(records) => records.iter_mut().for_each(leave_out_missing),
        _ => {}
    }
}
