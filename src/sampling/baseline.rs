//! A baseline: a machine that other machines are measured against. The sampling errors of two machines in the same
//! windows are correlated. Where the baseline is known better, it corrects the others: a regression estimator in two
//! phases (Saerndal et al. 1992, 9.7), whose slope is the regression of their residuals on the baseline's.

use std::collections::BTreeMap;

use super::estimate::{Estimate, Estimates, Total};
use super::figures::{Figure, Figures, Levels};
use crate::machine::MachineSpec;
use crate::stats::{Change, MachineStats, Residual};
use crate::student::student;

/// Maximum slope: one estimated from few points may be far too steep.
const STEEPEST: f64 = 2.0;

/// The baseline's known figures, and its estimates from the same windows as the other machines'.
#[derive(Debug)]
pub(super) struct Baseline<'a> {
    /// Estimates from the same windows.
    pub windows: Estimates,
    /// Sums over ends of frames.
    pub ends: &'a Figures,
    /// Its known figures, each with its relative half width.
    pub known: &'a BTreeMap<Figure, (f64, f64)>,
    /// The residuals of the sample that the known figures come from.
    pub points: &'a [Residual],
}

/// The figures of a run, each with its relative half width.
pub(super) fn known(machine: &MachineSpec, stats: &MachineStats) -> BTreeMap<Figure, (f64, f64)> {
    let levels = Levels::new(machine);
    let [cycles, l2_bytes, dram_bytes] = stats.accuracy.shares().unwrap_or_default();
    let share = |figure: &Figure, value: f64| match figure {
        Figure::Cycles => cycles,
        Figure::L2Bytes => l2_bytes,
        Figure::DramBytes => dram_bytes,
        other => {
            let half = levels.path(other).and_then(|path| stats.half_widths.get(&path).copied());
            if value > 0.0 { half.unwrap_or_default() / value } else { 0.0 }
        }
    };
    let figures = levels.figures(stats);
    figures.into_iter().map(|(figure, value)| (figure.clone(), (value, share(&figure, value)))).collect()
}

/// The result of a sample beside a baseline.
#[derive(Debug)]
pub(super) struct Corrected {
    /// Corrected totals.
    pub totals: BTreeMap<Figure, Total>,
    /// The residuals of the baseline's larger sample times the slope: the error shared with the baseline.
    pub points: Vec<Residual>,
    /// The residuals of the machine's own points that are not shared with the baseline.
    pub change: Change,
}

/// The regression of a figure on the baseline's.
struct Slope {
    slope: f64,
    /// For each point, the relative error that is not shared.
    errors: Vec<f64>,
    freedom: f64,
}

impl Baseline<'_> {
    /// The result of a sample of the same windows; `reported` are the figures whose errors are reported for each point.
    pub(super) fn corrected(&self, own: &Estimates, ends: &Figures, reported: &[Figure; 3]) -> Corrected {
        let mut slopes: BTreeMap<&Figure, Slope> = BTreeMap::new();
        let mut totals = BTreeMap::new();
        for (figure, estimate) in &own.figures {
            let end = |ends: &Figures| ends.get(figure).copied().unwrap_or_default();
            let total = estimate.total + end(ends);
            let slope = self.slope(own, figure, estimate, total);
            let (value, share) = self.known.get(figure).copied().unwrap_or_default();
            let base = self.windows.figures.get(figure).map_or(0.0, |estimate| estimate.total + end(self.ends));
            let off = if base > 0.0 { value / base - 1.0 } else { 0.0 };
            let total = total * (1.0 + slope.slope * off);
            let half = self.half(own, &slope).hypot(slope.slope * share);
            totals.insert(figure.clone(), Total { total, half_width: total * half });
            slopes.insert(figure, slope);
        }
        // Figures that only ends of frames have.
        for (figure, &end) in ends.iter().filter(|(figure, _)| !own.figures.contains_key(figure)) {
            totals.insert(figure.clone(), Total { total: end, half_width: 0.0 });
        }
        let of = |at: usize| slopes.get(&reported[at]);
        let errors =
            |value: &dyn Fn(usize, &Slope) -> f64| [0, 1, 2].map(|at| of(at).map_or(0.0, |slope| value(at, slope)));
        let shared =
            |point: &Residual| Residual { errors: errors(&|at, slope| slope.slope * point.errors[at]), ..*point };
        let own_points = own.points.iter().enumerate().map(|(point, drawn)| Residual {
            place: drawn.place,
            stratum: drawn.stratum,
            weight: drawn.weight,
            errors: errors(&|_, slope| slope.errors[point]),
        });
        let change = Change {
            points: own_points.collect(),
            freedom: [0, 1, 2].map(|at| of(at).map_or(1.0, |slope| slope.freedom)),
            half_widths: errors(&|_, slope| self.half(own, slope)),
        };
        Corrected { totals, points: self.points.iter().map(shared).collect(), change }
    }

    /// Relative half width of the error that is not shared.
    fn half(&self, own: &Estimates, slope: &Slope) -> f64 {
        let variance = own.variance(slope.errors.iter().copied());
        student(variance.freedom(slope.freedom)) * variance.value.sqrt()
    }

    fn slope(&self, own: &Estimates, figure: &Figure, estimate: &Estimate, total: f64) -> Slope {
        let share = |errors: &[f64], total: f64| -> Vec<f64> {
            errors.iter().map(|error| if total > 0.0 { error / total } else { 0.0 }).collect()
        };
        let errors = share(&estimate.errors, total);
        let alone = |errors| Slope { slope: 0.0, errors, freedom: estimate.freedom };
        // A figure that is not known of the baseline is not corrected.
        let base = self.windows.figures.get(figure).filter(|_| self.known.contains_key(figure));
        let Some(base) = base else { return alone(errors) };
        let base_total = base.total + self.ends.get(figure).copied().unwrap_or_default();
        let all = share(&base.errors, base_total);
        let at = |place: f64| self.windows.points.iter().position(|point| point.place == place);
        let others: Option<Vec<f64>> = own.points.iter().map(|point| Some(all[at(point.place)?])).collect();
        let Some(others) = others else { return alone(errors) };
        let both = |sign: f64| own.variance(errors.iter().zip(&others).map(|(own, other)| own + sign * other)).value;
        let alike = (both(1.0) - both(-1.0)) / 4.0;
        let varies = own.variance(others.iter().copied()).value;
        let slope = if varies > 0.0 { (alike / varies).clamp(0.0, STEEPEST) } else { 0.0 };
        let errors = errors.iter().zip(&others).map(|(own, other)| own - slope * other).collect();
        // The slope takes a degree of freedom.
        Slope { slope, errors, freedom: (estimate.freedom - 1.0).max(1.0) }
    }
}
