//! The Gauss-Legendre rule of a strip, with an error estimate from the node values alone.

use std::num::NonZeroUsize;

use gauss_quad::GaussLegendre;

/// Nodes per strip: exact for polynomials up to degree 19, and accurate to about 1e-10 on the paper's whole
/// range.
pub(super) const NODES: usize = 10;

/// Equally spaced points, both ends included, at which a certificate is interpolated between the nodes.
pub(super) const FINE: usize = 17;

/// Values of a function at the nodes of a rule.
pub(super) type Samples = [f64; NODES];

/// A rule on `[-1, 1]`.
#[derive(Debug, Clone)]
pub(super) struct Rule {
    /// Ascending nodes.
    pub nodes: Samples,
    /// Weights, summing to 2.
    pub weights: Samples,
    /// Rows that give the Legendre coefficients of degree 3, 4, 8 and 9 of the interpolating polynomial.
    coefficients: [Samples; 4],
    /// Rows that give the interpolating polynomial at the fine points.
    interpolation: [Samples; FINE],
    /// Rows that give the coefficients of the interpolating polynomial, the constant one first.
    pub powers: [Samples; NODES],
}

/// Ascending Gauss-Legendre nodes on `[-1, 1]` with their weights.
pub(super) fn gauss_legendre(points: NonZeroUsize) -> Vec<(f64, f64)> {
    let mut pairs = GaussLegendre::new(points).as_node_weight_pairs().to_vec();
    pairs.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    pairs
}

/// Legendre polynomial of degree `degree` at `x`, by the three-term recurrence.
fn legendre(degree: usize, x: f64) -> f64 {
    let (mut previous, mut value) = (1.0, x);
    if degree == 0 {
        return 1.0;
    }
    for k in 1..degree {
        let k = k as f64;
        (previous, value) = (value, ((2.0 * k + 1.0) * x * value - k * previous) / (k + 1.0));
    }
    value
}

impl Rule {
    pub fn new() -> Self {
        let pairs = gauss_legendre(NonZeroUsize::new(NODES).unwrap_or(NonZeroUsize::MIN));
        let nodes: Samples = std::array::from_fn(|q| pairs[q].0);
        let weights: Samples = std::array::from_fn(|q| pairs[q].1);
        let coefficients = [3, 4, 8, 9].map(|degree| {
            let scale = (2 * degree + 1) as f64 / 2.0;
            std::array::from_fn(|q| scale * weights[q] * legendre(degree, nodes[q]))
        });
        let interpolation = std::array::from_fn(|point| {
            let x = -1.0 + 2.0 * point as f64 / (FINE - 1) as f64;
            std::array::from_fn(|q| {
                let others = (0..NODES).filter(|&other| other != q);
                others.map(|other| (x - nodes[other]) / (nodes[q] - nodes[other])).product()
            })
        });
        Self { nodes, weights, coefficients, interpolation, powers: powers(&nodes) }
    }

    /// Estimated error of the integral over `[-1, 1]` of the function with these node values.
    ///
    /// The Legendre coefficients of an analytic function decay geometrically. Their decay from degrees 3, 4
    /// to degrees 8, 9 is extrapolated by another one and a half times as many degrees.
    pub fn error(&self, values: &Samples) -> f64 {
        let [c3, c4, c8, c9] = self.coefficients.each_ref().map(|row| dot(row, values).abs());
        let (early, late) = (c3.max(c4), c8.max(c9));
        if late == 0.0 {
            return 0.0;
        }
        let rate = (late / early).min(1.0);
        late * rate * rate.sqrt()
    }

    /// Points between the nodes where a function that is positive at all nodes might fall below 0; none if it
    /// stays well above 0.
    ///
    /// The estimate uses the interpolating polynomial, its highest coefficients (its possible error) and its
    /// curvature (its possible dip between fine points). The ends themselves are left to the caller, who
    /// knows their values.
    pub fn dips(&self, values: &Samples) -> impl Iterator<Item = f64> + use<> {
        let lowest = values.iter().copied().fold(f64::INFINITY, f64::min);
        let highest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let clear = lowest > highest - lowest;
        let (mut fine, mut doubt) = ([0.0; FINE], 0.0);
        if !clear {
            fine = std::array::from_fn(|point| dot(&self.interpolation[point], values));
            doubt = dot(&self.coefficients[2], values).abs() + dot(&self.coefficients[3], values).abs();
        }
        let points = if clear { 1..1 } else { 1..FINE - 1 };
        points.filter_map(move |point| {
            let (before, here, after) = (fine[point - 1], fine[point], fine[point + 1]);
            let valley = (here <= before || point == 1) && (here <= after || point == FINE - 2);
            let curvature = before - 2.0 * here + after;
            let bottom =
                if curvature > 0.0 { (0.5 * (before - after) / curvature).clamp(-1.0, 1.0) } else { 0.0 };
            let near = here - 0.25 * curvature.abs() - doubt <= 0.0;
            (valley && near).then_some(-1.0 + 2.0 * (point as f64 + bottom) / (FINE - 1) as f64)
        })
    }
}

impl Rule {
    /// Coefficients of the polynomial through these values at the nodes, the constant one first.
    pub fn polynomial(&self, values: &Samples) -> Samples {
        std::array::from_fn(|power| dot(&self.powers[power], values))
    }
}

/// The coefficients of every node's Lagrange polynomial, by power.
pub(super) fn powers<const N: usize>(nodes: &[f64; N]) -> [[f64; N]; N] {
    let mut rows = [[0.0; N]; N];
    for (q, node) in nodes.iter().enumerate() {
        let mut product = [0.0; N];
        product[0] = 1.0;
        for (degree, other) in nodes.iter().enumerate().filter(|(r, _)| *r != q).map(|(_, n)| n).enumerate() {
            let scale = 1.0 / (node - other);
            for power in (0..=degree + 1).rev() {
                let lower = if power > 0 { product[power - 1] } else { 0.0 };
                product[power] = scale * (lower - other * product[power]);
            }
        }
        for power in 0..N {
            rows[power][q] = product[power];
        }
    }
    rows
}

fn dot(row: &Samples, values: &Samples) -> f64 {
    row.iter().zip(values).map(|(r, v)| r * v).sum()
}
