//! Samples of a stream, of a given size or as large as a target error needs. The result of a machine does not depend on
//! the machines sampled with it.

use super::findings::Findings;
use super::grow::{Against, Goal, sample_until};
use super::pass::{Member, PerMachine, Sampler};
use super::plan::{Cut, MIN_POINTS, MIN_POINTS_TO_STOP, Plan};
use super::verdict::Verdict;
use crate::engine::whole::whole;
use crate::engine::{ItemStream, RunError, Sampled, Source};
use crate::machine::MachineSpec;
use crate::ranged::Share;
use crate::stats::{Accuracy, MachineStats};
use crate::stream::Header;

/// Maximum points for each window of a stream. Where a target error needs half of the windows or more, everything is
/// replayed. A stream is not sampled if [`MIN_POINTS`] windows are more than half of it: one unmeasured window may
/// differ from all others. With a target error, it is not sampled if [`MIN_POINTS_TO_STOP`] windows are more than half
/// of it.
const MOST: f64 = 0.5;

/// A sample's figures with the errors that it can claim. Windows of a level that is not exact tell how far the figures
/// are from that level on the whole stream, and not how far from the machine.
fn claimed(engine: Sampled, stats: MachineStats) -> MachineStats {
    match engine {
        Sampled::Event => stats,
        Sampled::Profile => stats.without_claims(),
    }
}

/// Samples `rate` of the windows in one pass; `seed` draws them.
///
/// # Errors
/// The sample is too small, the engine refuses the machine, or a run fails.
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
        let whole = whole(engine.into(), machine, header, items, None)?;
        return Ok(claimed(engine, MachineStats { accuracy: all, ..whole }));
    }
    let mut sampled = sample_together(engine, cut, (rate, seed), &[machine], header, items)?;
    sampled.pop().expect("one machine, one sample")
}

/// Samples `rate` of the windows on several machines; `rate` is below 1.
///
/// # Errors
/// The sample is too small, or the stream cannot be read. Per machine: its run fails.
pub(crate) fn sample_together(
    engine: Sampled,
    cut: Cut,
    (rate, seed): (Share, u64),
    machines: &[&MachineSpec],
    header: &Header,
    items: &mut ItemStream<'_>,
) -> PerMachine<MachineStats> {
    let refused = |windows: usize| {
        let least = MIN_POINTS as f64 / windows.max(1) as f64;
        let advice = if least <= MOST {
            format!("take a `rate` of {:.3} or more, Auto, or Event", (least * 1000.0).ceil() / 1000.0)
        } else {
            "take Auto or Event".to_owned()
        };
        RunError::Sample { windows, pixels: cut.window(), rate: rate.get(), advice }
    };
    let windows = cut.windows(header);
    if (windows * rate.get()).round() < MIN_POINTS as f64 || windows * MOST < MIN_POINTS as f64 {
        return Err(refused(windows as usize));
    }
    let plan = Plan::new(rate.get(), cut, seed);
    let members: Vec<Member<'_>> = machines.iter().map(|&machine| Member { machine, plan: plan.clone() }).collect();
    let sampler = Sampler::new(engine, header);
    let estimate = |(machine, pass): (&&MachineSpec, Result<_, RunError>)| {
        let findings = Findings::of(&sampler, machine, &cut, pass?);
        // The stream may have ended early.
        let windows = findings.population.windows;
        if findings.points(plan.draws.end) < MIN_POINTS / 2 && windows > 0 {
            return Err(refused(windows));
        }
        Ok(claimed(engine, findings.estimate(machine, plan.draws.end)))
    };
    Ok(machines.iter().zip(sampler.pass(&members, 0, items)?).map(estimate).collect())
}

/// Samples each machine, from `rate` of the windows on, until the intervals of cycles and of L2 and DRAM bytes are
/// within `target`. Where that would take half of the windows or more, the verdict is a whole replay.
///
/// # Errors
/// The stream cannot be read. Per machine: its run fails.
pub(crate) fn sample_until_within(
    target: Share,
    engine: Sampled,
    cut: Cut,
    (rate, seed): (Share, u64),
    (machines, baseline): (&[&MachineSpec], Option<Against<'_>>),
    header: &Header,
    source: &dyn Source,
) -> PerMachine<Verdict> {
    let whole = Verdict::Whole { level: engine.into(), choice: None };
    let windows = cut.windows(header);
    let first = rate.get().max(MIN_POINTS as f64 / windows);
    if first.max(MIN_POINTS_TO_STOP as f64 / windows) > MOST {
        return Ok(machines.iter().map(|_| Ok(whole.clone())).collect());
    }
    let goal = Goal { target, most: MOST };
    let sampled = sample_until((engine, header), machines, baseline, &Plan::new(first, cut, seed), goal, source)?;
    let verdict = |(stats, is_enough)| match is_enough {
        true => Verdict::Sampled(Box::new(claimed(engine, stats))),
        false => whole.clone(),
    };
    Ok(sampled.into_iter().map(|sampled| sampled.map(verdict)).collect())
}
