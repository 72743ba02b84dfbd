//! The filmstrip of an episode: the team at several instants on one map, with phi next to it.

use super::kit::{
    AXIS_ROOM, Align, BAND, Clutter, GAP, INK, LEFT_ROOM, Legend, Letters, LineStyle, MARGIN, PAPER, Plot,
    TEXT_SIZE, TITLE_ROOM, Text, disc, document_of, guide, lettered_title, level, line_sample, polygon,
    rectangle, stroke, upright,
};
use super::map_view::MapView;
use super::opening_labels::{PATH_COST, clutter, opening_labels};
use super::{MAX_LISTED, Track, nothing, option_colour};
use crate::palette::{HAIR, HUMAN, OBJECT, ROBOT, hex};
use cocarry::Error;
use cocarry::geometry::{Bounds, Footprint, PlanarPose, Point, Vector, direction, left_of};
use cocarry::options::OptionSet;
use cocarry::world::World;
use svg::node::element::{ClipPath, Definitions, Element, Group};

/// The narrowest and the widest layout of a picture of an episode, px. Type is 16.5 px high: at least 7 pt
/// where the narrowest is printed 3.5 in wide.
pub const NARROWEST: f64 = 577.0;
/// See [`NARROWEST`].
pub const WIDEST: f64 = 1154.0;
/// From this width on the chart is next to the map, px.
pub(super) const MIN_WIDTH_BOTH: f64 = 760.0;

/// Largest distance of a drawn arc from its chords, m.
const SAGITTA: f64 = 0.01;
/// Ends of the line of an entry of the legend.
const SAMPLE_ENDS: [Point; 2] = [Point::new(-20.0, 0.0), Point::new(20.0, 0.0)];

/// The base of a team that is a point is drawn as this disc, at this distance behind the object, m.
pub const STAND_IN: Footprint = Footprint::Disc { center: Point::new(0.0, 0.0), radius: 0.25 };
const STAND_IN_BEHIND_M: f64 = 0.45;

/// Where a team that is a point has its base and its grasp, for an object of this length (m).
pub fn stand_in(object: &PlanarPose, length: f64) -> (PlanarPose, Point) {
    let ahead = direction(object.yaw);
    let position = object.position - ahead * (length / 2.0 + STAND_IN_BEHIND_M);
    (PlanarPose { position, yaw: object.yaw }, object.position - ahead * (length / 2.0))
}

/// An episode to draw.
#[derive(Clone, Debug)]
pub struct Film<'a> {
    /// The world.
    pub world: &'a World,
    /// Its options.
    pub options: &'a OptionSet,
    /// Outline of the robot's base about its place, x ahead.
    pub base: &'a Footprint,
    /// The states of the team in time order; at least one.
    pub moments: Vec<Moment>,
    /// How its pictures have their letters.
    pub letters: Letters,
}

/// The team at a time, seen from above.
#[derive(Clone, Debug)]
pub struct Moment {
    /// Simulated time, s.
    pub time: f64,
    /// Position and heading of the robot's base.
    pub base: PlanarPose,
    /// Where the robot holds the object.
    pub grasp: Point,
    /// Middle and heading of the object.
    pub object: PlanarPose,
    /// Middle and heading of the human's torso.
    pub human: PlanarPose,
    /// phi.
    pub stubbornness: f64,
    /// Whether the human leads.
    pub human_leads: bool,
    /// P_o of every option, in the order of the options; NaN where it is not known.
    pub probabilities: Vec<f64>,
    /// The newest event, as a sentence; may be empty.
    pub sentence: String,
}

/// Where the parts of a picture are.
struct FilmLayout {
    view: MapView,
    chart: Bounds,
    /// The y at which map and chart end, with their axes.
    bottom: f64,
}

