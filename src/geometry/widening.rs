//! A path widened at its corners, for a team with a long object.

use super::{Bend, Path, Piece, Point, angle_of};
use std::f64::consts::{PI, TAU};

/// The shares of the widening that are tried at a corner: less where there is no room for more.
const SHARES: [f64; 4] = [1.0, 0.67, 0.33, 0.0];
const NO_WIDENING: usize = SHARES.len() - 1;
/// Corners closer together than this (m) count as one: the two corners at the end of a thin wall are one half
/// turn.
const ONE_CORNER_DISTANCE_M: f64 = 0.5;

/// A widener of paths that keeps its memory between calls.
#[derive(Clone, Debug, Default)]
pub struct Widening {
    /// The corners of the section of path between two points where lines meet.
    corners: Vec<Corner>,
    /// The lines before, between and after the corners.
    lines: Vec<[Point; 2]>,
}

#[derive(Clone, Copy, Debug)]
struct Corner {
    narrow: Bend,
    /// The angle by which the path turns here, rad.
    sweep: f64,
    /// The wanted radius, m.
    wanted: f64,
    /// The share of the widening, as an index into [`SHARES`].
    share: usize,
    bend: Bend,
}

/// The reason why corners cannot be joined as they are.
enum Misfit {
    /// A corner that the path does not touch: wider corners before and after it lead past it.
    Hidden(usize),
    /// A line between two corners, one of which covers the other.
    Covered(usize),
}

impl Widening {
    /// Writes `path` into `way` with its arcs widened about their centres. `radius` gives the wanted radius
    /// (m) from the present radius (m) and the angle (rad) of the turn. `is_free`, asked for steps of a few
    /// centimetres, limits the widening. Points where lines meet stay, as do the sides on which corners are
    /// passed and arcs that are wide enough.
    pub fn write(
        &mut self,
        path: &Path,
        radius: impl Fn(f64, f64) -> f64,
        is_free: impl Fn(Point, Point) -> bool,
        way: &mut Path,
    ) {
        way.clear();
        let pieces = path.pieces();
        let mut begin = 0;
        for end in 1..=pieces.len() {
            if end < pieces.len()
                && !matches!(pieces[end - 1..=end], [Piece::Line { .. }, Piece::Line { .. }])
            {
                continue;
            }
            let stretch = &pieces[begin..end];
            begin = end;
            if !self.is_wide(stretch, &radius, &is_free) {
                stretch.iter().for_each(|piece| way.push(*piece));
                continue;
            }
            for (i, [from, to]) in self.lines.iter().copied().enumerate() {
                way.line(from, to);
                self.corners.get(i).into_iter().for_each(|corner| way.push(corner.arc(to)));
            }
        }
    }

    /// Whether `corners` and `lines` should replace the section.
    fn is_wide(
        &mut self,
        stretch: &[Piece],
        radius: impl Fn(f64, f64) -> f64,
        is_free: impl Fn(Point, Point) -> bool,
    ) -> bool {
        let (Some(Piece::Line { from, .. }), Some(Piece::Line { to, .. })) =
            (stretch.first(), stretch.last())
        else {
            return false;
        };
        self.corners.clear();
        for corner in stretch.iter().filter_map(Corner::of) {
            match self.corners.last_mut() {
                // consecutive pieces of one arc
                Some(last) if last.narrow == corner.narrow => last.sweep += corner.sweep,
                _ => self.corners.push(corner),
            }
        }
        // a wider corner turns by a larger angle, and so needs an even larger radius
        for _ in 0..2 {
            self.want(&radius);
            if self.corners.iter().all(|corner| corner.wanted <= corner.narrow.radius.abs()) {
                return false;
            }
            if !self.fit(*from, *to, &is_free) {
                return false;
            }
        }
        true
    }

    fn want(&mut self, radius: impl Fn(f64, f64) -> f64) {
        for i in 0..self.corners.len() {
            let Bend { center, radius: side } = self.corners[i].narrow;
            let is_same = |corner: &&Corner| {
                corner.narrow.radius * side > 0.0
                    && (corner.narrow.center - center).norm() <= ONE_CORNER_DISTANCE_M
            };
            let sweep: f64 = self.corners.iter().filter(is_same).map(|corner| corner.sweep).sum();
            self.corners[i].wanted = radius(side.abs(), sweep.min(PI));
            self.corners[i].share = 0;
        }
    }

