//! The table of an episode's settings: every key, range, word and sentence of help is declared here, once.
//!
//! The command line, study files, columns of results, baselines and the check of a scenario derive from
//! [`SETTINGS`]. The table does not have the other parts of a scenario: seed, world, human, preference
//! changes, belief, plant and robot.

use super::setting::{Applies, Field, Range, Setting, SettingGroup, SettingKind};
use super::word::{AVOIDED, BELIEFS, CRITERIA, POSES, put, word, words};
use crate::human::{MODELS, ModelName};
use crate::policy::Method;
use crate::preference::{MAX_LAPSE_RATE, MAX_PERCEPTION, MAX_RATIONALITY};
use crate::simulation::{HumanSettings, PhysicsSettings};
use crate::suggestion::Expected;

/// The range of alpha and gamma.
pub const PERCEPTION: Range = Range::above(0.0, MAX_PERCEPTION);
const PERIODS: Range = Range::between(0.01, 60.0);
/// A former key and flag, and what to give in their place.
pub const PERIOD: [&str; 3] = [
    "period_s",
    "period",
    "given as planning_step_s (--planning-step), the step of phi, g and J, or as control_period_s (--control-period), the period of eqs. (7) and (8); this former setting was both",
];
const POSITIVE: Range = Range::above(0.0, 1e6);
const NOT_NEGATIVE: Range = Range::between(0.0, 1e6);

/// The [`Field`] of a place in a scenario, in its robot or in its physics, optionally with words for the
/// values of an enum.
macro_rules! field {
    (scenario $s:ident => $place:expr) => {
        Field { get: |$s| Some($place), set: |$s, value| $place = value }
    };
    (robot $r:ident => $place:expr) => {
        Field {
            get: |s| s.plant.robot_setup().map(|$r| $place),
            set: |s, value| s.plant.robot_setup_mut().into_iter().for_each(|$r| $place = value),
        }
    };
    (physics $p:ident => $place:expr) => {
        Field {
            get: |s| s.plant.physics().map(|$p| $place),
            set: |s, value| s.plant.physics_mut().into_iter().for_each(|$p| $place = value),
        }
    };
    (robot $r:ident => $place:expr, $words:ident) => {
        Field {
            get: |s| s.plant.robot_setup().and_then(|$r| word($words, $place)),
            set: |s, word| {
                s.plant.robot_setup_mut().into_iter().for_each(|$r| put(&mut $place, $words, &word))
            },
        }
    };
}

/// c_r of eq. (2).
pub const RISK_WEIGHT: Setting = Setting {
    key: "risk_weight_m",
    flag: "risk-weight",
    path: "settings.predictor.risk_weight_m",
    group: SettingGroup::Method,
    about: "Weight c_r of risk against distance, in metres",
    applies: Applies::Always,
    kind: SettingKind::Number(
        "m",
        NOT_NEGATIVE,
        Field {
            get: |s| Some(s.settings.predictor.risk_weight()),
            // fails only outside the range
            set: |s, value| drop(s.settings.predictor.set_risk_weight(value)),
        },
    ),
};

/// l of P'_o = (1 - l) P_o + l / n.
pub const BELIEF_LAPSE: Setting = Setting {
    key: "belief_lapse",
    flag: "belief-lapse",
    path: "settings.predictor.lapse_rate",
    group: SettingGroup::Method,
    about: "Lapse rate l of the robot's belief: with probability l, a human takes any option. Above 0, a robot that learns uses the same rate for its sightings",
    applies: Applies::Always,
    kind: SettingKind::Number(
        "",
        Range::between(0.0, MAX_LAPSE_RATE),
        Field {
            get: |s| Some(s.settings.predictor.lapse_rate()),
            set: |s, lapse_rate| {
                // fails only outside the range
                drop(s.settings.predictor.set_lapse_rate(lapse_rate));
                s.settings.learning = s.settings.learning.map(|learning| learning.assuming(lapse_rate));
            },
        },
    ),
};