impl Film<'_> {
    /// The team at `instants` times on one map, with phi next to it: the first and the last time, the
    /// transition if there is one, and others at equal distances. `width` is the layout's, px, from
    /// [`NARROWEST`] to [`WIDEST`]. The picture is shown `shown_width` wide, in `unit` (`in`, or `` for px).
    ///
    /// # Errors
    /// There is nothing to draw, or a number cannot be drawn.
    pub fn strip(
        &self,
        instants: usize,
        width: f64,
        (shown_width, unit): (f64, &str),
    ) -> Result<String, Error> {
        self.check()?;
        let layout = self.layout(width);
        let shown = self.instants(instants);
        let (map, mut clutter) = self.ground(&layout.view, None);
        let mut map = map.set("clip-path", "url(#map)");
        let walked: Vec<Point> = self.moments.iter().map(|m| layout.view.px(m.object.position)).collect();
        clutter.add(&walked, 2.0, PATH_COST);
        map = map.add(stroke(&walked, INK, 2.0));
        let mut numbers = Group::new();
        for (i, &at) in shown.iter().enumerate() {
            let moment = &self.moments[at];
            map = map.add(team(self.world, self.base, &layout.view, moment));
            let outline = self.outline(&layout.view, moment);
            outline.iter().for_each(|area| clutter.take(*area));
            numbers = numbers.add(self.instant_number(i + 1, &layout, moment, &mut clutter));
        }
        let labels = opening_labels(&layout.view, self.world, false, &mut clutter).group;
        let marks = shown.iter().enumerate().map(|(i, &at)| (i + 1, &self.moments[at]));
        let chart = self.chart(layout.chart, &self.moments, marks.collect(), None);
        let (legend, bottom) =
            self.legend(false).draw(Point::new(MARGIN, layout.bottom), width - 2.0 * MARGIN);
        let frame = layout.view.frame();
        let size = |length: f64| format!("{:.3}{unit}", length * shown_width / width);
        let picture = document_of(width, bottom)
            .set("width", size(width))
            .set("height", size(bottom))
            .add(Self::clip("map", frame))
            .add(lettered_title(self.letters, &self.world.name, frame.min.x, frame))
            .add(map)
            .add(layout.view.ends(self.world))
            .add(numbers)
            .add(labels)
            .add(layout.view.axes())
            .add(chart)
            .add(legend);
        Ok(picture.to_string())
    }

    pub(super) fn check(&self) -> Result<(), Error> {
        if self.moments.is_empty() {
            return Err(nothing());
        }
        let of = |number: fn(&Moment) -> Point| self.moments.iter().map(number).collect();
        let track = |positions| Track { label: "episode".to_owned(), positions, ..Track::default() };
        for positions in
            [of(|m| m.object.position), of(|m| m.base.position), of(|m| m.human.position), of(|m| m.grasp)]
        {
            track(positions).check()?;
        }
        let stubbornness = self.moments.iter().map(|m| m.stubbornness).collect();
        Track { stubbornness, ..track(Vec::new()) }.check()
    }

    /// The area of everything in the episode: options, openings, start and target, and wherever the bodies
    /// come.
    pub(super) fn content(&self) -> Bounds {
        let begin = self.options.begin();
        let paths = (0..self.options.options().len()).filter_map(|o| self.options.path(&begin, o));
        let paths = paths.flat_map(|path| path.polyline(SAGITTA));
        let ends = self.world.openings.iter().flat_map(|opening| opening.ends);
        let bodies = self.moments.iter().flat_map(|m| [m.base.position, m.human.position]);
        let points: Vec<Point> =
            paths.chain(ends).chain(bodies).chain([self.world.start, self.world.target]).collect();
        Bounds::around(points).unwrap_or(self.world.bounds()).grown(0.9)
    }

    /// The map as large as fits with a chart next to or below it.
    fn layout(&self, width: f64) -> FilmLayout {
        let top = TITLE_ROOM;
        let content = self.content();
        let is_beside = width >= MIN_WIDTH_BOTH;
        let right = width - MARGIN;
        let room = if is_beside { 0.56 * width } else { right };
        let most = Vector::new(room - LEFT_ROOM, if is_beside { 0.5 * width } else { 0.95 * width });
        let view = MapView::of(content, Point::new(LEFT_ROOM, top), most).with_letters(self.letters);
        let frame = view.frame();
        if is_beside {
            let min = Point::new(frame.max.x + LEFT_ROOM + GAP, top);
            let tallest = frame.max.y.min(top + 0.8 * (right - min.x)).max(top + 150.0);
            let chart = Bounds { min, max: Point::new(right, tallest) };
            return FilmLayout { view, chart, bottom: frame.max.y.max(tallest) + AXIS_ROOM };
        }
        let spare = Vector::new((most.x - frame.size().x) / 2.0, 0.0);
        let min = Point::new(LEFT_ROOM, frame.max.y + AXIS_ROOM + TITLE_ROOM);
        let chart = Bounds { min, max: Point::new(right, min.y + 170.0) };
        FilmLayout { view: view.moved_to(frame.min + spare), chart, bottom: chart.max.y + AXIS_ROOM }
    }

    /// A frame by its name: what lies outside is not drawn.
    pub(super) fn clip(name: &str, frame: Bounds) -> Definitions {
        Definitions::new().add(ClipPath::new().set("id", name).add(rectangle(frame)))
    }

    /// Obstacles, options and openings, and what they cover. At a moment the options are as wide as their
    /// P_o.
    pub(super) fn ground(&self, view: &MapView, moment: Option<&Moment>) -> (Group, Clutter) {
        let mut clutter = clutter(view, self.world);
        let begin = self.options.begin();
        let count = self.options.options().len();
        let widths: Vec<f64> = match moment {
            Some(moment) => {
                let known = moment.probabilities.iter().map(|p| if p.is_nan() { 0.0 } else { *p });
                known.map(|p| 1.2 + 13.0 * p).collect()
            }
            None => vec![1.8; count],
        };
        let mut order: Vec<usize> = (0..count.min(MAX_LISTED)).collect();
        order.sort_by(|&a, &b| widths[b].total_cmp(&widths[a]).then(a.cmp(&b)));
        let mut group = Group::new().add(view.obstacles(self.world));
        for option in order {
            let Some(path) = self.options.path(&begin, option) else { continue };
            let points: Vec<Point> = path.polyline(SAGITTA).into_iter().map(|p| view.px(p)).collect();
            clutter.add(&points, widths[option], PATH_COST / 2.0);
            let line = match moment {
                Some(_) => Group::new().add(stroke(&points, &option_colour(option), widths[option])),
                None => LineStyle::of(option).draw(&points, widths[option]),
            };
            group = group.add(line);
        }
        (group.add(view.openings(self.world, true)), clutter)
    }

    /// The areas that the team covers, px.
    fn outline(&self, view: &MapView, moment: &Moment) -> Vec<Bounds> {
        let radius = match self.base {
            Footprint::Disc { radius, .. } => *radius,
            Footprint::Polygon(corners) => corners.iter().map(|c| c.coords.norm()).fold(0.0, f64::max),
        };
        let bodies =
            [(moment.base.position, radius), (moment.human.position, 0.3), (moment.object.position, 0.4)];
        let area = |(center, radius): (Point, f64)| {
            let at = view.px(center);
            Bounds { min: at, max: at }.grown(radius * view.scale())
        };
        bodies.map(area).to_vec()
    }

    /// The number of an instant next to the team, with its time.
    fn instant_number(&self, n: usize, layout: &FilmLayout, moment: &Moment, clutter: &mut Clutter) -> Group {
        let center = layout.view.px(moment.object.position);
        let words = Text::new(n.to_string()).bold();
        let half = Vector::new(words.width(TEXT_SIZE) / 2.0 + 5.0, 0.62 * TEXT_SIZE);
        let around = (0..16).flat_map(|spoke| [26.0, 36.0, 48.0, 62.0].map(|out| (f64::from(spoke), out)));
        let places = around.map(|(spoke, out)| {
            let middle = center + direction(spoke * std::f64::consts::TAU / 16.0) * out;
            (Bounds { min: middle - half, max: middle + half }, out)
        });
        let cost = |(area, out): &(Bounds, f64)| clutter.cost(*area) + 0.6 * out;
        let Some((area, _)) = places.min_by(|a, b| cost(a).total_cmp(&cost(b))) else { return Group::new() };
        clutter.take(area);
        let middle = nalgebra::center(&area.min, &area.max);
        number_mark(self.letters, n, middle)
    }

    /// phi over time with its threshold, and numbered instants or a cursor.
    pub(super) fn chart(
        &self,
        frame: Bounds,
        moments: &[Moment],
        marks: Vec<(usize, &Moment)>,
        cursor: Option<&Moment>,
    ) -> Group {
        let last = self.moments.last().map_or(1.0, |m| m.time).max(1e-3);
        let top = self.moments.iter().map(|m| m.stubbornness).fold(1.0, f64::max).min(2.0) * 1.22;
        let plot = Plot::linear(frame, [[0.0, last], [0.0, top]]).with_letters(self.letters);
        let mut group = Group::new().set("class", "chart");
        let led: Vec<f64> = moments.iter().filter(|m| m.human_leads).map(|m| m.time).collect();
        if let (Some(from), Some(to)) = (led.first(), led.last()) {
            let min = Point::new(plot.x.at(*from), frame.min.y);
            let area = Bounds { min, max: Point::new(plot.x.at(*to), frame.max.y) };
            group = group.add(rectangle(area).set("fill", BAND));
        }
        let one = plot.y.at(1.0);
        group = group.add(guide(level(one, frame)));
        let line: Vec<Point> = moments.iter().map(|m| plot.at(m.time, m.stubbornness)).collect();
        group = group.add(stroke(&line, INK, 2.6));
        group = group.add(self.threshold_label(&plot, frame, &marks));
        for (n, moment) in marks {
            let x = plot.x.at(moment.time);
            let foot = plot.at(moment.time, moment.stubbornness);
            group = group.add(disc(foot, 3.4).set("fill", INK));
            let at = Point::new(x, frame.max.y - 0.8 * TEXT_SIZE);
            let inside = x.clamp(frame.min.x + 1.4 * GAP, frame.max.x - 1.4 * GAP);
            group = group.add(stroke(&[foot, at], INK, 0.8)).add(number_mark(
                self.letters,
                n,
                Point::new(inside, at.y),
            ));
        }
        if let Some(moment) = cursor {
            let at = plot.at(moment.time, moment.stubbornness);
            group = group.add(stroke(&upright(at.x, frame), INK, 1.2)).add(disc(at, 5.0).set("fill", INK));
        }
        let phi = Text::new("stubbornness ").italic("\u{3c6}");
        group.add(plot.axes(&Text::new("time (s)"), &phi))
    }

    /// The label of the threshold, above or below its line, where it covers neither phi nor the lines of
    /// instants. It is at the same place in every frame of an animation.
    fn threshold_label(&self, plot: &Plot, frame: Bounds, marks: &[(usize, &Moment)]) -> Element {
        let mut clutter = Clutter::new(frame);
        let phi: Vec<Point> = self.moments.iter().map(|m| plot.at(m.time, m.stubbornness)).collect();
        clutter.add(&phi, 6.0, 1.0);
        for (_, moment) in marks {
            let foot = plot.at(moment.time, moment.stubbornness);
            clutter.add(&[foot, Point::new(foot.x, frame.max.y)], 6.0, 1.0);
        }
        let words = Text::new("threshold 1");
        let (one, width) = (plot.y.at(1.0), words.width(TEXT_SIZE));
        let places = (0..=20).flat_map(|i| {
            let right = frame.max.x - GAP - (frame.size().x - width - 2.0 * GAP) * f64::from(i) / 20.0;
            [1.15, -0.4].map(|lines| Point::new(right, one + lines * TEXT_SIZE))
        });
        let cost = |at: &Point| {
            let min = Point::new(at.x - width, at.y - 0.75 * TEXT_SIZE);
            clutter.cost(Bounds { min, max: Point::new(at.x, at.y + 0.2 * TEXT_SIZE) })
        };
        // the first of equally good places
        let at = places.min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap_or(frame.max);
        words.lettered(self.letters, at, TEXT_SIZE, Align::Right)
    }

    /// The options by their styles, or their colours alone, and what is grey in the chart.
    pub(super) fn legend(&self, is_solid: bool) -> Legend {
        let options = self.options.options().iter().enumerate().take(MAX_LISTED);
        let legend = options.fold(Legend::of_lines().with_letters(self.letters), |legend, (o, option)| {
            let sample = match is_solid {
                true => Group::new().add(stroke(&SAMPLE_ENDS, &option_colour(o), 5.0)),
                false => line_sample(LineStyle::of(o), 3.0),
            };
            legend.entry(sample, format!("option {}", option.name))
        });
        let grey = Group::new().add(stroke(&SAMPLE_ENDS, BAND, 14.0));
        legend.entry(grey, "the human leads")
    }

    /// The moments of `count` instants.
    fn instants(&self, count: usize) -> Vec<usize> {
        let (first, last) = (self.moments[0].time, self.moments[self.moments.len() - 1].time);
        let nearest = |time: f64| {
            let off = |m: &Moment| (m.time - time).abs();
            let all = self.moments.iter().enumerate();
            all.min_by(|a, b| off(a.1).total_cmp(&off(b.1))).map_or(0, |(i, _)| i)
        };
        let count = count.max(2);
        let time = |i: usize| first + (last - first) * i as f64 / (count - 1) as f64;
        let mut shown: Vec<usize> = (0..count).map(|i| nearest(time(i))).collect();
        let begins = |pair: &[Moment]| !pair[0].human_leads && pair[1].human_leads;
        let transition = self.moments.windows(2).position(begins).map(|i| i + 1);
        if let (Some(transition), true) = (transition, count > 2) {
            // it takes the place of the inner instant that is nearest
            let inner = 1..count - 1;
            if let Some(i) = inner.min_by_key(|&i| shown[i].abs_diff(transition)) {
                shown[i] = transition;
            }
        }
        shown.dedup();
        shown
    }
}

