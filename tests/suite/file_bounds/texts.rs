//! Texts: worlds, settings, URDFs, xacros, tables.

use super::{Bench, environment_4};
use crate::spoiled_robot::{TOML, URDF, original};
use crate::support::time_for;

/// Obstacles of notches, or round ones, far from the walls and `apart` (m) from each other.
fn obstacles(count: usize, corners: usize, size: f64, notch: f64, apart: f64) -> String {
    let mut text = String::new();
    for i in 0..count {
        let (x, y) = (100.0 + apart * (i % 100) as f64, 100.0 + apart * (i / 100) as f64);
        text +=
            &format!("[[obstacle]]\nname = \"o{i}\"\nheight_m = 1.0\nshape = \"polygon\"\nvertices_m = [");
        for corner in 0..corners {
            let angle = std::f64::consts::TAU * corner as f64 / corners as f64;
            let radius = if corner % 2 == 0 { size } else { size * notch };
            let (sine, cosine) = cocarry::math::sin_cos(angle);
            text += &format!("[{:.4},{:.4}],", x + radius * cosine, y + radius * sine);
        }
        text += "]\n";
    }
    text
}

pub(super) fn worlds(bench: Bench) {
    let world = environment_4();
    // openings that are found are the longest work
    let (found, _) = world.split_once("[[opening]]").expect("openings");
    for text in [
        bench.filled(&world, "# x\n"),
        bench.filled(&(world.clone() + &obstacles(200, 20, 1.0, 0.6, 3.0)), "\n"),
        bench.filled(&(found.to_owned() + &obstacles(1, 2500, 1.0, 0.6, 3.0)), "# x\n"),
        bench.filled(&(found.to_owned() + &obstacles(1, 20_000, 90.0, 1.0, 3.0)), "# x\n"),
        bench.filled(&(found.to_owned() + &obstacles(120, 64, 0.02, 1.0, 0.05)), "# x\n"),
    ] {
        bench.write("w.toml", &text);
        bench.reads("world w.toml");
        bench.write("w.toml", text + "\n");
        bench.refuses("world w.toml", &bench.too_long());
    }
    for (count, corners, size, apart) in
        [(1, 20_000, 1.0, 3.0), (1, 20_000, 90.0, 3.0), (1500, 64, 0.02, 0.05)]
    {
        let notch = if count == 1 { 0.6 } else { 1.0 };
        bench.write("w.toml", found.to_owned() + &obstacles(count, corners, size, notch, apart));
        bench.refuses("world w.toml", "w.toml: too many walls and parts of outlines within 2.5 m");
    }
    // much structure in few bytes
    for piece in
        ["a=[[[],[],[],", "[[obstacle]]\n", "x.y.z=1\n", "[a.b.c.d.e]\n", "[x]\nx={x={x={", "a.", "[a."]
    {
        bench.write("w.toml", bench.filled("", piece));
        bench.refuses("world w.toml", "w.toml");
    }
    // keys of a million parts
    for (begin, end) in [("", "a=1"), ("[", "a]\n"), ("[[", "a]]\n"), ("a={", "a=1}")] {
        bench.write("w.toml", format!("{begin}{}{end}", "a.".repeat(bench.longest() / 2 - 10)));
        bench.refuses("world w.toml", "w.toml");
    }
}

