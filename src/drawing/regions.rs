//! The regions of the (alpha, gamma) plane and P_o in; the figure of them out: each region with its option's name and P_o in it.

use super::DrawingError;
use super::axis::Scale;
use super::labels::length_inside;
use super::scene::{document, rectangle};
use super::style::{INK, LARGE, Look, SMALL, number, path_data, px, stroke};
use super::text::{Align, Words, shorten};
use crate::geometry::{Bounds, Point, Vector};
use crate::preference::{Perception, Regions};
use svg::node::element::{Group, Path};

/// The regions of one world.
#[derive(Clone, Debug, PartialEq)]
pub struct RegionPanel {
    /// Stands above the panel; long ones are shortened.
    pub title: String,
    /// Which option is preferred where.
    pub regions: Regions,
    /// Every option's name and P_o.
    pub options: Vec<(String, f64)>,
}

/// Panels in a row.
const ACROSS: usize = 2;
/// Size of a panel's frame, px.
const SIZE: Vector = Vector::new(262.0, 240.0);
/// Left side of the first column, and the distance from one to the next, px.
const LEFT: f64 = 78.0;
const PITCH: f64 = 360.0;
/// Room above a panel, and below it with the numbers and the line of options that nobody prefers, px.
const ABOVE: f64 = 36.0;
const BELOW: f64 = 88.0;
/// Distance between the lines of a hatching, px.
const HATCH: f64 = 11.0;
/// Paper of a region, from light to dark; with its hatching and its name it is told from the others in grey too.
const PAPERS: [&str; 4] = ["#ffffff", "#d3d9e6", "#efe3c8", "#b9cdbf"];

/// Which option a human with every (alpha, gamma) prefers, two panels in a row.
///
/// Regions differ in paper and hatching, and carry the option's name and P_o; below a panel stand the options that nobody prefers. Every
/// region is one path with `data-option`, the option's index, whose area is its share of the frame.
///
/// # Errors
/// [`DrawingError::NoPanels`]; [`DrawingError::Probability`] for what is not a number from 0 to 1; [`DrawingError::ProbabilityCount`].
pub fn preference_regions(panels: &[RegionPanel]) -> Result<String, DrawingError> {
    if panels.is_empty() {
        return Err(DrawingError::NoPanels);
    }
    let rows = panels.len().div_ceil(ACROSS) as f64;
    let mut picture = document(rows * (ABOVE + SIZE.y + BELOW) + 4.0);
    for (i, panel) in panels.iter().enumerate() {
        check(panel)?;
        let (row, column) = ((i / ACROSS) as f64, (i % ACROSS) as f64);
        let min = Point::new(LEFT + column * PITCH, ABOVE + row * (ABOVE + SIZE.y + BELOW));
        picture = picture.add(draw(panel, Bounds { min, max: min + SIZE }));
    }
    Ok(picture.to_string())
}

fn check(panel: &RegionPanel) -> Result<(), DrawingError> {
    // rounding may leave a sum of areas a little above 1
    if let Some((option, value)) = panel.options.iter().find(|o| !(0.0..=1.0 + 1e-9).contains(&o.1)) {
        return Err(DrawingError::Probability { option: option.clone(), value: *value });
    }
    let named = panel.regions.parts.iter().map(|p| p.option + 1).max().unwrap_or(0);
    match named > panel.options.len() {
        true => Err(DrawingError::ProbabilityCount { probabilities: panel.options.len(), options: named }),
        false => Ok(()),
    }
}

