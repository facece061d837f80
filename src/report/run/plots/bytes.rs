//! Bytes moved by level and class, with and without culling.

use super::machine::{Machine, MachinePlot};
use crate::quantity::Bytes;
use crate::report::draw::Figure;
use crate::report::draw::bars::{Bar, BarChart, Group, Segment};
use crate::report::draw::palette::class_color;
use crate::report::format::{bytes, change, percent_tick, words};
use crate::report::run::machine_run::MachineRun;
use crate::stats::TrafficClass;

pub(super) const PLOT: MachinePlot = MachinePlot { name: "bytes", figure };

fn total(run: &MachineRun, level: &str) -> Option<Bytes> {
    run.stats.bytes.get(level).map(|classes| classes.values().copied().sum())
}

fn figure<'a>(machine: &'a Machine<'a>) -> Option<Figure<'a>> {
    let mut levels = machine.keys(|run| &run.stats.bytes);
    // From the units outwards: L1s and L2 come first, then the other levels, such as DRAM.
    levels.sort_by_key(|level| if level.starts_with('l') { (0, *level) } else { (1, *level) });

    let mut max: f64 = 1.0;
    let mut seen = Vec::new();
    let mut groups = Vec::new();
    for level in levels {
        let off = machine.baseline_run().and_then(|run| total(run, level));
        let largest = machine.runs().filter_map(|(_, run)| total(run, level)).max();
        let Some(whole) = off.or(largest).filter(|whole| whole.0 > 0) else { continue };
        let bar = |(policy, run): (&str, &MachineRun)| {
            let moved = total(run, level)?;
            let segments = TrafficClass::ALL.into_iter().filter_map(|class| {
                let part = run.stats.bytes.get(level)?.get(&class)?.0;
                if part > 0 && !seen.contains(&class) {
                    seen.push(class);
                }
                Some(Segment { part: words(class.name()), value: part as f64, color: class_color(class) })
            });
            let segments = segments.collect();
            max = max.max(moved.0 as f64 / whole.0 as f64);
            let changed = off.filter(|_| !machine.is_baseline(policy));
            let changed = changed.and_then(|off| change(off.0 as f64, moved.0 as f64));
            let changed = changed.map(|change| format!(" ({change})")).unwrap_or_default();
            Some(Bar { name: policy.into(), segments, note: format!("{}{changed}", bytes(moved)) })
        };
        let bars = machine.runs().filter_map(bar).collect();
        groups.push(Group { name: words(level), whole: whole.0 as f64, bars });
    }
    if groups.is_empty() {
        return None;
    }
    seen.sort();
    let lengths = match machine.baseline_run() {
        Some(_) => "the run without culling",
        None => "the longest of the level",
    };
    let name = machine.name;
    let title = machine.changes(|run| total(run, "dram").map(|bytes| bytes.0 as f64));
    let title = title.map_or_else(|| format!("{name}: bytes moved"), |changes| format!("{name}: DRAM bytes {changes}"));
    let chart = BarChart {
        title,
        about: format!(
            "Bytes moved between a level and the one above it, towards the units, in all measured frames, by what they \
             are for. Lengths are relative to {lengths}."
        ),
        key: seen.into_iter().map(|class| (words(class.name()), class_color(class))).collect(),
        axis: "bytes, share of those without culling",
        unit: "bytes",
        max,
        tick: percent_tick,
        groups,
    };
    Some(chart.figure())
}
