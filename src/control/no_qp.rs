//! In place of `qp.rs` on WebAssembly without a system: clarabel reads a clock, and only JavaScript has one.

/// Finds no minimum. The active-set method solves almost all programs; where it does not converge, eq. (7) is
/// unsolved here.
#[derive(Clone, Debug, Default)]
pub struct Qp;

impl Qp {
    /// Returns false.
    pub fn minimise(&mut self, _d: &[f64], _c: &[f64], _minimiser: &mut Vec<f64>) -> bool {
        false
    }
}
