//! Hands over measured numbers as rows, by their declarations.

use serde::Serialize;
use serde_json::Value;

use super::columns::RESULTS_FILE;
use super::names::{Family, Metric, Node, Place};
use super::row::{Amount, Row, Subject, Take};
use crate::json;
use crate::report::error::ReportError;

/// Half the width of the interval of the number at a path.
type HalfWidth<'a> = &'a dyn Fn(&str) -> Option<f64>;

/// A subject whose numbers become rows, and their declarations.
#[derive(Clone, Copy)]
pub(in crate::report) struct Walk<'a> {
    /// The declarations.
    pub family: &'a Family,
    /// The subject of the numbers.
    pub of: Subject<'a>,
    /// The part for numbers whose path names none.
    pub part: Option<&'a str>,
    /// Their intervals.
    pub half_width: HalfWidth<'a>,
}

impl Walk<'_> {
    /// Hands over a row for each declared number of `measured`.
    ///
    /// # Errors
    /// `measured` cannot be represented in JSON, or `take` fails.
    pub(in crate::report) fn rows(&self, measured: &impl Serialize, take: &mut Take<'_>) -> Result<(), ReportError> {
        let failed = |source| ReportError::Numbers { file: RESULTS_FILE, source };
        let value = json::value(measured).map_err(failed)?;
        self.descend(&value, self.family.root(), &mut Way::default(), take)
    }

    fn descend<'v>(
        &self,
        value: &'v Value,
        node: &Node,
        way: &mut Way<'v>,
        take: &mut Take<'_>,
    ) -> Result<(), ReportError> {
        let mut below = |word: &'v str, value: &'v Value| {
            let Some((node, is_name)) = node.follow(word) else { return Ok(()) };
            way.path.push(word);
            if is_name {
                way.names.push(word);
            }
            let done = self.descend(value, node, way, take);
            way.path.pop();
            if is_name {
                way.names.pop();
            }
            done
        };
        match value {
            Value::Object(fields) => fields.iter().try_for_each(|(word, value)| below(word, value)),
            Value::Array(values) => PLACES.into_iter().zip(values).try_for_each(|(word, value)| below(word, value)),
            Value::Number(number) => match &node.metric {
                Some(metric) => take(&self.row(metric, way, Some(Amount::of(number)))),
                None => Ok(()),
            },
            Value::Null | Value::Bool(_) | Value::String(_) => Ok(()),
        }
    }

    fn row<'r>(&'r self, metric: &'r Metric, way: &Way<'r>, value: Option<Amount>) -> Row<'r> {
        let name = |place| {
            let at = metric.places.iter().position(|own| *own == place);
            at.and_then(|at| way.names.get(at)).copied()
        };
        Row {
            of: self.of,
            part: name(Place::Part).or(self.part),
            class: metric.class.or_else(|| name(Place::Class)),
            metric,
            value,
            half_width: (self.half_width)(&way.path.join(".")),
        }
    }
}

/// The path to a number.
#[derive(Default)]
struct Way<'v> {
    /// All words of the path.
    path: Vec<&'v str>,
    /// The words that are names.
    names: Vec<&'v str>,
}

/// Names for the places of a list. The only declared list holds the three replays of a split.
const PLACES: [&str; 3] = ["without_culling", "free_words", "as_it_is"];
