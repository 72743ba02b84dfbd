//! The JSON Schemas of the JSON channels.
//!
//! Foxglove reads one plain type a field and refuses lists of types: a field without a value is left out of the message, and the schema does
//! not require it.

use super::channel::Channel;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

/// A channel as a file defines it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Definition {
    /// Topic.
    pub topic: String,
    /// How messages are encoded.
    pub encoding: String,
    /// What is in them; `None` where the file does not say.
    pub schema: Option<SchemaText>,
    /// What else the file says of it.
    pub metadata: BTreeMap<String, String>,
}

/// A schema as a file defines it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SchemaText {
    /// Name.
    pub name: String,
    /// `protobuf` or `jsonschema`.
    pub encoding: String,
    /// A protobuf `FileDescriptorSet`, or the text of a JSON Schema.
    pub data: Vec<u8>,
}

impl Definition {
    /// What this crate defines a channel as.
    pub fn of(channel: Channel) -> Self {
        let schema = channel.schema();
        Self {
            topic: channel.topic().to_owned(),
            encoding: channel.encoding().to_owned(),
            schema: Some(SchemaText {
                name: schema.name,
                encoding: schema.encoding,
                data: schema.data.into_owned(),
            }),
            metadata: BTreeMap::new(),
        }
    }
}

/// A field of a JSON message.
pub(super) struct Field {
    pub key: &'static str,
    pub kind: Kind,
    pub about: &'static str,
}

