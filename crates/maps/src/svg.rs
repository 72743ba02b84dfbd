//! The obstacles of a floor plan drawn as SVG: filled areas, and lines as wide as they are drawn.

use crate::request::Request;
use crate::room::{MAX_CORNERS, Obstacles};
use crate::svg_bounds::{self, DRAWING};
use cocarry::bounds;
use cocarry::error::{Error, Place};
use cocarry::geometry::{Point, Vector, cross, left_of};
use cocarry::guarded;
use cocarry::located::{self, Source};
use std::collections::BTreeMap;
use std::path::Path as FilePath;
use usvg::tiny_skia_path::{PathSegment, Transform};
use usvg::{FillRule, Group, ImageHrefResolver, Node, Options, Paint, Path, Tree, roxmltree};

/// How far (m) the corners of a curve may be from it, and the largest number of them.
const TOLERANCE_M: f64 = 0.005;
const MAX_CURVE_CORNERS: f64 = 64.0;
/// Lines narrower than this are as wide, m.
const MIN_LINE_M: f64 = 0.01;
/// Corners nearer to each other than this (m) are one: coordinates have seven digits.
const SAME_CORNER_M: f64 = 1e-4;
/// Paint whose channels are all above this is paper.
const WHITE: u8 = 250;

/// A closed ring, without its first corner at its end.
type Ring = Vec<Point>;

/// The obstacles of the drawing in a file: what is filled in another colour than white, and every line as
/// wide as it is drawn. Names are the elements' ids. The origin is the lower left corner of the drawing.
pub(crate) fn obstacles(path: &FilePath, request: &Request) -> Result<String, Error> {
    let file = path.display().to_string();
    let text = located::read(&bounds::DRAWING, path)?;
    let source = Source { file: &file, text: &text };
    guarded::on_thread(|| of_text(source, request))
        .unwrap_or_else(|panic| Err(source.invalid("SVG file", panic)))
}

/// As [`obstacles`], of the text of a drawing.
fn of_text(source: Source, request: &Request) -> Result<String, Error> {
    let Source { file, text } = source;
    DRAWING.check(text).map_err(|why| source.invalid("SVG file", why))?;
    // a declaration of the document type that defines nothing
    let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
    let document = roxmltree::Document::parse_with_options(text, options);
    let document = document.map_err(|error| source.invalid("SVG file", error))?;
    svg_bounds::check(&document).map_err(|why| source.invalid("SVG file", why))?;
    let tree = Tree::from_xmltree(&document, &without_pictures())
        .map_err(|error| source.invalid("SVG file", error))?;
    let frame = Frame::new(&document, &tree, request.unit.metres());
    let mut plan =
        Plan { frame, request, names: BTreeMap::new(), corners: 0, obstacles: Obstacles::default() };
    plan.add_group(tree.root()).map_err(|TooLarge| {
        let sentence = format_args!(
            "its areas and lines have more than {MAX_CORNERS} corners; leave out what is not an obstacle"
        );
        Error::at(Place::file(file), sentence)
    })?;
    if plan.obstacles.text.is_empty() {
        return Err(Error::bad(
            Place::file(file),
            "a drawing without obstacles",
            "areas that are filled in another colour than white, or lines",
        ));
    }
    Ok(plan.obstacles.text)
}

/// Options under which no picture is read: a drawing may name any file of this machine.
fn without_pictures() -> Options<'static> {
    let image_href_resolver =
        ImageHrefResolver { resolve_data: Box::new(|_, _, _| None), resolve_string: Box::new(|_, _| None) };
    Options { image_href_resolver, ..Options::default() }
}

/// A drawing with more than [`MAX_CORNERS`].
struct TooLarge;

/// The place of the drawing in the world: x to the right, y up, from the lower left corner of its view box.
struct Frame {
    /// The length of a pixel, m.
    pixel: f64,
    /// The lower left corner, pixels.
    corner: [f64; 2],
}

