//! Machines that replay streams during tracing: one thread each, fed through a short queue.

use std::cell::RefCell;
use std::path::Path;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{Scope, ScopedJoinHandle};
use std::time::{Duration, Instant};

use super::exports::Exports;
use super::line_export::LineExport;
use super::over_time::Recorder;
use super::progress::{self, Progress};
use super::split::Role;
use crate::machine::MachineSpec;
use crate::output::TemporaryFolder;
use crate::replay::{Fidelity, Items, Replay, RunError, Source, StreamFile};
use crate::report::run::Span;
use crate::stats::MachineStats;
use crate::stream::{Header, Item, StreamError, StreamReader, StreamWriter};

/// A machine has failed or stopped, and takes no more items.
#[derive(Debug)]
pub(crate) struct Stopped;

/// Items that may wait for a machine: a few bands of a picture. A longer queue would only take memory. Assumed.
const WAITING: usize = 8;

/// Machines that replay the streams of several policies.
#[derive(Default)]
pub(crate) struct Replays<'scope> {
    runs: Vec<Running<'scope>>,
}

struct Running<'scope> {
    policy: usize,
    machine: String,
    role: Role,
    items: SyncSender<Item>,
    thread: ScopedJoinHandle<'scope, Result<Replayed, RunError>>,
}

/// A machine's measurements, and the time they took.
pub(crate) struct Replayed {
    /// The measurements.
    pub stats: MachineStats,
    /// The measured frames over time; only for a machine in the role `AsItIs` that is replayed cycle by cycle.
    pub over_time: Vec<Span>,
    /// Wall time of the simulation, waiting for the tracer included.
    pub wall: Duration,
}

/// A finished replay.
pub(crate) struct Finished {
    /// The policy whose stream it was.
    pub policy: usize,
    /// The machine's name.
    pub machine: String,
    /// The machine's role.
    pub role: Role,
    /// The result.
    pub result: Result<Replayed, RunError>,
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
            let replay = Replay::new(&spec, &header)?;
            let mut recorder = Recorder::new(&header);
            let stats = match (fidelity.exact(), fidelity.one_pass()) {
                (Ok(exact), _) if role == Role::AsItIs => {
                    replay.fidelity(exact).observe(&mut recorder)?.run(received.into_iter().map(Ok))?
                }
                (_, Some(fidelity)) => replay.fidelity(fidelity).run(received.into_iter().map(Ok))?,
                (_, None) => {
                    let folder = TemporaryFolder::create().map_err(temporary)?;
                    let file = folder.path().join("stream.rays");
                    record(&header, received, &file)?;
                    replay.fidelity(fidelity).run(&StreamFile(&file))?
                }
            };
            Ok(Replayed { stats, over_time: recorder.finish(), wall: begin.elapsed() })
        });
        self.runs.push(Running { policy, machine: machine.name.clone(), role, items, thread });
    }

    /// Sends the next item of a policy's stream to all machines that replay it; blocks while their queues are full.
    pub(crate) fn send(&self, policy: usize, item: &Item) -> Result<(), Stopped> {
        for run in self.runs.iter().filter(|run| run.policy == policy) {
            // The machine has failed: `finish` returns its error.
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

/// Writes a stream to `path`, so that it can be read more than once.
fn record(header: &Header, items: Receiver<Item>, path: &Path) -> Result<(), StreamError> {
    let mut writer = StreamWriter::create(path, header)?;
    items.into_iter().try_for_each(|item| writer.write(&item))?;
    writer.finish()
}

/// Replays the recorded stream `path` on a machine, and writes the files in `exports` and `lines`.
pub(crate) fn replay_file(
    machine: &MachineSpec,
    fidelity: Fidelity,
    path: &Path,
    exports: &mut Exports,
    lines: Option<&mut LineExport>,
) -> Result<MachineStats, RunError> {
    let header = StreamReader::open(path)?.header().clone();
    let bar = progress::bar("replaying", header.frames.len(), "frames");
    let told = Told { file: StreamFile(path), bar: &bar, lines: RefCell::new(lines) };
    let replay = Replay::new(machine, &header)?;
    let stats = match exports.is_empty() {
        true => replay.fidelity(fidelity).run(&told),
        false => replay.fidelity(fidelity.exact()?).observe(exports)?.run(told.open(0)?),
    };
    drop(bar);
    stats
}

/// A recorded stream that advances a bar as it is read, and writes its lines to a file if that is wanted.
struct Told<'a> {
    file: StreamFile<'a>,
    bar: &'a Progress,
    lines: RefCell<Option<&'a mut LineExport>>,
}

impl Source for Told<'_> {
    fn open(&self, frame: usize) -> Result<Items<'_>, StreamError> {
        self.bar.reset();
        let told = |item: &Result<Item, StreamError>| {
            if matches!(item, Ok(Item::End { .. })) {
                self.bar.inc(1);
            }
            if let (Some(lines), Ok(item)) = (self.lines.borrow_mut().as_mut(), item) {
                lines.item(item);
            }
        };
        Ok(Box::new(self.file.open(frame)?.inspect(told)))
    }
}
