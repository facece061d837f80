//! Totals of a population from a stratified sample, by generalised regression (Saerndal, Swensson and Wretman 1992,
//! chapters 6 and 7): covariates of all windows explain a window's figures, and only the residuals are sampled.

use std::collections::{BTreeMap, BTreeSet};

use super::covariates::{Columns, OPERATIONS, Span, explanation};
use super::figures::{Figure, Figures};
use super::regression::{Regression, dot};
use super::strata::{Point, Strata};
use crate::stats::Residual;
use crate::student::{Variance, student};

/// A replayed part: its covariates and its figures; absent figures are 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Part {
    /// Covariates.
    pub covariates: Columns,
    /// Measured figures.
    pub figures: Figures,
}

/// A measured window.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Window {
    /// The points that lie in the window.
    pub hits: Vec<Point>,
    /// Operations of the window's own rays.
    pub operations: f64,
    /// Covariates and figures of each [`Span`].
    pub spans: [Part; Span::ALL.len()],
}

/// A population of windows.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Population {
    /// The strata of its axis.
    pub strata: Strata,
    /// Number of windows.
    pub windows: usize,
    /// Sums of the covariates.
    pub covariates: Columns,
}

impl Window {
    /// The part of `span`.
    pub(crate) fn span(&self, span: Span) -> &Part {
        &self.spans[span as usize]
    }
}

impl Population {
    /// Adds covariates.
    pub(crate) fn add(&mut self, covariates: &Columns) {
        self.covariates.iter_mut().zip(covariates).for_each(|(sum, covariates)| *sum += covariates);
    }
}

/// A total and half the width of its interval.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Total {
    /// The estimate.
    pub total: f64,
    /// Half the width of the 95 % interval.
    pub half_width: f64,
}

impl Total {
    /// Relative half width.
    pub(crate) fn share(&self) -> f64 {
        if self.total > 0.0 { self.half_width / self.total } else { 0.0 }
    }
}

/// The estimate of a figure and its residuals.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Estimate {
    /// The estimate.
    pub total: f64,
    /// The residual of each point.
    pub errors: Vec<f64>,
    /// Maximum degrees of freedom.
    pub freedom: f64,
}

/// A point of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Drawn {
    /// Its position on the axis.
    pub place: f64,
    /// Its stratum; joined strata count as one.
    pub stratum: usize,
    /// Number of windows that it stands for.
    pub weight: f64,
}

/// The estimates of a sample.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Estimates {
    /// The points.
    pub points: Vec<Drawn>,
    /// The estimate and residuals of each figure.
    pub figures: BTreeMap<Figure, Estimate>,
}

impl Estimates {
    /// The variance of the weighted sum of `values`, one for each point.
    pub(crate) fn variance(&self, values: impl IntoIterator<Item = f64>) -> Variance {
        let values = self.points.iter().zip(values);
        Variance::stratified(values.map(|(point, value)| (point.stratum, value * point.weight)))
    }

    /// The total of a figure, with a 95 % interval.
    pub(crate) fn total(&self, figure: &Figure) -> Total {
        let Some(Estimate { total, errors, freedom }) = self.figures.get(figure) else { return Total::default() };
        let variance = self.variance(errors.iter().copied());
        Total { total: *total, half_width: student(variance.freedom(*freedom)) * variance.value.sqrt() }
    }

    /// The points' residuals of three figures, as shares of the estimates, and the figures' degrees of freedom.
    pub(crate) fn residuals(&self, figures: &[Figure; 3]) -> (Vec<Residual>, [f64; 3]) {
        let left = figures.each_ref().map(|figure| self.figures.get(figure));
        let share = |at: usize, left: Option<&Estimate>| {
            left.filter(|left| left.total > 0.0).map_or(0.0, |left| left.errors[at] / left.total)
        };
        let points = self.points.iter().enumerate().map(|(at, &Drawn { place, stratum, weight })| {
            let errors = left.map(|left| share(at, left));
            Residual { place, stratum, weight, errors }
        });
        (points.collect(), left.map(|left| left.map_or(1.0, |left| left.freedom)))
    }
}

