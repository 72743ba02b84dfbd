//! Paths of lines and circular arcs: points and headings by arc length.

use super::{Point, angle_of, direction, left_of, wrap_angle};
use crate::math;

/// One piece of a path.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Piece {
    /// A straight line.
    Line {
        /// First point.
        from: Point,
        /// Last point.
        to: Point,
    },
    /// A circular arc.
    Arc {
        /// Centre of the circle.
        center: Point,
        /// Radius, m.
        radius: f64,
        /// Angle of the first point seen from the centre, rad.
        from_angle: f64,
        /// Signed angle of the arc, rad; positive is counter-clockwise.
        sweep: f64,
    },
}

impl Piece {
    pub(super) fn length(&self) -> f64 {
        match self {
            Self::Line { from, to } => (to - from).norm(),
            Self::Arc { radius, sweep, .. } => radius * sweep.abs(),
        }
    }

    pub(super) fn point_at(&self, walked: f64) -> Point {
        match *self {
            Self::Line { from, to } => {
                let length = (to - from).norm();
                if length > 0.0 { from + (to - from) * (walked / length) } else { from }
            }
            Self::Arc { center, radius, from_angle, sweep } => {
                center + direction(from_angle + sweep.signum() * walked / radius) * radius
            }
        }
    }

    fn heading_at(&self, walked: f64) -> f64 {
        match *self {
            Self::Line { from, to } => angle_of(to - from),
            Self::Arc { radius, from_angle, sweep, .. } => {
                let turn = sweep.signum();
                angle_of(left_of(direction(from_angle + turn * walked / radius)) * turn)
            }
        }
    }
}

impl Piece {
    /// Whether the piece is free when checked in steps of a few centimetres.
    pub(super) fn is_free(&self, is_free: impl Fn(Point, Point) -> bool) -> bool {
        const CHECK_STEP_M: f64 = 0.08;
        let steps = (self.length() / CHECK_STEP_M).ceil().max(1.0);
        let point = |i: usize| self.point_at(self.length() * i as f64 / steps);
        (0..steps as usize).all(|i| is_free(point(i), point(i + 1)))
    }

    /// The remainder of the piece after `walked` metres.
    fn rest(&self, walked: f64) -> Self {
        match *self {
            Self::Line { to, .. } => Self::Line { from: self.point_at(walked), to },
            Self::Arc { center, radius, from_angle, sweep } => {
                let gone = sweep.signum() * walked / radius;
                Self::Arc { center, radius, from_angle: from_angle + gone, sweep: sweep - gone }
            }
        }
    }
}

/// A connected path, parameterised by the arc length from its first point.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(from = "Vec<Piece>", into = "Vec<Piece>")]
pub struct Path {
    pieces: Vec<Piece>,
    /// Arc length at the end of each piece, m.
    pub(super) ends: Vec<f64>,
}

impl From<Vec<Piece>> for Path {
    fn from(pieces: Vec<Piece>) -> Self {
        let mut path = Self::with_capacity(pieces.len());
        pieces.into_iter().for_each(|piece| path.push(piece));
        path
    }
}

impl From<Path> for Vec<Piece> {
    fn from(path: Path) -> Self {
        path.pieces
    }
}

impl Path {
    /// An empty path with room for this many pieces.
    pub fn with_capacity(pieces: usize) -> Self {
        Self { pieces: Vec::with_capacity(pieces), ends: Vec::with_capacity(pieces) }
    }

    /// Adds a piece that begins where the path ends. A piece of length 0 is left out.
    pub fn push(&mut self, piece: Piece) {
        if piece.length() > 0.0 {
            self.ends.push(self.length() + piece.length());
            self.pieces.push(piece);
        }
    }

    /// Adds a straight line.
    pub fn line(&mut self, from: Point, to: Point) {
        self.push(Piece::Line { from, to });
    }

    /// Adds the remainder of `path` after `walked` metres of it.
    pub fn push_rest(&mut self, path: &Path, walked: f64) {
        let mut begun = 0.0;
        for (piece, end) in path.pieces.iter().zip(&path.ends) {
            if *end > walked {
                self.push(piece.rest((walked - begun).max(0.0)));
            }
            begun = *end;
        }
    }

    /// The path from its end to its beginning.
    pub fn reversed(&self) -> Self {
        let backward = |piece: &Piece| match *piece {
            Piece::Line { from, to } => Piece::Line { from: to, to: from },
            Piece::Arc { center, radius, from_angle, sweep } => {
                Piece::Arc { center, radius, from_angle: from_angle + sweep, sweep: -sweep }
            }
        };
        self.pieces.iter().rev().map(backward).collect::<Vec<_>>().into()
    }

    /// Empties the path and keeps its memory.
    pub fn clear(&mut self) {
        self.pieces.clear();
        self.ends.clear();
    }

    /// Length, m.
    pub fn length(&self) -> f64 {
        self.ends.last().copied().unwrap_or(0.0)
    }

