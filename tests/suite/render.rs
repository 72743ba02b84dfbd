//! Recordings as pages and pictures: what `cocarry render` and `run --render` write, and what they refuse.

use crate::support::{cocarry, is_built_of, repository, stderr, stdout};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Recordings of all plants: those that ship, and one of each plant that they do not have.
fn recordings(folder: &Path) -> Vec<PathBuf> {
    let shipped = (1..=4).map(|n| repository(&format!("recordings/environment-{n}.mcap")));
    let made = ["point", "kinematic"].map(|plant| {
        let file = folder.join(format!("{plant}.mcap"));
        good(&["run", "environment-3", "--seed", "2", "--plant", plant, "--record", text(&file)]);
        file
    });
    shipped.chain(made).collect()
}

fn text(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

fn good(arguments: &[&str]) -> String {
    let output = cocarry(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    stdout(&output)
}

fn refused(arguments: &[&str], words: &[&str]) {
    let output = cocarry(arguments);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    words.iter().for_each(|word| assert!(said.contains(word), "{arguments:?}: no {word:?} in: {said}"));
}

/// The episode inside a player's page.
fn episode(page: &str) -> Value {
    let (_, rest) = page.split_once("<script type=\"application/json\" id=\"episode\">").expect("an episode");
    let (episode, _) = rest.split_once("</script>").expect("its end");
    serde_json::from_str(episode).expect("JSON")
}

/// The first row of a channel's CSV, and the rows by column.
fn table(recording: &Path, channel: &str) -> Vec<std::collections::BTreeMap<String, String>> {
    let text = good(&["inspect", text(recording), "--csv", channel]);
    csv::Reader::from_reader(text.as_bytes()).deserialize().map(Result::unwrap).collect()
}

#[test]
fn a_player_is_one_small_file_that_asks_for_nothing_and_has_the_recorded_figures() {
    let folder = tempfile::tempdir().unwrap();
    for recording in recordings(folder.path()) {
        let name = recording.file_stem().unwrap().to_str().unwrap();
        let file = folder.path().join(format!("{name}.html"));
        good(&["render", text(&recording), "-o", text(&file)]);
        let page = std::fs::read_to_string(&file).unwrap();
        assert!(page.len() < 3_000_000, "{name}: {} bytes", page.len());
        for attribute in ["src=", "href=", "@import", "url("] {
            let outside = page.match_indices(attribute).map(|(at, _)| &page[at..page.len().min(at + 60)]);
            let outside = outside.filter(|text| text.contains("http:") || text.contains("https:"));
            assert_eq!(outside.collect::<Vec<_>>(), [""; 0], "{name}: {attribute}");
        }
        // the browser itself refuses whatever is asked for
        assert!(page.contains("default-src 'none'; script-src 'unsafe-inline'"), "{name}");

        let episode = episode(&page);
        let steps = &episode["steps"];
        for (channel, key) in [
            ("/coordination", "stubbornness"),
            ("/coordination", "x_m"),
            ("/interaction", "hand_force_n"),
            ("/cost", "walked_m"),
        ] {
            let drawn = &steps["figures"][key]["values"];
            if channel == "/interaction" && !drawn.is_array() {
                assert!(["point", "kinematic"].contains(&name), "{name} has forces");
                continue;
            }
            let recorded = table(&recording, channel);
            assert_eq!(drawn.as_array().unwrap().len(), recorded.len(), "{name} {key}");
            for (drawn, row) in drawn.as_array().unwrap().iter().zip(&recorded) {
                assert_eq!(drawn.as_f64(), row[key].parse().ok(), "{name} {key}");
            }
        }
        let recorded = table(&recording, "/options");
        for option in episode["options"].as_array().unwrap() {
            let key = format!("options[{}].probability", option["name"].as_str().unwrap());
            for (drawn, row) in option["probability"].as_array().unwrap().iter().zip(&recorded) {
                assert_eq!(drawn.as_f64(), row[&key].parse().ok(), "{name} {key}");
            }
        }
        let told: Vec<&Value> =
            episode["events"].as_array().unwrap().iter().map(|e| &e["sentence"]).collect();
        let recorded = table(&recording, "/log");
        assert_eq!(told, recorded.iter().map(|row| row["message"].as_str()).collect::<Vec<_>>(), "{name}");
        let has_robot = name != "point";
        assert_eq!(!episode["robot"].as_array().unwrap().is_empty(), has_robot, "{name}");
        let frames = episode["frames"]["time_s"].as_array().unwrap().len();
        assert_eq!(episode["frames"]["torso"].as_array().unwrap().len(), 7 * frames, "{name}");
        assert_eq!(frames, steps["decided_s"].as_array().unwrap().len() + 1, "{name}");
    }
}

#[test]
fn a_run_renders_what_its_recording_renders() {
    let folder = tempfile::tempdir().unwrap();
    let [recording, from_run, from_recording] =
        ["r.mcap", "a.html", "r.html"].map(|name| folder.path().join(name));
    good(&["run", "--plant", "kinematic", "--record", text(&recording), "--render", text(&from_run)]);
    good(&["render", text(&recording), "--output", text(&from_recording)]);
    let [mut a, b] = [&from_run, &from_recording].map(|f| episode(&std::fs::read_to_string(f).unwrap()));
    assert_eq!((a["title"].take(), &b["title"]), ("the recording of this run".into(), &"r".into()));
    a["title"] = b["title"].clone();
    assert!(a == b);
}

#[test]
fn a_page_has_the_meshes_of_a_robot_whose_file_is_given() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let urdf = std::fs::read_to_string(repository("assets/robots/carrier.urdf")).unwrap();
    let base = "<geometry><cylinder radius=\"0.25\" length=\"0.36\"/></geometry>\n      <material";
    let mesh = "<geometry><mesh filename=\"base.stl\" scale=\"1 1 2\"/></geometry>\n      <material";
    assert!(urdf.contains(base));
    std::fs::write(path("carrier.urdf"), urdf.replacen(base, mesh, 1)).unwrap();
    std::fs::copy(repository("assets/robots/carrier.toml"), path("carrier.toml")).unwrap();
    std::fs::write(path("base.stl"), "solid base\nendsolid base\n").unwrap();
    let robot = path("carrier.toml");
    let run = ["run", "--plant", "kinematic", "--max-steps", "3", "--robot", text(&robot)];
    let output = cocarry(
        &[&run[..], &["--record", text(&path("r.mcap")), "--render", text(&path("run.html"))]].concat(),
    );
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    good(&["render", text(&path("r.mcap")), "-o", text(&path("with.html")), "--robot", text(&robot)]);
    good(&["render", text(&path("r.mcap")), "-o", text(&path("without.html"))]);
    let meshes = |name: &str| {
        let episode = episode(&std::fs::read_to_string(path(name)).unwrap());
        (episode["meshes"].as_array().unwrap().len(), episode["robot"][0]["shapes"][0].clone())
    };
    for name in ["run.html", "with.html"] {
        let (count, shape) = meshes(name);
        assert_eq!((count, &shape["mesh"], &shape["scale"][2]), (1, &0.into(), &2.0.into()), "{name}");
    }
    let (count, shape) = meshes("without.html");
    assert_eq!((count, &shape["cylinder"][0]), (0, &0.25.into()), "the collision shape");
    // the recording's own scene has the mesh, and the replay is identical without the files
    std::fs::remove_file(path("base.stl")).unwrap();
    let replayed = good(&["replay", text(&path("r.mcap"))]);
    assert!(replayed.contains("identical"), "{replayed}");
    let recorded = std::fs::read(path("r.mcap")).unwrap();
    let mut reader = cocarry_recording::recording::Reader::new(&recorded[..], "r").unwrap();
    let mut team = None;
    while let Some(entry) = reader.next().unwrap() {
        if let Some(message) = entry.message().filter(|m| m.channel.topic == "/scene/team") {
            team = cocarry_recording::recording::decode(message.channel, message.data);
        }
    }
    let team = team.expect("a team");
    let base = team["entities"].as_array().unwrap().iter().find(|e| e["frame_id"] == "robot/base_link");
    let model = &base.expect("the base")["models"][0];
    assert_eq!((&model["media_type"], &model["scale"]["y"]), (&"model/stl".into(), &2.0.into()));
    let other = repository("assets/robots/carrier.toml");
    refused(
        &["render", text(&path("r.mcap")), "-o", text(&path("x.html")), "--robot", text(&other)],
        &["is not the robot of the recording", "URDF"],
    );
}

/// The page that runs the simulator gets what the recording has of its scenario, at the address that is given.
#[test]
fn a_player_hands_its_episode_to_the_page_that_runs_the_simulator() {
    let folder = tempfile::tempdir().unwrap();
    let recording = repository("recordings/environment-4.mcap");
    let file = folder.path().join("page.html");
    for (flags, address) in [(&[][..], "http://127.0.0.1:8790/"), (&["--demo", "../demo/"], "../demo/")] {
        let render = [&["render", text(&recording), "--overwrite", "-o", text(&file)], flags].concat();
        good(&render);
        let take_over = &episode(&std::fs::read_to_string(&file).unwrap())["take_over"];
        assert_eq!((&take_over["address"], &take_over["log"]), (&json!(address), &Value::Null));
        let scenario = cocarry::scenario::Scenario::parse(take_over["scenario"].as_str().unwrap()).unwrap();
        assert_eq!((scenario.human.alpha, scenario.world.file()), (0.747, "environment-4"));
    }
    for address in ["javascript:alert(1)", "data:text/html,x", "", "http://a b/", "http://x/#y", "file:///x"]
    {
        let said =
            cocarry(&["render", text(&recording), "--overwrite", "-o", text(&file), "--demo", address]);
        assert_eq!(said.status.code(), Some(2), "{address}");
        assert!(stderr(&said).contains("--demo"), "{}", stderr(&said));
    }
    let picture = folder.path().join("page.svg");
    refused(
        &["render", text(&recording), "-o", text(&picture), "--demo", "x/"],
        &["--demo is for .html only"],
    );
}

/// Everything that a layout shows is recorded: options by their names in the colours of the player, and no
/// others.
#[test]
fn a_layout_shows_what_is_recorded_under_its_name_and_in_its_colour() {
    let folder = tempfile::tempdir().unwrap();
    for recording in recordings(folder.path()) {
        let name = recording.file_stem().unwrap().to_str().unwrap();
        let [file, page] = ["json", "html"].map(|end| folder.path().join(format!("{name}.{end}")));
        good(&["render", text(&recording), "-o", text(&file)]);
        good(&["render", text(&recording), "-o", text(&page)]);
        let layout: Value = serde_json::from_slice(&std::fs::read(&file).unwrap()).unwrap();
        let options = episode(&std::fs::read_to_string(&page).unwrap())["options"].take();
        let panels = layout["configById"].as_object().unwrap();
        let mut probabilities = Vec::new();
        for curve in panels.values().flat_map(|p| p["paths"].as_array().into_iter().flatten()) {
            let (topic, field) = curve["value"].as_str().unwrap().split_once('.').expect("a field");
            let table = table(&recording, topic);
            let index = field.split(['[', ']']).nth(1).map(|i| i.parse::<usize>().unwrap());
            let column = match index {
                Some(i) => {
                    probabilities.push(json!({ "name": curve["label"], "colour": curve["color"] }));
                    format!("options[{}].probability", options[i]["name"].as_str().unwrap())
                }
                None => field.to_owned(),
            };
            let recorded = table.iter().filter_map(|row| row[&column].parse::<f64>().ok()).count();
            assert!(recorded > 0, "{name}: nothing is recorded as {topic} {column}");
        }
        let expected = options.as_array().unwrap().iter().map(|option| {
            let words = format!("option {}", option["name"].as_str().unwrap());
            json!({ "name": words, "colour": option["colour"] })
        });
        assert_eq!(probabilities, expected.collect::<Vec<_>>(), "{name}");
        let placed = layout["layout"].to_string();
        for (id, panel) in panels {
            assert_eq!(placed.matches(&format!("\"{id}\"")).count(), 1, "{name}: {id} has one place");
            assert!(panel["foxglovePanelTitle"].is_string(), "{name}: {id}");
            assert_eq!(panel["foxglovePanelTitle"], panel["lichtblickPanelTitle"], "{name}: {id}");
            for topic in panel["topics"].as_object().into_iter().flat_map(|topics| topics.keys()) {
                assert!(topic.starts_with("/scene/"), "{name}: {topic}");
            }
        }
        let follows = name != "point";
        assert_eq!(panels.get("3D!team").is_some_and(|p| p["followTf"] == "object"), follows, "{name}");
        assert_eq!(panels.contains_key("Plot!force"), follows && name != "kinematic", "{name}");
    }
}

#[test]
fn what_cannot_be_rendered_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let shipped = repository("recordings/environment-4.mcap");
    refused(&["render", text(&shipped), "-o", "x.mp4"], &["x.mp4", ".html, .svg, .png, .gif, .json"]);
    refused(&["run", "--plant", "point", "--render", "x"], &["--render", ".html, .svg, .png, .gif, .json"]);
    for (name, flag, value, words) in [
        ("x.html", "--instants", "3", "--instants is for .svg and .png only"),
        ("x.gif", "--instants", "3", "--instants is for .svg and .png only"),
        ("x.html", "--width", "3.5in", "--width is for .svg, .png and .gif only"),
        ("x.png", "--robot", "r.toml", "--robot is for .html only"),
        ("x.png", "--width", "12", "3.5in or 1200px"),
        ("x.png", "--width", "1in", "from 2in to 20in"),
        ("x.png", "--width", "NaNpx", "from 300px to 6000px"),
        ("x.png", "--instants", "1", "2..=20"),
    ] {
        refused(&["render", text(&shipped), "-o", text(&path(name)), flag, value], &[words]);
    }

    let bytes = std::fs::read(&shipped).unwrap();
    let output = path("x.html");
    let render = |recording: &Path, words: &[&str]| {
        refused(&["render", text(recording), "-o", text(&output)], words);
        assert!(!output.exists(), "{words:?}");
    };
    std::fs::write(path("cut.mcap"), &bytes[..bytes.len() / 2]).unwrap();
    render(&path("cut.mcap"), &["cut.mcap", "is cut at byte", "recover"]);
    let mut spoiled = bytes.clone();
    let middle = spoiled.len() / 2;
    spoiled[middle] ^= 0x40;
    std::fs::write(path("spoiled.mcap"), &spoiled).unwrap();
    render(&path("spoiled.mcap"), &["spoiled.mcap", "at byte"]);
    std::fs::write(path("other.mcap"), "no recording").unwrap();
    render(&path("other.mcap"), &["other.mcap", "is not an MCAP file"]);
    render(&path("missing.mcap"), &["missing.mcap"]);

    // an input is never an output, whatever its name
    std::fs::write(path("in.html"), &bytes).unwrap();
    refused(
        &["render", text(&path("in.html")), "-o", text(&path("in.html")), "--overwrite"],
        &["is an input of this command"],
    );
    assert!(std::fs::read(path("in.html")).unwrap() == bytes);
}

