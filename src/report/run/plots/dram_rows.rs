//! DRAM column commands by the state of the row: open, none open, another one open.

use super::machine::{Machine, MachinePlot};
use crate::report::draw::Figure;
use crate::report::draw::bars::{Bar, BarChart, Group, Segment};
use crate::report::draw::palette::{GREEN, SKY, VERMILLION};
use crate::report::format::{or_absent, percent, tick};
use crate::report::run::machine_run::MachineRun;

pub(super) const PLOT: MachinePlot = MachinePlot { name: "dram_rows", figure };

fn figure<'a>(machine: &'a Machine<'a>) -> Option<Figure<'a>> {
    let looks = [("row open", GREEN), ("no row open", SKY), ("another row open", VERMILLION)];
    let bar = |(policy, run): (&str, &MachineRun)| {
        let dram = run.stats.dram;
        let met = [dram.row_hits, dram.row_misses, dram.row_conflicts];
        let segments = met.into_iter().zip(looks);
        let segments = segments.map(|(count, (part, color))| Segment { part: part.into(), value: count as f64, color });
        let note = or_absent(run.dram_row_hit_rate, |rate| format!("{} open", percent(rate)));
        (met != [0; 3]).then(|| Bar { name: policy.into(), segments: segments.collect(), note })
    };
    let bars: Vec<Bar> = machine.runs().filter_map(bar).collect();
    let lengths = bars.iter().map(|bar| bar.segments.iter().map(|segment| segment.value).sum::<f64>());
    let max = lengths.reduce(f64::max)?;
    let rates =
        machine.runs().filter_map(|(policy, run)| Some(format!("{} with {policy}", percent(run.dram_row_hit_rate?))));
    let rates: Vec<String> = rates.take(3).collect();
    let chart = BarChart {
        title: format!("{}: DRAM commands find their row open in {}", machine.name, rates.join(", ")),
        about:
            "Reads and writes of the measured frames. An open row answers at once; another row must first be closed."
                .into(),
        key: looks.map(|(name, color)| (name.into(), color)).into(),
        axis: "column commands",
        unit: "commands",
        max,
        tick,
        groups: vec![Group { name: "DRAM".into(), whole: 1.0, bars }],
    };
    Some(chart.figure())
}
