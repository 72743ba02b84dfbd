//! H3: Table III, every method and start compared with its baseline, and the composition of the costs.

use crate::paper::h3::{self, PoseMethod, PoseRow, PoseStudy};
use crate::paper::pairs::{SIGNIFICANCE_LEVEL, compared, explained, is_significant, rounded};
use crate::paper::part::{Block, Figure, Finding, Part, Plan, Section, grouped, holds, none};
use crate::paper::{ENVIRONMENTS, SETTINGS};
use crate::parallel::OnDone;
use crate::table::{Cell, Columns, Table};
use cocarry::Error;
use cocarry::scenario::{Plant, PlantKind, RobotSetup};
use cocarry_output::drawing::{RatioPanel, RatioRow, cost_ratios};

/// Table III.
pub(crate) const PART: Part = Part {
    id: "h3",
    name: "Table III",
    episodes: |plan| h3::units(&PoseMethod::ALL, plan.robot.postures.len(), plan.episodes),
    studies: none,
    run: table_3_section,
};

/// Rows of Table III to compare: all methods that were run, from one start.
#[derive(Clone, Copy, Debug)]
pub struct Compared<'a> {
    /// Rows of all starts.
    pub rows: &'a [PoseRow],
    /// The start.
    pub start: &'a str,
    /// The methods that were run.
    pub methods: &'a [PoseMethod],
}

/// The methods that are compared with their baseline: name in tables and pictures, and name in columns of
/// files.
const METHODS: [(PoseMethod, &str, &str); 6] = [
    (PoseMethod::WithPo, "with PO", "with_po"),
    (PoseMethod::WithPoWholeBody, "whole-body", "whole_body"),
    (PoseMethod::Manipulability, "manipulability", "manipulability"),
    (PoseMethod::UniformWeights, "uniform weights", "uniform_weights"),
    (PoseMethod::TrackedOption, "tracked option", "tracked_option"),
    (PoseMethod::WithPoObstacles, "with PO, obstacles", "with_po_obstacles"),
];

impl<'a> Compared<'a> {
    fn of(self, method: PoseMethod) -> impl Iterator<Item = &'a PoseRow> {
        self.rows.iter().filter(move |r| r.start == self.start && r.method == method)
    }

    /// A method's ratio to its baseline, averaged over the cells.
    pub fn mean_ratio(self, method: PoseMethod) -> f64 {
        let ratios: Vec<f64> = self.of(method).map(|r| r.ratio).collect();
        ratios.iter().sum::<f64>() / ratios.len() as f64
    }

    /// Number of tested comparisons from this start.
    fn tested(self) -> usize {
        let own = self.rows.iter().filter(|r| r.start == self.start);
        own.filter(|r| r.against_baseline.is_some_and(|paired| paired.p_value.is_some())).count()
    }

    /// Every cell without and with pose optimisation.
    fn pairs(self) -> Vec<[&'a PoseRow; 2]> {
        let with = self.of(PoseMethod::WithPo);
        self.of(PoseMethod::WithoutPo).zip(with).map(|(without, with)| [without, with]).collect()
    }
}

/// The paper's mean ratio of the costs with and without pose optimisation.
fn paper_ratio() -> f64 {
    let ratios = ENVIRONMENTS.iter().flat_map(|e| e.control_cost_with.iter().zip(e.control_cost_without));
    let ratios: Vec<f64> = ratios.map(|(with, without)| with / without).collect();
    ratios.iter().sum::<f64>() / ratios.len() as f64
}

fn saving(with: f64, without: f64) -> String {
    format!("{:.1} %", 100.0 * (1.0 - with / without))
}

