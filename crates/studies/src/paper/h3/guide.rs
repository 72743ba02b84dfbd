//! The least guide: how much of the base's inputs eqs. (7) and (8) can decide with bodies.
//!
//! On the physical plant, a guide follows the path of the grasp with the base. Here its price falls from the
//! default to none, or none is paid within a width, and Table III is run with the same humans each time.

use super::{PoseMethod, PoseRow, Study, units};
use crate::parallel::OnDone;
use cocarry::Error;
use cocarry::control::{self, GUIDE_PRICE};
use cocarry::episode::Settings;
use cocarry::robot::Robot;
use cocarry::scenario::{Plant, PlantKind, RobotSetup};
use serde::Serialize;

/// What guides the base.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Guide {
    /// A price of the squared deviation of the base's inputs from those that follow the path.
    Price {
        /// The price, beside R = 1.
        price: f64,
    },
    /// No price, and a bound: the base is within a width of where following the path would take it.
    Width {
        /// The width along and across, m.
        #[serde(rename = "width_m")]
        width: f64,
    },
    /// The kinematic plant, whose base nothing guides.
    Free,
}

impl Guide {
    /// All that are compared, the default first.
    pub const ALL: [Self; 11] = [
        Self::Price { price: GUIDE_PRICE },
        Self::Price { price: 1000.0 },
        Self::Price { price: 100.0 },
        Self::Price { price: 30.0 },
        Self::Price { price: 10.0 },
        Self::Price { price: 1.0 },
        Self::Price { price: 0.0 },
        Self::Width { width: 0.05 },
        Self::Width { width: 0.1 },
        Self::Width { width: 0.2 },
        Self::Free,
    ];

    /// A name for tables.
    pub fn name(self) -> String {
        match self {
            Self::Price { price } => format!("price {price}"),
            Self::Width { width } => format!("within {width} m"),
            Self::Free => "kinematic, free".to_owned(),
        }
    }

    fn plant(self, robot: &Robot) -> Plant {
        let default = control::Settings::default();
        let (kind, control) = match self {
            Self::Price { price } => (PlantKind::Rapier, control::Settings { guide_price: price, ..default }),
            Self::Width { width } => {
                (PlantKind::Rapier, control::Settings { guide_price: 0.0, guide_width: width, ..default })
            }
            Self::Free => (PlantKind::Kinematic, default),
        };
        Plant::new(kind, RobotSetup { control, ..RobotSetup::new(robot) })
    }
}

/// Table III with one guide: means over the cells of Table III with episodes that arrived.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GuideRow {
    /// The guide.
    pub guide: Guide,
    /// Episodes, with and without pose optimisation together.
    pub episodes: usize,
    /// Those that arrived.
    pub arrived: usize,
    /// Those in which something touched an obstacle; on the kinematic plant, in which the base overlapped one.
    pub collided: usize,
    /// Those in which the object was lost.
    pub lost_object: usize,
    /// Smallest distance between the base and an obstacle in an episode, m: negative where they overlap.
    #[serde(rename = "least_clearance_m")]
    pub least_clearance: f64,
    /// Parts of C without and with pose optimisation: tracking, wheels, arm, pose.
    pub parts: [[f64; 4]; 2],
    /// Tracking against the human's intended walk, without and with pose optimisation.
    pub intended_tracking: [f64; 2],
    /// The ratio of C with to C without pose optimisation, mean over the cells.
    pub ratio: Option<f64>,
    /// The same with tracking against the intended walk.
    pub intended_ratio: Option<f64>,
}

/// The methods of a row.
const METHODS: [PoseMethod; 2] = [PoseMethod::WithoutPo, PoseMethod::WithPo];

/// Episodes of the study, for a progress bar.
pub fn episodes(per_cell: usize) -> usize {
    Guide::ALL.len() * units(&METHODS, 1, per_cell)
}

/// Table III with every guide, from the robot's first posture.
///
/// # Errors
/// If a built-in world is not valid.
pub fn table(
    robot: &Robot,
    settings: &Settings,
    episodes: usize,
    seed: u64,
    on_done: OnDone,
) -> Result<Vec<GuideRow>, Error> {
    let start = robot.postures[0].name.as_str();
    let rows = Guide::ALL.into_iter().map(|guide| {
        let plant = &guide.plant(robot);
        let study = Study { plant, starts: &[start], methods: &METHODS, episodes, seed, settings };
        Ok(row(guide, &study.table(on_done)?))
    });
    rows.collect()
}

fn row(guide: Guide, rows: &[PoseRow]) -> GuideRow {
    let of = |method| rows.iter().filter(move |row| row.method == method);
    let sum = |count: fn(&PoseRow) -> usize| rows.iter().map(count).sum::<usize>();
    // cells without a pair that arrived have no costs
    let mean = |method: PoseMethod, value: &dyn Fn(&PoseRow) -> f64| {
        let values: Vec<f64> = of(method).map(value).filter(|v| v.is_finite()).collect();
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    };
    let both = |value: &dyn Fn(&PoseRow) -> f64| METHODS.map(|m| mean(m, value).unwrap_or(f64::NAN));
    let parts = [0, 1, 2, 3].map(|part| both(&|row: &PoseRow| row.split[part]));
    GuideRow {
        guide,
        episodes: sum(|row| row.episodes),
        arrived: sum(|row| row.episodes - row.not_arrived),
        collided: match guide {
            Guide::Free => sum(|row| row.overlapping_episodes),
            _ => sum(|row| row.collided),
        },
        lost_object: sum(|row| row.lost_object),
        least_clearance: rows.iter().map(|row| row.least_clearance).fold(f64::INFINITY, f64::min),
        parts: [0, 1].map(|method| parts.map(|part| part[method])),
        intended_tracking: both(&|row: &PoseRow| row.intended_tracking),
        ratio: mean(PoseMethod::WithPo, &|row| row.ratio),
        intended_ratio: mean(PoseMethod::WithPo, &|row| row.intended_ratio),
    }
}
