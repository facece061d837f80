//! The results of a sweep.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::values::shown;
use crate::quantity::{Bytes, Resolution};
use crate::report::format::{or_absent, percent, words};
use crate::report::grid::Grid;
use crate::report::split::{Column, Split, change_within, half_widths};
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
    /// Numbers of the warm-up frames: their figures are not counted.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warmup: Vec<u32>,
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

/// A machine's own value of a varied field.
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
    /// Fields that differ from the machine's file.
    pub changes: Vec<Change>,
    /// Savings and costs.
    #[serde(flatten)]
    pub split: Split,
    /// The effect of the changed fields, against the baseline under the same policy; `None` for the baseline itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub effect: Option<Effect>,
    /// DRAM bytes by class, with the policy's words.
    pub bytes: BTreeMap<TrafficClass, Bytes>,
    /// Hits over accesses, by cache and class of traffic, with the policy's words.
    pub hit_rate: BTreeMap<String, BTreeMap<TrafficClass, f64>>,
}

/// The effect of a machine's changed fields against the baseline: the machine as its file describes it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Effect {
    /// Cycles over those of the baseline.
    pub cycles_ratio: f64,
    /// DRAM bytes over those of the baseline; `None` if that moves none.
    pub dram_bytes_ratio: Option<f64>,
    /// Half the widths of the 95 % intervals of both ratios; of samples only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub half_widths: Option<[f64; 2]>,
}

impl Effect {
    /// The effect of `changed` against the baseline `own`.
    pub(crate) fn new(own: &MachineStats, changed: &MachineStats) -> Self {
        let [before, after] = [own, changed].map(|stats| stats.moved("dram").0 as f64);
        Self {
            cycles_ratio: changed.cycles.0 as f64 / own.cycles.0.max(1) as f64,
            dram_bytes_ratio: (before > 0.0).then(|| after / before),
            half_widths: half_widths(own, changed),
        }
    }

    /// The columns of a readable table.
    const COLUMNS: [&str; 2] = ["cycles, to baseline", "DRAM, to baseline"];
    /// The columns of a CSV.
    pub(super) const FIELDS: [&str; 4] =
        ["cycles_ratio_to_file", "cycles_ratio_half_width", "dram_bytes_ratio_to_file", "dram_bytes_ratio_half_width"];

    fn cells(of: Option<&Self>) -> [String; 2] {
        let half = |at: usize| of?.half_widths.map(|both| both[at]);
        let ratios = [of.map(|it| it.cycles_ratio), of.and_then(|it| it.dram_bytes_ratio)];
        std::array::from_fn(|at| or_absent(ratios[at], |ratio| change_within(1.0, ratio, half(at))))
    }

    /// The cells under [`Effect::FIELDS`].
    pub(super) fn fields(of: Option<&Self>) -> [String; 4] {
        let half = |at: usize| of?.half_widths.map(|both| both[at]);
        let [cycles, dram] = [of.map(|it| it.cycles_ratio), of.and_then(|it| it.dram_bytes_ratio)];
        [cycles, half(0), dram, half(1)].map(|it| it.map_or_else(String::new, |it| it.to_string()))
    }
}

impl SweepPoint {
    /// Half the width of the interval of its cycles over the baseline's; `None` if it is exact.
    pub(super) fn half_width_to_file(&self) -> Option<f64> {
        self.effect.and_then(|effect| Some(effect.half_widths?[0]))
    }

    /// The point of three measurements (without culling, with free words, with the policy's words) of a stream with
    /// `totals`. `own` holds the baseline's measurements, if this point is not the baseline.
    pub(crate) fn new(
        machine: &str,
        policy: &str,
        changes: Vec<Change>,
        measured: [&MachineStats; 3],
        totals: &Totals,
        own: Option<&MachineStats>,
    ) -> Self {
        let [.., real] = measured;
        Self {
            machine: machine.into(),
            policy: policy.into(),
            changes,
            split: Split::new(measured, totals),
            effect: own.map(|own| Effect::new(own, real)),
            bytes: real.bytes.get("dram").cloned().unwrap_or_default(),
            hit_rate: real.hit_rates(),
        }
    }

    /// The changed fields, in words.
    pub(crate) fn label(&self) -> String {
        label(&self.changes)
    }
}

/// The fields that differ from a machine's file, in words.
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

/// The points as a table: names, the effect of culling, the effect of the changed fields, and the other columns.
pub(crate) fn grid(summary: &SweepSummary) -> Grid {
    let [cycles, dram, rest @ ..] = Split::COLUMNS;
    let row = |point: &SweepPoint| {
        let split = |columns: &[Column]| columns.iter().map(|(_, text)| text(&point.split)).collect::<Vec<_>>();
        let effect = Effect::cells(point.effect.as_ref());
        point.names().into_iter().chain(split(&[cycles, dram])).chain(effect).chain(split(&rest)).collect()
    };
    let names = |columns: &[Column]| columns.iter().map(|(name, _)| *name).collect::<Vec<_>>();
    let head = NAMES.into_iter().chain(names(&[cycles, dram])).chain(Effect::COLUMNS).chain(names(&rest));
    Grid { head: head.map(Into::into).collect(), names: 3, rows: summary.points.iter().map(row).collect() }
}

/// Hit rates of every cache of any point, by class of traffic.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::run::tests::sample::sweep;

    /// Each figure stands under its name, and the effect of a field has its interval.
    #[test]
    fn a_point_tells_what_its_fields_change() {
        let table = grid(&sweep());
        assert_eq!(&table.head[3..7], ["cycles", "DRAM", "cycles, to baseline", "DRAM, to baseline"]);
        assert!(table.rows.iter().all(|row| row.len() == table.head.len()));
        assert_eq!(table.rows[0][5], "\u{2013}", "the machine as in its file: {:?}", table.rows);
        assert!(table.rows[1][5].starts_with('+') && table.rows[1][5].contains(" \u{b1} "), "{:?}", table.rows);
        let changed = Effect::fields(sweep().points[1].effect.as_ref());
        assert!(changed.iter().all(|cell| cell.parse::<f64>().is_ok()), "{changed:?}");
        assert_eq!(Effect::fields(None), [const { String::new() }; 4]);
    }
}
