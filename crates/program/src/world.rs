//! `cocarry world`: shows a world's obstacles, openings and options, as tables, JSON or a map.

use super::model::{ModelArguments, load_world};
use super::output::{
    Failure, OPTION_HEADINGS, OverwriteArguments, examples, input, option_json, print, print_json, svg_file,
    table, table_text, toml_file, warn, with_spinner, write_file,
};
use anyhow::Context;
use clap::Args;
use cocarry::episode::{OptionTick, prospects};
use cocarry::geometry::{Footprint, Point};
use cocarry::options::{OptionSet, PathOption};
use cocarry::preference::{ChoiceDistribution, Predictor, objective_cost};
use cocarry::world::{Obstacle, World};
use cocarry_maps::Ends;
use cocarry_output::drawing;
use cocarry_recording::rendering::Width;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Show the obstacles of a world, its openings with width and risk, and its options with length, risk, cost
/// and probability
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry world environment-4", ""),
    ("cocarry world my-world.toml --svg map.svg", "your world, with a map"),
    ("cocarry world environment-1 --risk-weight 5", "options for a smaller weight of risk"),
    ("cocarry world map.yaml --start 0,0 --target 4,1.5 --write room.toml", "a map of map_server, kept as a world file"),
]))]
pub(super) struct WorldArguments {
    /// World file (TOML), a built-in world (see `cocarry worlds`), or a map: the YAML of ROS's map_server, or
    /// a floor plan (GeoJSON, SVG)
    world: PathBuf,
    #[command(flatten)]
    map: MapArguments,
    #[command(flatten)]
    model: ModelArguments,
    /// Print one JSON object instead of tables
    #[arg(long)]
    json: bool,
    /// Draw the map into this SVG file
    #[arg(long, value_name = "FILE", value_parser = svg_file)]
    svg: Option<PathBuf>,
    /// Width of the map, in inches or pixels: 3.5in, 1200px. Type is at least 7 pt from 3.5 inches on
    /// [default: 720px]
    #[arg(long, value_name = "WIDTH", requires = "svg", value_parser = clap::value_parser!(Width))]
    width: Option<Width>,
    /// Write the world into this file (TOML), with the outlines of its map
    #[arg(long, value_name = "FILE", value_parser = toml_file)]
    write: Option<PathBuf>,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

/// The parts of a world that a map does not have.
#[derive(Args, Debug)]
struct MapArguments {
    /// Start A on a map, in metres
    #[arg(long, value_name = "X,Y", value_parser = point, requires = "target", allow_hyphen_values = true)]
    start: Option<Point>,
    /// Target B on a map, in metres
    #[arg(long, value_name = "X,Y", value_parser = point, requires = "start", allow_hyphen_values = true)]
    target: Option<Point>,
    /// Width d_r of the robot on a map, in metres [default: 0.5]
    #[arg(long, value_name = "M", requires = "start")]
    robot_width: Option<f64>,
    /// Largest distance of outlines from the sides of a map's cells, in metres [default: a cell]
    #[arg(long, value_name = "M", requires = "start")]
    tolerance: Option<f64>,
}

impl MapArguments {
    fn world(&self, path: &Path) -> Result<World, Failure> {
        let (Some(start), Some(target)) = (self.start, self.target) else { return load_world(path) };
        if !cocarry_maps::is_map(path) {
            let path = path.display();
            return Err(input(anyhow::anyhow!(
                "{path}: --start and --target are for maps (.yaml, .geojson, .svg); a world file has start_m and target_m"
            )));
        }
        let ends = Ends { start, target, robot_width: self.robot_width, tolerance: self.tolerance };
        let world = cocarry_maps::from_map(path, &ends).map_err(input)?;
        world.warnings().iter().for_each(warn);
        Ok(world)
    }
}

/// The point in `text`, X,Y.
fn point(text: &str) -> Result<Point, String> {
    let coordinates = text.split_once(',').and_then(|(x, y)| {
        let number = |text: &str| text.trim().parse().ok().filter(|number: &f64| number.is_finite());
        Some((number(x)?, number(y)?))
    });
    let (x, y) = coordinates.ok_or("must be X,Y in metres, as in -2.0,0.5")?;
    Ok(Point::new(x, y))
}

/// The heading of the lengths of the shortest paths through the same openings, which need not be straight.
const MIN_HEADING: &str = "shortest (m)";

/// An option, evaluated at the start.
struct Offer {
    name: String,
    openings: Vec<String>,
    option: OptionTick,
    /// Length of the shortest path through the same openings, m; `None` in worlds too large for it.
    shortest: Option<f64>,
}

pub(super) fn run_world(arguments: &WorldArguments) -> Result<ExitCode, Failure> {
    let inputs = [Some(&arguments.world), arguments.model.belief.belief_samples.as_ref()];
    let inputs = inputs.into_iter().flatten().map(PathBuf::as_path);
    let files = arguments.svg.iter().chain(&arguments.write);
    let outputs = arguments.overwrite.outputs(inputs, files)?;
    let mut predictor = arguments.model.predictor()?;
    let (world, set) = with_spinner("searching for the path options", || {
        let world = arguments.map.world(&arguments.world)?;
        let set = OptionSet::new(&world, predictor.risk_weight()).map_err(input)?;
        Ok((world, set))
    })?;
    let offers = offers(&world, &set, &mut predictor);
    if let Some(path) = &arguments.write {
        write_file(&outputs, path, &world.text)?;
    }
    if let Some(path) = &arguments.svg {
        let probabilities: Vec<f64> = offers.iter().map(|o| o.option.probability).collect();
        let svg = drawing::world_map(&world, &set, &probabilities, Width::sheet_or_default(arguments.width))
            .with_context(|| path.display().to_string())
            .map_err(Failure::Output)?;
        write_file(&outputs, path, &svg)?;
    }
    if arguments.json {
        print_json(&as_json(&world, &set, &offers))?;
    } else {
        print(&as_text(&world, &set, &offers))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn offers(world: &World, set: &OptionSet, predictor: &mut Predictor) -> Vec<Offer> {
    let prospects = prospects(set, &set.begin());
    let mut choice = ChoiceDistribution::default();
    let mut expected = Vec::new();
    predictor.predict(&prospects, &mut choice);
    predictor.expected_costs(&prospects, &mut expected);
    let shortest = set.shortest_lengths(world);
    let offer = |(o, option): (usize, &PathOption)| Offer {
        name: option.name.clone(),
        openings: option.crossings.iter().map(|c| world.openings[c.opening].name.clone()).collect(),
        option: OptionTick {
            remaining: set.remaining(&set.begin(), o),
            objective: objective_cost(prospects[o], predictor.risk_weight()),
            expected: expected[o],
            probability: choice.probabilities()[o],
            misaligned: false,
        },
        shortest: shortest.as_ref().map(|lengths| lengths[o]),
    };
    set.options().iter().enumerate().map(offer).collect()
}

fn as_text(world: &World, set: &OptionSet, offers: &[Offer]) -> String {
    let mut text = format!("{} ({})\n", world.name, world.file);
    if !world.note.is_empty() {
        text += &format!("{}\n", world.note);
    }
    text += &format!(
        "from A ({:.3}, {:.3}) to B ({:.3}, {:.3}), robot width d_r = {} m\n\nObstacles\n",
        world.start.x, world.start.y, world.target.x, world.target.y, world.robot_width
    );
    let mut obstacles = table(["name", "shape", "x (m)", "y (m)", "extent (m)", "height (m)"], 2);
    for o in &world.obstacles {
        let (middle, size) = (o.middle(), o.bounds().size());
        obstacles.add_row([
            o.name.clone(),
            o.shape_name().to_owned(),
            format!("{:.3}", middle.x),
            format!("{:.3}", middle.y),
            format!("{:.2} x {:.2}", size.x, size.y),
            format!("{:.2}", o.height),
        ]);
    }
    text += &table_text(&obstacles);
    let origin = if world.openings_detected { " (detected: the file lists none)" } else { "" };
    text += &format!("\nOpenings{origin}\n");
    let mut openings = table(["name", "between", "width (m)", "risk"], 2);
    for o in &world.openings {
        let [first, second] = o.between.map(|i| &world.obstacles[i].name);
        let risk = o.risk(world.robot_width);
        openings.add_row([
            o.name.clone(),
            format!("{first}, {second}"),
            format!("{:.4}", o.width),
            match (risk == 0.0, o.share < 1.0) {
                (true, _) => format!("0 (wider than {} d_r)", o.free_passage),
                (false, true) => format!("{risk:.4} ({:.0} % of {:.4}: *)", 100.0 * o.share, risk / o.share),
                (false, false) => format!("{risk:.4}"),
            },
        ]);
    }
    text += &table_text(&openings);
    if world.openings.iter().any(|o| o.share < 1.0 && o.risk(world.robot_width) > 0.0) {
        text += "* a narrower gap of the same passage is less than two robot widths away: this share of the risk counts\n";
    }
    text += &unused_openings(world, set);
    text += &closed_gaps(world);
    let origin = match (world.listed_options.is_empty(), set.is_cut) {
        (false, _) => String::new(),
        (true, false) => " (all options: the file lists none)".to_owned(),
        (true, true) if set.is_search_cut => {
            format!(" (the search was cut after {} of them: others may be cheaper)", offers.len())
        }
        (true, true) => {
            format!(" (the {} cheapest; increase option_limit in the file for more)", offers.len())
        }
    };
    text += &format!("\nOptions{origin}\n");
    let mut headings = OPTION_HEADINGS.to_vec();
    headings.insert(3, MIN_HEADING);
    let mut options = table(headings, 2);
    for o in offers {
        options.add_row([
            o.name.clone(),
            if o.openings.is_empty() { "(none)".to_owned() } else { o.openings.join(" ") },
            format!("{:.4}", o.option.remaining.length),
            o.shortest.map_or("-".to_owned(), |length| format!("{length:.4}")),
            format!("{:.4}", o.option.remaining.risk),
            format!("{:.4}", o.option.objective),
            format!("{:.4}", o.option.expected),
            format!("{:.2}", 100.0 * o.option.probability),
        ]);
    }
    text + &table_text(&options)
}

/// A line for the widest gaps that are too narrow to be openings, where openings are detected.
fn closed_gaps(world: &World) -> String {
    const MAX_LISTED: usize = 3;
    let gaps = if world.openings_detected { world.impassable_gaps() } else { Vec::new() };
    // obstacles that touch leave none
    let gaps = gaps.iter().filter(|gap| gap.width > 0.01).take(MAX_LISTED).map(|gap| {
        let [first, second] = gap.between.map(|i| &world.obstacles[i].name);
        format!("{first} to {second} ({:.2} m)", gap.width)
    });
    let gaps: Vec<String> = gaps.collect();
    match gaps.is_empty() {
        true => String::new(),
        false => format!("too narrow for a robot {} m wide: {}\n", world.robot_width, gaps.join(", ")),
    }
}

/// A line for openings that lead from a region to itself, and one for the others that no option uses.
fn unused_openings(world: &World, set: &OptionSet) -> String {
    let line = |one: &str, many: &str, leads_nowhere_new: bool, what_to_do: &str| {
        let names: Vec<&str> = (0..world.openings.len())
            .filter(|&o| !set.uses(o) && set.leads_nowhere_new(o) == leads_nowhere_new)
            .map(|o| world.openings[o].name.as_str())
            .collect();
        match names.len() {
            0 => String::new(),
            1 => format!("1 opening {one} ({}){what_to_do}\n", names[0]),
            n => format!("{n} openings {many} ({}){what_to_do}\n", names.join(", ")),
        }
    };
    line(
        "leads nowhere new",
        "lead nowhere new",
        true,
        ": a path without openings leads around; list [[option]]s in the file to use them",
    ) + &line("is on none of these options", "are on none of these options", false, "")
}

fn as_json(world: &World, set: &OptionSet, offers: &[Offer]) -> Value {
    let point = |p: Point| json!([p.x, p.y]);
    json!({
        "name": world.name,
        "file": world.file,
        "robot_width_m": world.robot_width,
        "start_m": point(world.start),
        "target_m": point(world.target),
        "obstacles": world.obstacles.iter().map(obstacle_json).collect::<Vec<_>>(),
        "openings_detected": world.openings_detected,
        "openings": world.openings.iter().enumerate().map(|(i, o)| json!({
            "name": o.name,
            "between": o.between.map(|i| &world.obstacles[i].name),
            "center_m": point(o.center()),
            "ends_m": o.ends.map(point),
            "width_m": o.width,
            "risk": o.risk(world.robot_width),
            "risk_share": o.share,
            "used": set.uses(i),
            "leads_nowhere_new": set.leads_nowhere_new(i),
        })).collect::<Vec<_>>(),
        "options_enumerated": world.listed_options.is_empty(),
        "options_cut": set.is_cut,
        "search_cut": set.is_search_cut,
        "options": offers.iter().map(offer_json).collect::<Vec<_>>(),
    })
}

fn offer_json(offer: &Offer) -> Value {
    let mut fields = option_json(&offer.name, &offer.openings, &offer.option);
    fields["shortest_length_m"] = json!(offer.shortest);
    fields
}

fn obstacle_json(obstacle: &Obstacle) -> Value {
    let vertices = |corners: &[Point]| corners.iter().map(|c| [c.x, c.y]).collect::<Vec<_>>();
    let outline = match (&obstacle.outline, &obstacle.parts[0].footprint) {
        // the outline of a room is around the walls, too
        (Some(outline), _) => json!({ "vertices_m": outline.rings().last().map(|ring| vertices(ring)) }),
        (None, Footprint::Polygon(corners)) => json!({ "vertices_m": vertices(corners) }),
        (None, Footprint::Disc { center, radius }) => {
            json!({ "center_m": [center.x, center.y], "radius_m": radius })
        }
    };
    json!({
        "name": obstacle.name,
        "shape": obstacle.shape_name(),
        "height_m": obstacle.height,
        "outline": outline,
    })
}
