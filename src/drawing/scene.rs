//! A world and a place on the picture in; the map's ground out: frame with axes, obstacles, openings, start and target.

use super::WIDTH;
use super::style::{INK, LARGE, SMALL, disc, number, path_data, px, risk_colour, stroke, ticks};
use super::text::{Align, FONTS, Words, printable};
use crate::geometry::{Bounds, Footprint, Point, Vector};
use crate::world::World;
use svg::Document;
use svg::node::element::{Group, Path, Rectangle, Title};

/// Openings that do not show their risk.
const PALE: &str = "#cdebd0";

/// Room left of a frame for the labels of its y axis, and below it for those of its x axis, px.
pub(super) const LEFT: f64 = 70.0;
pub(super) const BELOW: f64 = 56.0;

/// Thickness of the bars across openings, px.
pub(super) const BAR: f64 = 6.0;

/// Radius of the marks of start and target, px.
pub(super) const MARK: f64 = 12.5;

/// A part of the world on a part of the picture, equal scales on both axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    world: Bounds,
    /// px per m.
    scale: f64,
    /// Upper left corner of the frame, px.
    corner: Point,
}

impl View {
    /// The largest view of the world and of all `points` with its upper left corner at `corner` that is at most `most` large (px); it is at
    /// least `least` large, where need be by showing more of the surroundings.
    pub fn fit(
        world: &World,
        points: impl IntoIterator<Item = Point>,
        corner: Point,
        least: Vector,
        most: Vector,
    ) -> Self {
        let bounds = world.bounds();
        let content = Bounds::around(points.into_iter().chain([bounds.min, bounds.max])).unwrap_or(bounds);
        let margin = world.robot_width.max(0.015 * content.size().max());
        let content = content.grown(margin);
        let scale = most.component_div(&content.size()).min();
        let lacking = (least / scale - content.size()).sup(&Vector::zeros()) / 2.0;
        let world = Bounds { min: content.min - lacking, max: content.max + lacking };
        Self { world, scale, corner }
    }

    /// A place of the world on the picture, px.
    pub fn px(&self, p: Point) -> Point {
        let from_corner = Vector::new(p.x - self.world.min.x, self.world.max.y - p.y);
        self.corner + from_corner * self.scale
    }

    /// The frame on the picture, px; `min` is its upper left corner.
    pub fn frame(&self) -> Bounds {
        Bounds { min: self.corner, max: self.corner + self.world.size() * self.scale }
    }

    /// Moves the view on the picture.
    pub fn moved_to(self, corner: Point) -> Self {
        Self { corner, ..self }
    }

    /// The frame with its axes.
    pub fn axes(&self) -> Group {
        let frame = self.frame();
        let (bottom, left) = (frame.max.y, frame.min.x);
        let outline = rectangle(frame).set("fill", "none").set("stroke", INK).set("stroke-width", 1.2);
        let mut marks = vec![];
        let end = |x: f64| Words::new().plain(number(x, 0)).width(SMALL);
        let x_step = (end(self.world.min.x).max(end(self.world.max.x)) + 20.0).max(46.0);
        let mut labels = vec![];
        for (x, label) in ticks(self.world.min.x, self.world.max.x, x_step / self.scale) {
            let at = Point::new(self.px(Point::new(x, 0.0)).x, bottom);
            marks.push(stroke(&[at, at + Vector::new(0.0, 6.0)], INK, 1.2));
            labels.push(Words::new().plain(label).at(at + Vector::new(0.0, 23.0), SMALL, Align::Middle));
        }
        for (y, label) in ticks(self.world.min.y, self.world.max.y, 44.0 / self.scale) {
            let at = Point::new(left, self.px(Point::new(0.0, y)).y);
            marks.push(stroke(&[at - Vector::new(6.0, 0.0), at], INK, 1.2));
            let label = Words::new().plain(label);
            // so that long numbers leave room for the title
            let size = SMALL * (40.0 / label.width(SMALL)).min(1.0);
            labels.push(label.at(at + Vector::new(-10.0, 0.35 * size), size, Align::Right));
        }
        let middle = nalgebra::center(&frame.min, &frame.max);
        let title = |letter: &str| Words::new().italic(letter).plain(" (m)");
        labels.push(title("x").at(Point::new(middle.x, bottom + 46.0), LARGE, Align::Middle));
        let at = Point::new(left - 54.0, middle.y);
        let turned = Group::new().set("transform", format!("rotate(-90 {} {})", px(at.x), px(at.y)));
        let group = Group::new().set("class", "axes").add(outline);
        let group = marks.into_iter().fold(group, Group::add);
        let group = labels.into_iter().fold(group, Group::add);
        group.add(turned.add(title("y").at(at, LARGE, Align::Middle)))
    }

