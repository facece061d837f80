//! The tables of a run's page.

use crate::quantity::Bytes;
use crate::report::format::{bytes, exact, joules, milliseconds, or_absent, percent, short};
use crate::report::grid::Grid;
use crate::report::run::machine_run::MachineRun;
use crate::report::run::summary::{PolicySummary, Psnr, Summary};
use crate::report::run::tables::{OF_POLICIES, PolicyColumn, interval_of, of_policies, share_of_shadow_rays};
use crate::stats::Accuracy;

/// The meanings of columns.
pub(super) const MEANINGS: &[(&str, &str)] = &[
    ("skipped", "share of shadow rays answered without being traced"),
    ("dynamic only", "share of shadow rays traced among dynamic objects only"),
    ("nodes saved", "1 - node visits of shadow rays with the policy / without; mean of the frames"),
    ("triangles saved", "1 - triangle tests of shadow rays with the policy / without; mean of the frames"),
    ("tests/pixel", "occlusion tests that the policy makes a pixel; they are not in the shares saved"),
    ("false dark", "shadow rays decided dark that, traced without culling, find the light"),
    ("false lit", "shadow rays decided lit that, traced without culling, are stopped"),
    ("wrong share", "false dark and false lit over all shadow rays"),
    ("numeric", "shadow rays on which tracer (f32) and reference renderer (f64) differ: rounding, no decision"),
    ("lowest PSNR", "peak signal-to-noise ratio of the worst picture against the reference renderer's"),
    ("ms/frame", "simulated time of a measured frame, the mean"),
    ("time", "change of ms/frame against the run without culling"),
    ("DRAM", "change of DRAM/frame against the run without culling"),
    ("answered/s", "rays answered a second of simulated time, skipped ones among them"),
    ("DRAM/frame", "bytes that the DRAM moved a measured frame, the mean"),
    ("DRAM use", "bytes that the DRAM moved, over those that it could have moved at its peak"),
    ("energy/frame", "energy a measured frame with typical constants"),
    ("\u{b1} time, DRAM", "half the 95 % intervals of a sample"),
    ("extra misses", "misses of other classes, in all caches, that free words do not cause"),
    ("word hits", "hits over accesses of words in the first cache that they meet"),
    ("culled", "share of shadow rays skipped or traced among dynamic objects only"),
    ("break-even", "share of shadow rays that must be culled to save what the words cost"),
    ("interference", "extra DRAM bytes of other classes, whose lines the words evicted"),
    ("energy", "change of the measured frames' energy against the run without culling"),
    ("energy saved", "energy that culling saves if words cost nothing"),
    ("energy paid", "energy that words cost: with them, less with words that cost nothing"),
];

fn culling(summary: &Summary) -> impl Iterator<Item = (&str, &PolicySummary)> {
    summary.policies.iter().filter(|&(name, _)| summary.baseline.as_deref() != Some(name))
}

/// The effect of each culling policy on shadow rays.
pub(super) fn policies(summary: &Summary) -> Grid {
    let further: [PolicyColumn; 2] = [
        ("wrong share", |policy| share_of_shadow_rays(policy, policy.counts.wrong())),
        ("lowest PSNR", |policy| or_absent(lowest_psnr(policy), psnr)),
    ];
    of_policies(culling(summary), &[&OF_POLICIES[..], &further].concat())
}

fn lowest_psnr(policy: &PolicySummary) -> Option<Psnr> {
    policy.frames.iter().filter_map(|frame| frame.psnr).reduce(|low, next| match (low, next) {
        (Psnr::Decibel(a), Psnr::Decibel(b)) => Psnr::Decibel(a.min(b)),
        (Psnr::Identical, other) | (other, Psnr::Identical) => other,
    })
}

/// A ratio as text.
pub(super) fn psnr(psnr: Psnr) -> String {
    match psnr {
        Psnr::Identical => "identical".into(),
        Psnr::Decibel(ratio) => format!("{ratio:.1} dB"),
    }
}

