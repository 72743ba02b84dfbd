//! The regions of the (alpha, gamma) plane and P_o in; the figure of them out: each region with its option's name and P_o in it.

use super::DrawingError;
use super::axis::Scale;
use super::labels::{length_inside, overlap};
use super::scene::{document, rectangle};
use super::style::{INK, LARGE, Look, SMALL, disc, number, path_data, px, stroke};
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
const SIZE: Vector = Vector::new(262.0, 280.0);
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
    let mut labels = Vec::new();
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
        labels.push((Label::new(name, *probability), own));
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
    // the largest regions choose first
    let mut names = Group::new().set("class", "names");
    let mut taken = Vec::new();
    labels.sort_by(|a, b| area(&b.1).total_cmp(&area(&a.1)));
    for (label, own) in &labels {
        let place = label.place(own, &borders, frame, &taken);
        taken.push(label.area(place[0]));
        names = names.add(label.draw(place, own));
    }
    group.add(names)
}

/// Area of a region, px^2.
fn area(outlines: &[&[Point]]) -> f64 {
    let corners = outlines.iter().flat_map(|o| o.iter().zip(o.iter().cycle().skip(1)));
    0.5 * corners.map(|(a, b)| crate::geometry::cross(a.coords, b.coords)).sum::<f64>().abs()
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

/// An option's name and P_o on the picture.
struct Label {
    lines: [Words; 2],
    /// Half of its size, px.
    half: Vector,
}

impl Label {
    fn new(name: &str, probability: f64) -> Self {
        let lines = [
            Words::new().plain(format!("option {}", shorten(name, 10))),
            Words::new().plain(format!("{} %", number(100.0 * probability, 1))),
        ];
        let widest = lines.iter().map(|words| words.width(SMALL)).fold(0.0, f64::max);
        Self { lines, half: Vector::new(0.48 * widest, SMALL * 1.15) }
    }

    fn area(&self, at: Point) -> Bounds {
        Bounds { min: at - self.half, max: at + self.half }
    }

    /// The place where the label covers the least of borders and of what is `taken`, deep in the region or else near it, and the deepest
    /// point of the region.
    fn place(&self, own: &[&[Point]], borders: &[Vec<Point>], frame: Bounds, taken: &[Bounds]) -> [Point; 2] {
        const GRID: i32 = 40;
        let grid = (1..GRID).flat_map(|i| (1..GRID).map(move |j| Vector::new(f64::from(i), f64::from(j))));
        let places: Vec<Point> =
            grid.map(|at| frame.min + frame.size().component_mul(&(at / f64::from(GRID)))).collect();
        let pairs = || borders.iter().flat_map(|line| line.windows(2));
        // how far border and frame are, in labels' sizes
        let depth = |at: Point| {
            let sides = [at - frame.min, frame.max - at].map(|v| v.component_div(&self.half).min());
            let near = pairs().map(|pair| (pair[0] - at).component_div(&self.half).norm());
            near.chain(sides).fold(3.0, f64::min)
        };
        let is_own = |at: Point| own.iter().any(|outline| contains(outline, at));
        let inside = places.iter().filter(|at| is_own(**at));
        let deepest = inside.max_by(|a, b| depth(**a).total_cmp(&depth(**b)));
        let deepest = deepest.or(own.first().and_then(|o| o.first())).copied().unwrap_or(frame.min);
        let cost = |at: Point| {
            let area = self.area(at);
            let covered: f64 = pairs().map(|pair| length_inside(area.grown(3.0), [pair[0], pair[1]])).sum();
            let shared: f64 = taken.iter().map(|t| overlap(area.grown(4.0), *t)).sum();
            let room = [area.min - frame.min, frame.max - area.max].map(|v| v.min());
            let outside = (4.0 - room[0].min(room[1])).max(0.0);
            let apart = if is_own(at) { -20.0 * depth(at) } else { 60.0 + (at - deepest).norm() };
            4.0 * covered + 2.0 * shared + 40.0 * outside + apart
        };
        let best = places.iter().map(|at| (*at, cost(*at))).min_by(|a, b| a.1.total_cmp(&b.1));
        [best.map_or(deepest, |b| b.0), deepest]
    }

    /// The label at its place, with a line to the region if it stands elsewhere.
    fn draw(&self, [at, deepest]: [Point; 2], own: &[&[Point]]) -> Group {
        let mut group = Group::new();
        if !own.iter().any(|outline| contains(outline, at)) {
            let line = stroke(&[at, deepest], INK, 1.2);
            group = group.add(line).add(disc(deepest, 3.2).set("fill", INK));
        }
        let line =
            |i: usize, down: f64| self.lines[i].at(at + Vector::new(0.0, down * SMALL), SMALL, Align::Middle);
        group
            .add(rectangle(self.area(at)).set("fill", "#ffffff").set("fill-opacity", 0.9).set("rx", 4))
            .add(Group::new().set("font-weight", "bold").add(line(0, -0.2)))
            .add(line(1, 0.88))
    }
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
