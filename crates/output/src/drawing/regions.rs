//! The figure of preference regions in the (alpha, gamma) plane, each labelled with its option's name and
//! P_o.

use super::kit::{
    AXIS_ROOM, Align, Clutter, GAP, INK, LineStyle, Plot, TEXT_SIZE, Text, disc, frame_title, in_two_columns,
    nearest, number, path_data, stroke,
};
use super::map_view::paper;
use super::{check_probabilities, nothing, unequal};
use cocarry::Error;
use cocarry::geometry::{Bounds, Point, Vector, cross};
use cocarry::preference::{Perception, Regions};
use svg::node::element::{Group, Path};

/// The regions of one world.
#[derive(Clone, Debug, PartialEq)]
pub struct RegionPanel {
    /// Title above the panel; long ones are shortened.
    pub title: String,
    /// The preference regions.
    pub regions: Regions,
    /// Name and P_o of every option.
    pub options: Vec<(String, f64)>,
}

/// Height of a panel's frame, px.
const HEIGHT: f64 = 280.0;
/// Distance between the lines of a hatching, px.
const HATCH_DISTANCE: f64 = 11.0;
/// Largest width of an option's name, px.
const NAME_WIDTH: f64 = 100.0;

/// The preferred option for every (alpha, gamma), two panels in a row.
///
/// A region has the colour of its option and a hatching, and shows the option's name and P_o. Options that
/// nobody prefers are listed below the panel. Every region is one path with the attribute `data-option`, the
/// option's index; its area is its share of the frame.
///
/// # Errors
/// There is no panel, or not a probability from 0 to 1 for every option.
pub fn preference_regions(panels: &[RegionPanel]) -> Result<String, Error> {
    if panels.is_empty() {
        return Err(nothing());
    }
    panels.iter().try_for_each(check)?;
    Ok(in_two_columns(panels, HEIGHT, draw))
}

fn check(panel: &RegionPanel) -> Result<(), Error> {
    check_probabilities(panel.options.iter().map(|(name, p)| (name.as_str(), *p)))?;
    let named = panel.regions.parts.iter().map(|p| p.option + 1).max().unwrap_or(0);
    match named > panel.options.len() {
        true => Err(unequal(panel.options.len(), named)),
        false => Ok(()),
    }
}

/// A panel, and the y at which it ends.
fn draw(panel: &RegionPanel, frame: Bounds) -> (Group, f64) {
    let regions = &panel.regions;
    let plot = Plot::linear(frame, [regions.alpha, regions.gamma]);
    let corners =
        |line: &[Perception]| line.iter().map(|p| plot.at(p.alpha, p.gamma)).collect::<Vec<Point>>();
    let outlines: Vec<(usize, Vec<Point>)> =
        regions.parts.iter().map(|part| (part.option, corners(&part.outline))).collect();
    let borders: Vec<Vec<Point>> = regions.borders.iter().map(|border| corners(border)).collect();
    let mut group = Group::new().add(frame_title(&panel.title, frame.min.x, frame));
    let mut clutter = Clutter::new(frame.grown(-4.0));
    let mut labels = Vec::new();
    let mut unwanted = Vec::new();
    for (option, (name, probability)) in panel.options.iter().enumerate() {
        let own: Vec<&[Point]> = outlines.iter().filter(|o| o.0 == option).map(|o| o.1.as_slice()).collect();
        if own.is_empty() {
            unwanted.push(name.as_str());
            continue;
        }
        let data: String = own.iter().map(|outline| path_data(outline) + "Z").collect();
        let region = Path::new().set("d", data).set("fill", LineStyle::of(option).tint());
        group = group.add(region.set("data-option", option)).add(hatching(option, &own, frame));
        labels.push((Label::new(name, *probability), own));
    }
    for border in &borders {
        clutter.add(border, 6.0, 4.0);
        group = group.add(stroke(border, INK, 1.6));
    }
    let title = |what: &str, letter: &str| Text::new(what).italic(letter);
    group = group
        .add(plot.axes(&title("distance perception ", "\u{3b1}"), &title("risk perception ", "\u{3b3}")));
    let mut bottom = frame.max.y + AXIS_ROOM + GAP;
    if !unwanted.is_empty() {
        let plural = if unwanted.len() > 1 { "s" } else { "" };
        let text = format!("option{plural} {}: preferred by nobody", unwanted.join(", "));
        bottom += GAP;
        let at = Point::new((frame.min.x + frame.max.x) / 2.0, bottom - 0.5 * GAP);
        let text = Text::new(text);
        // scaled down to fit, but to no less than four fifths
        let size = TEXT_SIZE * (frame.size().x / text.width(TEXT_SIZE)).clamp(0.8, 1.0);
        group = group.add(text.within(frame.size().x, size).at(at, size, Align::Middle));
    }
    // the largest regions choose first
    let mut names = Group::new().set("class", "names");
    labels.sort_by(|a, b| area(&b.1).total_cmp(&area(&a.1)));
    for (label, own) in &labels {
        let [at, deepest] = label.place(own, &borders, frame, &clutter);
        clutter.take(label.area(at));
        names = names.add(label.draw([at, deepest], own));
    }
    (group.add(names), bottom)
}

/// Area of a region, px^2.
fn area(outlines: &[&[Point]]) -> f64 {
    let corners = outlines.iter().flat_map(|o| o.iter().zip(o.iter().cycle().skip(1)));
    0.5 * corners.map(|(a, b)| cross(a.coords, b.coords)).sum::<f64>().abs()
}

