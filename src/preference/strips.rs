//! The integral over `gamma`: strips in which the same options win in the same order, each integrated by one
//! Gauss rule.
//!
//! Within a strip, every end of a winner's interval of `alpha` is an analytic function of `gamma`, so a rule
//! of ten nodes converges fast. At a strip's end an option joins or leaves the envelope. Three checks make
//! sure that no such event is missed: the envelope at both ends of a strip, the check at every node that the
//! assumed winners are the winners, and the certificates (the margin by which a loser loses, the length a
//! winner wins) interpolated between the nodes.

use super::Marginal;
use super::curve::{Curve, Pair, turning_point};
use super::envelope::Envelope;
use super::margin::{Margin, Rival};
use super::rule::{NODES, Rule, Samples};

/// Largest estimated error of one end of an interval, as a probability, in an accepted strip.
const TOLERANCE: f64 = 1e-11;

/// The fraction of the range of `gamma` below which strips are not split further: their total contribution is
/// smaller than this.
const MIN_STRIP: f64 = 1e-12;

/// The fraction of the range of `gamma` to which events are located. The effect of a misplaced event grows
/// with the square of the distance, since an option joins or leaves the envelope with an interval of length
/// 0.
const EVENT_TOLERANCE: f64 = 1e-8;

/// The number of nodes after which a call stops refining and uses what it has. It is far beyond any real set
/// of options and ends every loop.
const MAX_NODES: u64 = 2_000_000;

/// Independent `alpha` and `gamma` with their panels.
#[derive(Debug, Clone)]
pub(super) struct Domain {
    pub alpha: Marginal,
    pub alpha_panels: Vec<f64>,
    pub gamma: Marginal,
    pub gamma_panels: Vec<f64>,
}

/// An end of a strip: the envelope there, as a piece of the list of winners.
#[derive(Debug, Clone, Copy)]
struct Edge {
    gamma: f64,
    start: usize,
    count: usize,
}

/// A curve that does not win in a strip, and the index of the envelope's breakpoint at which it comes
/// nearest.
#[derive(Debug, Clone, Copy)]
struct Loser {
    rival: Rival,
    breakpoint: usize,
}

/// The border between two options in a strip, at the nodes of its rule.
#[derive(Debug, Clone, Copy)]
pub(super) struct Border {
    /// The ends of the strip in `gamma`.
    pub gamma: [f64; 2],
    /// The options below and above the border in `alpha`.
    pub options: [usize; 2],
    /// `alpha` of the border.
    pub alphas: Samples,
    /// Probability up to `alpha` times the density of `gamma`.
    pub marks: Samples,
}

/// A strip with the options that win at the least and at the largest `alpha` of one range of `alpha`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extent {
    /// The ends of the strip in `gamma`.
    pub gamma: [f64; 2],
    /// The index of the range of `alpha`.
    pub range: usize,
    /// The first and the last winner.
    pub options: [usize; 2],
}

/// The regions R_o as borders between winners.
#[derive(Debug, Clone, Default)]
pub(super) struct Outline {
    /// The borders.
    pub borders: Vec<Border>,
    /// The strips.
    pub extents: Vec<Extent>,
    /// Number of ranges of `alpha`.
    pub ranges: usize,
}

/// The result of a strip: accepted, or where to cut it.
enum Verdict {
    Done,
    CutAt(f64),
}

/// The integrator over `(alpha, gamma)`; all buffers are kept between calls.
#[derive(Debug, Clone)]
pub(super) struct Strips {
    rule: Rule,
    envelope: Envelope,
    alpha_cuts: Vec<f64>,
    winners: Vec<usize>,
    todo: Vec<(Edge, Edge)>,
    /// Neighbours among the winners of the present strip, and of the one before.
    pairs: Vec<Pair>,
    earlier_pairs: Vec<Pair>,
    losers: Vec<Loser>,
    /// Ends of the winners' intervals at one node: `pairs.len() + 2` values.
    breakpoints: Vec<f64>,
    /// Probability up to each inner breakpoint times the density of `gamma`, at the nodes.
    marks: Vec<Samples>,
    /// The inner breakpoints themselves, at the nodes.
    alphas: Vec<Samples>,
    /// The regions of the last call, if they are wanted.
    pub outline: Option<Outline>,
    /// Lengths of the winners' intervals, then margins of the losers, at the nodes.
    certificates: Vec<Samples>,
    /// Nodes evaluated since the count was last reset.
    pub nodes: u64,
}

