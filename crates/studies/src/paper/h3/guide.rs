//! The least guide: how much of the base's inputs eqs. (7) and (8) can decide with bodies.
//!
//! On the physical plant, the base follows the path of the grasp, by a price on the squared deviation of its
//! inputs. Here that price falls from the default to none, or there is none within a width, and Table III and
//! random walled worlds are run with the same humans each time.

use super::{PoseMethod, PoseRow, units};
use crate::paper::cycles::Search;
use crate::paper::placed::Placed;
use crate::parallel::OnDone;
use cocarry::Error;
use cocarry::control::{self, GUIDE_PRICE};
use cocarry::episode::EpisodeSettings;
use cocarry::robot::Robot;
use cocarry::scenario::{Plant, PlantKind, RobotSetup};
use serde::Serialize;

/// What guides the base.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Guide {
    /// A price of the squared deviation of the base's inputs from those that follow the path.
    Price {
        /// The price; R is 1.
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
    pub const ALL: &[Self] = &[
        Self::DEFAULT,
        Self::Price { price: 1000.0 },
        Self::Price { price: 300.0 },
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
    /// Few of them, for a first look.
    pub const FEW: &[Self] =
        &[Self::DEFAULT, Self::Price { price: 100.0 }, Self::Width { width: 0.1 }, Self::Free];
    /// The default guide of the physical plant.
    pub const DEFAULT: Self = Self::Price { price: GUIDE_PRICE };

    /// A name for tables.
    pub fn name(self) -> String {
        match self {
            Self::Price { price } => format!("price {price}"),
            Self::Width { width } => format!("within {width} m"),
            Self::Free => "kinematic, free".to_owned(),
        }
    }

    /// The price, where there is one that is compared.
    pub fn price(self) -> Option<f64> {
        match self {
            Self::Price { price } => Some(price),
            Self::Width { .. } | Self::Free => None,
        }
    }

    fn plant(self, robot: &Robot) -> Plant {
        let default = control::ControlSettings::default();
        let (kind, control) = match self {
            Self::Price { price } => {
                (PlantKind::Rapier, control::ControlSettings { guide_price: price, ..default })
            }
            Self::Width { width } => (
                PlantKind::Rapier,
                control::ControlSettings { guide_price: 0.0, guide_width: width, ..default },
            ),
            Self::Free => (PlantKind::Kinematic, default),
        };
        Plant::new(kind, RobotSetup { control, ..RobotSetup::new(robot) })
    }
}

/// Table III and random worlds with one guide: means over the cells of Table III with pairs that arrived.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GuideRow {
    /// The guide.
    pub guide: Guide,
    /// Episodes of Table III, with and without pose optimisation together.
    pub episodes: usize,
    /// Those that arrived.
    pub arrived: usize,
    /// Those in which something touched an obstacle; on the kinematic plant, in which the base overlapped one.
    pub collided: usize,
    /// Those in which the object was lost.
    pub lost_object: usize,
    /// Smallest distance between the base and an obstacle in them, m: negative where they overlap.
    #[serde(rename = "least_clearance_m")]
    pub least_clearance: f64,
    /// Random walled worlds; `None` on the kinematic plant, where nothing can be touched.
    pub worlds: Option<WorldsRow>,
    /// Parts of C without and with pose optimisation: tracking, wheels, arm, pose.
    pub parts: [[f64; 4]; 2],
    /// Tracking against the human's intended walk, without and with pose optimisation.
    pub intended_tracking: [f64; 2],
    /// The ratio of C with to C without pose optimisation, mean over the cells.
    pub ratio: Option<f64>,
    /// The same with tracking against the intended walk.
    pub intended_ratio: Option<f64>,
}

/// Random walled worlds with one guide.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct WorldsRow {
    /// Worlds.
    pub worlds: usize,
    /// Those in which the team arrived.
    pub arrived: usize,
    /// Those in which it touched an obstacle.
    pub collided: usize,
    /// Those in which the object was lost.
    pub lost_object: usize,
}

