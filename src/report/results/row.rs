//! A row of `results.csv`, and who gives rows.

use std::fmt;

use serde_json::Number;

use super::names::Metric;
use crate::report::error::ReportError;

/// What a row's number is summed over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::report) enum Scope {
    /// Of a machine, all measured frames; of a policy's own counts, all traced frames.
    Total,
    /// One measured or traced frame.
    Frame,
    /// One frame that warms a machine up: it is in no total.
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
    /// The number as JSON holds it.
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

/// What a number is of. What does not apply is absent.
#[derive(Clone, Copy, Debug)]
pub(in crate::report) struct Subject<'a> {
    /// The run's name.
    pub run: &'a str,
    /// The scene's name.
    pub scene: &'a str,
    /// What the number is summed over.
    pub scope: Scope,
    /// The frame, if it is of one.
    pub frame: Option<u32>,
    /// The culling policy.
    pub policy: &'a str,
    /// The machine and its fidelity level; none of what the tracer counted.
    pub machine: Option<(&'a str, &'a str)>,
    /// Values of the varied fields, in the order of [`Results::varied`]; absent is as in the machine's file.
    pub varied: &'a [Option<&'a str>],
}

/// One number.
#[derive(Clone, Copy, Debug)]
pub(in crate::report) struct Row<'a> {
    /// What it is of.
    pub of: Subject<'a>,
    /// The part of the machine, or the light.
    pub part: Option<&'a str>,
    /// The class of traffic, or the cause of a unit's cycles.
    pub class: Option<&'a str>,
    /// What the number is.
    pub metric: &'a Metric,
    /// The number; absent where a sample cannot tell it.
    pub value: Option<Amount>,
    /// Half the width of its 95 % interval: 0 of an exact number, absent where nobody knows.
    pub half_width: Option<f64>,
}

impl Row<'_> {
    /// Why the interval is absent, or the number with it.
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

/// Takes a row.
pub(in crate::report) type Take<'t> = dyn FnMut(&Row<'_>) -> Result<(), ReportError> + 't;

/// A report whose numbers are rows.
pub(in crate::report) trait Results {
    /// Fields of machines that differ from row to row, each a column of its own.
    fn varied(&self) -> Vec<&str> {
        Vec::new()
    }

    /// Hands over all rows, in a fixed order.
    ///
    /// # Errors
    /// A number has no form in JSON, or `take` fails.
    fn rows(&self, take: &mut Take<'_>) -> Result<(), ReportError>;
}
