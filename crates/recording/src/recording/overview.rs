//! The view of a whole scene in a viewer's panel, and where the labels of openings are in it.

use super::shapes::LETTERS;
use cocarry::geometry::{Bounds, Point, Vector};
use cocarry::math;
use cocarry::options::OptionSet;
use cocarry::world::World;

/// The vertical field of view of the cameras of a viewer.
pub const FIELD_OF_VIEW_DEG: f64 = 45.0;
/// The smallest panel in which the labels are apart, px: the layout's in a window of 1120 by 740.
const PANEL: [f64; 2] = [590.0, 310.0];
/// Angle of the view from straight down.
const TILT_DEG: f64 = 38.0;
/// Room of a letter, in heights of letters: width, and height of a line.
const LETTER: [f64; 2] = [0.62, 1.3];
/// Distance between the places at which a label can be, m, and their numbers to either side and upward.
const STEP: f64 = 0.25;
const SIDEWAYS: i32 = 8;
const UPWARD: i32 = 40;
/// Openings after these have their labels at the lowest place.
const MAX_SEPARATED_POINTS: usize = 100;

/// A camera that sees everywhere the team may go, from the side on which that is wider.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overview {
    /// Distance of the camera from the point that it looks at, m.
    pub distance: f64,
    /// Angle of its view from straight down, degrees.
    pub tilt_deg: f64,
    /// Its turn, degrees: at 0 the view is along y, at 90 along x.
    pub turn_deg: f64,
    /// The point on the floor that it looks at, m.
    pub target: Point,
}

impl Overview {
    /// The view of a world with its options.
    pub fn of(world: &World, options: &OptionSet) -> Self {
        let (sine, cosine) = math::sin_cos((FIELD_OF_VIEW_DEG / 2.0).to_radians());
        let begin = options.begin();
        let paths = (0..options.options().len()).filter_map(|o| options.path(&begin, o));
        let points = paths.flat_map(|path| path.polyline(0.05));
        let openings = world.openings.iter().flat_map(|opening| opening.ends);
        let points = points.chain(openings).chain([world.start, world.target]);
        let content = Bounds::around(points).unwrap_or(world.bounds()).grown(1.0);
        let (size, middle) = (content.size(), nalgebra::center(&content.min, &content.max));
        let is_tall = size.y > size.x;
        let (across, away) = if is_tall { (size.y, size.x) } else { (size.x, size.y) };
        let aspect = PANEL[0] / PANEL[1];
        let distance = (across / aspect).max(away * math::cos(TILT_DEG.to_radians())) * cosine / (2.0 * sine)
            + away / 6.0;
        let rounded = |value: f64| (value * 10.0).round() / 10.0 + 0.0;
        Self {
            distance: rounded(distance),
            tilt_deg: TILT_DEG,
            turn_deg: if is_tall { 90.0 } else { 0.0 },
            target: Point::new(rounded(middle.x), rounded(middle.y)),
        }
    }

    /// Where a point is in the smallest panel, px from its middle: right and up.
    fn seen(&self, place: Point, height: f64) -> Point {
        let (sine, cosine) = math::sin_cos(self.tilt_deg.to_radians());
        let (turn_sine, turn_cosine) = math::sin_cos(self.turn_deg.to_radians());
        let from = place - self.target;
        let right = turn_cosine * from.x - turn_sine * from.y;
        let ahead = turn_sine * from.x + turn_cosine * from.y;
        let depth = (self.distance + sine * ahead - cosine * height).max(0.1);
        let half = (FIELD_OF_VIEW_DEG / 2.0).to_radians();
        let (half_sine, half_cosine) = math::sin_cos(half);
        let scale = PANEL[1] / 2.0 * half_cosine / half_sine / depth;
        Point::new(scale * right, scale * (cosine * ahead + sine * height))
    }

