//! Measurements of a sample, and the estimates of the stream's statistics.

use std::collections::BTreeMap;

use super::baseline::{Baseline, Corrected};
use super::estimate::{Estimates, Population, Total, Window, estimates};
use super::figures::{Figure, Figures, Levels};
use super::job::{Found, Latencies};
use super::pass::{Pass, Sampler};
use super::plan::Cut;
use crate::machine::MachineSpec;
use crate::stats::{Accuracy, Change, LatencyCounts, MachineStats, Residual, Residuals};

/// The figures with reported intervals and residuals.
const REPORTED: [Figure; 3] = [Figure::Cycles, Figure::L2Bytes, Figure::DramBytes];

/// Measurements of a sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Findings {
    /// Covariates of all windows, without ends of frames.
    pub population: Population,
    /// The measured windows.
    pub measured: Vec<Window>,
    /// Sums over ends of frames.
    ends: Figures,
    /// Traced rays of the stream (skipped ones not counted).
    rays: u64,
    /// Pixels of a window.
    window_pixels: u64,
    /// Statistics of a run that did nothing, with the longest latencies of the measured windows.
    nothing: MachineStats,
}

impl Findings {
    /// The findings of a machine's first `pass`.
    pub(crate) fn of(sampler: &Sampler<'_>, machine: &MachineSpec, cut: &Cut, pass: Pass) -> Self {
        let Pass { population, rays, found, .. } = pass;
        let (window_pixels, nothing) = (cut.window() as u64, sampler.nothing(machine));
        let mut findings = Self { population, rays, window_pixels, nothing, ..Self::default() };
        findings.add(found);
        findings
    }

    /// Adds measurements.
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

    /// Number of points with draws below `draws`.
    pub(crate) fn points(&self, draws: usize) -> usize {
        self.measured.iter().flat_map(|window| &window.hits).filter(|hit| hit.draw < draws).count()
    }

    /// The stream's statistics, estimated from the first `draws` points of each stratum.
    pub(crate) fn estimate(&self, machine: &MachineSpec, draws: usize) -> MachineStats {
        let own = self.estimates(machine, draws);
        let mut totals: BTreeMap<Figure, Total> =
            own.figures.keys().map(|figure| (figure.clone(), own.total(figure))).collect();
        for (figure, end) in &self.ends {
            totals.entry(figure.clone()).or_default().total += end;
        }
        let (points, freedom) = own.residuals(&REPORTED);
        self.stats(machine, &totals, self.residuals(points, freedom, None))
    }

    /// The same beside a baseline measured in the same windows. `residuals.change` has the error that is not shared
    /// with it.
    pub(crate) fn estimate_beside(
        &self,
        machine: &MachineSpec,
        draws: usize,
        baseline: &KnownBaseline<'_>,
    ) -> MachineStats {
        let KnownBaseline { machine: base, findings, stats, figures } = baseline;
        let residuals = stats.residuals.as_ref();
        let points = residuals.map_or(&[][..], |residuals| &residuals.points);
        let windows = findings.estimates(base, draws);
        let baseline = Baseline { windows, ends: &findings.ends, known: figures, points };
        let Corrected { totals, points, change } =
            baseline.corrected(&self.estimates(machine, draws), &self.ends, &REPORTED);
        let freedom = residuals.map_or([1.0; 3], |residuals| residuals.freedom);
        self.stats(machine, &totals, self.residuals(points, freedom, Some(change)))
    }

    fn estimates(&self, machine: &MachineSpec, draws: usize) -> Estimates {
        estimates(&self.population, &self.measured, draws, machine.line_bytes.get(), |_| true)
    }

    fn residuals(&self, points: Vec<Residual>, freedom: [f64; 3], change: Option<Change>) -> Residuals {
        let Self { population, window_pixels, .. } = self;
        Residuals { window_pixels: *window_pixels, seed: population.strata.seed, freedom, points, change }
    }

    fn stats(&self, machine: &MachineSpec, totals: &BTreeMap<Figure, Total>, residuals: Residuals) -> MachineStats {
        // Classes without bytes are left out, as in whole runs.
        let is_there = |figure: &Figure, total: &Total| !matches!(figure, Figure::Bytes(..)) || total.total > 0.0;
        let found = || totals.iter().filter(|(figure, total)| is_there(figure, total));
        let levels = Levels::new(machine);
        let mut stats = levels.with(&self.nothing, found().map(|(figure, total)| (figure, total.total)));
        stats.rays = self.rays;
        let share = |figure: Figure| totals.get(&figure).map_or(0.0, Total::share);
        let [cycles, l2_bytes, dram_bytes] = REPORTED.map(share);
        let rate = self.measured.len() as f64 / self.population.windows as f64;
        stats.accuracy = Accuracy::Estimated { cycles, l2_bytes, dram_bytes, rate };
        let half_width = |(figure, total): (&Figure, &Total)| Some((levels.path(figure)?, total.half_width));
        stats.half_widths = found().filter_map(half_width).collect();
        stats.residuals = Some(residuals);
        stats
    }
}

/// A baseline: its measurements in the sample's windows, and its known statistics.
#[derive(Clone, Copy, Debug)]
pub(crate) struct KnownBaseline<'a> {
    /// The machine.
    pub machine: &'a MachineSpec,
    /// Its measurements, in at least the windows of the others.
    pub findings: &'a Findings,
    /// Its known statistics.
    pub stats: &'a MachineStats,
    /// The figures of `stats`, each with its relative half width.
    pub figures: &'a BTreeMap<Figure, (f64, f64)>,
}
