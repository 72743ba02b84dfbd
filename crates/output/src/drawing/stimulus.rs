//! Stimuli: a world as participants of a study see it, without lengths, widths, risks and probabilities.

use super::film::{Film, Moment, team};
use super::kit::{
    Align, GAP, INK, Letters, LineStyle, MARGIN, PAPER, TEXT_SIZE, Text, document_of, rectangle, stroke,
};
use super::map_view::MapView;
use super::opening_labels::{PATH_COST, clutter, opening_labels};
use cocarry::geometry::{Bounds, Footprint, Point, Vector};
use cocarry::options::OptionSet;
use cocarry::world::World;
use svg::node::element::Group;

/// Largest distance of a drawn arc from its chords, m.
const SAGITTA: f64 = 0.01;
/// Room around A for the team that lines up there, m.
const TEAM: f64 = 2.4;
/// Room around everything else, m.
const ROOM: f64 = 0.6;
/// Width of the paths, px: no option stands out.
const PATH: f64 = 4.0;
/// Radius of the mark with an option's name, px.
const MARK: f64 = 14.0;
/// The tallest picture, as a multiple of its width.
const TALLEST: f64 = 1.4;

/// What a stimulus shows beside obstacles, A and B.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Shown {
    /// The names of the openings.
    pub openings: bool,
    /// The options: their paths, all drawn alike, with their names.
    pub options: bool,
}

/// The picture of a world for participants: the same frame and scale with and without a team.
pub struct Stimulus<'a> {
    world: &'a World,
    view: MapView,
    size: Vector,
    ground: Group,
    /// Names, which the team does not cover.
    names: Group,
}

impl<'a> Stimulus<'a> {
    /// The picture of a world, `width` px wide.
    pub fn new(world: &'a World, options: &'a OptionSet, shown: Shown, width: f64, letters: Letters) -> Self {
        let begin = options.begin();
        let count = options.options().len();
        let paths: Vec<Vec<Point>> = (0..count)
            .map(|option| options.path(&begin, option).map_or_else(Vec::new, |path| path.polyline(SAGITTA)))
            .collect();
        let bounds = world.bounds();
        let around = Bounds { min: world.start, max: world.start }.grown(TEAM);
        let ends = [bounds.min, bounds.max, around.min, around.max, world.target];
        let content =
            Bounds::around(paths.iter().flatten().copied().chain(ends)).unwrap_or(bounds).grown(ROOM);
        let most = Vector::new(width - 2.0 * MARGIN, TALLEST * width);
        let view = MapView::of(content, Point::new(MARGIN, MARGIN), most).with_letters(letters);
        let frame = view.frame();
        let view = view.moved_to(frame.min + Vector::new((most.x - frame.size().x) / 2.0, 0.0));
        let size = Vector::new(width, frame.max.y + 3.0 * GAP + TEXT_SIZE);
        let mut clutter = clutter(&view, world);
        let mut ground = Group::new().add(view.obstacles(world));
        let mut names = Group::new();
        if shown.options {
            let paths: Vec<Vec<Point>> =
                paths.iter().map(|path| path.iter().map(|p| view.px(*p)).collect()).collect();
            for (option, path) in paths.iter().enumerate() {
                clutter.add(path, PATH, PATH_COST);
                ground = ground.add(LineStyle::of(option).draw(path, PATH));
            }
            for (option, path) in paths.iter().enumerate() {
                names = names.add(option_mark(&view, &options.options()[option].name, option, &paths, path));
            }
        }
        if shown.openings {
            names = names.add(opening_labels(&view, world, false, &mut clutter).group);
        }
        let names = names.add(view.ends(world)).add(scale_bar(&view, size));
        Self { world, view, size, ground, names }
    }

    /// The world without a team, as SVG.
    pub fn map(&self) -> String {
        self.document(Group::new())
    }

    /// Width and height of the picture, px.
    pub fn size(&self) -> Vector {
        self.size
    }

