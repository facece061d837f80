//! No more than a stream needs, in two phases: the tags of the caches over everything, which tell what every window
//! asks for, and `Event` on as many windows as the target takes. Where that would not pay, `Event` on everything.

use super::grow::{Against, Goal, sample_until};
use super::pass::Each;
use super::plan::{Cut, LEAST, Plan, TELLING};
use super::verdict::Verdict;
use crate::engine::{Level, Sampled, Source};
use crate::machine::MachineSpec;
use crate::ranged::Share;
use crate::stats::{Choice, MachineStats, Why};
use crate::stream::Header;

/// Processor time of the tags' pass, over that of `Event` (`small`, `Published`: 12 % on Sponza, 14 % on robot, 17 and
/// 18 % on kitchen, living room and gas station, 21 % on staircase).
const TAGS: f64 = 0.18;
/// Points with which sampling begins, as a share of those that are expected. [`TELLING`] ones are measured whatever
/// they tell, and on the first pass, so that no jobs need be kept for that: those of a large L2 hold half a megabyte
/// each. What comes later was kept, up to 32 times as many.
const FIRST_SHARE: f64 = 0.2;
/// Points that intervals of 2 % take, as a rule (kitchen: 24 to 48), and some more. A sample is tried where so many
/// would pay, and [`TELLING`] ones at least: a try that is given up costs more than it can win.
const EXPECTED: f64 = 60.0;
const EXPECTED_AT: f64 = 0.02;
/// The processor time that a sample is expected to take at most, over that of `Event`. The rest is for streams whose
/// windows differ more than others'.
const WORTH: f64 = 0.7;

/// Replays a stream on several machines with errors of cycles and of L2 and DRAM bytes that are to be within `target`.
///
/// # Errors
/// The stream cannot be read; of a machine, a run fails.
pub(crate) fn auto(
    machines: &[&MachineSpec],
    baseline: Option<Against<'_>>,
    cut: Cut,
    target: Share,
    header: &Header,
    source: &dyn Source,
) -> Each<Verdict> {
    let all = cut.windows(header);
    let choice = |windows: u64, cost, why| Choice { target: target.get(), windows, of: all as u64, cost, why };
    let event = |choice| Verdict::Whole { level: Level::Event, choice: Some(choice) };
    if !pays(cut, target, header, baseline.is_some()) {
        return Ok(machines.iter().map(|_| Ok(event(choice(0, 1.0, Why::Short)))).collect());
    }
    let plan = Plan::new((FIRST_SHARE * expected(target, baseline.is_some())).max(TELLING as f64) / all, cut, 0);
    // What was spent is spent: more windows are measured as long as they take less than `Event` on everything.
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

/// Whether a sample of a stream is tried, beside a baseline or without.
pub(crate) fn pays(cut: Cut, target: Share, header: &Header, has_baseline: bool) -> bool {
    let windows = cut.windows(header);
    windows >= 2.0 * LEAST as f64 && cost(cut, expected(target, has_baseline), windows) <= WORTH
}

/// Points that intervals of a target take.
fn expected(target: Share, has_baseline: bool) -> f64 {
    match has_baseline {
        // Little is left over.
        true => TELLING as f64,
        false => (EXPECTED * (EXPECTED_AT / target.get()).powi(2)).max(TELLING as f64),
    }
}

/// The processor time of the tags and of so many of all windows, over that of `Event`.
fn cost(cut: Cut, windows: f64, all: f64) -> f64 {
    TAGS + cut.effort() * windows / all
}
