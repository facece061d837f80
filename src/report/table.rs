//! Tables: `frames.csv` with every count, and the few figures that sum a run up, for the terminal and the page.

use comfy_table::{CellAlignment, Table};

use super::format::{bytes, change, exact, joules, milliseconds, or_absent, percent, short};
use super::split::Split;
use super::steady;
use super::summary::{FrameSummary, MachineRun, MachineSummary, PolicySummary, Psnr, Summary};
use crate::counters::Counter;
use crate::quantity::Bytes;
use crate::stats::{
    Accuracy, Bounds, CacheCounts, CacheStats, Cause, DramCounts, Energy, FrameStats, L1Counts, Limit, MachineStats,
    ModelCheck, Needs, PartNeed, TrafficClass,
};
use crate::stream::Totals;

/// A column of `frames.csv`: its header, and the field of a frame (empty where absent).
type Column = (&'static str, fn(&FrameSummary) -> String);

fn field<T: ToString>(value: Option<T>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}

/// The columns behind the frame's number and the tracer's counters.
const COLUMNS: [Column; 9] = [
    ("occlusion_tests", |row| row.counts.occlusion_tests.to_string()),
    ("occlusion_tests_per_pixel", |row| field(row.counts.occlusion_tests_per_pixel)),
    ("traversal_saved", |row| field(row.traversal_saved)),
    ("intersection_saved", |row| field(row.intersection_saved)),
    ("false_dark", |row| field(row.counts.false_dark)),
    ("false_lit", |row| field(row.counts.false_lit)),
    ("compared_rays", |row| field(row.counts.compared_rays)),
    ("numeric_differences", |row| field(row.counts.numeric_differences)),
    ("psnr_db", |row| match row.psnr {
        None => String::new(),
        Some(Psnr::Identical) => "inf".into(),
        Some(Psnr::Decibel(ratio)) => ratio.to_string(),
    }),
];

/// A column of a machine in `frames.csv`, behind the machine's name and a dot.
type MachineColumn = (String, Box<dyn Fn(&FrameStats) -> String>);

/// What a machine measured in frames, with the caches, levels and units that it has.
fn machine_columns(machine: &MachineSummary) -> Vec<MachineColumn> {
    let frames = || machine.policies.iter().flat_map(|(_, run)| &run.stats.frames);
    let Some(first) = frames().next() else { return Vec::new() };
    let mut columns: Vec<MachineColumn> = vec![
        ("warmup".into(), Box::new(|frame| u8::from(frame.warmup).to_string())),
        ("cycles".into(), Box::new(|frame| frame.cycles.to_string())),
        ("rays".into(), Box::new(|frame| frame.rays.to_string())),
        ("answered".into(), Box::new(|frame| frame.answered.to_string())),
    ];
    for level in first.bytes.keys() {
        let (name, level) = (format!("bytes.{level}"), level.clone());
        columns.push((name, Box::new(move |frame| field(frame.bytes.get(&level)))));
    }
    for cache in first.caches.keys() {
        for (at, counter) in CacheCounts::DECLARED.iter().enumerate() {
            let (name, cache) = (format!("caches.{cache}.{}", counter.name), cache.clone());
            columns.push((name, Box::new(move |frame| field(frame.caches.get(&cache).map(|it| it.values()[at])))));
        }
    }
    for (unit, causes) in &first.units {
        for &cause in causes.keys() {
            let (name, unit) = (format!("units.{unit}.{}", cause.name()), unit.clone());
            columns.push((name, Box::new(move |frame| field(frame.units.get(&unit).and_then(|it| it.get(&cause))))));
        }
    }
    for (at, counter) in DramCounts::DECLARED.iter().enumerate() {
        columns.push((format!("dram.{}", counter.name), Box::new(move |frame| frame.dram.values()[at].to_string())));
    }
    if let Some(energy) = &first.energy {
        let of = |figure: fn(&Energy) -> f64| move |frame: &FrameStats| field(frame.energy.as_ref().map(figure));
        columns.push(("energy.joules".into(), Box::new(of(|energy| energy.joules))));
        columns.push(("energy.low".into(), Box::new(of(|energy| energy.low))));
        columns.push(("energy.high".into(), Box::new(of(|energy| energy.high))));
        for part in energy.by.keys() {
            let (name, part) = (format!("energy.by.{part}"), part.clone());
            columns.push((name, Box::new(move |frame| field(frame.energy.as_ref().and_then(|it| it.by.get(&part))))));
        }
    }
    columns
}

/// `frames.csv`: a row a policy and frame, policies in the experiment's order. Of a frame that a machine did not replay its
/// columns are empty.
pub fn frames_csv(summary: &Summary) -> Result<Vec<u8>, csv::Error> {
    let mut csv = csv::Writer::from_writer(Vec::new());
    let counters = Totals::DECLARED.iter().map(|counter| counter.name);
    let machines: Vec<_> =
        summary.machines.iter().map(|(name, machine)| (name, machine, machine_columns(machine))).collect();
    let head = ["policy", "frame"].into_iter().chain(counters).chain(COLUMNS.map(|(header, _)| header));
    let of_machines = machines
        .iter()
        .flat_map(|(name, _, columns)| columns.iter().map(move |(column, _)| format!("{name}.{column}")));
    csv.write_record(head.map(str::to_owned).chain(of_machines))?;
    for (name, policy) in summary.policies.iter() {
        for row in &policy.frames {
            let counters = row.counts.totals.values().map(|value| value.to_string());
            let others = COLUMNS.map(|(_, text)| text(row));
            let of_machines = machines.iter().flat_map(|(_, machine, columns)| {
                let run = machine.policies.get(name);
                let frame = run.and_then(|run| run.stats.frames.iter().find(|frame| frame.frame == row.frame));
                columns.iter().map(move |(_, text)| frame.map_or_else(String::new, text))
            });
            let names = [name.to_owned(), row.frame.to_string()];
            csv.write_record(names.into_iter().chain(counters).chain(others).chain(of_machines))?;
        }
    }
    csv.into_inner().map_err(|error| error.into_error().into())
}

/// A table of texts: names, then numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Grid {
    /// Headers.
    pub head: Vec<String>,
    /// How many of the columns are names.
    pub names: usize,
    /// Rows, each as long as `head`.
    pub rows: Vec<Vec<String>>,
}

