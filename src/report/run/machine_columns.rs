//! Numbers of machines in a frame, as columns of `frames.csv`.

use super::summary::{MachineSummary, Summary};
use crate::report::csv_table::cell;
use crate::stats::{CacheCounts, DramCounts, Energy, FrameStats};

/// A column: the number's path in a frame of the summary, and the function that formats it.
pub(crate) type CountedColumn = (String, Box<dyn Fn(&FrameStats) -> String>);

/// The columns of one machine.
pub(crate) struct MachineColumns<'a> {
    name: &'a str,
    machine: &'a MachineSummary,
    columns: Vec<CountedColumn>,
}

impl<'a> MachineColumns<'a> {
    /// The columns of all machines.
    pub(crate) fn of(summary: &'a Summary) -> Vec<Self> {
        let columns = |(name, machine)| Self { name, machine, columns: columns(machine) };
        summary.machines.iter().map(columns).collect()
    }

    /// The headers: the machine's name, a dot and the column.
    pub(crate) fn head(&self) -> impl Iterator<Item = String> {
        self.columns.iter().map(|(column, _)| format!("{}.{column}", self.name))
    }

    /// The fields of a policy's frame; empty if the machine did not replay the frame.
    pub(crate) fn row(&self, policy: &str, number: u32) -> impl Iterator<Item = String> {
        let run = self.machine.policies.get(policy);
        let frame = run.and_then(|run| run.stats.frames.iter().find(|frame| frame.frame == number));
        self.columns.iter().map(move |(_, text)| frame.map_or_else(String::new, text))
    }
}

/// All columns of a machine.
fn columns(machine: &MachineSummary) -> Vec<CountedColumn> {
    let mut frames = machine.policies.iter().flat_map(|(_, run)| &run.stats.frames);
    let Some(first) = frames.next() else { return Vec::new() };
    let mut columns: Vec<CountedColumn> = vec![
        ("warmup".into(), Box::new(|frame| u8::from(frame.warmup).to_string())),
        ("cycles".into(), Box::new(|frame| frame.cycles.to_string())),
        ("rays".into(), Box::new(|frame| frame.rays.to_string())),
        ("answered".into(), Box::new(|frame| frame.answered.to_string())),
    ];
    columns.extend(counted_columns(first));
    columns
}

/// Columns of counts of levels, caches, units and DRAM, and of energy, as far as the frame `first` has them.
pub(crate) fn counted_columns(first: &FrameStats) -> Vec<CountedColumn> {
    let mut columns: Vec<CountedColumn> = Vec::new();
    for level in first.bytes.keys() {
        let (name, level) = (format!("bytes.{level}"), level.clone());
        columns.push((name, Box::new(move |frame| cell(frame.bytes.get(&level)))));
    }
    for cache in first.caches.keys() {
        for (at, counter) in CacheCounts::DECLARED.iter().enumerate() {
            let (name, cache) = (format!("caches.{cache}.{}", counter.name), cache.clone());
            columns.push((name, Box::new(move |frame| cell(frame.caches.get(&cache).map(|it| it.values()[at])))));
        }
    }
    for (unit, causes) in &first.units {
        for &cause in causes.keys() {
            let (name, unit) = (format!("units.{unit}.{}", cause.name()), unit.clone());
            columns.push((name, Box::new(move |frame| cell(frame.units.get(&unit).and_then(|it| it.get(&cause))))));
        }
    }
    for (at, counter) in DramCounts::DECLARED.iter().enumerate() {
        columns.push((format!("dram.{}", counter.name), Box::new(move |frame| frame.dram.values()[at].to_string())));
    }
    if let Some(energy) = &first.energy {
        let of = |figure: fn(&Energy) -> f64| move |frame: &FrameStats| cell(frame.energy.as_ref().map(figure));
        columns.push(("energy.joules".into(), Box::new(of(|energy| energy.joules))));
        columns.push(("energy.low".into(), Box::new(of(|energy| energy.low))));
        columns.push(("energy.high".into(), Box::new(of(|energy| energy.high))));
        for part in energy.by.keys() {
            let (name, part) = (format!("energy.by.{part}"), part.clone());
            columns.push((name, Box::new(move |frame| cell(frame.energy.as_ref().and_then(|it| it.by.get(&part))))));
        }
    }
    columns
}
