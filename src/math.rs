//! Transcendental functions with the same bits on every machine.
//!
//! The standard library's `f64::{sin, exp, powf, ...}` call the system's C library, whose last bits depend on
//! the machine. All floors use the functions of this module instead. They come from the `libm` crate, which
//! is plain arithmetic. `clippy.toml` forbids the standard library's. Addition, multiplication, division,
//! `sqrt`, `mul_add` and remainders are exact everywhere and stay as they are.

pub use libm::{
    acos, asin, atan2, cos, erf, erfc, exp, expm1 as exp_m1, hypot, log as ln, log1p as ln_1p, log10, pow,
    sin,
};

/// Sine and cosine of `angle` (rad).
#[inline]
pub fn sin_cos(angle: f64) -> (f64, f64) {
    libm::sincos(angle)
}

/// The square of `x`.
#[inline]
pub fn squared(x: f64) -> f64 {
    x * x
}

/// Every function of this module evaluated at or near `x`: input to the arithmetic stamp.
pub fn sample(x: f64) -> [f64; 17] {
    let (positive, within) = (x.abs() + 0.1, x / (1.0 + x.abs()));
    let (sine, cosine) = sin_cos(1e3 * x);
    [
        sin(x),
        cos(x),
        sine,
        cosine,
        asin(within),
        acos(within),
        atan2(x, 1.7),
        exp(0.1 * x),
        exp_m1(within),
        ln(positive),
        ln_1p(positive),
        log10(positive),
        pow(positive, within),
        hypot(x, 1.3),
        erf(within),
        erfc(0.01 * x),
        ln_gamma(positive),
    ]
}

/// ln |Gamma(x)|.
pub fn ln_gamma(x: f64) -> f64 {
    libm::lgamma(x)
}
