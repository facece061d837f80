//! Runs an experiment: traces each frame for all policies, replays their streams on all machines, and compares
//! pictures with the reference renderer. The results make a report.

mod failure;
mod gathered;
mod measured;
mod report;
mod stages;

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

pub(crate) use self::failure::RunFailure;
use self::gathered::Gathered;
pub(super) use self::gathered::frame_result;
use self::stages::Clock;
use super::frame_reuse::FrameReuses;
use super::frames::Replayed;
use super::load::Experiment;
use super::progress;
use super::replay::Replays;
use super::split::Role;
use super::validation::{self, Words};
use crate::culling::Policy;
use crate::machine::MachineSpec;
use crate::named::Named;
use crate::reference::Reference;
use crate::replay::are_units_idle;
use crate::report::run::RunFiles;
use crate::stream::{Header, Item, Step, Totals};
use crate::tracer::{LaneFrame, Tracer};

/// Runs the experiment, without machines if `machines` is false. When `stop` becomes true, the run ends with the
/// current frame, and the report has the frames done.
pub(crate) fn run(experiment: &Experiment, machines: bool, stop: &AtomicBool) -> Result<RunFiles, RunFailure> {
    let begin = Instant::now();
    let scene = &experiment.scene;
    let first = scene.animation.frame(experiment.frames[0]);
    let tracer = Tracer::new(scene, &first, experiment.spec.resolution, experiment.spec.tracer);
    let reference = Reference::new(scene);
    let mut policies = experiment.policies();
    let headers = headers(experiment, &tracer, &policies);
    let mut gathered = Gathered::new(experiment);
    let mut clock = Clock::default();
    let bar = progress::bar("tracing", experiment.frames.len(), "frames");

    let none = Named::<MachineSpec>::default();
    let machines = if machines { &experiment.machines } else { &none };
    let (finished, reuse) = std::thread::scope(|scope| {
        let mut replays = Replays::default();
        let reuses = FrameReuses::start(scope, experiment, machines, &headers);
        // The policies are compared with each other.
        let fidelity = experiment.spec.fidelity.compared();
        for (_, machine) in machines.iter() {
            for (policy, header) in headers.iter().enumerate() {
                for role in roles(experiment, machine, policy) {
                    replays.start(scope, (machine, role), fidelity, policy, header.clone());
                }
            }
        }
        for (index, &number) in experiment.frames.iter().enumerate() {
            if stop.load(Ordering::Relaxed) {
                break;
            }
            let frame = scene.animation.frame(number);
            let validated = experiment.spec.validate.takes(index);
            let words = validated.then(|| latch(&policies, scene.primitive_count()));
            let replayed = experiment.replayed.contains(number);
            let mut recorded = vec![Totals::default(); policies.len()];
            let (traced, waited) = (Instant::now(), clock.machines);
            let lanes = tracer.frame(&frame, &mut policies, |policy, item| {
                count(&mut recorded[policy], &item);
                if !replayed {
                    return Ok(());
                }
                let sent = Instant::now();
                reuses.send(policy, number, &item);
                let result = replays.send(policy, &item);
                clock.machines += sent.elapsed();
                result
            });
            clock.trace += traced.elapsed() - (clock.machines - waited);
            // `finish` returns the error of a machine that has stopped.
            let Ok(lanes) = lanes else { break };
            check(experiment, number, &recorded, &lanes)?;
            let compared = Instant::now();
            let validated = words
                .map(|words| (validation::validate(experiment, &reference, &frame, tracer.offset(), &lanes), words));
            gathered.add(experiment, number, &lanes, validated);
            if replayed && !experiment.replayed.measures(number) {
                gathered.warmup.push(number);
            } else if replayed {
                gathered.measured.push(number);
                gathered.totals.iter_mut().zip(&recorded).for_each(|(all, &frame)| *all += frame);
            }
            clock.reference += compared.elapsed();
            bar.inc(1);
        }
        bar.set_message("machines");
        let waiting = Instant::now();
        let finished = (replays.finish(), reuses.finish());
        clock.machines += waiting.elapsed();
        Ok::<_, RunFailure>(finished)
    })?;
    drop(bar);
    if gathered.frames.is_empty() && finished.iter().all(|run| run.result.is_ok()) {
        return Err(RunFailure::Stopped);
    }
    report::report(experiment, &headers, gathered, (finished, reuse), clock, begin)
}

/// The roles in which `machine` replays the stream of policy `policy`. Where the units are idle without culling, the
/// split's baseline needs no replay of its own.
fn roles(experiment: &Experiment, machine: &MachineSpec, policy: usize) -> impl Iterator<Item = Role> {
    let split = experiment.spec.split && experiment.spec.fidelity.knows_all_placements();
    let other = match policy == experiment.off() {
        true => (!are_units_idle(machine)).then_some(Role::WithoutUnit),
        false => Some(Role::FreeWords),
    };
    std::iter::once(Role::AsItIs).chain(other.filter(|_| split))
}

fn headers(experiment: &Experiment, tracer: &Tracer<'_>, policies: &[Box<dyn Policy>]) -> Vec<Header> {
    let Replayed { frames, warmup } = &experiment.replayed;
    let inputs = experiment.inputs();
    experiment
        .policy_names()
        .zip(policies)
        .map(|(name, policy)| Header {
            warmup: warmup.clone(),
            ..tracer.header(name, policy.as_ref(), frames.clone(), &inputs)
        })
        .collect()
}

fn latch(policies: &[Box<dyn Policy>], primitives: usize) -> Vec<Words> {
    policies.iter().map(|policy| Words::latch(policy.as_ref(), primitives)).collect()
}

/// Adds the records of a stream's item to the counts.
fn count(recorded: &mut Totals, item: &Item) {
    match item {
        Item::Frame(_) => {}
        Item::Rays(chunk) => chunk.rays().for_each(|ray| recorded.count(&ray)),
        Item::End { policy, .. } => recorded.count_policy(Step::unpack_all(policy)),
    }
}

/// Compares the counts of the records with the tracer's own.
fn check(experiment: &Experiment, frame: u32, recorded: &[Totals], lanes: &[LaneFrame]) -> Result<(), RunFailure> {
    for ((policy, recorded), lane) in experiment.policy_names().zip(recorded).zip(lanes) {
        if *recorded != lane.totals {
            return Err(RunFailure::Counts {
                frame,
                policy: policy.to_owned(),
                recorded: Box::new(*recorded),
                counted: Box::new(lane.totals),
            });
        }
    }
    Ok(())
}
