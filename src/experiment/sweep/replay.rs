//! Replays a recorded stream on a machine, with a way to stop.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use super::error::SweepError;
use super::kept::kept;
use super::streams::Recorded;
use crate::json;
use crate::machine::MachineSpec;
use crate::replay::{Cut, Estimate, Fidelity, Items, Replay, RunError, Source, StreamFile, Together, Verdict};
use crate::stats::MachineStats;
use crate::stream::StreamError;

/// A recorded stream that ends early when it is stopped; the result of that replay is discarded.
struct Stoppable<'a> {
    file: StreamFile<'a>,
    stop: &'a AtomicBool,
}

impl Source for Stoppable<'_> {
    fn open(&self, frame: usize) -> Result<Items<'_>, StreamError> {
        Ok(Box::new(self.file.open(frame)?.take_while(|_| !self.stop.load(Ordering::Relaxed))))
    }
}

/// Replays a recorded stream on a machine. Samples are cut as `cut` says; by default as the machine requires.
///
/// # Errors
/// The replay is stopped or fails.
pub(crate) fn replay(
    machine: &MachineSpec,
    (fidelity, cut): (Fidelity, Option<Cut>),
    stream: &Recorded,
    stop: &AtomicBool,
) -> Result<MachineStats, SweepError> {
    let replay = replay_of(machine, stream).map(|replay| cut.map_or(replay, |cut| replay.cut(cut)));
    let replayed = replay.and_then(|replay| replay.fidelity(fidelity).run(&source(stream, stop)));
    told(replayed, machine, stream, stop)
}

/// Estimates of `machines` on a recorded stream, from a pass on `reference`, unless `folder` keeps them.
///
/// # Errors
/// The pass is stopped or fails.
pub(in super::super) fn estimates(
    reference: &MachineSpec,
    machines: &[MachineSpec],
    stream: &Recorded,
    (folder, stop): (&Path, &AtomicBool),
) -> Result<Vec<Estimate>, SweepError> {
    let specs = json::line(&(reference, machines)).expect("plain data, which JSON can hold");
    // The name of a stream's file is a hash of its inputs.
    let inputs = format!("{} {specs}", stream.path.file_name().unwrap_or_default().display());
    let is_whole = |found: &Vec<Estimate>| found.len() == machines.len();
    kept(folder, "estimates", &inputs, is_whole, || {
        let replay = replay_of(reference, stream);
        let found = replay.and_then(|replay| replay.estimates(&source(stream, stop), machines));
        told(found, reference, stream, stop)
    })
}

/// Samples a recorded stream for several machines on the same passes, if the fidelity level samples.
pub(super) struct Shared<'a> {
    together: Together<'a>,
    stream: &'a Recorded,
    stop: &'a AtomicBool,
}

impl<'a> Shared<'a> {
    /// `None` if the level does not sample.
    pub(super) fn of(
        (fidelity, cut): (Fidelity, Option<Cut>),
        baseline: Option<(&'a MachineSpec, &'a MachineStats)>,
        stream: &'a Recorded,
        stop: &'a AtomicBool,
    ) -> Option<Self> {
        let together = Together { header: &stream.header, fidelity, cut: cut?, baseline };
        together.samples().then_some(Self { together, stream, stop })
    }

    /// The sample of each machine, or the verdict that its whole stream is to be replayed.
    ///
    /// # Errors
    /// Sampling is stopped or fails.
    pub(super) fn sample(&self, machines: &[MachineSpec]) -> Result<Vec<Verdict>, SweepError> {
        for machine in machines {
            told(replay_of(machine, self.stream), machine, self.stream, self.stop)?;
        }
        let Some(first) = machines.first() else { return Ok(Vec::new()) };
        let specs: Vec<&MachineSpec> = machines.iter().collect();
        let sampled = self.together.sample(&specs, &source(self.stream, self.stop));
        let sampled = told(sampled, first, self.stream, self.stop)?.into_iter().zip(machines);
        sampled.map(|(verdict, machine)| told(verdict, machine, self.stream, self.stop)).collect()
    }

    /// The statistics of a machine: from its sample, or from a replay of the whole stream.
    ///
    /// # Errors
    /// The replay is stopped or fails.
    pub(super) fn stats(&self, verdict: Verdict, machine: &MachineSpec) -> Result<MachineStats, SweepError> {
        let stats = verdict.stats(machine, &self.stream.header, &source(self.stream, self.stop));
        told(stats, machine, self.stream, self.stop)
    }
}

fn source<'a>(stream: &'a Recorded, stop: &'a AtomicBool) -> Stoppable<'a> {
    Stoppable { file: StreamFile(&stream.path), stop }
}

fn replay_of<'a>(machine: &'a MachineSpec, stream: &'a Recorded) -> Result<Replay<'a>, RunError> {
    Ok(Replay::new(machine, &stream.header)?)
}

fn told<T>(
    result: Result<T, RunError>,
    machine: &MachineSpec,
    stream: &Recorded,
    stop: &AtomicBool,
) -> Result<T, SweepError> {
    if stop.load(Ordering::Relaxed) {
        return Err(SweepError::Stopped);
    }
    result.map_err(|source| SweepError::Machine {
        machine: machine.name.clone(),
        policy: stream.header.policy.clone(),
        source: Box::new(source),
    })
}