/// The numbers of an attribute of SVG elements.
fn attribute(svg: &str, name: &str) -> Vec<f64> {
    let begin = format!(" {name}=\"");
    let found = svg.split(&begin).skip(1);
    found.filter_map(|rest| rest.split('"').next()?.parse().ok()).collect()
}

#[test]
fn a_filmstrip_is_as_wide_as_asked_with_legible_type() {
    let folder = tempfile::tempdir().unwrap();
    for recording in recordings(folder.path()) {
        let name = recording.file_stem().unwrap().to_str().unwrap();
        let [column, page, image] =
            ["c.svg", "p.svg", "i.png"].map(|end| folder.path().join(format!("{name}-{end}")));
        good(&["render", text(&recording), "-o", text(&column), "--width", "3.5in", "--instants", "4"]);
        good(&["render", text(&recording), "-o", text(&page)]);
        for (file, inches, instants) in [(&column, 3.5, 4), (&page, 7.0, 6)] {
            let svg = std::fs::read_to_string(file).unwrap();
            assert!(
                svg.starts_with("<svg ") && svg.contains(&format!("width=\"{inches:.3}in\"")),
                "{svg:.300}"
            );
            let (_, layout) = svg.split_once("viewBox=\"0 0 ").expect("a view box");
            let layout: f64 = layout.split(' ').next().unwrap().parse().unwrap();
            let points = 72.0 * inches / layout;
            // of lines and of indices
            let smallest = attribute(&svg, "font-size").into_iter().fold(f64::MAX, f64::min);
            assert!(smallest * points >= 7.0, "{name}: {smallest} px at {points} pt a px");
            assert!((instants - 1..=instants).contains(&(svg.matches("class=\"team\"").count())), "{name}");
            assert!(svg.contains("stubbornness") && svg.contains("threshold 1"), "{name}");
        }
        good(&["render", text(&recording), "-o", text(&image), "--width", "640px"]);
        let image = std::fs::read(&image).unwrap();
        assert_eq!(&image[..8], b"\x89PNG\r\n\x1a\n", "{name}");
        assert_eq!(u32::from_be_bytes(image[16..20].try_into().unwrap()), 640, "{name}");
    }
}

