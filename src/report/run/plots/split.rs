//! What culling saved of the DRAM's bytes, and what its words cost.

use super::machine::{Machine, MachinePlot};
use crate::quantity::Bytes;
use crate::report::draw::bars::{Bar, BarChart, Group, Segment};
use crate::report::draw::canvas::{DrawError, palette};
use crate::report::format::{bytes, change, or_absent, percent, percent_tick};
use crate::report::split::{Split, signed};

pub(super) const PLOT: MachinePlot = MachinePlot { name: "split", draw };

fn draw(machine: &Machine<'_>) -> Result<Option<String>, DrawError> {
    let looks = [
        ("saved by culling", palette::GREEN),
        ("words, counters and ids", palette::VERMILLION),
        ("interference", palette::ORANGE),
    ];
    let [green, red, orange] = looks.map(|(_, color)| color);
    let mut max: f64 = 0.0;
    let mut group = |(policy, split): (&str, &Split)| {
        let whole = split.dram[0].0.max(1) as f64;
        // What is below zero has no length.
        let segment = |bytes: i64, color| Segment { length: bytes.max(0) as f64 / whole, color };
        let saved = Bar {
            name: "saved".into(),
            segments: vec![segment(split.saved, green)],
            note: format!("{}, {} of the shadow rays culled", signed(split.saved), percent(split.culled)),
        };
        let paid = Bar {
            name: "paid".into(),
            segments: vec![segment(split.words as i64, red), segment(split.interference, orange)],
            note: format!(
                "{} and {}, break-even at {} culled",
                bytes(Bytes(split.words)),
                signed(split.interference),
                or_absent(split.break_even, percent)
            ),
        };
        let lengths = [&saved, &paid].map(|bar| bar.segments.iter().map(|segment| segment.length).sum());
        max = lengths.into_iter().fold(max, f64::max);
        let net = or_absent(change(whole, split.dram[2].0 as f64), |it| it);
        Group { name: format!("{policy}: {net}"), bars: vec![saved, paid] }
    };
    let groups: Vec<Group> = machine.summary.split.iter().map(&mut group).collect();
    if groups.is_empty() || max == 0.0 {
        return Ok(None);
    }
    let chart = BarChart {
        title: format!("Saved and paid, in DRAM bytes: {}", machine.name),
        subtitle: "paid - saved is the change against no culling, which stands beside each name; what is below zero has no length"
            .into(),
        legend: looks.map(|(name, color)| (name.into(), color)).into(),
        axis: "DRAM bytes, share of those without culling",
        max,
        tick: percent_tick,
        groups,
    };
    chart.draw().map(Some)
}
