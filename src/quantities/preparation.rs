//! The inputs of the controller's decision in a step: references, and the candidates of eq. (8). They are in
//! recordings only.

use super::{
    Fields, METRES, PLAIN, Quantity, QuantityKind, RADIANS, Value, View, fields, headings, quantities,
};
use crate::control::{CandidateCost, Reference};
use crate::robot::Configuration;
use QuantityKind::{List, Numbers, Text};

/// The references and candidates of a step. Missing without a robot.
#[rustfmt::skip]
pub const PREPARATION: &[Quantity] = quantities! {
    "references", List(|| headings(REFERENCE)), "what eq. (7) and (8) track: all options while the human leads, else the one executed", |v| references(v);
    "target", QuantityKind::Record(|| headings(CONFIGURATION)), "q*, the configuration that eq. (8) chose, else the present one", |v| v.episode.decision_basis().map(|c| configuration(v, c.target));
    "candidates", List(|| headings(CANDIDATE)), "Q of eq. (8), the present configuration first; none where eq. (8) was not solved", |v| candidates(v);
};

struct ReferenceView<'a> {
    name: &'a str,
    weight: f64,
    reference: &'a Reference,
}

type OfReference = Quantity<fn(&ReferenceView) -> Value>;

#[rustfmt::skip]
const REFERENCE: &[OfReference] = quantities! {
    "name", Text, "name of the option", |v| v.name;
    "weight", PLAIN, "its weight in eq. (8): P_o, if nothing else was asked for", |v| v.weight;
    "s", Numbers, "s_o(1) to s_o(8), six numbers each: x, y, z (m) and rotation vector (rad), relative to the grasp's present pose, world axes; on the \
        physical plant the part left to the arm while the base follows its path", |v| v.reference.as_slice().to_vec();
};

struct ConfigurationView<'a> {
    configuration: &'a Configuration,
    joints: usize,
}

type OfConfiguration = Quantity<fn(&ConfigurationView) -> Value>;

#[rustfmt::skip]
const CONFIGURATION: &[OfConfiguration] = quantities! {
    "x_m", METRES, "position of the base, world x", |v| v.configuration.base.position.x;
    "y_m", METRES, "position of the base, world y", |v| v.configuration.base.position.y;
    "yaw_rad", RADIANS, "heading of the base", |v| v.configuration.base.yaw;
    "joints", Numbers, "positions of the joints, in the order of /joints, rad (prismatic: m)", |v| v.configuration.joints.as_slice()[..v.joints].to_vec();
};

/// The quantities of a candidate: its configuration and its evaluation.
type OfCandidate = Quantity<fn(&(Fields, CandidateCost)) -> Value>;

#[rustfmt::skip]
const CANDIDATE: &[OfCandidate] = quantities! {
    "q", QuantityKind::Record(|| headings(CONFIGURATION)), "the configuration", |(q, _)| q.clone();
    "lower_bound", PLAIN, "the sum of eq. (8) without limits; missing where no costs were asked for", |(_, found)| found.lower_bound;
    "total", PLAIN, "the sum of eq. (8) (minus the manipulability, if that is the criterion); missing where it is known to exceed the least without being \
        worked out", |(_, found)| found.cost;
};

fn references(view: &View) -> Option<Vec<Fields>> {
    let decision_basis = view.episode.decision_basis()?;
    let is_led = view.preparation().is_some_and(|p| p.tracked.is_some());
    let pairs = decision_basis.references.iter().zip(decision_basis.weights).enumerate();
    let records = pairs.map(|(i, (reference, &weight))| {
        let name = view.option(if is_led { i } else { view.tick().executed });
        fields(REFERENCE, &ReferenceView { name, weight, reference })
    });
    Some(records.collect())
}

fn configuration(view: &View, configuration: &Configuration) -> Fields {
    let joints = view.prepared.robot().map_or(0, |robot| robot.joint_count());
    fields(CONFIGURATION, &ConfigurationView { configuration, joints })
}

fn candidates(view: &View) -> Option<Vec<Fields>> {
    let decision_basis = view.episode.decision_basis()?;
    if view.preparation().is_none() {
        return Some(Vec::new());
    }
    let candidate_costs = decision_basis.poses.candidate_costs();
    let candidates =
        candidate_costs.map(|c| fields(CANDIDATE, &(configuration(view, &c.candidate.configuration), c)));
    Some(candidates.collect())
}

/// Key and kind of every quantity in a nested record.
#[cfg(test)]
pub(super) fn nested() -> Vec<(&'static str, QuantityKind)> {
    let of_references = REFERENCE.iter().map(|q| (q.key, q.kind));
    let of_configurations = CONFIGURATION.iter().map(|q| (q.key, q.kind));
    of_references.chain(of_configurations).chain(CANDIDATE.iter().map(|q| (q.key, q.kind))).collect()
}
