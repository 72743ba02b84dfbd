//! The combinations of a run's values.

use super::names::Plants;
use crate::control::{Avoid, CandidateSet, PoseCriterion, Settings as Control};
use crate::coordination;
use crate::episode::Settings;
use crate::policy::Method;
use crate::preference::RISK_WEIGHT;
use crate::scenario::Redraws;
use crate::simulation::HumanSettings;

/// The most combinations that a run may have.
pub const LARGEST_RUN: usize = 100_000;

/// All that an episode is settled by but the seed. Worlds, humans, beliefs and robots by their place in the study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cell {
    pub world: usize,
    pub plant: Plants,
    pub method: Method,
    pub eta: f64,
    pub initial_stubbornness: f64,
    pub risk_weight: f64,
    pub humans: usize,
    pub redraws: Redraws,
    pub belief: usize,
    pub period: f64,
    pub speed: f64,
    pub yaw_rate: f64,
    pub max_steps: Option<u64>,
    /// From here on: of the robot, on the plants that have one.
    pub robot: usize,
    /// By its place in the study's postures; none: the robot's first.
    pub posture: Option<usize>,
    pub candidates: CandidateSet,
    /// Where there are candidates.
    pub criterion: PoseCriterion,
    pub prepare_while_leading: bool,
    pub avoid: Avoid,
    /// Of the human's hand, m, on the physical plant.
    pub sway: f64,
}

/// The values of every key of a run.
#[derive(Clone, Debug)]
pub(super) struct Axes {
    pub worlds: Vec<usize>,
    pub plants: Vec<Plants>,
    pub methods: Vec<Method>,
    pub eta: Vec<f64>,
    pub initial_stubbornness: Vec<f64>,
    pub risk_weight: Vec<f64>,
    pub humans: Vec<usize>,
    pub redraws: Vec<Redraws>,
    pub beliefs: Vec<usize>,
    pub period: Vec<f64>,
    pub speed: Vec<f64>,
    pub yaw_rate: Vec<f64>,
    pub max_steps: Vec<Option<u64>>,
    pub robots: Vec<usize>,
    pub postures: Vec<Option<usize>>,
    pub candidates: Vec<CandidateSet>,
    pub criteria: Vec<PoseCriterion>,
    pub prepare_while_leading: Vec<bool>,
    pub avoid: Vec<Avoid>,
    pub sway: Vec<f64>,
}

impl Default for Axes {
    /// What `cocarry run` does where nothing is said; no world.
    fn default() -> Self {
        let (settings, control) = (Settings::default(), Control::default());
        let coordination = coordination::Settings::default();
        Self {
            worlds: Vec::new(),
            plants: vec![Plants::Kinematic],
            methods: vec![settings.method],
            eta: vec![coordination.eta],
            initial_stubbornness: vec![coordination.initial_stubbornness],
            risk_weight: vec![RISK_WEIGHT],
            humans: vec![0],
            redraws: vec![Redraws::NONE],
            beliefs: vec![0],
            period: vec![settings.period],
            speed: vec![settings.speed],
            yaw_rate: vec![settings.yaw_rate],
            max_steps: vec![settings.tick_limit],
            robots: vec![0],
            postures: vec![None],
            candidates: vec![control.candidates],
            criteria: vec![control.criterion],
            prepare_while_leading: vec![control.prepare_while_leading],
            avoid: vec![control.avoid],
            sway: vec![HumanSettings::default().sway_lateral],
        }
    }
}