    /// Length of the first `pieces` pieces, m.
    pub(crate) fn length_of(&self, pieces: usize) -> f64 {
        self.ends.get(pieces.min(self.ends.len()).wrapping_sub(1)).copied().unwrap_or(0.0)
    }

    /// The pieces in order.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// The point at arc length `walked` (m), clamped to `[0, length]`; `None` for an empty path.
    pub fn point_at(&self, walked: f64) -> Option<Point> {
        self.locate(walked).map(|(piece, along)| piece.point_at(along))
    }

    /// The direction of travel (rad) at arc length `walked` (m); `None` for an empty path.
    pub fn heading_at(&self, walked: f64) -> Option<f64> {
        self.locate(walked).map(|(piece, along)| piece.heading_at(along))
    }

    /// The largest jump (rad) of the direction of travel where two pieces meet.
    pub fn sharpest_bend(&self) -> f64 {
        let jump = |pair: &[Piece]| {
            let before = pair[0].heading_at(pair[0].length());
            wrap_angle(pair[1].heading_at(0.0) - before).abs()
        };
        self.pieces.windows(2).map(jump).fold(0.0, f64::max)
    }

    /// The path as a polyline. Chords stay within `sagitta` (m) of the arcs.
    pub fn polyline(&self, sagitta: f64) -> Vec<Point> {
        let mut points = Vec::new();
        for piece in &self.pieces {
            let chords = match piece {
                Piece::Line { .. } => 1,
                Piece::Arc { radius, sweep, .. } => {
                    let widest = 2.0 * math::acos((1.0 - sagitta / radius).clamp(-1.0, 1.0));
                    (sweep.abs() / widest.max(1e-3)).ceil().max(1.0) as usize
                }
            };
            if points.is_empty() {
                points.push(piece.point_at(0.0));
            }
            let length = piece.length();
            points.extend((1..=chords).map(|i| piece.point_at(length * i as f64 / chords as f64)));
        }
        points
    }

    fn locate(&self, walked: f64) -> Option<(&Piece, f64)> {
        let walked = walked.clamp(0.0, self.length());
        let i = self.ends.partition_point(|&end| end <= walked).min(self.pieces.len().checked_sub(1)?);
        let begin = if i == 0 { 0.0 } else { self.ends[i - 1] };
        Some((&self.pieces[i], walked - begin))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    #[test]
    fn closed_form_the_sharpest_bend_is_where_lines_meet() {
        let mut path = bend();
        assert!(path.sharpest_bend() < 1e-9 && Path::default().sharpest_bend() == 0.0);
        // the path turns back, 135 degrees to the left
        let end = path.point_at(f64::INFINITY).unwrap();
        path.line(end, end + direction(path.heading_at(f64::INFINITY).unwrap() + 0.75 * PI));
        assert!((path.sharpest_bend() - 0.75 * PI).abs() < 1e-9);
    }

    fn bend() -> Path {
        let mut path = Path::default();
        path.line(Point::new(0.0, 0.0), Point::new(2.0, 0.0));
        path.push(Piece::Arc {
            center: Point::new(2.0, 1.0),
            radius: 1.0,
            from_angle: -FRAC_PI_2,
            sweep: FRAC_PI_2,
        });
        path
    }

    #[test]
    fn closed_form_a_reversed_path_has_the_same_points_and_headings_the_other_way() {
        let (path, back) = (bend(), bend().reversed());
        let length = path.length();
        assert!((back.length() - length).abs() < 1e-12);
        for walked in [0.0, 0.7, 2.3, 3.5] {
            let [there, here] =
                [path.point_at(walked), back.point_at(length - walked)].map(|p| p.expect("a point"));
            assert!((there - here).norm() < 1e-12);
            let headings = [path.heading_at(walked), back.heading_at(length - walked)].map(Option::unwrap);
            assert!((wrap_angle(headings[1] - headings[0]).abs() - PI).abs() < 1e-9 || walked == 0.0);
        }
    }

    #[test]
    fn closed_form_a_bend_has_the_length_of_its_pieces() {
        let path = bend();
        assert!((path.length() - 2.0 - FRAC_PI_2).abs() < 1e-15);
        let end = path.point_at(f64::INFINITY).unwrap();
        assert!((end - Point::new(3.0, 1.0)).norm() < 1e-15);
        assert!((path.heading_at(1e9).unwrap() - FRAC_PI_2).abs() < 1e-12);
        assert!((path.heading_at(2.0 + PI / 4.0).unwrap() - PI / 4.0).abs() < 1e-12);
        assert_eq!(Path::default().point_at(0.0), None);
    }

    #[test]
    fn closed_form_a_polyline_stays_within_its_sagitta() {
        let points = bend().polyline(1e-3);
        let middle = nalgebra::center(&points[1], &points[2]);
        assert!(1.0 - (middle - Point::new(2.0, 1.0)).norm() <= 1e-3);
        assert!(points.len() > 5);
    }
}