fn draw(panel: &RegionPanel, frame: Bounds) -> Group {
    let regions = &panel.regions;
    let across = Scale { range: regions.alpha, ends: [frame.min.x, frame.max.x], is_log: false };
    let up = Scale { range: regions.gamma, ends: [frame.max.y, frame.min.y], is_log: false };
    let place = |p: &Perception| Point::new(across.at(p.alpha), up.at(p.gamma));
    let title = Words::new().plain(shorten(&panel.title, 30));
    let title = title.at(frame.min - Vector::new(0.0, 11.0), LARGE, Align::Left);
    let mut group =
        Group::new().set("class", "panel").add(Group::new().set("font-weight", "bold").add(title));

    let outlines: Vec<(usize, Vec<Point>)> =
        regions.parts.iter().map(|part| (part.option, part.outline.iter().map(place).collect())).collect();
    let borders: Vec<Vec<Point>> =
        regions.borders.iter().map(|border| border.iter().map(place).collect()).collect();
    let mut names = Group::new().set("class", "names");
    let mut unwanted = Vec::new();
    for (option, (name, probability)) in panel.options.iter().enumerate() {
        let own: Vec<&[Point]> = outlines.iter().filter(|o| o.0 == option).map(|o| o.1.as_slice()).collect();
        if own.is_empty() {
            unwanted.push(shorten(name, 12));
            continue;
        }
        let data: String = own.iter().map(|outline| path_data(outline) + "Z").collect();
        let paper = Path::new().set("d", data).set("fill", PAPERS[option % PAPERS.len()]);
        group = group.add(paper.set("data-option", option)).add(hatching(option, &own, frame));
        names = names.add(label(name, *probability, &own, &borders, frame));
    }
    for border in &borders {
        group = group.add(stroke(border, INK, 1.6));
    }
    group = group.add(rectangle(frame).set("fill", "none").set("stroke", INK).set("stroke-width", 1.2));
    let letter = |letter: &str, what: &str| Words::new().plain(what).italic(letter);
    group = group
        .add(across.below(frame, letter("\u{3b1}", "distance perception ")))
        .add(up.beside(frame, letter("\u{3b3}", "risk perception ")));
    if !unwanted.is_empty() {
        let text = match unwanted.as_slice() {
            [one] => format!("option {one}: preferred by nobody"),
            more => format!("options {}: preferred by nobody", more.join(", ")),
        };
        let at = Point::new((frame.min.x + frame.max.x) / 2.0, frame.max.y + 70.0);
        group = group.add(Words::new().plain(text).at(at, SMALL - 1.5, Align::Middle));
    }
    group.add(names)
}

/// Lines across a region, in a direction that tells its option; the first option of four has none.
fn hatching(option: usize, outlines: &[&[Point]], frame: Bounds) -> Group {
    let Some(along) =
        [None, Some(Vector::new(1.0, -1.0)), Some(Vector::new(1.0, 1.0)), Some(Vector::new(1.0, 0.0))]
            [option % PAPERS.len()]
    else {
        return Group::new();
    };
    let along = along.normalize();
    let across = Vector::new(-along.y, along.x);
    let middle = nalgebra::center(&frame.min, &frame.max);
    let reach = frame.size().norm() / 2.0;
    let lines = (reach / HATCH) as i32;
    let mut data = String::new();
    for i in -lines..=lines {
        let foot = middle + across * (f64::from(i) * HATCH);
        for outline in outlines {
            for [from, to] in inside(foot, along, outline) {
                data += &path_data(&[foot + along * from, foot + along * to]);
            }
        }
    }
    let colour = Look::of(option).colour;
    let line = Path::new().set("d", data).set("fill", "none").set("stroke", colour);
    Group::new().set("class", "hatching").add(line.set("stroke-width", px(1.1)).set("stroke-opacity", 0.55))
}

/// The parts of a line that lie inside an outline, as distances along it.
fn inside(foot: Point, along: Vector, outline: &[Point]) -> Vec<[f64; 2]> {
    let side = |p: &Point| crate::geometry::cross(along, p - foot);
    let next = outline.iter().cycle().skip(1);
    let mut met: Vec<f64> = outline
        .iter()
        .zip(next)
        .filter(|(a, b)| (side(a) < 0.0) != (side(b) < 0.0))
        .map(|(a, b)| (a + (b - a) * (side(a) / (side(a) - side(b))) - foot).dot(&along))
        .collect();
    met.sort_by(f64::total_cmp);
    met.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect()
}