/// The policies' key figures.
pub fn policies(summary: &Summary) -> Grid {
    const HEAD: [&str; 9] = [
        "policy",
        "skipped",
        "dyn. only",
        "nodes saved",
        "triangles saved",
        "tests/pixel",
        "false dark",
        "false lit",
        "numeric",
    ];
    let row = |(name, policy): (&str, &PolicySummary)| {
        let counts = &policy.counts;
        let of_shadow_rays = |rays: u64| {
            if counts.shadow_rays == 0 { None } else { Some(rays as f64 / counts.shadow_rays as f64) }
        };
        vec![
            name.to_owned(),
            or_absent(of_shadow_rays(counts.shadow_rays_skipped), percent),
            or_absent(of_shadow_rays(counts.shadow_rays_dynamic_only), percent),
            or_absent(policy.traversal_saved.mean, percent),
            or_absent(policy.intersection_saved.mean, percent),
            or_absent(counts.occlusion_tests_per_pixel, |tests| format!("{tests:.3}")),
            or_absent(counts.false_dark, exact),
            or_absent(counts.false_lit, exact),
            or_absent(counts.numeric_differences, exact),
        ]
    };
    Grid { head: HEAD.map(Into::into).to_vec(), names: 1, rows: summary.policies.iter().map(row).collect() }
}

/// All bytes that moved between DRAM and the level above.
pub fn dram_bytes(run: &MachineRun) -> Option<Bytes> {
    run.stats.bytes.get("dram").map(|classes| classes.values().copied().sum())
}

/// How `figure`, whose place among an accuracy's shares is `share`, changes from one run to another, with an interval if samples tell it.
fn change_of(
    figure: fn(&MachineRun) -> Option<f64>,
    share: usize,
    before: &MachineRun,
    after: &MachineRun,
) -> Option<String> {
    let (old, new) = (figure(before)?, figure(after)?);
    let text = change(old, new)?;
    Some(match after.stats.accuracy.of_ratio(&before.stats.accuracy, share, new / old) {
        Some(wide) => format!("{} \u{b1} {}", text.trim_end_matches(" %"), percent(wide)),
        None => text,
    })
}

/// How far a run's cycles and DRAM bytes may be from the truth, in a word.
fn error(accuracy: &Accuracy) -> String {
    match *accuracy {
        Accuracy::Exact => "none".into(),
        Accuracy::Estimated { cycles, dram_bytes, .. } => {
            format!("\u{b1} {}, {}", percent(cycles).trim_end_matches(" %"), percent(dram_bytes))
        }
        Accuracy::Few { windows, .. } => format!("unknown: {windows} windows"),
        Accuracy::Bounded => "within bounds".into(),
        Accuracy::Unknown => "unknown".into(),
    }
}

