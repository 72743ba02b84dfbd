//! The palette of every picture: colours, dash patterns and line widths, and the colours of risk.

use super::{px, stroke};
use crate::geometry::Point;
use svg::node::element::Group;

/// Colours of frames and letters, and of the paper.
pub(in super::super) const INK: &str = "#1a1a1a";
pub(in super::super) const PAPER: &str = "#ffffff";
/// Background greys from light to dark: alternate rows, areas, grids, faint lines and marks.
pub(in super::super) const STRIPE: &str = "#f3f3f3";
pub(in super::super) const BAND: &str = "#e6e6e6";
pub(in super::super) const GRID: &str = "#d6d6d6";
pub(in super::super) const FAINT: &str = "#8a8a8a";
/// Width of faint lines, px.
pub(in super::super) const FAINT_WIDTH: f64 = 1.2;

/// Okabe and Ito's colours, which readers with any colour vision can distinguish. Dark red replaces yellow,
/// which is invisible on white paper. In this order, the first four differ in grey as well.
const COLOURS: [[u8; 3]; 8] = [
    [0, 114, 178],
    [230, 159, 0],
    [136, 34, 85],
    [0, 158, 115],
    [86, 180, 233],
    [213, 94, 0],
    [204, 121, 167],
    [17, 17, 17],
];

/// Dash patterns for a line of medium width: lengths of dashes and gaps, px. Empty is solid.
const DASHES: [&[f64]; 8] = [
    &[],
    &[14.0, 6.0],
    &[4.0, 5.0],
    &[17.0, 5.0, 4.0, 5.0],
    &[9.0, 5.0],
    &[17.0, 5.0, 4.0, 5.0, 4.0, 5.0],
    &[26.0, 7.0],
    &[13.0, 4.0, 6.0, 4.0],
];

/// The style that distinguishes one of several lines. An option has the style of its index in every picture.
#[derive(Clone, Copy)]
pub(in super::super) struct LineStyle {
    colour: [u8; 3],
    dash: &'static [f64],
}

impl LineStyle {
    /// The style of this index. Eight styles differ in colour and in dash pattern, 64 in one of the two.
    pub fn of(index: usize) -> Self {
        let n = COLOURS.len();
        Self { colour: COLOURS[index % n], dash: DASHES[(index + index / n) % n] }
    }

    pub fn colour(self) -> String {
        hex(self.colour)
    }

    pub fn dash(self) -> &'static [f64] {
        self.dash
    }

    /// The colour mixed with white, for areas under letters.
    pub fn tint(self) -> String {
        hex(self.colour.map(|c| 255 - (255 - c) / 4))
    }

    /// A line with a white edge, so that lines below it stay readable.
    pub fn draw(self, points: &[Point], width: f64) -> Group {
        let factor = (width / 4.5).clamp(0.75, 1.5);
        let dash: Vec<String> = self.dash.iter().map(|d| px(d * factor)).collect();
        let lines = [(PAPER.to_owned(), width + 0.8), (self.colour(), width)];
        lines.into_iter().fold(Group::new(), |group, (colour, width)| {
            let line = stroke(points, &colour, width);
            group.add(if dash.is_empty() { line } else { line.set("stroke-dasharray", dash.join(" ")) })
        })
    }
}

/// Width of one of several lines, px. Each is narrower than the previous one, so that coinciding lines remain
/// visible.
pub(in super::super) fn width_by_rank(index: usize, of: usize) -> f64 {
    let narrowed = index as f64 / of.saturating_sub(1).max(3) as f64;
    6.4 - 4.2 * narrowed
}

/// Line widths, px, that grow with probability and all differ.
pub(in super::super) fn widths_by_probability(probabilities: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut widths: Vec<f64> = probabilities.map(|p| 1.4 + 9.0 * p.min(1.0)).collect();
    let mut order: Vec<usize> = (0..widths.len()).collect();
    // of equally wide lines the later one is narrower
    order.sort_by(|&a, &b| widths[a].total_cmp(&widths[b]).then(b.cmp(&a)));
    let step = (8.0 / widths.len().max(1) as f64).min(1.6);
    for pair in order.windows(2) {
        widths[pair[1]] = widths[pair[1]].max(widths[pair[0]] + step);
    }
    widths
}