    /// Joins the corners, each as wide as there is room. False if no share of the widening fits.
    fn fit(&mut self, from: Point, to: Point, is_free: impl Fn(Point, Point) -> bool) -> bool {
        loop {
            let line = match self.join(from, to) {
                Ok(()) => match self.blocked(&is_free) {
                    None => return true,
                    Some(line) => line,
                },
                Err(Misfit::Hidden(corner)) => {
                    self.corners.remove(corner);
                    continue;
                }
                Err(Misfit::Covered(line)) => line,
            };
            // narrow the corners at the ends of the line, or else all corners
            let ends = line.saturating_sub(1)..(line + 1).min(self.corners.len());
            let mut narrowed = false;
            for corner in &mut self.corners[ends] {
                narrowed |= corner.share < NO_WIDENING;
                corner.share = (corner.share + 1).min(NO_WIDENING);
            }
            if !narrowed {
                if self.corners.iter().all(|corner| corner.share == NO_WIDENING) {
                    return false;
                }
                self.corners.iter_mut().for_each(|corner| corner.share = (corner.share + 1).min(NO_WIDENING));
            }
        }
    }

    /// Draws the lines and sets the angle by which the path turns at each corner.
    fn join(&mut self, from: Point, to: Point) -> Result<(), Misfit> {
        let n = self.corners.len();
        for (i, corner) in self.corners.iter_mut().enumerate() {
            let narrow = corner.narrow.radius.abs();
            let mut wide = narrow + (corner.wanted - narrow).max(0.0) * SHARES[corner.share];
            // the circle must not contain the ends of the section
            for end in [(i == 0).then_some(from), (i + 1 == n).then_some(to)].into_iter().flatten() {
                wide = wide.min((end - corner.narrow.center).norm());
            }
            corner.bend = Bend { radius: wide.copysign(corner.narrow.radius), ..corner.narrow };
        }
        self.lines.clear();
        let Some((first, last)) = self.corners.first().zip(self.corners.last()) else {
            self.lines.push([from, to]);
            return Ok(());
        };
        self.lines.push([from, first.bend.touch_from(from).0]);
        for (i, pair) in self.corners.windows(2).enumerate() {
            self.lines.push(pair[0].bend.line_to(&pair[1].bend).ok_or(Misfit::Covered(i + 1))?);
        }
        self.lines.push([last.bend.leave_to(to), to]);
        for (i, corner) in self.corners.iter_mut().enumerate() {
            let Bend { center, radius } = corner.bend;
            let [touch, leave] = [self.lines[i][1], self.lines[i + 1][0]].map(|p| angle_of(p - center));
            let ahead = (radius.signum() * (leave - touch)).rem_euclid(TAU);
            // an angle just below a full turn is a turn backward by rounding: none
            corner.sweep = if ahead > TAU - 1e-6 { 0.0 } else { ahead };
            if corner.sweep > 1.5 * PI {
                return Err(Misfit::Hidden(i));
            }
        }
        Ok(())
    }

    /// The first line, or the arc before it, that is not free.
    fn blocked(&self, is_free: impl Fn(Point, Point) -> bool) -> Option<usize> {
        (0..self.lines.len()).find(|&i| {
            let [from, to] = self.lines[i];
            let arc = i.checked_sub(1).map(|before| self.corners[before].arc(self.lines[before][1]));
            !arc.into_iter().chain([Piece::Line { from, to }]).all(|piece| piece.is_free(&is_free))
        })
    }
}

impl Corner {
    fn of(piece: &Piece) -> Option<Self> {
        let Piece::Arc { center, radius, sweep, .. } = *piece else { return None };
        let narrow = Bend { center, radius: radius.copysign(sweep) };
        Some(Self { narrow, sweep: sweep.abs(), wanted: radius, share: 0, bend: narrow })
    }

    fn arc(&self, touch: Point) -> Piece {
        let Bend { center, radius } = self.bend;
        let sweep = self.sweep.copysign(radius);
        Piece::Arc { center, radius: radius.abs(), from_angle: angle_of(touch - center), sweep }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Vector, cross, direction};

    /// A path from (-3, 0) round corners, at 0.25 m, to a point 3 m beyond the last.
    fn bends(corners: &[(f64, f64)]) -> Path {
        let mut path = Path::default();
        let (mut at, mut heading) = (Point::new(-3.0, 0.0), 0.0_f64);
        for &(length, turn) in corners {
            let to = at + direction(heading) * length;
            path.line(at, to);
            let out = direction(heading - turn.signum() * PI / 2.0);
            let arc =
                Piece::Arc { center: to - out * 0.25, radius: 0.25, from_angle: angle_of(out), sweep: turn };
            path.push(arc);
            at = arc.point_at(arc.length());
            heading += turn;
        }
        path.line(at, at + direction(heading) * 3.0);
        path
    }

    fn widened(
        path: &Path,
        radius: impl Fn(f64, f64) -> f64,
        is_free: impl Fn(Point, Point) -> bool,
    ) -> Path {
        let mut way = Path::default();
        Widening::default().write(path, radius, is_free, &mut way);
        way
    }