impl Frame {
    /// `unit` is the length of a unit of the view box, m; without one, of a pixel.
    fn new(document: &roxmltree::Document, tree: &Tree, unit: f64) -> Self {
        let size = [tree.size().width(), tree.size().height()].map(f64::from);
        let numbers = |text: &str| -> Vec<f64> {
            text.split([' ', ',']).filter_map(|number| number.trim().parse().ok()).collect()
        };
        let view_box = document.root_element().attribute("viewBox").map(numbers);
        match view_box.as_deref() {
            Some(&[_, _, width, height]) if width > 0.0 && height > 0.0 => {
                // the view box is in the middle of the drawing, as large as fits
                let pixels = (size[0] / width).min(size[1] / height);
                let margin = [(size[0] - pixels * width) / 2.0, (size[1] - pixels * height) / 2.0];
                Self { pixel: unit / pixels, corner: [margin[0], size[1] - margin[1]] }
            }
            _ => Self { pixel: unit, corner: [0.0, size[1]] },
        }
    }

    fn point(&self, p: usvg::tiny_skia_path::Point) -> Point {
        let [x, y] = self.corner;
        Point::new((f64::from(p.x) - x) * self.pixel, (y - f64::from(p.y)) * self.pixel)
    }
}

struct Plan<'a> {
    frame: Frame,
    request: &'a Request,
    /// How often each name was used.
    names: BTreeMap<String, usize>,
    /// The corners of all areas and lines so far.
    corners: usize,
    obstacles: Obstacles,
}

impl Plan<'_> {
    fn add_group(&mut self, group: &Group) -> Result<(), TooLarge> {
        for node in group.children() {
            match node {
                Node::Group(group) => self.add_group(group)?,
                Node::Path(path) if path.is_visible() => self.add_path(path)?,
                // neither text nor pictures are obstacles
                _ => {}
            }
        }
        Ok(())
    }

    fn add_path(&mut self, path: &Path) -> Result<(), TooLarge> {
        let transform = path.abs_transform();
        let lines = self.lines(path, transform);
        // before the areas, whose time grows with the square of their number
        self.corners += lines.iter().map(|(line, _)| line.len()).sum::<usize>();
        if self.corners > MAX_CORNERS {
            return Err(TooLarge);
        }
        if let Some(fill) = path.fill().filter(|fill| is_drawn(fill.paint())) {
            let rings = lines.iter().map(|(line, _)| line.clone()).filter(|ring| ring.len() >= 3).collect();
            for (outer, holes) in areas(rings, fill.rule()) {
                let name = self.name(path.id());
                self.obstacles.add(&name, "polygon", &outer, &holes, self.request.height);
            }
        }
        if let Some(stroke) = path.stroke().filter(|stroke| is_drawn(stroke.paint())) {
            let (sx, sy) = transform.get_scale();
            let scale = f64::from(sx * sy).abs().sqrt();
            let width = (f64::from(stroke.width().get()) * scale * self.frame.pixel).max(MIN_LINE_M);
            for (line, is_closed) in &lines {
                for corners in bars(line, *is_closed, width) {
                    let name = self.name(path.id());
                    self.obstacles.add(&name, "polygon", &corners, &[], self.request.height);
                }
            }
        }
        Ok(())
    }

    fn name(&mut self, id: &str) -> String {
        let name = if id.is_empty() { "area" } else { id };
        let used = self.names.entry(name.to_owned()).or_default();
        *used += 1;
        if *used == 1 && !id.is_empty() { name.to_owned() } else { format!("{name}-{used}") }
    }

    /// The lines of a path in the world, each with whether it is closed.
    fn lines(&self, path: &Path, transform: Transform) -> Vec<(Ring, bool)> {
        let Some(data) = path.data().clone().transform(transform) else { return Vec::new() };
        let mut lines: Vec<(Ring, bool)> = Vec::new();
        for segment in data.segments() {
            let at = lines.last().and_then(|(line, _)| line.last().copied()).unwrap_or_default();
            match segment {
                PathSegment::MoveTo(p) => lines.push((vec![self.frame.point(p)], false)),
                PathSegment::LineTo(p) => extend(&mut lines, [self.frame.point(p)]),
                PathSegment::QuadTo(c, p) => {
                    let [c, p] = [c, p].map(|p| self.frame.point(p));
                    // as a cubic one
                    let controls = [at + (c - at) * (2.0 / 3.0), p + (c - p) * (2.0 / 3.0)];
                    extend(&mut lines, curve([at, controls[0], controls[1], p]));
                }
                PathSegment::CubicTo(c, d, p) => {
                    let [c, d, p] = [c, d, p].map(|p| self.frame.point(p));
                    extend(&mut lines, curve([at, c, d, p]));
                }
                PathSegment::Close => {
                    if let Some((_, is_closed)) = lines.last_mut() {
                        *is_closed = true;
                    }
                }
            }
        }
        for (line, _) in &mut lines {
            line.dedup_by(|a, b| (*a - *b).norm() < SAME_CORNER_M);
            if line.len() > 1 && (line[0] - line[line.len() - 1]).norm() < SAME_CORNER_M {
                line.pop();
            }
        }
        lines
    }
}