    /// The obstacles.
    pub fn obstacles(&self, world: &World) -> Group {
        let style = Group::new()
            .set("class", "obstacles")
            .set("fill", "#a6a6a6")
            .set("stroke", "#595959")
            .set("stroke-width", 0.8)
            .set("stroke-linejoin", "round");
        world.obstacles.iter().fold(style, |group, obstacle| {
            let title = Title::new(printable(&obstacle.name));
            match &obstacle.footprint {
                Footprint::Polygon(_) => group.add(
                    Path::new().set("d", path_data(&self.outline(&obstacle.footprint)) + "Z").add(title),
                ),
                Footprint::Disc { center, radius } => {
                    group.add(disc(self.px(*center), radius * self.scale).add(title))
                }
            }
        })
    }

    /// The corners (px) of an obstacle's outline; a disc's is a polygon.
    pub fn outline(&self, footprint: &Footprint) -> Vec<Point> {
        match footprint {
            Footprint::Polygon(corners) => corners.iter().map(|c| self.px(*c)).collect(),
            Footprint::Disc { center, radius } => (0..24)
                .map(|i| {
                    center + crate::geometry::direction(f64::from(i) * std::f64::consts::TAU / 24.0) * *radius
                })
                .map(|p| self.px(p))
                .collect(),
        }
    }

    /// The openings: bars across their gaps, coloured by risk or all alike.
    pub fn openings(&self, world: &World, by_risk: bool) -> Group {
        world.openings.iter().fold(Group::new().set("class", "openings"), |group, opening| {
            let ends = opening.ends.map(|p| self.px(p));
            let risk = opening.risk(world.robot_width);
            let colour = if by_risk { risk_colour(risk) } else { PALE.to_owned() };
            let title = format!("{}: width {:.3} m, risk {risk:.3}", opening.name, opening.width);
            group.add(
                Group::new()
                    .add(Title::new(printable(&title)))
                    .add(stroke(&ends, INK, BAR + if by_risk { 2.4 } else { 1.6 }))
                    .add(stroke(&ends, &colour, BAR)),
            )
        })
    }

    /// The start A and the target B.
    pub fn ends(&self, world: &World) -> Group {
        let group = Group::new().set("class", "ends");
        [(world.start, "A"), (world.target, "B")].into_iter().fold(group, |group, (place, letter)| {
            let at = self.px(place);
            let dot = disc(at, MARK).set("fill", "#ffffff").set("stroke", INK).set("stroke-width", 2);
            let baseline = at + Vector::new(0.0, 0.36 * LARGE);
            let letter = Words::new().plain(letter).at(baseline, LARGE, Align::Middle);
            group.add(dot).add(Group::new().set("font-weight", "bold").add(letter))
        })
    }
}

/// An empty picture, white.
pub(super) fn document(height: f64) -> Document {
    let paper = Bounds { min: Point::origin(), max: Point::new(WIDTH, height) };
    Document::new()
        .set("width", px(WIDTH))
        .set("height", px(height))
        .set("viewBox", format!("0 0 {} {}", px(WIDTH), px(height)))
        .set("font-family", FONTS)
        .add(rectangle(paper).set("fill", "#ffffff"))
}

/// A rectangle on the picture, px.
pub(super) fn rectangle(bounds: Bounds) -> Rectangle {
    Rectangle::new()
        .set("x", px(bounds.min.x))
        .set("y", px(bounds.min.y))
        .set("width", px(bounds.size().x))
        .set("height", px(bounds.size().y))
}
