//! One perception parameter as a random variable: uniform or truncated normal between positive bounds.

use std::fmt;
use std::str::FromStr;

use crate::error::Error;
use crate::math::{self, erf, erfc};
use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

use super::perception::MAX_PERCEPTION;

/// Distribution of one perception parameter (`alpha` or `gamma`, dimensionless) on `[lower, upper]` with
/// `0 < lower < upper <= 10`.
///
/// Read and written as `uniform(lower,upper)` or `normal(mean,std,lower,upper)`, where mean and standard
/// deviation are those of the normal before truncation.
///
/// ```
/// use cocarry::preference::Marginal;
/// let alpha: Marginal = "uniform(0.55, 0.95)".parse()?;
/// assert_eq!(alpha, Marginal::uniform(0.55, 0.95)?);
/// assert_eq!(alpha.to_string(), "uniform(0.55,0.95)");
/// # Ok::<(), cocarry::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Marginal {
    lower: f64,
    upper: f64,
    shape: Shape,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Shape {
    Uniform,
    /// `mass` is the probability the untruncated normal has between the bounds, `from` the lower bound.
    Normal {
        mean: f64,
        std: f64,
        mass: f64,
        from: Standardised,
    },
}

/// A value in standard deviations from the mean, with both error functions there.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Standardised {
    z: f64,
    /// `erf(z / sqrt(2))`.
    erf: f64,
    /// `erfc(|z| / sqrt(2))`.
    erfc: f64,
}

impl Marginal {
    /// Uniform on `[lower, upper]`.
    pub fn uniform(lower: f64, upper: f64) -> Result<Self, Error> {
        if !(0.0 < lower && lower < upper && upper <= MAX_PERCEPTION) {
            return Err(Error::new(format!(
                "bounds [{lower}, {upper}] must satisfy 0 < lower < upper <= {MAX_PERCEPTION}"
            )));
        }
        Ok(Self { lower, upper, shape: Shape::Uniform })
    }

    /// The normal with this mean and standard deviation, truncated to `[lower, upper]`.
    pub fn truncated_normal(mean: f64, std: f64, lower: f64, upper: f64) -> Result<Self, Error> {
        let bounded = Self::uniform(lower, upper)?;
        if !(mean.is_finite() && std.is_finite() && std > 0.0) {
            return Err(Error::new(format!(
                "normal distribution with mean {mean} and standard deviation {std}: the mean must be finite, the deviation positive"
            )));
        }
        let from = Standardised::new((lower - mean) / std);
        let mass = from.mass_up_to((upper - mean) / std);
        // Below this the ratio of two probabilities loses its digits.
        if mass.is_nan() || mass < 1e-290 {
            return Err(Error::new(format!(
                "normal distribution with mean {mean} and standard deviation {std} has no probability in [{lower}, {upper}]"
            )));
        }
        Ok(Self { shape: Shape::Normal { mean, std, mass, from }, ..bounded })
    }

    /// Lower bound.
    pub fn lower(&self) -> f64 {
        self.lower
    }

    /// Upper bound.
    pub fn upper(&self) -> f64 {
        self.upper
    }

    /// Mean and standard deviation before truncation; `None` for a uniform.
    pub fn normal_shape(&self) -> Option<(f64, f64)> {
        match self.shape {
            Shape::Uniform => None,
            Shape::Normal { mean, std, .. } => Some((mean, std)),
        }
    }

    /// Probability of a value up to `value`: 0 at and below the lower bound, 1 at and above the upper one.
    pub fn cdf(&self, value: f64) -> f64 {
        if value <= self.lower {
            return 0.0;
        }
        if value >= self.upper {
            return 1.0;
        }
        match self.shape {
            Shape::Uniform => (value - self.lower) / (self.upper - self.lower),
            Shape::Normal { mean, std, mass, from } => {
                (from.mass_up_to((value - mean) / std) / mass).min(1.0)
            }
        }
    }

    /// Probability density at `value`, per unit of the parameter; 0 outside the bounds.
    pub fn density(&self, value: f64) -> f64 {
        if !(self.lower..=self.upper).contains(&value) {
            return 0.0;
        }
        match self.shape {
            Shape::Uniform => 1.0 / (self.upper - self.lower),
            Shape::Normal { mean, std, mass, .. } => normal_density((value - mean) / std) / (std * mass),
        }
    }

