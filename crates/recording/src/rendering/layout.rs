//! The layout for Foxglove and Lichtblick that shows a recording: its options by name, in the colours of every
//! picture.

use crate::recording::{Channel, FIELD_OF_VIEW_DEG, Overview, Playback};
use cocarry_output::drawing::option_colour;
use cocarry_output::palette;
use serde_json::{Map, Value, json};

/// The topics of the scene.
const SCENES: [Channel; 4] = [Channel::World, Channel::Team, Channel::OptionLines, Channel::Path];

/// A curve: message path, name, colour.
type Curve = (String, String, String);

/// The layout as JSON, to be imported in either viewer. It has panels only for what is recorded. Equal
/// recordings give equal bytes.
pub fn viewer_layout(playback: &Playback) -> String {
    let has = |channel: Channel| !playback.messages(channel).is_empty();
    let mut panels = Map::new();
    panels.insert("3D!scene".to_owned(), scene("Scene", overview(playback)));
    let has_team = playback.prepared.robot().is_some();
    if has_team {
        panels.insert("3D!team".to_owned(), scene("The team, from behind", follow()));
    }
    let grey = palette::hex([90, 96, 105]);
    let ink = || palette::hex(palette::INK);
    let curve =
        |path: &str, name: &str, colour: String| -> Curve { (path.to_owned(), name.to_owned(), colour) };
    let mut plots: Vec<(&str, Value)> = Vec::new();
    let stubbornness = [
        curve("/coordination.stubbornness", "phi", ink()),
        curve("/coordination.stubbornness_threshold", "threshold", option_colour(5)),
    ];
    let title = "Stubbornness phi: above the threshold the human takes the lead";
    plots.push(("Plot!stubbornness", plot(title, "phi", Some(0.0), &stubbornness)));
    let options = playback.prepared.options().options();
    let curves: Vec<Curve> = options
        .iter()
        .enumerate()
        .map(|(o, option)| {
            let path = format!("/options.options[{o}].probability");
            (path, format!("option {}", option.name), option_colour(o))
        })
        .collect();
    let title = "Probability P_o that a human prefers an option";
    plots.push(("Plot!probability", plot(title, "P_o", Some(0.0), &curves)));
    let discomfort = [curve("/coordination.discomfort", "g", ink())];
    plots.push(("Plot!discomfort", plot("Discomfort g", "g", Some(0.0), &discomfort)));
    if has_team {
        let cost =
            |key: &str, name: &str, colour| curve(&format!("/cost.accumulated_{key}_cost"), name, colour);
        let costs = [
            cost("control", "C, the sum", ink()),
            cost("tracking", "tracking", option_colour(4)),
            cost("effort", "effort", option_colour(5)),
            cost("pose", "pose", option_colour(6)),
        ];
        plots.push(("Plot!cost", plot("Control cost, summed up", "C", Some(0.0), &costs)));
    }
    if has(Channel::Interaction) {
        let forces = [
            curve("/interaction.grip_force_n", "robot's gripper", grey),
            curve("/interaction.hand_force_n", "human's hand", palette::hex(palette::HUMAN)),
        ];
        plots.push(("Plot!force", plot("Forces on the object (rms over a step)", "force, N", None, &forces)));
    }
    let right = stack(&plots.iter().map(|(id, _)| json!(id)).collect::<Vec<_>>());
    panels.extend(plots.into_iter().map(|(id, panel)| (id.to_owned(), panel)));
    let mut log = titled("What happened");
    log.extend([
        ("searchTerms".to_owned(), json!([])),
        ("minLogLevel".to_owned(), json!(1)),
        ("topicToRender".to_owned(), json!(Channel::Log.topic())),
    ]);
    panels.insert("RosOut!log".to_owned(), log.into());
    let scenes = match has_team {
        true => split("column", json!("3D!scene"), json!("3D!team"), 56.0),
        false => json!("3D!scene"),
    };
    let left = split("column", scenes, json!("RosOut!log"), 82.0);
    let layout = json!({
        "configById": panels,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": { "speed": 1 },
        "layout": split("row", left, right, 58.0),
    });
    format!("{layout:#}\n")
}