/// beta of a belief in Boltzmann humans.
pub const BELIEF_RATIONALITY: Setting = Setting {
    key: "belief_rationality",
    flag: "belief-rationality",
    path: "settings.predictor.rationality",
    group: SettingGroup::Method,
    about: "Rationality beta of the robot's belief: P_o is that of humans who choose with probability proportional to exp(-beta J^), as boltzmann(beta) does [default: infinite, eq. (4)]",
    applies: Applies::Always,
    kind: SettingKind::Number(
        "",
        Range::above(0.0, MAX_RATIONALITY),
        Field {
            get: |s| s.settings.predictor.rationality(),
            // fails only outside the range
            set: |s, rationality| drop(s.settings.predictor.set_rationality(Some(rationality))),
        },
    ),
};

/// The robot's posture at the start.
pub const POSTURE: Setting = Setting {
    key: "posture",
    flag: "posture",
    path: "plant.posture",
    group: SettingGroup::Robot,
    about: "Posture at the start, by its name in the robot file [default: the first]",
    applies: Applies::Robot,
    kind: SettingKind::Text(
        || "the name of a posture".into(),
        |text| !text.is_empty(),
        Field {
            get: |s| s.plant.robot_setup().map(|robot| robot.posture.clone()).filter(|name| !name.is_empty()),
            set: |s, name| {
                s.plant.robot_setup_mut().into_iter().for_each(|robot| robot.posture.clone_from(&name))
            },
        },
    ),
};

/// The parts of the robot that eq. (7) keeps out of obstacles.
pub const AVOID: Setting = Setting {
    key: "avoid",
    flag: "avoid",
    path: "control.avoid",
    group: SettingGroup::Control,
    about: "Parts of the robot that its MPC keeps out of obstacles",
    applies: Applies::Robot,
    kind: SettingKind::Word(|| words(AVOIDED), field!(robot r => r.control.avoid, AVOIDED)),
};

