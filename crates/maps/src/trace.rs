//! Outlines of cells along the cells' sides.

/// A corner of cells: numbers of cells from the lower left corner of the grid.
pub(crate) type Vertex = [i32; 2];

/// Takes cells out until no two of them meet at a corner only. Their outlines then do not touch themselves
/// or each other.
pub(crate) fn without_pinches(is_inside: &mut [bool], width: usize) {
    let height = is_inside.len() / width;
    let mut queue: Vec<(usize, usize)> =
        (1..height).flat_map(|row| (1..width).map(move |column| (column, row))).rev().collect();
    let mut looks = 0;
    while let Some((column, row)) = queue.pop() {
        looks += 1;
        let [low_left, low_right] = [(row - 1) * width + column - 1, (row - 1) * width + column];
        let [high_left, high_right] = [low_left + width, low_right + width];
        let cells = [low_left, low_right, high_left, high_right].map(|i| is_inside[i]);
        let out = match cells {
            [true, false, false, true] => low_left,
            [false, true, true, false] => low_right,
            _ => continue,
        };
        is_inside[out] = false;
        let (column, row) = (out % width, out / width);
        for (column, row) in [(column, row), (column + 1, row), (column, row + 1), (column + 1, row + 1)] {
            if (1..width).contains(&column) && (1..height).contains(&row) {
                queue.push((column, row));
            }
        }
    }
    debug_assert!(looks < 10 * is_inside.len().max(1));
}

/// The outlines of the cells inside, which are on their left, by their corners.
pub(crate) fn rings(is_inside: &[bool], width: usize) -> Vec<Vec<Vertex>> {
    let height = is_inside.len() / width;
    let inside = |column: i32, row: i32| {
        (0..width as i32).contains(&column)
            && (0..height as i32).contains(&row)
            && is_inside[row as usize * width + column as usize]
    };
    let mut seen = vec![false; is_inside.len()];
    let mut rings = Vec::new();
    for row in 0..height as i32 {
        for column in 0..width as i32 {
            let is_lower_side = inside(column, row) && !inside(column, row - 1);
            if is_lower_side && !seen[row as usize * width + column as usize] {
                rings.push(ring([column, row], width, &inside, &mut seen));
            }
        }
    }
    rings
}

/// The outline that begins with the lower side of a cell.
fn ring(first: Vertex, width: usize, inside: &impl Fn(i32, i32) -> bool, seen: &mut [bool]) -> Vec<Vertex> {
    const AHEAD: [Vertex; 4] = [[1, 0], [0, 1], [-1, 0], [0, -1]];
    let mut corners = Vec::new();
    let (mut at, mut heading) = (first, 0);
    loop {
        if heading == 0 {
            let side = &mut seen[at[1] as usize * width + at[0] as usize];
            if std::mem::replace(side, true) {
                break;
            }
        }
        at = [at[0] + AHEAD[heading][0], at[1] + AHEAD[heading][1]];
        // the cells ahead, to the left and to the right, by their lower left corners
        let [left, right]: [Vertex; 2] = match heading {
            0 => [[0, 0], [0, -1]],
            1 => [[-1, 0], [0, 0]],
            2 => [[-1, -1], [-1, 0]],
            _ => [[0, -1], [-1, -1]],
        };
        let is_inside = |by: Vertex| inside(at[0] + by[0], at[1] + by[1]);
        let turn = match (is_inside(left), is_inside(right)) {
            (false, _) => 1,
            (true, true) => 3,
            (true, false) => 0,
        };
        if turn != 0 {
            corners.push(at);
            heading = (heading + turn) % 4;
        }
    }
    corners
}

/// Twice the area within a ring: positive around cells inside, negative around cells outside.
pub(crate) fn doubled_area(ring: &[Vertex]) -> i64 {
    let n = ring.len();
    let cross = |[a, b]: Vertex, [c, d]: Vertex| i64::from(a) * i64::from(d) - i64::from(b) * i64::from(c);
    (0..n).map(|i| cross(ring[i], ring[(i + 1) % n])).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The cells of a picture, its first line on top.
    fn cells(picture: &str) -> (Vec<bool>, usize) {
        let lines: Vec<&str> = picture.split_whitespace().collect();
        (lines.iter().rev().flat_map(|line| line.chars().map(|c| c == '.')).collect(), lines[0].len())
    }

    #[test]
    fn closed_form_a_room_with_a_pillar() {
        let (is_inside, width) = cells("###### #....# #.#..# #....# ######");
        let rings = rings(&is_inside, width);
        assert_eq!(rings.len(), 2);
        assert_eq!(rings[0], [[5, 1], [5, 4], [1, 4], [1, 1]]);
        assert_eq!(rings.iter().map(|ring| doubled_area(ring)).collect::<Vec<_>>(), [24, -2]);
    }

    #[test]
    fn closed_form_cells_up_to_the_border() {
        let (is_inside, width) = cells(".. .#");
        assert_eq!(rings(&is_inside, width), [[[1, 0], [1, 1], [2, 1], [2, 2], [0, 2], [0, 0]]]);
    }

    #[test]
    fn property_outlines_without_pinches_pass_every_corner_once() {
        for seed in 0_u64..50 {
            let width = 12;
            let mut state = seed;
            let mut is_inside: Vec<bool> = (0..width * 9)
                .map(|_| {
                    state =
                        state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                    (state >> 33) % 3 > 0
                })
                .collect();
            let before = is_inside.clone();
            without_pinches(&mut is_inside, width);
            assert!(is_inside.iter().zip(&before).all(|(after, before)| !after || *before));
            let rings = rings(&is_inside, width);
            let mut corners: Vec<&Vertex> = rings.iter().flatten().collect();
            let count = corners.len();
            corners.sort_unstable();
            corners.dedup();
            assert_eq!(corners.len(), count, "a corner is passed twice");
            let area: i64 = rings.iter().map(|ring| doubled_area(ring)).sum();
            assert_eq!(area, 2 * is_inside.iter().filter(|inside| **inside).count() as i64);
        }
    }
}
