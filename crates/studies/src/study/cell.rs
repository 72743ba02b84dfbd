//! The combinations of a run's values.

use super::partners::Custom;
use cocarry::scenario::{POSE, PlantKind, PreferenceChanges, SETTINGS, Scenario, Value};

/// The largest number of combinations of a study.
pub const MAX_RUN: usize = 100_000;

/// The inputs of an episode except the seed. Worlds, humans, beliefs and robots are indices into the study's
/// lists.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Cell {
    pub world: usize,
    pub plant: PlantKind,
    pub belief: usize,
    pub humans: usize,
    pub changes: PreferenceChanges,
    /// The robot, on plants that have one.
    pub robot: usize,
    /// One value for each of [`SETTINGS`]; `None` if the plant ignores the setting, or it has no default.
    pub values: Vec<Option<Value>>,
    /// The custom partners, which take the place of the settings' method and human model.
    pub custom: Custom,
}

/// The lists of values of a run, by key.
#[derive(Clone, Debug)]
pub(super) struct Axes {
    pub worlds: Vec<usize>,
    pub plants: Vec<PlantKind>,
    pub beliefs: Vec<usize>,
    pub humans: Vec<usize>,
    pub changes: Vec<PreferenceChanges>,
    pub robots: Vec<usize>,
    /// The values of each of [`SETTINGS`].
    pub values: Vec<Vec<Option<Value>>>,
}

impl Default for Axes {
    /// The defaults of a study, without a world: those of `cocarry run`, but on the kinematic plant.
    fn default() -> Self {
        let defaults = Scenario::defaults();
        Self {
            worlds: Vec::new(),
            plants: vec![PlantKind::Kinematic],
            beliefs: vec![0],
            humans: vec![0],
            changes: vec![PreferenceChanges::NONE],
            robots: vec![0],
            values: SETTINGS.iter().map(|setting| vec![setting.get(&defaults)]).collect(),
        }
    }
}

impl Axes {
    /// All combinations; the last key varies fastest. `None` if there are more than [`MAX_RUN`]. Settings
    /// that a plant ignores are not varied for it, nor those of pose optimisation without candidates.
    pub fn cells(&self) -> Option<Vec<Cell>> {
        let always = |_: &Cell| true;
        let has_robot = |cell: &Cell| cell.plant != PlantKind::Point;
        let mut cells = vec![Cell {
            world: 0,
            plant: PlantKind::Point,
            belief: 0,
            humans: 0,
            changes: PreferenceChanges::NONE,
            robot: 0,
            values: vec![None; SETTINGS.len()],
            custom: Custom::default(),
        }];
        vary(&mut cells, &self.worlds, always, |cell, value| cell.world = *value)?;
        vary(&mut cells, &self.plants, always, |cell, value| cell.plant = *value)?;
        vary(&mut cells, &self.beliefs, always, |cell, value| cell.belief = *value)?;
        vary(&mut cells, &self.humans, always, |cell, value| cell.humans = *value)?;
        vary(&mut cells, &self.changes, always, |cell, value| cell.changes = *value)?;
        vary(&mut cells, &self.robots, has_robot, |cell, value| cell.robot = *value)?;
        let pose = SETTINGS.iter().position(|setting| setting.key == POSE.key)?;
        for (i, (setting, values)) in SETTINGS.iter().zip(&self.values).enumerate() {
            let is_on = |cell: &Cell| {
                let chooses = cell.values[pose] != Some(Value::Text("none".to_owned()));
                setting.applies.is_on(cell.plant, chooses)
            };
            vary(&mut cells, values, is_on, |cell, value| cell.values[i].clone_from(value))?;
        }
        Some(cells)
    }
}

/// Replaces every cell for which the condition holds by copies with each of the values. `None` if there are
/// too many cells.
fn vary<T>(
    cells: &mut Vec<Cell>,
    values: &[T],
    is_varied: impl Fn(&Cell) -> bool,
    set: impl Fn(&mut Cell, &T),
) -> Option<()> {
    let mut varied = Vec::with_capacity(cells.len());
    for cell in cells.iter() {
        let one = if is_varied(cell) { values } else { &[] };
        for value in one {
            let mut cell = cell.clone();
            set(&mut cell, value);
            varied.push(cell);
        }
        if one.is_empty() {
            varied.push(cell.clone());
        }
        if varied.len() > MAX_RUN {
            return None;
        }
    }
    *cells = varied;
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(mut axes: Axes, key: &str, texts: &[&str]) -> Axes {
        let at = SETTINGS.iter().position(|setting| setting.key == key).expect("a key");
        axes.values[at] = texts.iter().map(|text| SETTINGS[at].parse(text).ok()).collect();
        axes
    }

    #[test]
    fn closed_form_what_a_plant_has_no_use_for_is_not_varied_with_it() {
        let plants = PlantKind::ALL.to_vec();
        let axes = Axes { worlds: vec![0, 1], plants, ..Axes::default() };
        let axes = with(axes, "pose", &["none", "arm"]);
        let axes = with(axes, "pose_criterion", &["expected", "uniform"]);
        let axes = with(axes, "sway_m", &["0", "0.01", "0.02"]);
        // per world: 1 on the point; 1 + 2 on the kinematic plant; three times that on the physical one
        assert_eq!(axes.cells().map(|cells| cells.len()), Some(2 * (1 + 3 + 9)));
    }

    #[test]
    fn closed_form_too_many_combinations_are_not_made() {
        let many: Vec<String> = (1..400).map(|i| i.to_string()).collect();
        let many: Vec<&str> = many.iter().map(String::as_str).collect();
        let axes = with(Axes { worlds: vec![0], ..Axes::default() }, "eta", &many);
        let axes = with(axes, "sway_m", &many[..5]);
        assert_eq!(axes.cells().map(|cells| cells.len()), Some(399));
        assert!(with(axes, "risk_weight_m", &many).cells().is_none());
    }
}