/// Estimates totals from the points with draws below `draws`: of the figures that some window measured and that are
/// `wanted`. `line` is the bytes of a line.
pub(crate) fn estimates(
    population: &Population,
    windows: &[Window],
    draws: usize,
    line: u64,
    wanted: impl Fn(&Figure) -> bool,
) -> Estimates {
    let mut sample = Sample::new(population, windows, draws, line as f64);
    let figures = sample.figures().into_iter().filter(wanted);
    let figures = figures.map(|figure| (figure.clone(), sample.estimate(&figure))).collect();
    let points = sample.places.iter().zip(sample.strata_of.iter().zip(&sample.weights));
    let points = points.map(|(&place, (&stratum, &weight))| Drawn { place, stratum, weight });
    Estimates { points: points.collect(), figures }
}

/// Points of a sample, and the windows that they lie in.
struct Sample<'a> {
    population: &'a Population,
    line: f64,
    points: Vec<&'a Window>,
    /// For each point its place, its stratum (joined strata counted once) and its weight.
    places: Vec<f64>,
    strata_of: Vec<usize>,
    strata: usize,
    weights: Vec<f64>,
    /// The replay of a window is larger than the window: the factor from replays to windows.
    scale: f64,
    solvers: BTreeMap<(Span, Vec<usize>), (Regression, Vec<f64>)>,
}

impl<'a> Sample<'a> {
    fn new(population: &'a Population, windows: &'a [Window], draws: usize, line: f64) -> Self {
        let hits = windows.iter().flat_map(|window| window.hits.iter().map(move |hit| (window, hit)));
        let mut hits: Vec<(&Window, &Point)> = hits.filter(|(_, hit)| hit.draw < draws).collect();
        // In the order of the stream, whatever was measured first.
        hits.sort_by(|(_, one), (_, other)| one.place.total_cmp(&other.place));
        let (points, hits): (Vec<&Window>, Vec<&Point>) = hits.into_iter().unzip();
        let ends = population.strata.ends(draws, population.windows as f64);
        let places: Vec<f64> = hits.iter().map(|hit| hit.place).collect();
        let of: Vec<usize> = places.iter().map(|place| ends.partition_point(|end| end <= place)).collect();
        let (strata, strata_of) = joined(&ends, &of);
        let mut sampled = vec![0.0; strata.len()];
        strata_of.iter().for_each(|&stratum| sampled[stratum] += 1.0);
        // A stratum's windows are divided equally among its points.
        let weights: Vec<f64> = strata_of.iter().map(|&stratum| strata[stratum] / sampled[stratum]).collect();
        let size = |of: fn(&Window) -> f64| points.iter().zip(&weights).map(|(window, w)| w * of(window)).sum::<f64>();
        let grown = size(|window| window.span(Span::Group).covariates[OPERATIONS]);
        let scale = if grown > 0.0 { size(|window| window.operations) / grown } else { 1.0 };
        let (strata, solvers) = (strata.len(), BTreeMap::new());
        Self { population, line, points, places, strata_of, strata, weights, scale, solvers }
    }

    fn figures(&self) -> BTreeSet<Figure> {
        let parts = self.points.iter().flat_map(|window| &window.spans);
        parts.flat_map(|part| part.figures.keys().cloned()).collect()
    }

