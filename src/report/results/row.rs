//! A row of `results.csv`, and the trait of reports that have rows.

use std::fmt;

use serde_json::Number;

use super::names::Metric;
use crate::report::error::ReportError;

/// The frames over which a row's number is summed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::report) enum Scope {
    /// All measured frames for a machine's number; all traced frames for a policy's own counts.
    Total,
    /// One measured or traced frame.
    Frame,
    /// One warm-up frame of a machine: it is in no total.
    Warmup,
}

impl Scope {
    /// Its name in the file.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Total => "total",
            Self::Frame => "frame",
            Self::Warmup => "warmup",
        }
    }
}

/// A number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::report) enum Amount {
    /// A count.
    Whole(i128),
    /// A measure.
    Real(f64),
}

impl Amount {
    /// Converts a JSON number.
    pub(super) fn of(number: &Number) -> Self {
        let whole = number.as_u64().map(i128::from).or_else(|| number.as_i64().map(i128::from));
        whole.map_or_else(|| Self::Real(number.as_f64().unwrap_or(f64::NAN)), Self::Whole)
    }
}

#[cfg(feature = "parquet")]
impl Amount {
    /// The nearest `f64`.
    pub(super) fn as_f64(self) -> f64 {
        match self {
            Self::Whole(count) => count as f64,
            Self::Real(measure) => measure,
        }
    }
}

impl fmt::Display for Amount {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole(count) => count.fmt(f),
            Self::Real(measure) => measure.fmt(f),
        }
    }
}

/// The subject of a number. A field that does not apply is absent.
#[derive(Clone, Copy, Debug)]
pub(in crate::report) struct Subject<'a> {
    /// The run's name.
    pub run: &'a str,
    /// The scene's name.
    pub scene: &'a str,
    /// The frames over which the number is summed.
    pub scope: Scope,
    /// The frame, if the number belongs to one.
    pub frame: Option<u32>,
    /// The culling policy.
    pub policy: &'a str,
    /// The machine and its fidelity level; `None` for counts of the tracer.
    pub machine: Option<(&'a str, &'a str)>,
    /// Values of the varied fields, in the order of [`Results::varied`]; absent where the value is the machine file's
    /// own.
    pub varied: &'a [Option<&'a str>],
}

/// One number.
#[derive(Clone, Copy, Debug)]
pub(in crate::report) struct Row<'a> {
    /// Its subject.
    pub of: Subject<'a>,
    /// The part of the machine, or the light.
    pub part: Option<&'a str>,
    /// The class of traffic, or the cause of a unit's cycles.
    pub class: Option<&'a str>,
    /// The meaning of the number.
    pub metric: &'a Metric,
    /// The number; absent where a sample cannot estimate it.
    pub value: Option<Amount>,
    /// Half the width of its 95 % interval: 0 for an exact number, absent where it is not known.
    pub half_width: Option<f64>,
}

impl Row<'_> {
    /// The reason why the interval, or the number too, is absent.
    pub(super) fn reason(&self) -> &'static str {
        if self.half_width.is_some() {
            return "";
        }
        match self.of.machine.map_or("", |(_, fidelity)| fidelity.split('(').next().unwrap_or_default()) {
            "Bound" | "Profile" if self.value.is_some() => "the level gives bounds, and no interval",
            "Sampled" | "Auto" => "the sample has no interval of this",
            "predicted" => "the prediction has no interval of this",
            _ if self.value.is_none() => "the replay failed: the report says why",
            _ => "no interval was estimated",
        }
    }
}

/// A function that receives a row.
pub(in crate::report) type Take<'t> = dyn FnMut(&Row<'_>) -> Result<(), ReportError> + 't;

/// A report whose numbers are rows.
pub(in crate::report) trait Results {
    /// Fields of machines that differ between rows, each a column of its own.
    fn varied(&self) -> Vec<&str> {
        Vec::new()
    }

    /// Hands over all rows, in a fixed order.
    ///
    /// # Errors
    /// A number cannot be represented in JSON, or `take` fails.
    fn rows(&self, take: &mut Take<'_>) -> Result<(), ReportError>;
}
