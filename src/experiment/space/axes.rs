//! The inputs of a surrogate for each design: fields as numbers, or the load of each resource.

use super::figure::Figure;
use crate::replay::Estimate;
use crate::size;
use crate::surrogate::Group;

/// The input of a resource that is always busy; an idle one has 0, and the values of a numeric field span 2. Assumed.
const SHARES: f64 = 3.0;
/// An input whose values span less is left out. Assumed.
const MOVES: f64 = 0.01;

/// A field's values as inputs.
pub(super) enum Axis {
    /// Numbers, scaled from -1 to 1: by their logarithms if all are above zero.
    Amounts(Vec<f64>),
    /// Names: one 0-or-1 input for each name but the first.
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

    /// The inputs of the value at `place`; zeros for a design without the field.
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

/// What is known of all designs without a replay.
pub(super) struct Known<'a> {
    /// The fields.
    pub(super) axes: &'a [Axis],
    /// Of each design, its value's place on each axis; `None` where the design does not have the field.
    pub(super) places: &'a [Vec<Option<usize>>],
    /// The estimate of each design.
    pub(super) estimates: &'a [Estimate],
}

/// Inputs of all designs, and their groups, each with its own length scale.
pub(super) type Inputs = (Vec<Vec<f64>>, Vec<Group>);

impl Known<'_> {
    /// The inputs that explain how a figure differs from its estimate. Cycles and energy: the load of each resource,
    /// since the busiest waits for the others. Bytes: the fields.
    pub(super) fn inputs(&self, figure: Figure) -> Inputs {
        let Self { axes, places, estimates } = *self;
        let mut blocks: Vec<Vec<Vec<f64>>> = Vec::new();
        match figure {
            Figure::Cycles | Figure::Joules => {
                let resources = estimates.first().map_or(0, |it| it.resources.len());
                let share =
                    |at: usize| estimates.iter().map(|it| vec![SHARES * it.resources[at] / it.cycles]).collect();
                blocks.extend((0..resources).map(share));
            }
            Figure::DramBytes => {
                for (field, axis) in axes.iter().enumerate() {
                    blocks.push(places.iter().map(|places| axis.inputs(places[field])).collect());
                }
            }
        }
        grouped(&blocks, places.len())
    }
}

/// Makes each block a group of inputs; leaves out inputs that hardly change (see `MOVES`).
fn grouped(blocks: &[Vec<Vec<f64>>], designs: usize) -> Inputs {
    let mut rows: Vec<Vec<f64>> = vec![Vec::new(); designs];
    let mut groups = Vec::new();
    for block in blocks {
        let first = rows.first().map_or(0, Vec::len);
        for column in 0..block.first().map_or(0, Vec::len) {
            let of = |row: &Vec<f64>| row[column];
            let (low, high) = range(block.iter().map(of));
            if high - low >= MOVES {
                rows.iter_mut().zip(block).for_each(|(row, cells)| row.push(centred(cells[column], low, high)));
            }
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
        let estimate =
            |busy: f64| Estimate { cycles: 100.0, dram_bytes: 64.0, joules: None, resources: vec![busy, 1.0] };
        let known = Known {
            axes: &[axis(&["1", "2"]), axis(&["7"])],
            places: &[vec![Some(0), Some(0)], vec![Some(1), Some(0)]],
            estimates: &[estimate(80.0), estimate(40.0)],
        };
        let (rows, groups) = known.inputs(Figure::Cycles);
        assert_eq!(groups, [Group { inputs: 0..1 }]);
        assert!((rows[0][0] - rows[1][0] - SHARES * 0.4).abs() < 1e-12);
        let (rows, groups) = known.inputs(Figure::DramBytes);
        assert_eq!(groups, [Group { inputs: 0..1 }]);
        assert_eq!(rows, [[-1.0], [1.0]]);
    }
}
