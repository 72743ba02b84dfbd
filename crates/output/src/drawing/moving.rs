//! The frames of an animation: the team in the middle of a map that moves with it, phi over time, and the
//! whole way.

use super::Moment;
use super::film::{Film, MIN_WIDTH_BOTH, team};
use super::kit::{
    AXIS_ROOM, Align, GAP, INK, LEFT_ROOM, MARGIN, PAPER, TEXT_SIZE, Text, disc, document_of, number, px,
    rectangle, stroke, wrapped,
};
use super::map_view::MapView;
use super::opening_labels::{PATH_COST, opening_labels};
use cocarry::Error;
use cocarry::geometry::{Bounds, Point, Vector};
use svg::node::element::Group;

/// The part of the world that the map shows around the team, m: the longer side.
const WINDOW_M: f64 = 7.0;
/// Height of a line of the words above the map, px.
const LINE: f64 = 24.0;

/// The frames of an animation: all have the same size, with the same parts in the same places.
pub struct Moving<'a> {
    film: &'a Film<'a>,
    width: f64,
    /// The number of lines of words.
    lines: usize,
    bottom: f64,
    /// The map of everything, of which the window shows a part.
    view: MapView,
    window: Bounds,
    chart: Bounds,
    /// The map of the whole way, in a wide picture.
    whole: Option<(MapView, Group)>,
    labels: Group,
    legend: Group,
}

impl<'a> Film<'a> {
    /// The frames of an animation. `width` is the layout's, px. Each has room for `lines` lines of words, and
    /// shows no more; with `None`, for the longest text.
    ///
    /// # Errors
    /// There is nothing to draw, or a number cannot be drawn.
    pub fn moving(&'a self, width: f64, lines: Option<usize>) -> Result<Moving<'a>, Error> {
        self.check()?;
        let is_wide = width >= MIN_WIDTH_BOTH;
        let room = width - 2.0 * MARGIN;
        let longest = || self.moments.iter().map(|m| wrapped(&m.sentence, room, TEXT_SIZE).len()).max();
        let lines = lines.or_else(longest).unwrap_or(0);
        let top = 26.0 + LINE * (lines as f64 + 0.4);
        let side = if is_wide { (0.48 * width).round() } else { room };
        let window = Bounds {
            min: Point::new(MARGIN, top),
            max: Point::new(MARGIN + side, top + if is_wide { side } else { 0.8 * side }),
        };
        let content = self.content();
        let view = MapView::of(content, Point::origin(), content.size() * (side / WINDOW_M));
        let view = view.with_letters(self.letters);
        let (_, mut clutter) = self.ground(&view, None);
        // labels keep away from everywhere the team comes
        let walked: Vec<Point> = self.moments.iter().map(|m| view.px(m.object.position)).collect();
        clutter.add(&walked, 40.0, 3.0 * PATH_COST);
        let labels = opening_labels(&view, self.world, true, &mut clutter).group;
        let right = width - MARGIN;
        let (chart, whole, bottom) = if is_wide {
            let left = window.max.x + LEFT_ROOM;
            let middle = top + (0.44 * side).round();
            let chart = Bounds { min: Point::new(left, top), max: Point::new(right, middle) };
            let under = Point::new(left, middle + AXIS_ROOM + GAP);
            let whole = self.whole(content, Bounds { min: under, max: Point::new(right, window.max.y) });
            (chart, Some(whole), window.max.y + GAP)
        } else {
            let min = Point::new(LEFT_ROOM, window.max.y + 2.0 * GAP);
            let chart = Bounds { min, max: Point::new(right, min.y + 170.0) };
            (chart, None, chart.max.y + AXIS_ROOM)
        };
        let (legend, bottom) = self.legend(true).draw(Point::new(MARGIN, bottom), room);
        Ok(Moving { film: self, width, lines, bottom, view, window, chart, whole, labels, legend })
    }

    /// The small map of everything, in the middle of an area.
    fn whole(&self, content: Bounds, area: Bounds) -> (MapView, Group) {
        let view = MapView::of(content, area.min, area.size());
        let spare = (area.size() - view.frame().size()) / 2.0;
        let view = view.moved_to(area.min + spare);
        let frame = rectangle(view.frame()).set("fill", PAPER).set("stroke", INK).set("stroke-width", 1);
        let inside = Group::new().set("clip-path", "url(#whole)");
        let inside = inside.add(view.obstacles(self.world)).add(view.openings(self.world, true));
        let map = Group::new().add(frame).add(inside);
        let ends = [(self.world.start, "A"), (self.world.target, "B")];
        let map = ends.into_iter().fold(map, |map, (place, letter)| {
            let at = view.px(place);
            // next to its point, toward the middle of the map
            let is_left = at.x < view.frame().min.x + view.frame().size().x / 2.0;
            let (off, align) = if is_left { (9.0, Align::Left) } else { (-9.0, Align::Right) };
            let words = Text::new(letter).bold();
            let map = map.add(disc(at, 4.0).set("fill", INK));
            let place = at + Vector::new(off, -0.3 * TEXT_SIZE);
            map.add(words.lettered(self.letters, place, TEXT_SIZE, align))
        });
        (view, map)
    }
}

impl Moving<'_> {
    /// The picture at a moment (its index; of a larger one the last).
    pub fn picture(&self, at: usize) -> String {
        let film = self.film;
        let at = at.min(film.moments.len() - 1);
        let moment = &film.moments[at];
        let leads = if moment.human_leads { "The human leads" } else { "The robot leads" };
        let leads = Text::new(format!("{leads}, {} s", number(moment.time, 1))).bold();
        let caption = Point::new(MARGIN, 26.0);
        let mut picture = document_of(self.width, self.bottom)
            .add(Film::clip("map", self.window))
            .add(leads.lettered(film.letters, caption, TEXT_SIZE, Align::Left));
        let words = wrapped(&moment.sentence, self.width - 2.0 * MARGIN, TEXT_SIZE);
        for (line, words) in (1..).zip(words.into_iter().take(self.lines)) {
            let at = caption + Vector::new(0.0, LINE * f64::from(line));
            picture = picture.add(words.lettered(film.letters, at, TEXT_SIZE, Align::Left));
        }
        picture = picture.add(self.around(at)).add(self.scale_bar()).add(film.chart(
            self.chart,
            &film.moments[..=at],
            Vec::new(),
            Some(moment),
        ));
        if let Some((view, map)) = &self.whole {
            picture = picture.add(Film::clip("whole", view.frame()));
            let walked: Vec<Point> = film.moments[..=at].iter().map(|m| view.px(m.object.position)).collect();
            let here = disc(view.px(moment.object.position), 5.0).set("fill", INK);
            picture = picture.add(map.clone()).add(stroke(&walked, INK, 2.4)).add(here);
        }
        picture.add(self.legend.clone()).to_string()
    }

