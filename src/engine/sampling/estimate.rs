//! Totals of a population from a stratified sample, by generalised regression (Saerndal, Swensson and Wretman 1992, chapters 6
//! and 7): what a window costs is explained by what is known of all windows, and only what is left over is sampled.

use std::collections::{BTreeMap, BTreeSet};

use super::job::Figures;
use super::known::{COLUMNS, Columns, OPERATIONS, explanation};

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
}

impl Total {
    /// Half the interval's width over the total.
    pub fn share(&self) -> Option<f64> {
        let half_width = self.half_width?;
        Some(if self.total > 0.0 { half_width / self.total } else { 0.0 })
    }
}

/// Estimates the total of everything that was measured in some window, with lines of so many bytes. Intervals are of 95 %.
pub fn estimate(population: &Population, windows: &[Window], line: u64) -> BTreeMap<String, Total> {
    let (strata, place) = joined(&population.strata, windows);
    let mut sampled = vec![0u64; strata.len()];
    place.iter().for_each(|&stratum| sampled[stratum] += 1);
    let weights: Vec<f64> = place.iter().map(|&stratum| strata[stratum] as f64 / sampled[stratum] as f64).collect();
    // A window's group is larger than itself: all are brought to the windows' size.
    let size = |of: fn(&Window) -> f64| windows.iter().map(of).sum::<f64>();
    let grown = size(|window| window.group.known[OPERATIONS]);
    let scale = if grown > 0.0 { size(|window| window.operations) / grown } else { 1.0 };
    let rows = |of_group: bool| -> Vec<(Columns, &Figures)> {
        let row = |window: &Window| window.group.known.map(|known| known * scale);
        let inside = |window: &Window| window.inside.known;
        let known = windows.iter().map(|window| if of_group { row(window) } else { inside(window) });
        let figures = windows.iter().map(|window| if of_group { &window.group } else { &window.inside });
        known.zip(figures.map(|part| &part.figures)).collect()
    };
    let rows = [rows(false), rows(true)];
    let names: BTreeSet<&String> = rows.iter().flatten().flat_map(|(_, figures)| figures.keys()).collect();
    let mut solvers: BTreeMap<(bool, Vec<usize>), (Regression, Vec<f64>)> = BTreeMap::new();
    let mut total = |name: &String| {
        let how = explanation(name);
        let rows = &rows[usize::from(how.of_group)];
        let known: Vec<Columns> = rows.iter().map(|(known, _)| *known).collect();
        let (solver, leverage) = solvers.entry((how.of_group, how.columns)).or_insert_with_key(|(_, columns)| {
            let solver = Regression::new(&known, &weights, columns);
            let leverage = solver.leverage(&known, &weights);
            (solver, leverage)
        });
        let freedom = windows.len() as f64 - strata.len() as f64 - solver.rank() as f64 + 1.0;
        let expected = |known: &Columns| how.lines.map_or(0.0, |lines| known[lines] * line as f64);
        let value = |(known, figures): &(Columns, &Figures)| {
            let found = figures.get(name).copied().unwrap_or(0.0);
            (if how.of_group { scale * found } else { found }) - expected(known)
        };
        let values: Vec<f64> = rows.iter().map(value).collect();
        let slopes = solver.slopes(&known, &weights, &values);
        let left: Vec<f64> = known.iter().zip(&values).map(|(known, y)| y - dot(&slopes, known)).collect();
        // What the regression fitted away of a window's own residual is given back (MacKinnon and White 1985, HC2).
        let full: Vec<f64> =
            left.iter().zip(leverage.iter()).map(|(left, leverage)| left / (1.0 - leverage).sqrt()).collect();
        let total = expected(&population.known)
            + dot(&slopes, &population.known)
            + left.iter().zip(&weights).map(|(left, w)| left * w).sum::<f64>();
        let (mut variance, mut squares) = (0.0, 0.0);
        for (stratum, (&all, &some)) in strata.iter().zip(&sampled).enumerate() {
            let here = || place.iter().zip(&full).filter(|(place, _)| **place == stratum).map(|(_, left)| *left);
            let (all, some) = (all as f64, some as f64);
            if some > 1.0 {
                let mean = here().sum::<f64>() / some;
                let spread = here().map(|left| (left - mean).powi(2)).sum::<f64>() / (some - 1.0);
                let here = all * all * (1.0 - some / all) * spread / some;
                variance += here;
                squares += here * here / (some + 1.0);
            }
        }
        // Strata that vary more than others count for few: degrees of freedom by Welch 1947, whose -2 and +2 set right that the
        // variances are estimates themselves.
        let freedom = if squares > 0.0 && freedom >= 1.0 {
            freedom.min(variance * variance / squares - 2.0).max(1.0)
        } else {
            freedom
        };
        let complete = strata.iter().zip(&sampled).all(|(all, some)| all == some);
        let half_width = match freedom {
            _ if complete => Some(0.0),
            _ if freedom >= 1.0 => Some(student(freedom) * variance.sqrt()),
            _ => None,
        };
        Total { total, half_width }
    };
    names.into_iter().map(|name| (name.clone(), total(name))).collect()
}