impl Strips {
    pub fn new() -> Self {
        Self {
            rule: Rule::new(),
            envelope: Envelope::default(),
            alpha_cuts: Vec::new(),
            winners: Vec::new(),
            todo: Vec::new(),
            pairs: Vec::new(),
            earlier_pairs: Vec::new(),
            losers: Vec::new(),
            breakpoints: Vec::new(),
            marks: Vec::new(),
            alphas: Vec::new(),
            outline: None,
            certificates: Vec::new(),
            nodes: 0,
        }
    }

    /// Adds to `masses` the probability that each option of the front is the cheapest.
    pub fn integrate(&mut self, front: &[Curve], risk_weight: f64, domain: &Domain, masses: &mut [f64]) {
        self.cut_alpha(front, &domain.alpha_panels);
        self.envelope.risk_weight = risk_weight;
        if let Some(outline) = &mut self.outline {
            outline.borders.clear();
            outline.extents.clear();
            outline.ranges = 0;
        }
        for cut in 1..self.alpha_cuts.len() {
            let (lower, upper) = (self.alpha_cuts[cut - 1], self.alpha_cuts[cut]);
            self.envelope.reset(front, lower, upper);
            self.winners.clear();
            self.pairs.clear();
            let mut right = self.edge(domain.gamma.upper());
            for &cut in domain.gamma_panels.iter().rev().skip(1) {
                let left = self.edge(cut);
                self.todo.push((left, right));
                right = left;
            }
            while let Some((left, right)) = self.todo.pop() {
                self.strip(left, right, domain, masses);
            }
            if let Some(outline) = &mut self.outline {
                outline.ranges += 1;
            }
        }
    }

    /// Ranges of `alpha` in which any two curves cross at most once.
    fn cut_alpha(&mut self, front: &[Curve], panels: &[f64]) {
        self.alpha_cuts.clear();
        self.alpha_cuts.extend_from_slice(panels);
        let (lower, upper) = (panels[0], panels[panels.len() - 1]);
        // Only the options with less than 1 m left can turn, and they come first in the front.
        let near = front.iter().take_while(|curve| curve.length < 1.0).count();
        for longer in 1..near {
            for shorter in 0..longer {
                let turn = turning_point(&front[shorter], &front[longer]);
                self.alpha_cuts.extend(turn.filter(|turn| *turn > lower && *turn < upper));
            }
        }
        self.alpha_cuts.sort_unstable_by(f64::total_cmp);
        self.alpha_cuts.dedup();
    }

    /// The envelope at `gamma`, from scratch.
    fn edge(&mut self, gamma: f64) -> Edge {
        self.nodes += 1;
        self.envelope.winners(gamma);
        let start = self.winners.len();
        self.winners.extend(self.envelope.stack.iter().map(|winner| winner.rank));
        Edge { gamma, start, count: self.winners.len() - start }
    }

    fn sequence(&self, edge: Edge) -> &[usize] {
        &self.winners[edge.start..edge.start + edge.count]
    }

    /// Integrates between two edges, or cuts the strip and adds the parts to the list.
    fn strip(&mut self, left: Edge, right: Edge, domain: &Domain, masses: &mut [f64]) {
        let range = domain.gamma.upper() - domain.gamma.lower();
        let width = right.gamma - left.gamma;
        if width <= MIN_STRIP * range || self.nodes > MAX_NODES {
            self.sliver(left, right, domain, masses);
            return;
        }
        if self.sequence(left) != self.sequence(right) {
            match self.event(left, right, range) {
                Some((gamma, rank)) => self.cut_at_event(left, right, gamma, rank),
                None => self.cut(left, right, 0.5 * (left.gamma + right.gamma)),
            }
            return;
        }
        if let Verdict::CutAt(cut) = self.smooth_strip(left, right, domain, masses) {
            self.cut(left, right, cut);
        }
    }

    fn cut(&mut self, left: Edge, right: Edge, gamma: f64) {
        let middle = self.edge(gamma);
        self.todo.push((middle, right));
        self.todo.push((left, middle));
    }

