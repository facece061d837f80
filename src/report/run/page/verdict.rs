//! The finding in a sentence, and one tile per machine.

use minijinja::{Value, context};

use crate::quantity::Bytes;
use crate::report::format::{bytes, change, exact, joules, milliseconds, or_absent, percent, short};
use crate::report::run::limits::{Limit, limit};
use crate::report::run::machine_run::MachineRun;
use crate::report::run::summary::{Claim, MachineSummary, PolicySummary, Summary};

/// A smaller change of time counts as none.
const SAME: f64 = 0.02;

/// A machine's fastest culling policy, compared with the run without culling.
struct Best<'a> {
    machine: &'a str,
    policy: &'a str,
    /// Time with culling over time without, minus 1.
    change: f64,
    /// The fidelity level, if it is not known how far off it is.
    uncertain: Option<&'a str>,
    limit: Option<Limit>,
}

fn without<'a>(summary: &'a Summary, machine: &'a MachineSummary) -> Option<&'a MachineRun> {
    machine.policies.get(summary.baseline.as_deref()?)
}

/// The fastest culling policy.
fn fastest<'a>(summary: &Summary, machine: &'a MachineSummary) -> Option<(&'a str, &'a MachineRun)> {
    let culling = machine.policies.iter().filter(|&(name, _)| summary.baseline.as_deref() != Some(name));
    culling.min_by_key(|(_, run)| run.stats.cycles)
}

fn best<'a>(summary: &'a Summary, name: &'a str, machine: &'a MachineSummary) -> Option<Best<'a>> {
    let (policy, run) = fastest(summary, machine)?;
    let uncertain = match machine.claim(run) {
        Claim::Known => None,
        Claim::By(level) => Some(level),
        Claim::Nothing => return None,
    };
    let before = without(summary, machine)?.milliseconds_per_frame.filter(|&before| before > 0.0)?;
    let change = run.milliseconds_per_frame? / before - 1.0;
    Some(Best { machine: name, policy, change, uncertain, limit: limit(run) })
}

/// The finding of the run, in one sentence.
pub(super) fn finding(summary: &Summary) -> String {
    let bests: Vec<Best<'_>> = summary.machines.iter().filter_map(|(name, it)| best(summary, name, it)).collect();
    let Some(first) = bests.first() else { return without_machines(summary) };
    let one = bests.iter().all(|best| best.policy == first.policy);
    let culling = summary.policies.iter().filter(|&(name, _)| summary.baseline.as_deref() != Some(name)).count();
    let clauses: Vec<String> = bests.iter().map(|best| clause(best, one)).collect();
    let subject = match (one, culling) {
        (true, 1) => format!("With {} culling, a frame takes ", first.policy),
        (true, _) => format!("With {}, the fastest policy that culls, a frame takes ", first.policy),
        _ => "With each machine's fastest policy that culls, a frame takes ".into(),
    };
    let (last, others) = clauses.split_last().map_or((String::new(), &[][..]), |(last, others)| (last.clone(), others));
    let list = if others.is_empty() { last } else { format!("{} and {last}", others.join(", ")) };
    let price = if one { summary.policies.get(first.policy).map_or(String::new(), price) } else { String::new() };
    format!("{subject}{list}{price}.")
}

/// `42.2 % less time on small`.
fn clause(best: &Best<'_>, one: bool) -> String {
    let who = if one { String::new() } else { format!(" ({})", best.policy) };
    let by = best.uncertain.map_or_else(String::new, |level| format!(" by {level}, error unknown"));
    let who = who + &by;
    let amount = percent(best.change.abs());
    let text = match best.change {
        change if change.abs() < SAME => format!("as long as before on {}{who}", best.machine),
        change if change < 0.0 => return format!("{amount} less time on {}{who}", best.machine),
        _ => format!("{amount} more time on {}{who}", best.machine),
    };
    match &best.limit {
        Some(limit) => format!("{text} ({})", limit.short),
        None => text,
    }
}

fn price(policy: &PolicySummary) -> String {
    let share = |wrong: u64| percent(wrong as f64 / policy.counts.shadow_rays.max(1) as f64);
    match policy.counts.wrong() {
        None => String::new(),
        Some(0) => "; no shadow is wrong".into(),
        Some(wrong) => format!("; {} of all frames' shadow answers are wrong", share(wrong)),
    }
}