/// Strata of which fewer than two windows were measured are joined with the one before (or, at the beginning, behind): how many windows each
/// has then, and the stratum of each window that was measured.
fn joined(strata: &[u64], windows: &[Window]) -> (Vec<u64>, Vec<usize>) {
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

fn dot(a: &Columns, b: &Columns) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Weighted least squares, of the columns that are not a combination of those before.
struct Regression {
    /// Rows of the normal equations' inverse; zero for a column that is left out.
    inverse: [Columns; COLUMNS],
    used: [bool; COLUMNS],
}

impl Regression {
    fn new(rows: &[Columns], weights: &[f64], order: &[usize]) -> Self {
        let mut normal = [[0.0; COLUMNS]; COLUMNS];
        for (known, weight) in rows.iter().zip(weights) {
            for (row, x) in normal.iter_mut().zip(known) {
                row.iter_mut().zip(known).for_each(|(cell, y)| *cell += weight * x * y);
            }
        }
        // Gauss-Jordan on the matrix beside the unit matrix; a column whose pivot is lost in rounding, or that there are too few
        // windows for, is left out.
        let mut inverse = [[0.0; COLUMNS]; COLUMNS];
        let mut used = [false; COLUMNS];
        let scale: Vec<f64> = (0..COLUMNS).map(|column| normal[column][column]).collect();
        let mut rank = 0;
        for &column in order {
            if normal[column][column] <= 1e-6 * scale[column] || 8 * (rank + 1) > rows.len() {
                continue;
            }
            used[column] = true;
            rank += 1;
            inverse[column][column] = 1.0;
            let pivot = normal[column][column];
            normal[column].iter_mut().chain(&mut inverse[column]).for_each(|cell| *cell /= pivot);
            for row in (0..COLUMNS).filter(|&row| row != column) {
                let factor = normal[row][column];
                for place in 0..COLUMNS {
                    normal[row][place] -= factor * normal[column][place];
                    inverse[row][place] -= factor * inverse[column][place];
                }
            }
        }
        Self { inverse, used }
    }

    fn rank(&self) -> usize {
        self.used.iter().filter(|&&used| used).count()
    }

    /// How much of its own value the regression takes over for each window; kept below 1.
    fn leverage(&self, rows: &[Columns], weights: &[f64]) -> Vec<f64> {
        let of = |(known, weight): (&Columns, &f64)| {
            let used = |at: &usize| self.used[*at];
            let rows = (0..COLUMNS).filter(used).map(|row| {
                let cells = (0..COLUMNS).filter(used).map(|column| self.inverse[row][column] * known[column]);
                known[row] * cells.sum::<f64>()
            });
            (weight * rows.sum::<f64>()).clamp(0.0, 0.9)
        };
        rows.iter().zip(weights).map(of).collect()
    }

    fn slopes(&self, rows: &[Columns], weights: &[f64], values: &[f64]) -> Columns {
        let mut right = [0.0; COLUMNS];
        for ((known, weight), value) in rows.iter().zip(weights).zip(values) {
            right.iter_mut().zip(known).for_each(|(cell, x)| *cell += weight * x * value);
        }
        std::array::from_fn(|row| {
            let cells = (0..COLUMNS).filter(|&column| self.used[column]).map(|c| self.inverse[row][c] * right[c]);
            if self.used[row] { cells.sum() } else { 0.0 }
        })
    }
}

/// The 97.5 % point of Student's t (Hill 1970, algorithm 396's expansion; within 0.1 % from 6 degrees of freedom on; a table below).
fn student(freedom: f64) -> f64 {
    const SMALL: [f64; 5] = [12.706, 4.303, 3.182, 2.776, 2.571];
    const Z: f64 = 1.959_964;
    if freedom < 6.0 {
        return SMALL[freedom as usize - 1];
    }
    let (z2, n) = (Z * Z, freedom);
    let g1 = Z * (z2 + 1.0) / 4.0;
    let g2 = Z * ((5.0 * z2 + 16.0) * z2 + 3.0) / 96.0;
    let g3 = Z * (((3.0 * z2 + 19.0) * z2 + 17.0) * z2 - 15.0) / 384.0;
    Z + g1 / n + g2 / (n * n) + g3 / (n * n * n)
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
    fn students_t_by_the_table() {
        for (freedom, expected) in [(1.0, 12.706), (3.0, 3.182), (10.0, 2.228), (30.0, 2.042), (1000.0, 1.962)] {
            assert!((student(freedom) / expected - 1.0).abs() < 3e-3, "{freedom}: {}", student(freedom));
        }
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
