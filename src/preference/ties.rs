//! Options that are one choice: ways that have become the same, and ties.

use super::Prospect;
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;

/// The difference in length (m) up to which two options of equal risk are tied: a micrometre is not a reason.
/// Lengths of mirrored ways differ by rounding.
const TIE_LENGTH_M: f64 = 1e-6;

/// The difference in risk up to which two options of equal length are tied, relative to the risk and to its
/// distance from 1: perceived risk is infinitely steep at 0 and 1.
const TIE_RISK: f64 = 1e-8;

/// The options whose remaining ways have become the same: they are one choice, and one of them stands for all.
///
/// ```
/// use cocarry::preference::Ways;
///
/// // options 0 and 2 lead the same way from here, and the team walks option 2
/// let mut ways = Ways::default();
/// ways.find(3, Some(2), |a, b| (a, b) == (0, 2));
/// assert_eq!([0, 1, 2].map(|option| ways.representative(option)), [2, 1, 2]);
/// ```
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Ways {
    /// By option, its representative. Further options represent themselves.
    representatives: Vec<usize>,
}

impl Clone for Ways {
    fn clone(&self) -> Self {
        Self { representatives: self.representatives.clone() }
    }

    // a derived one would allocate
    fn clone_from(&mut self, source: &Self) {
        self.representatives.clone_from(&source.representatives);
    }
}

impl Ways {
    /// Finds the ways of so many `options`. `is_same(a, b)`, asked with `a < b`, says whether both lead the
    /// same way. An option represents its way if it is `current`, the option being executed, or if no other
    /// one does and it is the first.
    pub fn find(&mut self, options: usize, current: Option<usize>, is_same: impl Fn(usize, usize) -> bool) {
        self.representatives.clear();
        for option in 0..options {
            let first = (0..option)
                .find(|&earlier| self.representatives[earlier] == earlier && is_same(earlier, option));
            self.representatives.push(first.unwrap_or(option));
        }
        let Some(current) = current.filter(|&current| current < options) else { return };
        let first = self.representatives[current];
        self.representatives.iter_mut().filter(|of| **of == first).for_each(|of| *of = current);
    }

    /// The option that stands for the way of this one.
    pub fn representative(&self, option: usize) -> usize {
        self.representatives.get(option).copied().unwrap_or(option)
    }

    /// Whether these can be the ways of so many options. Those read from a file may not.
    pub(crate) fn fits(&self, options: usize) -> bool {
        self.representatives.len() <= options && self.representatives.iter().all(|of| *of < options)
    }
}

/// The choices among options: each is one way or several that are tied, which share its probability equally.
#[derive(Clone, Debug, Default)]
pub(super) struct Ties {
    /// The options, with lengths and risks in their domains.
    prospects: Vec<Prospect>,
    /// Their indices, shortest first, then by risk and index.
    order: Vec<usize>,
    /// By option: the option whose length and risk stand for it.
    leaders: Vec<usize>,
    /// By leader: the number of ways that are tied with it, itself included.
    ways: Vec<usize>,
    /// By option: whether it represents its way.
    represents: Vec<bool>,
}

impl Ties {
    /// Finds the ties among options.
    pub fn find(&mut self, prospects: &[Prospect], ways: &Ways, risk_matters: bool) {
        let Self { prospects: all, order, leaders, ways: tied, represents } = self;
        all.clear();
        all.extend(prospects.iter().map(|prospect| prospect.clamped()));
        order.clear();
        order.extend(0..all.len());
        order.sort_unstable_by(|&a, &b| {
            let (first, second) = (all[a], all[b]);
            let by_risk = if risk_matters { first.risk.total_cmp(&second.risk) } else { Ordering::Equal };
            first.length.total_cmp(&second.length).then(by_risk).then(a.cmp(&b))
        });
        represents.clear();
        represents.extend((0..all.len()).map(|option| {
            let representative = ways.representative(option);
            representative == option || all.get(representative) != Some(&all[option])
        }));
        leaders.clear();
        leaders.extend(0..all.len());
        tied.clear();
        tied.resize(all.len(), 0);
        for (place, &option) in order.iter().enumerate() {
            let mine = all[option];
            let is_tied = |other: Prospect| {
                !risk_matters || mine.length == f64::INFINITY || is_same_risk(other.risk, mine.risk)
            };
            let near = order[..place].iter().rev().take_while(|&&o| is_near(all[o].length, mine.length));
            if let Some(&leader) = near.filter(|&&o| leaders[o] == o && is_tied(all[o])).last() {
                leaders[option] = leader;
            }
            tied[leaders[option]] += usize::from(represents[option]);
        }
    }

    /// The options that stand for all others, shortest first, then by risk.
    pub fn leaders(&self) -> impl Iterator<Item = (usize, Prospect)> + '_ {
        let leaders = self.order.iter().copied().filter(|&option| self.leaders[option] == option);
        leaders.map(|option| (option, self.prospects[option]))
    }

    /// The number of ways that are tied with a leader, itself included.
    pub fn ways(&self, leader: usize) -> f64 {
        self.ways[leader] as f64
    }

    /// The option that stands for this one.
    pub fn leader(&self, option: usize) -> usize {
        self.leaders[option]
    }

    /// Shares the probabilities of the leaders among the ways that are tied with them.
    pub fn share(&self, masses: &mut [f64]) {
        for &option in self.order.iter().rev() {
            // an option comes after its leader in this order, so the leader still has the whole
            let leader = self.leaders[option];
            let whole = masses[leader];
            masses[option] = match self.represents[option] {
                true => whole / self.ways[leader] as f64,
                false => 0.0,
            };
        }
    }

    /// The mean of what the ways tied with each option have, into `means`: the likelihoods of what was seen if
    /// the human prefers one of them.
    pub fn means(&self, values: &[f64], means: &mut Vec<f64>) {
        means.clear();
        means.resize(values.len(), 0.0);
        for (option, value) in values.iter().enumerate().filter(|(option, _)| self.represents[*option]) {
            let leader = self.leaders[option];
            means[leader] += value / self.ways[leader] as f64;
        }
        for option in 0..values.len() {
            means[option] = means[self.leaders[option]];
        }
    }
}

fn is_near(shorter: f64, longer: f64) -> bool {
    shorter == longer || longer - shorter <= TIE_LENGTH_M
}

fn is_same_risk(a: f64, b: f64) -> bool {
    let least = [a, b, 1.0 - a, 1.0 - b].into_iter().fold(f64::INFINITY, f64::min);
    (a - b).abs() <= TIE_RISK * least
}
