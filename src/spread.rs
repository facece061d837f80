//! A figure with a range of possible values.

use std::iter::Sum;
use std::ops::{Add, AddAssign, Mul};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The lowest, the typical and the highest value of a constant, in ascending order and each at least 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "Values")]
pub struct Spread {
    /// The lowest value.
    pub low: f64,
    /// The typical value. Figures in reports use it.
    pub typical: f64,
    /// The highest value.
    pub high: f64,
}

/// Values are finite: `TryFrom` refuses others.
impl Eq for Spread {}

/// The values as a file has them.
#[derive(Deserialize, JsonSchema)]
#[serde(rename = "Spread", deny_unknown_fields)]
struct Values {
    /// The lowest value.
    low: f64,
    /// The typical value. Figures in reports use it.
    typical: f64,
    /// The highest value.
    high: f64,
}

impl TryFrom<Values> for Spread {
    type Error = String;

    fn try_from(Values { low, typical, high }: Values) -> Result<Self, String> {
        if 0.0 <= low && low <= typical && typical <= high && high.is_finite() {
            Ok(Self { low, typical, high })
        } else {
            Err(format!("a range from {low} to {high} with {typical} as typical value: 0 <= low <= typical <= high"))
        }
    }
}

impl Spread {
    /// A range.
    pub const fn new(low: f64, typical: f64, high: f64) -> Self {
        Self { low, typical, high }
    }

    /// A range between two values; the typical one is their geometric mean.
    pub fn between(low: f64, high: f64) -> Self {
        Self { low, typical: (low * high).sqrt(), high }
    }
}

impl Mul<f64> for Spread {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self { low: self.low * factor, typical: self.typical * factor, high: self.high * factor }
    }
}

impl Add for Spread {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { low: self.low + other.low, typical: self.typical + other.typical, high: self.high + other.high }
    }
}

impl AddAssign for Spread {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sum for Spread {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), Add::add)
    }
}