#[test]
fn a_moving_picture_shows_every_step_at_twice_the_speed_in_a_small_file() {
    let folder = tempfile::tempdir().unwrap();
    let recording = repository("recordings/environment-4.mcap");
    let [file, again] = ["a.gif", "b.gif"].map(|name| folder.path().join(name));
    for file in [&file, &again] {
        good(&["render", text(&recording), "-o", text(file), "--width", "480px"]);
    }
    let bytes = std::fs::read(&file).unwrap();
    assert!(bytes == std::fs::read(&again).unwrap(), "equal recordings give equal bytes");
    assert!(bytes.len() < 1_500_000, "{} bytes", bytes.len());
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(&bytes[..]).unwrap();
    assert_eq!(decoder.width(), 480);
    let mut delays = Vec::new();
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        delays.push(frame.delay);
    }
    let steps = table(&recording, "/coordination").len();
    assert_eq!(delays.len(), steps + 1);
    assert!(delays[..steps].iter().all(|delay| *delay == 10), "{delays:?}");
}

#[test]
fn the_page_that_ships_is_built_from_the_sources_that_ship() {
    let is_built =
        is_built_of("assets/player.html", "viewer", &["build.mjs", "package-lock.json", "package.json"]);
    assert!(is_built, "build it anew: cd viewer && npm ci && node build.mjs");
}
