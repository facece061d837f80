//! The report of a sweep: `sweep.csv`, `summary.json`, a plot, and a page.

use std::path::Path;

use minijinja::{Environment, context};
use serde::{Deserialize, Serialize};

use super::format::{bytes, change, or_absent, percent, short};
use super::plots;
use super::table::Grid;
use super::{PAGE_FILE, PLOTS_FOLDER, ReportError, SUMMARY_FILE, put};
use crate::quantity::{Bytes, Resolution};
use crate::stats::{MachineStats, TrafficClass};
use crate::stream::Totals;

/// The file with a row a point.
pub const SWEEP_FILE: &str = "sweep.csv";

/// A whole sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweepSummary {
    /// The experiment's name.
    pub experiment: String,
    /// The scene's name.
    pub scene: String,
    /// Numbers of the frames.
    pub frames: Vec<u32>,
    /// Size of the pictures.
    pub resolution: Resolution,
    /// The points, in the order of the files.
    pub points: Vec<SweepPoint>,
}

/// A field of the machine that a point sets.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Change {
    /// Its path.
    pub field: String,
    /// Its value.
    pub value: String,
}

/// A machine and a policy, measured three times: without culling, with words that cost nothing, and as it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweepPoint {
    /// The machine's name.
    pub machine: String,
    /// The policy's name.
    pub policy: String,
    /// What differs from the machine's file.
    pub changes: Vec<Change>,
    /// Cycles without culling, with free words, and as it is.
    pub cycles: [u64; 3],
    /// DRAM bytes of the same three.
    pub dram: [Bytes; 3],
    /// DRAM bytes by class, as it is.
    pub classes: Vec<(TrafficClass, Bytes)>,
    /// DRAM bytes that culling saved, words not counted: first less second.
    pub saved: i64,
    /// DRAM bytes of the words' own classes.
    pub words: u64,
    /// DRAM bytes of other classes that the words drove out of caches.
    pub interference: i64,
    /// Misses of other classes in all caches that are not there with free words.
    pub extra_misses: i64,
    /// Hits over accesses of words and counters in the first cache that they meet; none without one.
    pub word_hit_rate: Option<f64>,
    /// Shadow rays asked for, and the share of them that was skipped or traced among dynamic objects only.
    pub shadow_rays: u64,
    /// See above.
    pub culled: f64,
    /// DRAM bytes a ray without culling.
    pub bytes_per_ray: f64,
    /// The share of shadow rays that must be culled to save what the words cost, at that many bytes a ray.
    pub break_even: Option<f64>,
}

const WORDS: [TrafficClass; 3] = [TrafficClass::ModeWord, TrafficClass::PixelCounter, TrafficClass::OccluderId];

fn dram(stats: &MachineStats, of: impl Fn(TrafficClass) -> bool) -> u64 {
    let classes = stats.bytes.get("dram").into_iter().flatten();
    classes.filter(|(class, _)| of(**class)).map(|(_, bytes)| bytes.0).sum()
}

impl SweepPoint {
    /// The point of three measurements (without culling, with free words, as it is) of a stream that holds `totals`.
    pub fn new(
        machine: &str,
        policy: &str,
        changes: Vec<Change>,
        [off, free, real]: [&MachineStats; 3],
        totals: &Totals,
    ) -> Self {
        let all = |stats| Bytes(dram(stats, |_| true));
        let others = |stats| dram(stats, |class| !WORDS.contains(&class)) as i64;
        let other_misses = |stats: &MachineStats| -> i64 {
            let classes = stats.caches.values().flatten().filter(|(class, _)| !WORDS.contains(class));
            classes.map(|(_, counts)| counts.misses as i64).sum()
        };
        let word_counts = ["l1_shadow_cache", "l1_intersection", "l2"].into_iter().find_map(|cache| {
            let classes = real.caches.get(cache)?.iter().filter(|(class, _)| WORDS.contains(class));
            let (hits, accesses) = classes.fold((0, 0), |sum, (_, it)| (sum.0 + it.hits, sum.1 + it.accesses));
            (accesses > 0).then_some(hits as f64 / accesses as f64)
        });
        let words = dram(real, |class| WORDS.contains(&class));
        let (saved, interference) = (others(off) - others(free), others(real) - others(free));
        let bytes_per_ray = all(off).0 as f64 / off.rays.max(1) as f64;
        let culled = totals.shadow_rays_skipped + totals.shadow_rays_dynamic_only;
        let possible = bytes_per_ray * totals.shadow_rays as f64;
        Self {
            machine: machine.into(),
            policy: policy.into(),
            changes,
            cycles: [off, free, real].map(|stats| stats.cycles.0),
            dram: [off, free, real].map(all),
            classes: real.bytes.get("dram").into_iter().flatten().map(|(&class, &bytes)| (class, bytes)).collect(),
            saved,
            words,
            interference,
            extra_misses: other_misses(real) - other_misses(free),
            word_hit_rate: word_counts,
            shadow_rays: totals.shadow_rays,
            culled: culled as f64 / totals.shadow_rays.max(1) as f64,
            bytes_per_ray,
            break_even: (possible > 0.0).then(|| (words as i64 + interference) as f64 / possible),
        }
    }

