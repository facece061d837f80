//! A machine that others are measured against. What a sample is off is mostly what a sample of the same windows on
//! another machine is off. Where more is known of that one, it sets the others right: a regression estimator in two
//! phases (Saerndal et al. 1992, 9.7), whose slope is that of what both leave over.

use std::collections::BTreeMap;

use super::estimate::{Estimates, Left, Total};
use super::figures::{Figure, Figures, Levels};
use crate::machine::MachineSpec;
use crate::stats::{Change, MachineStats, Residual};
use crate::student::student;

/// The most that is taken of what the baseline is off: a slope from few points may be far too steep.
const STEEPEST: f64 = 2.0;

/// What is known of the baseline, and what the same windows as others' let be estimated of it.
#[derive(Debug)]
pub(super) struct Baseline<'a> {
    /// The windows.
    pub windows: Estimates,
    /// Sums over frames' ends.
    pub ends: &'a Figures,
    /// Its figures as they are known, and half the widths of their intervals as shares of them.
    pub known: &'a BTreeMap<Figure, (f64, f64)>,
    /// What the windows are off by which its figures are known.
    pub points: &'a [Residual],
}

/// The figures of a run, each with half the width of its interval as a share of it.
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

/// What a sample tells beside its baseline.
#[derive(Debug)]
pub(super) struct Told {
    /// The figures.
    pub totals: BTreeMap<Figure, Total>,
    /// What the points of the baseline's larger sample are off, as far as that is the machine's too.
    pub points: Vec<Residual>,
    /// What its own points are off otherwise than the baseline's.
    pub change: Change,
}

/// How a figure hangs on the baseline's.
struct Slope {
    slope: f64,
    /// By point, what is off otherwise, as a share.
    errors: Vec<f64>,
    freedom: f64,
}

impl Baseline<'_> {
    /// What a sample of the same windows tells; `told` are the figures whose errors are told point by point.
    pub(super) fn told(&self, own: &Estimates, ends: &Figures, told: &[Figure; 3]) -> Told {
        let mut slopes: BTreeMap<&Figure, Slope> = BTreeMap::new();
        let mut totals = BTreeMap::new();
        for (figure, left) in &own.left {
            let end = |ends: &Figures| ends.get(figure).copied().unwrap_or_default();
            let total = left.total + end(ends);
            let slope = self.slope(own, figure, left, total);
            let (value, share) = self.known.get(figure).copied().unwrap_or_default();
            let base = self.windows.left.get(figure).map_or(0.0, |left| left.total + end(self.ends));
            let off = if base > 0.0 { value / base - 1.0 } else { 0.0 };
            let total = total * (1.0 + slope.slope * off);
            let half = self.half(own, &slope).hypot(slope.slope * share);
            totals.insert(figure.clone(), Total { total, half_width: total * half });
            slopes.insert(figure, slope);
        }
        // What no window does, frames' ends may.
        for (figure, &end) in ends.iter().filter(|(figure, _)| !own.left.contains_key(figure)) {
            totals.insert(figure.clone(), Total { total: end, half_width: 0.0 });
        }
        let of = |at: usize| slopes.get(&told[at]);
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
        Told { totals, points: self.points.iter().map(shared).collect(), change }
    }

    /// Half the width of the interval of what is off otherwise, as a share.
    fn half(&self, own: &Estimates, slope: &Slope) -> f64 {
        let variance = own.variance(slope.errors.iter().copied());
        student(variance.freedom(slope.freedom)) * variance.value.sqrt()
    }

    fn slope(&self, own: &Estimates, figure: &Figure, left: &Left, total: f64) -> Slope {
        let share = |errors: &[f64], total: f64| -> Vec<f64> {
            errors.iter().map(|error| if total > 0.0 { error / total } else { 0.0 }).collect()
        };
        let errors = share(&left.errors, total);
        let alone = |errors| Slope { slope: 0.0, errors, freedom: left.freedom };
        // Of a figure that nobody knows of the baseline, nothing can be set right.
        let base = self.windows.left.get(figure).filter(|_| self.known.contains_key(figure));
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
        Slope { slope, errors, freedom: (left.freedom - 1.0).max(1.0) }
    }
}
