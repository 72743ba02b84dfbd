//! A world that is being drawn: outlines, openings, options, and the regions of the (alpha, gamma) plane.

use crate::parts::{BeliefPart, SettingsPart, predictor};
use cocarry::Error;
use cocarry::episode::{OptionTick, prospects};
use cocarry::options::OptionSet;
use cocarry::preference::{
    ChoiceDistribution, Perception, Predictor, Prospect, Regions, Ways, objective_cost,
};
use cocarry::world::{BuiltInWorld, World};
use cocarry_output::player;
use serde::Deserialize;
use serde_json::{Value, json};

/// The name in errors of a world that has none.
const FILE: &str = "world.toml";

/// A request of a world.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Request {
    /// The text of the world file, or the name of a built-in world.
    text: Option<String>,
    name: Option<String>,
    /// Its name in errors.
    file: Option<String>,
    /// The width of a robot, which may be wider than the file says, m.
    #[serde(default)]
    robot_width_m: f64,
    #[serde(default)]
    settings: SettingsPart,
    #[serde(default)]
    belief: BeliefPart,
    #[serde(default)]
    regions: bool,
}

/// The world as it is drawn, with its options.
///
/// # Errors
/// The world, a setting or the belief is not valid.
pub fn world(request: Request) -> Result<Value, Error> {
    let Request { text, name, file, robot_width_m, settings, belief, regions } = request;
    let file = file.as_deref().or(name.as_deref()).unwrap_or(FILE);
    let built_in = name.as_deref().and_then(BuiltInWorld::named).map(|world| world.text);
    let text = text.as_deref().or(built_in);
    let text = text
        .ok_or_else(|| Error::new("the request of a world needs its text, or the name of a built-in one"))?;
    let mut predictor = predictor(&settings, &belief)?;
    let world = World::parse_for(file, text, if robot_width_m > 0.0 { robot_width_m } else { 0.0 })?;
    let set = OptionSet::new(&world, predictor.risk_weight())?;
    let options = evaluated(&set, &mut predictor);
    let mut drawn = player::world(&world);
    for (o, opening) in world.openings.iter().enumerate() {
        let drawn = &mut drawn["openings"][o];
        drawn["used"] = set.uses(o).into();
        drawn["leads_nowhere_new"] = set.leads_nowhere_new(o).into();
        drawn["detected"] = world.openings_detected.into();
        drawn["between"] = opening.between.map(|i| world.obstacles[i].name.as_str()).as_slice().into();
    }
    let parts = world.obstacles.iter().enumerate().flat_map(|(i, o)| o.footprints().map(move |_| i));
    for (part, index) in parts.enumerate() {
        drawn["obstacles"][part]["index"] = index.into();
    }
    let of_option = |(o, option): (usize, &OptionTick)| {
        let mut drawn = player::option(o, &set, &world);
        drawn["length_m"] = option.remaining.length.into();
        drawn["risk"] = option.remaining.risk.into();
        drawn["objective_cost_m"] = option.objective.into();
        drawn["expected_subjective_cost"] = option.expected.into();
        drawn["probability"] = option.probability.into();
        drawn
    };
    drawn["file"] = world.file.as_str().into();
    drawn["note"] = world.note.as_str().into();
    drawn["is_widened"] = world.is_widened.into();
    drawn["warnings"] = world.warnings().into();
    drawn["options_cut"] = set.is_cut.into();
    drawn["options"] = options.iter().enumerate().map(of_option).collect();
    if regions {
        drawn["regions"] = plane(&prospects(&set, &set.begin()), &Ways::default(), &predictor);
    }
    Ok(drawn)
}

/// The options at the start, by eqs. (1), (4) and (6).
pub fn evaluated(set: &OptionSet, predictor: &mut Predictor) -> Vec<OptionTick> {
    let begin = set.begin();
    let prospects = prospects(set, &begin);
    let (mut choice, mut expected) = (ChoiceDistribution::default(), Vec::new());
    predictor.predict(&prospects, &mut choice);
    predictor.expected_costs(&prospects, &mut expected);
    let option = |o: usize| OptionTick {
        remaining: set.remaining(&begin, o),
        objective: objective_cost(prospects[o], predictor.risk_weight()),
        expected: expected[o],
        probability: choice.probabilities()[o],
        misaligned: false,
    };
    (0..set.options().len()).map(option).collect()
}

/// R_o over the ranges of the belief. Options that have become one of the `ways` are the one that represents them.
pub fn plane(prospects: &[Prospect], ways: &Ways, predictor: &Predictor) -> Value {
    let [alpha, gamma] = predictor.belief().ranges();
    let regions = Regions::of_ways(prospects, ways, predictor.risk_weight(), alpha, gamma);
    let line = |line: &[Perception]| line.iter().map(|p| json!([p.alpha, p.gamma])).collect::<Vec<_>>();
    json!({
        "alpha": regions.alpha,
        "gamma": regions.gamma,
        "parts": regions.parts.iter().map(|part| json!({
            "option": part.option, "outline": line(&part.outline),
        })).collect::<Vec<_>>(),
        "borders": regions.borders.iter().map(|border| line(border)).collect::<Vec<_>>(),
    })
}
