//! What a sweep found.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::values::shown;
use crate::quantity::{Bytes, Resolution};
use crate::report::format::{or_absent, percent, words};
use crate::report::grid::Grid;
use crate::report::split::Split;
use crate::stats::{MachineStats, TrafficClass};
use crate::stream::Totals;

/// A whole sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct SweepSummary {
    /// The experiment's name.
    pub experiment: String,
    /// The scene's name.
    pub scene: String,
    /// The fidelity level of the replays.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fidelity: Option<String>,
    /// Numbers of the frames.
    pub frames: Vec<u32>,
    /// Size of the pictures.
    pub resolution: Resolution,
    /// Values of the varied fields in the machines' files.
    #[serde(default)]
    pub own: Vec<Own>,
    /// The points, in the order of the files.
    pub points: Vec<SweepPoint>,
}

/// A field of the machine that a point sets.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Change {
    /// Its path.
    pub field: String,
    /// Its value.
    pub value: String,
}

/// A machine's own value of a field that is varied.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Own {
    /// The machine's name.
    pub machine: String,
    /// The field's path.
    pub field: String,
    /// Its value.
    pub value: String,
}

/// A machine and a policy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct SweepPoint {
    /// The machine's name.
    pub machine: String,
    /// The policy's name.
    pub policy: String,
    /// What differs from the machine's file.
    pub changes: Vec<Change>,
    /// What was saved and paid.
    #[serde(flatten)]
    pub split: Split,
    /// DRAM bytes by class, as it is.
    pub bytes: BTreeMap<TrafficClass, Bytes>,
    /// Hits over accesses, a cache and class of traffic, as it is.
    pub hit_rate: BTreeMap<String, BTreeMap<TrafficClass, f64>>,
}

impl SweepPoint {
    /// The point of three measurements (without culling, with free words, as it is) of a stream that holds `totals`.
    pub(crate) fn new(
        machine: &str,
        policy: &str,
        changes: Vec<Change>,
        measured: [&MachineStats; 3],
        totals: &Totals,
    ) -> Self {
        let [.., real] = measured;
        Self {
            machine: machine.into(),
            policy: policy.into(),
            changes,
            split: Split::new(measured, totals),
            bytes: real.bytes.get("dram").cloned().unwrap_or_default(),
            hit_rate: real.hit_rates(),
        }
    }

    /// What differs, in words.
    pub(crate) fn label(&self) -> String {
        label(&self.changes)
    }
}

/// What differs from a machine's file, in words.
pub(crate) fn label(changes: &[Change]) -> String {
    if changes.is_empty() {
        return "baseline".into();
    }
    let short = |change: &Change| {
        let field = change.field.strip_prefix("shadow_cache.").unwrap_or(&change.field);
        format!("{field}: {}", shown(&change.field, &change.value))
    };
    changes.iter().map(short).collect::<Vec<_>>().join(", ")
}

/// The columns that name a point.
pub(super) const NAMES: [&str; 3] = ["machine", "policy", "point"];

impl SweepPoint {
    /// The cells under [`NAMES`].
    pub(crate) fn names(&self) -> [String; 3] {
        [self.machine.clone(), self.policy.clone(), self.label()]
    }
}

/// The points as a table.
pub(crate) fn grid(summary: &SweepSummary) -> Grid {
    let columns = Split::COLUMNS;
    let row = |point: &SweepPoint| {
        point.names().into_iter().chain(columns.map(|(_, text)| text(&point.split))).collect::<Vec<_>>()
    };
    let head = NAMES.into_iter().chain(columns.map(|(name, _)| name)).map(Into::into);
    Grid { head: head.collect(), names: 3, rows: summary.points.iter().map(row).collect() }
}

/// Hit rates of every cache that any point has, by class of traffic.
pub(super) fn hit_rates(summary: &SweepSummary) -> Vec<(String, Grid)> {
    let of_cache = |cache: &String| {
        let classes =
            |point: &SweepPoint| point.hit_rate.get(cache).into_iter().flat_map(BTreeMap::keys).copied().collect();
        let classes: BTreeSet<TrafficClass> =
            summary.points.iter().flat_map(|point| -> Vec<_> { classes(point) }).collect();
        let row = |point: &SweepPoint| {
            let rate = |class| point.hit_rate.get(cache)?.get(class).copied();
            point.names().into_iter().chain(classes.iter().map(|class| or_absent(rate(class), percent))).collect()
        };
        let named = classes.iter().map(|class| words(class.name()));
        let head = NAMES.into_iter().map(str::to_owned).chain(named).collect();
        (words(cache), Grid { head, names: 3, rows: summary.points.iter().map(row).collect() })
    };
    let used = summary.points.iter().flat_map(|point| &point.hit_rate).filter(|(_, rates)| !rates.is_empty());
    let caches: BTreeSet<&String> = used.map(|(cache, _)| cache).collect();
    caches.into_iter().map(of_cache).collect()
}
