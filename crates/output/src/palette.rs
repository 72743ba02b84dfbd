//! The colours of every picture, scene and player, in one place: options, risk, and who is who.
//!
//! The colours of the options differ for readers with any colour vision, and the first four in greyscale too.

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

/// The colour of an option, by its index: red, green and blue.
pub fn option_colour(option: usize) -> [u8; 3] {
    COLOURS[option % COLOURS.len()]
}

/// The number of different colours of options.
pub const fn option_colours() -> usize {
    COLOURS.len()
}

/// The dash pattern of an option's line, by its index: lengths of dashes and gaps, px; empty is solid. Eight
/// options differ in colour and in dash pattern, 64 in one of the two.
pub fn option_dash(option: usize) -> &'static [f64] {
    let n = COLOURS.len();
    DASHES[(option + option / n) % n]
}

/// The colour of an opening where risk is not shown.
pub const PLAIN_OPENING: &str = "#cdebd0";

/// The colours of risk at 0, 1/4, ..., 1: viridis, whose lightness falls evenly.
pub const RISK_COLOURS: [[u8; 3]; 5] =
    [[253, 231, 37], [94, 201, 98], [33, 145, 140], [59, 82, 139], [68, 1, 84]];

/// The colour of a risk from 0 (light) to 1 (dark).
pub fn risk_colour(risk: f64) -> [u8; 3] {
    let place = risk.clamp(0.0, 1.0) * (RISK_COLOURS.len() - 1) as f64;
    let low = (place as usize).min(RISK_COLOURS.len() - 2);
    let part = place - low as f64;
    let mix = |i: usize| {
        let [from, to] = [RISK_COLOURS[low][i], RISK_COLOURS[low + 1][i]].map(f64::from);
        (from + part * (to - from)).round() as u8
    };
    [mix(0), mix(1), mix(2)]
}

/// The robot, where its URDF gives no colour.
pub const ROBOT: [u8; 3] = [212, 217, 223];
/// The carried object.
pub const OBJECT: [u8; 3] = [185, 130, 63];
/// The human: shirt, hair, skin, trousers, shoes.
pub const HUMAN: [u8; 3] = [47, 95, 158];
/// See [`HUMAN`].
pub const HAIR: [u8; 3] = [59, 42, 32];
/// See [`HUMAN`].
pub const SKIN: [u8; 3] = [217, 165, 131];
/// See [`HUMAN`].
pub const TROUSERS: [u8; 3] = [51, 60, 77];
/// See [`HUMAN`].
pub const SHOES: [u8; 3] = [29, 32, 38];
/// The path walked, and letters.
pub const INK: [u8; 3] = [26, 26, 26];

/// A colour as `#rrggbb`.
pub fn hex([red, green, blue]: [u8; 3]) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use cocarry::math;

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
    fn risk_is_coloured_without_steps() {
        let colours = [-1.0, 0.25, 2.0, 0.125].map(|risk| hex(risk_colour(risk)));
        assert_eq!(colours, ["#fde725", "#5ec962", "#440154", "#aed844"]);
    }
}
