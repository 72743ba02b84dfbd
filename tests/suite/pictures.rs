//! Pictures compared by tolerance, because rasterisers round: goldens of a small recording, and the book's.

use crate::support::{cocarry, repository, stderr};
use resvg::tiny_skia::Pixmap;
use std::path::Path;

/// Set to anything: goldens and the book's pictures are written anew, not compared.
const UPDATE: &str = "COCARRY_UPDATE_BOOK";
/// The largest mean difference of a channel, and the largest share of pixels that differ by more than
/// `VISIBLE` in a channel; of 255.
const MEAN: f64 = 0.5;
const SHARE: f64 = 0.002;
const VISIBLE: u8 = 48;

fn is_updating() -> bool {
    std::env::var_os(UPDATE).is_some()
}

/// The pixels of a PNG file, or of a GIF file at one of its pictures.
fn pixels(bytes: &[u8], picture: usize) -> Pixmap {
    if bytes.starts_with(b"\x89PNG") {
        return Pixmap::decode_png(bytes).expect("a PNG");
    }
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(bytes).expect("a GIF");
    let (width, height) = (usize::from(decoder.width()), usize::from(decoder.height()));
    let mut canvas = Pixmap::new(width as u32, height as u32).expect("a size");
    for _ in 0..=picture {
        let frame = decoder.read_next_frame().expect("a GIF").expect("so many pictures");
        let (left, top) = (usize::from(frame.left), usize::from(frame.top));
        for (i, pixel) in frame.buffer.chunks_exact(4).enumerate().filter(|(_, pixel)| pixel[3] > 0) {
            let (x, y) = (left + i % usize::from(frame.width), top + i / usize::from(frame.width));
            canvas.data_mut()[4 * (y * width + x)..][..4].copy_from_slice(pixel);
        }
    }
    canvas
}

/// What differs visibly between two pictures, as words; `None` if nothing does.
fn difference(a: &Pixmap, b: &Pixmap) -> Option<String> {
    if (a.width(), a.height()) != (b.width(), b.height()) {
        return Some(format!("{} x {} and {} x {} pixels", a.width(), a.height(), b.width(), b.height()));
    }
    let off = |(a, b): (&u8, &u8)| a.abs_diff(*b);
    let total: u64 = a.data().iter().zip(b.data()).map(|pair| u64::from(off(pair))).sum();
    let mean = total as f64 / a.data().len() as f64;
    let pairs = a.data().chunks_exact(4).zip(b.data().chunks_exact(4));
    let visible = pairs.filter(|(a, b)| a.iter().zip(*b).any(|pair| off(pair) > VISIBLE)).count();
    let share = visible as f64 / f64::from(a.width() * a.height());
    (mean > MEAN || share > SHARE)
        .then(|| format!("mean difference {mean:.3}, {:.3} % visible", 100.0 * share))
}

/// Compares a picture with a file, or writes the file.
fn settle(file: &str, made: &[u8]) {
    let path = repository(file);
    if is_updating() {
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        return std::fs::write(path, made).expect("it is written");
    }
    let shown = std::fs::read(&path).unwrap_or_else(|e| panic!("{file}: {e}"));
    if let Some(difference) = difference(&pixels(&shown, 0), &pixels(made, 0)) {
        panic!("{file}: {difference}; look at it, and write it anew with {UPDATE}=1");
    }
}

/// Numbers of an SVG, which are compared by tolerance, and the text between them.
fn numbers(svg: &str) -> (Vec<f64>, String) {
    let is_part = |c: char| c.is_ascii_digit() || c == '.';
    let (mut found, mut rest, mut text) = (Vec::new(), svg, String::new());
    while let Some(at) = rest.find(is_part) {
        let end = rest[at..].find(|c| !is_part(c)).map_or(rest.len(), |length| at + length);
        text += &rest[..at];
        text.push('#');
        match rest[at..end].parse() {
            Ok(number) => found.push(number),
            Err(_) => text += &rest[at..end],
        }
        rest = &rest[end..];
    }
    (found, text + rest)
}

fn render(recording: &Path, to: &Path, more: &[&str]) -> Vec<u8> {
    let names = [recording, to].map(|path| path.to_str().expect("UTF-8"));
    let output = cocarry(&[&["render", names[0], "-o", names[1]], more].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    std::fs::read(to).expect("it is written")
}

#[test]
fn golden_filmstrips_and_a_moving_picture_of_a_small_recording() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let recording = path("small.mcap");
    let run =
        ["run", "environment-3", "--seed", "2", "--plant", "kinematic", "--max-steps", "40", "--record"];
    let output = cocarry(&[&run[..], &[recording.to_str().unwrap()]].concat());
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    let strip = ["--width", "3.5in", "--instants", "4"];
    let svg = String::from_utf8(render(&recording, &path("strip.svg"), &strip)).unwrap();
    let png = render(&recording, &path("strip.png"), &["--width", "480px", "--instants", "4"]);
    let gif = render(&recording, &path("moving.gif"), &["--width", "480px"]);
    settle("tests/fixtures/pictures/strip.png", &png);
    // one picture of the GIF, of which the file would be large
    let picture = pixels(&gif, 25).encode_png().unwrap();
    settle("tests/fixtures/pictures/moving-25.png", &picture);
    let file = repository("tests/fixtures/pictures/strip.svg");
    if is_updating() {
        return std::fs::write(file, svg).unwrap();
    }
    let shown = std::fs::read_to_string(file).unwrap();
    let ((found, text), (expected, wanted)) = (numbers(&svg), numbers(&shown));
    assert_eq!(text, wanted, "strip.svg has other parts: look at it, and write it anew with {UPDATE}=1");
    let off = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(found.len() == expected.len() && off < 0.5, "strip.svg: a number differs by {off} px");
}

