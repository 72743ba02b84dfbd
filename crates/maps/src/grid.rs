//! Occupancy grids: which cells are free, and which of these a robot reaches.

use crate::description::{Description, Mode};
use crate::image::Image;
use cocarry::geometry::{Point, direction, left_of};

/// The state of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cell {
    Free,
    Occupied,
    Unknown,
}

/// A grid of cells on the floor, row by row from the lowest y.
pub(crate) struct Grid {
    pub width: usize,
    pub height: usize,
    /// Side of a cell, m.
    pub resolution: f64,
    /// The lower left corner: x, y (m) and yaw (rad).
    pub origin: [f64; 3],
    pub cells: Vec<Cell>,
}

impl Grid {
    pub fn new(description: &Description, image: &Image) -> Self {
        let cell = |shade: &Option<u8>| {
            let Some(shade) = shade.map(f64::from) else { return Cell::Unknown };
            let probability = match description.mode {
                Mode::Shades if description.negate => shade / 255.0,
                Mode::Shades => (255.0 - shade) / 255.0,
                Mode::Percent if shade > 100.0 => return Cell::Unknown,
                Mode::Percent => shade / 100.0,
            };
            match probability {
                p if p > description.occupied => Cell::Occupied,
                p if p < description.free => Cell::Free,
                _ => Cell::Unknown,
            }
        };
        // the image's first row is the highest
        let cells = image.shades.chunks_exact(image.width).rev().flatten().map(cell).collect();
        let Description { resolution, origin, .. } = *description;
        Self { width: image.width, height: image.height, resolution, origin, cells }
    }

    /// The point of the world at these numbers of cells from the lower left corner.
    pub fn point(&self, x: f64, y: f64) -> Point {
        let [x0, y0, yaw] = self.origin;
        let along = direction(yaw);
        Point::new(x0, y0) + along * (x * self.resolution) + left_of(along) * (y * self.resolution)
    }

    /// The cell (column, row) in which a point of the world is; `None` outside of the map.
    pub fn cell_at(&self, p: Point) -> Option<(usize, usize)> {
        let [x0, y0, yaw] = self.origin;
        let (from_origin, along) = (p - Point::new(x0, y0), direction(yaw));
        let within = |length: f64, cells: usize| {
            let cell = (length / self.resolution).floor();
            (cell >= 0.0 && cell < cells as f64).then_some(cell as usize)
        };
        Some((
            within(from_origin.dot(&along), self.width)?,
            within(from_origin.dot(&left_of(along)), self.height)?,
        ))
    }

    pub fn index(&self, (column, row): (usize, usize)) -> usize {
        row * self.width + column
    }

    /// Whether each cell is within `radius` (cells) of a marked one, from centre to centre.
    pub fn within(&self, is_marked: impl Fn(usize) -> bool, radius: f64) -> Vec<bool> {
        let (width, height) = (self.width, self.height);
        let far = u16::MAX;
        // the distance to the nearest marked cell of the column, in cells
        let mut vertical = vec![far; width * height];
        for row in 0..height {
            for column in 0..width {
                let i = row * width + column;
                vertical[i] = match (is_marked(i), row) {
                    (true, _) => 0,
                    (false, 0) => far,
                    (false, _) => vertical[i - width].saturating_add(1),
                };
            }
        }
        for i in (0..width * height.saturating_sub(1)).rev() {
            vertical[i] = vertical[i].min(vertical[i + width].saturating_add(1));
        }
        // half the length of a row's part within the radius, for every vertical distance
        let squared = radius * radius;
        let halves: Vec<usize> = (0..)
            .map(|vertical: u32| squared - f64::from(vertical) * f64::from(vertical))
            .take_while(|rest| *rest >= 0.0)
            .map(|rest| rest.sqrt() as usize)
            .collect();
        let mut is_within = vec![false; width * height];
        let mut changes = vec![0_i32; width + 1];
        for (row, marks) in vertical.chunks_exact(width).zip(is_within.chunks_exact_mut(width)) {
            changes.fill(0);
            for (column, vertical) in row.iter().enumerate() {
                if let Some(half) = halves.get(usize::from(*vertical)) {
                    changes[column.saturating_sub(*half)] += 1;
                    changes[(column + half + 1).min(width)] -= 1;
                }
            }
            let mut depth = 0;
            for (mark, change) in marks.iter_mut().zip(&changes) {
                depth += change;
                *mark = depth > 0;
            }
        }
        is_within
    }