    /// What differs, in words.
    pub fn label(&self) -> String {
        if self.changes.is_empty() {
            return "as in its file".into();
        }
        let short = |change: &Change| {
            let field = change.field.strip_prefix("shadow_cache.").unwrap_or(&change.field);
            format!("{field}: {}", change.value)
        };
        self.changes.iter().map(short).collect::<Vec<_>>().join(", ")
    }
}

/// The points as a table.
pub fn grid(summary: &SweepSummary) -> Grid {
    const HEAD: [&str; 12] = [
        "machine",
        "policy",
        "point",
        "cycles",
        "DRAM",
        "saved",
        "words",
        "interference",
        "extra misses",
        "word hits",
        "culled",
        "break-even",
    ];
    let signed = |value: i64| {
        let sign = if value < 0 { "\u{2212}" } else { "" };
        format!("{sign}{}", bytes(Bytes(value.unsigned_abs())))
    };
    let row = |point: &SweepPoint| {
        let [off, _, real] = point.cycles.map(|cycles| cycles as f64);
        let [off_dram, _, dram] = point.dram.map(|bytes| bytes.0 as f64);
        vec![
            point.machine.clone(),
            point.policy.clone(),
            point.label(),
            or_absent(change(off, real), |it| it),
            or_absent(change(off_dram, dram), |it| it),
            signed(point.saved),
            bytes(Bytes(point.words)),
            signed(point.interference),
            short(point.extra_misses as f64),
            or_absent(point.word_hit_rate, percent),
            percent(point.culled),
            or_absent(point.break_even, percent),
        ]
    };
    Grid { head: HEAD.map(Into::into).to_vec(), names: 3, rows: summary.points.iter().map(row).collect() }
}

fn csv(summary: &SweepSummary) -> Result<Vec<u8>, csv::Error> {
    let mut csv = csv::Writer::from_writer(Vec::new());
    csv.write_record([
        "machine",
        "policy",
        "point",
        "cycles_off",
        "cycles_free_words",
        "cycles",
        "dram_bytes_off",
        "dram_bytes_free_words",
        "dram_bytes",
        "saved_bytes",
        "word_bytes",
        "interference_bytes",
        "extra_misses",
        "word_hit_rate",
        "shadow_rays",
        "culled_share",
        "dram_bytes_per_ray_off",
        "break_even_share",
    ])?;
    for point in &summary.points {
        let mut row = vec![point.machine.clone(), point.policy.clone(), point.label()];
        row.extend(point.cycles.iter().map(u64::to_string));
        row.extend(point.dram.iter().map(|bytes| bytes.0.to_string()));
        row.extend([point.saved.to_string(), point.words.to_string(), point.interference.to_string()]);
        row.push(point.extra_misses.to_string());
        row.push(point.word_hit_rate.map(|rate| rate.to_string()).unwrap_or_default());
        row.extend([point.shadow_rays.to_string(), point.culled.to_string(), point.bytes_per_ray.to_string()]);
        row.push(point.break_even.map(|share| share.to_string()).unwrap_or_default());
        csv.write_record(row)?;
    }
    csv.into_inner().map_err(|error| error.into_error().into())
}

/// Writes the report beside the points in `folder`, each file whole.
pub fn write_sweep(folder: &Path, summary: &SweepSummary) -> Result<(), ReportError> {
    let mut text = serde_json::to_vec_pretty(summary).map_err(ReportError::Summary)?;
    text.push(b'\n');
    let plot = plots::sweep::draw(summary).map_err(ReportError::Plot)?;
    let mut environment = Environment::new();
    let page = environment
        .add_template("sweep.html", include_str!("sweep.html"))
        .and_then(|()| environment.get_template("sweep.html"))
        .and_then(|template| {
            let Grid { head, names, rows } = grid(summary);
            template.render(context! {
                experiment => summary.experiment.as_str(),
                scene => summary.scene.as_str(),
                frames => summary.frames.len(),
                resolution => summary.resolution.to_string(),
                head, names, rows,
                plot => plot.as_str(),
            })
        })
        .map_err(ReportError::Page)?;
    put(&folder.join(SUMMARY_FILE), &text)?;
    put(&folder.join(SWEEP_FILE), &csv(summary).map_err(ReportError::Table)?)?;
    put(&folder.join(PLOTS_FOLDER).join("sweep.svg"), plot.as_bytes())?;
    put(&folder.join(PAGE_FILE), page.as_bytes())
}
