//! No more than a stream needs, in two phases: the tags of the caches over everything, which tell what every window
//! asks for, and `Event` on as many windows as the target takes. Where that would not pay, `Event` on everything.

use super::plan::{Cut, Plan, TELLING};
use super::sample::{Goal, sample_until};
use crate::engine::whole::whole;
use crate::engine::{Level, RunError, Sampled, Source};
use crate::machine::MachineSpec;
use crate::ranged::Share;
use crate::stats::{Choice, MachineStats, Why};
use crate::stream::Header;

/// Processor time of the tags' pass, over that of `Event` (kitchen, `Published`: 17 % on `small`, 16 % on `desktop`,
/// 12 % on `tni_engine`).
const TAGS: f64 = 0.17;
/// Points with which sampling begins: twice as many tell intervals of half the width or less, since regressions have
/// more columns.
const FIRST: usize = 12;
/// Points that intervals of 2 % take, as a rule (kitchen: 24 to 48), and some more. A sample is tried where so many
/// would pay, and [`TELLING`] ones at least: a try that is given up costs more than it can win.
const EXPECTED: f64 = 60.0;
const EXPECTED_AT: f64 = 0.02;
/// The processor time that a sample is expected to take at most, over that of `Event`. The rest is for streams whose
/// windows differ more than others'.
const WORTH: f64 = 0.7;

/// Replays a stream with an error of cycles and of L2 and DRAM bytes that is to be within `target`.
///
/// # Errors
/// The stream cannot be read, or a run fails.
pub(crate) fn auto(
    machine: &MachineSpec,
    cut: Cut,
    target: Share,
    header: &Header,
    source: &dyn Source,
) -> Result<MachineStats, RunError> {
    let all = cut.windows(header);
    let cost = |points: f64| TAGS + cut.effort() * points / all;
    let choice = |windows: u64, cost, why| Choice { target: target.get(), windows, of: all as u64, cost, why };
    let event = |choice| {
        let stats = whole(Level::Event, machine, header, &mut source.open(0)?, None)?;
        Ok(MachineStats { choice: Some(choice), ..stats })
    };
    let expected = (EXPECTED * (EXPECTED_AT / target.get()).powi(2)).max(TELLING as f64);
    if cost(expected) > WORTH {
        return event(choice(0, 1.0, Why::Short));
    }
    let plan = Plan::new(FIRST as f64 / all, cut, 0);
    // What was spent is spent: more windows are measured as long as they take less than `Event` on everything.
    let goal = Goal { target, most: 1.0 / cut.effort() };
    let (sampled, is_enough, passes) = sample_until(Sampled::Event, machine, header, plan, goal, source)?;
    let windows = sampled.residuals.as_ref().map_or(0, |residuals| residuals.windows());
    let spent = cost(windows as f64) + TAGS * f64::from(passes - 1);
    if is_enough {
        return Ok(MachineStats { choice: Some(choice(windows, spent, Why::Sampled)), ..sampled });
    }
    event(choice(windows, 1.0 + spent, Why::Varied))
}
