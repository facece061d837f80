//! Samples of a stream: of one size, or as large as a target error takes.

use super::findings::Findings;
use super::pass::Sampler;
use super::plan::Plan;
use crate::engine::whole::whole;
use crate::engine::{ItemStream, RunError, Sampled, Source};
use crate::machine::MachineSpec;
use crate::ranged::Share;
use crate::stats::{Accuracy, MachineStats};
use crate::stream::Header;

/// The most windows that a target error may take, as points for a window: where sampling would take half of them or
/// more, everything is replayed.
const MOST: f64 = 0.5;

/// Samples `rate` of the windows of a stream that is read once; `seed` says which.
///
/// # Errors
/// No window is in the sample, the engine refuses the machine, or a run fails.
pub(crate) fn sample(
    engine: Sampled,
    (rate, seed): (Share, u64),
    machine: &MachineSpec,
    header: &Header,
    items: &mut ItemStream<'_>,
) -> Result<MachineStats, RunError> {
    if rate.get() == 1.0 {
        let all = Accuracy::Estimated { cycles: 0.0, l2_bytes: 0.0, dram_bytes: 0.0, rate: 1.0 };
        return Ok(MachineStats { accuracy: all, ..whole(engine.into(), machine, header, items, None)? });
    }
    let plan = Plan::new(rate.get(), machine, seed);
    let sampler = Sampler::new(engine, machine, header);
    let findings = Findings::of(&sampler, sampler.pass(&plan, 0, items)?)?;
    let windows = findings.population.windows;
    if findings.measured.is_empty() && windows > 0 {
        return Err(RunError::Sample { windows, pixels: plan.cut.window(), rate: rate.get() });
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
    (rate, seed): (Share, u64),
    machine: &MachineSpec,
    header: &Header,
    source: &dyn Source,
) -> Result<MachineStats, RunError> {
    let plan = Plan::new(rate.get(), machine, seed);
    let (stats, is_enough) = sample_until(engine, machine, header, plan, (target, MOST), source)?;
    if is_enough { Ok(stats) } else { whole(engine.into(), machine, header, &mut source.open(0)?, None) }
}

/// Samples with more and more windows, as long as the target may be reached with at most `most` points a window; also
/// whether it was.
pub(crate) fn sample_until(
    engine: Sampled,
    machine: &MachineSpec,
    header: &Header,
    mut plan: Plan,
    (target, most): (Share, f64),
    source: &dyn Source,
) -> Result<(MachineStats, bool), RunError> {
    let sampler = Sampler::new(engine, machine, header);
    let keep = (most * plan.strata.length) as usize;
    let mut pass = sampler.pass(&plan, keep, &mut source.open(0)?)?;
    let mut kept = std::mem::take(&mut pass.kept);
    let mut findings = Findings::of(&sampler, pass)?;
    loop {
        let stats = findings.estimate(machine, plan.draws.end);
        let is_enough = stats.accuracy.is_within(target.get());
        let next = plan.next_draws(stats.accuracy.widest(), target.get(), keep);
        let Some(draws) = next.filter(|_| !is_enough) else { return Ok((stats, is_enough)) };
        plan.draws = plan.draws.end..draws;
        let more = match kept.take(&plan.draws) {
            Some(jobs) => sampler.replay(jobs)?,
            None => {
                let pass = sampler.pass(&plan, keep, &mut source.open(0)?)?;
                kept = pass.kept;
                pass.found
            }
        };
        findings.add(more);
    }
}
