//! Samples that grow until their intervals are narrow enough, of several machines on the same passes.

use super::baseline::known;
use super::findings::{Findings, KnownBaseline};
use super::job::Found;
use super::job_cache::{CachedJob, JobCache};
use super::pass::{Member, Pass, PerMachine, Sampler};
use super::plan::{MIN_POINTS_TO_STOP, Plan};
use crate::engine::{RunError, Sampled, Source};
use crate::machine::MachineSpec;
use crate::ranged::Share;
use crate::stats::MachineStats;
use crate::stream::Header;

/// When a sample is large enough.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal {
    /// Maximum relative half width of the intervals.
    pub target: Share,
    /// Maximum points for each window of the stream.
    pub most: f64,
}

/// A baseline: a machine that others are measured against, and its known statistics.
pub(crate) type Against<'a> = (&'a MachineSpec, &'a MachineStats);

/// Adds windows to each sample until the goal is reached or out of reach; returns the statistics, and whether it was
/// reached. With a baseline, the goal applies to the error not shared with it. Machines whose jobs were not kept pass
/// over the stream again, together.
///
/// # Errors
/// The stream cannot be read, or the baseline's run fails. Per machine: its run fails.
pub(crate) fn sample_until(
    (engine, header): (Sampled, &Header),
    machines: &[&MachineSpec],
    baseline: Option<Against<'_>>,
    plan: &Plan,
    goal: Goal,
    source: &dyn Source,
) -> PerMachine<(MachineStats, bool)> {
    let sampler = Sampler::new(engine, header);
    let keep = (goal.most * plan.strata.length) as usize;
    let figures = baseline.map(|(machine, stats)| known(machine, stats)).unwrap_or_default();
    let all = machines.iter().copied().chain(baseline.map(|(machine, _)| machine));
    let mut samples: Vec<Sample<'_>> = all.map(|machine| Sample::new(Member { machine, plan: plan.clone() })).collect();
    loop {
        let mut due: Vec<&mut Sample<'_>> = samples.iter_mut().filter(|sample| sample.is_due()).collect();
        if due.is_empty() {
            break;
        }
        let members: Vec<Member<'_>> = due.iter().map(|sample| sample.member.clone()).collect();
        let passes = sampler.pass(&members, keep, &mut source.open(0)?)?;
        due.iter_mut().zip(passes).for_each(|(sample, pass)| sample.passed(&sampler, pass));
        loop {
            let (own, base) = samples.split_at_mut(machines.len());
            let mut base = base.first_mut();
            let mut beside = None;
            if let (Some(base), Some((machine, stats))) = (base.as_deref_mut(), baseline) {
                // A sample beside a baseline waits until the baseline is measured in its windows.
                let Some(findings) = base.measured()? else { break };
                beside = Some(KnownBaseline { machine, findings, stats, figures: &figures });
            }
            let go_on = |sample: &mut Sample<'_>| sample.go_on(beside.as_ref(), goal.target, keep);
            let mut more: Vec<Option<Vec<CachedJob>>> = own.iter_mut().map(go_on).collect();
            let farthest = own.iter().map(|sample| sample.member.plan.draws.end).max().unwrap_or_default();
            more.extend(base.map(|base| base.reach(farthest)));
            if more.iter().all(Option::is_none) {
                break;
            }
            let jobs = more.into_iter().enumerate();
            let jobs = jobs.flat_map(|(at, jobs)| jobs.into_iter().flatten().map(move |job| (at, job)));
            let members: Vec<Member<'_>> = samples.iter().map(|sample| sample.member.clone()).collect();
            let found = sampler.replay(&members, jobs.collect());
            samples.iter_mut().zip(found).for_each(|(sample, found)| sample.found(found));
        }
    }
    samples.truncate(machines.len());
    Ok(samples.into_iter().map(Sample::outcome).collect())
}

/// The sample of a machine.
struct Sample<'a> {
    member: Member<'a>,
    findings: Option<Findings>,
    cached: JobCache,
    stage: Stage,
}

