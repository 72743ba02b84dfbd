//! Floor plans drawn as SVG.

use super::{assert_same_options, by_hand, ends, head};
use crate::support::{cocarry, stderr};
use cocarry::geometry::{Point, direction};
use cocarry::world::World;

/// Walls as a filled ring and as thick lines, a pillar in a group that is moved and turned, on white paper
/// with a note: the room in metres.
#[test]
fn a_floor_plan_drawn_as_svg_is_the_room_drawn_by_hand() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let plan = |size: &str| {
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 9000 6000\" {size}>\
             <rect width=\"9000\" height=\"6000\" fill=\"white\"/>\
             <path id=\"walls\" fill-rule=\"evenodd\" d=\"M0 0H9000V6000H0Z M200 200V5800H8800V200Z\"/>\
             <g id=\"wall\" fill=\"none\" stroke=\"#333\" stroke-width=\"200\">\
             <path d=\"M4100 5800V4500M4100 3600V1900\"/><line id=\"end\" x1=\"4100\" y1=\"700\" x2=\"4100\" y2=\"200\"/></g>\
             <g transform=\"translate(6200 3000) rotate(90)\"><rect id=\"pillar\" x=\"-200\" y=\"-200\" width=\"400\" height=\"400\"/></g>\
             <text x=\"300\" y=\"300\">Room</text></svg>"
        )
    };
    std::fs::write(file("room.toml"), head([0.0; 3]) + "[map]\nfile = \"plan.svg\"\nunit = \"mm\"\n")
        .unwrap();
    let find = || cocarry_maps::find(&file("room.toml"), "room.toml");
    let drawn = World::parse("room", &by_hand([0.0; 3])).unwrap();
    // many programs name the type of the document
    let declared = "<!DOCTYPE svg PUBLIC \"-//W3C//DTD SVG 1.1//EN\" \"http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd\">\n";
    // as large as its view box, and on paper of another shape
    for (before, size) in [("", ""), ("", "width=\"450\" height=\"600\""), (declared, "")] {
        std::fs::write(file("plan.svg"), format!("{before}{}", plan(size))).unwrap();
        let world = find().unwrap_or_else(|error| panic!("{error}"));
        assert_same_options(&drawn, &world, [1e-4; 2]);
        let names: Vec<&str> = world.obstacles.iter().map(|obstacle| obstacle.name.as_str()).collect();
        assert!(names.contains(&"walls") && names.contains(&"pillar") && names.contains(&"end"), "{names:?}");
    }
    std::fs::write(
        file("plan.svg"),
        "<svg xmlns=\"http://www.w3.org/2000/svg\"><circle r=\"1\" fill=\"none\"/></svg>",
    )
    .unwrap();
    let refused = find().unwrap_err().to_string();
    assert!(refused.contains("plan.svg") && refused.contains("without obstacles"), "{refused}");
    std::fs::write(file("plan.svg"), &plan("")[..300]).unwrap();
    assert!(find().unwrap_err().to_string().contains("not a valid SVG file"));
}

/// A drawing may name any file. One that is read would hang here: a pipe without a writer.
#[test]
#[cfg(unix)]
fn pictures_in_a_drawing_are_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let made = std::process::Command::new("mkfifo").arg(file("pipe")).status().unwrap();
    assert!(made.success());
    let svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 10 6\"><circle cx=\"5\" cy=\"2\" r=\"1\"/>\
         <image width=\"1\" height=\"1\" href=\"{}\"/></svg>",
        file("pipe").display()
    );
    std::fs::write(file("plan.svg"), svg).unwrap();
    let (sent, received) = std::sync::mpsc::channel();
    let path = file("plan.svg");
    std::thread::spawn(move || {
        let place = ["--start", "1,4", "--target", "9,4"];
        let output = cocarry(&[&["world", path.to_str().unwrap()][..], &place].concat());
        sent.send(output.status.code())
    });
    let code = received.recv_timeout(std::time::Duration::from_secs(60));
    assert_eq!(code, Ok(Some(0)), "the pipe was opened");
}

