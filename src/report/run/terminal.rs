//! A run in the terminal: its main tables, and its verdict.

use super::choice::choice;
use super::limits::limit;
use super::machine_run::MachineRun;
use super::steady;
use super::summary::{Claim, Summary};
use super::tables::{dram_per_frame, error, interval_of, policies};
use crate::named::Named;
use crate::report::format::{ABSENT, change, counted, exact, joules, milliseconds, or_absent, percent, short};
use crate::report::grid::{Grid, drawn_most, paragraph};
use crate::stats::{Accuracy, MachineStats};

/// Changes below this share count as none.
const SAME: f64 = 0.005;
/// Order of the policies' columns: a narrow terminal shows the first ones.
const POLICY_COLUMNS: [usize; 9] = [0, 1, 3, 4, 6, 7, 5, 8, 2];

/// The run in a dozen lines, without a final line break.
pub(crate) fn terminal(summary: &Summary) -> String {
    let head = format!(
        "{}: {}, {} of {}",
        summary.experiment,
        summary.scene.name,
        counted(summary.frames.len(), "frame"),
        summary.resolution
    );
    let stopped = summary.provenance.get("stopped early").map(|done| format!("stopped early: {done}"));
    let notes = steady::frames(summary).into_iter().chain(steady::cold_starts(summary)).chain(stopped);
    let notes = notes.chain(choices(summary));
    let notes = std::iter::once(head).chain(notes).map(|line| paragraph(&line)).collect::<Vec<_>>().join("\n");
    let grid = machines(summary);
    let machines = (!grid.rows.is_empty()).then(|| drawn_most(&grid, MACHINE_COLUMNS));
    let policies = drawn_most(&chosen(&policies(summary), &POLICY_COLUMNS), 6);
    [Some(notes), machines, Some(policies)].into_iter().flatten().collect::<Vec<_>>().join("\n\n")
}

/// The decisions of `Auto` on the streams of each machine.
fn choices(summary: &Summary) -> impl Iterator<Item = String> {
    let machines = summary.machines.iter();
    machines
        .filter_map(|(name, it)| Some(format!("{name}: {}", choice(it.policies.iter().map(|(_, run)| &run.stats))?)))
}

fn chosen(grid: &Grid, columns: &[usize]) -> Grid {
    let of = |row: &Vec<String>| columns.iter().filter_map(|&column| row.get(column).cloned()).collect();
    Grid { head: of(&grid.head), names: grid.names, rows: grid.rows.iter().map(of).collect() }
}

/// Number of the machines' columns that fit a terminal of 80 columns.
const MACHINE_COLUMNS: usize = 6;

/// One row for each machine and culling policy: time and DRAM traffic of a frame, without the policy and with it.
pub(super) fn machines(summary: &Summary) -> Grid {
    let runs = || summary.machines.iter().flat_map(|(_, machine)| machine.policies.iter());
    let all_exact = runs().all(|(_, run)| matches!(run.stats.accuracy, Accuracy::Exact));
    let mut head = vec!["machine", "policy", "ms/frame", "change", "DRAM MB/frame", "change"];
    if !all_exact {
        head.push("\u{b1} time, DRAM");
    }
    head.extend(["rays answered/s", "DRAM use", "energy/frame"]);
    let mut rows = Vec::new();
    for (name, machine) in summary.machines.iter() {
        let off = summary.baseline.as_deref().and_then(|baseline| machine.policies.get(baseline));
        let culling = machine.policies.iter().filter(|(policy, _)| summary.baseline.as_deref() != Some(*policy));
        let culling: Vec<_> = culling.collect();
        // Without a culling policy, the rows show the machine's own runs.
        let shown = if culling.is_empty() { machine.policies.iter().collect() } else { culling };
        for (policy, run) in shown {
            let pair = |figure: fn(&MachineRun) -> Option<f64>, show: fn(f64) -> String| {
                let after = or_absent(figure(run), show);
                off.map_or(after.clone(), |off| format!("{} \u{2192} {after}", or_absent(figure(off), show)))
            };
            let changed = |figure: fn(&MachineRun) -> Option<f64>, share: usize| {
                let change = off.and_then(|off| interval_of(figure, share, off, run));
                change.unwrap_or_else(|| ABSENT.into())
            };
            let megabytes = |bytes: f64| milliseconds(bytes / 1e6);
            let mut row = vec![
                name.to_owned(),
                policy.to_owned(),
                pair(|run| run.milliseconds_per_frame, milliseconds),
                changed(|run| run.milliseconds_per_frame, 0),
                pair(dram_per_frame, megabytes),
                changed(dram_per_frame, 2),
            ];
            if !all_exact {
                row.push(error(&run.stats.accuracy));
            }
            row.push(or_absent(run.rays_answered_per_second, short));
            row.push(or_absent(run.dram_utilization, percent));
            row.push(or_absent(run.joules_per_frame, joules));
            rows.push(row);
        }
    }
    Grid { head: head.into_iter().map(Into::into).collect(), names: 2, rows }
}

/// The result of the run, in sentences: the change of a frame's time, and the number of wrong decisions.
pub(crate) fn verdict(summary: &Summary) -> Option<String> {
    let culling = || summary.policies.iter().filter(|(name, _)| summary.baseline.as_deref() != Some(*name));
    let speed = culling().filter_map(|(policy, _)| {
        let told = summary.machines.iter().filter_map(|(name, machine)| {
            let [off, with] = [summary.baseline.as_deref()?, policy].map(|name| machine.policies.get(name));
            let (off, with) = (off?, with?);
            let change = time(off.milliseconds_per_frame?, with.milliseconds_per_frame?)?;
            match machine.claim(with) {
                Claim::Known => Some(format!("{change} on {name}")),
                Claim::By(level) => Some(format!("{change} on {name} by {level}, error unknown")),
                Claim::Nothing => None,
            }
        });
        let told: Vec<String> = told.collect();
        (!told.is_empty()).then(|| format!("{policy}: a frame takes {}", told.join(", ")))
    });
    let wrong = culling().filter_map(|(policy, of)| {
        let (wrong, asked) = (of.counts.wrong()?, of.counts.shadow_rays);
        let share = (wrong > 0 && asked > 0).then(|| format!(" ({})", percent(wrong as f64 / asked as f64)));
        let told = format!("{} of {}{}", exact(wrong), short(asked as f64), share.unwrap_or_default());
        Some(if culling().count() == 1 { told } else { format!("{policy} {told}") })
    });
    let wrong: Vec<String> = wrong.collect();
    let wrong = (!wrong.is_empty()).then(|| format!("wrong shadow decisions in all frames: {}", wrong.join(", ")));
    let lines: Vec<String> = speed.chain(wrong).collect();
    (!lines.is_empty()).then(|| lines.join("\n"))
}

/// One sentence per machine about the part that limits it on a stream.
pub(crate) fn replay_verdict(machines: &Named<MachineStats>) -> String {
    let told = machines.iter().map(|(name, stats)| {
        let limit = limit(&MachineRun::from(stats.clone()));
        format!("{name}: {}", limit.map_or("what limits it is not known at this level".into(), |limit| limit.text))
    });
    told.collect::<Vec<_>>().join("\n")
}

/// The change of a frame's time, in words.
fn time(before: f64, after: f64) -> Option<String> {
    let share = after / before - 1.0;
    let size = change(before, after)?.trim_start_matches(['+', '\u{2212}']).to_owned();
    Some(match share {
        share if share.abs() < SAME => "as much time".into(),
        share if share < 0.0 => format!("{size} less time"),
        _ => format!("{size} more time"),
    })
}
