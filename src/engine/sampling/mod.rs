//! Sampling: of each stratum of consecutive windows (runs of pixels of about the same number of rays) some are replayed and measured,
//! each by itself, between parts of others and behind warm caches; the accesses of all others go through the caches' tags alone.

pub mod estimate;
pub mod figures;
mod job;
mod kept;
mod known;
mod pass;
mod plan;
mod regression;
mod tags;
mod windows;

use std::collections::BTreeMap;

use self::estimate::{Population, Total, Window};
use self::job::{Figures, Found, Latencies};
pub use self::kept::Kept;
use self::known::{DRAM_BYTES, L2_BYTES};
pub use self::pass::{Pass, Sampler};
pub use self::plan::{Cut, Plan};
pub use self::tags::Tags;
use crate::engine::Sampled;
use crate::machine::MachineSpec;
use crate::stats::{Accuracy, LatencyCounts, MachineStats};

/// Windows from which on the width of an interval tells something: with fewer, too many intervals are too narrow by chance.
pub const TELLING: usize = 48;

/// What a sample found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Findings {
    /// All windows, frames' ends left out.
    pub population: Population,
    /// Those that were measured.
    pub measured: Vec<Window>,
    /// Sums over frames' ends.
    ends: Figures,
    /// Rays of the stream, skipped ones not counted.
    rays: u64,
    /// The statistics of a run in which nothing happens, but for the longest latencies, which are those of the windows.
    nothing: MachineStats,
    /// What another engine than `Event` found for everything, if it did, as windows of `Event` correct it.
    whole: Option<Figures>,
}

impl Findings {
    /// Nothing was measured yet of the stream that `pass` went over, but for what it found.
    pub fn of(sampler: &Sampler<'_>, plan: &Plan, pass: Pass) -> Self {
        let Pass { population, rays, found, .. } = pass;
        let engine = if plan.corrected.is_empty() { sampler.engine } else { Sampled::Event };
        let mut findings = Self { population, rays, nothing: sampler.nothing(engine), ..Self::default() };
        findings.add(found);
        findings
    }

    /// Adds what was measured.
    pub fn add(&mut self, found: Vec<Found>) {
        for found in found {
            match found {
                Found::Window(window, latency) => {
                    self.measured.push(*window);
                    self.know_longest(latency);
                }
                Found::End(end) => {
                    end.into_iter().for_each(|(name, value)| *self.ends.entry(name).or_default() += value);
                }
            }
        }
    }

    /// From now on windows correct what another engine than `Event` found for everything.
    pub fn correct(&mut self, whole: &MachineStats) {
        self.whole = Some(job::figures_of(whole));
    }

    fn know_longest(&mut self, latencies: Latencies) {
        for (kind, LatencyCounts { most, .. }) in latencies {
            let known = self.nothing.latency.entry(kind).or_default();
            known.most = known.most.max(most);
        }
    }

    /// Windows that `Event` replayed to correct the others.
    fn corrections(&self) -> usize {
        self.measured.iter().filter(|window| window.by_event.is_some()).count()
    }

    /// Whether there are enough windows for intervals that tell something.
    pub fn tells(&self) -> bool {
        let corrections = self.corrections();
        let windows = if corrections > 0 { corrections } else { self.measured.len() };
        windows >= TELLING || windows as u64 == self.population.strata.iter().sum::<u64>()
    }

    /// All figures.
    pub fn totals(&self, machine: &MachineSpec) -> BTreeMap<String, Total> {
        let line = machine.line_bytes.get();
        let mut totals = estimate::estimate(&self.population, &self.measured, self.whole.as_ref(), line);
        let is_whole = |name: &String| self.whole.as_ref().is_some_and(|whole| whole.contains_key(name));
        for (name, end) in self.ends.iter().filter(|(name, _)| !is_whole(name)) {
            totals.entry(name.clone()).or_default().total += end;
        }
        totals
    }

    /// The stream's statistics by `totals`.
    pub fn estimate(&self, totals: &BTreeMap<String, Total>) -> MachineStats {
        // Absent is absent.
        let is_there = |name: &str, total: &Total| !name.starts_with("bytes.") || total.total > 0.0;
        let named = || totals.iter().filter(|(name, total)| !name.starts_with('=') && is_there(name, total));
        let figures: BTreeMap<String, f64> = named().map(|(name, total)| (name.clone(), total.total)).collect();
        let mut stats = figures::with(&self.nothing, figures.iter());
        stats.rays = self.rays;
        let windows = self.population.strata.iter().sum::<u64>() as f64;
        let share = |windows_of: usize| if windows > 0.0 { windows_of as f64 / windows } else { 1.0 };
        let corrected = (self.corrections() > 0).then(|| share(self.corrections()));
        let rate = if self.whole.is_some() { 1.0 } else { share(self.measured.len()) };
        let half = |name: &str| totals.get(name).and_then(Total::share);
        stats.accuracy = match (half("cycles"), half(L2_BYTES), half(DRAM_BYTES)) {
            (Some(cycles), Some(l2_bytes), Some(dram_bytes)) if self.tells() => {
                Accuracy::Estimated { cycles, l2_bytes, dram_bytes, rate, corrected }
            }
            _ => Accuracy::Few { windows: self.measured.len(), telling: TELLING },
        };
        if self.tells() {
            stats.half_widths = named().filter_map(|(name, total)| Some((name.clone(), total.half_width?))).collect();
        }
        stats
    }

    /// Whether corrections alone, of what another engine finds for everything, would leave intervals within `target`.
    pub fn corrections_are_within(&self, totals: &BTreeMap<String, Total>, target: f64) -> bool {
        let is_within = |total: &Total| {
            let share = total.variances[1] / total.variances.iter().sum::<f64>();
            total.share().is_some_and(|half_width| half_width == 0.0 || half_width * share.sqrt() <= target)
        };
        self.tells() && Self::targets(totals).iter().all(is_within)
    }

    /// What a target is held against: cycles and bytes of L2 and DRAM.
    pub fn targets(totals: &BTreeMap<String, Total>) -> Vec<Total> {
        ["cycles", L2_BYTES, DRAM_BYTES].iter().filter_map(|name| totals.get(*name).copied()).collect()
    }
}
