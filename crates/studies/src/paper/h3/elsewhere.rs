//! H3 elsewhere than in the paper: with bodies, on an omnidirectional base, and with the other choices that
//! the paper leaves open.

use super::section::{Compared, finding, parts_table, table_3, table_3_ratios};
use crate::paper::h3::{self, PoseMethod, PoseStudy};
use crate::paper::part::{Block, Finding, Part, Plan, Section, none};
use crate::parallel::OnDone;
use crate::table::{Columns, Table};
use cocarry::Error;
use cocarry::control;
use cocarry::episode::EpisodeSettings;
use cocarry::robot::{Robot, RobotTexts};
use cocarry::scenario::{Plant, PlantKind, RobotSetup};

/// Table III on the physical plant.
pub(crate) const WITH_BODIES: Part = Part {
    id: "h3-bodies",
    name: "Table III with bodies",
    episodes: |plan| {
        h3::units(PoseMethod::on(PlantKind::Rapier), plan.robot.postures.len(), plan.episodes_with_bodies)
    },
    studies: none,
    run: run_with_bodies,
};

/// Table III on the built-in robot's omnidirectional sister.
pub(crate) const OMNIDIRECTIONAL: Part = Part {
    id: "h3-omni",
    name: "Table III, omnidirectional",
    episodes: |plan| h3::units(&WITH_AND_WITHOUT, plan.robot.postures.len(), plan.episodes),
    studies: none,
    run: run_omnidirectional,
};

/// Table III with other values of what the paper leaves open.
pub(crate) const CHOICES: Part = Part {
    id: "h3-choices",
    name: "Table III, open choices",
    episodes: |plan| VARIANTS.len() * h3::units(&WITH_AND_WITHOUT[..2], 1, choice_episodes(plan)),
    studies: none,
    run: run_choices,
};

/// Without pose optimisation, with it, and with weights that ignore P_o.
const WITH_AND_WITHOUT: [PoseMethod; 3] =
    [PoseMethod::WithoutPo, PoseMethod::WithPo, PoseMethod::UniformWeights];

fn run_with_bodies(plan: &Plan, on_done: OnDone) -> Result<Section, Error> {
    let plant = Plant::new(PlantKind::Rapier, RobotSetup::new(plan.robot));
    let text =
        "As H3, with bodies, forces and contacts: the base follows the path, and the robot avoids obstacles.";
    let methods = PoseMethod::on(plant.kind());
    let claim = "H3, where the team has bodies (not in the paper)";
    let names = ("H3 with bodies", claim, "table-3-bodies");
    section(plan, (plan.robot, &plant), (methods, plan.episodes_with_bodies), names, text, on_done)
}

fn run_omnidirectional(plan: &Plan, on_done: OnDone) -> Result<Section, Error> {
    let mut texts = RobotTexts::default();
    texts.file = "omni-carrier.toml".to_owned();
    texts.text = include_str!("../../../../../assets/robots/omni-carrier.toml").to_owned();
    texts.urdf_file = "omni-carrier.urdf".to_owned();
    texts.urdf = include_str!("../../../../../assets/robots/omni-carrier.urdf").to_owned();
    let robot = Robot::parse(&texts)?;
    let plant = Plant::new(PlantKind::Kinematic, RobotSetup::new(&robot));
    let text =
        "As H3, with the same humans, body and arm, on four mecanum wheels: a base that moves to the side.";
    let claim = "H3 on an omnidirectional base (not in the paper)";
    let names = ("H3 on an omnidirectional base", claim, "table-3-omni");
    section(plan, (&robot, &plant), (&WITH_AND_WITHOUT, plan.episodes), names, text, on_done)
}