/// The paper's table next to the project's.
pub fn table_3(shown: Compared) -> Table {
    let paper = |row: &PoseRow| row.paper_mean.unwrap_or(f64::NAN);
    let pairs = shown.pairs();
    let columns = Columns::of(&pairs)
        .numbered("environment", "environment", |[_, with]| with.environment)
        .text("setting", "setting", |[_, with]| with.setting)
        .number("paper: without PO", "paper_without_po", 1, |[without, _]| paper(without))
        .number("with PO", "paper_with_po", 1, |[_, with]| paper(with))
        .derived("saving", |[without, with]| saving(paper(with), paper(without)))
        .spread("ours: without PO", ["without_po_mean", "without_po_std"], 1, |[without, _]| {
            [without.ours_mean, without.ours_std]
        })
        .spread("with PO", ["with_po_mean", "with_po_std"], 1, |[_, with]| [with.ours_mean, with.ours_std])
        .derived("saving", |[without, with]| saving(with.ours_mean, without.ours_mean))
        .data("ratio", |[_, with]| with.ratio);
    let table = compared(columns, "difference", ["with_po", ""], |[_, with]| with.against_baseline)
        .count("ways", "ways", |[_, with]| with.ways as u64)
        .column("cheaper in", false, &["wins", "episodes"], |[_, with]| Cell {
            shown: format!("{} of {}", with.wins, with.episodes),
            values: vec![with.wins.into(), with.episodes.into()],
        })
        .table(
            &format!("table-3-{}", shown.start),
            format!(
                "Table III: control cost C with and without pose optimisation (PO); episodes start `{}`",
                shown.start
            ),
        )
        .with_note(format!(
            "mean ratio with / without: paper {:.3}, ours {:.3}. C depends on robot, worlds and speed, which the paper does not give: compare the savings.",
            paper_ratio(),
            shown.mean_ratio(PoseMethod::WithPo),
        ))
        .with_note("Ways: different sequences of options that the humans walk.");
    explained(table, shown.tested(), FAMILY)
}

/// The family of Holm's correction.
const FAMILY: &str = "of all methods from this start";

/// Every method's cost relative to its baseline's.
pub fn table_3_ratios(compared: Compared) -> Table {
    // one row per cell, and a last one for their mean
    let cells = ENVIRONMENTS.iter().flat_map(|e| SETTINGS.iter().map(|s| Some((e.number, s.name))));
    let lines: Vec<_> = cells.chain([None]).collect();
    let mut columns = Columns::of(&lines)
        .text("environment", "environment", |cell| cell.map_or("mean".to_owned(), |(e, _)| e.to_string()))
        .text("setting", "setting", |cell| cell.map_or("", |(_, setting)| setting));
    for (method, heading, key) in METHODS {
        if !compared.methods.contains(&method) {
            continue;
        }
        let p_key = format!("{key}_p_holm");
        columns = columns.column(heading, false, &[key, &p_key], |cell| {
            let Some((environment, setting)) = *cell else {
                let mean = compared.mean_ratio(method);
                return Cell { shown: format!("{mean:.3}"), values: vec![mean.into(), None::<f64>.into()] };
            };
            let row = compared.of(method).find(|r| r.environment == environment && r.setting == setting);
            let Some(row) = row else {
                return Cell { shown: "-".to_owned(), values: vec![None::<f64>.into(); 2] };
            };
            let holm = row.against_baseline.and_then(|paired| paired.p_holm);
            let doubt = match holm {
                None => "*",
                Some(p) if p >= SIGNIFICANCE_LEVEL => "?",
                Some(_) => "",
            };
            Cell { shown: format!("{:.3}{doubt}", row.ratio), values: vec![row.ratio.into(), holm.into()] }
        });
    }
    let table = columns
        .table(
            &format!("table-3-ratios-{}", compared.start),
            format!("C relative to no pose optimisation; episodes start `{}`", compared.start),
        )
        .with_note(format!(
            "?: p >= {SIGNIFICANCE_LEVEL}, paired t-test, corrected by Holm's method for the {} comparisons {FAMILY} that are tested; *: one outcome, nothing is tested.",
            compared.tested()
        ))
        .with_note("manipulability: the most manipulable candidate. uniform weights: eq. (8) without P_o.")
        .with_note("tracked option: eq. (8) for that option alone.");
    let table = match compared.methods.contains(&PoseMethod::WithPoObstacles) {
        true => table.with_note(
            "whole-body: candidates move base and arm. obstacles: the base is kept off obstacles; compared with no PO under the same limits.",
        ),
        false => table.with_note(
            "With bodies: the robot avoids obstacles, and the base follows the path. Pairs in which either episode did not arrive are left out.",
        ),
    };
    let own = || compared.rows.iter().filter(|r| r.start == compared.start);
    let lost: usize = own().map(|r| r.not_arrived).sum();
    let unsolved: u64 = own().map(|r| r.fallback_steps).sum();
    let table = if lost > 0 { table.with_note(format!("{lost} episodes did not arrive.")) } else { table };
    match unsolved {
        0 => table,
        n => table.with_note(format!("{n} steps had no solution of eq. (7).")),
    }
}

