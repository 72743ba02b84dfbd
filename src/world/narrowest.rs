//! Parallel gaps in one passage as one opening, its narrowest.
//!
//! Grooves, ribs and ragged walls give a passage several gaps of nearly equal width, which the disc over a
//! gap does not tell apart: where the wider of two gaps, of widths v < w, is closer than sqrt(w^2 - v^2) / 2
//! to the narrower, that disc contains the narrower one's sides. Here the same distance plus [`ONE_PASSAGE`]
//! robot widths makes them one: nobody can turn off between them. From there on the wider gap counts the more
//! the farther away it is, so that S does not jump.

use super::opening::Opening;
use crate::geometry::{Bounds, Nearby, cross};

/// The distance in robot widths up to which parallel gaps of equal width are one opening, and from which on
/// both count in full.
const ONE_PASSAGE: [f64; 2] = [1.0, 2.0];
/// The distance (m) that stands for a metre off the axis of the narrower gap: gaps that lie side by side are
/// two.
const ACROSS_FACTOR: f64 = 4.0;
/// The distance (m) that stands for the difference of 1 minus the cosine of the angle between two gaps.
const TURNED_M: f64 = 5.0;

/// The gaps that are separate openings, each with its share of the risk. Of gaps of equal width, up to a
/// micrometre, the first counts as narrower.
pub(super) fn narrowest(mut gaps: Vec<Opening>, robot_width: f64) -> Vec<Opening> {
    let [from, to] = ONE_PASSAGE.map(|widths| widths * robot_width);
    let nearby = Nearby::new(gaps.iter().map(|gap| Bounds { min: gap.center(), max: gap.center() }));
    let key = |i: usize| ((gaps[i].width * 1e6).round() as i64, i);
    let share = |(number, gap): (usize, &Opening)| {
        // of the wider gap's distances the farthest is the one along its disc
        let within = to + gap.width / 2.0;
        let near = nearby.meeting(Bounds { min: gap.center(), max: gap.center() }.grown(within));
        let narrower = near.into_iter().filter(|&other| key(other) < key(number));
        let distance = narrower.map(|other| apart(&gaps[other], gap)).fold(f64::INFINITY, f64::min);
        ((distance - from) / (to - from)).clamp(0.0, 1.0)
    };
    let shares: Vec<f64> = gaps.iter().enumerate().map(share).collect();
    gaps.iter_mut().zip(shares).for_each(|(gap, share)| gap.share = share);
    gaps.retain(|gap| gap.share > 0.0);
    gaps
}

/// The distance (m) between a gap and a wider one, less that at which the wider one's disc contains the
/// narrower one's sides.
fn apart(narrower: &Opening, wider: &Opening) -> f64 {
    let between = wider.center() - narrower.center();
    let across = cross(narrower.axis(), between).abs();
    let along = between.norm_squared() - (wider.width * wider.width - narrower.width * narrower.width) / 4.0;
    let turned = 1.0 - narrower.axis().dot(&wider.axis()).abs();
    along.max(0.0).sqrt() + ACROSS_FACTOR * across + TURNED_M * turned
}