/// The machines' key figures of measured frames, with the change against the run without culling. Rays a second are those
/// answered.
pub fn machines(summary: &Summary) -> Grid {
    const HEAD: [&str; 8] =
        ["machine", "policy", "ms/frame", "rays/s", "DRAM/frame", "DRAM use", "energy/frame", "error (cycles, DRAM)"];
    let mut rows = Vec::new();
    for (name, machine) in summary.machines.iter() {
        let off = summary.baseline.as_deref().and_then(|baseline| machine.policies.get(baseline));
        for (policy, run) in machine.policies.iter() {
            let off = off.filter(|_| summary.baseline.as_deref() != Some(policy));
            let changed = |text: String, change: Option<String>| {
                change.map_or(text.clone(), |change| format!("{text} ({change})"))
            };
            let measured = |text: String, figure: fn(&MachineRun) -> Option<f64>, share: usize| {
                changed(text, off.and_then(|off| change_of(figure, share, off, run)))
            };
            let energy = off.and_then(|off| change(off.joules_per_frame?, run.joules_per_frame?));
            rows.push(vec![
                name.to_owned(),
                policy.to_owned(),
                measured(or_absent(run.milliseconds_per_frame, milliseconds), |run| run.milliseconds_per_frame, 0),
                or_absent(run.rays_answered_per_second, short),
                measured(or_absent(run.dram_bytes_per_frame, mean_bytes), |run| run.dram_bytes_per_frame, 2),
                or_absent(run.dram_utilization, percent),
                changed(or_absent(run.joules_per_frame, joules), energy),
                error(&run.stats.accuracy),
            ]);
        }
    }
    Grid { head: HEAD.map(Into::into).to_vec(), names: 2, rows }
}

fn mean_bytes(amount: f64) -> String {
    bytes(Bytes(amount.round() as u64))
}

/// What each policy saved and paid on a machine.
pub fn split(machine: &MachineSummary) -> Grid {
    let row = |(policy, split): (&str, &Split)| {
        std::iter::once(policy.to_owned()).chain(Split::COLUMNS.map(|(_, text)| text(split))).collect()
    };
    Grid {
        head: std::iter::once("policy").chain(Split::COLUMNS.map(|(name, _)| name)).map(Into::into).collect(),
        names: 1,
        rows: machine.split.iter().map(row).collect(),
    }
}

/// Nothing but a line under the header.
const PLAIN: &str = "     ──            ";

/// The run in a dozen lines for the terminal, without a line's end at the end.
pub fn terminal(summary: &Summary) -> String {
    let grids = [policies(summary), machines(summary)];
    let shown = grids.iter().filter(|grid| !grid.rows.is_empty()).map(drawn);
    let lines: Vec<String> = steady::frames(summary).into_iter().chain(steady::cold_starts(summary)).collect();
    let lines = (!lines.is_empty()).then(|| lines.join("\n"));
    shown.chain(lines).collect::<Vec<_>>().join("\n\n")
}

/// What one machine measured on one stream, for the terminal, without a line's end at the end.
pub fn replayed(machine: &str, policy: &str, stats: &MachineStats) -> String {
    let run = MachineRun::from(stats.clone());
    let head = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>();
    let sum = Grid {
        head: head(&["machine", "policy", "rays", "cycles", "rays/s", "DRAM traffic", "DRAM use", "row hits"]),
        names: 2,
        rows: vec![vec![
            machine.to_owned(),
            policy.to_owned(),
            exact(stats.rays),
            exact(stats.cycles.0),
            or_absent(run.rays_per_second, short),
            or_absent(dram_bytes(&run), bytes),
            or_absent(run.dram_utilization, percent),
            or_absent(run.dram_row_hit_rate, percent),
        ]],
    };
    let caches = caches(stats);
    let units = stats.units.iter().map(|(unit, causes)| {
        // A rung that does not tell all causes leaves them out.
        let all = stats.cycles.0 * stats.unit_counts.get(unit).copied().unwrap_or(0);
        let shares = Cause::ALL.iter().map(|cause| {
            let cycles = causes.get(cause).filter(|_| all > 0);
            or_absent(cycles, |&cycles| percent(cycles as f64 / all as f64))
        });
        let count = or_absent(stats.unit_counts.get(unit).copied(), exact);
        [unit.clone(), count].into_iter().chain(shares).collect()
    });
    let causes = Cause::ALL.iter().map(|cause| cause.name());
    let units = Grid {
        head: ["unit", "count"].into_iter().chain(causes).map(Into::into).collect(),
        names: 1,
        rows: units.collect(),
    };
    let dram = format!("DRAM: {}", stats.dram_organization);
    let needs = stats.needs.iter().flat_map(|needs| [drawn(&parts(needs)), drawn(&models(needs))]);
    let rest = [dram, drawn(&caches), drawn(&units)];
    [drawn(&sum), trust(stats)].into_iter().chain(needs).chain(rest).collect::<Vec<_>>().join("\n\n")
}