/// An option's name and P_o where they fit best into its region, on paper.
fn label(name: &str, probability: f64, own: &[&[Point]], borders: &[Vec<Point>], frame: Bounds) -> Group {
    let lines = [
        Words::new().plain(format!("option {}", shorten(name, 10))),
        Words::new().italic("P").sub("o").plain(format!(" = {} %", number(100.0 * probability, 1))),
    ];
    let widest = lines.iter().map(|words| words.width(SMALL)).fold(0.0, f64::max);
    let half = Vector::new(widest / 2.0, SMALL * 1.15);
    let mut best = (frame.min, f64::INFINITY);
    for (i, j) in (1..48).flat_map(|i| (1..48).map(move |j| (i, j))) {
        let at = frame.min + frame.size().component_mul(&(Vector::new(f64::from(i), f64::from(j)) / 48.0));
        if !own.iter().any(|outline| contains(outline, at)) {
            continue;
        }
        // how much of borders and frame the words would cover, and then how near the borders come
        let area = Bounds { min: at - half, max: at + half };
        let pairs = || borders.iter().flat_map(|line| line.windows(2));
        let covered: f64 = pairs().map(|pair| length_inside(area.grown(3.0), [pair[0], pair[1]])).sum();
        let room = [area.min - frame.min, frame.max - area.max].map(|v| v.min()).into_iter();
        let room = room.fold(f64::INFINITY, f64::min);
        let near = pairs().map(|pair| (pair[0] - at).component_div(&half).norm()).fold(4.0, f64::min);
        let cost = covered + 20.0 * (4.0 - room).max(0.0) - 4.0 * near;
        if cost < best.1 {
            best = (at, cost);
        }
    }
    let at = best.0;
    let paper = rectangle(Bounds { min: at - half, max: at + half });
    let paper = paper.set("fill", "#ffffff").set("fill-opacity", 0.86).set("rx", 4);
    Group::new()
        .add(paper)
        .add(Group::new().set("font-weight", "bold").add(lines[0].at(
            at - Vector::new(0.0, 0.2 * SMALL),
            SMALL,
            Align::Middle,
        )))
        .add(lines[1].at(at + Vector::new(0.0, 0.88 * SMALL), SMALL, Align::Middle))
}

fn contains(outline: &[Point], at: Point) -> bool {
    let along = Vector::new(1.0, 0.0);
    inside(at, along, outline).iter().any(|[from, to]| *from < 0.0 && *to > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preference::Prospect;

    fn panel(title: &str) -> RegionPanel {
        let prospects = [(41.9, 0.66), (17.4, 0.36), (14.3, 0.55), (21.4, 0.25)];
        let prospects = prospects.map(|(d, s)| Prospect::new(d, s));
        RegionPanel {
            title: title.to_owned(),
            regions: Regions::new(&prospects, 10.0, [0.55, 0.95], [0.5, 1.1]),
            options: [("<1>", 0.0), ("2", 0.4), ("3", 0.35), ("4", 0.25)]
                .map(|(name, p)| (name.to_owned(), p))
                .to_vec(),
        }
    }

    #[test]
    fn the_figure_is_well_formed_and_names_every_region() {
        let panels = [panel("a & b"), panel("c"), panel("d")];
        let picture = preference_regions(&panels).unwrap();
        assert_eq!(picture, preference_regions(&panels).unwrap());
        crate::drawing::tests::check_well_formed(&picture);
        assert!(!picture.contains("NaN") && !picture.contains("inf"));
        assert_eq!(picture.matches("data-option=").count(), 9);
        assert_eq!(picture.matches("preferred by nobody").count(), 3);
        assert!(picture.contains("40.0 %") && picture.contains("a &amp; b"));
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        assert!(matches!(preference_regions(&[]), Err(DrawingError::NoPanels)));
        let mut spoiled = panel("a");
        spoiled.options[2].1 = f64::NAN;
        assert!(matches!(preference_regions(&[spoiled]), Err(DrawingError::Probability { .. })));
        let mut short = panel("a");
        short.options.pop();
        assert!(matches!(preference_regions(&[short]), Err(DrawingError::ProbabilityCount { .. })));
    }
}