#[test]
fn a_drawing_with_too_many_corners_is_refused_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plan.svg");
    let rings: String = (0..60_000).map(|i| format!("M{} {}h.01v.01h-.01z", i % 100, i / 100)).collect();
    let svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 100 600\"><path d=\"{rings}\"/></svg>"
    );
    std::fs::write(&path, svg).unwrap();
    let output = cocarry(&["world", path.to_str().unwrap(), "--start", "1,1", "--target", "9,9"]);
    assert_eq!(output.status.code(), Some(2));
    let said = stderr(&output);
    assert!(said.contains("plan.svg: its areas and lines have more than 20000 corners"), "{said}");
}

/// A round table is round to half a centimetre, and a hole in it is free.
#[test]
fn curves_of_a_drawing_are_followed() {
    let folder = tempfile::tempdir().unwrap();
    let svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 10 6\"><circle cx=\"5\" cy=\"2\" r=\"1\"/></svg>";
    std::fs::write(folder.path().join("plan.svg"), svg).unwrap();
    let text = "name = \"table\"\nrobot_width_m = 0.5\nstart_m = [1, 4]\ntarget_m = [9, 4]\n[map]\nfile = \"plan.svg\"\n";
    let path = folder.path().join("table.toml");
    std::fs::write(&path, text).unwrap();
    let world = cocarry_maps::find(&path, "table.toml").unwrap_or_else(|error| panic!("{error}"));
    for i in 0..100 {
        let p = Point::new(5.0, 4.0) + direction(0.0628 * f64::from(i)) * 1.5;
        let distance = world.obstacles[0].distance_to_point(p);
        assert!((distance - 0.5).abs() < 0.006, "{distance} m at {p}");
    }
}

/// What refers to what refers to more, elements in elements, and rules that are compared with every element.
#[test]
fn a_small_drawing_that_asks_for_much_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plan.svg");
    let groups: String = (1..10)
        .map(|i| format!("<g id=\"g{i}\">{}</g>", format!("<use href=\"#g{}\"/>", i - 1).repeat(10)))
        .collect();
    let patterns: String = (1..12)
        .map(|i| {
            format!(
                "<pattern id=\"g{i}\">{}</pattern>",
                format!("<path d=\"M0 0H1V1z\" fill=\"url(#g{})\"/>", i - 1).repeat(8)
            )
        })
        .collect();
    let first = "<g id=\"g0\"><path d=\"M0 0H1V1z\"/></g>";
    let rules: String = (0..3000).map(|i| format!(".a{i} {{fill:red}}")).collect();
    for (content, said) in [
        (format!("{first}{groups}"), "more than 300000 elements, with those that others refer to"),
        (format!("{first}{patterns}"), "more than 300000 elements, with those that others refer to"),
        ("<g>".repeat(20_000) + &"</g>".repeat(20_000), "depth of its elements = 129"),
        (format!("<style>{rules}</style>{}", "<g/>".repeat(10_000)), "3000 rules of style"),
        (
            format!(
                "<marker id=\"m\"><path d=\"M0 0\"/></marker><path style=\"marker-mid:url(#m)\" d=\"{}\"/>",
                "M1 1".repeat(200_000)
            ),
            "more than 300000 elements",
        ),
    ] {
        let svg = format!("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 10 6\">{content}</svg>");
        std::fs::write(&path, svg).unwrap();
        let begun = std::time::Instant::now();
        let error = cocarry_maps::from_map(&path, &ends([0.0; 3])).expect_err("refused");
        let error = format!("{:#}", anyhow::Error::from(error));
        assert!(error.contains("plan.svg: not a valid SVG file") && error.contains(said), "{error}");
        assert!(begun.elapsed() < crate::support::time_for(5), "{said}: {:?}", begun.elapsed());
    }
}
