//! The margin of a curve above the envelope of the others, and the `gamma` at which the curve joins or leaves
//! it.

use super::curve::Pair;
use super::envelope::Envelope;

/// A curve and the winner that it is compared with.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rival {
    pair: Pair,
    /// Whether the curve, not the winner, is the left one of the pair.
    on_left: bool,
}

impl Rival {
    /// Compares the curve of this rank with that of its neighbours among the winners (there is at least one)
    /// that is nearer in length.
    ///
    /// Where the curve comes nearest to the envelope, both neighbours cost the same; the nearer one keeps
    /// more digits.
    pub fn new(envelope: &Envelope, rank: usize, before: Option<usize>, after: Option<usize>) -> Self {
        let log = |rank: usize| envelope.curves[rank].log_length;
        let distance = |other: usize| (log(other) - log(rank)).abs();
        match (before, after) {
            (Some(before), Some(after)) if distance(after) < distance(before) => {
                Self { pair: envelope.pair(rank, after), on_left: true }
            }
            (Some(before), _) => Self { pair: envelope.pair(before, rank), on_left: false },
            (None, after) => Self { pair: envelope.pair(rank, after.unwrap_or(rank)), on_left: true },
        }
    }

    /// Cost of the curve minus that of the winner at `alpha` and the envelope's present `gamma`.
    pub fn margin(&self, envelope: &Envelope, alpha: f64) -> f64 {
        let difference = envelope.difference(&self.pair, alpha);
        if self.on_left { difference } else { -difference }
    }
}

/// The least margin of a curve above its neighbours on the envelope as a function of `gamma`; negative where
/// the curve wins.
///
/// It is least where the neighbours cross, or at the end of the range of `alpha` if there is only one
/// neighbour.
pub(super) struct Margin {
    rival: Rival,
    neighbours: Option<Pair>,
    end: f64,
    ranks: [usize; 3],
}

impl Margin {
    /// The margin of the curve of this rank above its neighbours, of which there is at least one.
    pub fn new(envelope: &Envelope, rank: usize, before: Option<usize>, after: Option<usize>) -> Self {
        Self {
            rival: Rival::new(envelope, rank, before, after),
            neighbours: before.zip(after).map(|(before, after)| envelope.pair(before, after)),
            end: if before.is_none() { envelope.lower } else { envelope.upper },
            ranks: [rank, before.unwrap_or(rank), after.unwrap_or(rank)],
        }
    }

    fn at(&mut self, envelope: &mut Envelope, gamma: f64) -> f64 {
        envelope.set_gamma_of(&self.ranks, gamma);
        let alpha = match &mut self.neighbours {
            Some(pair) => envelope.crossing(pair),
            None => self.end,
        };
        self.rival.margin(envelope, alpha)
    }

    /// The `gamma` between `from` and `to` at which the margin is 0, to within `tolerance`; `None` if its
    /// sign is the same at both.
    ///
    /// The method is false position. The value of an end that stays twice is reduced so that it moves
    /// (Anderson and Bjorck).
    pub fn root(&mut self, envelope: &mut Envelope, from: f64, to: f64, tolerance: f64) -> Option<f64> {
        let (mut a, mut b) = (from, to);
        let (mut at_a, mut at_b) = (self.at(envelope, a), self.at(envelope, b));
        if at_a.is_nan() || at_b.is_nan() || (at_a < 0.0) == (at_b < 0.0) {
            return None;
        }
        let (mut last, mut moved_a, mut moved_b) = (f64::INFINITY, false, false);
        for step in 0..100 {
            let secant = (a * at_b - b * at_a) / (at_b - at_a);
            let next = if secant > a && secant < b && step < 30 { secant } else { 0.5 * (a + b) };
            if (next - last).abs() <= tolerance || next <= a || next >= b {
                return Some(next);
            }
            last = next;
            let value = self.at(envelope, next);
            if value == 0.0 {
                return Some(next);
            }
            let reduced = |old: f64| if value / old < 1.0 { 1.0 - value / old } else { 0.5 };
            if (value < 0.0) == (at_a < 0.0) {
                at_b *= if moved_a { reduced(at_a) } else { 1.0 };
                (a, at_a, moved_a, moved_b) = (next, value, true, false);
            } else {
                at_a *= if moved_b { reduced(at_b) } else { 1.0 };
                (b, at_b, moved_a, moved_b) = (next, value, false, true);
            }
        }
        None
    }
}
