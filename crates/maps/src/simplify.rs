//! Outlines with fewer corners: none of those left out is farther than a tolerance from the outline that is
//! left, and outlines do not come to cross or touch.

use crate::trace::{Vertex, doubled_area};
use cocarry::geometry::{Bounds, Nearby, Point, segments_meet, squared_distance_to_segment};
use std::collections::BTreeSet;

/// The number of times that a tolerance is halved before an outline keeps all corners.
const MAX_HALVINGS: u32 = 6;

/// The largest part of its extent by which a ring is changed: a post stays round.
const MAX_CHANGE: f64 = 1.0 / 8.0;

/// These rings, which do not touch, with fewer corners, within `tolerance` (cells) and an eighth of their
/// extent. Where they would cross or touch, or enclose nothing, the tolerance is halved.
///
/// The corners are chosen by the method of D. Douglas and T. Peucker (Algorithms for the reduction of the
/// number of points required to represent a digitized line or its caricature, Cartographica 10, 1973).
pub(crate) fn simplified(rings: &[Vec<Vertex>], tolerance: f64) -> Vec<Vec<Vertex>> {
    let mut halvings = vec![0_u32; rings.len()];
    let tolerances: Vec<f64> = rings.iter().map(|ring| tolerance.min(MAX_CHANGE * extent(ring))).collect();
    let mut simple: Vec<Vec<Vertex>> =
        rings.iter().zip(&tolerances).map(|(ring, tolerance)| with_fewer_corners(ring, *tolerance)).collect();
    loop {
        let spoiled = spoiled(rings, &simple);
        let spoiled: Vec<usize> = spoiled.into_iter().filter(|i| halvings[*i] <= MAX_HALVINGS).collect();
        if spoiled.is_empty() {
            return simple;
        }
        for i in spoiled {
            halvings[i] += 1;
            simple[i] = match halvings[i] {
                halved @ ..=MAX_HALVINGS => {
                    with_fewer_corners(&rings[i], tolerances[i] / f64::from(1_u32 << halved))
                }
                _ => rings[i].clone(),
            };
        }
    }
}

/// The rings that cross or touch others or themselves, or no longer enclose an area on the same side.
fn spoiled(rings: &[Vec<Vertex>], simple: &[Vec<Vertex>]) -> BTreeSet<usize> {
    let is_collapsed = |i: &usize| {
        simple[*i].len() < 3 || doubled_area(&simple[*i]).signum() != doubled_area(&rings[*i]).signum()
    };
    let mut spoiled: BTreeSet<usize> = (0..rings.len()).filter(is_collapsed).collect();
    let sides: Vec<(usize, usize, [Point; 2])> = simple
        .iter()
        .enumerate()
        .flat_map(|(i, ring)| {
            (0..ring.len()).map(move |k| (i, k, [point(ring[k]), point(ring[(k + 1) % ring.len()])]))
        })
        .collect();
    let bounds = |[a, b]: [Point; 2]| Bounds { min: a.inf(&b), max: a.sup(&b) };
    let near = Nearby::new(sides.iter().map(|(.., side)| bounds(*side)));
    for (s, &(i, k, [a, b])) in sides.iter().enumerate() {
        near.any_meeting(bounds([a, b]), |t| {
            let (j, l, [c, d]) = sides[t];
            let n = simple[i].len();
            let are_neighbors = i == j && ((k + 1) % n == l || (l + 1) % n == k);
            if t > s && !are_neighbors && segments_meet(a, b, c, d, 0.0) {
                spoiled.extend([i, j]);
            }
            false
        });
    }
    spoiled
}

/// The larger side of the rectangle around a ring, in cells.
fn extent(ring: &[Vertex]) -> f64 {
    let side = |axis: usize| {
        let coordinates = || ring.iter().map(|corner| corner[axis]);
        coordinates().max().unwrap_or(0) - coordinates().min().unwrap_or(0)
    };
    f64::from(side(0).max(side(1)))
}

fn point([x, y]: Vertex) -> Point {
    Point::new(f64::from(x), f64::from(y))
}

/// The corners of a ring that are kept.
fn with_fewer_corners(ring: &[Vertex], tolerance: f64) -> Vec<Vertex> {
    let n = ring.len();
    if n < 4 || tolerance <= 0.0 {
        return ring.to_vec();
    }
    // two corners that are far apart are kept: the lowest of the leftmost, and the farthest from it
    let first = (0..n).min_by_key(|i| ring[*i]).unwrap_or(0);
    let at = |i: usize| ring[(first + i) % n];
    let distance = |i: &usize| (point(at(*i)) - point(at(0))).norm_squared();
    let farthest = (1..n).max_by(|i, j| distance(i).total_cmp(&distance(j))).unwrap_or(1);
    let mut is_kept = vec![false; n];
    (is_kept[0], is_kept[farthest]) = (true, true);
    let mut queue = vec![[0, farthest], [farthest, n]];
    while let Some([from, to]) = queue.pop() {
        let (a, b) = (point(at(from)), point(at(to)));
        let off = |i: usize| squared_distance_to_segment(point(at(i)), a, b);
        let widest =
            (from + 1..to).map(|i| (i, off(i))).max_by(|i, j| i.1.total_cmp(&j.1).then(j.0.cmp(&i.0)));
        if let Some((i, off)) = widest
            && off > tolerance * tolerance
        {
            is_kept[i] = true;
            queue.extend([[from, i], [i, to]]);
        }
    }
    (0..n).filter(|i| is_kept[*i]).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_a_staircase_is_a_line_and_a_square_is_a_square() {
        let mut stairs: Vec<Vertex> = (0..20).flat_map(|i| [[i, i], [i + 1, i]]).collect();
        stairs.extend([[20, 20], [0, 20]]);
        let simple = &simplified(&[stairs.clone()], 1.0)[0];
        assert!(simple.len() <= 4, "{simple:?}");
        let square = vec![[0, 0], [9, 0], [9, 9], [0, 9]];
        assert_eq!(simplified(std::slice::from_ref(&square), 1.0), [square]);
        // a single cell does not vanish
        let cell = vec![[3, 3], [3, 4], [4, 4], [4, 3]];
        assert_eq!(simplified(std::slice::from_ref(&cell), 1.0)[0].len(), 4);
    }

    #[test]
    fn closed_form_rings_close_to_each_other_do_not_come_to_touch() {
        // a cell next to a bay of two cells that a tolerance of two would close
        let bay = vec![[0, 0], [10, 0], [10, 6], [6, 6], [6, 4], [3, 4], [3, 6], [0, 6]];
        let cell = vec![[4, 5], [4, 6], [5, 6], [5, 5]];
        let simple = simplified(&[bay.clone(), cell.clone()], 2.5);
        assert_eq!(simple[1].len(), 4);
        assert!(spoiled(&[bay, cell], &simple).is_empty());
    }
}
