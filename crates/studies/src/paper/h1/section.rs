//! H1: Table I, the preference regions whose area is P_o, and the perception of risk and distance.

use crate::paper::ENVIRONMENTS;
use crate::paper::h1::{self, ChoiceRow, Fit};
use crate::paper::part::{Block, Figure, Finding, Part, Plan, Section, holds, none};
use crate::table::{Columns, Table};
use cocarry::Error;
use cocarry::episode::prospects;
use cocarry::options::OptionSet;
use cocarry::preference::{ChoiceDistribution, Predictor, Regions, perceived_distance, perceived_risk};
use cocarry_output::drawing::{Curve, CurvePanel, RegionPanel, Sheet, curves, preference_regions, world_map};

/// Table I.
pub(crate) const PART: Part =
    Part { id: "h1", name: "Table I", episodes: none, studies: none, run: table_1_section };

/// The paper's ranges, and the value of a human with true perception.
const ALPHAS: [f64; 6] = [0.55, 0.65, 0.75, 0.85, 0.95, 1.0];
const GAMMAS: [f64; 6] = [0.5, 0.65, 0.8, 0.95, 1.1, 1.0];
/// The longest distance on the chart of perceived distance, m: slightly more than the environments' longest.
const MAX_DISTANCE_M: f64 = 45.0;

/// Table I: humans, the paper's model, the project's model.
pub fn table_1(rows: &[ChoiceRow]) -> Table {
    let (mean, worst) = h1::differences(rows);
    Columns::of(rows)
        .numbered("environment", "environment", |r| r.environment)
        .text("option", "option", |r| r.option.clone())
        .number("human (%)", "human_percent", 1, |r| r.human_percent)
        .number("paper's model (%)", "paper_percent", 1, |r| r.paper_percent)
        .number("ours (%)", "ours_percent", 1, |r| r.ours_percent)
        .derived("ours - paper", |r| signed(r.ours_percent - r.paper_percent))
        .derived("ours - human", |r| signed(r.ours_percent - r.human_percent))
        .table("table-1", "Table I: probability that a human chooses an option")
        .with_note(format!(
            "ours - paper's model: mean |difference| {mean:.2}, largest {worst:.2} percentage points."
        ))
        .with_note("The paper does not publish its worlds' geometry; it was calibrated to this table.")
}

/// A difference, without a sign where it rounds to 0.
fn signed(difference: f64) -> String {
    let text = format!("{difference:+.1}");
    if text.ends_with("0.0") { "0.0".to_owned() } else { text }
}

/// The difference of models from the humans' answers.
fn fits_table(fits: &[Fit]) -> Table {
    Columns::of(fits)
        .numbered("environment", "environment", |f| f.environment)
        .number("ours", "ours_points", 1, |f| f.ours)
        .number("paper's model", "paper_points", 1, |f| f.paper)
        .number("fixed parameters, at best", "fixed_points", 1, |f| f.fixed)
        .derived("pairs ranked as by humans", |f| format!("{} of {}", f.ranked, f.pairs))
        .data("ranked_pairs", |f| f.ranked)
        .data("pairs", |f| f.pairs)
        .table("table-1-fit", "Table I: mean absolute difference from the human column, percentage points")
        .with_note(
            "Fixed parameters give one option 100 % of the choices; shown is the least that any one option can be off. Environment 3's human column \
             sums to 95 %, as printed.",
        )
}

