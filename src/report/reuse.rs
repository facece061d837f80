//! Misses of caches of all sizes: `reuse.csv`, a plot, and a table of the caches that the machine has.

use serde::{Deserialize, Serialize};

use super::format::{exact, percent};
use super::table::Grid;
use super::{PLOTS_FOLDER, ReportError, SUMMARY_FILE, plots, put, replace};
use crate::output::ResultsFolder;
use crate::stats::{MachineStats, ReuseCurve, ReuseLevel};

/// The file with a row a cache, class and size.
pub const REUSE_FILE: &str = "reuse.csv";
/// The plot's file.
pub const PLOT_FILE: &str = "reuse.svg";

/// Reuse in the caches of a machine on a stream; `summary.json` holds it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReuseSummary {
    /// The machine's name.
    pub machine: String,
    /// The stream's scene and policy.
    pub scene: String,
    /// See above.
    pub policy: String,
    /// Whose reuse was measured, in words.
    pub of: String,
    /// What the machine measured on the way.
    pub stats: MachineStats,
    /// The caches.
    pub levels: Vec<ReuseLevel>,
}

/// The size of a cache.
pub fn size(bytes: u64) -> String {
    if bytes < 1 << 20 {
        format!("{} kB", bytes as f64 / 1024.0)
    } else {
        format!("{} MB", bytes as f64 / 1024.0 / 1024.0)
    }
}

/// Misses of the caches as the machine has them, by class: counted in its sets, and from reuse distances without sets and in random ones.
pub fn grid(summary: &ReuseSummary) -> Grid {
    let head = ["cache", "class", "each", "accesses", "misses", "without sets", "random sets", "first touches"];
    let mut rows = Vec::new();
    for level in &summary.levels {
        let each = format!("{}, {} ways", size(level.bytes), level.ways);
        for (class, curve) in &level.classes {
            let counts = summary.stats.caches.get(&level.name).and_then(|classes| classes.get(class));
            let share = |misses: f64| percent(misses / curve.sampled.max(1.0));
            let place = ReuseCurve::sizes().position(|size| size == level.bytes);
            rows.push(vec![
                level.name.clone(),
                class.name().into(),
                each.clone(),
                exact(curve.accesses),
                counts.map_or_else(String::new, |it| percent(it.misses as f64 / it.accesses.max(1) as f64)),
                place.map_or_else(String::new, |place| share(curve.misses[place])),
                share(curve.misses_in_sets),
                share(curve.first_touches),
            ]);
        }
    }
    Grid { head: head.map(String::from).to_vec(), names: 3, rows }
}

fn csv(summary: &ReuseSummary) -> Result<Vec<u8>, csv::Error> {
    let mut csv = csv::Writer::from_writer(Vec::new());
    csv.write_record(["cache", "class", "bytes", "accesses", "misses", "miss_ratio"])?;
    for level in &summary.levels {
        for (class, curve) in &level.classes {
            for (size, misses) in ReuseCurve::sizes().zip(&curve.misses) {
                csv.write_record([
                    level.name.as_str(),
                    class.name(),
                    &size.to_string(),
                    &curve.accesses.to_string(),
                    &misses.to_string(),
                    &(misses / curve.sampled.max(1.0)).to_string(),
                ])?;
            }
        }
    }
    csv.into_inner().map_err(|error| error.into_error().into())
}

/// Writes the report at `target`, in the place of an earlier one if there is one, complete or not at all.
pub fn write_reuse(folder: &ResultsFolder, summary: &ReuseSummary) -> Result<(), ReportError> {
    replace(folder, |dir| {
        let mut text = serde_json::to_vec_pretty(summary).map_err(ReportError::Summary)?;
        text.push(b'\n');
        put(&dir.join(SUMMARY_FILE), &text)?;
        put(&dir.join(REUSE_FILE), &csv(summary).map_err(ReportError::Table)?)?;
        let plot = plots::reuse::draw(summary).map_err(ReportError::Plot)?;
        put(&dir.join(PLOTS_FOLDER).join(PLOT_FILE), plot.as_bytes())
    })
}
