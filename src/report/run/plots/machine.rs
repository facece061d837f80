//! What a machine measured, as its plots see it.

use std::collections::{BTreeMap, BTreeSet};

use crate::report::draw::DrawError;
use crate::report::run::summary::{MachineRun, MachineSummary};

/// A plot that is drawn once a machine.
pub(super) struct MachinePlot {
    /// Its name in files; the machine's name follows.
    pub name: &'static str,
    /// Draws an SVG file; none where the machine has nothing to show.
    pub draw: fn(&Machine<'_>) -> Result<Option<String>, DrawError>,
}

/// A machine's part of a summary.
pub(super) struct Machine<'a> {
    pub name: &'a str,
    pub summary: &'a MachineSummary,
    pub baseline: Option<&'a str>,
}

impl<'a> Machine<'a> {
    /// Its runs, by policy.
    pub(super) fn runs(&self) -> impl Iterator<Item = (&'a str, &'a MachineRun)> + use<'a> {
        self.summary.policies.iter()
    }

    /// The run without culling.
    pub(super) fn baseline_run(&self) -> Option<&'a MachineRun> {
        self.summary.policies.get(self.baseline?)
    }

    /// All keys that the runs have, in order.
    pub(super) fn keys<T>(&self, of: fn(&'a MachineRun) -> &'a BTreeMap<String, T>) -> Vec<&'a str> {
        let keys: BTreeSet<&str> = self.runs().flat_map(|(_, run)| of(run).keys().map(String::as_str)).collect();
        keys.into_iter().collect()
    }
}