    fn estimate(&mut self, figure: &Figure) -> Estimate {
        let how = explanation(figure);
        let scale = if how.span == Span::Group { self.scale } else { 1.0 };
        let parts = || self.points.iter().map(|window| window.span(how.span));
        let covariates: Vec<Columns> =
            parts().map(|part| part.covariates.map(|covariates| covariates * scale)).collect();
        let expected = |covariates: &Columns| how.lines.map_or(0.0, |lines| covariates[lines] * self.line);
        let value = |(part, covariates): (&Part, &Columns)| {
            scale * part.figures.get(figure).copied().unwrap_or(0.0) - expected(covariates)
        };
        let values: Vec<f64> = parts().zip(&covariates).map(value).collect();
        let weights = &self.weights;
        let (solver, leverage) = self.solvers.entry((how.span, how.columns)).or_insert_with_key(|(_, columns)| {
            let solver = Regression::new(&covariates, weights, columns);
            let leverage = solver.leverage(&covariates, weights);
            (solver, leverage)
        });
        let freedom = self.points.len() as f64 - self.strata as f64 - solver.rank() as f64 + 1.0;
        let slopes = solver.slopes(&covariates, weights, &values);
        let left: Vec<f64> =
            covariates.iter().zip(&values).map(|(covariates, y)| y - dot(&slopes, covariates)).collect();
        let all = &self.population.covariates;
        // HC2 restores what the regression fitted away of a window's own residual (MacKinnon and White 1985). A
        // residual counts as much as its window does in the estimate calibrated to all covariates (Saerndal et al.
        // 1992, 6.6).
        let counts = solver.calibration(&covariates, weights, all);
        let full = left.iter().zip(leverage.iter().zip(&counts));
        let errors = full.map(|(left, (leverage, count))| count * left / (1.0 - leverage).sqrt()).collect();
        let total = expected(all) + dot(&slopes, all) + left.iter().zip(weights).map(|(left, w)| left * w).sum::<f64>();
        // A sample with no degree of freedom left is not refused here: the sampler plans at least eight points.
        Estimate { total, errors, freedom: freedom.max(1.0) }
    }
}

/// Joins a stratum with fewer than two measured points with the one before it (the first one with the one behind it).
/// Returns the lengths of the joined strata, and the stratum of each point.
fn joined(ends: &[f64], points: &[usize]) -> (Vec<f64>, Vec<usize>) {
    let mut counts = vec![0u64; ends.len()];
    points.iter().for_each(|&stratum| counts[stratum] += 1);
    let (mut merged, mut place): (Vec<(f64, u64)>, Vec<usize>) = (Vec::new(), Vec::new());
    let lengths = ends.iter().scan(0.0, |begin, &end| Some(end - std::mem::replace(begin, end)));
    for (length, some) in lengths.zip(counts) {
        match merged.last_mut() {
            Some(last) if last.1 < 2 || some < 2 => *last = (last.0 + length, last.1 + some),
            _ => merged.push((length, some)),
        }
        place.push(merged.len() - 1);
    }
    (merged.into_iter().map(|(length, _)| length).collect(), points.iter().map(|&stratum| place[stratum]).collect())
}

#[cfg(test)]
mod tests {
    use super::super::covariates::{Capacity, Covariates};
    use super::*;
    use crate::machine::MachineSpec;

    fn window(place: f64, covariates: Columns, y: f64) -> Window {
        let inside = Part { covariates, figures: [(Figure::Cycles, y)].into() };
        let other = || Part { covariates, ..Part::default() };
        let hits = vec![Point { place, draw: 0 }];
        Window { hits, operations: covariates[OPERATIONS], spans: [inside, other(), other()] }
    }

    fn strata(length: f64) -> Strata {
        Strata { length, seed: 0 }
    }

    /// Covariates with these operations and DRAM lines.
    fn covariates(operations: f64, lines: f64) -> Columns {
        let covariates = Covariates {
            operations: [operations as u64, 0, 0, 0],
            dram: [lines as u64, 0, 0, 0, 0, 0, 0, 0, 0, 0],
            ..Covariates::default()
        };
        covariates.columns(&Capacity::new(&MachineSpec::default()))
    }

    #[test]
    fn what_is_known_explains_all_that_it_can() {
        // y = 3 steps + 7 new lines: no sampling error is left, though windows differ.
        let windows: Vec<_> = (0..16u32)
            .map(|i| {
                let covariates = covariates(f64::from(100 + i * i), f64::from(i % 5));
                window(10.0 * f64::from(i), covariates, 3.0 * f64::from(100 + i * i) + 7.0 * f64::from(i % 5))
            })
            .collect();
        let population = Population { strata: strata(40.0), windows: 160, covariates: covariates(20_000.0, 300.0) };
        let Total { total, half_width } = estimates(&population, &windows, 1, 64, |_| true).total(&Figure::Cycles);
        assert!((total - 62_100.0).abs() < 1e-6, "{total}");
        assert!(half_width < 1e-6);
    }