    /// Places (floor, height) of these labels, at which they do not cover each other in the view: each as near
    /// as can be to `least` above its point. Letters have one size on the screen, so labels are further apart
    /// in a larger panel.
    pub(super) fn places(&self, labels: &[(Point, String)], least: f64) -> Vec<(Point, f64)> {
        let (turn_sine, turn_cosine) = math::sin_cos(self.turn_deg.to_radians());
        let right = Vector::new(turn_cosine, -turn_sine);
        let all = (0..UPWARD).flat_map(|up| (-SIDEWAYS..=SIDEWAYS).map(move |side| (side, up)));
        let mut offsets: Vec<(i32, i32)> = all.collect();
        offsets.sort_by_key(|(side, up)| (side * side + up * up, *up, -side));
        let mut taken: Vec<Bounds> = Vec::new();
        let place = |point: Point, (side, up): (i32, i32)| {
            (point + right * (STEP * f64::from(side)), least + STEP * f64::from(up))
        };
        let mut places: Vec<(Point, f64)> = Vec::new();
        for (i, (point, words)) in labels.iter().enumerate() {
            let seen = |(floor, height): (Point, f64)| area(self.seen(floor, height), words);
            let mut all =
                offsets.iter().filter(|_| i < MAX_SEPARATED_POINTS).map(|offset| place(*point, *offset));
            let free = all.find(|at| !taken.iter().any(|other| overlap(*other, seen(*at))));
            let found = free.unwrap_or(place(*point, (0, 0)));
            taken.extend((i < MAX_SEPARATED_POINTS).then(|| seen(found)));
            places.push(found);
        }
        places
    }
}

/// The area of words around a point, px.
fn area(middle: Point, words: &str) -> Bounds {
    let letters = words.lines().map(|line| line.chars().count()).max().unwrap_or_default();
    let size = Vector::new(LETTER[0] * letters as f64, LETTER[1] * words.lines().count() as f64) * LETTERS;
    Bounds { min: middle - size / 2.0, max: middle + size / 2.0 }
}

fn overlap(a: Bounds, b: Bounds) -> bool {
    (0..2).all(|axis| a.min[axis] < b.max[axis] && b.min[axis] < a.max[axis])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view(turn_deg: f64) -> Overview {
        Overview { distance: 10.0, tilt_deg: 30.0, turn_deg, target: Point::new(1.0, 2.0) }
    }

    #[test]
    fn closed_form_points_in_the_view() {
        let (half_sine, half_cosine) = math::sin_cos(22.5f64.to_radians());
        // px per m at the target's depth
        let scale = PANEL[1] / 2.0 / (10.0 * half_sine / half_cosine);
        let seen = |turn, x, y, z| view(turn).seen(Point::new(x, y), z) / scale;
        let near = |p: Point, x: f64, y: f64| assert!((p - Point::new(x, y)).norm() < 1e-12, "{p}");
        near(seen(0.0, 1.0, 2.0, 0.0), 0.0, 0.0);
        near(seen(0.0, 4.0, 2.0, 0.0), 3.0, 0.0);
        near(seen(90.0, 1.0, -1.0, 0.0), 3.0, 0.0);
        // 4 m ahead is 2 m deeper; 1 m up is nearer by the cosine of the tilt
        near(seen(0.0, 1.0, 6.0, 0.0), 0.0, 4.0 * 0.75f64.sqrt() * 10.0 / 12.0);
        near(seen(90.0, 1.0, 2.0, 1.0), 0.0, 0.5 * 10.0 / (10.0 - 0.75f64.sqrt()));
    }

    #[test]
    fn labels_of_one_place_are_near_it_and_apart() {
        let words = "a: 1.00 m\nrisk 0.10";
        let labels = vec![(Point::new(1.0, 2.0), words.to_owned()); 6];
        let places = view(0.0).places(&labels, 0.5);
        assert_eq!(places[0], (labels[0].0, 0.5));
        let areas: Vec<Bounds> =
            places.iter().map(|(floor, height)| area(view(0.0).seen(*floor, *height), words)).collect();
        for (i, a) in areas.iter().enumerate() {
            assert!(areas[..i].iter().all(|b| !overlap(*a, *b)), "{places:?}");
            let away = nalgebra::center(&a.min, &a.max) - nalgebra::center(&areas[0].min, &areas[0].max);
            assert!(away.norm() < 250.0, "{places:?}");
        }
        let apart = [(Point::new(-9.0, 2.0), "a".to_owned()), (Point::new(9.0, 2.0), "b".to_owned())];
        assert_eq!(view(0.0).places(&apart, 0.5), apart.map(|(point, _)| (point, 0.5)));
    }

    #[test]
    fn labels_of_built_in_worlds_do_not_cover_each_other() {
        for built_in in cocarry::world::BUILT_IN_WORLDS {
            let name = built_in.name;
            let world = World::parse(name, built_in.text).unwrap();
            let options = OptionSet::new(&world, 10.0).unwrap();
            let view = Overview::of(&world, &options);
            let labels = super::super::scene::opening_labels(&world, &options);
            let seen = labels.iter().map(|(words, (floor, height))| area(view.seen(*floor, *height), words));
            let areas: Vec<Bounds> = seen.collect();
            for (i, a) in areas.iter().enumerate() {
                assert!(areas[..i].iter().all(|b| !overlap(*a, *b)), "{name}: {labels:?}");
            }
        }
    }
}
