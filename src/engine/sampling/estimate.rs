//! Totals of a population from a stratified sample, by generalised regression (Saerndal, Swensson and Wretman 1992, chapters 6
//! and 7): what a window costs is explained by what is known of all windows, and only what is left over is sampled.

use std::collections::{BTreeMap, BTreeSet};

use super::job::Figures;
use super::known::{Columns, Explanation, OPERATIONS, explanation};
use super::regression::{Regression, dot, student};

/// Something that was replayed: what is known of it, and what was measured; what is not named is 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Part {
    /// What is known.
    pub known: Columns,
    /// What was measured.
    pub figures: Figures,
}

/// A window that was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Window {
    /// Its stratum.
    pub stratum: usize,
    /// Operations that its rays ask for.
    pub operations: f64,
    /// What happened between the ends of the piece before it and of its own last piece, others' rays among it: for what hangs on how much is in flight.
    pub inside: Part,
    /// What the window and the pieces beside it did from beginning to end, no others' rays among it: for what does not.
    pub group: Part,
    /// The same as `Event` measured it, if that replayed it besides.
    pub by_event: Option<Box<Window>>,
}

/// A population of windows: how many each stratum has, and what is known of all together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Population {
    /// Windows a stratum.
    pub strata: Vec<u64>,
    /// Sums.
    pub known: Columns,
}

impl Population {
    /// Adds what is known of something.
    pub fn add(&mut self, known: &Columns) {
        self.known.iter_mut().zip(known).for_each(|(sum, known)| *sum += known);
    }
}

/// A total and half the width of its interval.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Total {
    /// The estimate.
    pub total: f64,
    /// The interval reaches so far to either side; none if there are too few windows to tell.
    pub half_width: Option<f64>,
    /// What windows add to its variance, and what corrections do.
    pub variances: [f64; 2],
}

impl Total {
    /// Half the interval's width over the total.
    pub fn share(&self) -> Option<f64> {
        let half_width = self.half_width?;
        Some(if self.total > 0.0 { half_width / self.total } else { 0.0 })
    }
}

/// Estimates the total of everything that was measured in some window, with lines of so many bytes. Intervals are of 95 %. Where `Event` replayed
/// some of the windows too, what it found differently corrects the others' sum (double sampling: Cochran 1977, chapter 12); `whole` is what another
/// engine than `Event` found for everything, if it did.
pub fn estimate(
    population: &Population,
    windows: &[Window],
    whole: Option<&Figures>,
    line: u64,
) -> BTreeMap<String, Total> {
    let windows: Vec<&Window> = windows.iter().collect();
    let mut sample = Sample::new(population, &windows, line);
    let both: Vec<&Window> = windows.iter().copied().filter(|window| window.by_event.is_some()).collect();
    if both.is_empty() {
        return sample.names().into_iter().map(|name| (name.clone(), sample.fit(&name).total())).collect();
    }
    let by_event: Vec<&Window> = both.iter().filter_map(|window| window.by_event.as_deref()).collect();
    let first = Sample { scale: sample.scale, ..Sample::new(population, &both, line) };
    let mut second = Sample { scale: sample.scale, ..Sample::new(population, &by_event, line) };
    let known = sample.names();
    let names: BTreeSet<String> = known.iter().cloned().chain(second.names()).collect();
    let mut total = |name: &String| {
        if !known.contains(name) {
            return second.fit(name).total();
        }
        let fit = sample.fit(name);
        let [left, right] = [&first, &second].map(|sample| sample.left(name, &fit.slopes));
        let apart: Vec<f64> = left.iter().zip(&right).map(|(left, right)| right - left).collect();
        let correction = second.weighted(&apart);
        let spread = second.spread(&apart);
        if let Some(whole) = whole {
            let total = whole.get(name).copied().unwrap_or(0.0) + correction;
            return Fit { total, spread: Spread::default(), ..fit }.corrected(spread, second.freedom());
        }
        // Where windows that cost more than was expected are those whose correction is larger, errors of both add up.
        let joint = second.spread(&right).variance - second.spread(&left).variance - spread.variance;
        let covariance = (joint * both.len() as f64 / windows.len() as f64).max(0.0);
        let base = Spread { variance: fit.spread.variance + covariance, ..fit.spread };
        Fit { total: fit.total + correction, spread: base, ..fit }.corrected(spread, second.freedom())
    };
    names.into_iter().map(|name| (name.clone(), total(&name))).collect()
}

/// How much totals of a sample differ from sample to sample: the variance, and the sum of the strata's squared variances over how well each is known.
#[derive(Clone, Copy, Debug, Default)]
struct Spread {
    variance: f64,
    squares: f64,
}

/// The estimate of a figure.
struct Fit {
    total: f64,
    slopes: Columns,
    spread: Spread,
    freedom: f64,
    is_complete: bool,
}