/// What each cache counted, a class a row; a counter that a level does not have is absent there.
fn caches(stats: &MachineStats) -> Grid {
    let words = |counter: &Counter| counter.name.replace('_', " ");
    let counters = CacheCounts::DECLARED.iter().chain(L1Counts::DECLARED).map(words);
    let row = |cache: &str, class: TrafficClass, stats: &CacheStats| {
        let names = [cache.to_owned(), class.name().to_owned(), or_absent(stats.hit_rate(), percent)];
        let l1 = stats.l1.map(|l1| l1.values());
        let l1 = (0..L1Counts::DECLARED.len()).map(|index| or_absent(l1.map(|values| values[index]), exact));
        names.into_iter().chain(stats.values().map(exact)).chain(l1).collect()
    };
    Grid {
        head: ["cache", "class", "hit rate"].map(Into::into).into_iter().chain(counters).collect(),
        names: 2,
        rows: stats
            .caches
            .iter()
            .flat_map(|(cache, classes)| classes.iter().map(|(&class, it)| row(cache, class, it)))
            .collect(),
    }
}

/// How far from the truth the numbers may be, and what no machine can leave.
fn trust(stats: &MachineStats) -> String {
    let error = match stats.accuracy {
        Accuracy::Exact => "none: the machine's rules, cycle for cycle".to_owned(),
        Accuracy::Estimated { cycles, l2_bytes, dram_bytes, rate } => {
            let [cycles, l2, dram, rate] = [cycles, l2_bytes, dram_bytes, rate].map(percent);
            format!(
                "within {cycles} (cycles), {l2} (L2) and {dram} (DRAM), at 95 %; {rate} of all windows were measured"
            )
        }
        Accuracy::Few { windows, telling } => {
            format!("unknown: the sample has {windows} windows, too few to tell ({telling} would)")
        }
        Accuracy::Bounded => "not known, but within the bounds".to_owned(),
        Accuracy::Unknown => "unknown".to_owned(),
    };
    let mut lines = vec![format!("Error: {error}")];
    if let Some(Bounds { cycles, dram_bytes, .. }) = stats.bounds {
        lines.push(format!(
            "Bounds: {} to {} cycles, {} to {} of DRAM traffic",
            exact(cycles.least.0),
            short(cycles.most.0 as f64),
            bytes(dram_bytes.least),
            bytes(dram_bytes.most)
        ));
    }
    if let Some(Limit { cycles, dram_bytes }) = stats.oracle {
        lines.push(format!(
            "If all shadow rays' answers were known: {} cycles, {} of DRAM traffic at least",
            exact(cycles.0),
            bytes(dram_bytes)
        ));
    }
    lines.join("\n")
}

/// What each part of the machine is worth on a stream.
pub fn parts(needs: &Needs) -> Grid {
    let signed = |share: Option<f64>| or_absent(share.and_then(|it| change(1.0, 1.0 + it)), |it| it);
    let row = |it: &PartNeed| {
        let [cycles, l2, dram] = [it.cycles, it.l2_bytes, it.dram_bytes].map(signed);
        vec![it.part.clone(), if it.matters { "matters" } else { "does not matter" }.into(), cycles, l2, dram]
    };
    Grid {
        head: ["without", "", "cycles", "L2 bytes", "DRAM bytes"].map(Into::into).to_vec(),
        names: 2,
        rows: needs.parts.iter().map(row).collect(),
    }
}

/// Which models were tried on a stream; the last was taken.
pub fn models(needs: &Needs) -> Grid {
    let row = |it: &ModelCheck| {
        let verdict = if it.passes { "close enough" } else { "not close enough" };
        vec![it.model.clone(), verdict.into(), or_absent(it.error, percent), or_absent(it.held_back, percent)]
    };
    Grid {
        head: ["model", "", "error", "on what was held back"].map(Into::into).to_vec(),
        names: 2,
        rows: needs.models.iter().map(row).collect(),
    }
}

/// A table for the terminal, without a line's end at the end.
pub fn drawn(grid: &Grid) -> String {
    let mut table = Table::new();
    table.load_preset(PLAIN).set_header(&grid.head).add_rows(&grid.rows);
    for column in table.column_iter_mut().skip(grid.names) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.trim_fmt()
}
