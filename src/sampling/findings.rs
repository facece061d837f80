//! What a sample found, and the statistics of the stream that it lets be estimated.

use std::collections::BTreeMap;

use super::estimate::{self, Population, Total, Window};
use super::figures::{self, Figures};
use super::job::{Found, Latencies};
use super::known::{DRAM_BYTES, L2_BYTES};
use super::pass::{Pass, Sampler};
use crate::machine::{MachineSpec, SpecError};
use crate::stats::{Accuracy, LatencyCounts, MachineStats};

/// Windows from which on the width of an interval tells something: with fewer, too many intervals are too narrow by
/// chance.
pub(crate) const TELLING: usize = 48;

/// What a sample found.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Findings {
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
}

impl Findings {
    /// Nothing was measured yet of the stream that `pass` went over, but for what it found.
    ///
    /// # Errors
    /// The sampler's engine refuses the machine.
    pub(crate) fn of(sampler: &Sampler<'_>, pass: Pass) -> Result<Self, SpecError> {
        let Pass { population, rays, found, .. } = pass;
        let mut findings = Self { population, rays, nothing: sampler.nothing(), ..Self::default() };
        findings.add(found);
        Ok(findings)
    }

    /// Adds what was measured.
    pub(crate) fn add(&mut self, found: Vec<Found>) {
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

    fn know_longest(&mut self, latencies: Latencies) {
        for (kind, LatencyCounts { most, .. }) in latencies {
            let known = self.nothing.latency.entry(kind).or_default();
            known.most = known.most.max(most);
        }
    }

    /// Whether there are enough windows for intervals that tell something.
    pub(crate) fn tells(&self) -> bool {
        self.measured.len() >= TELLING
    }

    /// The stream's statistics, as the first `draws` points of each stratum let them be estimated.
    pub(crate) fn estimate(&self, machine: &MachineSpec, draws: usize) -> MachineStats {
        let mut totals = estimate::estimate(&self.population, &self.measured, draws, machine.line_bytes.get());
        for (name, end) in &self.ends {
            totals.entry(name.clone()).or_default().total += end;
        }
        // Absent is absent.
        let is_there = |name: &str, total: &Total| !name.starts_with("bytes.") || total.total > 0.0;
        let named = || totals.iter().filter(|(name, total)| !name.starts_with('=') && is_there(name, total));
        let figures: BTreeMap<String, f64> = named().map(|(name, total)| (name.clone(), total.total)).collect();
        let mut stats = figures::with(&self.nothing, figures.iter());
        stats.rays = self.rays;
        let share = |name: &str| totals.get(name).and_then(Total::share);
        stats.accuracy = match (share("cycles"), share(L2_BYTES), share(DRAM_BYTES)) {
            (Some(cycles), Some(l2_bytes), Some(dram_bytes)) if self.tells() => {
                let rate = self.measured.len() as f64 / self.population.windows as f64;
                Accuracy::Estimated { cycles, l2_bytes, dram_bytes, rate }
            }
            _ => Accuracy::Few { windows: self.measured.len(), telling: TELLING },
        };
        if self.tells() {
            stats.half_widths = named().filter_map(|(name, total)| Some((name.clone(), total.half_width?))).collect();
        }
        stats
    }
}