impl Axes {
    /// Every combination, the last key varying fastest; none if there are more than [`LARGEST_RUN`]. What a plant or a choice has no use for
    /// is not varied with it: the robot on the planning level, the sway without a body, the criterion without candidates.
    pub fn cells(&self) -> Option<Vec<Cell>> {
        let standard = Self::default();
        let first = Cell {
            world: 0,
            plant: Plants::Point,
            method: standard.methods[0],
            eta: standard.eta[0],
            initial_stubbornness: standard.initial_stubbornness[0],
            risk_weight: standard.risk_weight[0],
            humans: 0,
            redraws: standard.redraws[0],
            belief: 0,
            period: standard.period[0],
            speed: standard.speed[0],
            yaw_rate: standard.yaw_rate[0],
            max_steps: None,
            robot: 0,
            posture: None,
            candidates: standard.candidates[0],
            criterion: standard.criteria[0],
            prepare_while_leading: standard.prepare_while_leading[0],
            avoid: standard.avoid[0],
            sway: standard.sway[0],
        };
        let always = |_: &Cell| true;
        let has_robot = |cell: &Cell| cell.plant != Plants::Point;
        let chooses = |cell: &Cell| has_robot(cell) && cell.candidates != CandidateSet::None;
        let has_body = |cell: &Cell| cell.plant == Plants::Rapier;
        let mut cells = vec![first];
        vary(&mut cells, &self.worlds, always, |cell, value| cell.world = value)?;
        vary(&mut cells, &self.plants, always, |cell, value| cell.plant = value)?;
        vary(&mut cells, &self.risk_weight, always, |cell, value| cell.risk_weight = value)?;
        vary(&mut cells, &self.beliefs, always, |cell, value| cell.belief = value)?;
        vary(&mut cells, &self.humans, always, |cell, value| cell.humans = value)?;
        vary(&mut cells, &self.redraws, always, |cell, value| cell.redraws = value)?;
        vary(&mut cells, &self.period, always, |cell, value| cell.period = value)?;
        vary(&mut cells, &self.speed, always, |cell, value| cell.speed = value)?;
        vary(&mut cells, &self.yaw_rate, always, |cell, value| cell.yaw_rate = value)?;
        vary(&mut cells, &self.max_steps, always, |cell, value| cell.max_steps = value)?;
        vary(&mut cells, &self.robots, has_robot, |cell, value| cell.robot = value)?;
        vary(&mut cells, &self.postures, has_robot, |cell, value| cell.posture = value)?;
        vary(&mut cells, &self.avoid, has_robot, |cell, value| cell.avoid = value)?;
        vary(&mut cells, &self.sway, has_body, |cell, value| cell.sway = value)?;
        vary(&mut cells, &self.initial_stubbornness, always, |c, value| c.initial_stubbornness = value)?;
        vary(&mut cells, &self.eta, always, |cell, value| cell.eta = value)?;
        vary(&mut cells, &self.methods, always, |cell, value| cell.method = value)?;
        vary(&mut cells, &self.candidates, has_robot, |cell, value| cell.candidates = value)?;
        vary(&mut cells, &self.criteria, chooses, |cell, value| cell.criterion = value)?;
        vary(&mut cells, &self.prepare_while_leading, chooses, |c, value| c.prepare_while_leading = value)?;
        Some(cells)
    }
}

/// Every cell of which it is true with every value instead of itself. None if they become too many.
fn vary<T: Copy>(
    cells: &mut Vec<Cell>,
    values: &[T],
    is_varied: impl Fn(&Cell) -> bool,
    set: impl Fn(&mut Cell, T),
) -> Option<()> {
    let mut varied = Vec::with_capacity(cells.len());
    for cell in cells.iter() {
        let one = if is_varied(cell) { values } else { &[] };
        for value in one {
            let mut cell = *cell;
            set(&mut cell, *value);
            varied.push(cell);
        }
        if one.is_empty() {
            varied.push(*cell);
        }
        if varied.len() > LARGEST_RUN {
            return None;
        }
    }
    *cells = varied;
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_what_a_plant_has_no_use_for_is_not_varied_with_it() {
        let axes = Axes {
            worlds: vec![0, 1],
            plants: vec![Plants::Point, Plants::Kinematic, Plants::Rapier],
            candidates: vec![CandidateSet::None, CandidateSet::Arm],
            criteria: vec![PoseCriterion::Expected, PoseCriterion::Uniform],
            sway: vec![0.0, 0.01, 0.02],
            ..Axes::default()
        };
        // per world: 1 on the point; 1 + 2 on the kinematic plant; three times that on the physical one
        assert_eq!(axes.cells().map(|cells| cells.len()), Some(2 * (1 + 3 + 9)));
    }

    #[test]
    fn closed_form_too_many_combinations_are_not_made() {
        let many: Vec<f64> = (1..400).map(f64::from).collect();
        let axes = Axes { worlds: vec![0], eta: many.clone(), sway: many.clone(), ..Axes::default() };
        assert_eq!(axes.cells().map(|cells| cells.len()), Some(399));
        let axes = Axes { risk_weight: many, ..axes };
        assert!(axes.cells().is_none());
    }
}
