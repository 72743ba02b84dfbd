//! The weights and choices of eqs. (7) and (8), with the paper's values as defaults.

use super::{Avoid, CandidateSet, GUIDE_PRICE};
use serde::{Deserialize, Serialize};

/// A distance from the guide that bounds nothing, m.
pub const GUIDE_WIDTH_M: f64 = 1e6;

// scenarios from before these settings do not have them, and a default value is not written
fn guide_price() -> f64 {
    GUIDE_PRICE
}

fn is_guide_price(price: &f64) -> bool {
    *price == GUIDE_PRICE
}

fn guide_width() -> f64 {
    GUIDE_WIDTH_M
}

fn is_guide_width(width: &f64) -> bool {
    *width == GUIDE_WIDTH_M
}

/// The settings of the controller.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControlSettings {
    /// q of Q = q I_6.
    pub state_weight: f64,
    /// r of R = r I.
    pub input_weight: f64,
    /// kappa of eq. (8).
    pub pose_weight: f64,
    /// The kind of candidates of eq. (8).
    pub candidates: CandidateSet,
    /// The criterion of eq. (8).
    pub criterion: PoseCriterion,
    /// Whether eq. (8) also chooses the configuration while the robot leads, to prepare for the path ahead.
    /// In the paper it does not.
    pub prepare_while_leading: bool,
    /// The parts of the robot that are kept off obstacles. The paper's eq. (7) has no obstacles.
    pub avoid: Avoid,
    /// Weight of the squared deviation (m/s, rad/s) of the base's inputs from those that follow the path of the
    /// grasp, on the physical plant. Below the default, eq. (8) decides them as well.
    #[serde(default = "guide_price", skip_serializing_if = "is_guide_price")]
    pub guide_price: f64,
    /// The farthest (m) that the base may be, along or across, from where following that path would take it.
    /// It is a bound of eq. (7) with the price of an obstacle's; by default it is so large that it bounds
    /// nothing.
    #[serde(default = "guide_width", skip_serializing_if = "is_guide_width")]
    pub guide_width: f64,
    /// How sharply a walking direction distinguishes options: the concentration of a von Mises distribution
    /// about an option's direction.
    pub direction_concentration: f64,
}

impl Default for ControlSettings {
    /// Sec. V-C: Q = 1000 I_6, R = I_9, kappa = 1; |Q| = 15 arm configurations. The concentration corresponds
    /// to directions known to about 13 degrees.
    fn default() -> Self {
        Self {
            state_weight: 1000.0,
            input_weight: 1.0,
            pose_weight: 1.0,
            candidates: CandidateSet::Arm,
            criterion: PoseCriterion::Expected,
            prepare_while_leading: false,
            avoid: Avoid::Robot,
            guide_price: GUIDE_PRICE,
            guide_width: GUIDE_WIDTH_M,
            direction_concentration: 20.0,
        }
    }
}

impl ControlSettings {
    /// Whether the guide alone decides the base's inputs, and eq. (8) takes them as given.
    pub fn is_base_given(&self) -> bool {
        self.guide_price >= GUIDE_PRICE
    }
}

/// The criterion of eq. (8).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PoseCriterion {
    /// Eq. (8): the options' costs, weighted by P_o.
    Expected,
    /// Eq. (8) with the same weight for every option.
    Uniform,
    /// Eq. (8) for the tracked option only.
    Tracked,
    /// Not eq. (8): the largest manipulability sqrt(det(J J')) of the arm (Yoshikawa 1985).
    Manipulability,
}
