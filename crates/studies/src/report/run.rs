//! The report's opening and closing sections: settings, environment and contents.

use crate::paper::COLUMNS;
use crate::paper::part::{Part, Plan, Section, grouped};
use cocarry::control::{self, HORIZON};
use cocarry::simulation::PhysicsSettings;

/// Choices that the paper leaves open, departures from the paper, and errors in it.
const DEVIATIONS: &str = include_str!("../../../../book/src/deviations.md");

/// Title and findings.
pub(super) fn opening(plan: &Plan, run: &[&Part], sections: &[Section]) -> String {
    let mut text = format!(
        "# Human-robot co-transportation, reproduced\n\n\
         Every table and figure of A. J. Mahmud, W. Li and X. Wang, *Mutual Adaptation in Human-Robot Co-Transportation with Human Preference Uncertainty*, with those \
         of `cocarry` {} next to them. All figures of ours, those in the text included, come from one run of {}.\n\n\
         ## What holds\n\n| claim | finding | in figures |\n| :-- | :-- | :-- |\n",
        env!("CARGO_PKG_VERSION"),
        all(plan, run),
    );
    for section in sections {
        let finding = &section.finding;
        text += &format!("| {} | **{}** | {} |\n", finding.claim, finding.verdict, finding.figures);
    }
    text + "\nA picture is `figures/NAME.svg` next to this report; the figures of a table are in the CSV file named at it.\n\n"
}

/// Deviations, episodes and settings.
pub(super) fn end(plan: &Plan, run: &[&Part]) -> String {
    // the document's title becomes a section's
    let deviations = DEVIATIONS.trim().replacen("# ", "## ", 1);
    format!("{deviations}\n\n## This run\n\n{}{}", parts(plan, run), settings(plan))
}

/// The episodes and studies that a report runs, in words.
fn all(plan: &Plan, run: &[&Part]) -> String {
    let [episodes, studies] = totals(plan, run);
    match studies {
        0 => format!("{} episodes", grouped(episodes)),
        _ => format!("{} episodes and {} simulated studies", grouped(episodes), grouped(studies)),
    }
}

/// Numbers of episodes and of simulated studies.
fn totals(plan: &Plan, run: &[&Part]) -> [usize; 2] {
    let sum = |of: fn(&Part, &Plan) -> usize| run.iter().map(|part| of(part, plan)).sum();
    [sum(|part, plan| (part.episodes)(plan)), sum(|part, plan| (part.studies)(plan))]
}

/// The number of episodes and of simulated studies of each part.
fn parts(plan: &Plan, run: &[&Part]) -> String {
    let mut text = "| part | episodes | simulated studies |\n| :-- | --: | --: |\n".to_owned();
    let mut line = |name: &str, [episodes, studies]: [usize; 2]| {
        text += &format!("| {name} | {} | {} |\n", grouped(episodes), grouped(studies));
    };
    for part in run {
        line(part.name, totals(plan, &[part]));
    }
    line("all", totals(plan, run));
    text + "\n"
}

fn settings(plan: &Plan) -> String {
    let episode = &plan.settings;
    let control = control::ControlSettings::default();
    let physics = PhysicsSettings::default();
    let [alpha, gamma] = episode.predictor.belief().ranges();
    let eta: Vec<String> = COLUMNS.iter().flatten().map(f64::to_string).collect();
    format!(
        "`cocarry` {}, seed {}, robot {} (starts: {}). c\u{1d63} = {} m; \u{3b1} from {} to {}, \u{3b3} from {} to {}; \u{3c6}(0) = {}, \u{3b7} = {}; one step is {} s, walking speed {} m/s, \
         turning at most {} rad/s. Eq. (7): H = {HORIZON}, Q = {} I, R = {} I; eq. (8): \u{3ba} = {}. Bodies: {} Hz, {} solver iterations, sway {} m.\n",
        env!("CARGO_PKG_VERSION"),
        plan.seed,
        plan.robot.name,
        plan.robot.postures.iter().map(|p| p.name.as_str()).collect::<Vec<_>>().join(", "),
        episode.predictor.risk_weight(),
        alpha[0],
        alpha[1],
        gamma[0],
        gamma[1],
        episode.coordination.initial_stubbornness,
        eta.join(", "),
        episode.planning_step,
        episode.speed,
        episode.yaw_rate,
        control.state_weight,
        control.input_weight,
        control.pose_weight,
        physics.rate_hz,
        physics.solver_iterations,
        physics.human.sway_lateral,
    )
}
