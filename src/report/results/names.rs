//! Metrics, and the columns for the names in a declaration's path.

use std::collections::BTreeMap;

use crate::report::explain::{Statistic, statistics};
use crate::stats::Cause;

/// The column for a name in a number's path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// The level, cache, unit, queue or kind of rays.
    Part,
    /// The class of traffic, or the cause of a unit's cycles.
    Class,
}

/// The only bytes without a level in their path.
const DRAM_BYTES_OF_POINT: &str = "points.*.bytes.*";

/// The meaning of a row's number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::report) struct Metric {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    /// Its meaning.
    pub about: &'static str,
    /// Its path in `summary.json`, as declared in `explain`.
    pub path: String,
    /// Columns of the names in the path, in order.
    pub(super) places: Vec<Place>,
    /// The class, if the path's last word is one.
    pub(super) class: Option<&'static str>,
}

impl Metric {
    /// The metric of a statistic; `rest` is its path after the family's prefix.
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

/// Numbers with columns or rows of their own, by the first word after the prefix.
const APART: [&str; 9] =
    ["frame", "frames", "light", "lights", "warmup", "half_widths", "within", "residuals", "choice"];

/// Metrics whose paths have the same prefix, as a tree of the words that follow.
#[derive(Debug, Default)]
pub(in crate::report) struct Family {
    root: Node,
}

/// The words that can follow a word.
#[derive(Debug, Default)]
pub(super) struct Node {
    words: BTreeMap<String, Node>,
    any: Option<Box<Node>>,
    pub(super) metric: Option<Metric>,
}

impl Node {
    /// The node of `word`, and whether the word is a name.
    pub(super) fn follow(&self, word: &str) -> Option<(&Self, bool)> {
        let named = || self.any.as_deref().map(|node| (node, true));
        self.words.get(word).map(|node| (node, false)).or_else(named)
    }
}

impl Family {
    /// The statistics that `explain` declares under `prefix`; `group` is the first part of their metrics' names. Left
    /// out: numbers that only tell the frame or light of others, or how these were estimated.
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
