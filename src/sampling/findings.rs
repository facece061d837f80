//! What a sample found, and the statistics of the stream that it lets be estimated.

use super::estimate::{self, Population, Total, Window};
use super::figures::{Figure, Figures, Levels};
use super::job::{Found, Latencies};
use super::pass::{Pass, Sampler};
use super::plan::Cut;
use crate::machine::{MachineSpec, SpecError};
use crate::stats::{Accuracy, LatencyCounts, MachineStats, Residuals};

/// The figures of a sample whose errors are told first.
const TOLD: [Figure; 3] = [Figure::Cycles, Figure::L2Bytes, Figure::DramBytes];

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
    /// Pixels of a window.
    window_pixels: u64,
    /// The statistics of a run in which nothing happens, but for the longest latencies, which are those of the windows.
    nothing: MachineStats,
}

impl Findings {
    /// Nothing was measured yet of the stream that `pass` went over, but for what it found.
    ///
    /// # Errors
    /// The sampler's engine refuses the machine.
    pub(crate) fn of(sampler: &Sampler<'_>, cut: &Cut, pass: Pass) -> Result<Self, SpecError> {
        let Pass { population, rays, found, .. } = pass;
        let window_pixels = cut.window() as u64;
        let mut findings = Self { population, rays, window_pixels, nothing: sampler.nothing(), ..Self::default() };
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
                    end.into_iter().for_each(|(figure, value)| *self.ends.entry(figure).or_default() += value);
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

    /// The points of the sample with draws below `draws`.
    pub(crate) fn points(&self, draws: usize) -> usize {
        self.measured.iter().flat_map(|window| &window.hits).filter(|hit| hit.draw < draws).count()
    }

    /// The stream's statistics, as the first `draws` points of each stratum let them be estimated.
    pub(crate) fn estimate(&self, machine: &MachineSpec, draws: usize) -> MachineStats {
        let mut totals = estimate::estimate(&self.population, &self.measured, draws, machine.line_bytes.get());
        for (figure, end) in &self.ends {
            totals.entry(figure.clone()).or_default().total += end;
        }
        // Absent is absent.
        let is_there = |figure: &Figure, total: &Total| !matches!(figure, Figure::Bytes(..)) || total.total > 0.0;
        let found = || totals.iter().filter(|(figure, total)| is_there(figure, total));
        let levels = Levels::new(machine);
        let mut stats = levels.with(&self.nothing, found().map(|(figure, total)| (figure, total.total)));
        stats.rays = self.rays;
        let share = |figure: Figure| totals.get(&figure).map_or(0.0, Total::share);
        let [cycles, l2_bytes, dram_bytes] = TOLD.map(share);
        let rate = self.measured.len() as f64 / self.population.windows as f64;
        stats.accuracy = Accuracy::Estimated { cycles, l2_bytes, dram_bytes, rate };
        let half_width = |(figure, total): (&Figure, &Total)| Some((levels.path(figure)?, total.half_width));
        stats.half_widths = found().filter_map(half_width).collect();
        stats.residuals = Some(self.residuals(machine, draws));
        stats
    }

    fn residuals(&self, machine: &MachineSpec, draws: usize) -> Residuals {
        let Self { population, measured, window_pixels, .. } = self;
        let (points, freedom) = estimate::residuals(population, measured, draws, machine.line_bytes.get(), &TOLD);
        Residuals { window_pixels: *window_pixels, seed: population.strata.seed, freedom, points }
    }
}