impl Fit {
    fn total(&self) -> Total {
        let half_width = if self.is_complete { Some(0.0) } else { half_width(self.spread, self.freedom) };
        Total { total: self.total, half_width, variances: [self.spread.variance, 0.0] }
    }

    /// The same with a correction that is itself known from a sample.
    fn corrected(&self, correction: Spread, freedom: f64) -> Total {
        let variances = [self.spread.variance, correction.variance];
        let spread = Spread {
            variance: variances.iter().sum(),
            squares: self.spread.squares + correction.squares,
        };
        Total { total: self.total, half_width: half_width(spread, self.freedom.max(0.0) + freedom), variances }
    }
}

/// Strata that vary more than others count for few degrees of freedom: Welch 1947, whose -2 and +2 set right that the variances are estimates
/// themselves.
fn half_width(Spread { variance, squares }: Spread, freedom: f64) -> Option<f64> {
    if variance == 0.0 && freedom >= 1.0 {
        return Some(0.0);
    }
    let freedom =
        if squares > 0.0 && freedom >= 1.0 { freedom.min(variance * variance / squares - 2.0).max(1.0) } else { freedom };
    (freedom >= 1.0).then(|| student(freedom) * variance.sqrt())
}

/// Windows of a population, as one engine measured them.
struct Sample<'a> {
    population: &'a Population,
    line: f64,
    /// Windows of each stratum, and those that were measured.
    strata: Vec<u64>,
    sampled: Vec<u64>,
    /// The stratum of each window.
    place: Vec<usize>,
    weights: Vec<f64>,
    /// A window's group is larger than itself: all are brought to the windows' size.
    scale: f64,
    /// What is known and what was measured, between the windows' ends and of their groups.
    known: [Vec<Columns>; 2],
    figures: [Vec<&'a Figures>; 2],
    solvers: BTreeMap<(bool, Vec<usize>), (Regression, Vec<f64>)>,
}

impl<'a> Sample<'a> {
    fn new(population: &'a Population, windows: &[&'a Window], line: u64) -> Self {
        let (strata, place) = joined(&population.strata, windows);
        let mut sampled = vec![0u64; strata.len()];
        place.iter().for_each(|&stratum| sampled[stratum] += 1);
        let weights = place.iter().map(|&stratum| strata[stratum] as f64 / sampled[stratum] as f64).collect();
        let size = |of: fn(&Window) -> f64| windows.iter().map(|window| of(window)).sum::<f64>();
        let grown = size(|window| window.group.known[OPERATIONS]);
        let scale = if grown > 0.0 { size(|window| window.operations) / grown } else { 1.0 };
        let parts: [fn(&Window) -> &Part; 2] = [|window| &window.inside, |window| &window.group];
        Self {
            population,
            line: line as f64,
            strata,
            sampled,
            place,
            weights,
            scale,
            known: parts.map(|part| windows.iter().map(|window| part(window).known).collect()),
            figures: parts.map(|part| windows.iter().map(|&window| &part(window).figures).collect()),
            solvers: BTreeMap::new(),
        }
    }

    fn names(&self) -> BTreeSet<String> {
        self.figures.iter().flatten().flat_map(|figures| figures.keys().cloned()).collect()
    }

    fn scale(&self, how: &Explanation) -> f64 {
        if how.of_group { self.scale } else { 1.0 }
    }

    fn rows(&self, how: &Explanation) -> Vec<Columns> {
        let scale = self.scale(how);
        self.known[usize::from(how.of_group)].iter().map(|known| known.map(|known| known * scale)).collect()
    }

    /// What is expected without a sample.
    fn expected(&self, how: &Explanation, known: &Columns) -> f64 {
        how.lines.map_or(0.0, |lines| known[lines] * self.line)
    }

    /// What was measured beyond what is expected.
    fn values(&self, name: &str, how: &Explanation, known: &[Columns]) -> Vec<f64> {
        let figures = &self.figures[usize::from(how.of_group)];
        let value = |figures: &&Figures| self.scale(how) * figures.get(name).copied().unwrap_or(0.0);
        figures.iter().map(value).zip(known).map(|(value, known)| value - self.expected(how, known)).collect()
    }

    /// What `slopes` do not explain.
    fn left(&self, name: &str, slopes: &Columns) -> Vec<f64> {
        let how = explanation(name);
        let known = self.rows(&how);
        self.values(name, &how, &known).iter().zip(&known).map(|(value, known)| value - dot(slopes, known)).collect()
    }

    fn weighted(&self, values: &[f64]) -> f64 {
        values.iter().zip(&self.weights).map(|(value, weight)| value * weight).sum()
    }

    fn freedom(&self) -> f64 {
        self.place.len() as f64 - self.strata.len() as f64
    }

    fn fit(&mut self, name: &str) -> Fit {
        let how = explanation(name);
        let known = self.rows(&how);
        let values = self.values(name, &how, &known);
        let weights = &self.weights;
        let of = (how.of_group, how.columns.clone());
        let (solver, leverage) = self.solvers.entry(of).or_insert_with_key(|(_, columns)| {
            let solver = Regression::new(&known, weights, columns);
            let leverage = solver.leverage(&known, weights);
            (solver, leverage)
        });
        let slopes = solver.slopes(&known, weights, &values);
        let rank = solver.rank() as f64;
        let left: Vec<f64> = known.iter().zip(&values).map(|(known, y)| y - dot(&slopes, known)).collect();
        // What the regression fitted away of a window's own residual is given back (MacKinnon and White 1985, HC2).
        let full: Vec<f64> =
            left.iter().zip(leverage.iter()).map(|(left, leverage)| left / (1.0 - leverage).sqrt()).collect();
        let all = &self.population.known;
        Fit {
            total: self.expected(&how, all) + dot(&slopes, all) + self.weighted(&left),
            slopes,
            spread: self.spread(&full),
            freedom: self.freedom() - rank + 1.0,
            is_complete: self.strata == self.sampled,
        }
    }

    fn spread(&self, values: &[f64]) -> Spread {
        let mut spread = Spread::default();
        for (stratum, (&all, &some)) in self.strata.iter().zip(&self.sampled).enumerate() {
            let here = || self.place.iter().zip(values).filter(|(place, _)| **place == stratum).map(|(_, value)| *value);
            let (all, some) = (all as f64, some as f64);
            if some > 1.0 {
                let mean = here().sum::<f64>() / some;
                let squares = here().map(|value| (value - mean).powi(2)).sum::<f64>() / (some - 1.0);
                let here = all * all * (1.0 - some / all) * squares / some;
                spread.variance += here;
                spread.squares += here * here / (some + 1.0);
            }
        }
        spread
    }
}