/// The composition of C, with and without pose optimisation.
pub(crate) fn parts_table(compared: Compared, plant: PlantKind) -> Table {
    let pairs = compared.pairs();
    let rows: Vec<&PoseRow> = pairs.iter().flatten().copied().collect();
    let has_bodies = plant == PlantKind::Rapier;
    let columns = figures(Columns::of(&rows), has_bodies);
    let columns = match has_bodies {
        true => columns.number("C intended", "intended_mean", 1, |r| r.intended_cost()),
        false => columns,
    };
    let table = columns
        .table(
            &format!("table-3-parts-{}", compared.start),
            format!("Composition of C (means over the episodes); episodes start `{}`", compared.start),
        )
        .with_note("error: distance of the grasp from its reference, rms over all steps; limited: share of the steps in which a limit was active;");
    match has_bodies {
        true => table
            .with_note("overlaps: episodes in which the base overlaps an obstacle; wheels, arm: the effort of their inputs; C intended: tracking against the walk of a human who does not wait for the robot, the paper's s."),
        false => table.with_note(
            "overlaps: episodes in which the base overlaps an obstacle; as in the paper, eq. (7) has no obstacles here.",
        ),
    }
}

/// Every row of every method and start, for programs.
fn all_rows(rows: &[PoseRow]) -> Table {
    let rows: Vec<&PoseRow> = rows.iter().collect();
    let mut table = figures(Columns::of(&rows), false)
        .data("paper_mean", |r| r.paper_mean)
        .data("ratio", |r| r.ratio)
        .data("pairs", |r| r.against_baseline.map(|p| p.difference.n))
        .data("difference", |r| r.against_baseline.map(|p| p.difference.mean))
        .data("difference_lower", |r| r.against_baseline.and_then(|p| p.difference.interval).map(|i| i[0]))
        .data("difference_upper", |r| r.against_baseline.and_then(|p| p.difference.interval).map(|i| i[1]))
        .data("effect_size", |r| r.against_baseline.and_then(|p| p.effect_size))
        .data("p_value", |r| r.against_baseline.and_then(|p| p.p_value))
        .data("p_holm", |r| r.against_baseline.and_then(|p| p.p_holm))
        .data("ways", |r| r.ways)
        .data("wins", |r| r.wins)
        .data("episodes", |r| r.episodes)
        .data("not_arrived", |r| r.not_arrived)
        .data("unsolved_steps", |r| r.fallback_steps)
        .table("table-3-all", "All methods from all starts, as a file");
    table.columns.iter_mut().for_each(|column| column.heading.clear());
    table
}

/// C of every row and its parts; `is_split`: with the effort of wheels and arm apart.
fn figures<'a>(columns: Columns<'a, &'a PoseRow>, is_split: bool) -> Columns<'a, &'a PoseRow> {
    let columns = columns
        .numbered("environment", "environment", |r| r.environment)
        .text("setting", "setting", |r| r.setting)
        .data("start", |r| r.start.as_str())
        .text("method", "method", |r| r.method.name())
        .spread("C", ["mean", "std"], 1, |r| [r.ours_mean, r.ours_std])
        .number("tracking", "tracking", 1, |r| r.parts[0]);
    let columns = match is_split {
        true => columns.number("wheels", "wheels", 1, |r| r.parts[1]).number("arm", "arm", 1, |r| r.parts[2]),
        false => columns.number("effort", "effort", 1, |r| r.effort),
    };
    columns
        .number("pose", "pose", 2, |r| r.parts[3])
        .column("error (mm)", false, &["position_error_rms_m"], |r| Cell {
            shown: format!("{:.1}", 1e3 * r.position_error_rms),
            values: vec![r.position_error_rms.into()],
        })
        .column("limited", false, &["constrained_share"], |r| Cell {
            shown: format!("{:.1} %", 100.0 * r.constrained_share),
            values: vec![r.constrained_share.into()],
        })
        .count("lost", "lost_object", |r| r.lost_object as u64)
        .count("overlaps", "overlapping_episodes", |r| r.overlapping_episodes as u64)
}