/// The state of a sample.
enum Stage {
    /// Waits for a pass over the stream.
    Due,
    /// Has measurements that were not evaluated yet.
    Measured,
    /// Is complete.
    Over(Result<Box<(MachineStats, bool)>, RunError>),
}

impl<'a> Sample<'a> {
    fn new(member: Member<'a>) -> Self {
        Self { member, findings: None, cached: JobCache::default(), stage: Stage::Due }
    }

    fn is_due(&self) -> bool {
        matches!(self.stage, Stage::Due)
    }

    /// Takes the result of a pass.
    fn passed(&mut self, sampler: &Sampler<'_>, pass: Result<Pass, RunError>) {
        self.stage = Stage::Measured;
        match pass {
            Ok(mut pass) => {
                self.cached = std::mem::take(&mut pass.cached);
                match &mut self.findings {
                    Some(findings) => findings.add(pass.found),
                    None => {
                        let Member { machine, plan } = &self.member;
                        self.findings = Some(Findings::of(sampler, machine, &plan.cut, pass));
                    }
                }
            }
            Err(error) => self.stage = Stage::Over(Err(error)),
        }
    }

    /// Takes the results of kept jobs.
    fn found(&mut self, found: Result<Vec<Found>, RunError>) {
        match (found, &mut self.findings) {
            (Ok(found), Some(findings)) => findings.add(found),
            (Ok(_), None) => {}
            (Err(error), _) => self.stage = Stage::Over(Err(error)),
        }
    }

    /// Evaluates the measurements. Returns the next jobs, if more points are needed and their jobs were kept.
    fn go_on(&mut self, baseline: Option<&KnownBaseline<'_>>, target: Share, keep: usize) -> Option<Vec<CachedJob>> {
        let (Stage::Measured, Some(findings)) = (&self.stage, &self.findings) else { return None };
        let Member { machine, plan } = &self.member;
        let (draws, points) = (plan.draws.end, findings.points(plan.draws.end));
        let stats = match baseline {
            Some(baseline) => findings.estimate_beside(machine, draws, baseline),
            None => findings.estimate(machine, draws),
        };
        let change = stats.residuals.as_ref().and_then(|residuals| residuals.change.as_ref());
        let widest = match change {
            Some(change) => Some(change.half_widths.into_iter().fold(0.0, f64::max)),
            None => stats.accuracy.widest(),
        };
        let widest = widest.unwrap_or(f64::INFINITY);
        let is_enough = points >= MIN_POINTS_TO_STOP && widest <= target.get();
        match plan.next_draws(points, widest, target.get(), keep).filter(|_| !is_enough) {
            Some(end) => self.reach(end),
            None => {
                self.stage = Stage::Over(Ok(Box::new((stats, is_enough))));
                None
            }
        }
    }

    /// Extends the draws to `end`; returns their jobs if they were kept.
    fn reach(&mut self, end: usize) -> Option<Vec<CachedJob>> {
        let draws = &mut self.member.plan.draws;
        if end <= draws.end {
            return None;
        }
        *draws = draws.end..end;
        let jobs = self.cached.take(draws);
        self.stage = if jobs.is_none() { Stage::Due } else { Stage::Measured };
        jobs
    }

    /// The measurements; `None` if a pass must come first.
    ///
    /// # Errors
    /// A run failed.
    fn measured(&mut self) -> Result<Option<&Findings>, RunError> {
        match std::mem::replace(&mut self.stage, Stage::Measured) {
            Stage::Due => {
                self.stage = Stage::Due;
                Ok(None)
            }
            Stage::Over(Err(error)) => Err(error),
            Stage::Over(Ok(_)) | Stage::Measured => Ok(self.findings.as_ref()),
        }
    }

    fn outcome(self) -> Result<(MachineStats, bool), RunError> {
        match self.stage {
            Stage::Over(outcome) => outcome.map(|told| *told),
            Stage::Due | Stage::Measured => unreachable!("samples grow until they are over"),
        }
    }
}
