//! The figure of mutual adaptation: (a) tracks of teams on the map, (b) the stubbornness of their humans.

use super::Track;
use super::kit::{
    AXIS_ROOM, Clutter, GAP, INK, LEFT_ROOM, Legend, LineStyle, MARGIN, Shape, Sheet, TITLE_ROOM,
    document_on, frame_title, line_sample, mark, place, width_by_rank,
};
use super::map_view::MapView;
use super::opening_labels::{PATH_COST, clutter, opening_labels};
use super::stubbornness::stubbornness;
use cocarry::Error;
use cocarry::geometry::{Bounds, Point, Vector};
use cocarry::world::World;
use svg::node::element::Group;

/// Room above the chart for the time axis, px.
const TIME_ROOM: f64 = 62.0;

/// The paper's figure of stubbornness: (a) the tracks on the map of their world, with a cross where the human
/// took the lead; (b) phi(k) over the step k, and over time with steps of `period` (s), up to the step at
/// which it exceeds 1.
///
/// Tracks are drawn from wide to narrow, so that coinciding tracks remain visible. A map that is taller than
/// wide is placed next to the chart, any other map above it.
///
/// # Errors
/// A number of a track cannot be drawn, its transition is after its end, or the period is not positive.
pub fn adaptation(world: &World, tracks: &[Track], period: f64, sheet: Sheet) -> Result<String, Error> {
    if !(period.is_finite() && period > 0.0) {
        return Err(Error::new(format!("the period is {period} s; expected a positive number")));
    }
    tracks.iter().try_for_each(Track::check)?;
    let (view, chart) = panels(world, tracks, sheet.width);
    let map = view.frame();

    let mut clutter = clutter(&view, world);
    let walked = walked(&view, tracks, &mut clutter);
    let mut crosses = Group::new().set("class", "transitions");
    for (i, track) in tracks.iter().enumerate() {
        if let Some(at) = track.transition.and_then(|step| track.positions.get(step)) {
            let at = view.px(*at);
            clutter.take(Bounds { min: at, max: at }.grown(GAP));
            crosses = crosses.add(place(mark(Shape::Cross, true, &LineStyle::of(i).colour()), at));
        }
    }
    let labels = opening_labels(&view, world, false, &mut clutter).group;
    let mut legend = Legend::of_lines();
    for (i, track) in tracks.iter().enumerate() {
        legend =
            legend.entry(line_sample(LineStyle::of(i), width_by_rank(i, tracks.len())), track.label.as_str());
    }
    if tracks.iter().any(|t| t.transition.is_some()) {
        legend = legend.entry(mark(Shape::Cross, true, INK), "human takes the lead");
    }
    let top = map.max.y.max(chart.max.y) + AXIS_ROOM;
    let (legend, bottom) = legend.draw(Point::new(MARGIN, top), sheet.width - 2.0 * MARGIN);
    let picture = document_on(sheet, bottom)
        .add(frame_title(&format!("(a) {}", world.name), map.min.x, map))
        .add(frame_title("(b)", chart.min.x - LEFT_ROOM + MARGIN, chart))
        .add(view.obstacles(world))
        .add(view.openings(world, false))
        .add(walked)
        .add(view.ends(world))
        .add(crosses)
        .add(labels)
        .add(view.axes())
        .add(stubbornness(tracks, period, chart))
        .add(legend);
    Ok(picture.to_string())
}

/// The map, and the frame of the chart (px).
fn panels(world: &World, tracks: &[Track], width: f64) -> (MapView, Bounds) {
    const BESIDE: Vector = Vector::new(300.0, 450.0);
    let points = || tracks.iter().flat_map(|t| t.positions.iter().copied());
    let fit = |least, most, top| MapView::fit(world, points(), Point::new(LEFT_ROOM, top), least, most);
    let right = width - MARGIN;
    let size = fit(Vector::zeros(), BESIDE, 0.0).frame().size();
    if size.y >= size.x {
        let view = fit(Vector::new(200.0, 330.0), BESIDE, TIME_ROOM);
        let min = Point::new(view.frame().max.x + LEFT_ROOM, TIME_ROOM);
        return (view, Bounds { min, max: Point::new(right, view.frame().max.y) });
    }
    let most = Vector::new(right - LEFT_ROOM, 460.0);
    let view = fit(Vector::new(300.0, 210.0), most, TITLE_ROOM);
    let spare = Vector::new((most.x - view.frame().size().x) / 2.0, 0.0);
    let min = Point::new(LEFT_ROOM, view.frame().max.y + AXIS_ROOM + TIME_ROOM);
    (view.moved_to(view.frame().min + spare), Bounds { min, max: Point::new(right, min.y + 250.0) })
}

/// The tracks on the map, drawn from wide to narrow.
fn walked(view: &MapView, tracks: &[Track], clutter: &mut Clutter) -> Group {
    let mut group = Group::new().set("class", "tracks");
    for (i, track) in tracks.iter().enumerate().filter(|(_, track)| track.positions.len() > 1) {
        let points: Vec<Point> = track.positions.iter().map(|p| view.px(*p)).collect();
        let width = width_by_rank(i, tracks.len());
        clutter.add(&points, width, PATH_COST);
        group = group.add(LineStyle::of(i).draw(&points, width).set("data-track", i));
    }
    group
}

#[cfg(test)]
mod tests {
    use super::super::tests::error;
    use super::*;
    use crate::drawing::tests::checked;

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
        let picture = checked(|| adaptation(&world(), &tracks, 0.1, Sheet::default()));
        assert_eq!(picture.matches("data-track=").count(), 2);
        checked(|| adaptation(&world(), &[], 0.1, Sheet::default()));
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        let with = |change: fn(&mut Track)| {
            let mut track = track("t");
            change(&mut track);
            adaptation(&world(), &[track], 0.1, Sheet::default())
        };
        assert!(error(with(|t| t.positions[1].x = f64::NAN)).contains("its position at step 1 cannot"));
        assert!(error(with(|t| t.stubbornness[3] = f64::NAN)).contains("its stubbornness at step 3 cannot"));
        assert!(error(with(|t| t.transition = Some(4))).contains("its transition is at step 4, but"));
        assert!(with(|t| t.stubbornness[2] = f64::INFINITY).is_ok());
        assert!(error(adaptation(&world(), &[], 0.0, Sheet::default())).starts_with("the period is 0 s"));
    }
}
