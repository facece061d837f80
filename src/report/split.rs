//! Savings of culling and costs of its mode words: three replays of a machine separate the two.

use serde::{Deserialize, Serialize};

use super::error::ReportError;
use super::format::{bytes, change, joules, or_absent, percent, short};
use super::results::{Row, Take, Walk};
use crate::quantity::Bytes;
use crate::stats::{MachineStats, TrafficClass};
use crate::stream::Totals;

/// A policy on a machine, measured three times: without culling, with free words, and with its words.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Split {
    /// Cycles without culling, with free words, and with the policy's words.
    pub cycles: [u64; 3],
    /// DRAM bytes of the same three replays.
    pub dram: [Bytes; 3],
    /// Energy of the same three replays in J, with typical constants; `None` if a replay has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joules: Option<[f64; 3]>,
    /// Half the widths of the 95 % intervals of the changes of cycles and of DRAM bytes, from the first replay to the
    /// last; of samples only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub half_widths: Option<[f64; 2]>,
    /// Half the widths of the 95 % intervals of figures that follow from differences; of samples only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within: Option<Within>,
    /// DRAM bytes of other classes that culling saves: first replay minus second.
    pub saved: i64,
    /// DRAM bytes of the words' own classes.
    pub words: u64,
    /// Extra DRAM bytes of other classes, whose lines the words evicted.
    pub interference: i64,
    /// Misses of other classes in all caches that free words do not cause; `None` for samples, which have no interval
    /// of them.
    pub extra_misses: Option<i64>,
    /// Hits over accesses of words, counters and ids in the first cache that they meet; `None` without such a cache.
    pub word_hit_rate: Option<f64>,
    /// Shadow rays asked for.
    pub shadow_rays: u64,
    /// Share of shadow rays that were skipped or traced among dynamic objects only.
    pub culled: f64,
    /// DRAM bytes per ray without culling.
    pub bytes_per_ray: f64,
    /// The share of shadow rays that must be culled to save what the words cost, at [`Split::bytes_per_ray`].
    pub break_even: Option<f64>,
}

/// Half the widths of the 95 % intervals of parts of a split.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Within {
    /// Of [`Split::saved`], in bytes.
    pub saved: f64,
    /// Of [`Split::interference`], in bytes.
    pub interference: f64,
    /// Of [`Split::break_even`].
    pub break_even: Option<f64>,
}

impl Within {
    /// The half widths of three samples; `None` for exact replays. The errors of a difference and of its scale add
    /// up: the worst case.
    fn new([off, free, real]: [&MachineStats; 3], possible: f64) -> Option<Self> {
        let all = |stats: &MachineStats| stats.moved("dram").0 as f64;
        let less = |from: &MachineStats, other: &MachineStats| {
            let ratio = all(other) / all(from).max(1.0);
            let share = from.accuracy.shares()?[2];
            Some(all(from) * (other.half_width_of_ratio(from, 2, ratio)? + (1.0 - ratio).abs() * share))
        };
        let words = WORDS.iter().filter_map(|class| real.half_widths.get(&format!("bytes.dram.{}", class.name())));
        let paid = less(real, free)?;
        let share = (all(real) - all(free)).abs() * off.accuracy.shares()?[2];
        let break_even = (possible > 0.0).then(|| (paid + share) / possible);
        Some(Self { saved: less(off, free)?, interference: paid + words.sum::<f64>(), break_even })
    }
}

const WORDS: [TrafficClass; 3] = [TrafficClass::ModeWord, TrafficClass::PixelCounter, TrafficClass::OccluderId];

fn dram(stats: &MachineStats, of: impl Fn(TrafficClass) -> bool) -> u64 {
    let classes = stats.bytes.get("dram").into_iter().flatten();
    classes.filter(|(class, _)| of(**class)).map(|(_, bytes)| bytes.0).sum()
}

/// Energies of three replays, if all have one.
fn energies([off, free, real]: [&MachineStats; 3]) -> Option<[f64; 3]> {
    let of = |stats: &MachineStats| stats.energy.as_ref().map(|energy| energy.joules);
    Some([of(off)?, of(free)?, of(real)?])
}

/// Half the widths of the intervals of the changes of cycles and DRAM bytes; `None` if they are not known.
pub(crate) fn half_widths(before: &MachineStats, after: &MachineStats) -> Option<[f64; 2]> {
    let cycles = after.cycles.0 as f64 / before.cycles.0.max(1) as f64;
    let bytes = after.moved("dram").0 as f64 / before.moved("dram").0.max(1) as f64;
    Some([after.half_width_of_ratio(before, 0, cycles)?, after.half_width_of_ratio(before, 2, bytes)?])
}