/// Strata of which fewer than two windows were measured are joined with the one before (or, at the beginning, behind): how many windows each
/// has then, and the stratum of each window that was measured.
fn joined(strata: &[u64], windows: &[&Window]) -> (Vec<u64>, Vec<usize>) {
    let count = |stratum: usize| windows.iter().filter(|window| window.stratum == stratum).count() as u64;
    let (mut merged, mut place): (Vec<(u64, u64)>, Vec<usize>) = (Vec::new(), Vec::new());
    for (stratum, &all) in strata.iter().enumerate() {
        let some = count(stratum);
        match merged.last_mut() {
            Some(last) if last.1 < 2 || some < 2 && (some < all || all == 0) => *last = (last.0 + all, last.1 + some),
            _ => merged.push((all, some)),
        }
        place.push(merged.len() - 1);
    }
    let windows = windows.iter().map(|window| place[window.stratum]).collect();
    (merged.into_iter().map(|(all, _)| all).collect(), windows)
}

#[cfg(test)]
mod tests {
    use super::super::known::{Capacity, Known};
    use super::*;
    use crate::machine::MachineSpec;

    fn window(stratum: usize, known: Columns, y: f64) -> Window {
        let inside = Part { known, figures: [("y".to_owned(), y)].into() };
        Window { stratum, operations: known[OPERATIONS], group: Part { known, ..Part::default() }, inside }
    }

    /// Operations and lines of the DRAM.
    fn known(operations: f64, lines: f64) -> Columns {
        let known = Known {
            operations: [operations as u64, 0, 0, 0],
            dram: [lines as u64, 0, 0, 0, 0, 0, 0],
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
                window(i as usize / 4, known, 3.0 * f64::from(100 + i * i) + 7.0 * f64::from(i % 5))
            })
            .collect();
        let population = Population { strata: vec![40; 4], known: known(20_000.0, 300.0) };
        let Total { total, half_width } = estimate(&population, &windows, 64)["y"];
        assert!((total - 62_100.0).abs() < 1e-6, "{total}");
        assert!(half_width.unwrap() < 1e-6);
    }

    #[test]
    fn a_complete_sample_is_the_sum() {
        let windows: Vec<_> = (0..6).map(|i| window(i / 2, known(1.0, 0.0), (i * i) as f64)).collect();
        let total = estimate(&Population { strata: vec![2; 3], known: known(6.0, 0.0) }, &windows, 64)["y"];
        assert!((total.total - 55.0).abs() < 1e-9);
        assert_eq!(total.half_width, Some(0.0));
    }

    #[test]
    fn lonely_windows_join_their_neighbours() {
        let one = known(1.0, 0.0);
        let windows = [window(0, one, 5.0), window(0, one, 5.0), window(1, one, 5.0)];
        assert_eq!(joined(&[10, 4, 0], &windows), (vec![14], vec![0; 3]));
    }
}