impl GuideRow {
    /// Episodes of both kinds, and those that arrived.
    pub fn arrivals(&self) -> [usize; 2] {
        let (worlds, arrived) = self.worlds.map_or((0, 0), |w| (w.worlds, w.arrived));
        [self.episodes + worlds, self.arrived + arrived]
    }

    /// C without and with pose optimisation.
    pub fn costs(&self) -> [f64; 2] {
        self.parts.map(|parts| parts.iter().sum())
    }

    /// C against the intended walk, without and with pose optimisation.
    pub fn intended_costs(&self) -> [f64; 2] {
        [0, 1].map(|method| self.intended_tracking[method] + self.parts[method][1..].iter().sum::<f64>())
    }
}

/// The methods of a row.
const METHODS: [PoseMethod; 2] = [PoseMethod::WithoutPo, PoseMethod::WithPo];

/// The study of the guide.
#[derive(Clone, Copy, Debug)]
pub struct GuideStudy<'a> {
    /// The robot, which starts in its first posture.
    pub robot: &'a Robot,
    /// The episode's settings.
    pub settings: &'a EpisodeSettings,
    /// The guides.
    pub guides: &'a [Guide],
    /// Random humans in each cell of Table III.
    pub episodes: usize,
    /// Random walled worlds.
    pub worlds: usize,
    /// Seed of the humans, and of the first world.
    pub seed: u64,
}

impl GuideStudy<'_> {
    /// Number of episodes, for a progress bar.
    pub fn units(&self) -> usize {
        let with_bodies = self.guides.iter().filter(|guide| **guide != Guide::Free).count();
        self.guides.len() * units(&METHODS, 1, self.episodes) + with_bodies * self.worlds
    }

    /// A row for every guide.
    ///
    /// # Errors
    /// If a built-in world is not valid, or a setting is out of its range.
    pub fn table(&self, on_done: OnDone) -> Result<Vec<GuideRow>, Error> {
        self.guides.iter().map(|guide| self.row(*guide, on_done)).collect()
    }

    fn row(&self, guide: Guide, on_done: OnDone) -> Result<GuideRow, Error> {
        let Self { robot, settings, episodes, worlds, seed, .. } = *self;
        let plant = &guide.plant(robot);
        let start = robot.postures[0].name.as_str();
        let table = super::PoseStudy { plant, starts: &[start], methods: &METHODS, episodes, seed, settings };
        let rows = table.table(on_done)?;
        let worlds = match guide {
            Guide::Free => None,
            _ => {
                let search = Search { plant, settings, worlds, seed, placed: Placed::AsDrawn };
                let found = search.run(on_done)?;
                Some(WorldsRow {
                    worlds: found.episodes,
                    arrived: found.arrived,
                    collided: found.touched.iter().sum(),
                    lost_object: found.lost_object,
                })
            }
        };
        Ok(row(guide, &rows, worlds))
    }
}

fn row(guide: Guide, rows: &[PoseRow], worlds: Option<WorldsRow>) -> GuideRow {
    let of = |method| rows.iter().filter(move |row| row.method == method);
    let sum = |count: fn(&PoseRow) -> usize| rows.iter().map(count).sum::<usize>();
    // cells without a pair that arrived have no costs
    let mean = |method: PoseMethod, value: &dyn Fn(&PoseRow) -> f64| {
        let values: Vec<f64> = of(method).map(value).filter(|v| v.is_finite()).collect();
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    };
    let both = |value: &dyn Fn(&PoseRow) -> f64| METHODS.map(|m| mean(m, value).unwrap_or(f64::NAN));
    let parts = [0, 1, 2, 3].map(|part| both(&|row: &PoseRow| row.parts[part]));
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
        worlds,
        parts: [0, 1].map(|method| parts.map(|part| part[method])),
        intended_tracking: both(&|row: &PoseRow| row.intended_tracking),
        ratio: mean(PoseMethod::WithPo, &|row| row.ratio),
        intended_ratio: mean(PoseMethod::WithPo, &|row| row.intended_ratio),
    }
}