    fn radii(path: &Path) -> Vec<f64> {
        let radius = |piece: &Piece| match piece {
            Piece::Arc { radius, .. } => Some(*radius),
            Piece::Line { .. } => None,
        };
        path.pieces().iter().filter_map(radius).collect()
    }

    fn is_smooth(path: &Path) -> bool {
        let heading = |piece: &Piece, at: f64| -> Vector {
            (piece.point_at(at + 1e-4) - piece.point_at(at)).normalize()
        };
        path.pieces().windows(2).all(|pair| {
            let gap = pair[1].point_at(0.0) - pair[0].point_at(pair[0].length());
            let bend = cross(heading(&pair[0], pair[0].length() - 1e-4), heading(&pair[1], 0.0));
            gap.norm() < 1e-9 && bend.abs() < 2e-3
        })
    }

    #[test]
    fn property_wider_corners_join_the_same_ends_smoothly_and_on_the_same_side() {
        for turns in
            [&[(3.0, -0.2)][..], &[(3.0, 2.5)], &[(3.0, 1.0), (2.0, -1.2)], &[(3.0, -1.5), (0.1, -1.5)]]
        {
            let path = bends(turns);
            let way = widened(&path, |_, _| 0.6, |_, _| true);
            assert!(is_smooth(&path) && is_smooth(&way), "{turns:?}: {way:?}");
            assert_eq!(radii(&way), vec![0.6; turns.len()]);
            for walked in [0.0, f64::INFINITY] {
                assert!((way.point_at(walked).unwrap() - path.point_at(walked).unwrap()).norm() < 1e-9);
            }
            for (wide, narrow) in way.pieces().iter().zip(path.pieces()) {
                if let (Piece::Arc { sweep, .. }, Piece::Arc { sweep: before, .. }) = (wide, narrow) {
                    assert!(sweep.signum() == before.signum() && sweep.abs() > before.abs() - 0.2);
                }
            }
            assert!(way.length() > path.length());
        }
    }

    #[test]
    fn corners_close_to_each_other_count_as_one() {
        let thin = widened(&bends(&[(3.0, -1.5), (0.1, -1.5)]), |_, turn| 0.2 * turn, |_, _| true);
        assert!(radii(&thin).iter().all(|radius| *radius > 0.59), "{:?}", radii(&thin));
        let thick = widened(&bends(&[(3.0, -1.5), (1.0, -1.5)]), |_, turn| 0.2 * turn, |_, _| true);
        assert!(radii(&thick).iter().all(|radius| *radius < 0.4), "{:?}", radii(&thick));
    }

    #[test]
    fn a_corner_is_widened_as_far_as_there_is_room_and_no_farther() {
        let path = bends(&[(3.0, -1.0), (3.0, 0.5)]);
        // a wall next to the first corner
        let way = widened(&path, |_, _| 0.6, |_, to| to.x > 1.0 || to.y < 0.15);
        let [first, second] = radii(&way)[..] else { panic!("{way:?}") };
        assert!((0.3..0.4).contains(&first) && second > first, "{first} {second}");
        assert_eq!(widened(&path, |_, _| 0.6, |_, _| false), path);
        assert_eq!(widened(&path, |_, turn| 0.2 * turn, |_, _| true), path);
    }

    #[test]
    fn a_corner_that_wider_ones_lead_past_is_left_out() {
        let path = bends(&[(3.0, -1.5), (2.0, -0.05), (2.0, -1.5)]);
        let way = widened(&path, |_, turn| if turn > 1.0 { 0.6 } else { 0.25 }, |_, _| true);
        assert_eq!(radii(&way), [0.6, 0.6]);
        assert!(is_smooth(&way));
    }

    #[test]
    fn an_arc_in_parts_is_one_corner() {
        let path = bends(&[(3.0, 1.0)]);
        let [before, Piece::Arc { center, radius, from_angle, sweep }, after] = path.pieces()[..] else {
            panic!("{path:?}")
        };
        let part = |i: f64| Piece::Arc {
            center,
            radius,
            from_angle: from_angle + i * sweep / 2.0,
            sweep: sweep / 2.0,
        };
        let parts = Path::from(vec![before, part(0.0), part(1.0), after]);
        let [whole, parts] = [path, parts].map(|path| widened(&path, |_, turn| 0.6 * turn, |_, _| true));
        assert_eq!(radii(&parts).len(), 1);
        assert!((radii(&parts)[0] - radii(&whole)[0]).abs() < 1e-9);
    }

    #[test]
    fn a_path_without_lines_beside_its_arcs_stays_as_it_is() {
        let path = Path::from(vec![bends(&[(3.0, 1.0)]).pieces()[1]]);
        assert_eq!(widened(&path, |_, _| 0.6, |_, _| true), path);
    }
}
