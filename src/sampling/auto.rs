//! `Auto`: tags over the whole stream give covariates of every window; `Event` replays as many windows as the target
//! error needs. Where a sample would not pay, `Event` replays everything.

use super::grow::{Against, Goal, sample_until};
use super::pass::PerMachine;
use super::plan::{Cut, MIN_POINTS, MIN_POINTS_TO_STOP, Plan};
use super::verdict::Verdict;
use crate::engine::{Level, Sampled, Source};
use crate::machine::MachineSpec;
use crate::ranged::Share;
use crate::stats::{Choice, MachineStats, Why};
use crate::stream::Header;

/// Processor time of the tags' pass over that of `Event` (`small`, `Published`: 12 % on Sponza, 14 % on robot, 17 and
/// 18 % on kitchen, living room and gas station, 21 % on staircase).
const TAGS: f64 = 0.18;
/// Points of the first sample, as a share of the expected number. At least [`MIN_POINTS_TO_STOP`] points are always
/// needed, so they are measured on the first pass: no job is kept for them (jobs of a large L2 hold half a megabyte
/// each). The jobs of later points are kept, up to 32 times as many.
const FIRST_SHARE: f64 = 0.2;
/// Points that 2 % intervals usually need (kitchen: 24 to 48), with a reserve. A sample is tried only where this
/// number, and at least [`MIN_POINTS_TO_STOP`], would pay: an abandoned sample costs more than a good one saves.
const EXPECTED: f64 = 60.0;
const EXPECTED_AT: f64 = 0.02;
/// Maximum expected processor time of a sample over that of `Event`. The reserve is for streams whose windows differ
/// more than usual.
const WORTH: f64 = 0.7;

/// Samples a stream on several machines until the errors of cycles and of L2 and DRAM bytes are within `target`; where
/// that does not pay, the verdict is `Event` on everything. With a baseline, `target` applies to the error not shared
/// with it.
///
/// # Errors
/// The stream cannot be read. Per machine: its run fails.
pub(crate) fn auto(
    machines: &[&MachineSpec],
    baseline: Option<Against<'_>>,
    cut: Cut,
    target: Share,
    header: &Header,
    source: &dyn Source,
) -> PerMachine<Verdict> {
    let all = cut.windows(header);
    let choice = |windows: u64, cost, why| Choice { target: target.get(), windows, of: all as u64, cost, why };
    let event = |choice| Verdict::Whole { level: Level::Event, choice: Some(choice) };
    if !pays(cut, target, header, baseline.is_some()) {
        return Ok(machines.iter().map(|_| Ok(event(choice(0, 1.0, Why::Short)))).collect());
    }
    let plan =
        Plan::new((FIRST_SHARE * expected(target, baseline.is_some())).max(MIN_POINTS_TO_STOP as f64) / all, cut, 0);
    // The time of tags and first windows is spent anyway: windows are added while these additional ones take less time
    // than `Event` on everything.
    let goal = Goal { target, most: 1.0 / cut.effort() };
    let verdict = |(stats, is_enough): (MachineStats, bool)| {
        let windows = stats.residuals.as_ref().map_or(0, |residuals| residuals.windows());
        let spent = cost(cut, windows as f64, all);
        match is_enough {
            true => {
                let choice = Some(choice(windows, spent, Why::Sampled));
                Verdict::Sampled(Box::new(MachineStats { choice, ..stats }))
            }
            false => event(choice(windows, 1.0 + spent, Why::Varied)),
        }
    };
    let sampled = sample_until((Sampled::Event, header), machines, baseline, &plan, goal, source)?;
    Ok(sampled.into_iter().map(|sampled| sampled.map(verdict)).collect())
}

/// Whether sampling a stream is expected to pay, with or without a baseline.
pub(crate) fn pays(cut: Cut, target: Share, header: &Header, has_baseline: bool) -> bool {
    let windows = cut.windows(header);
    windows >= 2.0 * MIN_POINTS as f64 && cost(cut, expected(target, has_baseline), windows) <= WORTH
}

/// Points that intervals of a target usually need.
fn expected(target: Share, has_baseline: bool) -> f64 {
    match has_baseline {
        // Little error is left beside a baseline.
        true => MIN_POINTS_TO_STOP as f64,
        false => (EXPECTED * (EXPECTED_AT / target.get()).powi(2)).max(MIN_POINTS_TO_STOP as f64),
    }
}

/// Processor time of the tags and of `windows` of `all` windows, over that of `Event`.
fn cost(cut: Cut, windows: f64, all: f64) -> f64 {
    TAGS + cut.effort() * windows / all
}
