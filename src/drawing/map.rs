//! A world, its options and their probabilities in; the map of the world, with a legend, out.

use super::labels::Ground;
use super::legend::{Row, legend};
use super::scene::{BELOW, LEFT, View, document};
use super::style::{LARGE, Look, stroke, widths_by_probability};
use super::text::{Align, Words, shorten};
use super::{DrawingError, WIDTH};
use crate::geometry::{Point, Vector};
use crate::options::OptionSet;
use crate::world::World;
use svg::node::element::{Element, Group};

/// How many options a map shows in colour and lists; the others are thin and grey.
pub const MOST_LISTED: usize = 12;

/// How far a drawn arc may be from its chords, m.
const SAGITTA: f64 = 0.01;

/// An option as it is drawn.
struct Route {
    index: usize,
    probability: f64,
    /// World frame, m; empty where there is no way.
    points: Vec<Point>,
}

/// The map of a world: obstacles, openings coloured by risk, and every option as a path from A to B whose width grows with its probability.
///
/// `probabilities` holds P_o of every option, in the order of `options`. Beyond [`MOST_LISTED`] options, the most probable are shown in
/// colour (of equally probable ones, the first, which is the cheapest where options were enumerated); the legend says so.
///
/// # Errors
/// [`DrawingError::ProbabilityCount`], [`DrawingError::Probability`].
pub fn world_map(world: &World, options: &OptionSet, probabilities: &[f64]) -> Result<String, DrawingError> {
    let (listed, others) = routes(options, probabilities)?;
    let top = Point::new(LEFT, 44.0);
    let points = listed.iter().chain(&others).flat_map(|r| r.points.iter().copied());
    let most = Vector::new(WIDTH - LEFT - 26.0, 700.0);
    let view = View::fit(world, points, top, Vector::new(214.0, 210.0), most);

    let rows: Vec<Row> = listed.iter().map(|r| row(world, options, r)).collect();
    let beside = WIDTH - view.frame().max.x - 40.0;
    let (view, at, width) = if beside >= super::legend::LEAST_WIDTH {
        (view, Point::new(view.frame().max.x + 26.0, top.y), beside)
    } else {
        let spare = Vector::new((most.x - view.frame().size().x) / 2.0, 0.0);
        let below = view.frame().max.y + BELOW + 18.0;
        (view.moved_to(top + spare), Point::new(20.0, below), WIDTH - 34.0)
    };
    let frame = view.frame();
    let left_out: f64 = others.iter().map(|r| r.probability).sum();
    let (legend, bottom) = legend(at, width, &rows, others.len(), left_out, options.is_cut);

    let title = Words::new().plain(shorten(&world.name, 60));
    let title = Group::new().set("font-weight", "bold").add(title.at(
        Point::new(frame.min.x, 28.0),
        LARGE,
        Align::Left,
    ));
    let mut ground = Ground::of(&view, world);
    let paths = paths(&view, &listed, &others, &mut ground);
    let names = ground.label_openings(&view, world, true);
    let height = bottom.max(frame.max.y + BELOW) + 10.0;
    let picture = document(height)
        .add(title)
        .add(view.obstacles(world))
        .add(paths)
        .add(view.openings(world, true))
        .add(view.ends(world))
        .add(names)
        .add(view.axes())
        .add(legend);
    Ok(picture.to_string())
}

/// The options to show in colour, in their own order, and the others.
fn routes(options: &OptionSet, probabilities: &[f64]) -> Result<(Vec<Route>, Vec<Route>), DrawingError> {
    let all = options.options();
    if probabilities.len() != all.len() {
        return Err(DrawingError::ProbabilityCount {
            probabilities: probabilities.len(),
            options: all.len(),
        });
    }
    // rounding may leave a sum of areas a little above 1
    if let Some(i) = probabilities.iter().position(|p| !(0.0..=1.0 + 1e-9).contains(p)) {
        return Err(DrawingError::Probability { option: all[i].name.clone(), value: probabilities[i] });
    }
    let begin = options.begin();
    let mut listed: Vec<Route> = probabilities
        .iter()
        .enumerate()
        .map(|(index, &probability)| {
            let points = options.path(&begin, index).map(|p| p.polyline(SAGITTA)).unwrap_or_default();
            Route { index, probability, points }
        })
        .collect();
    listed.sort_by(|a, b| b.probability.total_cmp(&a.probability).then(a.index.cmp(&b.index)));
    let others = listed.split_off(listed.len().min(MOST_LISTED));
    listed.sort_by_key(|r| r.index);
    Ok((listed, others))
}