/// The team from above: base and arm, object, and the human with arms, shoulders and head.
pub(super) fn team(world: &World, base_outline: &Footprint, view: &MapView, moment: &Moment) -> Group {
    let outlined = |group: Group, points: Vec<Point>, fill: &str| {
        let points: Vec<Point> = points.into_iter().map(|p| view.px(p)).collect();
        group.add(polygon(&points).set("fill", fill).set("stroke", INK).set("stroke-width", 1))
    };
    let round = |center: Point, yaw: f64, [along, across]: [f64; 2]| {
        let (ahead, aside) = (direction(yaw), left_of(direction(yaw)));
        let turn = (0..24).map(|i| direction(f64::from(i) * std::f64::consts::TAU / 24.0));
        turn.map(|t| center + ahead * (along * t.x) + aside * (across * t.y)).collect::<Vec<_>>()
    };
    let PlanarPose { position, yaw } = moment.object;
    let [length, breadth] = [world.object.size[0], world.object.size[1].max(0.12)];
    let (ahead, aside) = (direction(yaw) * (length / 2.0), left_of(direction(yaw)) * (breadth / 2.0));
    let object = [ahead + aside, aside - ahead, -ahead - aside, ahead - aside].map(|v| position + v);
    let human = moment.human;
    let shoulder = |side: f64| human.position + left_of(direction(human.yaw)) * (0.19 * side);
    let front = position + ahead;
    let line = |from: Point, to: Point, colour: &str, width| {
        stroke(&[view.px(from), view.px(to)], colour, width).set("stroke-linecap", "round")
    };
    let width = (0.1 * view.scale()).max(2.2);
    let mut group = Group::new().set("class", "team");
    let base = moment.base.position;
    let outline = match base_outline {
        Footprint::Disc { radius, .. } => round(base, 0.0, [*radius; 2]),
        Footprint::Polygon(corners) => {
            let ahead = direction(moment.base.yaw);
            corners.iter().map(|c| base + ahead * c.x + left_of(ahead) * c.y).collect()
        }
    };
    group = outlined(group, outline, &hex(ROBOT));
    group = group.add(line(base, moment.grasp, INK, width + 1.6));
    group = group.add(line(base, moment.grasp, &hex(ROBOT), width));
    for side in [1.0, -1.0] {
        let hand = front + left_of(direction(yaw)) * (breadth / 2.0 * side);
        group = group.add(line(shoulder(side), hand, INK, width + 1.2));
        group = group.add(line(shoulder(side), hand, &hex(HUMAN), width - 0.2));
    }
    group = outlined(group, object.to_vec(), &hex(OBJECT));
    group = outlined(group, round(human.position, human.yaw, [0.14, 0.25]), &hex(HUMAN));
    outlined(group, round(human.position + direction(human.yaw) * 0.03, 0.0, [0.1; 2]), &hex(HAIR))
}

/// A number in a disc.
fn number_mark(letters: Letters, n: usize, middle: Point) -> Group {
    let words = Text::new(n.to_string()).bold();
    let radius = 0.5 * words.width(TEXT_SIZE).max(0.75 * TEXT_SIZE) + 4.0;
    let baseline = middle + Vector::new(0.0, 0.36 * TEXT_SIZE);
    Group::new()
        .set("class", "instant")
        .add(disc(middle, radius).set("fill", PAPER).set("stroke", INK).set("stroke-width", 1.2))
        .add(words.lettered(letters, baseline, TEXT_SIZE, Align::Middle))
}