/// What a field holds.
#[derive(Clone, Copy)]
pub(super) enum Kind {
    Number,
    /// A number, left out where there is none.
    Maybe,
    Count,
    Text,
    /// Text, left out where there is none.
    MaybeText,
    Flag,
    Numbers,
    Record(&'static [Field]),
    List(&'static [Field]),
}

use Kind::{Count, Flag, List, Maybe, MaybeText, Number, Numbers, Record, Text};

const fn field(key: &'static str, kind: Kind, about: &'static str) -> Field {
    Field { key, kind, about }
}

const STEP: Field = field("step", Count, "k, from 0");

const OPTIONS: &[Field] = &[
    STEP,
    field(
        "options",
        List(OPTION),
        "every option as it is from where the team is at the beginning of the step",
    ),
];

const OPTION: &[Field] = &[
    field("name", Text, "name of the option"),
    field("length_m", Maybe, "D_o: length of what is left, m; left out where there is no way"),
    field("risk", Number, "S_o: risk of what is left, 0 to 1"),
    field("objective_m", Number, "J_o = D_o + c_r S_o, eq. (1), m"),
    field(
        "expected_subjective",
        Maybe,
        "J~_o: mean over the robot's belief of the subjective cost, eq. (6), cost units; left out while the human leads",
    ),
    field(
        "probability",
        Maybe,
        "P_o: probability that the human prefers it, eq. (4), 0 to 1; left out where it was not evaluated",
    ),
    field(
        "misaligned",
        Flag,
        "omega_o: whether the team moves toward something else than this option's next opening",
    ),
];

const COORDINATION: &[Field] = &[
    STEP,
    field("stubbornness", Number, "phi(k), eq. (5); the human takes the lead above 1"),
    field("threshold", Number, "what phi is compared with: 1"),
    field("discomfort", Number, "g(k), eq. (5)"),
    field("mode", Text, "robot-led or human-led"),
    field("executed", Text, "name of the option executed"),
    field("executed_index", Count, "its place among the options, from 0"),
    field("preferred", Text, "name of the option that this human would choose from here"),
    field("preferred_index", Count, "its place among the options, from 0"),
    field(
        "steps_back_for",
        MaybeText,
        "the option for which the team steps back, to where there is room to turn onto it; mostly left out",
    ),
    field("x_m", Number, "where the team is at the beginning of the step, world x, m"),
    field("y_m", Number, "the same, world y, m"),
    field("heading_deg", Number, "direction of travel, counter-clockwise from x, degrees"),
];

const CONTROL: &[Field] = &[
    STEP,
    field("position_error_m", Number, "distance between grasp and reference at the end of the step, m"),
    field("orientation_error_deg", Number, "angle between them, degrees"),
    field("tracking_cost", Number, "||x - s||_Q^2 at the end of the step"),
    field("control_effort", Number, "||u||_R^2"),
    field("pose_cost", Number, "kappa ||q* - q_c||^2"),
    field(
        "tracked",
        MaybeText,
        "the option that the robot takes the human to be on; left out while it leads",
    ),
    field(
        "pose_candidate",
        Maybe,
        "the configuration that eq. (8) chose, 0 the present one; left out where it was not asked",
    ),
    field("pose_candidates", Maybe, "|Q|; left out where eq. (8) was not asked"),
    field(
        "pose_constrained_problems",
        Maybe,
        "problems of eq. (8) solved with limits; left out where it was not asked",
    ),
    field(
        "mpc_outcome",
        Text,
        "how eq. (7) was solved: unconstrained, constrained, or fallback with the reason",
    ),
    field("mpc_active_limits", Count, "limits of joints, wheels and obstacles active in its solution"),
    field("mpc_active_guides", Count, "bounds active in it that hold the base to its way; physics only"),
    field("least_singular_value", Number, "least singular value of B(q*), m or rad for a unit input"),
    field(
        "base_clearance_m",
        Maybe,
        "distance of the base to the nearest obstacle at the beginning of the step, m; left out without obstacles",
    ),
    field("rim_speeds_m_per_s", Numbers, "u of the left and the right wheel's rim, m/s"),
    field("joint_rates", Numbers, "u of the joints, in the order of /joints, rad/s (prismatic: m/s)"),
];

const PREPARATION: &[Field] = &[
    STEP,
    field(
        "references",
        List(REFERENCE),
        "what eq. (7) and (8) track: all options while the human leads, else the one executed",
    ),
    field("target", Record(CONFIGURATION), "q*, the configuration that eq. (8) chose, else the present one"),
    field(
        "candidates",
        List(CANDIDATE),
        "Q of eq. (8), the present configuration first; none where it was not asked",
    ),
];

const REFERENCE: &[Field] = &[
    field("name", Text, "name of the option"),
    field("weight", Number, "what it counts for in eq. (8): P_o, if nothing else was asked for"),
    field(
        "s",
        Numbers,
        "s_o(1) to s_o(8), six numbers each: x, y, z (m) and rotation vector (rad), relative to the grasp's present pose, world axes; on the \
         physical plant what is left for the arm while the base follows its way",
    ),
];

const CONFIGURATION: &[Field] = &[
    field("x_m", Number, "where the base is, world x, m"),
    field("y_m", Number, "the same, world y, m"),
    field("yaw_rad", Number, "its heading, rad"),
    field("joints", Numbers, "positions of the joints, in the order of /joints, rad (prismatic: m)"),
];

const CANDIDATE: &[Field] = &[
    field("q", Record(CONFIGURATION), "the configuration"),
    field("lower_bound", Maybe, "the sum of eq. (8) without limits; left out where no costs were asked for"),
    field(
        "total",
        Maybe,
        "the sum of eq. (8) (minus the manipulability, if that is the criterion); left out where it is known to be more than the least without being \
         worked out",
    ),
];

const INTERACTION: &[Field] = &[
    STEP,
    field("grip", Record(GRIP), "what the robot does to the object at its rear end"),
    field("hand", Record(GRIP), "what the human does to the object at its front end"),
    field(
        "squared_jerk_m2_per_s5",
        Number,
        "integral over the step of the square of the object's jerk, m^2/s^5",
    ),
    field("effort_share", Number, "the most that a motor of the arm exerted, as a share of its effort limit"),
    field(
        "obstacle_distance_m",
        Maybe,
        "least distance of robot, object or human to an obstacle at the end of the step, m; left out without obstacles",
    ),
    field("human_distance_m", Maybe, "distance between robot and human at the end of the step, m"),
    field("contacts", Count, "pairs of parts that touched in the step"),
];

const GRIP: &[Field] = &[
    field("force_n", Record(AXES), "mean force over the step, world axes, N"),
    field("torque_nm", Record(AXES), "mean torque over the step, world axes, Nm"),
    field("rms_n", Number, "root mean square of the force's magnitude, N"),
    field("peak_n", Number, "its largest value, N"),
    field("work_j", Number, "work done on the object in the step, J"),
    field("stretch_m", Number, "how far the grip yielded at most, m"),
];

const AXES: &[Field] =
    &[field("x", Number, "along x"), field("y", Number, "along y"), field("z", Number, "along z")];

const COST: &[Field] = &[
    STEP,
    field("objective_m", Number, "J of the option executed, m"),
    field("accumulated_objective_m", Number, "sum of J up to and with this step, m"),
    field("walked_m", Number, "way walked, m"),
    field("control", Maybe, "C so far: tracking + effort + pose; left out without a robot"),
    field("tracking", Maybe, "sum of ||x - s||_Q^2; left out without a robot"),
    field("effort", Maybe, "sum of ||u||_R^2; left out without a robot"),
    field("pose", Maybe, "sum of kappa ||q* - q_c||^2; left out without a robot"),
    field("robot_work_j", Maybe, "work that the robot did on the object, J; left out without physics"),
    field("human_work_j", Maybe, "work that the human did on the object, J; left out without physics"),
];

const OUTCOME: &[Field] = &[
    field(
        "outcome",
        Text,
        "arrived, out-of-time, no-way, collided, stuck, dropped, object-lost, non-finite, or interrupted by the user",
    ),
    field("steps", Count, "steps taken"),
    field("time_s", Number, "simulated time, s"),
    field("walked_m", Number, "way walked, m"),
    field("accumulated_objective_cost_m", Number, "sum of J of the option executed, m"),
    field("first_option", Text, "name of the option executed first"),
    field("last_option", Text, "name of the option executed last"),
    field("changes", Count, "how often the executed option changed"),
    field("transition_step", Maybe, "k at which the human took the lead; left out if not"),
    field("final_stubbornness", Number, "phi in the last step"),
    field("final_discomfort", Number, "g in the last step"),
    field(
        "share_off_preference",
        Number,
        "share of the steps off the option that this human preferred, 0 to 1",
    ),
    field(
        "accumulated_subjective_cost",
        Number,
        "sum of J^ of the option executed, eq. (2), with this human's alpha and gamma; cost units",
    ),
    field("lost_by", MaybeText, "robot or human, if the object was lost; else left out"),
    field("lost_at_step", Maybe, "k at which it was lost; left out if not"),
    field(
        "lost_distance_m",
        Maybe,
        "how far off the grasp was then, or its grip yielded, m; left out if not",
    ),
    field("control_cost", Maybe, "C; left out without a robot"),
    field(
        "position_error_rms_m",
        Maybe,
        "root mean square distance between grasp and reference, m; left out without a robot",
    ),
    field(
        "hand_force_rms_n",
        Maybe,
        "root mean square of the human's force on the object, N; left out without physics",
    ),
    field("peak_force_n", Maybe, "largest force in either grip, N; left out without physics"),
];

/// The fields of a JSON channel; none of the others.
pub(super) fn fields(channel: Channel) -> &'static [Field] {
    match channel {
        Channel::Options => OPTIONS,
        Channel::Coordination => COORDINATION,
        Channel::Control => CONTROL,
        Channel::Preparation => PREPARATION,
        Channel::Interaction => INTERACTION,
        Channel::Cost => COST,
        Channel::Outcome => OUTCOME,
        _ => &[],
    }
}

/// The JSON Schema of messages with these fields.
pub(super) fn json_schema(title: &str, fields: &[Field]) -> Value {
    let mut schema = record(fields);
    schema.insert("$schema".to_owned(), json!("https://json-schema.org/draft/2020-12/schema"));
    schema.insert("title".to_owned(), json!(title));
    Value::Object(schema)
}

fn record(fields: &[Field]) -> Map<String, Value> {
    let properties: Map<String, Value> =
        fields.iter().map(|field| (field.key.to_owned(), Value::Object(property(field)))).collect();
    let is_required = |field: &&Field| !matches!(field.kind, Maybe | MaybeText);
    let required: Vec<&str> = fields.iter().filter(is_required).map(|field| field.key).collect();
    let schema = [
        ("type".to_owned(), json!("object")),
        ("properties".to_owned(), Value::Object(properties)),
        ("required".to_owned(), json!(required)),
    ];
    schema.into_iter().collect()
}

fn property(field: &Field) -> Map<String, Value> {
    let plain = |name: &str| Map::from_iter([("type".to_owned(), json!(name))]);
    let list =
        |items: Value| Map::from_iter([("type".to_owned(), json!("array")), ("items".to_owned(), items)]);
    let mut property = match field.kind {
        Number | Maybe => plain("number"),
        Count => plain("integer"),
        Text | MaybeText => plain("string"),
        Flag => plain("boolean"),
        Numbers => list(json!({ "type": "number" })),
        Record(fields) => record(fields),
        List(fields) => list(Value::Object(record(fields))),
    };
    property.insert("description".to_owned(), json!(field.about));
    property
}
