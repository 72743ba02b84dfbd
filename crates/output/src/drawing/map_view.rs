//! The view of a world in a picture: its frame and scale, axes, obstacles, openings, start and target.

use super::kit::{
    Align, INK, Letters, OBSTACLE, OBSTACLE_EDGE, PAPER, Plot, TITLE_SIZE, Text, area, disc, polygon,
    rectangle, risk_colour, stroke,
};
use crate::palette::PLAIN_OPENING;
use crate::xml::printable;
use cocarry::geometry::{Bounds, Footprint, Point, Vector, direction};
use cocarry::world::{Obstacle, World};
use svg::node::element::{Group, Title};

/// Thickness of the bars across openings, px.
pub(super) const BAR: f64 = 6.0;

/// Radius of the marks of start and target, px.
pub(super) const END: f64 = 12.5;

/// A view of a part of the world in a picture, with equal scales on both axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct MapView {
    world: Bounds,
    /// px per m.
    scale: f64,
    /// Upper left corner of the frame, px.
    corner: Point,
    pub letters: Letters,
}

impl MapView {
    /// The largest view of the world and of all `points` with its upper left corner at `corner` and a size of
    /// at most `most` (px). It is at least `least` large, if necessary by showing more of the surroundings.
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
        Self { world, scale, corner, letters: Letters::Text }
    }

    /// The largest view of an area with its upper left corner at `corner` and a size of at most `most` (px).
    pub fn of(area: Bounds, corner: Point, most: Vector) -> Self {
        let scale = most.component_div(&area.size()).min();
        Self { world: area, scale, corner, letters: Letters::Text }
    }

    /// The same view in these letters.
    pub fn with_letters(self, letters: Letters) -> Self {
        Self { letters, ..self }
    }

    /// Scale, px per m.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// A position of the world in the picture, px.
    pub fn px(&self, p: Point) -> Point {
        let from_corner = Vector::new(p.x - self.world.min.x, self.world.max.y - p.y);
        self.corner + from_corner * self.scale
    }

    /// The frame in the picture, px; `min` is its upper left corner.
    pub fn frame(&self) -> Bounds {
        Bounds { min: self.corner, max: self.corner + self.world.size() * self.scale }
    }

    /// The same view at another position of the picture.
    pub fn moved_to(self, corner: Point) -> Self {
        Self { corner, ..self }
    }

    /// The frame with its axes.
    pub fn axes(&self) -> Group {
        let [x, y] = [0, 1].map(|axis| [self.world.min[axis], self.world.max[axis]]);
        let title = |letter: &str| Text::default().italic(letter).plain(" (m)");
        Plot::linear(self.frame(), [x, y]).with_letters(self.letters).axes(&title("x"), &title("y"))
    }

    /// The obstacles.
    pub fn obstacles(&self, world: &World) -> Group {
        let style = Group::new()
            .set("class", "obstacles")
            .set("fill", OBSTACLE)
            .set("stroke", OBSTACLE_EDGE)
            .set("stroke-width", 0.8)
            .set("stroke-linejoin", "round");
        world.obstacles.iter().fold(style, |group, obstacle| {
            let title = Title::new(printable(&obstacle.name));
            match (&obstacle.outline, &obstacle.parts[0].footprint) {
                (Some(_), _) => group.add(area(&self.outlines(obstacle)).add(title)),
                (None, footprint @ Footprint::Polygon(_)) => {
                    group.add(polygon(&self.outline(footprint)).add(title))
                }
                (None, Footprint::Disc { center, radius }) => {
                    group.add(disc(self.px(*center), radius * self.scale).add(title))
                }
            }
        })
    }

    /// The corners (px) of the outlines of an obstacle.
    pub fn outlines(&self, obstacle: &Obstacle) -> Vec<Vec<Point>> {
        match &obstacle.outline {
            Some(outline) => {
                outline.rings().iter().map(|ring| ring.iter().map(|p| self.px(*p)).collect()).collect()
            }
            None => obstacle.footprints().map(|footprint| self.outline(footprint)).collect(),
        }
    }

    /// The corners (px) of a convex outline; a disc becomes a polygon.
    pub fn outline(&self, footprint: &Footprint) -> Vec<Point> {
        match footprint {
            Footprint::Polygon(corners) => corners.iter().map(|c| self.px(*c)).collect(),
            Footprint::Disc { center, radius } => (0..24)
                .map(|i| center + direction(f64::from(i) * std::f64::consts::TAU / 24.0) * *radius)
                .map(|p| self.px(p))
                .collect(),
        }
    }

    /// The openings: bars across their gaps, coloured by risk or all alike.
    pub fn openings(&self, world: &World, by_risk: bool) -> Group {
        world.openings.iter().fold(Group::new().set("class", "openings"), |group, opening| {
            let ends = opening.ends.map(|p| self.px(p));
            let risk = opening.risk(world.robot_width);
            let colour = if by_risk { risk_colour(risk) } else { PLAIN_OPENING.to_owned() };
            let title = format!("{}: width {:.3} m, risk {risk:.3}", opening.name, opening.width);
            group.add(
                Group::new()
                    .add(Title::new(printable(&title)))
                    .add(stroke(&ends, INK, BAR + 2.4))
                    .add(stroke(&ends, &colour, BAR)),
            )
        })
    }

    /// The start A and the target B.
    pub fn ends(&self, world: &World) -> Group {
        let group = Group::new().set("class", "ends");
        [(world.start, "A"), (world.target, "B")].into_iter().fold(group, |group, (place, letter)| {
            let at = self.px(place);
            let dot = disc(at, END).set("fill", PAPER).set("stroke", INK).set("stroke-width", 2);
            let baseline = at + Vector::new(0.0, 0.36 * TITLE_SIZE);
            let words = Text::new(letter).bold();
            group.add(dot).add(words.lettered(self.letters, baseline, TITLE_SIZE, Align::Middle))
        })
    }
}

/// A white background for letters.
pub(super) fn paper(area: Bounds) -> svg::node::element::Rectangle {
    rectangle(area).set("fill", PAPER).set("fill-opacity", 0.85).set("rx", 3)
}