/// Panels below each other, equally high.
fn stack(panels: &[Value]) -> Value {
    match panels {
        [] => Value::Null,
        [last] => last.clone(),
        [first, rest @ ..] => split("column", first.clone(), stack(rest), 100.0 / panels.len() as f64),
    }
}

fn split(direction: &str, first: Value, second: Value, share: f64) -> Value {
    json!({ "direction": direction, "first": first, "second": second, "splitPercentage": share.round() })
}

/// The title of a panel, under the key of either viewer.
fn titled(title: &str) -> Map<String, Value> {
    let keys = ["foxglovePanelTitle", "lichtblickPanelTitle"];
    keys.into_iter().map(|key| (key.to_owned(), title.into())).collect()
}

fn plot(title: &str, y: &str, least: Option<f64>, curves: &[Curve]) -> Value {
    let paths = curves.iter().map(|(path, name, colour)| {
        json!({
            "value": path,
            "enabled": true,
            "timestampMethod": "receiveTime",
            "label": name,
            "color": colour,
            "showLine": true,
            "lineSize": 1,
        })
    });
    let paths: Vec<Value> = paths.collect();
    let mut panel = titled(title);
    let rest = json!({
        "paths": paths,
        "minYValue": least,
        "showXAxisLabels": true,
        "showYAxisLabels": true,
        "xAxisLabel": "time, s",
        "yAxisLabel": y,
        "showLegend": curves.len() > 1,
        "legendDisplay": "left",
        "showPlotValuesInLegend": true,
        "isSynced": true,
        "xAxisVal": "timestamp",
        "sidebarDimension": 140,
    });
    if let Value::Object(rest) = rest {
        panel.extend(rest.into_iter().filter(|(_, value)| !value.is_null()));
    }
    panel.into()
}

/// A 3-D panel with this camera.
fn scene(title: &str, camera: Camera) -> Value {
    let topics: Map<String, Value> =
        SCENES.iter().map(|channel| (channel.topic().to_owned(), json!({ "visible": true }))).collect();
    let mut panel = titled(title);
    let rest = json!({
        "cameraState": {
            "distance": camera.distance,
            "perspective": true,
            "phi": camera.tilt_deg,
            "target": [0, 0, 0],
            "targetOffset": camera.target,
            "targetOrientation": [0, 0, 0, 1],
            "thetaOffset": camera.turn_deg,
            "fovy": FIELD_OF_VIEW_DEG,
            "near": 0.1,
            "far": 5000.0,
        },
        "followMode": camera.follow,
        "followTf": camera.frame,
        "scene": {
            "backgroundColor": "#f4f4f6",
            "transforms": { "showLabel": false, "axisScale": 0, "lineWidth": 0, "enablePreloading": true },
        },
        "transforms": {},
        "topics": topics,
        "layers": {
            "grid": {
                "visible": true,
                "frameLocked": true,
                "label": "Grid of 1 m",
                "instanceId": "grid",
                "layerId": "foxglove.Grid",
                "frameId": "world",
                "size": 60,
                "divisions": 60,
                "lineWidth": 1,
                "color": "#d0d0d6ff",
                "position": [0, 0, 0],
                "rotation": [0, 0, 0],
                "order": 1,
            },
        },
        "imageMode": {},
    });
    if let Value::Object(rest) = rest {
        panel.extend(rest);
    }
    panel.into()
}

/// Where a scene is seen from.
struct Camera {
    frame: &'static str,
    follow: &'static str,
    distance: f64,
    tilt_deg: f64,
    turn_deg: f64,
    target: [f64; 3],
}

/// Behind the object, turning with it.
fn follow() -> Camera {
    Camera {
        frame: "object",
        follow: "follow-pose",
        distance: 6.0,
        tilt_deg: 60.0,
        turn_deg: 90.0,
        target: [0.2, 0.0, 0.1],
    }
}

/// The whole scene.
fn overview(playback: &Playback) -> Camera {
    let view = Overview::of(playback.prepared.world(), playback.prepared.options());
    Camera {
        frame: "world",
        follow: "follow-none",
        distance: view.distance,
        tilt_deg: view.tilt_deg,
        turn_deg: view.turn_deg,
        target: [view.target.x, view.target.y, 0.0],
    }
}
