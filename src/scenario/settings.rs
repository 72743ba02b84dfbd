//! The table of an episode's settings: every key, range, word and sentence of help is declared here, once.
//!
//! The command line, study files, columns of results, baselines and the check of a scenario derive from
//! [`SETTINGS`]. The table does not have the other parts of a scenario: seed, world, human, preference
//! changes, belief, plant and robot.

use super::word::{AVOIDED, CRITERIA, POSES, Word, one_of, put, word, words};
use super::{PlantKind, Scenario};
use crate::human::{MODELS, ModelName};
use crate::policy::Method;
use crate::preference::LARGEST_PERCEPTION;
use crate::suggestion::hint_of_listed;
use std::fmt;

/// A setting of an episode.
#[derive(Debug)]
pub struct Setting {
    /// Its key in studies and their results, with the unit.
    pub key: &'static str,
    /// Its name on the command line, without the dashes.
    pub flag: &'static str,
    /// Its key in a scenario's text, with the tables around it.
    pub path: &'static str,
    /// The part of the help and of the documentation that it belongs to.
    pub group: Group,
    /// Its help text, with its unit.
    pub about: &'static str,
    /// The teams to which it applies.
    pub applies: Applies,
    /// Its values, and its field in a scenario.
    pub kind: Kind,
}

/// The part of the help that a setting belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// The human.
    Human,
    /// The robot and the plant.
    Robot,
    /// The method, and how it weighs risk.
    Method,
    /// How the team walks.
    Walk,
    /// The robot's controller.
    Control,
}

impl Group {
    /// Its title.
    pub const fn title(self) -> &'static str {
        match self {
            Self::Human => "Human",
            Self::Robot => "Robot and plant",
            Self::Method => "Method",
            Self::Walk => "Walk",
            Self::Control => "Robot's controller",
        }
    }
}

/// The teams to which a setting applies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Applies {
    /// Every team.
    Always,
    /// A robot.
    Robot,
    /// A robot that chooses among configurations.
    Candidates,
    /// A human with a body.
    Bodies,
}

/// The values of a setting, and its field in a scenario.
#[derive(Debug)]
pub enum Kind {
    /// A number in a range.
    Number(Range, Field<f64>),
    /// A whole number from 1 to a limit.
    Count(u64, Field<Option<u64>>),
    /// True or false.
    Flag(Field<bool>),
    /// One of several words.
    Word(fn() -> Vec<Word>, Field<String>),
    /// A text: the form to name in errors, and a check.
    Text(fn() -> String, fn(&str) -> bool, Field<String>),
}

/// A field of a scenario: a getter, which returns `None` if the scenario does not have the field, and a
/// setter.
#[derive(Debug)]
pub struct Field<T> {
    get: fn(&Scenario) -> Option<T>,
    set: fn(&mut Scenario, T),
}

/// The value of a setting.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Of [`Kind::Number`].
    Number(f64),
    /// Of [`Kind::Count`].
    Count(u64),
    /// Of [`Kind::Flag`].
    Flag(bool),
    /// Of [`Kind::Word`] and [`Kind::Text`].
    Text(String),
}

/// A range of numbers from `least`, or above it, to `most`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    least: f64,
    is_open: bool,
    most: f64,
}

/// The range of alpha and gamma.
pub const PERCEPTION: Range = Range::above(0.0, LARGEST_PERCEPTION);
const POSITIVE: Range = Range::above(0.0, 1e6);
const NOT_NEGATIVE: Range = Range::between(0.0, 1e6);

/// The [`Field`] of a place in a scenario or in its robot, optionally with words for the values of an enum.
macro_rules! field {
    (scenario $s:ident => $place:expr) => {
        Field { get: |$s| Some($place), set: |$s, value| $place = value }
    };
    (robot $r:ident => $place:expr) => {
        Field {
            get: |s| s.plant.carrier().map(|$r| $place),
            set: |s, value| s.plant.carrier_mut().into_iter().for_each(|$r| $place = value),
        }
    };
    (robot $r:ident => $place:expr, $words:ident) => {
        Field {
            get: |s| s.plant.carrier().and_then(|$r| word($words, $place)),
            set: |s, word| s.plant.carrier_mut().into_iter().for_each(|$r| put(&mut $place, $words, &word)),
        }
    };
}

