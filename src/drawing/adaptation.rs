//! A world and tracks of teams in; the figure of mutual adaptation out: (a) where they went, (b) how stubbornness grew.

use super::chart::chart;
use super::labels::Ground;
use super::scene::{BELOW, LEFT, View, document};
use super::style::{LARGE, Look, SMALL, width_by_rank};
use super::text::{Align, Words, shorten};
use super::{DrawingError, Track, WIDTH};
use crate::geometry::{Bounds, Point, Vector};
use crate::world::World;
use svg::node::element::Group;

/// The paper's figure of stubbornness: (a) the tracks on the map of their world, a cross where the human took the lead; (b) phi(k) over the
/// step k, and over time with steps of `period` (s), up to the step at which it exceeds 1.
///
/// Tracks are drawn over each other from wide to narrow, so that those which coincide remain visible. A map that is higher than wide stands
/// beside the chart, any other above it.
///
/// # Errors
/// [`DrawingError::NotDrawable`], [`DrawingError::Transition`], [`DrawingError::Period`].
pub fn adaptation(world: &World, tracks: &[Track], period: f64) -> Result<String, DrawingError> {
    if !(period.is_finite() && period > 0.0) {
        return Err(DrawingError::Period { period });
    }
    tracks.iter().try_for_each(Track::check)?;
    let (view, chart_frame) = panels(world, tracks);
    let frame = view.frame();
    let chart = chart(tracks, period, chart_frame)?;

    let mut ground = Ground::of(&view, world);
    let walked = walked(&view, tracks, &mut ground);
    let names = ground.label_openings(&view, world, false);
    let crosses = tracks.iter().enumerate().filter_map(|(i, track)| {
        let at = *track.positions.get(track.transition?)?;
        Some(Look::of(i).cross(view.px(at)))
    });
    let crosses = crosses.fold(Group::new().set("class", "transitions"), Group::add);

    let left = Point::new(20.0, frame.max.y.max(chart_frame.max.y) + BELOW + 24.0);
    let (legend, bottom) = legend(left, tracks);
    let title = format!("(a) {}", shorten(&world.name, 24));
    let picture = document(bottom)
        .add(heading(&title, frame.min - Vector::new(0.0, 16.0)))
        .add(heading("(b)", Point::new(chart_frame.min.x - 44.0, chart_frame.min.y - 45.0)))
        .add(view.obstacles(world))
        .add(view.openings(world, false))
        .add(walked)
        .add(view.ends(world))
        .add(crosses)
        .add(names)
        .add(view.axes())
        .add(chart)
        .add(legend);
    Ok(picture.to_string())
}

/// The map, and the frame of the chart (px).
fn panels(world: &World, tracks: &[Track]) -> (View, Bounds) {
    let corner = Point::new(LEFT, 62.0);
    let points = || tracks.iter().flat_map(|t| t.positions.iter().copied());
    let right = WIDTH - 20.0;
    let tall = View::fit(world, points(), corner, Vector::new(200.0, 330.0), Vector::new(310.0, 450.0));
    let size = tall.frame().size();
    let upright =
        View::fit(world, points(), corner, Vector::zeros(), Vector::new(310.0, 450.0)).frame().size();
    if upright.y >= upright.x {
        let min = Point::new(corner.x + size.x + 86.0, corner.y);
        return (tall, Bounds { min, max: Point::new(right, corner.y + size.y) });
    }
    let most = Vector::new(right - LEFT, 460.0);
    let corner = Point::new(LEFT, 44.0);
    let wide = View::fit(world, points(), corner, Vector::new(300.0, 210.0), most);
    let spare = Vector::new((most.x - wide.frame().size().x) / 2.0, 0.0);
    let min = Point::new(LEFT, wide.frame().max.y + BELOW + 76.0);
    (wide.moved_to(corner + spare), Bounds { min, max: Point::new(right, min.y + 250.0) })
}

