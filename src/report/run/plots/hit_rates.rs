//! Hit rates a cache and class, with and without culling.

use super::machine::{Machine, MachinePlot};
use crate::report::draw::bars::{Bar, BarChart, Group, Segment};
use crate::report::draw::canvas::{DrawError, class_color, pale};
use crate::report::format::{percent, percent_tick, short, words};
use crate::stats::TrafficClass;

pub(super) const PLOT: MachinePlot = MachinePlot { name: "hit_rates", draw };

fn draw(machine: &Machine<'_>) -> Result<Option<String>, DrawError> {
    let caches = machine.keys(|run| &run.stats.caches);
    let mut groups = Vec::new();
    for (cache, class) in caches.iter().flat_map(|&cache| TrafficClass::ALL.map(|class| (cache, class))) {
        let bars: Vec<Bar> = machine
            .runs()
            .filter_map(|(policy, run)| {
                let counts = run.stats.caches.get(cache)?.get(&class)?;
                let color = class_color(class);
                let color = if machine.baseline == Some(policy) { pale(color) } else { color };
                let length = counts.hit_rate()?;
                let segment = Segment { length, color };
                let note = format!("{} of {}", percent(length), short(counts.accesses as f64));
                Some(Bar { name: policy.into(), segments: vec![segment], note })
            })
            .collect();
        if !bars.is_empty() {
            groups.push(Group { name: format!("{}, {}", words(cache), words(class.name())), bars });
        }
    }
    if groups.is_empty() {
        return Ok(None);
    }
    let chart = BarChart {
        title: format!("Cache hit rates, by what is looked for: {}", machine.name),
        subtitle: match machine.baseline {
            Some(_) => "a line already on its way counts as no hit; pale: without culling".into(),
            None => "a line already on its way counts as no hit".into(),
        },
        legend: Vec::new(),
        axis: "hits, share of accesses",
        max: 1.0,
        tick: percent_tick,
        groups,
    };
    chart.draw().map(Some)
}