/// c_r of eq. (2).
pub const RISK_WEIGHT: Setting = Setting {
    key: "risk_weight_m",
    flag: "risk-weight",
    path: "settings.predictor.risk_weight_m",
    group: Group::Method,
    about: "Weight c_r of risk against distance, in metres",
    applies: Applies::Always,
    kind: Kind::Number(
        NOT_NEGATIVE,
        Field {
            get: |s| Some(s.settings.predictor.risk_weight()),
            // fails only outside the range
            set: |s, value| drop(s.settings.predictor.set_risk_weight(value)),
        },
    ),
};

/// The robot's posture at the start.
pub const POSTURE: Setting = Setting {
    key: "posture",
    flag: "posture",
    path: "plant.posture",
    group: Group::Robot,
    about: "Posture at the start, by its name in the robot file [default: the first]",
    applies: Applies::Robot,
    kind: Kind::Text(
        || "the name of a posture".to_owned(),
        |text| !text.is_empty(),
        Field {
            get: |s| s.plant.carrier().map(|robot| robot.posture.clone()).filter(|name| !name.is_empty()),
            set: |s, name| {
                s.plant.carrier_mut().into_iter().for_each(|robot| robot.posture.clone_from(&name))
            },
        },
    ),
};

/// The parts of the robot that eq. (7) keeps out of obstacles.
pub const AVOID: Setting = Setting {
    key: "avoid",
    flag: "avoid",
    path: "control.avoid",
    group: Group::Control,
    about: "Parts of the robot that its MPC keeps out of obstacles",
    applies: Applies::Robot,
    kind: Kind::Word(|| words(AVOIDED), field!(robot r => r.control.avoid, AVOIDED)),
};

/// The sway of the human's hand.
pub const SWAY: Setting = Setting {
    key: "sway_m",
    flag: "sway",
    path: "physics.human.sway_lateral_m",
    group: Group::Human,
    about: "Amplitude of the human hand's lateral sway with the gait, in metres; half of it vertically",
    applies: Applies::Bodies,
    kind: Kind::Number(
        Range::between(0.0, 0.1),
        Field {
            get: |s| s.plant.physics().map(|physics| physics.human.sway_lateral),
            set: |s, sway| {
                if let Some(physics) = s.plant.physics_mut() {
                    (physics.human.sway_lateral, physics.human.sway_vertical) = (sway, sway / 2.0);
                }
            },
        },
    ),
};

/// phi(0) of eq. (5).
pub const INITIAL_STUBBORNNESS: Setting = Setting {
    key: "initial_stubbornness",
    flag: "initial-stubbornness",
    path: "settings.coordination.initial_stubbornness",
    group: Group::Human,
    about: "Stubbornness phi(0) at the start",
    applies: Applies::Always,
    kind: Kind::Number(
        Range::above(0.0, 1.0),
        field!(scenario s => s.settings.coordination.initial_stubbornness),
    ),
};

/// Candidates of eq. (8).
pub const POSE: Setting = Setting {
    key: "pose",
    flag: "pose",
    path: "control.candidates",
    group: Group::Control,
    about: "Configurations that pose optimisation chooses among while the human leads",
    applies: Applies::Robot,
    kind: Kind::Word(|| words(POSES), field!(robot r => r.control.candidates, POSES)),
};