    /// The value up to which the probability is `probability` (clamped to `[0, 1]`): the inverse of
    /// [`cdf`](Self::cdf).
    pub fn quantile(&self, probability: f64) -> f64 {
        let probability = probability.clamp(0.0, 1.0);
        let (mut below, mut above) = (self.lower, self.upper);
        let mut value = below + probability * (above - below);
        if self.shape == Shape::Uniform {
            return value.min(above);
        }
        // Newton inside a shrinking bracket: the density may vanish in a far tail, where only bisection still
        // moves.
        for _ in 0..200 {
            let excess = self.cdf(value) - probability;
            if excess > 0.0 {
                above = value;
            } else {
                below = value;
            }
            let newton = value - excess / self.density(value);
            let next = if newton > below && newton < above { newton } else { 0.5 * (below + above) };
            if (next - value).abs() <= 4.0 * f64::EPSILON * value || next <= below || next >= above {
                return next.clamp(self.lower, self.upper);
            }
            value = next;
        }
        value
    }

    /// A random value, by inversion of one uniform draw from `rng`.
    pub fn sample<R: Rng + ?Sized>(&self, rng: &mut R) -> f64 {
        self.quantile(rng.random::<f64>())
    }

    /// Ascending points from bound to bound between which density and distribution function are smooth enough
    /// for one rule.
    pub(super) fn panels(&self) -> Vec<f64> {
        let mut cuts = vec![self.lower, self.upper];
        // Stevens' and Prelec's functions vary exponentially with the parameter, so a range over several
        // octaves needs more than one panel.
        let octaves = math::ln(self.upper / self.lower) / math::ln(3.0f64);
        let pieces = octaves.ceil().clamp(1.0, 64.0) as i32;
        for piece in 1..pieces {
            cuts.push(self.lower * math::pow(self.upper / self.lower, f64::from(piece) / f64::from(pieces)));
        }
        if let Shape::Normal { mean, std, .. } = self.shape
            && self.upper - self.lower > 6.0 * std
        {
            // A peak narrower than the range must not fall between the nodes of a rule.
            cuts.extend([-6.0, -2.0, 2.0, 6.0].map(|deviations| mean + deviations * std));
        }
        cuts.retain(|cut| (self.lower..=self.upper).contains(cut));
        cuts.sort_unstable_by(f64::total_cmp);
        cuts.dedup();
        cuts
    }
}

/// Standard normal density.
fn normal_density(z: f64) -> f64 {
    math::exp(-0.5 * z * z) / (2.0 * std::f64::consts::PI).sqrt()
}

impl Standardised {
    fn new(z: f64) -> Self {
        let scaled = z * std::f64::consts::FRAC_1_SQRT_2;
        Self { z, erf: erf(scaled), erfc: erfc(scaled.abs()) }
    }

    /// Probability a standard normal has from here to `to`, accurate in both tails and for short intervals.
    fn mass_up_to(&self, to: f64) -> f64 {
        let (width, middle) = (to - self.z, 0.5 * (self.z + to));
        if width * (1.0 + middle.abs()) < 1e-3 {
            // The difference of two distribution functions would cancel most digits.
            return width * normal_density(middle) * (1.0 + (middle * middle - 1.0) * width * width / 24.0);
        }
        let scaled = to * std::f64::consts::FRAC_1_SQRT_2;
        0.5 * if self.z > 0.0 {
            self.erfc - erfc(scaled)
        } else if to < 0.0 {
            erfc(-scaled) - self.erfc
        } else {
            erf(scaled) - self.erf
        }
    }
}

impl fmt::Display for Marginal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { lower, upper, shape } = self;
        match shape {
            Shape::Uniform => write!(f, "uniform({lower},{upper})"),
            Shape::Normal { mean, std, .. } => write!(f, "normal({mean},{std},{lower},{upper})"),
        }
    }
}

impl FromStr for Marginal {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let syntax = || {
            Error::new(format!(
                "`{text}` is not a distribution: write uniform(lower,upper) or normal(mean,std,lower,upper)"
            ))
        };
        let (name, rest) = text.trim().split_once('(').ok_or_else(syntax)?;
        let numbers = rest.strip_suffix(')').ok_or_else(syntax)?;
        let numbers: Vec<f64> = numbers
            .split(',')
            .map(|number| number.trim().parse())
            .collect::<Result<_, _>>()
            .map_err(|_| syntax())?;
        match (name.trim(), numbers.as_slice()) {
            ("uniform", &[lower, upper]) => Self::uniform(lower, upper),
            ("normal", &[mean, std, lower, upper]) => Self::truncated_normal(mean, std, lower, upper),
            _ => Err(syntax()),
        }
    }
}

