//! The curve on which a base rolls that follows a team's path.
//!
//! A base that looks ahead along its path cuts corners: round the end of a wall it is nearer to it than the
//! path.

use crate::geometry::{Point, angle_of, direction, wrap_angle};
use crate::math;

/// The shortest look-ahead of the base, m: where it has little room (Follower::inputs).
const LOOK_AHEAD_M: f64 = 0.3;
/// The sharpest curve of the base, rad per metre.
const MAX_CURVATURE_RAD_PER_M: f64 = 5.0;
/// Distance between places on the curve, m.
const STEP_M: f64 = 0.05;
/// Half the distance over which the direction of the path is taken, m.
const DIRECTION_M: f64 = 0.02;

/// Calls `on_place` for places on the curve, from where the base is on the path, at the position `from`, to
/// where it has come to the position `to` (m): with the position along the path and the place. `point` gives
/// the path by position.
pub(super) fn pursue(
    point: impl Fn(f64) -> Point,
    [from, to]: [f64; 2],
    mut on_place: impl FnMut(f64, Point),
) {
    let tangent = |along: f64| angle_of(point(along + DIRECTION_M) - point(along - DIRECTION_M));
    let (mut along, mut at, mut yaw) = (from, point(from), tangent(from));
    let steps = (2.0 * (to - from) / STEP_M).max(0.0) as usize;
    for _ in 0..steps {
        if along >= to {
            return;
        }
        let goal = point(along + LOOK_AHEAD_M) - at;
        let bearing = wrap_angle(angle_of(goal) - yaw);
        let curvature = 2.0 * math::sin(bearing) / goal.norm().max(STEP_M);
        let (rate, ahead) = match math::cos(bearing) > 0.0 {
            true => (curvature.clamp(-MAX_CURVATURE_RAD_PER_M, MAX_CURVATURE_RAD_PER_M), STEP_M),
            // it turns on the spot
            false => (MAX_CURVATURE_RAD_PER_M.copysign(bearing), 0.0),
        };
        at += direction(yaw + rate * STEP_M / 2.0) * ahead;
        yaw = wrap_angle(yaw + rate * STEP_M);
        // the nearest point of the path, by one step of Newton's iteration
        along += (at - point(along)).dot(&direction(tangent(along))).clamp(0.0, 2.0 * STEP_M);
        on_place(along, at);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::nearest_on_segment;

    /// Round a corner the curve is off the path by centimetres, and back on it behind the corner.
    #[test]
    fn a_base_cuts_a_corner_and_comes_back_to_its_path() {
        for (turn, [least, most]) in
            [(0.0, [0.0, 1e-9]), (0.8_f64, [0.03, 0.06]), (-0.8, [0.03, 0.06]), (-1.5, [0.1, 0.15])]
        {
            let point = |along: f64| Point::from(direction(if along < 0.0 { 0.0 } else { turn }) * along);
            let (mut off, mut last) = (0.0_f64, Point::origin());
            pursue(point, [-2.0, 2.0], |along, at| {
                off = off.max((at - point(along)).norm());
                last = at;
            });
            assert!((least..=most).contains(&off), "turn {turn}: {off} m off the path");
            let nearest = nearest_on_segment(last, Point::origin(), Point::from(direction(turn) * 3.0));
            assert!((last - nearest).norm() < 0.01, "turn {turn}: {last}");
        }
    }
}