/// All settings. A study varies the last ones fastest.
pub const SETTINGS: &[Setting] = &[
    RISK_WEIGHT,
    Setting {
        key: "human_model",
        flag: "human",
        path: "human_model",
        group: Group::Human,
        about: "Model of the human: preference, boltzmann(RATIONALITY) or scripted(STEP:OPTION,...)",
        applies: Applies::Always,
        kind: Kind::Text(
            || format!("one of {}", MODELS.map(|model| format!("\"{}\"", model.form)).join(", ")),
            |text| text.parse::<ModelName>().is_ok(),
            Field {
                get: |s| Some(s.human_model.to_string()),
                set: |s, text| s.human_model = text.parse().unwrap_or_default(),
            },
        ),
    },
    Setting {
        key: "period_s",
        flag: "period",
        path: "settings.period_s",
        group: Group::Walk,
        about: "Control period, in seconds; one planning step each",
        applies: Applies::Always,
        kind: Kind::Number(Range::between(0.01, 60.0), field!(scenario s => s.settings.period)),
    },
    Setting {
        key: "speed_m_per_s",
        flag: "speed",
        path: "settings.speed_m_per_s",
        group: Group::Walk,
        about: "Walking speed of the team, in metres per second",
        applies: Applies::Always,
        kind: Kind::Number(Range::between(0.001, 10.0), field!(scenario s => s.settings.speed)),
    },
    Setting {
        key: "yaw_rate_rad_per_s",
        flag: "yaw-rate",
        path: "settings.yaw_rate_rad_per_s",
        group: Group::Walk,
        about: "Largest yaw rate of the human, in radians per second",
        applies: Applies::Always,
        kind: Kind::Number(Range::above(0.0, 1000.0), field!(scenario s => s.settings.yaw_rate)),
    },
    Setting {
        key: "max_steps",
        flag: "max-steps",
        path: "settings.tick_limit",
        group: Group::Walk,
        about: "Largest number of steps [default: ten times the steps of the longest option]",
        applies: Applies::Always,
        kind: Kind::Count(1_000_000_000, field!(scenario s => s.settings.tick_limit)),
    },
    POSTURE,
    Setting {
        key: "state_weight",
        flag: "state-weight",
        path: "control.state_weight",
        group: Group::Control,
        about: "Weight of the grasp error in eq. (7): Q is this number times the identity",
        applies: Applies::Robot,
        kind: Kind::Number(POSITIVE, field!(robot r => r.control.state_weight)),
    },
    Setting {
        key: "input_weight",
        flag: "input-weight",
        path: "control.input_weight",
        group: Group::Control,
        about: "Weight of the inputs in eq. (7): R is this number times the identity",
        applies: Applies::Robot,
        kind: Kind::Number(POSITIVE, field!(robot r => r.control.input_weight)),
    },
    AVOID,
    SWAY,
    INITIAL_STUBBORNNESS,
    Setting {
        key: "eta",
        flag: "eta",
        path: "settings.coordination.eta",
        group: Group::Human,
        about: "Tolerance eta of the human: the larger, the more slowly stubbornness grows (paper: 5, 10.5, 15)",
        applies: Applies::Always,
        kind: Kind::Number(POSITIVE, field!(scenario s => s.settings.coordination.eta)),
    },
    Setting {
        key: "method",
        flag: "method",
        path: "settings.method",
        group: Group::Method,
        about: "Method: who leads, and on which option",
        applies: Applies::Always,
        kind: Kind::Word(
            || Method::all().map(|method| (method.name(), method.about())).collect(),
            Field {
                get: |s| Some(s.settings.method.to_string()),
                set: |s, word| s.settings.method = word.parse().unwrap_or(s.settings.method),
            },
        ),
    },
    POSE,
    Setting {
        key: "pose_criterion",
        flag: "pose-criterion",
        path: "control.criterion",
        group: Group::Control,
        about: "Criterion of pose optimisation",
        applies: Applies::Candidates,
        kind: Kind::Word(|| words(CRITERIA), field!(robot r => r.control.criterion, CRITERIA)),
    },
    Setting {
        key: "pose_weight",
        flag: "pose-weight",
        path: "control.pose_weight",
        group: Group::Control,
        about: "Weight kappa of a change of configuration in eq. (8)",
        applies: Applies::Robot,
        kind: Kind::Number(NOT_NEGATIVE, field!(robot r => r.control.pose_weight)),
    },
    Setting {
        key: "direction_concentration",
        flag: "direction-concentration",
        path: "control.direction_concentration",
        group: Group::Control,
        about: "Concentration of the von Mises distribution of the walking direction on an option",
        applies: Applies::Robot,
        kind: Kind::Number(NOT_NEGATIVE, field!(robot r => r.control.direction_concentration)),
    },
    Setting {
        key: "prepare_while_leading",
        flag: "prepare-while-leading",
        path: "control.prepare_while_leading",
        group: Group::Control,
        about: "Optimise the pose also while the robot leads, for its own path; the paper does so only while it follows",
        applies: Applies::Candidates,
        kind: Kind::Flag(field!(robot r => r.control.prepare_while_leading)),
    },
];

impl Setting {
    /// Its value in a scenario; `None` if the scenario does not have the setting.
    pub fn get(&self, scenario: &Scenario) -> Option<Value> {
        match &self.kind {
            Kind::Number(_, field) => (field.get)(scenario).map(Value::Number),
            Kind::Count(_, field) => (field.get)(scenario)?.map(Value::Count),
            Kind::Flag(field) => (field.get)(scenario).map(Value::Flag),
            Kind::Word(_, field) | Kind::Text(.., field) => (field.get)(scenario).map(Value::Text),
        }
    }

