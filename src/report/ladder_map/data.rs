//! The failure map of the fidelity levels: how far each level is from `Event` on streams and machines that are hard
//! for it.

use serde::{Deserialize, Serialize};

use crate::quantity::Cycle;
use crate::report::format::{percent, signed};
use crate::report::grid::Grid;
use crate::stats::MachineStats;

/// The map; `summary.json` holds it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct LadderMap {
    /// Names of the rows; a row is a level.
    pub rows: Vec<String>,
    /// The parameters that were swept.
    pub axes: Vec<Axis>,
}

/// A parameter that was swept while all others stayed fixed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Axis {
    /// Its name, with a unit.
    pub name: String,
    /// The points.
    pub points: Vec<Point>,
}

/// A stream on a machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Point {
    /// The parameter's value.
    pub value: String,
    /// Cycles that `Event` takes.
    pub cycles: Cycle,
    /// The results of each of [`LadderMap::rows`].
    pub rows: Vec<Row>,
}

/// How many samples' intervals of cycles held the true cycles; the samples differ in their seeds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Covered {
    /// Samples whose interval held the truth.
    pub held: u32,
    /// Samples with an interval.
    pub told: u32,
}

/// The result of a level at a point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Row {
    /// Relative error of each of [`Figure::ALL`]; absent where the level gives no figure, or `Event`'s is 0. For
    /// several samples, the worst.
    pub errors: [Option<f64>; Figure::ALL.len()],
    /// How often a sample's intervals held.
    pub covered: Option<Covered>,
}

/// A figure that is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Figure {
    /// Cycles of the run.
    Cycles,
    /// Bytes between L1s and L2.
    L2Bytes,
    /// Bytes between L2 and DRAM.
    DramBytes,
    /// Misses of the traversal units' L1s.
    L1Misses,
}

impl Figure {
    /// All figures.
    pub(crate) const ALL: [Self; 4] = [Self::Cycles, Self::L2Bytes, Self::DramBytes, Self::L1Misses];

    /// Its name.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Cycles => "cycles",
            Self::L2Bytes => "L2 bytes",
            Self::DramBytes => "DRAM bytes",
            Self::L1Misses => "misses of the traversal L1s",
        }
    }

    fn of(self, stats: &MachineStats) -> Option<f64> {
        let some = |value: u64| Some(value as f64);
        match self {
            Self::Cycles => some(stats.cycles.0),
            Self::L2Bytes => some(stats.moved("l2").0),
            Self::DramBytes => some(stats.moved("dram").0),
            Self::L1Misses => {
                let classes = stats.caches.get("l1_traversal")?;
                some(classes.values().map(|counts| counts.misses).sum())
            }
        }
    }

    /// The relative error of `found` against `truth`; `None` without a figure, or if the true figure is 0.
    pub(crate) fn error(self, found: &MachineStats, truth: &MachineStats) -> Option<f64> {
        off(self.of(found)?, self.of(truth)?)
    }

    /// The relative error of misses that are given as a miss ratio; `None` for all other figures.
    pub(crate) fn error_of_ratio(self, ratio: f64, truth: &MachineStats) -> Option<f64> {
        if self != Self::L1Misses {
            return None;
        }
        let accesses: u64 = truth.caches.get("l1_traversal")?.values().map(|counts| counts.accesses).sum();
        off(ratio * accesses as f64, self.of(truth)?)
    }
}

fn off(found: f64, truth: f64) -> Option<f64> {
    (truth > 0.0).then(|| found / truth - 1.0)
}

/// Mean and worst error of each row and figure, and the point of the worst error.
pub(crate) fn grid(map: &LadderMap) -> Grid {
    let head = ["level", "figure", "mean", "worst", "where"].map(String::from).to_vec();
    let mut rows = Vec::new();
    for (index, name) in map.rows.iter().enumerate() {
        for figure in Figure::ALL {
            let all = map.axes.iter().flat_map(|axis| axis.points.iter().map(move |point| (axis, point)));
            let errors: Vec<_> = all
                .filter_map(|(axis, point)| Some((point.rows[index].errors[figure as usize]?, axis, point)))
                .collect();
            let Some((worst, axis, point)) = errors.iter().max_by(|a, b| a.0.abs().total_cmp(&b.0.abs())) else {
                continue;
            };
            let mean = errors.iter().map(|(error, ..)| error.abs()).sum::<f64>() / errors.len() as f64;
            let place = format!("{} {}", axis.name, point.value);
            rows.push(vec![name.clone(), figure.name().into(), percent(mean), signed(*worst), place]);
        }
        let samples = map.axes.iter().flat_map(|axis| &axis.points);
        let covered: Vec<_> = samples.filter_map(|point| point.rows[index].covered).collect();
        if !covered.is_empty() {
            let (held, told) = covered.iter().fold((0, 0), |(held, told), it| (held + it.held, told + it.told));
            let text = format!("{held} of {told}");
            rows.push(vec![name.clone(), "intervals of cycles that hold".into(), text, String::new(), String::new()]);
        }
    }
    Grid { head, names: 2, rows }
}

/// Names the worst error of cycles of each level.
pub(crate) fn verdict(map: &LadderMap) -> String {
    let worst = |(index, name): (usize, &String)| {
        let points = map.axes.iter().flat_map(|axis| &axis.points);
        let errors = points.filter_map(|point| point.rows[index].errors[Figure::Cycles as usize]);
        let worst = errors.max_by(|a, b| a.abs().total_cmp(&b.abs()))?;
        Some(format!("{name} {}", signed(worst)))
    };
    let worst: Vec<String> = map.rows.iter().enumerate().filter_map(worst).collect();
    if worst.is_empty() {
        return "no level says how many cycles a point takes".into();
    }
    format!("worst errors of cycles against Event: {}", worst.join("; "))
}
