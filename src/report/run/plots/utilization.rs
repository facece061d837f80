//! Cycle breakdown of the units: utilisation, and the cause of each lost cycle.

use super::machine::{Machine, MachinePlot};
use crate::report::draw::Figure;
use crate::report::draw::bars::{Bar, BarChart, Group, Segment};
use crate::report::draw::palette::cause_look;
use crate::report::format::{percent, percent_tick, words};
use crate::report::run::limits;
use crate::report::run::machine_run::MachineRun;
use crate::stats::Cause;

pub(super) const PLOT: MachinePlot = MachinePlot { name: "utilization", figure };

fn figure<'a>(machine: &'a Machine<'a>) -> Option<Figure<'a>> {
    let groups: Vec<Group> = machine
        .keys(|run| &run.stats.units)
        .into_iter()
        .filter_map(|unit| {
            let bar = |(policy, run): (&str, &MachineRun)| {
                let causes = run.stats.units.get(unit)?;
                let busy = run.utilization.get(unit)?;
                let whole: u64 = causes.values().sum();
                let segments = Cause::ALL.map(|cause| {
                    let (name, color) = cause_look(cause);
                    let cycles = causes.get(&cause).copied().unwrap_or(0);
                    Segment { part: name.into(), value: cycles as f64 / whole as f64, color }
                });
                let note = format!("{} busy", percent(*busy));
                Some(Bar { name: policy.into(), segments: segments.into(), note })
            };
            let bars: Vec<Bar> = machine.runs().filter_map(bar).collect();
            let count = machine.runs().find_map(|(_, run)| run.stats.unit_counts.get(unit));
            let count = count.map(|count| format!(" \u{d7}{count}")).unwrap_or_default();
            (!bars.is_empty()).then(|| Group { name: format!("{}{count}", words(unit)), whole: 1.0, bars })
        })
        .collect();
    if groups.is_empty() {
        return None;
    }
    let busiest = machine.runs().filter_map(|(policy, run)| {
        let (unit, share) = limits::busiest(run)?;
        Some(format!("{} units {} busy with {policy}", words(unit), percent(share)))
    });
    let busiest: Vec<String> = busiest.take(2).collect();
    let chart = BarChart {
        title: format!("{}: {}", machine.name, busiest.join(", ")),
        about: "Cycle breakdown: every cycle of every unit has exactly one cause. Bars are shares of the run's cycles."
            .into(),
        key: Cause::ALL.into_iter().map(|cause| (cause_look(cause).0.into(), cause_look(cause).1)).collect(),
        axis: "share of cycles",
        unit: "share",
        max: 1.0,
        tick: percent_tick,
        groups,
    };
    Some(chart.figure())
}
