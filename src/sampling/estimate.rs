//! Totals of a population from a stratified sample, by generalised regression (Saerndal, Swensson and Wretman 1992,
//! chapters 6 and 7): what a window costs is explained by what is known of all windows, and only what is left over is
//! sampled.

use std::collections::{BTreeMap, BTreeSet};

use super::figures::{Figure, Figures};
use super::known::{Columns, OPERATIONS, Span, explanation};
use super::regression::{Regression, dot};
use super::strata::{Point, Strata};
use crate::stats::Residual;
use crate::student::{Variance, student};

/// Something that was replayed: what is known of it, and what was measured; what is not named is 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Part {
    /// What is known.
    pub known: Columns,
    /// What was measured.
    pub figures: Figures,
}

/// A window that was measured.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Window {
    /// The points that lie in it.
    pub hits: Vec<Point>,
    /// Operations that its rays ask for.
    pub operations: f64,
    /// What each span did.
    pub spans: [Part; Span::ALL.len()],
}

/// A population of windows: the strata of its axis, how many windows there are, and what is known of all together.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Population {
    /// Strata.
    pub strata: Strata,
    /// Windows.
    pub windows: usize,
    /// Sums.
    pub known: Columns,
}

impl Window {
    /// What a span did.
    pub(crate) fn span(&self, span: Span) -> &Part {
        &self.spans[span as usize]
    }
}

impl Population {
    /// Adds what is known of something.
    pub(crate) fn add(&mut self, known: &Columns) {
        self.known.iter_mut().zip(known).for_each(|(sum, known)| *sum += known);
    }
}

/// A total and half the width of its interval.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Total {
    /// The estimate.
    pub total: f64,
    /// The interval reaches so far to either side.
    pub half_width: f64,
}

impl Total {
    /// Half the interval's width over the total.
    pub(crate) fn share(&self) -> f64 {
        if self.total > 0.0 { self.half_width / self.total } else { 0.0 }
    }
}

/// What the windows leave over of a figure.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Left {
    /// The estimate.
    pub total: f64,
    /// By point, what is off there.
    pub errors: Vec<f64>,
    /// Degrees of freedom at most.
    pub freedom: f64,
}

/// A point of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Drawn {
    /// Where it lies.
    pub place: f64,
    /// Its stratum; those of joined ones are one.
    pub stratum: usize,
    /// Windows that it stands for.
    pub weight: f64,
}

/// What the points of a sample tell.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Estimates {
    /// The points.
    pub points: Vec<Drawn>,
    /// What they leave over of each figure.
    pub left: BTreeMap<Figure, Left>,
}

impl Estimates {
    /// The variance of the sum of values, one for each point.
    pub(crate) fn variance(&self, values: impl IntoIterator<Item = f64>) -> Variance {
        let values = self.points.iter().zip(values);
        Variance::stratified(values.map(|(point, value)| (point.stratum, value * point.weight)))
    }

    /// The total of a figure. The interval is of 95 %.
    pub(crate) fn total(&self, figure: &Figure) -> Total {
        let Some(Left { total, errors, freedom }) = self.left.get(figure) else { return Total::default() };
        let variance = self.variance(errors.iter().copied());
        Total { total: *total, half_width: student(variance.freedom(*freedom)) * variance.value.sqrt() }
    }

    /// What the points are off of three figures, as shares of the estimates, and the degrees of freedom.
    pub(crate) fn residuals(&self, figures: &[Figure; 3]) -> (Vec<Residual>, [f64; 3]) {
        let left = figures.each_ref().map(|figure| self.left.get(figure));
        let share = |at: usize, left: Option<&Left>| {
            left.filter(|left| left.total > 0.0).map_or(0.0, |left| left.errors[at] / left.total)
        };
        let points = self.points.iter().enumerate().map(|(at, &Drawn { place, stratum, weight })| {
            let errors = left.map(|left| share(at, left));
            Residual { place, stratum, weight, errors }
        });
        (points.collect(), left.map(|left| left.map_or(1.0, |left| left.freedom)))
    }
}

/// Estimates the totals of those `wanted` of the figures that were measured in some window, by the points with draws
/// below `draws`, with lines of so many bytes.
pub(crate) fn estimates(
    population: &Population,
    windows: &[Window],
    draws: usize,
    line: u64,
    wanted: impl Fn(&Figure) -> bool,
) -> Estimates {
    let mut sample = Sample::new(population, windows, draws, line as f64);
    let figures = sample.figures().into_iter().filter(wanted);
    let left = figures.map(|figure| (figure.clone(), sample.left(&figure))).collect();
    let points = sample.places.iter().zip(sample.strata_of.iter().zip(&sample.weights));
    let points = points.map(|(&place, (&stratum, &weight))| Drawn { place, stratum, weight });
    Estimates { points: points.collect(), left }
}