fn extend(lines: &mut [(Ring, bool)], points: impl IntoIterator<Item = Point>) {
    if let Some((line, _)) = lines.last_mut() {
        line.extend(points);
    }
}

/// Whether paint is not that of paper.
fn is_drawn(paint: &Paint) -> bool {
    match paint {
        Paint::Color(color) => [color.red, color.green, color.blue].iter().any(|channel| *channel <= WHITE),
        _ => true,
    }
}

/// Points of a cubic curve after its first one, near enough to each other for lines between them.
fn curve([a, b, c, d]: [Point; 4]) -> impl Iterator<Item = Point> {
    // the error of n chords is at most an eighth of the second derivative over n^2
    let bend = 6.0
        * (a.coords - b.coords * 2.0 + c.coords).norm().max((b.coords - c.coords * 2.0 + d.coords).norm());
    let corners = (bend / (8.0 * TOLERANCE_M)).sqrt().ceil().clamp(1.0, MAX_CURVE_CORNERS) as u32;
    (1..=corners).map(move |i| {
        let t = f64::from(i) / f64::from(corners);
        let s = 1.0 - t;
        let weigh = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
        let sum = [a, b, c, d].iter().zip(weigh).fold(Vector::zeros(), |sum, (p, w)| sum + p.coords * w);
        Point::from(sum)
    })
}

/// A bar of this width (m) around every side of a line. They end at the line's ends, and beyond its bends, so
/// that its corners are filled.
fn bars(line: &[Point], is_closed: bool, width: f64) -> Vec<Ring> {
    let n = line.len();
    let sides = if is_closed && n > 2 { n } else { n.saturating_sub(1) };
    (0..sides)
        .map(|i| {
            let [from, to] = [line[i], line[(i + 1) % n]];
            let along = (to - from).normalize();
            let beyond = |is_bend: bool| if is_bend { along * (width / 2.0) } else { Vector::zeros() };
            let from = from - beyond(is_closed || i > 0);
            let to = to + beyond(is_closed || i + 1 < sides);
            let aside = left_of(along) * (width / 2.0);
            vec![from - aside, to - aside, to + aside, from + aside]
        })
        .collect()
}

/// The areas that rings enclose by a fill rule: each with its holes. Rings do not cross.
fn areas(rings: Vec<Ring>, rule: FillRule) -> Vec<(Ring, Vec<Ring>)> {
    let mut rings: Vec<(f64, Ring)> = rings.into_iter().map(|ring| (doubled_area(&ring), ring)).collect();
    rings.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
    let winding = |area: f64| if rule == FillRule::EvenOdd { 1.0 } else { area.signum() };
    let is_filled = |sum: f64| match rule {
        FillRule::EvenOdd => sum.rem_euclid(2.0) == 1.0,
        FillRule::NonZero => sum != 0.0,
    };
    let mut areas: Vec<(Ring, Vec<Ring>)> = Vec::new();
    for (i, (area, ring)) in rings.iter().enumerate().filter(|(_, (area, _))| *area != 0.0) {
        let around = rings[..i].iter().filter(|(_, other)| contains(other, ring[0]));
        let outside: f64 = around.map(|(area, _)| winding(*area)).sum();
        match [outside, outside + winding(*area)].map(is_filled) {
            [false, true] => areas.push((ring.clone(), Vec::new())),
            [true, false] => {
                // the smallest area around it comes last
                if let Some((_, holes)) = areas.iter_mut().rev().find(|(outer, _)| contains(outer, ring[0])) {
                    holes.push(ring.clone());
                }
            }
            _ => {}
        }
    }
    areas
}

fn doubled_area(ring: &Ring) -> f64 {
    (0..ring.len()).map(|i| cross(ring[i].coords, ring[(i + 1) % ring.len()].coords)).sum()
}

/// Whether a point is inside a ring.
fn contains(ring: &Ring, p: Point) -> bool {
    let crossed = (0..ring.len()).filter(|&i| {
        let [a, b] = [ring[i], ring[(i + 1) % ring.len()]];
        (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
    });
    crossed.count() % 2 == 1
}
