//! Validated tracks to draw: positions of a team and the stubbornness of its human.

use cocarry::Error;
use cocarry::coordination::Mode;
use cocarry::episode::Tick;
use cocarry::geometry::Point;

/// Largest coordinate of a position, m.
const MAX_COORDINATE_M: f64 = 1e7;
/// Value to which stubbornness is clipped; charts end far below.
const MAX_STUBBORNNESS: f64 = 1e6;

/// Positions of a team and the stubbornness of its human by step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Track {
    /// Label in the legend.
    pub label: String,
    /// First step.
    pub first_step: u64,
    /// Position at every step, m, world frame.
    pub positions: Vec<Point>,
    /// Step at which the human took the lead.
    pub transition: Option<usize>,
    /// phi at every step; empty if there is none.
    pub stubbornness: Vec<f64>,
}

impl Track {
    /// The track of an episode from its ticks, with the final position.
    pub fn new(label: impl Into<String>, ticks: &[Tick], end: Option<Point>) -> Self {
        let led_by_robot = ticks.iter().take_while(|t| t.mode == Mode::RobotLed).count();
        let human_leads_from_the_start = led_by_robot == 0;
        Self {
            label: label.into(),
            first_step: ticks.first().map_or(0, |t| t.step),
            positions: ticks.iter().map(|t| t.position).chain(end).collect(),
            transition: (!human_leads_from_the_start && led_by_robot < ticks.len()).then_some(led_by_robot),
            stubbornness: match human_leads_from_the_start {
                true => Vec::new(),
                false => ticks.iter().map(|t| t.stubbornness).collect(),
            },
        }
    }

    pub(super) fn check(&self) -> Result<(), Error> {
        let track = &self.label;
        let bad = |quantity, step, value: f64| {
            Error::new(format!("track `{track}`: its {quantity} at step {step} cannot be drawn: {value}"))
        };
        for (step, p) in self.positions.iter().enumerate() {
            if let Some(value) = [p.x, p.y].into_iter().find(|c| c.is_nan() || c.abs() > MAX_COORDINATE_M) {
                return Err(bad("position", step, value));
            }
        }
        if let Some(step) = self.stubbornness.iter().position(|phi| phi.is_nan()) {
            return Err(bad("stubbornness", step, self.stubbornness[step]));
        }
        match self.transition {
            Some(transition) if transition >= self.positions.len() => Err(Error::new(format!(
                "track `{track}`: its transition is at step {transition}, but it has {} positions",
                self.positions.len()
            ))),
            _ => Ok(()),
        }
    }

    /// (k, phi) up to the transition, after which phi is constant.
    pub(super) fn stubbornness_by_step(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let steps = self.transition.map_or(usize::MAX, |t| t.saturating_add(1));
        let drawn = self.stubbornness.iter().take(steps).enumerate();
        drawn.map(|(i, phi)| ((self.first_step + i as u64) as f64, phi.clamp(0.0, MAX_STUBBORNNESS)))
    }

    /// (k, phi) at the transition.
    pub(super) fn transition_point(&self) -> Option<(f64, f64)> {
        self.stubbornness_by_step().nth(self.transition?)
    }
}