/// Formats the change of a figure, with its interval if there is one.
pub(crate) fn change_within(before: f64, after: f64, half_width: Option<f64>) -> String {
    let text = or_absent(change(before, after), |it| it);
    match half_width {
        Some(half) => format!("{} \u{b1} {}", text.trim_end_matches(" %"), percent(half)),
        None => text,
    }
}

/// A change as a share, and half the width of its interval for samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shift {
    /// The change.
    pub share: f64,
    /// Half the width.
    pub half_width: Option<f64>,
}

impl Shift {
    /// The change from `without`; `None` if it is 0.
    pub(crate) fn new(with: u64, without: u64, half_width: Option<f64>) -> Option<Self> {
        (without > 0).then(|| Self { share: with as f64 / without as f64 - 1.0, half_width })
    }

    /// The ends of its interval; both are the change itself if it is exact.
    pub(crate) fn ends(self) -> [f64; 2] {
        [-1.0, 1.0].map(|side| self.share + side * self.half_width.unwrap_or_default())
    }
}

/// A column of a table of splits: its header, and the function that formats it.
pub(crate) type Column = (&'static str, fn(&Split) -> String);

impl Split {
    /// The split of three measurements (without culling, with free words, with the policy's words) of a stream with
    /// `totals`.
    pub(crate) fn new([off, free, real]: [&MachineStats; 3], totals: &Totals) -> Self {
        let all = |stats| Bytes(dram(stats, |_| true));
        let others = |stats| dram(stats, |class| !WORDS.contains(&class)) as i64;
        let other_misses = |stats: &MachineStats| -> i64 {
            let classes = stats.caches.values().flatten().filter(|(class, _)| !WORDS.contains(class));
            classes.map(|(_, counts)| counts.misses as i64).sum()
        };
        let word_hit_rate = real.first_caches().find_map(|cache| {
            let classes = real.caches.get(cache)?.iter().filter(|(class, _)| WORDS.contains(class));
            let (hits, accesses) = classes.fold((0, 0), |sum, (_, it)| (sum.0 + it.hits, sum.1 + it.accesses));
            (accesses > 0).then_some(hits as f64 / accesses as f64)
        });
        let words = dram(real, |class| WORDS.contains(&class));
        let (saved, interference) = (others(off) - others(free), others(real) - others(free));
        let bytes_per_ray = all(off).0 as f64 / off.rays.max(1) as f64;
        let culled = totals.shadow_rays_skipped + totals.shadow_rays_dynamic_only;
        let possible = bytes_per_ray * totals.shadow_rays as f64;
        let within = Within::new([off, free, real], possible);
        let extra_misses = within.is_none().then(|| other_misses(real) - other_misses(free));
        Self {
            cycles: [off, free, real].map(|stats| stats.cycles.0),
            dram: [off, free, real].map(all),
            joules: energies([off, free, real]),
            half_widths: half_widths(off, real),
            within,
            saved,
            words,
            interference,
            extra_misses,
            word_hit_rate,
            shadow_rays: totals.shadow_rays,
            culled: culled as f64 / totals.shadow_rays.max(1) as f64,
            bytes_per_ray,
            break_even: (possible > 0.0).then(|| (words as i64 + interference) as f64 / possible),
        }
    }

    /// The changes of cycles and DRAM bytes by culling; `None` for a figure that is 0 without culling.
    pub(crate) fn shifts(&self) -> [Option<Shift>; 2] {
        let half_width = |at: usize| self.half_widths.map(|both| both[at]);
        [
            Shift::new(self.cycles[2], self.cycles[0], half_width(0)),
            Shift::new(self.dram[2].0, self.dram[0].0, half_width(1)),
        ]
    }

    /// Hands over the numbers as rows of `results.csv`. A number that samples cannot estimate has a row without a
    /// value.
    ///
    /// # Errors
    /// A number cannot be represented in JSON, or `take` fails.
    pub(in crate::report) fn rows(
        &self,
        is_exact: bool,
        walk: Walk<'_>,
        take: &mut Take<'_>,
    ) -> Result<(), ReportError> {
        let within = |path: &str| match path {
            "saved" => Some(self.within?.saved),
            "interference" => Some(self.within?.interference),
            "break_even" => self.within?.break_even,
            _ => None,
        };
        let half_width = |path: &str| if is_exact { Some(0.0) } else { within(path) };
        let walk = Walk { half_width: &half_width, ..walk };
        walk.rows(self, take)?;
        match walk.family.metric("extra_misses").filter(|_| self.extra_misses.is_none()) {
            None => Ok(()),
            Some(metric) => {
                let (of, part) = (walk.of, walk.part);
                take(&Row { of, part, class: None, metric, value: None, half_width: None })
            }
        }
    }

    /// The columns of a readable table.
    pub(crate) const COLUMNS: [Column; 9] = [
        ("cycles", |it| {
            change_within(it.cycles[0] as f64, it.cycles[2] as f64, it.half_widths.map(|[cycles, _]| cycles))
        }),
        ("DRAM", |it| change_within(it.dram[0].0 as f64, it.dram[2].0 as f64, it.half_widths.map(|[_, dram]| dram))),
        ("saved", |it| signed_within(it.saved, it.within.map(|within| within.saved))),
        ("words", |it| bytes(Bytes(it.words))),
        ("interference", |it| signed_within(it.interference, it.within.map(|within| within.interference))),
        ("extra misses", |it| match it.extra_misses {
            Some(misses) => short(misses as f64).replace('-', "\u{2212}"),
            None => "not known".into(),
        }),
        ("word hits", |it| or_absent(it.word_hit_rate, percent)),
        ("culled", |it| percent(it.culled)),
        ("break-even", |it| {
            let half = it.within.and_then(|within| within.break_even);
            let half = half.map_or_else(String::new, |half| format!(" \u{b1} {}", percent(half)));
            or_absent(it.break_even, |share| format!("{}{half}", percent(share)))
        }),
    ];

    /// Columns of energy in a readable table: its change, the part that culling saves with free words, and the cost
    /// of words.
    pub(crate) const ENERGY: [Column; 3] = [
        ("energy", |it| or_absent(it.joules, |[off, _, real]| change_within(off, real, None))),
        ("energy saved", |it| or_absent(it.joules, |[off, free, _]| signed_joules(off - free))),
        ("energy paid", |it| or_absent(it.joules, |[_, free, real]| signed_joules(real - free))),
    ];

    /// The columns of a CSV.
    pub(crate) const FIELDS: [Column; 20] = [
        ("cycles_off", |it| it.cycles[0].to_string()),
        ("cycles_free_words", |it| it.cycles[1].to_string()),
        ("cycles", |it| it.cycles[2].to_string()),
        ("dram_bytes_off", |it| it.dram[0].to_string()),
        ("dram_bytes_free_words", |it| it.dram[1].to_string()),
        ("dram_bytes", |it| it.dram[2].to_string()),
        ("cycles_change_half_width", |it| number(it.half_widths.map(|[cycles, _]| cycles))),
        ("dram_bytes_change_half_width", |it| number(it.half_widths.map(|[_, dram]| dram))),
        ("saved_bytes_half_width", |it| number(it.within.map(|within| within.saved))),
        ("interference_bytes_half_width", |it| number(it.within.map(|within| within.interference))),
        ("break_even_share_half_width", |it| number(it.within.and_then(|within| within.break_even))),
        ("saved_bytes", |it| it.saved.to_string()),
        ("word_bytes", |it| it.words.to_string()),
        ("interference_bytes", |it| it.interference.to_string()),
        ("extra_misses", |it| it.extra_misses.map_or_else(String::new, |misses| misses.to_string())),
        ("word_hit_rate", |it| number(it.word_hit_rate)),
        ("shadow_rays", |it| it.shadow_rays.to_string()),
        ("culled_share", |it| it.culled.to_string()),
        ("dram_bytes_per_ray_off", |it| it.bytes_per_ray.to_string()),
        ("break_even_share", |it| number(it.break_even)),
    ];
}

/// An energy that may be below zero.
fn signed_joules(value: f64) -> String {
    let sign = if value < 0.0 { "\u{2212}" } else { "" };
    format!("{sign}{}", joules(value.abs()))
}

fn number(value: Option<f64>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}

/// An amount of data that may be below zero, with its interval if it has one.
fn signed_within(value: i64, half_width: Option<f64>) -> String {
    match half_width {
        Some(half) => format!("{} \u{b1} {}", signed(value), bytes(Bytes(half.ceil() as u64))),
        None => signed(value),
    }
}

/// An amount of data that may be below zero.
pub(crate) fn signed(value: i64) -> String {
    let sign = if value < 0 { "\u{2212}" } else { "" };
    format!("{sign}{}", bytes(Bytes(value.unsigned_abs())))
}
