//! The figures that a baseline keeps of an episode.

use super::{Figures, Tolerance};
use cocarry::geometry::{Point, cross};
use cocarry::options::Crossing;
use cocarry::quantities::{self, EPISODE, View};
use cocarry::scenario::PreparedScenario;

/// A figure of a run: a word, a whole number or a number.
pub type Figure = quantities::Value;

/// The keys of the figures of the route, which show the side on which the team passed.
const WALKED: [&str; 2] = ["openings", "mean_offset_m"];

/// The names of all figures, in the order in which they are recorded: the quantities of an [`EPISODE`], then
/// `openings`, each with its middle, in the order in which the team passed them, and `mean_offset_m`, the
/// mean distance to the left of the straight line from start to target. A figure that a run does not have is
/// left out.
pub fn figure_names() -> Vec<&'static str> {
    EPISODE.iter().map(|quantity| quantity.key).chain(WALKED).collect()
}

/// Whether a figure has not moved: words must be equal, numbers may differ by the tolerance.
pub fn is_near(before: &Figure, now: &Figure, tolerance: Tolerance) -> bool {
    match (before.as_f64(), now.as_f64()) {
        (Some(before), Some(now)) => {
            (now - before).abs() <= tolerance.absolute + tolerance.relative * before.abs()
        }
        _ => before == now,
    }
}

/// The route of a team: the openings that it passed, and its offset from the straight line.
#[derive(Clone, Debug)]
pub struct Route {
    position: Point,
    crossings: Vec<Crossing>,
    /// Sum over the steps of the distance to the left of the straight line from start to target, m.
    offsets: f64,
    steps: u64,
}

impl Route {
    /// The route before the first step.
    pub fn new(prepared: &PreparedScenario) -> Self {
        Self { position: prepared.world().start, crossings: Vec::new(), offsets: 0.0, steps: 0 }
    }

    /// Adds a step to a new position.
    pub fn step(&mut self, prepared: &PreparedScenario, to: Point) {
        let world = prepared.world();
        self.crossings.extend(prepared.options().crossing(self.position, to));
        let ahead = world.target - world.start;
        self.offsets += cross(ahead, to - world.start) / ahead.norm();
        self.steps += 1;
        self.position = to;
    }

    fn openings(&self, prepared: &PreparedScenario) -> String {
        let names = self.crossings.iter().map(|crossing| {
            let opening = &prepared.world().openings[crossing.opening];
            // to the centimetre; no negative zero
            let [x, y] = [opening.center().x, opening.center().y].map(|c| (c * 100.0).round() / 100.0 + 0.0);
            format!("{} ({x:.2}, {y:.2})", opening.name)
        });
        let names = names.collect::<Vec<_>>().join(", ");
        if names.is_empty() { "none".to_owned() } else { names }
    }
}

/// The figures of a finished episode.
pub fn figures(view: &View, route: &Route) -> Figures {
    let mean_offset = route.offsets / route.steps.max(1) as f64;
    let walked = WALKED.into_iter().zip([route.openings(view.prepared).into(), mean_offset.into()]);
    view.read(EPISODE).into_iter().chain(walked).filter(|(_, figure)| *figure != Figure::Missing).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_tolerances_add_up() {
        let tolerance = Tolerance { relative: 0.01, absolute: 0.5 };
        let is_near = |a: f64, b: f64| is_near(&a.into(), &b.into(), tolerance);
        assert!(is_near(100.0, 101.5) && is_near(100.0, 98.5));
        assert!(!is_near(100.0, 101.500_1) && !is_near(100.0, f64::NAN));
    }

    #[test]
    fn words_and_numbers_differ() {
        let exact = Tolerance { relative: 0.0, absolute: 0.0 };
        let never: Figure = "never".into();
        assert!(is_near(&never, &never, exact));
        assert!(!is_near(&never, &Figure::Count(42), exact) && !is_near(&Figure::Count(42), &never, exact));
        assert!(is_near(&Figure::Count(2), &Figure::Number(2.0), exact));
    }
}
