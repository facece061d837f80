//! What a surrogate knows of a machine: its fields as numbers, and what its resources are asked for.

use crate::replay::Estimate;
use crate::size;
use crate::surrogate::Group;

/// Shares of a resource below this count as this: a resource that is hardly used changes nothing.
const LEAST_SHARE: f64 = 0.05;
/// An input that moves less is none.
const MOVES: f64 = 0.01;

/// A field's values as inputs.
pub(super) enum Axis {
    /// Numbers, by their logarithms if all are above zero, from -1 to 1.
    Amounts(Vec<f64>),
    /// Names: an input each, but the first.
    Names(usize),
}

impl Axis {
    /// The axis of a field with these values.
    pub(super) fn new(values: &[String]) -> Self {
        let Some(amounts) = values.iter().map(|value| size::amount(value)).collect::<Option<Vec<f64>>>() else {
            return Self::Names(values.len());
        };
        let all_above = amounts.iter().all(|&amount| amount > 0.0);
        let scaled: Vec<f64> = amounts.iter().map(|&amount| if all_above { amount.ln() } else { amount }).collect();
        let (low, high) = range(scaled.iter().copied());
        let place = |value: &f64| if high > low { 2.0 * (value - low) / (high - low) - 1.0 } else { 0.0 };
        Self::Amounts(scaled.iter().map(place).collect())
    }

    /// The inputs of the value at `place`; those in the middle without one.
    fn inputs(&self, place: Option<usize>) -> Vec<f64> {
        match self {
            Self::Amounts(places) => vec![place.map_or(0.0, |place| places[place])],
            Self::Names(count) => (1..*count).map(|name| f64::from(u8::from(place == Some(name)))).collect(),
        }
    }
}

fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
}

/// The inputs of all designs, and their groups: one an axis, one of all resources, one a figure's estimate. Each design
/// has a place on each axis, or none where it does not have the field.
pub(super) fn inputs(
    axes: &[Axis],
    places: &[Vec<Option<usize>>],
    estimates: &[Estimate],
) -> (Vec<Vec<f64>>, Vec<Group>) {
    let mut blocks: Vec<Vec<Vec<f64>>> = Vec::new();
    for (field, axis) in axes.iter().enumerate() {
        blocks.push(places.iter().map(|places| axis.inputs(places[field])).collect());
    }
    let share = |busy: &f64, estimate: &Estimate| (busy / estimate.cycles).max(LEAST_SHARE).ln();
    blocks.push(estimates.iter().map(|it| it.resources.iter().map(|busy| share(busy, it)).collect()).collect());
    for figure in [|it: &Estimate| it.cycles, |it: &Estimate| it.dram_bytes, |it: &Estimate| it.joules.unwrap_or(1.0)] {
        blocks.push(estimates.iter().map(|it| vec![figure(it).max(1e-30).ln()]).collect());
    }
    let mut rows: Vec<Vec<f64>> = vec![Vec::new(); places.len()];
    let mut groups = Vec::new();
    for block in blocks {
        let first = rows.first().map_or(0, Vec::len);
        for column in 0..block.first().map_or(0, Vec::len) {
            let of = |row: &Vec<f64>| row[column];
            let (low, high) = range(block.iter().map(of));
            let same = |at: usize| {
                rows.iter().zip(&block).all(|(row, cells)| (row[at] - centred(cells[column], low, high)).abs() < 1e-9)
            };
            if high - low < MOVES || (first..rows[0].len()).any(same) {
                continue;
            }
            rows.iter_mut().zip(&block).for_each(|(row, cells)| row.push(centred(cells[column], low, high)));
        }
        let end = rows.first().map_or(0, Vec::len);
        if end > first {
            groups.push(Group { inputs: first..end });
        }
    }
    (rows, groups)
}

fn centred(value: f64, low: f64, high: f64) -> f64 {
    value - (low + high) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(values: &[&str]) -> Axis {
        Axis::new(&values.iter().map(|value| (*value).to_owned()).collect::<Vec<_>>())
    }

    #[test]
    fn numbers_and_sizes_lie_on_a_logarithmic_axis_and_names_have_one_each() {
        let sizes = axis(&["256", "\"1 KiB\"", "4096"]);
        assert_eq!([0, 1, 2].map(|place| sizes.inputs(Some(place))[0].round()), [-1.0, 0.0, 1.0]);
        assert_eq!(axis(&["0", "1", "4"]).inputs(Some(1)), [-0.5]);
        assert_eq!(axis(&["Own", "L2", "Free"]).inputs(Some(2)), [0.0, 1.0]);
        assert_eq!(sizes.inputs(None), [0.0]);
    }

    #[test]
    fn what_does_not_move_is_no_input() {
        let estimate = |cycles: f64, busy: f64| Estimate {
            cycles,
            dram_bytes: 64.0,
            joules: None,
            resources: vec![busy, 1.0, busy],
        };
        let (field, fixed) = (axis(&["1", "2"]), axis(&["7"]));
        let (rows, groups) = inputs(
            &[field, fixed],
            &[vec![Some(0), Some(0)], vec![Some(1), Some(0)]],
            &[estimate(100.0, 80.0), estimate(100.0, 40.0)],
        );
        assert_eq!(groups, [0..1, 1..2].map(|inputs| Group { inputs }));
        assert_eq!(rows.iter().map(|row| row[0]).collect::<Vec<_>>(), [-1.0, 1.0]);
        assert!((rows[0][1] - rows[1][1] - 2f64.ln()).abs() < 1e-12);
    }
}
