//! What the DRAM's column commands met: an open row, no row, another row.

use super::machine::{Machine, MachinePlot};
use crate::report::draw::bars::{Bar, BarChart, Group, Segment};
use crate::report::draw::canvas::{DrawError, palette};
use crate::report::format::{or_absent, percent, tick};
use crate::report::run::summary::MachineRun;

pub(super) const PLOT: MachinePlot = MachinePlot { name: "dram_rows", draw };

fn draw(machine: &Machine<'_>) -> Result<Option<String>, DrawError> {
    let looks =
        [("row open", palette::GREEN), ("no row open", palette::SKY), ("another row open", palette::VERMILLION)];
    let bar = |(policy, run): (&str, &MachineRun)| {
        let dram = run.stats.dram;
        let met = [dram.row_hits, dram.row_misses, dram.row_conflicts];
        let segments = met.into_iter().zip(looks);
        let segments = segments.map(|(count, (_, color))| Segment { length: count as f64, color });
        let note = or_absent(run.dram_row_hit_rate, |rate| format!("{} open", percent(rate)));
        (met != [0; 3]).then(|| Bar { name: policy.into(), segments: segments.collect(), note })
    };
    let bars: Vec<Bar> = machine.runs().filter_map(bar).collect();
    let lengths = bars.iter().map(|bar| bar.segments.iter().map(|segment| segment.length).sum::<f64>());
    let Some(max) = lengths.reduce(f64::max) else { return Ok(None) };
    let chart = BarChart {
        title: format!("DRAM commands, by the row they met: {}", machine.name),
        subtitle: "reads and writes; an open row answers at once, another row must first be closed".into(),
        legend: looks.map(|(name, color)| (name.into(), color)).into(),
        axis: "column commands",
        max,
        tick,
        groups: vec![Group { name: "DRAM".into(), bars }],
    };
    chart.draw().map(Some)
}