fn without_machines(summary: &Summary) -> String {
    let saved = |policy: &PolicySummary| policy.traversal_saved.mean;
    let culling = summary.policies.iter().filter(|&(name, _)| summary.baseline.as_deref() != Some(name));
    let most = culling.filter_map(|(name, policy)| Some((name, policy, saved(policy)?)));
    match most.max_by(|a, b| a.2.total_cmp(&b.2)) {
        Some((name, policy, saved)) => {
            format!("{name} saves {} of the node visits of shadow rays{}.", percent(saved), price(policy))
        }
        None => {
            let times = summary.machines.iter().filter_map(|(name, machine)| {
                let run = machine.policies.iter().next()?.1;
                Some(format!("{} ms on {name}", milliseconds(run.milliseconds_per_frame?)))
            });
            match times.collect::<Vec<_>>().as_slice() {
                [] => "The run has nothing to compare.".into(),
                times => format!("Without culling, a frame takes {}.", times.join(" and ")),
            }
        }
    }
}

/// A figure of a tile: its name, its value, the function that formats it, and whether less is better.
type Figure = (&'static str, fn(&MachineRun) -> Option<f64>, fn(f64) -> String, bool);

const FIGURES: [Figure; 4] = [
    ("ms a frame", |run| run.milliseconds_per_frame, milliseconds, true),
    ("frames/s", |run| run.frames_per_second, short, false),
    ("DRAM a frame", |run| run.dram_bytes_per_frame, |amount| bytes(Bytes(amount.round() as u64)), true),
    ("energy a frame", |run| run.joules_per_frame, joules, true),
];

/// The tiles.
pub(super) fn tiles(summary: &Summary) -> Vec<Value> {
    summary.machines.iter().map(|(name, machine)| tile(summary, name, machine)).collect()
}

fn tile(summary: &Summary, name: &str, machine: &MachineSummary) -> Value {
    let off = without(summary, machine);
    let with = fastest(summary, machine);
    let several = machine.policies.len() > 2;
    let shown = |value: Option<f64>, text: fn(f64) -> String| or_absent(value, text);
    let row = |(label, figure, text, less): &Figure| {
        let (before, after) = (off.and_then(figure), with.and_then(|(_, run)| figure(run)));
        let changed = before.zip(after).and_then(|(before, after)| change(before, after));
        let better =
            before.zip(after).map_or(0.0, |(before, after)| if *less { before - after } else { after - before });
        let is_same = before.is_some_and(|before| better.abs() < before.abs() * 0.005);
        let class = if is_same || better == 0.0 {
            ""
        } else if better > 0.0 {
            "good"
        } else {
            "bad"
        };
        context! {
            label => *label, class,
            without => shown(before, *text), with => shown(after, *text), change => or_absent(changed, |it| it),
        }
    };
    let wrong = |policy: Option<&str>| {
        let counts = &summary.policies.get(policy?)?.counts;
        let wrong = counts.wrong()?;
        let share = percent(wrong as f64 / counts.shadow_rays.max(1) as f64);
        Some((wrong, exact(wrong), share))
    };
    let [before, after] = [summary.baseline.as_deref(), with.map(|(policy, _)| policy)].map(wrong);
    let class = if after.as_ref().is_some_and(|it| it.0 > 0) { "bad" } else { "" };
    let share = after.as_ref().filter(|it| it.0 > 0).map(|it| it.2.clone()).unwrap_or_default();
    let text = |it: Option<(u64, String, String)>| or_absent(it, |(_, text, _)| text);
    let mut rows: Vec<Value> = FIGURES.iter().map(row).collect();
    rows.push(
        context! { label => "wrong shadow rays", class, without => text(before), with => text(after), change => share },
    );
    let limits: Vec<Value> = [off.map(|run| ("Without culling", run)), with]
        .into_iter()
        .flatten()
        .filter_map(|(policy, run)| Some(context! { policy, text => limit(run)?.text }))
        .collect();
    context! { name, policy => with.map(|(policy, _)| policy), several, rows, limits }
}
