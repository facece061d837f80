//! What every unit did in every cycle: utilisation, and the cause of each lost cycle.

use plotters::style::RGBColor;

use super::machine::{Machine, MachinePlot};
use crate::report::draw::bars::{Bar, BarChart, Group, Segment};
use crate::report::draw::canvas::{DrawError, palette};
use crate::report::format::{percent, percent_tick, words};
use crate::report::run::summary::MachineRun;
use crate::stats::Cause;

pub(super) const PLOT: MachinePlot = MachinePlot { name: "utilization", draw };

fn look(cause: Cause) -> (&'static str, RGBColor) {
    match cause {
        Cause::Busy => ("busy", palette::GREEN),
        Cause::Pipeline => ("all rays in the pipeline", palette::SKY),
        Cause::Memory => ("waits for memory", palette::VERMILLION),
        Cause::Blocked => ("blocked by a neighbour", palette::PURPLE),
        Cause::Intake => ("as many rays taken as it can, others wait", palette::YELLOW),
        Cause::Starved => ("starved: no ray", palette::GREY),
    }
}

fn draw(machine: &Machine<'_>) -> Result<Option<String>, DrawError> {
    let units = machine.keys(|run| &run.stats.units);
    let groups: Vec<Group> = units
        .into_iter()
        .filter_map(|unit| {
            let bar = |(policy, run): (&str, &MachineRun)| {
                let causes = run.stats.units.get(unit)?;
                let busy = run.utilization.get(unit)?;
                let whole: u64 = causes.values().sum();
                let segments = Cause::ALL.map(|cause| Segment {
                    length: causes.get(&cause).map_or(0.0, |&cycles| cycles as f64 / whole as f64),
                    color: look(cause).1,
                });
                let note = format!("{} busy", percent(*busy));
                Some(Bar { name: policy.into(), segments: segments.into(), note })
            };
            let bars: Vec<Bar> = machine.runs().filter_map(bar).collect();
            let count = machine.runs().find_map(|(_, run)| run.stats.unit_counts.get(unit));
            let count = count.map(|count| format!(" \u{d7}{count}")).unwrap_or_default();
            (!bars.is_empty()).then(|| Group { name: format!("{}{count}", words(unit)), bars })
        })
        .collect();
    if groups.is_empty() {
        return Ok(None);
    }
    let chart = BarChart {
        title: format!("Where the units' cycles went: {}", machine.name),
        subtitle: "every cycle of every unit has one cause; shares of each run's own cycles".into(),
        legend: Cause::ALL.into_iter().map(|cause| (look(cause).0.into(), look(cause).1)).collect(),
        axis: "share of cycles",
        max: 1.0,
        tick: percent_tick,
        groups,
    };
    chart.draw().map(Some)
}
