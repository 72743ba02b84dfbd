//! The 3-D player: one self-contained HTML page, which is the built page of `viewer/` with the episode in it.

use super::learned::learned;
use super::take_over::take_over;
use crate::recording::{Channel, Frame, Playback};
use cocarry::Error;
use cocarry::error::Place;
use cocarry::geometry::{Point, Pose};
use cocarry::quantities::{COORDINATION, COST, INTERACTION, Quantity, QuantityKind};
use cocarry::robot::Robot;
use cocarry_output::drawing::Shown;
use cocarry_output::figure;
use cocarry_output::palette::PLAIN_OPENING;
use cocarry_output::player::{self, Meshes, pose, read_mesh, shapes};
use serde_json::{Value, json};

/// The built page. `viewer/build.mjs` makes it.
const PAGE: &str = include_str!("../../../../assets/player.html");
/// The place of the episode in the page.
const PLACE: &str = "__EPISODE__";

/// The page that plays an episode in three dimensions. `title` names the recording. `robot` is the recorded
/// robot loaded from its file, so that its meshes can be found; without it, links whose visual shapes are
/// meshes are drawn with their collision shapes. `demo` is the address of the page that runs the simulator, in which
/// the reader takes over from the human: [`demo_address`](super::demo_address), or where that page is published,
/// also relative to this one. Equal recordings give equal bytes.
///
/// # Errors
/// The robot is another one, or a mesh cannot be read.
pub fn player(playback: &Playback, title: &str, robot: Option<&Robot>, demo: &str) -> Result<String, Error> {
    Ok(filled(&episode(playback, title, robot, demo)?))
}

/// As [`player()`], for participants of a study: the scene alone, with no figure, event or path of the episode.
/// `shown` says which names it has.
///
/// # Errors
/// As [`player()`].
pub fn stimulus_page(playback: &Playback, title: &str, shown: Shown) -> Result<String, Error> {
    let mut page = episode(playback, title, None, "")?;
    let count = playback.times(Channel::Coordination).len();
    page["is_stimulus"] = true.into();
    page["facts"] = json!({ "about": "" });
    page["steps"] = json!({
        "decided_s": page["steps"]["decided_s"],
        "done_s": page["steps"]["done_s"],
        "mode": vec!["robot-led"; count],
        "executed": vec![""; count],
        "preferred": vec![""; count],
        "figures": {},
    });
    for left_out in ["ahead", "events"] {
        page[left_out] = json!([]);
    }
    for unknown in ["outcome", "take_over"] {
        page[unknown] = Value::Null;
    }
    let entries = |list: &mut Value, is_shown: bool| {
        let entries = list.as_array_mut().map(std::mem::take).unwrap_or_default();
        if is_shown { entries } else { Vec::new() }
    };
    let openings = entries(&mut page["world"]["openings"], shown.openings).into_iter();
    let named =
        |opening: Value| json!({ "name": opening["name"], "ends": opening["ends"], "colour": PLAIN_OPENING });
    page["world"]["openings"] = openings.map(named).collect();
    let options = entries(&mut page["options"], shown.options).into_iter();
    // all are as wide
    let alike = |mut option: Value| {
        option["probability"] = json!([EQUAL_WIDTH]);
        option
    };
    page["options"] = options.map(alike).collect();
    Ok(filled(&page))
}

/// The P_o as which options are drawn without theirs.
const EQUAL_WIDTH: f64 = 0.25;

/// The page with what it shows.
pub(super) fn filled(episode: &Value) -> String {
    // inside a script element, `</script` would end it, and `<!--<script` would keep its end from ending it
    let text = episode.to_string().replace('<', "\\u003c");
    PAGE.replacen(PLACE, &text, 1)
}

fn episode(playback: &Playback, title: &str, robot: Option<&Robot>, demo: &str) -> Result<Value, Error> {
    let prepared = &playback.prepared;
    let (world, scenario) = (prepared.world(), prepared.scenario());
    let mut found_robot = None;
    let recorded = prepared.robot();
    if let (Some(recorded), Some(found)) = (recorded, robot) {
        let texts = [
            (&recorded.texts.text, &found.texts.text, "robot file"),
            (&recorded.texts.urdf, &found.texts.urdf, "URDF"),
        ];
        if let Some((_, _, what)) = texts.into_iter().find(|(a, b, _)| a != b) {
            let sentence =
                format_args!("is not the robot of the recording: its {what} differs from the recorded one");
            return Err(Error::at(Place::file(&found.texts.file), sentence));
        }
        found_robot = Some(found);
    }
    let mut meshes = Meshes::new(if found_robot.is_some() { Some(&read_mesh) } else { None });
    let links = found_robot.or(recorded).map_or(&[][..], |robot| &robot.links);
    let shapes: Vec<Vec<Value>> =
        links.iter().map(|link| shapes(link, &mut meshes)).collect::<Result<_, _>>()?;
    let drawn: Vec<usize> = (0..links.len()).filter(|&link| !shapes[link].is_empty()).collect();
    let (policy, human) = (playback.decisions.has_custom_policy(), playback.decisions.has_custom_human());
    let mut episode = json!({
        "title": title,
        "world": player::world(world),
        "facts": {
            "plant": scenario.plant.name(),
            "method": (!policy).then(|| scenario.settings.method.name()),
            "seed": scenario.seed,
            "alpha": (!human).then_some(scenario.human.alpha),
            "gamma": (!human).then_some(scenario.human.gamma),
            "robot": recorded.map(|robot| &robot.name),
        },
        "colours": player::colours(),
        "measures": figure::measures(),
        "period_s": scenario.settings.planning_step,
        "options": options(playback),
        "robot": drawn.iter().map(|&l| json!({ "name": links[l].name, "shapes": shapes[l] })).collect::<Vec<_>>(),
        "meshes": meshes.data(),
        "frames": frames(&playback.frames, &drawn),
        "ahead": ahead(playback),
        "steps": steps(playback),
        "events": playback.events.iter().map(|event| json!({
            "time_s": seconds(event.time), "about": event.about, "sentence": event.sentence,
        })).collect::<Vec<_>>(),
        "outcome": playback.outcome,
        "take_over": take_over(playback, demo)?,
    });
    if let Some(learned) = learned(playback) {
        episode["learned"] = learned;
    }
    Ok(episode)
}

