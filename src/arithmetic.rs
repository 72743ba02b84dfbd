//! The stamp of this machine's arithmetic: a checksum of the results of fixed calculations.
//!
//! Recordings, sweep rows and snapshots carry the stamp. Machines with the same stamp and the same program
//! version give the same bits. A different stamp (another processor architecture, compiler or dependency
//! version) means that last bits may differ, and comparisons say so. The stamp covers every function of
//! [`math`], nalgebra's rotations and decompositions, a quadratic program solved by clarabel, and rapier's
//! steps of bodies with contacts and of a multibody.

use crate::control::Qp;
use crate::geometry::rotation_vector;
use crate::math;
use crate::simulation::sample;
use nalgebra::{Matrix3, Matrix6, Rotation3, UnitQuaternion, Vector3};
use std::sync::OnceLock;

/// The stamp: eight hexadecimal digits. It is calculated once and takes about a millisecond.
pub fn stamp() -> &'static str {
    static STAMP: OnceLock<String> = OnceLock::new();
    STAMP.get_or_init(|| {
        let results = calculations();
        digest(results.iter().flat_map(|(_, results)| results))
    })
}

/// Digests of parts of the stamp by their names, and of [`PROGRAMS`] more quadratic programs, some of which have
/// dependent rows: what two machines of different stamps have in common. It takes tens of milliseconds.
///
/// The principal inertias are the only part with the system's functions. The WebAssembly module has the same digests
/// as this program of all others.
pub fn parts() -> Vec<(&'static str, String)> {
    let programs = ("programs", (0..PROGRAMS).flat_map(program).collect());
    calculations()
        .into_iter()
        .chain([programs])
        .map(|(name, results)| (name, digest(results.iter())))
        .collect()
}

/// The number of quadratic programs of [`parts`].
pub const PROGRAMS: usize = 200;

/// The results of the stamp, in parts.
fn calculations() -> [(&'static str, Vec<f64>); 6] {
    [
        ("functions", functions()),
        ("linear algebra", linear_algebra()),
        ("quadratic program", quadratic_program()),
        ("motion", sample::moved()),
        ("principal inertias", sample::principal_inertias()),
        ("hull", sample::hull()),
    ]
}

fn digest<'a>(results: impl Iterator<Item = &'a f64>) -> String {
    let mut checksum = crc32fast::Hasher::new();
    for result in results {
        // the bits of a NaN carry no meaning
        let bits = if result.is_nan() { u64::MAX } else { result.to_bits() };
        checksum.update(&bits.to_le_bytes());
    }
    format!("{:08x}", checksum.finalize())
}

/// Arguments from tiny to large, of both signs. No two implementations are likely to round all of them alike.
fn arguments() -> impl Iterator<Item = f64> {
    (-60..=60).map(|i| f64::from(i) * (0.037 + f64::from(i * i) * 0.0071))
}

fn functions() -> Vec<f64> {
    arguments().flat_map(math::sample).collect()
}

fn linear_algebra() -> Vec<f64> {
    let mut results = Vec::new();
    for x in arguments().step_by(10) {
        let rotation = Rotation3::new(Vector3::new(0.3 * x, 1.0 - x, 0.7));
        results.extend(rotation_vector(&rotation).iter());
        let quaternion = UnitQuaternion::from_rotation_matrix(&rotation);
        results.extend(quaternion.powf(0.3).coords.iter());
        let symmetric = Matrix3::from_fn(|i, j| math::sin(x + (i + j) as f64));
        results.extend(symmetric.symmetric_eigenvalues().iter());
        let matrix = Matrix6::from_fn(|i, j| math::cos(x * (1 + i) as f64 - (j * j) as f64));
        results.extend(matrix.singular_values().iter());
        results.extend(matrix.try_inverse().unwrap_or_default().iter());
    }
    results
}

fn quadratic_program() -> Vec<f64> {
    const N: usize = 6;
    let entry = |i: usize, j: usize| math::cos((i * j) as f64) + if i == j { 6.0 } else { 0.0 };
    let matrix: Vec<f64> = (0..N * N).map(|k| entry(k / N, k % N)).collect();
    let linear: Vec<f64> = (0..N).map(|i| math::sin(3.0 * i as f64) + 0.2).collect();
    minimiser(&matrix, &linear)
}

/// The minimiser of a program of 1 to 40 multipliers; every third has half as many independent rows.
fn program(number: usize) -> Vec<f64> {
    let n = 1 + number % 40;
    let rank = if number.is_multiple_of(3) { n.div_ceil(2) } else { n };
    let root = |i: usize, k: usize| math::sin((1 + i * rank + k) as f64 * (1.0 + 0.37 * number as f64));
    let product = |i: usize, j: usize| (0..rank).map(|k| root(i, k) * root(j, k)).sum::<f64>();
    let matrix: Vec<f64> = (0..n * n).map(|k| product(k / n, k % n)).collect();
    // in the matrix's range, or there would be no minimum
    let point = |j: usize| math::cos((1 + j) as f64 * (0.3 + number as f64));
    let linear: Vec<f64> = (0..n).map(|i| (0..n).map(|j| matrix[i * n + j] * point(j)).sum()).collect();
    minimiser(&matrix, &linear)
}

/// The minimiser of a quadratic program; NaN where there is none.
fn minimiser(matrix: &[f64], linear: &[f64]) -> Vec<f64> {
    let mut minimiser = Vec::new();
    match Qp::default().minimise(matrix, linear, &mut minimiser) {
        true => minimiser,
        false => vec![f64::NAN],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_has_results_and_one_bit_makes_another_stamp() {
        let parts = calculations().map(|(_, results)| results);
        for (part, least) in parts.iter().zip([1000, 300, 6, 12, 280, 7]) {
            let finite = part.iter().filter(|value| value.is_finite()).count();
            assert!(finite >= least && finite * 10 > part.len() * 9, "{finite} of {}", part.len());
        }
        let solved =
            (0..PROGRAMS).filter(|number| program(*number).iter().all(|value| value.is_finite())).count();
        assert_eq!(solved, PROGRAMS);
        let mut results = parts.concat();
        assert_eq!(digest(results.iter()), stamp());
        for k in (0..results.len()).step_by(97) {
            let before = results[k];
            results[k] = f64::from_bits(before.to_bits() ^ 1);
            assert!(results[k].is_nan() || digest(results.iter()) != stamp(), "value {k}");
            results[k] = before;
        }
    }
}