/// All ratios, one panel per start, with the paper's in the first.
///
/// # Errors
/// If a ratio is not a number, as where no episode arrived.
pub fn ratio_picture(rows: &[PoseRow], starts: &[&str]) -> Result<String, Error> {
    let paper = RatioRow {
        label: "paper, with PO".to_owned(),
        ratios: ENVIRONMENTS
            .iter()
            .flat_map(|e| {
                let pairs = e.control_cost_with.iter().zip(e.control_cost_without);
                pairs.map(move |(with, without)| (e.number, with / without))
            })
            .collect(),
    };
    let panels: Vec<RatioPanel> = starts
        .iter()
        .enumerate()
        .map(|(i, start)| {
            let of = |method| rows.iter().filter(move |r| r.start == *start && r.method == method);
            let ours = METHODS.iter().map(|(method, label, _)| RatioRow {
                label: (*label).to_owned(),
                ratios: of(*method).map(|r| (r.environment, r.ratio)).collect(),
            });
            let ours = ours.filter(|row| !row.ratios.is_empty());
            let papers = (i == 0).then(|| paper.clone());
            RatioPanel {
                title: format!("({}) episodes that start {start}", char::from(b'a' + (i % 26) as u8)),
                rows: ours.chain(papers).collect(),
            }
        })
        .collect();
    cost_ratios(&panels)
}

fn table_3_section(plan: &Plan, on_done: OnDone) -> Result<Section, Error> {
    let plant = Plant::new(PlantKind::Kinematic, RobotSetup::new(plan.robot));
    let starts: Vec<&str> = plan.robot.postures.iter().map(|p| p.name.as_str()).collect();
    let (episodes, seed, settings) = (plan.episodes, plan.seed, &plan.settings);
    let methods = &PoseMethod::ALL;
    let study = PoseStudy { plant: &plant, starts: &starts, methods, episodes, seed, settings };
    let rows = study.table(on_done)?;
    let of = |start| Compared { rows: &rows, start, methods };
    let text = "The human leads from the start and changes (\u{3b1}, \u{3b3}) once or twice during the episode; the robot knows only the full ranges. C is the true control \
                cost of Sec. V-C. Every method meets the same humans, so all comparisons are paired.";
    let all: Vec<Compared> = starts.iter().map(|start| of(start)).collect();
    let mut blocks = vec![Block::Text(text.to_owned()), Block::Text(account(&all))];
    blocks.extend(starts.iter().map(|start| Block::Table(table_3(of(start)))));
    blocks.push(Block::Figure(Figure {
        name: "table-3-ratios".to_owned(),
        caption:
            "Control cost relative to the baseline: one mark for each cell of Table III, a bar at the mean."
                .to_owned(),
        is_half: false,
        svg: ratio_picture(&rows, &starts)?,
    }));
    blocks.extend(starts.iter().map(|start| Block::Table(table_3_ratios(of(start)))));
    blocks.extend(starts.iter().map(|start| Block::Table(parts_table(of(start), PlantKind::Kinematic))));
    blocks.push(Block::Table(all_rows(&rows)));
    Ok(Section { title: "H3: preparing the arm".to_owned(), finding: finding(&all), blocks })
}

/// The finding on `compared`, which has every start, the robot's first one first.
pub(crate) fn finding(compared: &[Compared]) -> Finding {
    let pairs: Vec<[&PoseRow; 2]> = compared.iter().take(1).flat_map(|c| c.pairs()).collect();
    let cheaper = |pairs: &[[&PoseRow; 2]]| pairs.iter().filter(|[_, with]| with.ratio < 1.0).count();
    let sum = |of: fn(&PoseRow) -> usize| pairs.iter().map(|[_, with]| of(with)).sum::<usize>();
    let tested: Vec<_> = pairs.iter().filter_map(|[_, with]| with.against_baseline?.p_holm).collect();
    let shown = pairs.iter().filter_map(|[_, with]| with.against_baseline.as_ref());
    let shown = shown.filter(|paired| paired.difference.mean < 0.0 && is_significant(paired)).count();
    let alike: Vec<String> = pairs
        .iter()
        .filter(|[_, with]| with.against_baseline.is_none_or(|paired| paired.p_holm.is_none()))
        .map(|[_, with]| format!("Environment {}, {}", with.environment, with.setting))
        .collect();
    let ratio = |c: &Compared, method| format!("{:.3}", c.mean_ratio(method));
    let mut figures = format!(
        "cheaper in {} of {} cells and {} of {} pairs, significantly (p < {SIGNIFICANCE_LEVEL}, Holm) in {shown} of {} tested, largest p {}{}; mean ratio {} (paper {:.3})",
        cheaper(&pairs),
        pairs.len(),
        grouped(sum(|r| r.wins)),
        grouped(sum(|r| r.episodes)),
        tested.len(),
        rounded(tested.iter().copied().reduce(f64::max)),
        match alike.is_empty() {
            true => String::new(),
            false => format!(" (not tested, as all humans there have one outcome: {})", alike.join("; ")),
        },
        compared.first().map_or(String::new(), |c| ratio(c, PoseMethod::WithPo)),
        paper_ratio(),
    );
    let is_run = |method: &PoseMethod| compared.first().is_some_and(|c| c.methods.contains(method));
    for (method, what) in [
        (PoseMethod::UniformWeights, "weights without P\u{2092}"),
        (PoseMethod::TrackedOption, "the tracked option alone"),
        (PoseMethod::Manipulability, "manipulability"),
    ]
    .into_iter()
    .filter(|(method, _)| is_run(method))
    {
        figures += &compared.first().map_or(String::new(), |c| format!(", with {what} {}", ratio(c, method)));
    }
    for c in compared.iter().skip(1) {
        let pairs = c.pairs();
        figures += &format!(
            "; where both start {}, {}, cheaper in {} of {} cells",
            c.start,
            ratio(c, PoseMethod::WithPo),
            cheaper(&pairs),
            pairs.len()
        );
    }
    Finding {
        claim: "H3: pose optimisation while the human leads lowers the control cost",
        verdict: holds(cheaper(&pairs), pairs.len(), "cells"),
        figures,
    }
}

