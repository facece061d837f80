//! DRAM bytes of every point of a sweep, by class.

use super::data::{SweepPoint, SweepSummary};
use crate::quantity::Bytes;
use crate::report::draw::bars::{Bar, BarChart, Group, Segment};
use crate::report::draw::palette::class_color;
use crate::report::draw::{Figure, Plot};
use crate::report::format::{change, or_absent, words};
use crate::stats::TrafficClass;

pub(super) const PLOT: Plot<SweepSummary> = Plot { name: "sweep", section: (), figure };

/// The most bars in a plot; a sweep with more points has none.
const MOST: usize = 60;

fn figure(summary: &SweepSummary) -> Option<Figure<'_>> {
    if summary.points.len() > MOST {
        return None;
    }
    let of_off = |point: &SweepPoint, bytes: u64| bytes as f64 / point.split.dram[0].0.max(1) as f64;
    let mut groups: Vec<Group> = Vec::new();
    let mut seen: Vec<TrafficClass> = Vec::new();
    for point in &summary.points {
        let name = format!("{}, {}", point.machine, point.policy);
        let segment = |(&class, &bytes): (&TrafficClass, &Bytes)| {
            if !seen.contains(&class) {
                seen.push(class);
            }
            Segment { part: words(class.name()), value: of_off(point, bytes.0), color: class_color(class) }
        };
        let [off, _, with] = point.split.dram.map(|bytes| bytes.0 as f64);
        let note = or_absent(change(off, with), |it| it);
        let bar = Bar { name: point.label(), segments: point.bytes.iter().map(segment).collect(), note };
        match groups.iter_mut().find(|group| group.name == name) {
            Some(group) => group.bars.push(bar),
            None => groups.push(Group { name, whole: 1.0, bars: vec![bar] }),
        }
    }
    seen.sort();
    let most = summary.points.iter().map(|point| of_off(point, point.split.dram[2].0)).fold(1.0, f64::max);
    let chart = BarChart {
        title: format!("{}: DRAM bytes at every point", summary.scene),
        about: "Bars: bytes by class. At their ends: change against no culling.".into(),
        key: seen.into_iter().map(|class| (words(class.name()), class_color(class))).collect(),
        axis: "DRAM bytes, share of the same machine's without culling",
        unit: "share",
        max: most,
        tick: |share| format!("{:.0} %", share * 100.0),
        groups,
    };
    Some(chart.figure())
}
