//! Metrics, and how the names in a declaration's path become columns.

use std::collections::BTreeMap;

use crate::report::explain::{Statistic, statistics};
use crate::stats::Cause;

/// The column that a name in a number's path stands in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// The level, cache, unit, queue or kind of rays.
    Part,
    /// The class of traffic, or the cause of a unit's cycles.
    Class,
}

/// The only bytes without a level in their path.
const DRAM_BYTES_OF_POINT: &str = "points.*.bytes.*";

/// What a row's number is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::report) struct Metric {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    /// What it is.
    pub about: &'static str,
    /// Its path in `summary.json`, as `explain` has it.
    pub path: String,
    /// Columns of the names in the path, in order.
    pub(super) places: Vec<Place>,
    /// The class that the path's last word is.
    pub(super) class: Option<&'static str>,
}

impl Metric {
    /// The metric of a statistic whose path continues with `rest` behind its family's prefix.
    fn new(statistic: &Statistic, group: &str, rest: &str) -> Self {
        let mut words: Vec<&str> = rest.split('.').collect();
        let cause = words.last().and_then(|last| Cause::ALL.into_iter().map(Cause::name).find(|name| name == last));
        let class = cause.filter(|_| words[0] == "units");
        if class.is_some() {
            words.pop();
        }
        let by_class = words.contains(&"classes") || group == "split" || statistic.name == DRAM_BYTES_OF_POINT;
        let places = if by_class { [Place::Class; 2] } else { [Place::Part, Place::Class] };
        let stars = words.iter().filter(|word| **word == "*").count();
        let named = std::iter::once(group).filter(|group| !group.is_empty());
        let name: Vec<&str> = named.chain(words.iter().copied().filter(|word| *word != "*")).collect();
        Self {
            name: name.join("."),
            unit: statistic.unit,
            about: statistic.about,
            path: statistic.name.clone(),
            places: places[..stars].to_vec(),
            class,
        }
    }
}

/// What has columns or rows of its own.
const APART: [&str; 9] =
    ["frame", "frames", "light", "lights", "warmup", "half_widths", "within", "residuals", "choice"];

/// The metrics whose paths begin alike, by the words that follow.
#[derive(Debug, Default)]
pub(in crate::report) struct Family {
    root: Node,
}

/// What follows a word.
#[derive(Debug, Default)]
pub(super) struct Node {
    words: BTreeMap<String, Node>,
    any: Option<Box<Node>>,
    pub(super) metric: Option<Metric>,
}

impl Node {
    /// What follows `word`, and whether the word is a name.
    pub(super) fn follow(&self, word: &str) -> Option<(&Self, bool)> {
        let named = || self.any.as_deref().map(|node| (node, true));
        self.words.get(word).map(|node| (node, false)).or_else(named)
    }
}

impl Family {
    /// The statistics that `explain` declares under `prefix`; `group` begins the names of their metrics. What only says
    /// which frame or light numbers are of, or how they were estimated, is left out.
    pub(in crate::report) fn new(prefix: &str, group: &str) -> Self {
        let mut family = Self::default();
        for statistic in statistics() {
            let Some(rest) = statistic.name.strip_prefix(prefix) else { continue };
            if rest.split('.').next().is_some_and(|word| APART.contains(&word)) {
                continue;
            }
            let mut node = &mut family.root;
            for word in rest.split('.') {
                node = match word {
                    "*" => node.any.get_or_insert_default(),
                    word => node.words.entry(word.to_owned()).or_default(),
                };
            }
            node.metric = Some(Metric::new(&statistic, group, rest));
        }
        family
    }

    /// The metric of the number at a path of words, if one is declared.
    pub(in crate::report) fn metric(&self, path: &str) -> Option<&Metric> {
        let mut words = path.split('.');
        words.try_fold(&self.root, |node, word| Some(node.follow(word)?.0))?.metric.as_ref()
    }

    pub(super) fn root(&self) -> &Node {
        &self.root
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_in_a_path_become_columns() {
        let machine = Family::new("machines.*.policies.*.", "");
        let bytes = machine.metric("bytes.l2.node").unwrap().clone();
        assert_eq!((bytes.name.as_str(), bytes.unit, bytes.places), ("bytes", "B", vec![Place::Part, Place::Class]));
        let busy = machine.metric("units.traversal.busy").unwrap().clone();
        assert_eq!((busy.name.as_str(), busy.class, busy.places), ("units", Some("busy"), vec![Place::Part]));
        let hits = machine.metric("caches.l1_traversal.node.hits").unwrap().clone();
        assert_eq!((hits.name.as_str(), hits.unit), ("caches.hits", "accesses"));
        assert_eq!(machine.metric("energy.classes.node").unwrap().clone().places, [Place::Class]);
        let family = Family::new("machines.*.split.*.", "split");
        let split = family.metric("cycles.0").unwrap().clone();
        assert_eq!((split.name.as_str(), split.places), ("split.cycles", vec![Place::Class]));
    }
}