fn table_1_section(plan: &Plan, _: crate::parallel::OnDone) -> Result<Section, Error> {
    let predictor = &plan.settings.predictor;
    let rows = h1::table(predictor)?;
    let fits = h1::fits(&rows);
    let mut blocks = vec![
        Block::Text(
            "A human takes the option with the lowest subjective cost, eq. (3). The robot knows only ranges of \u{3b1} and \u{3b3}. P\u{2092} is the share of the ranges \
             in which the human takes option o, eq. (4)."
                .to_owned(),
        ),
        Block::Table(table_1(&rows)),
        Block::Table(fits_table(&fits)),
        Block::Figure(Figure {
            name: "preference-regions".to_owned(),
            caption: "Which option a human with (\u{3b1}, \u{3b3}) prefers at the start, by eq. (3). The percentage, P\u{2092}, is the region's share of the area.".to_owned(),
            is_half: false,
            svg: preference_regions(&panels(predictor)?)?,
        }),
        Block::Figure(Figure {
            name: "perception".to_owned(),
            caption: "Perceived risk (Prelec) and perceived distance (Stevens) over the paper's ranges of \u{3b3} and \u{3b1}; at 1, perception is true."
                .to_owned(),
            is_half: false,
            svg: curves(&perception())?,
        }),
    ];
    for environment in &ENVIRONMENTS {
        let world = environment.world()?;
        let set = OptionSet::new(&world, predictor.risk_weight())?;
        let choice = choice(predictor, &set);
        blocks.push(Block::Figure(Figure {
            name: environment.name.to_owned(),
            caption: format!(
                "Environment {}: openings with width and risk, options as wide as P\u{2092}.",
                environment.number
            ),
            is_half: true,
            svg: world_map(&world, &set, choice.probabilities(), Sheet::default())?,
        }));
    }
    Ok(Section { title: "H1: how humans choose".to_owned(), finding: finding(&rows, &fits), blocks })
}

fn finding(rows: &[ChoiceRow], fits: &[Fit]) -> Finding {
    let better = fits.iter().filter(|f| f.ours < f.fixed).count();
    let mean = |of: fn(&Fit) -> f64| fits.iter().map(of).sum::<f64>() / fits.len() as f64;
    let [ranked, pairs] = [fits.iter().map(|f| f.ranked).sum::<usize>(), fits.iter().map(|f| f.pairs).sum()];
    let (off, worst) = h1::differences(rows);
    Finding {
        claim: "H1: a distribution over (\u{3b1}, \u{3b3}) represents how humans choose better than fixed parameters",
        verdict: holds(better, fits.len(), "environments"),
        figures: format!(
            "{:.1} percentage points from the humans' answers on average (paper's model {:.1}; fixed parameters {:.1} at best); {ranked} of {pairs} pairs of \
             options ranked as by humans; {off:.1} from the paper's model on average, {worst:.1} at most (calibrated to it)",
            mean(|f| f.ours),
            mean(|f| f.paper),
            mean(|f| f.fixed),
        ),
    }
}

fn choice(predictor: &Predictor, set: &OptionSet) -> ChoiceDistribution {
    let mut choice = ChoiceDistribution::default();
    predictor.clone().predict(&prospects(set, &set.begin()), &mut choice);
    choice
}

fn panels(predictor: &Predictor) -> Result<Vec<RegionPanel>, Error> {
    let [alpha, gamma] = predictor.belief().ranges();
    let mut panels = Vec::new();
    for environment in &ENVIRONMENTS {
        let set = OptionSet::new(&environment.world()?, predictor.risk_weight())?;
        let choice = choice(predictor, &set);
        let names = set.options().iter().map(|o| o.name.clone());
        panels.push(RegionPanel {
            title: format!("Environment {}", environment.number),
            regions: Regions::new(&prospects(&set, &set.begin()), predictor.risk_weight(), alpha, gamma),
            options: names.zip(choice.probabilities().iter().copied()).collect(),
        });
    }
    Ok(panels)
}

fn perception() -> Vec<CurvePanel> {
    let curve = |label: String, most: f64, of: &dyn Fn(f64) -> f64| Curve {
        label,
        points: (0..=100).map(|i| most * f64::from(i) / 100.0).map(|x| [x, of(x)]).collect(),
    };
    vec![
        CurvePanel {
            title: "perceived risk".to_owned(),
            axes: ["risk S".to_owned(), "perceived risk".to_owned()],
            ranges: [[0.0, 1.0]; 2],
            mark: None,
            curves: GAMMAS
                .iter()
                .map(|g| curve(format!("\u{3b3} = {g}"), 1.0, &|s| perceived_risk(s, *g)))
                .collect(),
        },
        CurvePanel {
            title: "perceived distance".to_owned(),
            axes: ["distance D (m)".to_owned(), "perceived distance".to_owned()],
            ranges: [[0.0, MAX_DISTANCE_M]; 2],
            mark: None,
            curves: ALPHAS
                .iter()
                .map(|a| curve(format!("\u{3b1} = {a}"), MAX_DISTANCE_M, &|d| perceived_distance(d, *a)))
                .collect(),
        },
    ]
}
