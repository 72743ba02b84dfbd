//! The map of a world: obstacles, openings coloured by risk, options as paths, and a table of the options.

use super::kit::{
    AXIS_ROOM, Clutter, FAINT, FAINT_WIDTH, GAP, LEFT_ROOM, LineStyle, MARGIN, Sheet, TITLE_ROOM,
    document_on, frame_title, stroke, widths_by_probability,
};
use super::map_view::MapView;
use super::opening_labels::{PATH_COST, clutter, opening_labels};
use super::option_table::{MIN_WIDTH, Route, option_table};
use super::{check_probabilities, unequal};
use cocarry::Error;
use cocarry::geometry::{Point, Vector};
use cocarry::options::OptionSet;
use cocarry::world::World;
use svg::node::element::{Element, Group};

/// Largest number of options that a map shows in colour and lists; the others are thin and grey.
pub const MAX_LISTED: usize = 12;

/// Largest distance of a drawn arc from its chords, m.
const SAGITTA: f64 = 0.01;

/// The map of a world: obstacles, openings coloured by risk, and every option as a path from A to B whose
/// width grows with its probability.
///
/// `probabilities` holds P_o of every option, in the order of `options`. With more than [`MAX_LISTED`]
/// options, the most probable ones are shown in colour, and the table says so. Of equally probable options,
/// the first has priority, which is the cheapest where options were enumerated.
///
/// # Errors
/// There is not a probability from 0 to 1 for every option.
pub fn world_map(
    world: &World,
    options: &OptionSet,
    probabilities: &[f64],
    sheet: Sheet,
) -> Result<String, Error> {
    let (listed, others) = routes(world, options, probabilities)?;
    let top = Point::new(LEFT_ROOM, TITLE_ROOM);
    let points = listed.iter().chain(&others).flat_map(|r| r.points.iter().copied());
    let most = Vector::new(sheet.width - LEFT_ROOM - MARGIN, 700.0);
    let view = MapView::fit(world, points, top, Vector::new(214.0, 210.0), most);
    let free_width = sheet.width - view.frame().max.x - 2.0 * MARGIN;
    let (view, at, width) = if free_width >= MIN_WIDTH {
        (view, Point::new(view.frame().max.x + MARGIN, top.y), free_width)
    } else {
        let spare = Vector::new((most.x - view.frame().size().x) / 2.0, 0.0);
        let below = Point::new(MARGIN, view.frame().max.y + AXIS_ROOM + MARGIN);
        (view.moved_to(top + spare), below, sheet.width - 2.0 * MARGIN)
    };
    let frame = view.frame();
    let widths = widths_by_probability(listed.iter().map(|r| r.probability));
    let mut clutter = clutter(&view, world);
    let paths = paths(&view, &listed, &widths, &others, &mut clutter);
    let labels = opening_labels(&view, world, true, &mut clutter);
    let notes = [
        options.is_cut.then_some("more options exist than were enumerated"),
        (labels.without_width > 0).then_some("widths without room are left out; cocarry world lists them"),
    ];
    let notes: Vec<&str> = notes.into_iter().flatten().collect();
    let (table, bottom) = option_table(at, width, &listed, &widths, &others, &notes);
    let picture = document_on(sheet, bottom.max(frame.max.y + AXIS_ROOM) + GAP)
        .add(frame_title(&world.name, frame.min.x, frame))
        .add(view.obstacles(world))
        .add(paths)
        .add(view.openings(world, true))
        .add(view.ends(world))
        .add(labels.group)
        .add(view.axes())
        .add(table);
    Ok(picture.to_string())
}

/// The options to show in colour, in their own order, and the others.
fn routes(
    world: &World,
    options: &OptionSet,
    probabilities: &[f64],
) -> Result<(Vec<Route>, Vec<Route>), Error> {
    let all = options.options();
    if probabilities.len() != all.len() {
        return Err(unequal(probabilities.len(), all.len()));
    }
    check_probabilities(all.iter().map(|o| o.name.as_str()).zip(probabilities.iter().copied()))?;
    let begin = options.begin();
    let mut listed: Vec<Route> = probabilities
        .iter()
        .enumerate()
        .map(|(index, &probability)| {
            let option = &all[index];
            let remaining = options.remaining(&begin, index);
            Route {
                index,
                name: option.name.clone(),
                openings: option.crossings.iter().map(|c| world.openings[c.opening].name.clone()).collect(),
                length: remaining.length,
                risk: remaining.risk,
                probability,
                points: options
                    .path(&begin, index)
                    .expect("an option has a path from the start")
                    .polyline(SAGITTA),
            }
        })
        .collect();
    listed.sort_by(|a, b| b.probability.total_cmp(&a.probability).then(a.index.cmp(&b.index)));
    let others = listed.split_off(listed.len().min(MAX_LISTED));
    listed.sort_by_key(|r| r.index);
    Ok((listed, others))
}

/// The paths, drawn from wide to narrow, so that those with a common leg remain visible.
fn paths(view: &MapView, listed: &[Route], widths: &[f64], others: &[Route], clutter: &mut Clutter) -> Group {
    let mut order: Vec<(&Route, f64)> = listed.iter().zip(widths.iter().copied()).collect();
    order.sort_by(|a, b| b.1.total_cmp(&a.1));
    let faint = others.iter().map(|route| (route, None));
    let all = faint.chain(order.into_iter().map(|(route, width)| (route, Some(width))));
    let mut group = Group::new().set("class", "options");
    for (route, width) in all.filter(|(route, _)| route.points.len() > 1) {
        let points: Vec<Point> = route.points.iter().map(|p| view.px(*p)).collect();
        let line: Element = match width {
            Some(width) => LineStyle::of(route.index).draw(&points, width).into(),
            None => stroke(&points, FAINT, FAINT_WIDTH).into(),
        };
        clutter.add(
            &points,
            width.unwrap_or(FAINT_WIDTH),
            if width.is_some() { PATH_COST } else { PATH_COST / 2.0 },
        );
        group = group.add(Group::new().set("data-option", route.index).add(line));
    }
    group
}

#[cfg(test)]
mod tests {
    use super::super::tests::error;
    use super::*;
    use crate::drawing::tests::checked;

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
        let picture = checked(|| world_map(&world, &options, &vec![1.0 / n as f64; n], Sheet::default()));
        assert_eq!(picture.matches("data-option=").count(), n);
        assert!(picture.contains("&lt;Two &amp; &quot;ways&quot;&gt;"), "{picture}");
    }

    #[test]
    fn probabilities_are_checked() {
        let (world, options) = scene();
        let n = options.options().len();
        let refused = error(world_map(&world, &options, &[], Sheet::default()));
        assert_eq!(refused, format!("0 probabilities were given for {n} options"));
        let refused = error(world_map(&world, &options, &vec![f64::NAN; n], Sheet::default()));
        assert!(refused.contains("its probability is NaN"), "{refused}");
    }
}