/// Lines across a region, in a direction specific to its option.
fn hatching(option: usize, outlines: &[&[Point]], frame: Bounds) -> Group {
    const DIRECTIONS: [[f64; 2]; 4] = [[0.0, 1.0], [1.0, -1.0], [1.0, 1.0], [1.0, 0.0]];
    let along = Vector::from(DIRECTIONS[option % DIRECTIONS.len()]).normalize();
    let across = Vector::new(-along.y, along.x);
    let middle = nalgebra::center(&frame.min, &frame.max);
    let reach = frame.size().norm() / 2.0;
    let lines = (reach / HATCH_DISTANCE) as i32;
    let mut data = String::new();
    for i in -lines..=lines {
        let foot = middle + across * (f64::from(i) * HATCH_DISTANCE);
        for outline in outlines {
            for [from, to] in inside(foot, along, outline) {
                data += &path_data(&[foot + along * from, foot + along * to]);
            }
        }
    }
    let line = Path::new().set("d", data).set("fill", "none").set("stroke", LineStyle::of(option).colour());
    Group::new().set("class", "hatching").add(line.set("stroke-width", 1.1).set("stroke-opacity", 0.6))
}

/// The parts of a line that lie inside an outline, as distances along it.
fn inside(foot: Point, along: Vector, outline: &[Point]) -> Vec<[f64; 2]> {
    let side = |p: &Point| cross(along, p - foot);
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

/// The label of a region: its option's name and P_o.
struct Label {
    lines: [Text; 2],
    /// Half of its size, px.
    half: Vector,
}

impl Label {
    fn new(name: &str, probability: f64) -> Self {
        let lines = [
            Text::new(format!("option {name}")).bold().within(NAME_WIDTH, TEXT_SIZE),
            Text::new(format!("{} %", number(100.0 * probability, 1))),
        ];
        let widest = lines.iter().map(|line| line.width(TEXT_SIZE)).fold(0.0, f64::max);
        Self { lines, half: Vector::new(0.48 * widest, TEXT_SIZE * 1.15) }
    }

    fn area(&self, at: Point) -> Bounds {
        Bounds { min: at - self.half, max: at + self.half }
    }

    /// The position at which the label covers the least, well inside the region or else near it, and the
    /// deepest point of the region.
    fn place(
        &self,
        own: &[&[Point]],
        borders: &[Vec<Point>],
        frame: Bounds,
        clutter: &Clutter,
    ) -> [Point; 2] {
        const GRID: i32 = 40;
        let grid = (1..GRID).flat_map(|i| (1..GRID).map(move |j| Vector::new(f64::from(i), f64::from(j))));
        let places: Vec<Point> =
            grid.map(|at| frame.min + frame.size().component_mul(&(at / f64::from(GRID)))).collect();
        // distances from border and frame, in label sizes
        let depth = |at: Point| {
            let sides = [at - frame.min, frame.max - at].map(|v| v.component_div(&self.half).min());
            let near = borders.iter().flatten().map(|p| (p - at).component_div(&self.half).norm());
            near.chain(sides).fold(3.0, f64::min)
        };
        let is_own = |at: Point| own.iter().any(|outline| contains(outline, at));
        let inside = places.iter().filter(|at| is_own(**at));
        let deepest = inside.max_by(|a, b| depth(**a).total_cmp(&depth(**b)));
        let deepest = deepest.or(own.first().and_then(|o| o.first())).copied().unwrap_or(frame.min);
        let cost = |at: Point| {
            let apart = if is_own(at) { -20.0 * depth(at) } else { 160.0 + (at - deepest).norm() };
            clutter.cost(self.area(at)) + apart
        };
        let best = places.iter().map(|at| (*at, cost(*at))).min_by(|a, b| a.1.total_cmp(&b.1));
        [best.map_or(deepest, |b| b.0), deepest]
    }

    /// The label at its position, with a leader line to the region if it is outside.
    fn draw(&self, [at, deepest]: [Point; 2], own: &[&[Point]]) -> Group {
        let mut group = Group::new();
        if !own.iter().any(|outline| contains(outline, at)) {
            let edge = nearest(self.area(at), deepest);
            group = group.add(stroke(&[edge, deepest], INK, 1.2)).add(disc(deepest, 3.2).set("fill", INK));
        }
        let baselines = [-0.2, 0.88].map(|down| at + Vector::new(0.0, down * TEXT_SIZE));
        let lines = self.lines.iter().zip(baselines).map(|(line, at)| line.at(at, TEXT_SIZE, Align::Middle));
        lines.fold(group.add(paper(self.area(at))), Group::add)
    }
}

fn contains(outline: &[Point], at: Point) -> bool {
    let along = Vector::new(1.0, 0.0);
    inside(at, along, outline).iter().any(|[from, to]| *from < 0.0 && *to > 0.0)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{NOTHING, error};
    use super::*;
    use crate::drawing::tests::checked;
    use cocarry::preference::Prospect;

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
        let picture = checked(|| preference_regions(&panels));
        assert_eq!(picture.matches("data-option=").count(), 9);
        assert_eq!(picture.matches("preferred by nobody").count(), 3);
        assert!(picture.contains("40.0 %") && picture.contains("a &amp; b"));
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        assert_eq!(error(preference_regions(&[])), NOTHING);
        let mut spoiled = panel("a");
        spoiled.options[2].1 = f64::NAN;
        assert!(error(preference_regions(&[spoiled])).contains("its probability is NaN"));
        let mut short = panel("a");
        short.options.pop();
        assert!(error(preference_regions(&[short])).contains("probabilities were given for"));
    }
}
