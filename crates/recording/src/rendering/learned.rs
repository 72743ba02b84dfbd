//! The belief of a robot that learns about its human at every time, for the 3-D player.

use super::player::figure;
use crate::recording::{Channel, Playback};
use serde_json::{Value, json};

/// The human model whose alpha and gamma decide nothing.
const SCRIPTED: &str = "scripted";
/// The largest number of cells along either side of the plane of alpha and gamma.
const MAX_SIDE: usize = 256;
/// The figures of a message that the player shows.
const FIGURES: [&str; 8] = [
    "alpha_mean",
    "gamma_mean",
    "alpha_interval",
    "gamma_interval",
    "region_share",
    "information_nats",
    "eta_mean",
    "eta_interval",
];

/// The belief over time and the true human; `None` if the recording's robot does not learn.
pub(super) fn learned(playback: &Playback) -> Option<Value> {
    let messages = playback.messages(Channel::Learned);
    let (_, first) = messages.iter().find(|(_, message)| is_complete(&message["human"]))?;
    let cells = |message: &Value| message["human"]["density"].as_array().map_or(0, Vec::len);
    let is_shown = |message: &Value| is_complete(&message["human"]) && cells(message) == cells(first);
    // the plane changes seldom, and is large; eta changes in every step under the robot's lead
    let mut planes: Vec<(&Value, Value)> = Vec::new();
    let mut beliefs = Vec::new();
    for (time, message) in messages.iter().filter(|(_, message)| is_shown(message)) {
        let human = &message["human"];
        let density = &human["density"];
        if planes.last().is_none_or(|(last, _)| *last != density) {
            planes.push((density, plane(density, &human["region_density"])));
        }
        let mut belief = json!({ "time_s": *time as f64 / 1e9, "plane": planes.len() - 1 });
        for key in FIGURES {
            belief[key] = human[key].clone();
        }
        beliefs.push(belief);
    }
    Some(json!({
        "ranges": [first["human"]["alpha_range"], first["human"]["gamma_range"]],
        "planes": planes.into_iter().map(|(_, plane)| plane).collect::<Vec<_>>(),
        "beliefs": beliefs,
        "humans": humans(playback),
    }))
}

/// Whether a belief has all that the page shows of it: figures that are numbers, intervals and ranges that are
/// pairs of them, and a square of densities. A forged one may not.
fn is_complete(human: &Value) -> bool {
    let is_figure = |value: &Value| !figure(value.as_f64()).is_null();
    let is_pair =
        |value: &Value| value.as_array().is_some_and(|ends| ends.len() == 2 && ends.iter().all(is_figure));
    let is_range = |value: &Value| {
        is_pair(value) && value[0].as_f64().zip(value[1].as_f64()).is_some_and(|(a, b)| a < b)
    };
    let has_figures = FIGURES.iter().all(|key| match key.ends_with("_interval") {
        true => is_pair(&human[key]),
        false => is_figure(&human[key]),
    });
    let is_square = human["density"].as_array().is_some_and(|cells| {
        let side = cells.len().isqrt();
        (1..=MAX_SIDE).contains(&side) && side * side == cells.len() && cells.iter().all(is_figure)
    });
    has_figures && is_square && ["alpha_range", "gamma_range"].iter().all(|key| is_range(&human[key]))
}

/// The densities of the cells, for shading, and which cells are in the 95 % region: 1, else 0.
fn plane(densities: &Value, least: &Value) -> Value {
    let densities = || densities.as_array().into_iter().flatten().filter_map(Value::as_f64);
    // a cell on the region's level is in it, whatever its last digits
    let least = least.as_f64().unwrap_or_default() * (1.0 - 1e-6);
    json!({
        "density": densities().map(|density| (density * 1e3).round() / 1e3).collect::<Vec<_>>(),
        "region": densities().map(|density| if density >= least { '1' } else { '0' }).collect::<String>(),
    })
}

/// The true alpha and gamma and the times (s) from which they hold; none of a human who has none.
fn humans(playback: &Playback) -> Vec<Value> {
    let scenario = playback.prepared.scenario();
    if scenario.human_model.model().name == SCRIPTED {
        return Vec::new();
    }
    let mut changes: Vec<_> =
        scenario.changes.iter().map(|change| (change.step, change.perception)).collect();
    // of several at the same step, the last one applies
    changes.sort_by_key(|(step, _)| *step);
    let all = std::iter::once((0, scenario.human)).chain(changes);
    all.map(|(step, human)| json!([step as f64 * scenario.settings.planning_step, human.alpha, human.gamma]))
        .collect()
}