#[test]
fn the_comparison_sees_a_label_that_moved_and_forgives_rounding() {
    let golden = std::fs::read(repository("tests/fixtures/pictures/strip.png")).unwrap();
    let golden = pixels(&golden, 0);
    let mut rounded = golden.clone();
    rounded.data_mut().iter_mut().step_by(3).for_each(|c| *c = c.saturating_sub(1));
    assert_eq!(difference(&golden, &rounded), None);
    let mut moved = golden.clone();
    let row = 4 * golden.width() as usize;
    moved.data_mut().copy_within(..row * 40, row * 3);
    assert!(difference(&golden, &moved).is_some());
}

/// The book's filmstrip, by the command next to it.
#[test]
fn the_filmstrip_of_environment_4_is_of_the_present_program() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("environment-4.mcap");
    let run = "run environment-4 --alpha 0.747 --gamma 0.765 --eta 5 --record";
    let words: Vec<&str> = run.split(' ').chain([recording.to_str().unwrap()]).collect();
    assert!(cocarry(&words).status.success());
    let name = "environment-4-filmstrip.png";
    let made = render(&recording, &folder.path().join(name), &[]);
    settle(&format!("book/src/pictures/{name}"), &made);
}

/// `viewer/picture` notes in the moving picture which command it filmed, and what happened: the README's own.
#[test]
fn the_moving_picture_shows_the_episode_that_the_readme_prints_below_it() {
    let readme = std::fs::read_to_string(repository("README.md")).unwrap();
    let (_, episode) = readme.split_once("\n$ cocarry run").expect("a command");
    let command = episode.lines().next().and_then(|line| line.split("  ").next()).unwrap();
    let (_, events) = episode.split_once("\nEvents\n").expect("events");
    let (events, _) = events.split_once("\n\n").unwrap();
    let note = format!("cocarry run{command}\nEvents\n{events}\n");
    for page in ["README.md", "book/src/quick-start.md"] {
        let page = std::fs::read_to_string(repository(page)).unwrap();
        let first = page.split("![").nth(1).and_then(|picture| picture.lines().next()).expect("a picture");
        assert!(
            first.contains("pictures/environment-4.webp"),
            "{first}: the first picture is the moving one"
        );
    }
    let picture = std::fs::read(repository("book/src/pictures/environment-4.webp")).unwrap();
    let is_noted = picture.windows(note.len()).any(|part| part == note.as_bytes());
    assert!(is_noted, "the moving picture is of another episode: make it anew with viewer/picture");
}

/// Compares an SVG of the book with what the program draws, or writes it.
pub fn settle_text(file: &str, made: &str) {
    if is_updating() {
        return std::fs::write(repository(file), made).unwrap();
    }
    let shown = std::fs::read_to_string(repository(file)).unwrap();
    assert!(shown == made, "{file} is of an earlier program; write it anew with {UPDATE}=1");
}

/// `viewer/test/lichtblick` notes in the picture which recording it shows: the one that ships, or the page
/// says that it is of an earlier one.
#[test]
fn the_picture_of_a_viewer_shows_the_recording_that_ships() {
    let recording = std::fs::read(repository("recordings/environment-4.mcap")).unwrap();
    let note = format!("recording {:08x}", crc32fast::hash(&recording));
    let picture = std::fs::read(repository("book/src/pictures/lichtblick-environment-4.png")).unwrap();
    let is_noted = picture.windows(note.len()).any(|part| part == note.as_bytes());
    let page = std::fs::read_to_string(repository("book/src/recordings.md")).unwrap();
    let is_earlier = page.contains("as it was with 240 physics steps a second, in Lichtblick");
    assert!(
        is_noted != is_earlier,
        "the picture is of another recording: make it anew with viewer/test/lichtblick"
    );
}

/// Maps at the width of a column have type of at least 7 pt, too.
#[test]
fn maps_are_drawn_at_the_width_of_a_column() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("map.svg");
    let name = file.to_str().unwrap();
    for command in [
        &["world", "free-form"][..],
        &["world", "environment-2"],
        &["run", "environment-3", "--plant", "point"],
    ] {
        let output = cocarry(&[command, &["--svg", name, "--width", "3.5in", "--overwrite"]].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        let svg = std::fs::read_to_string(&file).unwrap();
        assert!(svg.contains(" width=\"3.500in\""), "{command:?}");
        let number = |text: &str| -> f64 { text.split(['"', ' ']).next().unwrap().parse().unwrap() };
        let layout = number(svg.split_once("viewBox=\"0 0 ").unwrap().1);
        let sizes: Vec<f64> = svg.split("font-size=\"").skip(1).map(number).collect();
        assert!(
            sizes.len() > 10 && sizes.iter().all(|size| size * 252.0 / layout >= 7.0),
            "{command:?} {layout} {sizes:?}"
        );
        let is_short = command[1] == "free-form";
        assert_eq!(svg.contains("widths without room are left out"), is_short, "{command:?}");
    }
    let refused = cocarry(&["world", "free-form", "--width", "3.5in"]);
    assert_eq!(refused.status.code(), Some(2));
}
