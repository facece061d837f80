//! A machine's measurements, as input of its plots.

use std::collections::{BTreeMap, BTreeSet};

use crate::report::draw::Figure;
use crate::report::draw::palette::{Color, WITHOUT, series_color};
use crate::report::format::change;
use crate::report::run::machine_run::MachineRun;
use crate::report::run::over_time::{OverTime, Span};
use crate::report::run::summary::{MachineSummary, Summary};

/// A plot that is drawn once per machine.
pub(super) struct MachinePlot {
    /// Its name in files; the machine's name follows.
    pub name: &'static str,
    /// Its figure; `None` if the machine has nothing to show.
    pub figure: for<'a> fn(&'a Machine<'a>) -> Option<Figure<'a>>,
}

/// A machine's part of a summary.
pub(super) struct Machine<'a> {
    pub name: &'a str,
    pub found: &'a MachineSummary,
    pub run: &'a Summary,
    pub over_time: &'a OverTime,
}

impl<'a> Machine<'a> {
    /// Its runs, by policy.
    pub(super) fn runs(&self) -> impl Iterator<Item = (&'a str, &'a MachineRun)> + use<'a> {
        self.found.policies.iter()
    }

    /// Whether `policy` is the baseline, which does not cull.
    pub(super) fn is_baseline(&self, policy: &str) -> bool {
        self.run.baseline.as_deref() == Some(policy)
    }

    /// The run without culling.
    pub(super) fn baseline_run(&self) -> Option<&'a MachineRun> {
        self.found.policies.get(self.run.baseline.as_deref()?)
    }

    /// The runs with culling.
    pub(super) fn culling(&self) -> impl Iterator<Item = (&'a str, &'a MachineRun)> {
        self.runs().filter(|(policy, _)| !self.is_baseline(policy))
    }

    /// The colour of a policy.
    pub(super) fn color(&self, policy: &str) -> Color {
        policy_color(self.run, policy)
    }

    /// The change of `figure` against the run without culling: `-42.2 % with Published`; for several policies, the
    /// least and the largest change.
    pub(super) fn changes(&self, figure: impl Fn(&MachineRun) -> Option<f64>) -> Option<String> {
        let before = figure(self.baseline_run()?).filter(|&before| before > 0.0)?;
        let mut all: Vec<(&str, f64)> = self.culling().filter_map(|(name, run)| Some((name, figure(run)?))).collect();
        all.sort_by(|a, b| a.1.total_cmp(&b.1));
        let [(least, first), .., (most, last)] = all[..] else {
            let (name, after) = *all.first()?;
            return Some(format!("{} with {name}", change(before, after)?));
        };
        Some(format!("{} with {least} to {} with {most}", change(before, first)?, change(before, last)?))
    }

    /// The spans of a policy's run; empty if the machine was not replayed by `Event` or `Cycle`.
    pub(super) fn spans(&self, policy: &str) -> &'a [Span] {
        self.over_time.get(&(self.name.to_owned(), policy.to_owned())).map_or(&[], Vec::as_slice)
    }

    /// The keys of all runs, in order.
    pub(super) fn keys<T>(&self, of: fn(&'a MachineRun) -> &'a BTreeMap<String, T>) -> Vec<&'a str> {
        let keys: BTreeSet<&str> = self.runs().flat_map(|(_, run)| of(run).keys().map(String::as_str)).collect();
        keys.into_iter().collect()
    }
}

/// The colour of a policy of a run: the same in all plots.
pub(super) fn policy_color(run: &Summary, policy: &str) -> Color {
    let is_baseline = |name: &str| run.baseline.as_deref() == Some(name);
    let mut culling = run.policies.iter().filter(|(name, _)| !is_baseline(name));
    culling.position(|(name, _)| name == policy).map_or(WITHOUT, series_color)
}
