//! A turn from the present heading onto a path: an arc and its tangent.

use super::{Path, Piece, Point, angle_of, direction, left_of, wrap_angle};
use crate::math;
use std::f64::consts::TAU;

/// The cost of a bend where the tangent meets the path, in metres of path per radian.
const BEND_COST_M_PER_RAD: f64 = 1.0;
/// The largest permissible bend, rad.
const MAX_BEND_RAD: f64 = 1.1;
/// How far along the path (m) to search for a joining point, and the step of the search (m).
const SEARCH_LENGTH_M: f64 = 6.0;
const SEARCH_STEP_M: f64 = 0.3;

/// The arc of a turn.
#[derive(Clone, Copy, Debug)]
pub struct Arc {
    /// Radius, m.
    pub radius: f64,
    /// Largest angle, rad.
    pub most: f64,
}

/// An arc and its tangent onto a path.
struct Turn {
    arc: Piece,
    tangent: [Point; 2],
    /// Arc length of the path at which it is joined, m.
    joined: f64,
    /// Length to the end of the path plus the cost of the bend, m.
    cost: f64,
}

/// Writes into `way` the path of a walker at `from` with `heading` (rad) who turns onto `path`: `arc`, its
/// tangent to a point of the path at most `latest` (m) along it, and the rest of the path. The result is the
/// shortest free one among all joining points and both directions of turning. `is_free` is asked for steps of
/// a few centimetres along arc and tangent. Returns the arc's length, m; `None`, with `way` empty, if no turn
/// is free.
pub fn write_turn_onto(
    (path, latest): (&Path, f64),
    from: Point,
    heading: f64,
    arc: Arc,
    is_free: impl Fn(Point, Point) -> bool,
    way: &mut Path,
) -> Option<f64> {
    way.clear();
    let mut best: Option<Turn> = None;
    let ends = path.ends.iter().copied();
    let steps = (1..).map(|i| SEARCH_STEP_M * f64::from(i)).take_while(|along| *along < path.length());
    let is_near = |along: &f64| *along <= SEARCH_LENGTH_M || *along == path.length();
    for joined in ends.chain(steps).filter(is_near).filter(|along| *along <= latest) {
        for side in [1.0, -1.0] {
            let Some(turn) = turn_to(path, joined, from, heading, Arc { radius: side * arc.radius, ..arc })
            else {
                continue;
            };
            if best.as_ref().is_none_or(|best| turn.cost < best.cost) && turn.is_free(&is_free) {
                best = Some(turn);
            }
        }
    }
    let Turn { arc, tangent: [leave, join], joined, .. } = best?;
    way.push(arc);
    way.line(leave, join);
    way.push_rest(path, joined);
    Some(arc.length())
}

/// The turn that joins the path at arc length `joined` (m); a positive radius turns left. `None` where the
/// circle covers the point or the bend is too sharp.
fn turn_to(path: &Path, joined: f64, from: Point, heading: f64, arc: Arc) -> Option<Turn> {
    let join = path.point_at(joined)?;
    let (side, radius) = (arc.radius.signum(), arc.radius.abs());
    let center = from + left_of(direction(heading)) * (side * radius);
    let toward = join - center;
    if toward.norm() <= radius {
        return None;
    }
    let from_angle = angle_of(from - center);
    let leave_angle = angle_of(toward) - side * math::acos(radius / toward.norm());
    // an angle below 0 by rounding only is not a full circle
    let turned = (side * (leave_angle - from_angle) + 1e-9).rem_euclid(TAU) - 1e-9;
    let sweep = side * turned.max(0.0);
    let leave = center + direction(leave_angle) * radius;
    // there is no bend at the end of the path
    let bend = if joined < path.length() {
        let onward = path.heading_at(joined + 1e-6)?;
        wrap_angle(onward - angle_of(join - leave)).abs()
    } else {
        0.0
    };
    if bend > MAX_BEND_RAD || turned > arc.most {
        return None;
    }
    let cost = radius * turned + (join - leave).norm() + path.length() - joined + BEND_COST_M_PER_RAD * bend;
    Some(Turn { arc: Piece::Arc { center, radius, from_angle, sweep }, tangent: [leave, join], joined, cost })
}

impl Turn {
    fn is_free(&self, is_free: &impl Fn(Point, Point) -> bool) -> bool {
        let [from, to] = self.tangent;
        self.arc.is_free(is_free) && Piece::Line { from, to }.is_free(is_free)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ARC: Arc = Arc { radius: 0.5, most: 4.5 };

    fn straight() -> Path {
        let mut path = Path::default();
        path.line(Point::new(0.0, 0.0), Point::new(-6.0, 3.0));
        path
    }

    /// Length of the path and the largest jump of its heading.
    fn walk(way: &Path) -> (f64, f64) {
        let headings = (0..=1000).map(|i| way.heading_at(way.length() * f64::from(i) / 1000.0).unwrap());
        let headings: Vec<f64> = headings.collect();
        let jump = headings.windows(2).map(|w| wrap_angle(w[1] - w[0]).abs()).fold(0.0, f64::max);
        (way.length(), jump)
    }

    #[test]
    fn property_a_turn_begins_as_one_walks_and_ends_as_the_path_does() {
        for degrees in (0..360).step_by(15) {
            let heading = f64::from(degrees).to_radians();
            let (from, path) = (Point::new(0.6, 0.1), straight());
            let mut way = Path::default();
            assert!(
                write_turn_onto((&path, f64::INFINITY), from, heading, ARC, |_, _| true, &mut way).is_some(),
                "{degrees}"
            );
            assert!((way.point_at(0.0).unwrap() - from).norm() < 1e-9);
            let sweep = wrap_angle(way.heading_at(0.0).unwrap() - heading).abs();
            let bent = way.length() > (path.point_at(6.0).unwrap() - from).norm() + 0.5;
            assert!(sweep < 1e-6 || !bent, "{degrees}: {sweep}");
            assert!((way.point_at(way.length()).unwrap() - Point::new(-6.0, 3.0)).norm() < 1e-9);
            let (_, jump) = walk(&way);
            assert!(jump < MAX_BEND_RAD + 0.05, "{degrees}: {jump}");
        }
    }

    #[test]
    fn a_turn_goes_the_other_way_round_what_is_in_its_way() {
        let (from, path) = (Point::new(0.0, 0.0), straight());
        let mut way = Path::default();
        assert!(write_turn_onto((&path, f64::INFINITY), from, -0.5, ARC, |_, _| true, &mut way).is_some());
        let free = way.length();
        let left = |_: Point, to: Point| left_of(direction(-0.5)).dot(&to.coords) > -0.2;
        assert!(write_turn_onto((&path, f64::INFINITY), from, -0.5, ARC, left, &mut way).is_some());
        assert!(way.length() > free);
        assert!(write_turn_onto((&path, f64::INFINITY), from, -0.5, ARC, |_, _| false, &mut way).is_none());
        assert_eq!(way.length(), 0.0);
    }

    #[test]
    fn a_turn_is_no_longer_than_it_may_be() {
        let (from, path) = (Point::new(0.0, 0.0), straight());
        let mut way = Path::default();
        let tight = Arc { radius: 0.5, most: 1.0 };
        assert!(write_turn_onto((&path, f64::INFINITY), from, -0.5, tight, |_, _| true, &mut way).is_none());
        assert!(write_turn_onto((&path, f64::INFINITY), from, 2.4, tight, |_, _| true, &mut way).is_some());
    }
}