    /// Where the measured windows have half of the operations that they stand for, each counts twice, and so does its
    /// residual.
    #[test]
    fn intervals_are_as_wide_as_windows_count() {
        let cost = |i: u32| f64::from(300 + i * i % 5);
        let windows: Vec<_> = (0..16).map(|i| window(10.0 * f64::from(i), covariates(100.0, 0.0), cost(i))).collect();
        let found = [16_000.0, 32_000.0].map(|operations| {
            let covariates = covariates(operations, 0.0);
            let population = Population { strata: strata(40.0), windows: 160, covariates };
            estimates(&population, &windows, 1, 64, |_| true).total(&Figure::Cycles)
        });
        let [once, twice] = found.map(|found| found.half_width);
        assert!(once > 1.0 && (twice / once - 2.0).abs() < 1e-9, "{once} {twice}");
    }

    #[test]
    fn a_point_that_was_not_drawn_yet_does_not_count() {
        let mut windows = [window(0.0, covariates(1.0, 0.0), 5.0), window(1.0, covariates(1.0, 0.0), 5.0)];
        windows[1].hits.push(Point { place: 1.5, draw: 4 });
        let population = Population { strata: strata(8.0), windows: 8, covariates: covariates(8.0, 0.0) };
        let at = |draws| Sample::new(&population, &windows, draws, 64.0).points.len();
        assert_eq!([1, 4, 5].map(at), [2, 2, 3]);
    }

    /// Windows with linearly growing costs, and points with draws below `draws`. Means over many seeds of the estimate,
    /// of its squared error, and of the squared error that the interval implies; relative to the truth or its square.
    fn resampled(draws: usize) -> [f64; 3] {
        const SEEDS: u32 = 2000;
        let cost = |window: usize| window as f64;
        let truth: f64 = (0..300).map(cost).sum();
        let mut means = [0.0; 3];
        for seed in 0..SEEDS {
            let strata = Strata { length: 30.0, seed: seed.into() };
            let mut points: Vec<Point> = (0..10).flat_map(|number| strata.points(number, draws)).collect();
            let mut windows = Vec::new();
            for at in 0..300 {
                let end = (at + 1) as f64;
                let hits: Vec<Point> = points.extract_if(.., |point| point.place < end).collect();
                if !hits.is_empty() {
                    windows.push(Window { hits, ..window(0.0, covariates(0.0, 0.0), cost(at)) });
                }
            }
            let population = Population { strata, windows: 300, covariates: covariates(0.0, 0.0) };
            let Total { total, half_width } =
                estimates(&population, &windows, draws, 64, |_| true).total(&Figure::Cycles);
            let error = half_width / student(1e9) / truth;
            let found = [total / truth, (total / truth - 1.0).powi(2), error * error];
            means.iter_mut().zip(found).for_each(|(mean, found)| *mean += found / f64::from(SEEDS));
        }
        means
    }

    /// With no strata halved, some, all, or all twice, estimates are unbiased, and intervals match the errors. Where
    /// neighbours are alike, four times the points in halved strata reduce the variance to far less than a quarter,
    /// which strata of constant length would give.
    #[test]
    fn halved_strata_are_unbiased_and_tell_more() {
        let found = [2, 3, 4, 8].map(resampled);
        for [mean, variance, said] in found {
            println!("mean {mean:.5}, variance {variance:.3e}, {said:.3e} by intervals");
            assert!((mean - 1.0).abs() < 4.0 * (variance / 2000.0).sqrt(), "{mean} {variance}");
            // Student's t makes intervals a little wider.
            assert!((0.9..1.6).contains(&(said / variance)), "{said} {variance}");
        }
        let [few, .., many] = found.map(|[_, variance, _]| variance);
        assert!(many < few / 16.0, "{few} {many}");
    }

    #[test]
    fn lonely_points_join_their_neighbours() {
        assert_eq!(joined(&[10.0, 14.0, 14.5], &[0, 0, 1]), (vec![14.5], vec![0; 3]));
        assert_eq!(joined(&[10.0, 14.0], &[0, 0, 1, 1]), (vec![10.0, 4.0], vec![0, 0, 1, 1]));
    }
}