pub(super) fn settings(bench: Bench) {
    let study = "worlds = \"environment-1\"\nplants = \"point\"\nmax_steps = 1\nseeds = 1\n";
    bench.write("s.toml", bench.filled(study, "# x\n"));
    bench.reads("sweep s.toml");
    bench.write("s.toml", bench.filled(study, "# x\n") + "\n");
    bench.refuses("sweep s.toml", &bench.too_long());
    // one file of a world by many names
    let named = |i: usize| format!("\"{}.{}/w.toml\"", "./".repeat(i % 32), "/".repeat(i / 32));
    for (world, count, words) in [
        (environment_4(), 1001, "more than 1000 worlds"),
        (
            environment_4() + &"# x\n".repeat(1 << 20)[200_000..],
            20,
            "more than 67108864 bytes of worlds and robots",
        ),
    ] {
        bench.write("w.toml", world);
        let names = (0..count).map(named).collect::<Vec<_>>().join(", ");
        bench.write("s.toml", format!("worlds = [{names}]\nplants = \"point\"\nseeds = 1\n"));
        bench.refuses("sweep s.toml", words);
    }
    bench.write(URDF, original(URDF));
    bench.write(TOML, bench.filled(&original(TOML), "# x\n"));
    bench.reads("robot check carrier.toml");
    // as many postures as fit
    let posture = original(TOML);
    let posture = &posture[posture.find("[[posture]]").expect("a posture")..];
    let mut text = original(TOML);
    for i in 0.. {
        let next = posture.replace("name = \"", &format!("name = \"{i}-"));
        if text.len() + next.len() > bench.longest() {
            break;
        }
        text += &next;
    }
    bench.write(TOML, text);
    bench.run("robot check carrier.toml");
    bench.write(TOML, bench.filled(&original(TOML), "# x\n") + "\n");
    bench.refuses("robot check carrier.toml", &bench.too_long());
    for piece in ["a=[[[],[],[],", "[[run]]\n", "[[posture]]\n", "x.y.z=1\n", "[a.b.c.d.e]\n"] {
        bench.write("s.toml", bench.filled("", piece));
        for line in ["sweep s.toml", "run --robot s.toml", "regress check s.toml"] {
            bench.refuses(line, "s.toml");
        }
    }
}

/// A URDF of the greatest length: links in a chain or side by side, then comments.
fn many_links(bench: &Bench, count: usize, is_chain: bool) -> String {
    let mut text = original(URDF);
    text.truncate(text.rfind("</robot>").expect("its end"));
    for i in 0..count {
        let parent = if i == 0 || !is_chain { "base_link".to_owned() } else { format!("l{}", i - 1) };
        text += &format!(
            "<link name=\"l{i}\"><collision><geometry><box size=\".1 .1 .1\"/></geometry></collision></link>\
             <joint name=\"j{i}\" type=\"fixed\"><parent link=\"{parent}\"/><child link=\"l{i}\"/></joint>\n"
        );
    }
    let end = "</robot>";
    let mut text = bench.filled(&(text + end), "\n");
    text.truncate(text.trim_end().len() - end.len());
    bench.filled(&text, "\n")[..bench.longest() - end.len()].to_owned() + end
}

pub(super) fn urdfs(bench: Bench) {
    bench.write(TOML, original(TOML));
    for (count, is_chain) in [(6500, false), (6500, true)] {
        let text = many_links(&bench, count, is_chain);
        bench.write(URDF, &text);
        bench.reads("robot check carrier.toml");
        bench.write(URDF, text + "\n");
        bench.refuses("robot check carrier.toml", &bench.too_long());
    }
    for piece in ["<a/>", "<a>", "<a b='' c=''/>", "&amp;", "<!-- -->", "<link name='a'/>", "<a xmlns:a='b'>"]
    {
        bench.write(URDF, bench.filled("<robot name='r'>", piece));
        bench.refuses("robot check carrier.toml", "carrier.urdf");
    }
}

/// What the program `xacro` prints is read as a URDF; the program itself has its limits in
/// [`xacros`](crate::xacros).
#[cfg(unix)]
pub(super) fn xacros(bench: Bench) {
    use std::os::unix::fs::PermissionsExt;
    bench.write("xacro", "#!/bin/sh\ncat expanded\n");
    std::fs::set_permissions(bench.path("xacro"), PermissionsExt::from_mode(0o755)).unwrap();
    bench.write(TOML, original(TOML).replace("carrier.urdf", "carrier.urdf.xacro"));
    bench.write("carrier.urdf.xacro", "");
    let text = many_links(&bench, 6500, false);
    bench.write("expanded", &text);
    // the memory is that of the child, which the program sets itself
    let line = "robot check carrier.toml --xacro";
    let with_path = |line: &str| {
        let path = format!("{}:{}", bench.folder().display(), std::env::var("PATH").unwrap());
        let begun = std::time::Instant::now();
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_cocarry"));
        let output = command.args(line.split(' ')).env("PATH", path).current_dir(bench.folder()).output();
        assert!(begun.elapsed() < time_for(2 * bench.bounds.seconds), "{:?}", begun.elapsed());
        output.unwrap()
    };
    let output = with_path(line);
    assert!(output.status.success(), "{}", crate::support::stderr(&output));
    bench.write("expanded", text + "\n");
    let said = crate::support::stderr(&with_path(line));
    assert!(said.contains(&format!("`xacro` prints more than {} bytes", bench.longest())), "{said}");
}