    /// Cuts where an option of this rank joins or leaves, provided that nothing else happened to the envelope
    /// in between.
    fn cut_at_event(&mut self, left: Edge, right: Edge, gamma: f64, rank: usize) {
        let middle = self.edge(gamma);
        let others = |edge: Edge| self.sequence(edge).iter().filter(move |&&other| other != rank);
        let (at_left, at_right) = if others(middle).eq(others(left)) {
            // At the event, rounding decides whether the option is in; each side keeps the winners of its
            // other end.
            (Edge { gamma, ..left }, Edge { gamma, ..right })
        } else {
            (middle, middle)
        };
        self.todo.push((at_right, right));
        self.todo.push((left, at_left));
    }

    /// Adds a strip too short to matter, or one given up on: the envelope at its middle represents the whole
    /// strip.
    fn sliver(&mut self, left: Edge, right: Edge, domain: &Domain, masses: &mut [f64]) {
        let mass = domain.gamma.cdf(right.gamma) - domain.gamma.cdf(left.gamma);
        self.nodes += 1;
        self.envelope.winners(0.5 * (left.gamma + right.gamma));
        let mut end = domain.alpha.cdf(self.envelope.upper);
        for winner in self.envelope.stack.iter().rev() {
            let start = domain.alpha.cdf(winner.start);
            masses[self.envelope.curves[winner.rank].option] += mass * (end - start);
            end = start;
        }
    }

    /// The `gamma` between two edges at which a single option joins or leaves the envelope, and its rank.
    ///
    /// `None` if the edges differ by more than one option or if the search finds no change of sign.
    fn event(&mut self, left: Edge, right: Edge, range: f64) -> Option<(f64, usize)> {
        let (more, fewer) = if left.count > right.count { (left, right) } else { (right, left) };
        if more.count != fewer.count + 1 {
            return None;
        }
        let (long, short) = (self.sequence(more), self.sequence(fewer));
        let place = (0..fewer.count).find(|&k| long[k] != short[k]).unwrap_or(fewer.count);
        if long[place + 1..] != short[place..] {
            return None;
        }
        let (before, after) = (place.checked_sub(1).map(|k| long[k]), long.get(place + 1).copied());
        let rank = long[place];
        let mut margin = Margin::new(&self.envelope, rank, before, after);
        let found = margin.root(&mut self.envelope, left.gamma, right.gamma, EVENT_TOLERANCE * range);
        found.map(|gamma| (gamma, rank))
    }

    /// Integrates a strip whose ends have the same winners. The verdict says where to cut it if the winners
    /// change within it or if the rule is not accurate enough.
    fn smooth_strip(&mut self, left: Edge, right: Edge, domain: &Domain, masses: &mut [f64]) -> Verdict {
        let half = 0.5 * (right.gamma - left.gamma);
        let middle = left.gamma + half;
        // In a strip this short a misplaced event may affect a node, but cannot matter.
        let short = 2.0 * half < 50.0 * EVENT_TOLERANCE * (domain.gamma.upper() - domain.gamma.lower());
        self.prepare(left);
        for node in 0..NODES {
            let gamma = middle + half * self.rule.nodes[node];
            if !self.node(node, gamma, domain) && !short {
                return Verdict::CutAt(gamma);
            }
        }
        if !short && let Some(cut) = self.suspected_change(left, right, middle, half) {
            return Verdict::CutAt(cut);
        }
        if !short && self.marks.iter().any(|mark| half * self.rule.error(mark) > TOLERANCE) {
            return Verdict::CutAt(middle);
        }
        self.record(left, right);
        let weight = |node: usize| half * self.rule.weights[node];
        let total = domain.gamma.cdf(right.gamma) - domain.gamma.cdf(left.gamma);
        let mut end = total * domain.alpha.cdf(self.envelope.upper);
        for place in (0..left.count).rev() {
            let start = match place.checked_sub(1) {
                Some(inner) => (0..NODES).map(|node| weight(node) * self.marks[inner][node]).sum(),
                None => total * domain.alpha.cdf(self.envelope.lower),
            };
            let option = self.envelope.curves[self.winners[left.start + place]].option;
            masses[option] += end - start;
            end = start;
        }
        Verdict::Done
    }