/// Every machine's figures under every policy, with the change against the run without culling.
pub(super) fn machines(summary: &Summary) -> Grid {
    const HEAD: [&str; 10] = [
        "machine",
        "policy",
        "ms/frame",
        "time",
        "answered/s",
        "DRAM/frame",
        "DRAM",
        "DRAM use",
        "energy/frame",
        "\u{b1} time, DRAM",
    ];
    let shares = |run: &MachineRun| match run.stats.accuracy {
        Accuracy::Exact => None,
        accuracy => Some(
            accuracy
                .shares()
                .map_or("unknown".into(), |[time, _, dram]| format!("{}, {}", percent(time), percent(dram))),
        ),
    };
    let runs = || summary.machines.iter().flat_map(|(name, it)| it.policies.iter().map(move |run| (name, it, run)));
    // If all runs are exact, the column of intervals is left out.
    let any = runs().any(|(.., (_, run))| shares(run).is_some());
    let columns = HEAD.len() - usize::from(!any);
    let rows = runs().map(|(name, machine, (policy, run))| {
        let off = summary.baseline.as_deref().filter(|&baseline| baseline != policy);
        let off = off.and_then(|baseline| machine.policies.get(baseline));
        let changed = |figure: fn(&MachineRun) -> Option<f64>, share: usize| {
            let text = off.and_then(|off| interval_of(figure, share, off, run));
            text.unwrap_or_else(|| if off.is_none() { "base".into() } else { or_absent(None::<f64>, short) })
        };
        let mut row = vec![
            name.to_owned(),
            policy.to_owned(),
            or_absent(run.milliseconds_per_frame, milliseconds),
            changed(|run| run.milliseconds_per_frame, 0),
            or_absent(run.rays_answered_per_second, short),
            or_absent(run.dram_bytes_per_frame, |amount| bytes(Bytes(amount.round() as u64))),
            changed(|run| run.dram_bytes_per_frame, 2),
            or_absent(run.dram_utilization, percent),
            or_absent(run.joules_per_frame, joules),
            shares(run).unwrap_or_else(|| "exact".into()),
        ];
        row.truncate(columns);
        row
    });
    Grid { head: HEAD[..columns].iter().map(|&name| name.into()).collect(), names: 2, rows: rows.collect() }
}

/// Wrong decisions towards each light.
pub(super) fn lights(summary: &Summary) -> Grid {
    let rows = culling(summary).flat_map(|(name, policy)| {
        policy.lights.iter().map(move |wrong| {
            vec![name.to_owned(), wrong.light.to_string(), exact(wrong.false_dark), exact(wrong.false_lit)]
        })
    });
    Grid {
        head: ["policy", "light", "false dark", "false lit"].map(Into::into).to_vec(),
        names: 1,
        rows: rows.collect(),
    }
}

/// The figures of each frame, one row per frame; the page's slider shows them too.
pub(super) fn frames(summary: &Summary) -> Grid {
    let mut head = vec!["frame".to_owned()];
    for (name, _) in culling(summary) {
        head.extend([format!("{name}: nodes saved"), format!("{name}: wrong")]);
    }
    for (machine, found) in summary.machines.iter() {
        head.extend(found.policies.iter().map(|(policy, _)| format!("{machine}, {policy}: ms")));
    }
    let row = |&number: &u32| {
        let mut row = vec![number.to_string()];
        for (_, policy) in culling(summary) {
            let frame = policy.frames.iter().find(|frame| frame.frame == number);
            row.push(or_absent(frame.and_then(|frame| frame.traversal_saved), percent));
            row.push(or_absent(frame.and_then(|frame| frame.counts.wrong()), exact));
        }
        for run in summary.machines.iter().flat_map(|(_, found)| found.policies.iter().map(|(_, run)| run)) {
            let frame = run.stats.frames.iter().find(|frame| frame.frame == number);
            let time = frame.map(|frame| frame.cycles.0 as f64 / (run.stats.clock_mhz * 1e3));
            row.push(or_absent(time, milliseconds));
        }
        row
    };
    Grid { head, names: 1, rows: summary.frames.iter().map(row).collect() }
}

/// Wall time and simulation speed, one row per stage.
pub(super) fn wall(summary: &Summary) -> Grid {
    let row = |(stage, seconds): (&str, &f64)| {
        let speed = summary.simulated_rays_per_wall_second.get(stage);
        vec![stage.into(), format!("{seconds:.2}"), or_absent(speed, |&speed| short(speed))]
    };
    Grid {
        head: ["stage", "seconds", "rays simulated a second"].map(Into::into).to_vec(),
        names: 1,
        rows: summary.wall_seconds.iter().map(row).collect(),
    }
}
