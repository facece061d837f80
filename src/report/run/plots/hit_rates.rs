//! Hit rates by cache and class, with and without culling.

use super::machine::{Machine, MachinePlot};
use crate::report::draw::Figure;
use crate::report::draw::bars::{Bar, BarChart, Group, Segment};
use crate::report::draw::palette::{class_color, pale};
use crate::report::format::{percent, percent_tick, short, words};
use crate::stats::TrafficClass;

pub(super) const PLOT: MachinePlot = MachinePlot { name: "hit_rates", figure };

fn figure<'a>(machine: &'a Machine<'a>) -> Option<Figure<'a>> {
    let caches = machine.keys(|run| &run.stats.caches);
    let mut groups = Vec::new();
    let mut lowest: Option<(f64, String)> = None;
    for (cache, class) in caches.iter().flat_map(|&cache| TrafficClass::ALL.map(|class| (cache, class))) {
        let name = format!("{}, {}", words(cache), words(class.name()));
        let bars: Vec<Bar> = machine
            .runs()
            .filter_map(|(policy, run)| {
                let counts = run.stats.caches.get(cache)?.get(&class)?;
                let color = class_color(class);
                let color = if machine.is_baseline(policy) { pale(color) } else { color };
                let rate = counts.hit_rate()?;
                if lowest.as_ref().is_none_or(|(least, _)| rate < *least) {
                    lowest = Some((rate, format!("{} ({})", words(cache), words(class.name()))));
                }
                let segment = Segment { part: "hits".into(), value: rate, color };
                let note = format!("{} of {}", percent(rate), short(counts.accesses as f64));
                Some(Bar { name: policy.into(), segments: vec![segment], note })
            })
            .collect();
        if !bars.is_empty() {
            groups.push(Group { name, whole: 1.0, bars });
        }
    }
    let (rate, place) = lowest?;
    let pale = if machine.baseline_run().is_some() { " Pale: without culling." } else { "" };
    let chart = BarChart {
        title: format!("{}: the lowest hit rate is {}, in {place}", machine.name, percent(rate)),
        about: format!("Hits over accesses, by what is looked for. A line that is already on its way is no hit.{pale}"),
        key: Vec::new(),
        axis: "hits, share of accesses",
        unit: "share",
        max: 1.0,
        tick: percent_tick,
        groups,
    };
    Some(chart.figure())
}
