//! Key figures of a run, for the terminal and the page.

use super::choice::choice;
use super::machine_run::MachineRun;
use super::summary::{MachineSummary, PolicySummary, Summary};
use crate::counters::Counter;
use crate::named::Named;
use crate::quantity::Bytes;
use crate::report::format::{bytes, change, exact, or_absent, percent, short};
use crate::report::grid::{Grid, drawn, paragraph};
use crate::report::split::Split;
use crate::stats::{Accuracy, Bounds, CacheCounts, CacheStats, Cause, L1Counts, Limit, MachineStats, TrafficClass};

/// A figure of a policy: its name, and the function that formats it.
pub(super) type PolicyColumn = (&'static str, fn(&PolicySummary) -> String);

/// The effect of each policy on shadow rays, and its wrong decisions.
pub(super) const OF_POLICIES: [PolicyColumn; 7] = [
    ("skipped", |policy| share_of_shadow_rays(policy, Some(policy.counts.shadow_rays_skipped))),
    ("dynamic only", |policy| share_of_shadow_rays(policy, Some(policy.counts.shadow_rays_dynamic_only))),
    ("nodes saved", |policy| or_absent(policy.traversal_saved.mean, percent)),
    ("triangles saved", |policy| or_absent(policy.intersection_saved.mean, percent)),
    ("tests/pixel", |policy| or_absent(policy.counts.occlusion_tests_per_pixel, |tests| format!("{tests:.3}"))),
    ("false dark", |policy| or_absent(policy.counts.false_dark, exact)),
    ("false lit", |policy| or_absent(policy.counts.false_lit, exact)),
];

/// `rays` as a share of all shadow rays.
pub(super) fn share_of_shadow_rays(policy: &PolicySummary, rays: Option<u64>) -> String {
    let all = policy.counts.shadow_rays;
    or_absent(rays.filter(|_| all > 0).map(|rays| rays as f64 / all as f64), percent)
}

/// A table of policies with these figures.
pub(super) fn of_policies<'a>(
    policies: impl Iterator<Item = (&'a str, &'a PolicySummary)>,
    columns: &[PolicyColumn],
) -> Grid {
    let row = |(name, policy): (&str, &PolicySummary)| {
        std::iter::once(name.to_owned()).chain(columns.iter().map(|(_, text)| text(policy))).collect()
    };
    Grid {
        head: std::iter::once("policy").chain(columns.iter().map(|(name, _)| *name)).map(Into::into).collect(),
        names: 1,
        rows: policies.map(row).collect(),
    }
}

/// The policies' key figures.
pub(super) fn policies(summary: &Summary) -> Grid {
    let numeric: PolicyColumn = ("numeric", |policy| or_absent(policy.counts.numeric_differences, exact));
    of_policies(summary.policies.iter(), &[&OF_POLICIES[..], &[numeric]].concat())
}

/// All bytes that moved between DRAM and the level above.
pub(super) fn dram_bytes(run: &MachineRun) -> Option<Bytes> {
    run.stats.bytes.get("dram").map(|classes| classes.values().copied().sum())
}

/// The change of `figure` from one run to another, with its interval if it is known. `share` is the figure's index in
/// an accuracy's shares.
pub(super) fn interval_of(
    figure: fn(&MachineRun) -> Option<f64>,
    share: usize,
    before: &MachineRun,
    after: &MachineRun,
) -> Option<String> {
    let (old, new) = (figure(before)?, figure(after)?);
    let text = change(old, new)?;
    Some(match after.stats.half_width_of_ratio(&before.stats, share, new / old) {
        Some(wide) => format!("{} \u{b1} {}", text.trim_end_matches(" %"), percent(wide)),
        None => text,
    })
}

/// The error of a run's cycles and DRAM bytes, in short.
pub(super) fn error(accuracy: &Accuracy) -> String {
    match *accuracy {
        Accuracy::Exact => "exact".into(),
        Accuracy::Estimated { cycles, dram_bytes, .. } => {
            format!("\u{b1} {}, {}", percent(cycles).trim_end_matches(" %"), percent(dram_bytes))
        }
        Accuracy::Bounded => "within bounds".into(),
        Accuracy::Unknown => "unknown".into(),
    }
}

/// Mean DRAM bytes of a measured frame.
pub(super) fn dram_per_frame(run: &MachineRun) -> Option<f64> {
    run.dram_bytes_per_frame
}