/// What the legend says of an option; its line is as wide as on the map.
fn row(world: &World, options: &OptionSet, route: &Route) -> Row {
    let option = &options.options()[route.index];
    let remaining = options.remaining(&options.begin(), route.index);
    Row {
        name: option.name.clone(),
        openings: option.crossings.iter().map(|c| world.openings[c.opening].name.clone()).collect(),
        length: remaining.length,
        risk: remaining.risk,
        probability: route.probability,
    }
}

/// The paths, the widest lowest, so that those which share a leg remain visible.
fn paths(view: &View, listed: &[Route], others: &[Route], ground: &mut Ground) -> Group {
    let widths = widths_by_probability(listed.iter().map(|r| r.probability));
    let mut order: Vec<usize> = (0..listed.len()).collect();
    order.sort_by(|&a, &b| widths[b].total_cmp(&widths[a]));
    let px = |route: &Route| -> Vec<Point> { route.points.iter().map(|p| view.px(*p)).collect() };
    let mut group = Group::new().set("class", "options");
    for route in others.iter().filter(|r| r.points.len() > 1) {
        let points = px(route);
        ground.add(&points, 1.1, 2.0);
        group = group.add(labelled(route, stroke(&points, Look::FAINT.colour, 1.1).into()));
    }
    for place in order.into_iter().filter(|&i| listed[i].points.len() > 1) {
        let points = px(&listed[place]);
        ground.add(&points, widths[place], 4.0);
        group = group.add(labelled(&listed[place], Look::of(place).draw(&points, widths[place]).into()));
    }
    group
}

fn labelled(route: &Route, line: Element) -> Group {
    Group::new().set("data-option", route.index).add(line)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WORLD: &str = r#"
name = "<Two & \"ways\">"
robot_width_m = 0.5
start_m = [0.0, 0.0]
target_m = [6.0, 0.0]
[[obstacle]]
name = "a<&"
shape = "box"
center_m = [3.0, 0.0]
size_m = [0.2, 2.0]
height_m = 1.0
[[obstacle]]
name = "b"
shape = "cylinder"
center_m = [3.0, 3.0]
radius_m = 1.0
height_m = 1.0
[[obstacle]]
name = "c"
shape = "polygon"
vertices_m = [[2.9, -5.0], [3.1, -5.0], [3.1, -1.8], [2.9, -1.8]]
height_m = 1.0
[[opening]]
name = "<&\""
between = ["a<&", "b"]
[[opening]]
name = "xi2"
between = ["a<&", "c"]
"#;

    fn scene() -> (World, OptionSet) {
        let world = World::parse("test", WORLD).unwrap();
        let options = OptionSet::new(&world, 10.0).unwrap();
        (world, options)
    }

    #[test]
    fn a_map_is_well_formed_deterministic_and_shows_every_option() {
        let (world, options) = scene();
        let n = options.options().len();
        let draw = || world_map(&world, &options, &vec![1.0 / n as f64; n]).unwrap();
        let picture = draw();
        assert_eq!(picture, draw());
        assert_eq!(picture.matches("data-option=").count(), n);
        assert!(!picture.contains("NaN") && !picture.contains("inf"), "{picture}");
        assert!(picture.contains("&lt;Two &amp; &quot;ways&quot;&gt;"), "{picture}");
        crate::drawing::tests::check_well_formed(&picture);
    }

    #[test]
    fn probabilities_are_checked() {
        let (world, options) = scene();
        let n = options.options().len();
        assert!(matches!(world_map(&world, &options, &[]), Err(DrawingError::ProbabilityCount { .. })));
        let bad = world_map(&world, &options, &vec![f64::NAN; n]);
        assert!(matches!(bad, Err(DrawingError::Probability { .. })));
    }
}