#[cfg(not(unix))]
pub(super) fn xacros(_: Bench) {}

/// Rows for as many people as may be, then empty lines.
fn of_people(bench: &Bench, people: usize, header: &str, of_person: impl Fn(usize) -> String) -> String {
    let mut text = header.to_owned();
    for person in 0..people {
        let rows = of_person(person);
        if text.len() + rows.len() > bench.longest() {
            break;
        }
        text += &rows;
    }
    bench.filled(&text, "\n")
}

/// A file of a million columns, or of one kind of cell.
fn malformed_tables(bench: &Bench) {
    bench.write("a.csv", bench.filled("participant,world,option,percent", ",x"));
    bench.refuses("fit risk-weight a.csv", "a.csv");
    bench.write("a.csv", bench.filled("participant,world,option,percent\n", ","));
    bench.refuses("infer a.csv", "a.csv:2");
    for line in ["infer a.csv", "fit eta a.csv", "fit risk-weight a.csv", "run --belief-samples a.csv"] {
        for piece in ["participant,", "a\n", "\"\n", "alpha,gamma\n", "\"\""] {
            bench.write("a.csv", bench.filled("", piece));
            bench.refuses(line, "a.csv");
        }
    }
}

pub(super) fn tables(bench: Bench) {
    malformed_tables(&bench);
    // as many people, and as many rows of few people, as fit
    let switch = |person: usize| format!("p{person},environment-1,1,{}\n", 20 + person % 20);
    let header = "participant,world,option,step\n";
    bench.write("s.csv", of_people(&bench, 20_000, header, switch));
    bench.reads("fit eta s.csv");
    bench.write("s.csv", of_people(&bench, 20_001, header, switch));
    bench.refuses("fit eta s.csv", "20001 participants; at most 20000 are read at once");
    let trials = |i: usize| format!("p{},environment-1,1,20,{i}\n", i % 10);
    bench.write("s.csv", of_people(&bench, 1_000_000, "participant,world,option,step,trial\n", trials));
    bench.reads("fit eta s.csv");
    let answer = |person: usize| -> String {
        let percent = |option: usize| if option == 1 + person % 4 { 100 } else { 0 };
        (1..=4).map(|option| format!("p{person},environment-1,{option},{}\n", percent(option))).collect()
    };
    let header = "participant,world,option,percent\n";
    let answers = of_people(&bench, 20_000, header, answer);
    bench.write("a.csv", &answers);
    bench.reads("fit risk-weight a.csv");
    bench.write("a.csv", answers + "\n");
    bench.refuses("fit risk-weight a.csv", &bench.too_long());
    bench.refuses("infer a.csv", &bench.too_long());
    bench.write("a.csv", of_people(&bench, 20_001, header, answer));
    bench.refuses("infer a.csv", "20001 participants");
    // one file of a world by many names
    bench.write("w.toml", environment_4());
    let named = |i: usize| format!("p,{}w.toml,1,100\n", "./".repeat(i));
    bench.write("a.csv", of_people(&bench, 1001, header, named));
    bench.refuses("infer a.csv", "1001 worlds; at most 1000");
    let samples = bench.filled("alpha,gamma\n", "0.7,0.8\n").trim_end().to_owned() + "\n";
    bench.write("s.csv", &samples);
    let output = bench.run("run --plant point --max-steps 2 --belief-samples s.csv");
    assert!(matches!(output.status.code(), Some(2 | 3)), "{output:?}");
}
