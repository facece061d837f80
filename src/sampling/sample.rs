//! Samples of a stream: of one size, or as large as a target error takes.

use super::findings::Findings;
use super::pass::Sampler;
use super::plan::{Cut, LEAST, Plan};
use crate::engine::whole::whole;
use crate::engine::{ItemStream, RunError, Sampled, Source};
use crate::machine::MachineSpec;
use crate::ranged::Share;
use crate::stats::{Accuracy, MachineStats};
use crate::stream::Header;

/// The most windows that a target error may take, as points for a window: where sampling would take half of them or
/// more, everything is replayed. A stream of which [`LEAST`] windows are more than half is not sampled at all: what is
/// not seen of it may be one window that differs from all others.
const MOST: f64 = 0.5;

/// When sampling is over.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal {
    /// All intervals are to be within it.
    pub target: Share,
    /// Points for a window of the stream, at most.
    pub most: f64,
}

/// Samples `rate` of the windows of a stream that is read once; `seed` says which.
///
/// # Errors
/// So few windows tell nothing, the engine refuses the machine, or a run fails.
pub(crate) fn sample(
    engine: Sampled,
    cut: Cut,
    (rate, seed): (Share, u64),
    machine: &MachineSpec,
    header: &Header,
    items: &mut ItemStream<'_>,
) -> Result<MachineStats, RunError> {
    if rate.get() == 1.0 {
        let all = Accuracy::Estimated { cycles: 0.0, l2_bytes: 0.0, dram_bytes: 0.0, rate: 1.0 };
        return Ok(MachineStats { accuracy: all, ..whole(engine.into(), machine, header, items, None)? });
    }
    let refused = |windows: usize| {
        let least = LEAST as f64 / windows.max(1) as f64;
        let advice = if least <= MOST {
            format!("take a `rate` of {:.3} or more, Auto, or Event", (least * 1000.0).ceil() / 1000.0)
        } else {
            "take Auto or Event".to_owned()
        };
        RunError::Sample { windows, pixels: cut.window(), rate: rate.get(), advice }
    };
    let windows = cut.windows(header);
    if (windows * rate.get()).round() < LEAST as f64 || windows * MOST < LEAST as f64 {
        return Err(refused(windows as usize));
    }
    let plan = Plan::new(rate.get(), cut, seed);
    let sampler = Sampler::new(engine, machine, header);
    let findings = Findings::of(&sampler, &cut, sampler.pass(&plan, 0, items)?)?;
    // The stream may have ended early.
    let windows = findings.population.windows;
    if findings.points(plan.draws.end) < LEAST / 2 && windows > 0 {
        return Err(refused(windows));
    }
    Ok(findings.estimate(machine, plan.draws.end))
}

/// Samples more and more windows, beginning with `rate` of them, until the intervals of cycles and of the bytes of L2
/// and DRAM are within `target`; where that would take half of the windows or more, everything is replayed.
///
/// # Errors
/// The engine refuses the machine, or a run fails.
pub(crate) fn sample_until_within(
    target: Share,
    engine: Sampled,
    cut: Cut,
    (rate, seed): (Share, u64),
    machine: &MachineSpec,
    header: &Header,
    source: &dyn Source,
) -> Result<MachineStats, RunError> {
    let first = rate.get().max(LEAST as f64 / cut.windows(header));
    if first <= MOST {
        let goal = Goal { target, most: MOST };
        let plan = Plan::new(first, cut, seed);
        let (stats, is_enough, _) = sample_until(engine, machine, header, plan, goal, source)?;
        if is_enough {
            return Ok(stats);
        }
    }
    whole(engine.into(), machine, header, &mut source.open(0)?, None)
}

/// Samples with more and more windows, as long as the goal may be reached; also whether it was, and how many passes
/// over the stream that took.
pub(crate) fn sample_until(
    engine: Sampled,
    machine: &MachineSpec,
    header: &Header,
    mut plan: Plan,
    Goal { target, most }: Goal,
    source: &dyn Source,
) -> Result<(MachineStats, bool, u32), RunError> {
    let sampler = Sampler::new(engine, machine, header);
    let keep = (most * plan.strata.length) as usize;
    let mut pass = sampler.pass(&plan, keep, &mut source.open(0)?)?;
    let mut kept = std::mem::take(&mut pass.kept);
    let mut findings = Findings::of(&sampler, &plan.cut, pass)?;
    let mut passes = 1;
    loop {
        let (stats, points) = (findings.estimate(machine, plan.draws.end), findings.points(plan.draws.end));
        let widest = stats.accuracy.widest().unwrap_or(f64::INFINITY);
        let is_enough = points >= LEAST && widest <= target.get();
        let next = plan.next_draws(points, widest, target.get(), keep);
        let Some(draws) = next.filter(|_| !is_enough) else { return Ok((stats, is_enough, passes)) };
        plan.draws = plan.draws.end..draws;
        let more = match kept.take(&plan.draws) {
            Some(jobs) => sampler.replay(jobs)?,
            None => {
                passes += 1;
                let pass = sampler.pass(&plan, keep, &mut source.open(0)?)?;
                kept = pass.kept;
                pass.found
            }
        };
        findings.add(more);
    }
}