    /// Sets it in a scenario to a value that it [accepts](Setting::accepts). No effect if the scenario does
    /// not have the setting.
    pub fn set(&self, scenario: &mut Scenario, value: &Value) {
        match (&self.kind, value) {
            (Kind::Number(_, field), Value::Number(value)) => (field.set)(scenario, *value),
            (Kind::Count(_, field), Value::Count(value)) => (field.set)(scenario, Some(*value)),
            (Kind::Flag(field), Value::Flag(value)) => (field.set)(scenario, *value),
            (Kind::Word(_, field) | Kind::Text(.., field), Value::Text(text)) => {
                (field.set)(scenario, text.clone());
            }
            _ => {}
        }
    }

    /// Whether the value is allowed.
    pub fn accepts(&self, value: &Value) -> bool {
        match (&self.kind, value) {
            (Kind::Number(range, _), Value::Number(value)) => range.contains(*value),
            (Kind::Count(most, _), Value::Count(value)) => (1..=*most).contains(value),
            (Kind::Flag(_), Value::Flag(_)) => true,
            (Kind::Word(words, _), Value::Text(text)) => words().iter().any(|(word, _)| word == text),
            (Kind::Text(_, accepts, _), Value::Text(text)) => accepts(text),
            _ => false,
        }
    }

    /// Its words; `None` if its values are not words.
    pub fn words(&self) -> Option<Vec<Word>> {
        if let Kind::Word(words, _) = &self.kind { Some(words()) } else { None }
    }

    /// A description of the allowed values, for errors.
    pub fn expected(&self) -> String {
        match &self.kind {
            Kind::Number(range, _) => range.to_string(),
            Kind::Count(most, _) => format!("a whole number from 1 to {most}"),
            Kind::Flag(_) => "true or false".to_owned(),
            Kind::Word(words, _) => one_of(&words()),
            Kind::Text(form, ..) => form(),
        }
    }

    /// The value in a text, as [`Value`] is displayed.
    ///
    /// # Errors
    /// A description of the allowed values, if the text is none of them.
    pub fn parse(&self, text: &str) -> Result<Value, String> {
        let value = match &self.kind {
            Kind::Number(..) => text.parse().ok().map(Value::Number),
            Kind::Count(..) => text.parse().ok().map(Value::Count),
            Kind::Flag(_) => text.parse().ok().map(Value::Flag),
            Kind::Word(..) | Kind::Text(..) => Some(Value::Text(text.to_owned())),
        };
        value.filter(|value| self.accepts(value)).ok_or_else(|| {
            let expected = self.expected();
            format!("must be {expected}{}", hint_of_listed(text, &expected))
        })
    }

    /// The value in a scenario, if it is a number out of range.
    pub(super) fn number_out_of_range(&self, scenario: &Scenario) -> Option<f64> {
        match self.get(scenario).filter(|value| !self.accepts(value))? {
            Value::Number(value) => Some(value),
            Value::Count(count) => Some(count as f64),
            Value::Flag(_) | Value::Text(_) => None,
        }
    }
}

impl Applies {
    /// Whether it applies to a team on that plant. `chooses`: whether the team's robot, if any, chooses among
    /// configurations.
    pub fn is_on(self, plant: PlantKind, chooses: bool) -> bool {
        match self {
            Self::Always => true,
            Self::Robot => plant != PlantKind::Point,
            Self::Candidates => plant != PlantKind::Point && chooses,
            Self::Bodies => plant == PlantKind::Rapier,
        }
    }

    /// What the setting needs, for errors.
    pub fn what(self) -> &'static str {
        match self {
            Self::Always => "a team",
            Self::Robot | Self::Candidates => "a robot",
            Self::Bodies => "a human's body",
        }
    }
}

impl Range {
    const fn between(least: f64, most: f64) -> Self {
        Self { least, is_open: false, most }
    }

    const fn above(least: f64, most: f64) -> Self {
        Self { least, is_open: true, most }
    }

    /// Whether the number is in the range; NaN is not.
    pub fn contains(&self, value: f64) -> bool {
        value <= self.most && if self.is_open { value > self.least } else { value >= self.least }
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { least, is_open, most } = self;
        match is_open {
            true => write!(f, "a number greater than {least} and at most {most}"),
            false => write!(f, "a number from {least} to {most}"),
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Number(value) => value.fmt(f),
            Self::Count(count) => count.fmt(f),
            Self::Flag(flag) => flag.fmt(f),
            Self::Text(text) => text.fmt(f),
        }
    }
}
