//! Machines at work on streams while these are traced: a thread each, fed through a short queue.

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{Scope, ScopedJoinHandle};
use std::time::{Duration, Instant};

use super::dram_export::DramExport;
use super::line_export::LineExport;
use super::progress;
use super::split::Role;
use crate::engine::{self, Fidelity, RunError};
use crate::machine::MachineSpec;
use crate::output::TemporaryFolder;
use crate::stats::MachineStats;
use crate::stream::{Header, Item, StreamError, StreamReader, StreamWriter};

/// A machine that was told nothing more will come, or that has failed.
#[derive(Debug)]
pub(crate) struct Stopped;

/// Items that may wait for a machine. A few bands: more would only take memory.
const WAITING: usize = 8;

/// Machines that replay the streams of several policies.
#[derive(Default)]
pub(crate) struct Replays<'scope> {
    runs: Vec<Replay<'scope>>,
}

struct Replay<'scope> {
    policy: usize,
    machine: String,
    role: Role,
    items: SyncSender<Item>,
    thread: ScopedJoinHandle<'scope, Result<Replayed, RunError<StreamError>>>,
}

/// What a machine measured, and how long that took.
pub(crate) struct Replayed {
    /// The measurements.
    pub stats: MachineStats,
    /// Wall time of the simulation, waiting for the tracer included.
    pub wall: Duration,
}

/// A finished replay.
pub(crate) struct Finished {
    /// The policy whose stream it was.
    pub policy: usize,
    /// The machine's name.
    pub machine: String,
    /// What it was replayed for.
    pub role: Role,
    /// The result.
    pub result: Result<Replayed, RunError<StreamError>>,
}

impl<'scope> Replays<'scope> {
    /// Starts a machine, in a role, on the stream of a policy.
    pub(crate) fn start(
        &mut self,
        scope: &'scope Scope<'scope, '_>,
        (machine, role): (&MachineSpec, Role),
        fidelity: Fidelity,
        policy: usize,
        header: Header,
    ) {
        let spec = role.machine(machine);
        let (items, received): (_, Receiver<Item>) = sync_channel(WAITING);
        let thread = scope.spawn(move || {
            let begin = Instant::now();
            let stats = if fidelity.takes_passes() {
                let folder = TemporaryFolder::create().map_err(temporary).map_err(RunError::Source)?;
                let file = record(&header, received, &folder.path().join("stream.rays")).map_err(RunError::Source)?;
                engine::run_passes(&spec, fidelity, &header, |frame| open_at(&file, frame))?
            } else {
                engine::run(&spec, fidelity, &header, received.into_iter().map(Ok))?
            };
            Ok(Replayed { stats, wall: begin.elapsed() })
        });
        self.runs.push(Replay { policy, machine: machine.name.clone(), role, items, thread });
    }

    /// Hands the next item of a policy's stream to all machines that replay it; waits while they are busy.
    pub(crate) fn send(&self, policy: usize, item: &Item) -> Result<(), Stopped> {
        for run in self.runs.iter().filter(|run| run.policy == policy) {
            // A machine that has gone away has failed: its error comes out in `finish`.
            run.items.send(item.clone()).map_err(|_| Stopped)?;
        }
        Ok(())
    }

    /// Ends all streams and waits for the results.
    pub(crate) fn finish(self) -> Vec<Finished> {
        let (threads, streams): (Vec<_>, Vec<_>) =
            self.runs.into_iter().map(|run| ((run.policy, run.machine, run.role, run.thread), run.items)).unzip();
        drop(streams);
        let join = |(policy, machine, role, thread): (usize, String, Role, ScopedJoinHandle<'_, _>)| {
            let result = thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            Finished { policy, machine, role, result }
        };
        threads.into_iter().map(join).collect()
    }
}

fn temporary(source: std::io::Error) -> StreamError {
    StreamError::Io { path: std::env::temp_dir(), doing: "write", source }
}

fn open_at(path: &Path, frame: usize) -> Result<StreamReader, StreamError> {
    let mut reader = StreamReader::open(path)?;
    reader.seek_frame(frame)?;
    Ok(reader)
}

/// Writes a stream that is to be read more than once at `path`.
fn record(header: &Header, items: Receiver<Item>, path: &Path) -> Result<PathBuf, StreamError> {
    let mut writer = StreamWriter::create(path, header)?;
    items.into_iter().try_for_each(|item| writer.write(&item))?;
    writer.finish()?;
    Ok(path.into())
}

/// Replays the recorded stream `path` on a machine, while what its DRAM and a cache are asked for goes to files if they
/// are wanted.
pub(crate) fn replay_file(
    machine: &MachineSpec,
    fidelity: Fidelity,
    path: &Path,
    dram: Option<&mut DramExport>,
    lines: Option<&mut LineExport>,
) -> Result<MachineStats, RunError<StreamError>> {
    let header = StreamReader::open(path).map_err(RunError::Source)?.header().clone();
    let bar = progress::bar(header.frames.len(), "frames").with_message("replaying");
    let lines = RefCell::new(lines);
    let open = |first| {
        bar.reset();
        let told = |item: &Result<Item, StreamError>| {
            if matches!(item, Ok(Item::End { .. })) {
                bar.inc(1);
            }
            if let (Some(lines), Ok(item)) = (lines.borrow_mut().as_mut(), item) {
                lines.item(item);
            }
        };
        Ok(open_at(path, first)?.inspect(told))
    };
    let stats = match dram {
        None => engine::run_passes(machine, fidelity, &header, open),
        Some(dram) => {
            let items = open(0).map_err(RunError::Source)?;
            engine::run_observed(machine, fidelity, &header, items, dram)
        }
    };
    bar.finish_and_clear();
    stats
}
