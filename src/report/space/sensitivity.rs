//! The effect of each field on each figure.

use super::data::SpaceSummary;
use crate::report::draw::reach::{Reach, reaches};
use crate::report::draw::{Figure, Plot};
use crate::report::sweep::shown;

pub(super) const CYCLES: Plot<SpaceSummary> = Plot { name: "cycles-by-field", section: (), figure: cycles };
pub(super) const DRAM_BYTES: Plot<SpaceSummary> = Plot { name: "dram-by-field", section: (), figure: dram_bytes };
pub(super) const ENERGY: Plot<SpaceSummary> = Plot { name: "energy-by-field", section: (), figure: energy };

fn cycles(summary: &SpaceSummary) -> Option<Figure<'_>> {
    figure(summary, "cycles", ("faster", "slower"))
}

fn dram_bytes(summary: &SpaceSummary) -> Option<Figure<'_>> {
    figure(summary, "dram_bytes", ("fewer", "more"))
}

fn energy(summary: &SpaceSummary) -> Option<Figure<'_>> {
    figure(summary, "joules", ("less", "more"))
}

fn figure<'a>(summary: &'a SpaceSummary, name: &str, words: (&str, &str)) -> Option<Figure<'a>> {
    let mut groups: Vec<(String, Vec<Reach>)> = Vec::new();
    for it in summary.sensitivities.iter().filter(|it| it.figure == name) {
        let group = format!("{}, {}", it.machine, it.policy);
        let value = |(value, change): &(String, f64)| (shown(&it.field, value), *change);
        let reach = Reach { field: it.field.clone(), least: value(&it.least), most: value(&it.most) };
        match groups.iter_mut().find(|(other, _)| *other == group) {
            Some((_, reaches)) => reaches.push(reach),
            None => groups.push((group, vec![reach])),
        }
    }
    for (_, reaches) in &mut groups {
        reaches.sort_by(|a, b| b.width().total_cmp(&a.width()));
    }
    let title = summary.widest(name)?;
    let about =
        "From the value with the least to the one with the most: means over all designs with the value, replayed or \
                 predicted, against the mean of all."
            .into();
    let words_of = name.replace("dram", "DRAM").replace("joules", "energy").replace('_', " ");
    Some(reaches((title, about), &words_of, words, groups))
}
