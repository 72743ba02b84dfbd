//! stub
use crate::{geometry::Point, options::OptionSet, world::World};
#[derive(Debug, thiserror::Error)]
pub enum DrawingError {
    #[error("x")]
    X,
}
pub struct Track {
    pub label: String,
    pub positions: Vec<Point>,
    pub transition: Option<usize>,
    pub stubbornness: Vec<f64>,
}
pub fn world_map(_w: &World, _o: &OptionSet, _p: &[f64]) -> Result<String, DrawingError> {
    Ok(String::new())
}
pub fn adaptation(_w: &World, _t: &[Track], _p: f64) -> Result<String, DrawingError> {
    Ok(String::new())
}

impl Track {
    /// The track of an episode from its ticks, ended at the target where it arrived.
    pub fn new(label: impl Into<String>, ticks: &[crate::episode::Tick], end: Option<Point>) -> Self {
        use crate::coordination::Mode;
        let led_by_robot = ticks.iter().take_while(|t| t.mode == Mode::RobotLed).count();
        Self {
            label: label.into(),
            positions: ticks.iter().map(|t| t.position).chain(end).collect(),
            transition: (0 < led_by_robot && led_by_robot < ticks.len()).then_some(led_by_robot),
            stubbornness: match led_by_robot {
                0 => Vec::new(),
                _ => ticks.iter().map(|t| t.stubbornness).collect(),
            },
        }
    }
}