/// Points of a sample, and the windows that they lie in.
struct Sample<'a> {
    population: &'a Population,
    line: f64,
    points: Vec<&'a Window>,
    /// The place of each point, its stratum, joined ones counted once, and its weight.
    places: Vec<f64>,
    strata_of: Vec<usize>,
    strata: usize,
    weights: Vec<f64>,
    /// A window's group is larger than itself: all are brought to the windows' size.
    scale: f64,
    solvers: BTreeMap<(Span, Vec<usize>), (Regression, Vec<f64>)>,
}

impl<'a> Sample<'a> {
    fn new(population: &'a Population, windows: &'a [Window], draws: usize, line: f64) -> Self {
        let hits = windows.iter().flat_map(|window| window.hits.iter().map(move |hit| (window, hit)));
        let mut hits: Vec<(&Window, &Point)> = hits.filter(|(_, hit)| hit.draw < draws).collect();
        // Whatever was measured first: in the order of the stream.
        hits.sort_by(|(_, one), (_, other)| one.place.total_cmp(&other.place));
        let (points, hits): (Vec<&Window>, Vec<&Point>) = hits.into_iter().unzip();
        let ends = population.strata.ends(draws, population.windows as f64);
        let places: Vec<f64> = hits.iter().map(|hit| hit.place).collect();
        let of: Vec<usize> = places.iter().map(|place| ends.partition_point(|end| end <= place)).collect();
        let (strata, strata_of) = joined(&ends, &of);
        let mut sampled = vec![0.0; strata.len()];
        strata_of.iter().for_each(|&stratum| sampled[stratum] += 1.0);
        // A point stands for its share of the stratum's windows.
        let weights: Vec<f64> = strata_of.iter().map(|&stratum| strata[stratum] / sampled[stratum]).collect();
        let size = |of: fn(&Window) -> f64| points.iter().zip(&weights).map(|(window, w)| w * of(window)).sum::<f64>();
        let grown = size(|window| window.span(Span::Group).known[OPERATIONS]);
        let scale = if grown > 0.0 { size(|window| window.operations) / grown } else { 1.0 };
        let (strata, solvers) = (strata.len(), BTreeMap::new());
        Self { population, line, points, places, strata_of, strata, weights, scale, solvers }
    }

    fn figures(&self) -> BTreeSet<Figure> {
        let parts = self.points.iter().flat_map(|window| &window.spans);
        parts.flat_map(|part| part.figures.keys().cloned()).collect()
    }

    fn left(&mut self, figure: &Figure) -> Left {
        let how = explanation(figure);
        let scale = if how.span == Span::Group { self.scale } else { 1.0 };
        let parts = || self.points.iter().map(|window| window.span(how.span));
        let known: Vec<Columns> = parts().map(|part| part.known.map(|known| known * scale)).collect();
        let expected = |known: &Columns| how.lines.map_or(0.0, |lines| known[lines] * self.line);
        let value = |(part, known): (&Part, &Columns)| {
            scale * part.figures.get(figure).copied().unwrap_or(0.0) - expected(known)
        };
        let values: Vec<f64> = parts().zip(&known).map(value).collect();
        let weights = &self.weights;
        let (solver, leverage) = self.solvers.entry((how.span, how.columns)).or_insert_with_key(|(_, columns)| {
            let solver = Regression::new(&known, weights, columns);
            let leverage = solver.leverage(&known, weights);
            (solver, leverage)
        });
        let freedom = self.points.len() as f64 - self.strata as f64 - solver.rank() as f64 + 1.0;
        let slopes = solver.slopes(&known, weights, &values);
        let left: Vec<f64> = known.iter().zip(&values).map(|(known, y)| y - dot(&slopes, known)).collect();
        let all = &self.population.known;
        // What the regression fitted away of a window's own residual is given back (MacKinnon and White 1985, HC2), and
        // it counts as much as the window does in the estimate once what is known of all windows is right (Saerndal et
        // al. 1992, 6.6).
        let counts = solver.calibration(&known, weights, all);
        let full = left.iter().zip(leverage.iter().zip(&counts));
        let errors = full.map(|(left, (leverage, count))| count * left / (1.0 - leverage).sqrt()).collect();
        let total = expected(all) + dot(&slopes, all) + left.iter().zip(weights).map(|(left, w)| left * w).sum::<f64>();
        // A point measures nothing by itself: `Sampler` asks for eight.
        Left { total, errors, freedom: freedom.max(1.0) }
    }
}

