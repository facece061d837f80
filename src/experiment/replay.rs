//! Machines at work on streams while these are traced: a thread each, fed through a short queue.

use std::convert::Infallible;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{Scope, ScopedJoinHandle};
use std::time::{Duration, Instant};

use super::dram_export::DramExport;
use super::progress;
use crate::engine::{self, Fidelity, RunError};
use crate::machine::MachineSpec;
use crate::stats::MachineStats;
use crate::stream::{Header, Item, StreamError, StreamReader};

/// A machine that was told nothing more will come, or that has failed.
#[derive(Debug)]
pub struct Stopped;

/// Items that may wait for a machine. A few bands: more would only take memory.
const WAITING: usize = 8;

/// Machines that replay the streams of several policies.
#[derive(Default)]
pub struct Replays<'scope> {
    runs: Vec<Replay<'scope>>,
}

struct Replay<'scope> {
    policy: usize,
    machine: String,
    items: SyncSender<Item>,
    thread: ScopedJoinHandle<'scope, Result<Replayed, RunError<Infallible>>>,
}

/// What a machine measured, and how long that took.
pub struct Replayed {
    /// The measurements.
    pub stats: MachineStats,
    /// Wall time of the simulation, waiting for the tracer included.
    pub wall: Duration,
}

/// A finished replay.
pub struct Finished {
    /// The policy whose stream it was.
    pub policy: usize,
    /// The machine's name.
    pub machine: String,
    /// The result.
    pub result: Result<Replayed, RunError<Infallible>>,
}

impl<'scope> Replays<'scope> {
    /// Starts a machine on the stream of a policy.
    pub fn start<'env>(
        &mut self,
        scope: &'scope Scope<'scope, 'env>,
        name: &str,
        machine: &'env MachineSpec,
        fidelity: Fidelity,
        policy: usize,
        header: Header,
    ) {
        let (items, received): (_, Receiver<Item>) = sync_channel(WAITING);
        let thread = scope.spawn(move || {
            let begin = Instant::now();
            let stats = engine::run(machine, fidelity, &header, received.into_iter().map(Ok))?;
            Ok(Replayed { stats, wall: begin.elapsed() })
        });
        self.runs.push(Replay { policy, machine: name.to_owned(), items, thread });
    }

    /// Hands the next item of a policy's stream to all machines that replay it; waits while they are busy.
    pub fn send(&self, policy: usize, item: &Item) -> Result<(), Stopped> {
        for run in self.runs.iter().filter(|run| run.policy == policy) {
            // A machine that has gone away has failed: its error comes out in `finish`.
            run.items.send(item.clone()).map_err(|_| Stopped)?;
        }
        Ok(())
    }

    /// Ends all streams and waits for the results.
    pub fn finish(self) -> Vec<Finished> {
        let (threads, streams): (Vec<_>, Vec<_>) =
            self.runs.into_iter().map(|run| ((run.policy, run.machine, run.thread), run.items)).unzip();
        drop(streams);
        let join = |(policy, machine, thread): (usize, String, ScopedJoinHandle<'_, _>)| {
            let result = thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            Finished { policy, machine, result }
        };
        threads.into_iter().map(join).collect()
    }
}

/// Replays a recorded stream on a machine, with what its DRAM is asked for and does written to files if they are wanted.
pub fn replay_file(
    machine: &MachineSpec,
    fidelity: Fidelity,
    reader: StreamReader,
    export: Option<&mut DramExport>,
) -> Result<MachineStats, RunError<StreamError>> {
    let header = reader.header().clone();
    let bar = progress::bar(header.frames.len(), "frames").with_message("replaying");
    let items = reader.inspect(|item| {
        if matches!(item, Ok(Item::End { .. })) {
            bar.inc(1);
        }
    });
    let stats = match export {
        None => engine::run(machine, fidelity, &header, items),
        Some(export) => engine::run_observed(machine, fidelity, &header, items, export),
    };
    bar.finish_and_clear();
    stats
}