fn seconds(time: u64) -> f64 {
    time as f64 / 1e9
}

/// The largest magnitude of a figure that the page shows; no figure of an episode is larger.
const MAX_FIGURE: f64 = 1e9;

/// A figure of a recording; null where it is not a number that the page can show.
pub(super) fn figure(value: Option<f64>) -> Value {
    value.filter(|value| value.abs() <= MAX_FIGURE).into()
}

/// The options with the colours of every picture, as they are at the start, and their P_o by step.
fn options(playback: &Playback) -> Vec<Value> {
    let options = playback.prepared.options();
    let world = playback.prepared.world();
    let probability = |name: &str| -> Vec<Value> {
        let steps = playback.messages(Channel::Options).iter();
        let of_step = |(_, step): &(u64, Value)| {
            let found = step["options"].as_array()?.iter().find(|o| o["name"] == name)?;
            Some(figure(found["probability"].as_f64()))
        };
        steps.map(|step| of_step(step).unwrap_or_default()).collect()
    };
    let drawn = options.options().iter().enumerate().map(|(o, option)| {
        let mut drawn = player::option(o, options, world);
        drawn["probability"] = probability(&option.name).into();
        drawn
    });
    drawn.collect()
}

/// The poses of the bodies, one list of numbers for each, and their times.
fn frames(frames: &[Frame], links: &[usize]) -> Value {
    let of = |body: &dyn Fn(&Frame) -> Pose| -> Vec<f64> {
        frames.iter().flat_map(|frame| pose(&body(frame))).collect()
    };
    json!({
        "time_s": frames.iter().map(|frame| seconds(frame.time)).collect::<Vec<_>>(),
        "links": links.iter().map(|&link| of(&|frame| frame.links[link])).collect::<Vec<_>>(),
        "object": of(&|frame| frame.object),
        "hand": of(&|frame| frame.hand),
        "torso": of(&|frame| frame.torso),
    })
}

/// The path ahead at the times at which it begins to hold.
fn ahead(playback: &Playback) -> Value {
    let line =
        |points: &Vec<Point>| points.iter().flat_map(|p| [p.x, p.y]).map(centimetres).collect::<Vec<_>>();
    playback.ahead.iter().map(|(time, points)| json!([seconds(*time), line(points)])).collect()
}

fn centimetres(value: f64) -> f64 {
    (value * 1e2).round() / 1e2 + 0.0
}

/// The figures of every step as they were recorded, with unit and meaning.
fn steps(playback: &Playback) -> Value {
    const DECIDED: [&str; 7] =
        ["x_m", "y_m", "heading_deg", "stubbornness", "stubbornness_threshold", "discomfort", "step"];
    const SUMMED: [&str; 2] = ["walked_m", "accumulated_objective_cost_m"];
    const FELT: [&str; 2] = ["grip_force_n", "hand_force_n"];
    let words = |key: &str| {
        let steps = playback.messages(Channel::Coordination).iter();
        steps.map(|(_, step)| step[key].as_str().into()).collect::<Vec<Value>>()
    };
    let mut figures = serde_json::Map::new();
    let tables: [(Channel, &[Quantity], &[&str]); 3] = [
        (Channel::Coordination, COORDINATION, &DECIDED),
        (Channel::Cost, COST, &SUMMED),
        (Channel::Interaction, INTERACTION, &FELT),
    ];
    for (channel, table, keys) in tables {
        if playback.messages(channel).is_empty() {
            continue;
        }
        for quantity in table.iter().filter(|quantity| keys.contains(&quantity.key)) {
            let unit = if let QuantityKind::Number(unit) = quantity.kind { unit } else { "" };
            let values = playback.column(channel, quantity.key);
            let values: Vec<Value> = values.into_iter().map(|value| figure(Some(value))).collect();
            figures.insert(
                quantity.key.to_owned(),
                json!({
                    "unit": unit,
                    "description": quantity.description,
                    "values": values,
                }),
            );
        }
    }
    json!({
        "decided_s": playback.times(Channel::Coordination),
        "done_s": playback.times(Channel::Cost),
        "mode": words("mode"),
        "executed": words("executed"),
        "preferred": words("preferred"),
        "figures": figures,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_has_one_place_for_the_episode() {
        assert_eq!(PAGE.matches(PLACE).count(), 1);
    }
}