    /// The place of a point of the world in the picture, px.
    pub fn pixel(&self, point: Point) -> Point {
        self.view.px(point)
    }

    /// The team alone, as an element of an SVG picture over [`Stimulus::map`].
    pub fn team(&self, base: &Footprint, moment: &Moment) -> String {
        team(self.world, base, &self.view, moment).to_string()
    }

    /// The world with the team, as SVG. `base` is the outline of the robot's base about its place, x ahead.
    pub fn with_team(&self, base: &Footprint, moment: &Moment) -> String {
        self.document(team(self.world, base, &self.view, moment))
    }

    fn document(&self, team: Group) -> String {
        let frame = self.view.frame();
        document_of(self.size.x, self.size.y)
            .set("width", self.size.x)
            .set("height", self.size.y)
            .add(Film::clip("map", frame))
            .add(Group::new().set("clip-path", "url(#map)").add(self.ground.clone()).add(team))
            .add(self.names.clone())
            .to_string()
    }
}

/// The name of an option on its path, where the other paths are far.
fn option_mark(view: &MapView, name: &str, option: usize, paths: &[Vec<Point>], path: &[Point]) -> Group {
    let others = || paths.iter().enumerate().filter(|(other, _)| *other != option).map(|(_, path)| path);
    let distance = |p: Point| {
        let legs = others().flat_map(|path| path.windows(2).map(|ends| [ends[0], ends[1]]));
        legs.map(|leg| (p - nearest_of_leg(leg, p)).norm()).fold(f64::INFINITY, f64::min)
    };
    let middle = nalgebra::center(&view.frame().min, &view.frame().max);
    // of places that are far enough from all others, the one nearest to the middle of the picture
    let apart = |p: &Point| distance(*p).min(3.0 * MARK) - 1e-3 * (p - middle).norm();
    let places = path.windows(2).flat_map(|ends| {
        let steps = ((ends[1] - ends[0]).norm() / MARK).ceil().max(1.0) as usize;
        let [from, to] = [ends[0], ends[1]];
        (0..steps).map(move |i| from + (to - from) * (i as f64 / steps as f64))
    });
    let Some(at) = places.max_by(|a, b| apart(a).total_cmp(&apart(b))) else { return Group::new() };
    let words = Text::new(name).bold().within(4.0 * MARK, TEXT_SIZE);
    let half = (words.width(TEXT_SIZE) / 2.0 + 6.0).max(MARK);
    let area = Bounds { min: at - Vector::new(half, MARK), max: at + Vector::new(half, MARK) };
    let tag = rectangle(area).set("rx", MARK).set("fill", PAPER).set("stroke", INK).set("stroke-width", 1.6);
    let baseline = at + Vector::new(0.0, 0.36 * TEXT_SIZE);
    Group::new().add(tag).add(words.lettered(view.letters, baseline, TEXT_SIZE, Align::Middle))
}

/// The point of a leg that is nearest to `p`.
fn nearest_of_leg([from, to]: [Point; 2], p: Point) -> Point {
    let along = to - from;
    let part = (p - from).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE);
    from + along * part.clamp(0.0, 1.0)
}

/// A metre, below the map.
fn scale_bar(view: &MapView, size: Vector) -> Group {
    let from = Point::new(view.frame().min.x, size.y - GAP);
    let to = from + Vector::new(view.scale(), 0.0);
    let words = Text::new("1 m").lettered(
        view.letters,
        to + Vector::new(GAP, 0.3 * TEXT_SIZE),
        TEXT_SIZE,
        Align::Left,
    );
    let ends = [from, to].map(|p| stroke(&[p - Vector::new(0.0, 5.0), p + Vector::new(0.0, 5.0)], INK, 2.0));
    ends.into_iter().fold(Group::new().add(stroke(&[from, to], INK, 2.0)), Group::add).add(words)
}
