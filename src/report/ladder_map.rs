//! The failure map of the ladder: how far each rung is from `Event` where streams and machines are made to hurt it.

use serde::{Deserialize, Serialize};

use super::format::percent;
use super::table::Grid;
use super::{PLOTS_FOLDER, ReportError, SUMMARY_FILE, plots, put, replace};
use crate::output::ResultsFolder;
use crate::quantity::Cycle;
use crate::stats::MachineStats;

/// The file with a row a point, row and figure.
pub const MAP_FILE: &str = "ladder.csv";

/// The map; `summary.json` holds it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LadderMap {
    /// The rows' names.
    pub rows: Vec<String>,
    /// What was swept.
    pub axes: Vec<Axis>,
}

/// Something that was swept while all else stayed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Axis {
    /// Its name, with a unit.
    pub name: String,
    /// The points.
    pub points: Vec<Point>,
}

/// A stream on a machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// What the axis is at.
    pub value: String,
    /// Cycles that `Event` takes.
    pub cycles: Cycle,
    /// What each of [`LadderMap::rows`] makes of it.
    pub rows: Vec<Row>,
}

/// How often samples of other rays each had the truth in their interval of cycles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Covered {
    /// How many had.
    pub held: u32,
    /// How many had an interval.
    pub told: u32,
}

/// What a rung makes of a point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Share by which each of [`Figure::ALL`] is off; absent where the rung doesn't say, or `Event` has none. The worst of several samples.
    pub errors: [Option<f64>; Figure::ALL.len()],
    /// What a sample's intervals are worth.
    pub covered: Option<Covered>,
}

/// What is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Figure {
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
    pub const ALL: [Self; 4] = [Self::Cycles, Self::L2Bytes, Self::DramBytes, Self::L1Misses];

    /// Its name.
    pub fn name(self) -> &'static str {
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

    /// The share by which `found` is off `truth`.
    pub fn error(self, found: &MachineStats, truth: &MachineStats) -> Option<f64> {
        off(self.of(found)?, self.of(truth)?)
    }

    /// The share by which a ratio of misses is off, if this is about that.
    pub fn error_of_ratio(self, ratio: f64, truth: &MachineStats) -> Option<f64> {
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

/// The worst of each row and figure, and where that is.
pub fn grid(map: &LadderMap) -> Grid {
    let head = ["rung", "figure", "mean", "worst", "where"].map(String::from).to_vec();
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

fn signed(share: f64) -> String {
    format!("{:+.1} %", share * 100.0)
}

fn csv(map: &LadderMap) -> Result<Vec<u8>, csv::Error> {
    let mut csv = csv::Writer::from_writer(Vec::new());
    csv.write_record(["axis", "value", "event_cycles", "rung", "figure", "error", "intervals_that_hold", "intervals"])?;
    for axis in &map.axes {
        for point in &axis.points {
            for (name, row) in map.rows.iter().zip(&point.rows) {
                for figure in Figure::ALL {
                    let Some(error) = row.errors[figure as usize] else { continue };
                    let covered = row.covered.filter(|_| figure == Figure::Cycles);
                    csv.write_record([
                        axis.name.as_str(),
                        &point.value,
                        &point.cycles.0.to_string(),
                        name,
                        figure.name(),
                        &error.to_string(),
                        &covered.map_or_else(String::new, |covered| covered.held.to_string()),
                        &covered.map_or_else(String::new, |covered| covered.told.to_string()),
                    ])?;
                }
            }
        }
    }
    csv.into_inner().map_err(|error| error.into_error().into())
}

/// Writes the map at `target`, in the place of an earlier one if there is one, complete or not at all.
pub fn write_map(folder: &ResultsFolder, map: &LadderMap) -> Result<(), ReportError> {
    replace(folder, |dir| {
        let mut text = serde_json::to_vec_pretty(map).map_err(ReportError::Summary)?;
        text.push(b'\n');
        put(&dir.join(SUMMARY_FILE), &text)?;
        put(&dir.join(MAP_FILE), &csv(map).map_err(ReportError::Table)?)?;
        let plot = plots::ladder_map::draw(map).map_err(ReportError::Plot)?;
        put(&dir.join(PLOTS_FOLDER).join(PLOT_FILE), plot.as_bytes())
    })
}

/// The plot's file.
pub const PLOT_FILE: &str = "ladder.svg";