    /// Adds an accepted strip to the outline, if it is wanted.
    fn record(&mut self, left: Edge, right: Edge) {
        let Some(outline) = &mut self.outline else { return };
        let ranks = &self.winners[left.start..left.start + left.count];
        let option = |rank: usize| self.envelope.curves[rank].option;
        let gamma = [left.gamma, right.gamma];
        for (place, ranks) in ranks.windows(2).enumerate() {
            let options = [option(ranks[0]), option(ranks[1])];
            let (alphas, marks) = (self.alphas[place], self.marks[place]);
            outline.borders.push(Border { gamma, options, alphas, marks });
        }
        if let (Some(first), Some(last)) = (ranks.first(), ranks.last()) {
            let options = [option(*first), option(*last)];
            outline.extents.push(Extent { gamma, range: outline.ranges, options });
        }
    }

    /// Sets up the neighbours among the winners of a strip and the winner each loser is compared with.
    fn prepare(&mut self, edge: Edge) {
        let ranks = &self.winners[edge.start..edge.start + edge.count];
        std::mem::swap(&mut self.pairs, &mut self.earlier_pairs);
        self.pairs.clear();
        let mut earlier = self.earlier_pairs.iter().peekable();
        for neighbours in ranks.windows(2) {
            let mut pair = self.envelope.pair(neighbours[0], neighbours[1]);
            // Both lists are sorted by rank.
            while earlier.next_if(|old| old.left < pair.left).is_some() {}
            if let Some(old) = earlier.next_if(|old| old.left == pair.left && old.right == pair.right) {
                pair.warm(old);
            }
            self.pairs.push(pair);
        }
        self.losers.clear();
        let mut breakpoint = 0;
        for rank in 0..self.envelope.curves.len() {
            if ranks.get(breakpoint) == Some(&rank) {
                breakpoint += 1;
                continue;
            }
            let before = breakpoint.checked_sub(1).map(|k| ranks[k]);
            let rival = Rival::new(&self.envelope, rank, before, ranks.get(breakpoint).copied());
            self.losers.push(Loser { rival, breakpoint });
        }
        self.marks.clear();
        self.marks.resize(self.pairs.len(), [0.0; NODES]);
        self.alphas.resize(self.pairs.len(), [0.0; NODES]);
        self.certificates.clear();
        self.certificates.resize(edge.count + self.losers.len(), [0.0; NODES]);
        self.breakpoints.resize(edge.count + 1, 0.0);
    }

    /// Evaluates one node of a prepared strip; false if the assumed winners are not the winners there.
    fn node(&mut self, node: usize, gamma: f64, domain: &Domain) -> bool {
        self.nodes += 1;
        let envelope = &mut self.envelope;
        envelope.set_gamma(gamma);
        let density = domain.gamma.density(gamma);
        let winners = self.pairs.len() + 1;
        self.breakpoints[0] = envelope.lower;
        self.breakpoints[winners] = envelope.upper;
        for (place, pair) in self.pairs.iter_mut().enumerate() {
            let alpha = envelope.crossing(pair);
            self.breakpoints[place + 1] = alpha;
            self.marks[place][node] = density * domain.alpha.cdf(alpha);
            self.alphas[place][node] = alpha;
        }
        let mut holds = true;
        for place in 0..winners {
            let length = self.breakpoints[place + 1] - self.breakpoints[place];
            self.certificates[place][node] = length;
            holds &= length > 0.0;
        }
        for (place, loser) in self.losers.iter().enumerate() {
            let margin = loser.rival.margin(envelope, self.breakpoints[loser.breakpoint]);
            self.certificates[winners + place][node] = margin;
            holds &= margin >= 0.0;
        }
        holds
    }

    /// A `gamma` between the nodes at which the winners differ, searched for where a certificate comes close
    /// enough to 0.
    fn suspected_change(&mut self, left: Edge, right: Edge, middle: f64, half: f64) -> Option<f64> {
        for certificate in &self.certificates {
            for gamma in self.rule.dips(certificate).map(|x| middle + half * x) {
                if gamma > left.gamma && gamma < right.gamma {
                    self.nodes += 1;
                    self.envelope.winners(gamma);
                    let found = self.envelope.stack.iter().map(|winner| &winner.rank);
                    if !found.eq(&self.winners[left.start..left.start + left.count]) {
                        return Some(gamma);
                    }
                }
            }
        }
        None
    }
}