/// The sway of the human's hand.
pub const SWAY: Setting = Setting {
    key: "sway_m",
    flag: "sway",
    path: "physics.human.sway_lateral_m",
    group: SettingGroup::Human,
    about: "Amplitude of the human hand's lateral sway with the gait, in metres; half of it vertically",
    applies: Applies::Bodies,
    kind: SettingKind::Number(
        "m",
        Range::of(HumanSettings::SWAYS),
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

/// The planning step k.
pub const PLANNING_STEP: Setting = Setting {
    key: "planning_step_s",
    flag: "planning-step",
    path: "settings.period_s",
    group: SettingGroup::Walk,
    about: "Planning step k, in seconds: phi, g, J and sightings count in it, so an eta is for one planning step",
    applies: Applies::Always,
    kind: SettingKind::Number("s", PERIODS, field!(scenario s => s.settings.planning_step)),
};

/// phi(0) of eq. (5).
pub const INITIAL_STUBBORNNESS: Setting = Setting {
    key: "initial_stubbornness",
    flag: "initial-stubbornness",
    path: "settings.coordination.initial_stubbornness",
    group: SettingGroup::Human,
    about: "Stubbornness phi(0) at the start",
    applies: Applies::Always,
    kind: SettingKind::Number(
        "",
        Range::above(0.0, 1.0),
        field!(scenario s => s.settings.coordination.initial_stubbornness),
    ),
};

/// Candidates of eq. (8).
pub const POSE: Setting = Setting {
    key: "pose",
    flag: "pose",
    path: "control.candidates",
    group: SettingGroup::Control,
    about: "Configurations that pose optimisation chooses among while the human leads",
    applies: Applies::Robot,
    kind: SettingKind::Word(|| words(POSES), field!(robot r => r.control.candidates, POSES)),
};

/// What a robot that leads does not decide by eq. (6): for stimuli.
const LEAD_OPTION: Setting = Setting {
    key: "lead_option",
    flag: "lead-option",
    path: "settings.lead_option",
    group: SettingGroup::Method,
    about: "Option on which the robot leads, by its number in `cocarry world` [default: the best by eq. (6)]",
    applies: Applies::Always,
    kind: SettingKind::Count(1_000_000, field!(scenario s => s.settings.lead_option)),
};

/// All settings. A study varies the last ones fastest.
pub const SETTINGS: &[Setting] = &[
    RISK_WEIGHT,
    Setting {
        key: "human_model",
        flag: "human",
        path: "human_model",
        group: SettingGroup::Human,
        about: "Model of the human: preference, boltzmann(RATIONALITY) or scripted(STEP:OPTION,...)",
        applies: Applies::Always,
        kind: SettingKind::Text(
            || Expected::one_of(MODELS.map(|model| model.form)),
            |text| text.parse::<ModelName>().is_ok(),
            Field {
                get: |s| Some(s.human_model.to_string()),
                set: |s, text| s.human_model = text.parse().expect("a model that the setting accepts"),
            },
        ),
    },
    PLANNING_STEP,
    Setting {
        key: "control_period_s",
        flag: "control-period",
        path: "settings.control_period_s",
        group: SettingGroup::Control,
        about: "Control period of eqs. (7) and (8), in seconds, a whole fraction of the planning step [default: the planning step]",
        applies: Applies::Always,
        kind: SettingKind::Number(
            "s",
            PERIODS,
            Field {
                get: |s| s.settings.control_period,
                set: |s, value| s.settings.control_period = Some(value),
            },
        ),
    },
    Setting {
        key: "speed_m_per_s",
        flag: "speed",
        path: "settings.speed_m_per_s",
        group: SettingGroup::Walk,
        about: "Walking speed of the team, in metres per second",
        applies: Applies::Always,
        kind: SettingKind::Number("m/s", Range::between(0.001, 10.0), field!(scenario s => s.settings.speed)),
    },
    Setting {
        key: "yaw_rate_rad_per_s",
        flag: "yaw-rate",
        path: "settings.yaw_rate_rad_per_s",
        group: SettingGroup::Walk,
        about: "Largest yaw rate of the human, in radians per second",
        applies: Applies::Always,
        kind: SettingKind::Number(
            "rad/s",
            Range::above(0.0, 1000.0),
            field!(scenario s => s.settings.yaw_rate),
        ),
    },
    Setting {
        key: "max_steps",
        flag: "max-steps",
        path: "settings.tick_limit",
        group: SettingGroup::Walk,
        about: "Largest number of steps [default: ten times the steps of the longest option]",
        applies: Applies::Always,
        kind: SettingKind::Count(1_000_000_000, field!(scenario s => s.settings.tick_limit)),
    },
    POSTURE,
    Setting {
        key: "state_weight",
        flag: "state-weight",
        path: "control.state_weight",
        group: SettingGroup::Control,
        about: "Weight of the grasp error in eq. (7): Q is this number times the identity",
        applies: Applies::Robot,
        kind: SettingKind::Number("", POSITIVE, field!(robot r => r.control.state_weight)),
    },
    Setting {
        key: "input_weight",
        flag: "input-weight",
        path: "control.input_weight",
        group: SettingGroup::Control,
        about: "Weight of the inputs in eq. (7): R is this number times the identity",
        applies: Applies::Robot,
        kind: SettingKind::Number("", POSITIVE, field!(robot r => r.control.input_weight)),
    },
    AVOID,
    Setting {
        key: "physics_rate_hz",
        flag: "physics-rate",
        path: "physics.rate_hz",
        group: SettingGroup::Physics,
        about: "Physics steps per second; a control period takes a whole number of them, and the remainder goes into the next",
        applies: Applies::Bodies,
        kind: SettingKind::Number("Hz", Range::of(PhysicsSettings::RATES), field!(physics p => p.rate_hz)),
    },
    Setting {
        key: "solver_iterations",
        flag: "solver-iterations",
        path: "physics.solver_iterations",
        group: SettingGroup::Physics,
        about: "Solver iterations in a physics step over grips and contacts; arm and base are solved exactly",
        applies: Applies::Bodies,
        kind: SettingKind::Count(
            PhysicsSettings::MAX_ITERATIONS as u64,
            Field {
                get: |s| s.plant.physics().map(|physics| Some(physics.solver_iterations as u64)),
                set: |s, count| {
                    if let (Some(physics), Some(count)) = (s.plant.physics_mut(), count) {
                        physics.solver_iterations = count as usize;
                    }
                },
            },
        ),
    },
    Setting {
        key: "rim_acceleration_m_per_s2",
        flag: "rim-acceleration",
        path: "physics.rim_acceleration_m_per_s2",
        group: SettingGroup::Physics,
        about: "Largest acceleration of a wheel's rim, in metres per second squared",
        applies: Applies::Bodies,
        kind: SettingKind::Number(
            "m/s^2",
            Range::of(PhysicsSettings::RIM_ACCELERATIONS),
            field!(physics p => p.rim_acceleration),
        ),
    },
    Setting {
        key: "gripper_stiffness_n_per_m",
        flag: "gripper-stiffness",
        path: "physics.gripper_stiffness_n_per_m",
        group: SettingGroup::Physics,
        about: "Linear stiffness of the gripper's hold on the object, in newtons per metre; the angular one is in proportion, the damping critical",
        applies: Applies::Bodies,
        kind: SettingKind::Number(
            "N/m",
            Range::of(PhysicsSettings::GRIPPER_STIFFNESSES),
            field!(physics p => p.gripper_stiffness),
        ),
    },
    Setting {
        key: "hand_stiffness_n_per_m",
        flag: "hand-stiffness",
        path: "physics.human.hand_stiffness_n_per_m",
        group: SettingGroup::Physics,
        about: "Linear stiffness of the human's hold on the object, in newtons per metre; the angular one is in proportion, the damping critical",
        applies: Applies::Bodies,
        kind: SettingKind::Number(
            "N/m",
            Range::of(HumanSettings::HAND_STIFFNESSES),
            field!(physics p => p.human.hand_stiffness),
        ),
    },
    Setting {
        key: "hand_speed_limit_m_per_s",
        flag: "hand-speed-limit",
        path: "physics.human.speed_limit_m_per_s",
        group: SettingGroup::Human,
        about: "Largest speed of the human's hand, in metres per second",
        applies: Applies::Bodies,
        kind: SettingKind::Number(
            "m/s",
            Range::of(HumanSettings::SPEED_LIMITS),
            field!(physics p => p.human.speed_limit),
        ),
    },
    Setting {
        key: "hand_acceleration_limit_m_per_s2",
        flag: "hand-acceleration-limit",
        path: "physics.human.acceleration_limit_m_per_s2",
        group: SettingGroup::Human,
        about: "Largest acceleration of the human's hand, in metres per second squared",
        applies: Applies::Bodies,
        kind: SettingKind::Number(
            "m/s^2",
            Range::of(HumanSettings::ACCELERATION_LIMITS),
            field!(physics p => p.human.acceleration_limit),
        ),
    },
    Setting {
        key: "step_frequency_hz",
        flag: "step-frequency",
        path: "physics.human.step_frequency_hz",
        group: SettingGroup::Human,
        about: "Frequency of the lateral sway, in hertz; the vertical sway is twice as fast",
        applies: Applies::Bodies,
        kind: SettingKind::Number(
            "Hz",
            Range::of(HumanSettings::STEP_FREQUENCIES),
            field!(physics p => p.human.step_frequency),
        ),
    },
    SWAY,
    INITIAL_STUBBORNNESS,
    Setting {
        key: "eta",
        flag: "eta",
        path: "settings.coordination.eta",
        group: SettingGroup::Human,
        about: "Tolerance eta of the human: the larger, the more slowly stubbornness grows (paper: 5, 10.5, 15)",
        applies: Applies::Always,
        kind: SettingKind::Number("", POSITIVE, field!(scenario s => s.settings.coordination.eta)),
    },
    Setting {
        key: "method",
        flag: "method",
        path: "settings.method",
        group: SettingGroup::Method,
        about: "Method: who leads, and on which option",
        applies: Applies::Always,
        kind: SettingKind::Word(
            || Method::all().map(|method| (method.name(), method.about())).collect(),
            Field {
                get: |s| Some(s.settings.method.to_string()),
                set: |s, word| s.settings.method = word.parse().unwrap_or(s.settings.method),
            },
        ),
    },
    LEAD_OPTION,
    POSE,
    Setting {
        key: "pose_criterion",
        flag: "pose-criterion",
        path: "control.criterion",
        group: SettingGroup::Control,
        about: "Criterion of pose optimisation",
        applies: Applies::Candidates,
        kind: SettingKind::Word(|| words(CRITERIA), field!(robot r => r.control.criterion, CRITERIA)),
    },
    Setting {
        key: "pose_weight",
        flag: "pose-weight",
        path: "control.pose_weight",
        group: SettingGroup::Control,
        about: "Weight kappa of a change of configuration in eq. (8)",
        applies: Applies::Robot,
        kind: SettingKind::Number("", NOT_NEGATIVE, field!(robot r => r.control.pose_weight)),
    },
    Setting {
        key: "direction_concentration",
        flag: "direction-concentration",
        path: "control.direction_concentration",
        group: SettingGroup::Control,
        about: "Concentration of the von Mises distribution of the walking direction on an option",
        applies: Applies::Robot,
        kind: SettingKind::Number("", NOT_NEGATIVE, field!(robot r => r.control.direction_concentration)),
    },
    Setting {
        key: "guide_price",
        flag: "guide-price",
        path: "control.guide_price",
        group: SettingGroup::Control,
        about: "Weight of the squared deviation of the base's inputs from those that follow the path; below 10000, eq. (8) decides them as well; at most 100 counts of an omnidirectional robot whose arm cannot move the grasp in every direction of the plane",
        applies: Applies::Bodies,
        kind: SettingKind::Number("", NOT_NEGATIVE, field!(robot r => r.control.guide_price)),
    },
    Setting {
        key: "guide_width_m",
        flag: "guide-width",
        path: "control.guide_width",
        group: SettingGroup::Control,
        about: "How far the base may be from where following the path takes it, in metres; 1000000: no bound",
        applies: Applies::Bodies,
        kind: SettingKind::Number("m", POSITIVE, field!(robot r => r.control.guide_width)),
    },
    Setting {
        key: "prepare_while_leading",
        flag: "prepare-while-leading",
        path: "control.prepare_while_leading",
        group: SettingGroup::Control,
        about: "Optimise the pose also while the robot leads, for its own path; the paper does so only while it follows",
        applies: Applies::Candidates,
        kind: SettingKind::Flag(field!(robot r => r.control.prepare_while_leading)),
    },
    Setting {
        key: "belief_update",
        flag: "belief",
        path: "settings.learning",
        group: SettingGroup::Method,
        about: "The robot's belief during the episode",
        applies: Applies::Always,
        kind: SettingKind::Word(
            || words(BELIEFS),
            Field {
                get: |s| word(BELIEFS, s.settings.learning.is_some()),
                set: |s, text| {
                    let mut learns = false;
                    put(&mut learns, BELIEFS, &text);
                    let lapse_rate = s.settings.predictor.lapse_rate();
                    let given = s.settings.learning.unwrap_or_default().assuming(lapse_rate);
                    s.settings.learning = learns.then_some(given);
                },
            },
        ),
    },
    BELIEF_LAPSE,
    BELIEF_RATIONALITY,
];