/// The colours of risk at 0, 1/4, ..., 1: viridis, whose lightness falls evenly.
pub(in super::super) const RISK_COLOURS: [[u8; 3]; 5] =
    [[253, 231, 37], [94, 201, 98], [33, 145, 140], [59, 82, 139], [68, 1, 84]];

/// The colour of a risk from 0 (light) to 1 (dark).
pub(in super::super) fn risk_colour(risk: f64) -> String {
    let place = risk.clamp(0.0, 1.0) * (RISK_COLOURS.len() - 1) as f64;
    let low = (place as usize).min(RISK_COLOURS.len() - 2);
    let part = place - low as f64;
    let mix = |i: usize| {
        let [from, to] = [RISK_COLOURS[low][i], RISK_COLOURS[low + 1][i]].map(f64::from);
        (from + part * (to - from)).round() as u8
    };
    hex([mix(0), mix(1), mix(2)])
}

fn hex([red, green, blue]: [u8; 3]) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;

    /// The perception of red, green and blue light by readers with full colour vision and by those without
    /// one kind of cone (Machado, Oliveira and Fernandes 2009).
    const READERS: [[[f64; 3]; 3]; 4] = [
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
    ];

    /// CIELAB of a colour as a reader sees it.
    fn seen(colour: [u8; 3], reader: &[[f64; 3]; 3]) -> [f64; 3] {
        let light = colour.map(|c| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { math::pow((c + 0.055) / 1.055, 2.4) }
        });
        let sum = |row: &[f64; 3], v: [f64; 3]| row.iter().zip(v).map(|(a, b)| a * b).sum::<f64>();
        let light = [0, 1, 2].map(|i| sum(&reader[i], light).clamp(0.0, 1.0));
        const XYZ: [[f64; 3]; 3] =
            [[0.433953, 0.376219, 0.189828], [0.212673, 0.715152, 0.072175], [0.017756, 0.109469, 0.872775]];
        let [x, y, z] = [0, 1, 2].map(|i| {
            let v = sum(&XYZ[i], light);
            if v > 0.008856 { math::pow(v, 1.0 / 3.0) } else { 7.787 * v + 16.0 / 116.0 }
        });
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    #[test]
    fn every_reader_tells_the_colours_apart_and_the_first_four_in_grey() {
        for (i, a) in COLOURS.iter().enumerate() {
            for (j, b) in COLOURS[..i].iter().enumerate() {
                for reader in &READERS {
                    let (a, b) = (seen(*a, reader), seen(*b, reader));
                    let difference = a.iter().zip(b).map(|(a, b)| math::squared(a - b)).sum::<f64>().sqrt();
                    assert!(difference > 15.0, "{i} {j}: {difference}");
                }
                let lightness = seen(*a, &READERS[0])[0] - seen(*b, &READERS[0])[0];
                assert!(i >= 4 || lightness.abs() > 10.0, "{i} {j}: {lightness}");
            }
            assert!(seen(*a, &READERS[0])[0] < 75.0, "too light for white paper");
        }
        let lightness = RISK_COLOURS.map(|c| seen(c, &READERS[0])[0]);
        assert!(lightness.windows(2).all(|pair| pair[1] < pair[0] - 10.0), "{lightness:?}");
    }

    #[test]
    fn wider_lines_are_more_probable_and_no_two_are_alike() {
        let widths = widths_by_probability([0.1, 0.5, 0.5, 0.0].into_iter());
        assert!(widths[1] > widths[2] && widths[2] > widths[0] && widths[0] > widths[3], "{widths:?}");
    }

    #[test]
    fn risk_is_coloured_without_steps() {
        assert_eq!(
            [risk_colour(-1.0), risk_colour(0.25), risk_colour(2.0)],
            ["#fde725", "#5ec962", "#440154"]
        );
        assert_eq!(risk_colour(0.125), "#aed844");
    }
}