/// Strata with these ends of which fewer than two points were measured are joined with the one before (or, at the
/// beginning, behind): how long each is then, and the stratum of each point.
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
    use super::super::known::{Capacity, Known};
    use super::*;
    use crate::machine::MachineSpec;

    fn window(place: f64, known: Columns, y: f64) -> Window {
        let inside = Part { known, figures: [(Figure::Cycles, y)].into() };
        let other = || Part { known, ..Part::default() };
        let hits = vec![Point { place, draw: 0 }];
        Window { hits, operations: known[OPERATIONS], spans: [inside, other(), other()] }
    }

    fn strata(length: f64) -> Strata {
        Strata { length, seed: 0 }
    }

    /// Operations and lines of the DRAM.
    fn known(operations: f64, lines: f64) -> Columns {
        let known = Known {
            operations: [operations as u64, 0, 0, 0],
            dram: [lines as u64, 0, 0, 0, 0, 0, 0, 0, 0, 0],
            ..Known::default()
        };
        known.columns(&Capacity::new(&MachineSpec::default()))
    }

    #[test]
    fn what_is_known_explains_all_that_it_can() {
        // y = 3 steps + 7 new lines: no sampling error is left, though windows differ.
        let windows: Vec<_> = (0..16u32)
            .map(|i| {
                let known = known(f64::from(100 + i * i), f64::from(i % 5));
                window(10.0 * f64::from(i), known, 3.0 * f64::from(100 + i * i) + 7.0 * f64::from(i % 5))
            })
            .collect();
        let population = Population { strata: strata(40.0), windows: 160, known: known(20_000.0, 300.0) };
        let Total { total, half_width } = estimates(&population, &windows, 1, 64, |_| true).total(&Figure::Cycles);
        assert!((total - 62_100.0).abs() < 1e-6, "{total}");
        assert!(half_width < 1e-6);
    }

    /// Where the windows that were measured have half of the operations that they should stand for, each counts twice,
    /// and so does what is left over.
    #[test]
    fn intervals_are_as_wide_as_windows_count() {
        let cost = |i: u32| f64::from(300 + i * i % 5);
        let windows: Vec<_> = (0..16).map(|i| window(10.0 * f64::from(i), known(100.0, 0.0), cost(i))).collect();
        let found = [16_000.0, 32_000.0].map(|operations| {
            let known = known(operations, 0.0);
            let population = Population { strata: strata(40.0), windows: 160, known };
            estimates(&population, &windows, 1, 64, |_| true).total(&Figure::Cycles)
        });
        let [once, twice] = found.map(|found| found.half_width);
        assert!(once > 1.0 && (twice / once - 2.0).abs() < 1e-9, "{once} {twice}");
    }

    #[test]
    fn a_point_that_was_not_drawn_yet_does_not_count() {
        let mut windows = [window(0.0, known(1.0, 0.0), 5.0), window(1.0, known(1.0, 0.0), 5.0)];
        windows[1].hits.push(Point { place: 1.5, draw: 4 });
        let population = Population { strata: strata(8.0), windows: 8, known: known(8.0, 0.0) };
        let at = |draws| Sample::new(&population, &windows, draws, 64.0).points.len();
        assert_eq!([1, 4, 5].map(at), [2, 2, 3]);
    }

    /// Windows along which what they cost grows, with points drawn by `draws`: means over many
    /// seeds of what is estimated, of its squared error, and of what the interval says that this is, over the truth or
    /// its square.
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
                    windows.push(Window { hits, ..window(0.0, known(0.0, 0.0), cost(at)) });
                }
            }
            let population = Population { strata, windows: 300, known: known(0.0, 0.0) };
            let Total { total, half_width } =
                estimates(&population, &windows, draws, 64, |_| true).total(&Figure::Cycles);
            let error = half_width / student(1e9) / truth;
            let found = [total / truth, (total / truth - 1.0).powi(2), error * error];
            means.iter_mut().zip(found).for_each(|(mean, found)| *mean += found / f64::from(SEEDS));
        }
        means
    }

    /// Whether no stratum is halved, some are, all are, or all twice: estimates are right on average, and intervals as
    /// wide as they are off. Where neighbours are alike, four times as many points tell much more than in strata as
    /// long as before, where variance would be a quarter.
    #[test]
    fn halved_strata_are_unbiased_and_tell_more() {
        let found = [2, 3, 4, 8].map(resampled);
        for [mean, variance, said] in found {
            println!("mean {mean:.5}, variance {variance:.3e}, {said:.3e} by intervals");
            assert!((mean - 1.0).abs() < 4.0 * (variance / 2000.0).sqrt(), "{mean} {variance}");
            // Intervals are a little wider, by Student's t.
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