impl TryFrom<String> for Marginal {
    type Error = Error;

    fn try_from(text: String) -> Result<Self, Error> {
        text.parse()
    }
}

impl From<Marginal> for String {
    fn from(marginal: Marginal) -> Self {
        marginal.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    fn examples() -> [Marginal; 5] {
        [
            Marginal::uniform(0.55, 0.95).unwrap(),
            Marginal::truncated_normal(0.75, 0.1, 0.55, 0.95).unwrap(),
            Marginal::truncated_normal(0.75, 1e6, 0.55, 0.95).unwrap(),
            Marginal::truncated_normal(0.75, 0.003, 0.5, 1.1).unwrap(),
            Marginal::truncated_normal(0.1, 0.05, 0.5, 1.1).unwrap(),
        ]
    }

    #[test]
    fn closed_form_density_is_the_slope_of_the_distribution() {
        for marginal in examples() {
            let range = marginal.upper() - marginal.lower();
            assert_eq!((marginal.cdf(marginal.lower()), marginal.cdf(marginal.upper())), (0.0, 1.0));
            for k in 1..200 {
                let (value, step) = (marginal.lower() + range * f64::from(k) / 200.0, 1e-6 * range);
                let slope = (marginal.cdf(value + step) - marginal.cdf(value - step)) / (2.0 * step);
                let density = marginal.density(value);
                assert!((slope - density).abs() < 1e-6 * (1.0 / range + density), "{marginal} at {value}");
            }
        }
    }

    #[test]
    fn closed_form_quantile_inverts_the_distribution() {
        for marginal in examples() {
            for k in 0..=50 {
                let probability = f64::from(k) / 50.0;
                let value = marginal.quantile(probability);
                assert!(
                    (marginal.cdf(value) - probability).abs() < 1e-12,
                    "{marginal} at {probability}: {value}"
                );
            }
        }
    }

    #[test]
    fn closed_form_wide_normal_is_uniform() {
        let [uniform, _, wide, ..] = examples();
        for value in [0.56, 0.7, 0.9] {
            assert!((uniform.cdf(value) - wide.cdf(value)).abs() < 1e-12);
        }
    }

    #[test]
    fn closed_form_samples_have_the_mean_and_stay_inside() {
        let marginal = Marginal::truncated_normal(0.75, 0.1, 0.55, 0.95).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let draws: Vec<f64> = (0..4000).map(|_| marginal.sample(&mut rng)).collect();
        assert!(draws.iter().all(|draw| (0.55..=0.95).contains(draw)));
        assert!((draws.iter().sum::<f64>() / 4000.0 - 0.75).abs() < 0.006);
    }

    #[test]
    fn closed_form_text_round_trip() {
        for marginal in examples() {
            assert_eq!(marginal.to_string().parse::<Marginal>().unwrap(), marginal);
        }
        assert_eq!(" normal( 0.75, 0.1 ,0.55,0.95 )".parse::<Marginal>().unwrap(), examples()[1]);
    }

    #[test]
    fn closed_form_bad_parameters_are_refused_with_their_numbers() {
        let refused = |text: &str| text.parse::<Marginal>().unwrap_err().to_string();
        for bounds in ["0.9, 0.5", "0, 0.5", "0.1, inf", "NaN, 1"] {
            let sentence = format!("bounds [{bounds}] must satisfy 0 < lower < upper <= 10");
            assert_eq!(refused(&format!("uniform({bounds})")), sentence);
        }
        let normal = "normal distribution with mean 0.7 and standard deviation 0";
        let shape = format!("{normal}: the mean must be finite, the deviation positive");
        assert_eq!(refused("normal(0.7,0,0.5,1)"), shape);
        assert!(refused("normal(-9,0.1,0.5,1)").ends_with("0.1 has no probability in [0.5, 1]"));
        for text in ["", "uniform", "uniform(1,2", "uniform(1)", "beta(1,2)", "uniform(a,b)", "normal(1,2)"] {
            let sentence = format!("`{text}` is not a distribution: write ");
            assert!(refused(text).starts_with(&sentence), "{}", refused(text));
        }
    }
}
