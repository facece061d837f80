//! The figures of a machine on the stream of one policy: the measurements, and rates and means that follow from them.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::stats::{MachineStats, TrafficClass};

/// Measurements of a machine on the stream of one policy. Warm-up frames are in `frames` alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct MachineRun {
    /// The measurements.
    #[serde(flatten)]
    pub stats: MachineStats,
    /// Mean simulated time of a measured frame, in ms.
    pub milliseconds_per_frame: Option<f64>,
    /// Measured frames per second of simulated time.
    pub frames_per_second: Option<f64>,
    /// Rays per second of simulated time.
    pub rays_per_second: Option<f64>,
    /// Rays that the measured frames ask for: traced rays, and rays whose answers are known without tracing.
    pub rays_answered: Option<u64>,
    /// Rays answered per second of simulated time.
    pub rays_answered_per_second: Option<f64>,
    /// Hits over accesses, by cache and class of traffic.
    pub hit_rate: BTreeMap<String, BTreeMap<TrafficClass, f64>>,
    /// Share of its cycles in which a kind of unit is busy.
    pub utilization: BTreeMap<String, f64>,
    /// Share of the DRAM's column commands that found their row open.
    pub dram_row_hit_rate: Option<f64>,
    /// Share of peak bandwidth of the DRAM.
    pub dram_utilization: Option<f64>,
    /// Bytes that the DRAM moved per second of simulated time, in GB/s (10^9 bytes).
    pub dram_gigabytes_per_second: Option<f64>,
    /// Mean bytes that the DRAM moved in a measured frame.
    pub dram_bytes_per_frame: Option<f64>,
    /// Mean energy of a measured frame in J.
    pub joules_per_frame: Option<f64>,
    /// Energy per answered ray in J.
    pub joules_per_ray: Option<f64>,
}

/// Number of the measured frames and of the rays that they ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Asked {
    /// Number of frames.
    pub frames: usize,
    /// Rays of these frames, including skipped ones.
    pub rays: u64,
}

impl Asked {
    /// Counts the measured frames of `stats` and their rays; `None` if `stats` has no figures by frame.
    pub(crate) fn of(stats: &MachineStats) -> Option<Self> {
        let measured = || stats.frames.iter().filter(|frame| !frame.warmup);
        let asked = Self { frames: measured().count(), rays: measured().map(|frame| frame.answered).sum() };
        (asked.frames > 0).then_some(asked)
    }
}

impl MachineRun {
    /// The figures of `stats`; means by frame and ray need `asked`.
    pub(crate) fn new(stats: MachineStats, asked: Option<Asked>) -> Self {
        let used = stats.units.keys().filter_map(|unit| Some((unit.clone(), stats.utilization(unit)?)));
        let dram = stats.dram;
        let peak = stats.dram_peak_bytes_per_cycle.map(|peak| peak * stats.cycles.0 as f64).filter(|&peak| peak > 0.0);
        let moved = stats.bytes.get("dram").map(|_| stats.moved("dram").0 as f64);
        let seconds = (stats.cycles.0 > 0).then(|| stats.cycles.0 as f64 / (stats.clock_mhz * 1e6));
        let a_second = |amount: Option<f64>| amount.zip(seconds).map(|(amount, seconds)| amount / seconds);
        let frames = asked.map(|asked| asked.frames as f64);
        let a_frame = |amount: Option<f64>| amount.zip(frames).map(|(amount, frames)| amount / frames);
        let (rays, joules) = (asked.map(|asked| asked.rays), stats.energy.as_ref().map(|energy| energy.joules));
        let answered = rays.map(|rays| rays as f64);
        Self {
            milliseconds_per_frame: a_frame(seconds.map(|seconds| seconds * 1e3)),
            frames_per_second: a_second(frames),
            rays_per_second: a_second(Some(stats.rays as f64)),
            rays_answered: rays,
            rays_answered_per_second: a_second(answered),
            hit_rate: stats.hit_rates(),
            utilization: used.collect(),
            dram_row_hit_rate: share(dram.row_hits, dram.row_hits + dram.row_misses + dram.row_conflicts),
            dram_utilization: moved.zip(peak).map(|(moved, peak)| moved / peak),
            dram_gigabytes_per_second: a_second(moved.map(|moved| moved / 1e9)),
            dram_bytes_per_frame: a_frame(moved),
            joules_per_frame: a_frame(joules),
            joules_per_ray: joules.zip(answered.filter(|&rays| rays > 0.0)).map(|(joules, rays)| joules / rays),
            stats,
        }
    }
}

impl From<MachineStats> for MachineRun {
    fn from(stats: MachineStats) -> Self {
        let asked = Asked::of(&stats);
        Self::new(stats, asked)
    }
}

/// `part` over `whole`; `None` if there is no whole.
pub(super) fn share(part: u64, whole: u64) -> Option<f64> {
    (whole > 0).then(|| part as f64 / whole as f64)
}