/// The tracks on the map, the widest lowest.
fn walked(view: &View, tracks: &[Track], ground: &mut Ground) -> Group {
    let mut group = Group::new().set("class", "tracks");
    for (i, track) in tracks.iter().enumerate() {
        let points: Vec<Point> = track.positions.iter().map(|p| view.px(*p)).collect();
        if points.len() > 1 {
            let width = width_by_rank(i, tracks.len());
            ground.add(&points, width, 4.0);
            let line = Look::of(i).draw(&points, width);
            group = group.add(Group::new().set("data-track", i).add(line));
        }
    }
    group
}

fn heading(text: &str, at: Point) -> Group {
    Group::new().set("font-weight", "bold").add(Words::new().plain(text).at(at, LARGE, Align::Left))
}

/// What the lines and the cross mean, in columns, and the y at which that ends.
fn legend(at: Point, tracks: &[Track]) -> (Group, f64) {
    const SAMPLE: f64 = 54.0;
    const LINE: f64 = 26.0;
    let mut entries: Vec<Words> = tracks.iter().map(|t| Words::new().plain(shorten(&t.label, 40))).collect();
    if tracks.iter().any(|t| t.transition.is_some()) {
        entries.push(Words::new().plain("human takes the lead"));
    }
    let widest = entries.iter().map(|w| w.width(SMALL)).fold(0.0, f64::max);
    let pitch = SAMPLE + 10.0 + widest + 24.0;
    let columns = (((WIDTH - at.x) / pitch) as usize).max(1);
    let mut group = Group::new().set("class", "legend");
    for (i, words) in entries.iter().enumerate() {
        let (row, column) = ((i / columns) as f64, (i % columns) as f64);
        let from = at + Vector::new(column * pitch, row * LINE);
        let to = from + Vector::new(SAMPLE, 0.0);
        group = match tracks.get(i) {
            Some(_) => group.add(Look::of(i).draw(&[from, to], width_by_rank(i, tracks.len()))),
            None => group.add(Look::of(4).cross(nalgebra::center(&from, &to))),
        };
        group = group.add(words.at(to + Vector::new(10.0, 0.35 * SMALL), SMALL, Align::Left));
    }
    (group, at.y + entries.len().div_ceil(columns) as f64 * LINE)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn world() -> World {
        World::parse(
            "test",
            "name = \"<&\"\nrobot_width_m = 0.5\nstart_m = [0.0, 0.0]\ntarget_m = [3.0, 0.0]\n",
        )
        .unwrap()
    }

    fn track(label: &str) -> Track {
        Track {
            first_step: 0,
            label: label.to_owned(),
            positions: (0..4).map(|i| Point::new(f64::from(i), 0.0)).collect(),
            transition: Some(2),
            stubbornness: vec![0.2, 0.6, 1.3, 1.3],
        }
    }

    #[test]
    fn the_figure_is_well_formed_deterministic_and_shows_every_track() {
        let tracks =
            [track("<&\""), track("b"), Track { positions: Vec::new(), transition: None, ..track("c") }];
        let picture = adaptation(&world(), &tracks, 0.1).unwrap();
        assert_eq!(picture, adaptation(&world(), &tracks, 0.1).unwrap());
        assert_eq!(picture.matches("data-track=").count(), 2);
        assert!(!picture.contains("NaN") && !picture.contains("inf"));
        crate::drawing::tests::check_well_formed(&picture);
        crate::drawing::tests::check_well_formed(&adaptation(&world(), &[], 0.1).unwrap());
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        let with = |change: fn(&mut Track)| {
            let mut track = track("t");
            change(&mut track);
            adaptation(&world(), &[track], 0.1)
        };
        assert!(matches!(
            with(|t| t.positions[1].x = f64::NAN),
            Err(DrawingError::NotDrawable { step: 1, .. })
        ));
        assert!(matches!(
            with(|t| t.stubbornness[3] = f64::NAN),
            Err(DrawingError::NotDrawable { step: 3, .. })
        ));
        assert!(matches!(with(|t| t.transition = Some(4)), Err(DrawingError::Transition { .. })));
        assert!(with(|t| t.stubbornness[2] = f64::INFINITY).is_ok());
        assert!(matches!(adaptation(&world(), &[], 0.0), Err(DrawingError::Period { .. })));
    }
}