    /// The map around the team.
    fn around(&self, at: usize) -> Group {
        let film = self.film;
        let moment: &Moment = &film.moments[at];
        let middle = nalgebra::center(&moment.base.position, &moment.human.position);
        // whole pixels, so that edges do not flicker
        let shift =
            (nalgebra::center(&self.window.min, &self.window.max) - self.view.px(middle)).map(f64::round);
        let walked: Vec<Point> =
            film.moments[..=at].iter().map(|m| self.view.px(m.object.position)).collect();
        let map = film.ground(&self.view, Some(moment)).0;
        let map = map
            .set("transform", format!("translate({} {})", px(shift.x), px(shift.y)))
            .add(stroke(&walked, INK, 2.4))
            .add(self.view.ends(film.world))
            .add(team(film.world, film.base, &self.view, moment))
            .add(self.labels.clone());
        let frame = rectangle(self.window).set("fill", "none").set("stroke", INK).set("stroke-width", 1.2);
        Group::new().add(Group::new().set("clip-path", "url(#map)").add(map)).add(frame)
    }

    /// A metre, at the lower left of the map.
    fn scale_bar(&self) -> Group {
        let from = Point::new(self.window.min.x + GAP, self.window.max.y - GAP);
        let to = from + Vector::new(self.view.scale(), 0.0);
        let words = Text::new("1 m");
        let area = Bounds { min: from - Vector::new(6.0, 1.4 * TEXT_SIZE), max: to + Vector::new(6.0, 6.0) };
        let above = nalgebra::center(&from, &to) - Vector::new(0.0, 0.35 * TEXT_SIZE);
        Group::new()
            .add(rectangle(area).set("fill", PAPER).set("fill-opacity", 0.85))
            .add(stroke(&[from, to], INK, 3.0))
            .add(words.lettered(self.film.letters, above, TEXT_SIZE, Align::Middle))
    }
}