/// The part of H3 that holds, with reasons and figures of this run; `compared` as for [`finding`].
fn account(compared: &[Compared]) -> String {
    let Some(first) = compared.first() else { return String::new() };
    let ratio = |c: &Compared, method| format!("{:.3}", c.mean_ratio(method));
    let share = |c: &Compared, method| {
        let rows: Vec<&PoseRow> = c.of(method).collect();
        let of = |count: fn(&PoseRow) -> usize| rows.iter().map(|r| count(r)).sum::<usize>();
        format!("{:.0} %", 100.0 * of(|r| r.overlapping_episodes) as f64 / of(|r| r.episodes) as f64)
    };
    let elsewhere = |method| -> String {
        let others = compared.iter().skip(1).map(|c| format!("{} from `{}`", ratio(c, method), c.start));
        others.collect::<Vec<_>>().join(", ")
    };
    let [po, whole_body, manipulability, uniform, tracked] = [
        PoseMethod::WithPo,
        PoseMethod::WithPoWholeBody,
        PoseMethod::Manipulability,
        PoseMethod::UniformWeights,
        PoseMethod::TrackedOption,
    ];
    format!(
        "Numbers are ratios of C to the baseline's C, averaged over the cells. Episodes start `{start}` unless another start is named.\n\n\
         *How much of it is the baseline's.* Pose optimisation: {po_ratio} ({po_elsewhere}). With minimum-norm inputs, an arm that starts in the vertical plane stays in it, where \
         sideways and yaw motion cost most. Pose optimisation swings the elbow out once and keeps it there. The gain that remains where both start with the elbow out is due to preparation.\n\n\
         *What the probabilities are worth.* Weights of eq. (8) by P\u{2092}: {po_ratio}; equal weights: {uniform_ratio}; the tracked option alone: {tracked_ratio}. The first \
         and the last differ by the gain of preparing for several options, the first and the second by the gain of knowing their probabilities.\n\n\
         *Costs against manipulability.* The most manipulable of the same candidates: {manipulability_ratio} ({manipulability_elsewhere}); above 1 is worse than doing nothing.\n\n\
         *Base and arm together.* {whole_body_ratio} ({whole_body_elsewhere}).\n\n\
         *Obstacles.* As in the paper, eq. (7) has no obstacles: the base overlaps one in {with} of the episodes with pose optimisation and in {without} without. With the base kept off \
         obstacles: {kept} and {kept_without}, at a ratio of {obstacle_ratio}.",
        start = first.start,
        po_ratio = ratio(first, po),
        po_elsewhere = elsewhere(po),
        uniform_ratio = ratio(first, uniform),
        tracked_ratio = ratio(first, tracked),
        manipulability_ratio = ratio(first, manipulability),
        manipulability_elsewhere = elsewhere(manipulability),
        whole_body_ratio = ratio(first, whole_body),
        whole_body_elsewhere = elsewhere(whole_body),
        with = share(first, po),
        without = share(first, PoseMethod::WithoutPo),
        kept = share(first, PoseMethod::WithPoObstacles),
        kept_without = share(first, PoseMethod::WithoutPoObstacles),
        obstacle_ratio = ratio(first, PoseMethod::WithPoObstacles),
    )
}
