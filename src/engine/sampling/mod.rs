//! Sampling: of each stratum of consecutive windows (runs of pixels of about the same number of rays) some are replayed and measured,
//! each by itself, between two halves of others and behind warm caches; the accesses of all others go through the caches' tags alone.

pub mod estimate;
pub mod figures;
mod job;
mod known;
mod plan;
mod tags;
mod windows;

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::sync::mpsc::{Receiver, sync_channel};
use std::sync::{Arc, Mutex};
use std::thread;

use self::estimate::{Population, Total, Window};
use self::job::{Figures, Found, Latencies};
use self::known::{DRAM_BYTES, L2_BYTES};
pub use self::plan::Plan;
pub use self::tags::Tags;
use self::windows::{Job, Windows};
use super::{Engine, RunError, Sampled, event, functional};
use crate::machine::MachineSpec;
use crate::stats::{Accuracy, LatencyCounts, MachineStats};
use crate::stream::{Header, Item};

/// What a sample found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Findings {
    /// All windows, frames' ends left out.
    pub population: Population,
    /// Those that were measured.
    pub measured: Vec<Window>,
    /// Sums over frames' ends.
    ends: Figures,
    /// Rays of the stream, skipped ones not counted.
    rays: u64,
    /// The statistics of a run in which nothing happens, but for the longest latencies, which are those of the windows.
    nothing: MachineStats,
}

/// Jobs that may wait: each holds the tags of a machine.
const WAITING: usize = 2;

/// Samples a stream: one thread reads it and keeps the tags warm, the others replay what is measured. What is found does not depend on
/// their number.
pub(super) fn sample<E>(
    engine: Sampled,
    machine: &MachineSpec,
    header: &Header,
    plan: Plan,
    items: impl Iterator<Item = Result<Item, E>>,
) -> Result<Findings, RunError<E>> {
    // One thread reads.
    let workers = thread::available_parallelism().map_or(1, |threads| threads.get() - 1).max(1);
    sample_by(workers, engine, machine, header, plan, items)
}

/// As [`sample`], with so many threads that replay.
pub(super) fn sample_by<E>(
    workers: usize,
    engine: Sampled,
    machine: &MachineSpec,
    header: &Header,
    plan: Plan,
    items: impl Iterator<Item = Result<Item, E>>,
) -> Result<Findings, RunError<E>> {
    let replay = |job: Job| match engine {
        Sampled::Functional => job::replay(functional::Functional::new(machine, header), machine, job),
        Sampled::Event => job::replay(event::Event::new(machine, header), machine, job),
    };
    let work = |jobs: &Mutex<Receiver<Job>>| {
        let mut found = Vec::new();
        loop {
            let job = jobs.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).recv();
            let Ok(job) = job else { return found };
            found.push((job.number, replay(job)));
        }
    };
    let mut windows = Windows::new(machine, header, plan);
    let mut found = thread::scope(|scope| {
        let (jobs, received) = sync_channel(WAITING);
        // Shared by the workers alone: should all of them panic, nothing can be sent.
        let received = Arc::new(Mutex::new(received));
        let workers: Vec<_> =
            (0..workers).map(|_| Arc::clone(&received)).map(|received| scope.spawn(move || work(&received))).collect();
        drop(received);
        for item in items {
            for job in windows.add(&item.map_err(RunError::Source)?) {
                if jobs.send(job).is_err() {
                    // All workers have panicked, which comes out below.
                    break;
                }
            }
        }
        drop(jobs);
        let joined =
            workers.into_iter().map(|worker| worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        Ok::<_, RunError<E>>(joined.flatten().collect::<Vec<_>>())
    })?;
    found.sort_by_key(|(number, _)| *number);
    let Windows { population, rays, .. } = windows;
    let nothing = match engine {
        Sampled::Functional => functional::Functional::new(machine, header).tally(1),
        Sampled::Event => event::Event::new(machine, header).tally(1),
    };
    let mut findings = Findings { population, rays, nothing: nothing.stats(machine), ..Findings::default() };
    for (_, found) in found {
        match found.map_err(without_source)? {
            Found::Window(window, latency) => {
                findings.measured.push(*window);
                findings.know_longest(latency);
            }
            Found::End(end) => {
                end.into_iter().for_each(|(name, value)| *findings.ends.entry(name).or_default() += value);
            }
        }
    }
    Ok(findings)
}

/// A job's items cannot fail to be read.
fn without_source<E>(error: RunError<Infallible>) -> RunError<E> {
    match error {
        RunError::Source(never) => match never {},
        RunError::Spec(error) => RunError::Spec(error),
        RunError::Stream(fault) => RunError::Stream(fault),
        RunError::Counts { frame, what, machine, tracer } => RunError::Counts { frame, what, machine, tracer },
        RunError::Invariant(what) => RunError::Invariant(what),
        RunError::Illegal { channel, violation } => RunError::Illegal { channel, violation },
        RunError::Observer(error) => RunError::Observer(error),
        RunError::Passes => RunError::Passes,
        RunError::Deadlock { cycle, queues } => RunError::Deadlock { cycle, queues },
    }
}

impl Findings {
    /// Adds what a later pass over the same stream measured.
    pub fn join(&mut self, other: Self) {
        let before = std::mem::replace(self, other);
        self.measured.extend(before.measured);
        self.know_longest(before.nothing.latency);
    }

    fn know_longest(&mut self, latencies: Latencies) {
        for (kind, LatencyCounts { most, .. }) in latencies {
            let known = self.nothing.latency.entry(kind).or_default();
            known.most = known.most.max(most);
        }
    }

    /// The stream's statistics, as the sample lets them be estimated; `rate` is the share of windows that were measured.
    pub fn estimate(&self, machine: &MachineSpec, rate: f64) -> MachineStats {
        let mut totals = estimate::estimate(&self.population, &self.measured, machine.line_bytes.get());
        for (name, end) in &self.ends {
            totals.entry(name.clone()).or_default().total += end;
        }
        // Absent is absent.
        let is_there = |name: &str, total: &Total| !name.starts_with("bytes.") || total.total > 0.0;
        let named = || totals.iter().filter(|(name, total)| !name.starts_with('=') && is_there(name, total));
        let figures: BTreeMap<String, f64> = named().map(|(name, total)| (name.clone(), total.total)).collect();
        let mut stats = figures::with(&self.nothing, figures.iter());
        stats.rays = self.rays;
        let share = |name: &str| totals.get(name).and_then(Total::share);
        stats.accuracy = match (share("cycles"), share(L2_BYTES), share(DRAM_BYTES)) {
            (Some(cycles), Some(l2_bytes), Some(dram_bytes)) => {
                Accuracy::Estimated { cycles, l2_bytes, dram_bytes, rate }
            }
            _ => Accuracy::Unknown,
        };
        stats.half_widths = named().filter_map(|(name, total)| Some((name.clone(), total.half_width?))).collect();
        stats
    }
}