/// Savings and costs of each policy on a machine.
pub(super) fn split(machine: &MachineSummary) -> Grid {
    let row = |(policy, split): (&str, &Split)| {
        let columns = Split::COLUMNS.into_iter().chain(Split::ENERGY);
        std::iter::once(policy.to_owned()).chain(columns.map(|(_, text)| text(split))).collect()
    };
    let columns = Split::COLUMNS.into_iter().chain(Split::ENERGY);
    Grid {
        head: std::iter::once("policy").chain(columns.map(|(name, _)| name)).map(Into::into).collect(),
        names: 1,
        rows: machine.split.iter().map(row).collect(),
    }
}

/// Measurements of machines on one stream in a timing model, for the terminal, without a final line break.
pub(crate) fn replayed(model: &str, policy: &str, machines: &Named<MachineStats>) -> String {
    let head = ["machine", "policy", "traced", "cycles", "traced/s", "DRAM traffic", "DRAM use", "row hits"];
    let row = |(machine, stats): (&str, &MachineStats)| {
        let run = MachineRun::from(stats.clone());
        vec![
            machine.to_owned(),
            policy.to_owned(),
            exact(stats.rays),
            exact(stats.cycles.0),
            or_absent(run.rays_per_second, short),
            or_absent(dram_bytes(&run), bytes),
            or_absent(run.dram_utilization, percent),
            or_absent(run.dram_row_hit_rate, percent),
        ]
    };
    let sum = Grid { head: head.map(Into::into).to_vec(), names: 2, rows: machines.iter().map(row).collect() };
    let parts = machines.iter().map(|(machine, stats)| {
        let name = (machines.len() > 1).then(|| format!("{machine}:"));
        name.into_iter().chain([in_detail(model, stats)]).collect::<Vec<_>>().join("\n")
    });
    std::iter::once(drawn(&sum)).chain(parts).collect::<Vec<_>>().join("\n\n")
}

/// The accuracy of a machine's figures, and its caches and cycle breakdown.
fn in_detail(model: &str, stats: &MachineStats) -> String {
    let units = stats.units.iter().map(|(unit, causes)| {
        // A fidelity level without figures of a cause has no share for it.
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
    let choice = choice([stats]).map(|line| paragraph(&line));
    let rest = [paragraph(&dram), drawn(&caches(stats)), drawn(&units)];
    choice.into_iter().chain([trust(model, stats)]).chain(rest).collect::<Vec<_>>().join("\n\n")
}

/// Counters of each cache, one row per class; a counter is absent where a level does not have it.
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

/// The error of the figures, and bounds that hold for all such machines.
fn trust(model: &str, stats: &MachineStats) -> String {
    let error = match stats.accuracy {
        Accuracy::Exact if model.starts_with("Sampled") => {
            "exact: all was replayed, since the target asks for more windows than pay".to_owned()
        }
        Accuracy::Exact => "exact; no sampling".to_owned(),
        Accuracy::Estimated { cycles, l2_bytes, dram_bytes, rate } => {
            let [cycles, l2, dram, rate] = [cycles, l2_bytes, dram_bytes, rate].map(percent);
            format!(
                "within {cycles} (cycles), {l2} (L2) and {dram} (DRAM), at 95 %; {rate} of all windows were measured"
            )
        }
        Accuracy::Bounded => "error not known, but within the bounds".to_owned(),
        Accuracy::Unknown => "error unknown".to_owned(),
    };
    let mut lines = vec![paragraph(&format!("Model: {model} ({error})"))];
    if let Some(Bounds { cycles, dram_bytes, .. }) = stats.bounds {
        let [least, traffic] = [exact(cycles.least.0), bytes(dram_bytes.least)];
        // The upper bound is far off, and useful only if nothing else is known.
        let line = if stats.accuracy.shares().is_some() {
            let share = or_absent((stats.cycles.0 > 0).then(|| cycles.least.0 as f64 / stats.cycles.0 as f64), percent);
            format!("Least that any such machine takes: {least} cycles ({share} of these), {traffic} of DRAM traffic")
        } else {
            let [most, most_bytes] = [short(cycles.most.0 as f64), bytes(dram_bytes.most)];
            format!("Bounds: {least} to {most} cycles, {traffic} to {most_bytes} of DRAM traffic")
        };
        lines.push(paragraph(&line));
    }
    if let Some(Limit { cycles, dram_bytes }) = stats.oracle {
        lines.push(paragraph(&format!(
            "If all shadow rays' answers were known: {} cycles, {} of DRAM traffic at least",
            exact(cycles.0),
            bytes(dram_bytes)
        )));
    }
    lines.join("\n")
}
