//! Reuse in the caches of a run's machines, measured in one frame of one policy's stream during the run.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{Scope, ScopedJoinHandle};

use super::load::Experiment;
use crate::machine::MachineSpec;
use crate::named::Named;
use crate::replay::{Fidelity, Replay, RunError};
use crate::stats::{FrameReuse, ReuseLevel};
use crate::stream::{Header, Item};

/// Items that may wait for a machine. Assumed.
const WAITING: usize = 8;

/// A machine failed.
pub(super) struct Failed {
    /// The machine's name.
    pub machine: String,
    /// The policy of the stream.
    pub policy: String,
    /// What happened.
    pub source: Box<RunError>,
}

type Found = Result<Option<Vec<ReuseLevel>>, RunError>;

/// Machines that measure reuse, one thread each.
pub(super) struct FrameReuses<'scope> {
    policy: usize,
    name: String,
    frame: Option<u32>,
    runs: Vec<(String, SyncSender<Item>, ScopedJoinHandle<'scope, Found>)>,
}

impl<'scope> FrameReuses<'scope> {
    /// Starts all machines, some of which may refuse. Takes the first policy that culls and the first measured frame.
    /// With fidelity level `Bound` no machine starts: reuse would take longer than the whole run.
    pub(super) fn start(
        scope: &'scope Scope<'scope, '_>,
        experiment: &Experiment,
        machines: &Named<MachineSpec>,
        headers: &[Header],
    ) -> Self {
        let off = experiment.off();
        let policy = (0..headers.len()).find(|&policy| policy != off).unwrap_or(off);
        let frame = experiment.frames.iter().copied().find(|&frame| experiment.replayed.measures(frame));
        let frame = frame.filter(|_| experiment.spec.fidelity != Fidelity::Bound);
        let header = headers.get(policy).zip(frame);
        let header = header.map(|(it, frame)| Header { frames: vec![frame], warmup: Vec::new(), ..it.clone() });
        let run = |(name, machine): (&str, &MachineSpec)| {
            let (header, machine) = (header.clone()?, machine.clone());
            let (items, received) = sync_channel(WAITING);
            Some((name.to_owned(), items, scope.spawn(move || measure(&machine, &header, received))))
        };
        let name = headers.get(policy).map(|header| header.policy.clone()).unwrap_or_default();
        Self { policy, name, frame, runs: machines.iter().filter_map(run).collect() }
    }

    /// Sends an item of a policy's stream in a frame to all machines, if they measure that policy and frame.
    pub(super) fn send(&self, policy: usize, frame: u32, item: &Item) {
        if self.policy == policy && self.frame == Some(frame) {
            // A machine that refused takes no items.
            self.runs.iter().for_each(|(_, items, _)| drop(items.send(item.clone())));
        }
    }

    /// Waits for the results, by machine.
    ///
    /// # Errors
    /// A machine failed.
    pub(super) fn finish(self) -> Result<Named<FrameReuse>, Failed> {
        let (policy, frame) = (self.name, self.frame.unwrap_or_default());
        let mut found = Named::default();
        for (machine, items, thread) in self.runs {
            drop(items);
            let levels = thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            match levels {
                Ok(Some(levels)) => found.insert(machine, FrameReuse { policy: policy.clone(), frame, levels }),
                Ok(None) => continue,
                Err(source) => return Err(Failed { machine, policy, source: Box::new(source) }),
            };
        }
        Ok(found)
    }
}

/// The reuse on a machine; `None` if it refuses, or if the run stops before the frame.
fn measure(machine: &MachineSpec, header: &Header, received: Receiver<Item>) -> Found {
    let Ok(first) = received.recv() else { return Ok(None) };
    let mut items = std::iter::once(first).chain(received).map(Ok);
    match Replay::new(machine, header)?.reuse_of_frame(&mut items) {
        Ok(levels) => Ok(Some(levels)),
        Err(RunError::Spec(_)) => Ok(None),
        Err(failed) => Err(failed),
    }
}