    /// The cells that are connected to `from` over sides of cells that are `open`.
    pub fn connected(
        &self,
        from: impl IntoIterator<Item = usize>,
        is_open: impl Fn(usize) -> bool,
    ) -> Vec<bool> {
        let (width, cells) = (self.width, self.cells.len());
        let mut is_reached = vec![false; cells];
        let mut seeds: Vec<usize> = from.into_iter().filter(|i| is_open(*i)).collect();
        while let Some(seed) = seeds.pop() {
            if is_reached[seed] {
                continue;
            }
            // the whole run of open cells of a row at once
            let row = seed - seed % width;
            let run = (row..seed).rev().take_while(|i| is_open(*i)).last().unwrap_or(seed)
                ..(seed..row + width).find(|i| !is_open(*i)).unwrap_or(row + width);
            is_reached[run.clone()].fill(true);
            // and a cell of every run that begins beside it
            for beside in [run.start.checked_sub(width), Some(run.start + width).filter(|i| *i < cells)] {
                let mut is_inside = false;
                for i in beside.into_iter().flat_map(|begin| begin..begin + run.len()) {
                    let was_inside = std::mem::replace(&mut is_inside, is_open(i) && !is_reached[i]);
                    if is_inside && !was_inside {
                        seeds.push(i);
                    }
                }
            }
        }
        is_reached
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn property_what_is_within_a_radius_is_what_a_search_through_all_finds() {
        let (width, height) = (23, 17);
        let grid = Grid {
            width,
            height,
            resolution: 1.0,
            origin: [0.0; 3],
            cells: vec![Cell::Free; width * height],
        };
        let is_marked = |i: usize| (i * 7919).is_multiple_of(61);
        for radius in [0.0, 1.0, 1.5, 3.2, 40.0] {
            let found = grid.within(is_marked, radius);
            for (i, found) in found.into_iter().enumerate() {
                let at = |i: usize| ((i % width) as f64, (i / width) as f64);
                let near = |j: usize| {
                    let ((x, y), (u, v)) = (at(i), at(j));
                    (x - u) * (x - u) + (y - v) * (y - v) <= radius * radius
                };
                assert_eq!(found, (0..width * height).any(|j| is_marked(j) && near(j)), "{i} {radius}");
            }
        }
    }

    #[test]
    fn property_what_is_connected_is_what_spreads_from_cell_to_cell() {
        let (width, height) = (29, 23);
        let cells = vec![Cell::Free; width * height];
        let grid = Grid { width, height, resolution: 1.0, origin: [0.0; 3], cells };
        for seed in 0..50 {
            let is_open = |i: usize| !(i + seed).wrapping_mul(2654435761).is_multiple_of(2 + seed % 3);
            let from = [seed, 200 + seed, 600];
            let mut spread: Vec<bool> =
                (0..width * height).map(|i| from.contains(&i) && is_open(i)).collect();
            loop {
                let next: Vec<bool> = (0..spread.len())
                    .map(|i| {
                        let beside = (i % width > 0 && spread[i - 1])
                            || (i % width + 1 < width && spread[i + 1])
                            || (i >= width && spread[i - width])
                            || spread.get(i + width).copied().unwrap_or(false);
                        is_open(i) && (spread[i] || beside)
                    })
                    .collect();
                if next == spread {
                    break;
                }
                spread = next;
            }
            assert_eq!(grid.connected(from, is_open), spread, "{seed}");
        }
    }

    #[test]
    fn closed_form_cells_of_a_turned_map() {
        let origin = [3.0, -1.0, std::f64::consts::FRAC_PI_2];
        let grid = Grid { width: 4, height: 2, resolution: 0.5, origin, cells: vec![Cell::Free; 8] };
        // along the image's x axis is along the world's y axis
        assert!((grid.point(4.0, 0.0) - Point::new(3.0, 1.0)).norm() < 1e-12);
        assert_eq!(grid.cell_at(Point::new(2.9, 0.9)), Some((3, 0)));
        assert_eq!(grid.cell_at(Point::new(2.1, -0.9)), Some((0, 1)));
        assert_eq!(grid.cell_at(Point::new(3.1, 0.0)), None);
    }
}
