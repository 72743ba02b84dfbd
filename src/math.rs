//! Transcendental functions with the same bits on every machine.
//!
//! The standard library's `f64::{sin, exp, powf, ...}` are the system's: their last bits depend on its C library and, through it, on the
//! processor. All floors take these functions from here, where they are the `libm` crate's, which is plain arithmetic; `clippy.toml` forbids
//! the standard library's. Addition, multiplication, division, `sqrt`, `mul_add` and remainders are exact everywhere and stay as they are.

pub use libm::{
    acos, asin, atan2, cos, erf, erfc, exp, expm1 as exp_m1, hypot, log as ln, log1p as ln_1p, log10, pow,
    sin,
};

/// Sine and cosine of `angle` (rad).
#[inline]
pub fn sin_cos(angle: f64) -> (f64, f64) {
    libm::sincos(angle)
}

/// `x` times itself.
#[inline]
pub fn squared(x: f64) -> f64 {
    x * x
}