/// A table of costs for the first start, and one of ratios for every start, with names that begin with
/// `prefix`.
fn section(
    plan: &Plan,
    (robot, plant): (&Robot, &Plant),
    (methods, episodes): (&[PoseMethod], usize),
    (title, claim, prefix): (&str, &'static str, &str),
    text: &str,
    on_done: OnDone,
) -> Result<Section, Error> {
    let starts: Vec<&str> = robot.postures.iter().map(|p| p.name.as_str()).collect();
    let (seed, settings) = (plan.seed, &plan.settings);
    let rows = PoseStudy { plant, starts: &starts, methods, episodes, seed, settings }.table(on_done)?;
    let compared: Vec<Compared> =
        starts.iter().map(|start| Compared { rows: &rows, start, methods }).collect();
    let is_physical = plant.kind() == PlantKind::Rapier;
    let tables = compared.iter().flat_map(|of| {
        let parts = is_physical.then(|| parts_table(*of, plant.kind()));
        [table_3(*of), table_3_ratios(*of)].into_iter().chain(parts)
    });
    let mut blocks = vec![Block::Text(text.to_owned())];
    blocks.extend(tables.map(|mut table| {
        table.name = table.name.replacen("table-3", prefix, 1);
        Block::Table(table)
    }));
    Ok(Section { title: title.to_owned(), finding: Finding { claim, ..finding(&compared) }, blocks })
}

/// A setting with a value other than its default: the choice, its value, and how it is set.
struct Variant {
    choice: &'static str,
    value: &'static str,
    set: fn(&mut EpisodeSettings, &mut control::ControlSettings),
}

/// The default first. The authors' public prototype has a period of 0.1 s.
const VARIANTS: [Variant; 13] = [
    Variant { choice: "none", value: "default", set: |_, _| {} },
    Variant { choice: "yaw rate (rad/s)", value: "0.6", set: |episode, _| episode.yaw_rate = 0.6 },
    Variant { choice: "yaw rate (rad/s)", value: "1.0", set: |episode, _| episode.yaw_rate = 1.0 },
    Variant { choice: "yaw rate (rad/s)", value: "not limited", set: |episode, _| episode.yaw_rate = 1000.0 },
    Variant { choice: "concentration", value: "0", set: |_, control| control.direction_concentration = 0.0 },
    Variant { choice: "concentration", value: "5", set: |_, control| control.direction_concentration = 5.0 },
    Variant {
        choice: "concentration",
        value: "100",
        set: |_, control| control.direction_concentration = 100.0,
    },
    Variant { choice: "walking speed (m/s)", value: "0.3", set: |episode, _| episode.speed = 0.3 },
    Variant { choice: "walking speed (m/s)", value: "0.8", set: |episode, _| episode.speed = 0.8 },
    Variant { choice: "kappa", value: "0", set: |_, control| control.pose_weight = 0.0 },
    Variant { choice: "kappa", value: "10", set: |_, control| control.pose_weight = 10.0 },
    Variant {
        choice: "control period (s)",
        value: "0.1",
        set: |episode, _| episode.control_period = Some(0.1),
    },
    Variant { choice: "planning step (s)", value: "0.1", set: |episode, _| episode.planning_step = 0.1 },
];

/// Humans in each cell: a fifth of those of Table III.
fn choice_episodes(plan: &Plan) -> usize {
    (plan.episodes / 5).max(2)
}

/// The mean ratio of the costs with and without pose optimisation, and that of the worst cell.
struct Choice {
    variant: &'static Variant,
    mean: f64,
    worst: f64,
    /// Mean C over the cells without and with pose optimisation.
    costs: [f64; 2],
    not_arrived: usize,
}

fn run_choices(plan: &Plan, on_done: OnDone) -> Result<Section, Error> {
    let methods = &WITH_AND_WITHOUT[..2];
    let (episodes, seed) = (choice_episodes(plan), plan.seed);
    let start = plan.robot.postures[0].name.as_str();
    let mut choices = Vec::new();
    for variant in &VARIANTS {
        let (mut settings, mut setup) = (plan.settings.clone(), RobotSetup::new(plan.robot));
        (variant.set)(&mut settings, &mut setup.control);
        let plant = &Plant::new(PlantKind::Kinematic, setup);
        let study = PoseStudy { plant, starts: &[start], methods, episodes, seed, settings: &settings };
        let rows = study.table(on_done)?;
        let compared = Compared { rows: &rows, start, methods };
        let with_po = || rows.iter().filter(|row| row.method == PoseMethod::WithPo);
        let cost = |method| {
            let costs: Vec<f64> = rows.iter().filter(|r| r.method == method).map(|r| r.ours_mean).collect();
            costs.iter().sum::<f64>() / costs.len() as f64
        };
        choices.push(Choice {
            variant,
            mean: compared.mean_ratio(PoseMethod::WithPo),
            worst: with_po().map(|row| row.ratio).fold(0.0, f64::max),
            costs: [PoseMethod::WithoutPo, PoseMethod::WithPo].map(cost),
            not_arrived: rows.iter().map(|row| row.not_arrived).sum(),
        });
    }
    let [least, most] = [f64::min, f64::max].map(|of| choices.iter().map(|c| c.mean).reduce(of));
    let text = format!("Table III with {episodes} humans in each cell, all else as above.");
    Ok(Section {
        title: "H3: the choices that the paper leaves open".to_owned(),
        finding: Finding {
            claim: "H3 depends on choices that the paper leaves open (not in the paper)",
            verdict: "the ratio, not its side of 1".to_owned(),
            figures: format!(
                "mean ratio {:.3} by default, from {:.3} to {:.3} with other choices",
                choices[0].mean,
                least.unwrap_or(f64::NAN),
                most.unwrap_or(f64::NAN)
            ),
        },
        blocks: vec![Block::Text(text), Block::Table(choices_table(&choices))],
    })
}

fn choices_table(choices: &[Choice]) -> Table {
    Columns::of(choices)
        .text("choice", "choice", |c| c.variant.choice)
        .text("value", "value", |c| c.variant.value)
        .number("mean ratio", "mean_ratio", 3, |c| c.mean)
        .number("worst cell", "worst_ratio", 3, |c| c.worst)
        .number("C without PO", "cost_without_po", 0, |c| c.costs[0])
        .number("with PO", "cost_with_po", 0, |c| c.costs[1])
        .count("not arrived", "not_arrived", |c| c.not_arrived as u64)
        .table(
            "table-3-choices",
            "C with over without pose optimisation, by choices that the paper leaves open",
        )
        .with_note("concentration: of the likelihood of the walking direction; 0: P_o alone.")
        .with_note("control period: of eqs. (7) and (8), which then look 0.8 s ahead; the terms of C are means over the periods of a planning step. planning step: C is a sum over twice as many steps.")
}
