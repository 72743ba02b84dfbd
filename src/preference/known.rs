//! What the integral over `gamma` needs of the options' risks, kept from call to call.
//!
//! The remaining risk of an option changes at openings only, and most integrals cut no panel of `gamma`. At the
//! ends and nodes of whole panels, Prelec's function and the logarithms of risk gaps are those of the last call.

use super::curve::{Curve, Level, Pair};
use super::rule::{NODES, Rule, Samples};

/// The number of pairs of options whose risk gaps are kept.
const MAX_GAPS: usize = 32;

/// Prelec's function and logarithms of risk gaps on whole panels of `gamma`.
#[derive(Debug, Clone, Default)]
pub(super) struct KnownRisks {
    risk_weight: f64,
    panels: Vec<f64>,
    /// By option.
    options: Vec<KnownRisk>,
    gaps: Vec<KnownGap>,
    /// The place of the gap that is replaced next.
    oldest: usize,
}

/// Prelec's function of one risk.
#[derive(Debug, Clone)]
struct KnownRisk {
    risk: f64,
    /// At the ends of the panels.
    cuts: Vec<Level>,
    /// At the nodes of each panel that was integrated as a whole.
    nodes: Vec<Option<[Level; NODES]>>,
}

/// The logarithm of a pair's risk gap at the nodes of a panel.
#[derive(Debug, Clone)]
struct KnownGap {
    panel: usize,
    /// The longer and the shorter option's risk.
    risks: [f64; 2],
    logs: Samples,
}

impl KnownRisks {
    /// Makes Prelec's function of these curves known at the ends of panels.
    pub fn prepare(&mut self, front: &[Curve], risk_weight: f64, panels: &[f64]) {
        if self.risk_weight != risk_weight || self.panels != panels {
            self.risk_weight = risk_weight;
            self.panels.clear();
            self.panels.extend_from_slice(panels);
            self.options.clear();
            self.gaps.clear();
        }
        for curve in front {
            if self.options.len() <= curve.option {
                let unknown = || KnownRisk { risk: f64::NAN, cuts: Vec::new(), nodes: Vec::new() };
                self.options.resize_with(curve.option + 1, unknown);
            }
            let KnownRisk { risk, cuts, nodes } = &mut self.options[curve.option];
            if *risk == curve.risk {
                continue;
            }
            *risk = curve.risk;
            cuts.clear();
            cuts.extend(panels.iter().map(|&gamma| Level::at(curve, gamma, risk_weight)));
            nodes.clear();
            nodes.resize(panels.len() - 1, None);
        }
    }

    /// The panel between these two values of `gamma`, where Prelec's function of the curves is then known at
    /// the nodes of `rule`; `None` if they are not the ends of one.
    pub fn panel(&mut self, ends: [f64; 2], curves: &[Curve], rule: &Rule) -> Option<usize> {
        let panel = self.panels.windows(2).position(|panel| *panel == ends)?;
        let (half, middle) = halves(ends);
        for curve in curves {
            let at = |x: f64| Level::at(curve, middle + half * x, self.risk_weight);
            self.options[curve.option].nodes[panel].get_or_insert_with(|| rule.nodes.map(at));
        }
        Some(panel)
    }

    /// Prelec's function of an option at an end of a panel.
    pub fn at_cut(&self, option: usize, cut: usize) -> Level {
        self.options[option].cuts[cut]
    }

    /// Prelec's function of an option at a node of a panel that was asked for.
    pub fn at_node(&self, option: usize, panel: usize, node: usize) -> Level {
        self.options[option].nodes[panel].map_or_else(Level::default, |nodes| nodes[node])
    }

    /// The logarithms of a pair's risk gap at the nodes of a panel, if they are known.
    pub fn log_gaps(&self, panel: usize, pair: &Pair, curves: &[Curve]) -> Option<Samples> {
        let risks = risks(pair, curves);
        self.gaps.iter().find(|gap| gap.panel == panel && gap.risks == risks).map(|gap| gap.logs)
    }

    /// Keeps these logarithms.
    pub fn keep_log_gaps(&mut self, panel: usize, pair: &Pair, curves: &[Curve], logs: Samples) {
        let gap = KnownGap { panel, risks: risks(pair, curves), logs };
        if self.gaps.len() < MAX_GAPS {
            self.gaps.push(gap);
        } else {
            self.gaps[self.oldest] = gap;
            self.oldest = (self.oldest + 1) % MAX_GAPS;
        }
    }
}

/// Half the length and the middle of an interval.
pub(super) fn halves([from, to]: [f64; 2]) -> (f64, f64) {
    let half = 0.5 * (to - from);
    (half, from + half)
}

/// The risks of the longer and of the shorter option, on which the risk gap depends.
fn risks(pair: &Pair, curves: &[Curve]) -> [f64; 2] {
    let (long, short) = if pair.rising { (pair.left, pair.right) } else { (pair.right, pair.left) };
    [curves[long].risk, curves[short].risk]
}
