//! A pass over a stream: one thread reads it, one cuts it and keeps the L1s' tags warm, one the L2's, and the others
//! replay what is measured.

use std::borrow::Cow;
use std::sync::mpsc::{Receiver, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, ScopedJoinHandle};

use super::cutter::{Cutter, Portion};
use super::estimate::Population;
use super::job::{self, Found};
use super::kept::{Kept, KeptJob};
use super::plan::Plan;
use super::windows::{Job, JobWork, Windows};
use crate::engine::contract::Engine;
use crate::engine::{self, ItemStream, RunError, Sampled};
use crate::machine::MachineSpec;
use crate::stats::MachineStats;
use crate::stream::{Header, Item};

/// Items that may wait to be cut, those that may wait for the L2, and jobs that may wait to be replayed, which hold the
/// tags of a machine each.
const ITEMS: usize = 4;
const CUT: usize = 4;
const JOBS: usize = 2;

/// Jobs of later draws are kept until so many times as many were measured: until twice as many were, three times.
const KEPT: usize = 8;

/// Who samples. What is found does not depend on how many threads there are.
#[derive(Clone, Copy)]
pub(crate) struct Sampler<'a> {
    /// What replays windows.
    pub engine: Sampled,
    /// The machine.
    pub machine: &'a MachineSpec,
    /// The stream's header.
    pub header: &'a Header,
    /// Threads.
    pub threads: usize,
}

/// What a pass gave.
pub(crate) struct Pass {
    /// All windows.
    pub population: Population,
    /// Rays of the stream, skipped ones not counted.
    pub rays: u64,
    /// What was measured, in the stream's order.
    pub found: Vec<Found>,
    /// Jobs of later draws.
    pub kept: Kept,
}

impl<'a> Sampler<'a> {
    /// Samples with as many threads as rayon has, which `--threads` says.
    pub(crate) fn new(engine: Sampled, machine: &'a MachineSpec, header: &'a Header) -> Self {
        Self { engine, machine, header, threads: rayon::current_num_threads() }
    }

    /// Passes over a stream, measures what `plan` says and keeps jobs of later draws below `keep`, which is the same
    /// for all passes whose findings are added: a window that is measured for its first point must know the later ones.
    ///
    /// # Errors
    /// The stream cannot be read, or a replay fails.
    pub(crate) fn pass(&self, plan: &Plan, keep: usize, items: &mut ItemStream<'_>) -> Result<Pass, RunError> {
        let mut cutter = Cutter::new(self.machine, self.header, plan.cut);
        let later = plan.draws.end..keep.min(KEPT * plan.draws.end).max(plan.draws.end);
        let mut windows = Windows::new(self.machine, self.header, plan.clone(), keep, later.end);
        let mut kept = Kept::new(later);
        thread::scope(|scope| {
            let (jobs, received) = sync_channel(JOBS);
            // Shared by the workers alone: should all of them panic, nothing can be sent.
            let received = Arc::new(Mutex::new(received));
            // Cutting takes a processor. Where more is to be replayed than the workers can, who takes pieces through
            // the L2 replays too.
            let workers: Vec<_> = (1..self.threads)
                .map(|_| Arc::clone(&received))
                .map(|received| scope.spawn(move || self.work(&received)))
                .collect();
            drop(received);
            let (items_read, to_cut) = sync_channel::<Item>(ITEMS);
            let (portions_cut, portions) = sync_channel::<Vec<Portion>>(CUT);
            let cutting = scope.spawn(move || {
                let mut cut = to_cut.into_iter().map(|item| cutter.add(&item));
                // Nobody receives any more if a thread has panicked, which comes out when it is joined.
                let _ = cut.try_for_each(|portions| portions_cut.send(portions));
            });
            let joining = scope.spawn(move || {
                let mut found = Vec::new();
                for job in portions.into_iter().flatten().flat_map(|portion| windows.add(portion)) {
                    if !plan.draws.contains(&job.draw) {
                        kept.add(job);
                    } else if let Err(TrySendError::Full(job) | TrySendError::Disconnected(job)) = jobs.try_send(job) {
                        found.push(self.replay_one(&job));
                    }
                }
                (windows, kept, found)
            });
            let mut read = Ok(());
            for item in items {
                match item {
                    Ok(item) => {
                        if items_read.send(item).is_err() {
                            // A thread has panicked.
                            break;
                        }
                    }
                    Err(error) => {
                        read = Err(error);
                        break;
                    }
                }
            }
            drop(items_read);
            joined(cutting);
            let (Windows { population, rays, .. }, kept, mut found) = joined(joining);
            found.extend(workers.into_iter().flat_map(joined));
            read?;
            Ok(Pass { population, rays, found: in_order(found)?, kept })
        })
    }

    /// Replays `jobs` that were kept.
    ///
    /// # Errors
    /// A replay fails.
    pub(crate) fn replay(&self, jobs: Vec<KeptJob>) -> Result<Vec<Found>, RunError> {
        let jobs = Mutex::new(jobs.into_iter());
        let work = || {
            let next = || jobs.lock().unwrap_or_else(PoisonError::into_inner).next();
            std::iter::from_fn(next).map(|job| self.replay_one(&job.unpack())).collect::<Vec<_>>()
        };
        let found = thread::scope(|scope| {
            let workers: Vec<_> = (0..self.threads).map(|_| scope.spawn(work)).collect();
            workers.into_iter().flat_map(joined).collect()
        });
        in_order(found)
    }

    fn work(&self, jobs: &Mutex<Receiver<Job>>) -> Vec<Numbered> {
        let next = || jobs.lock().unwrap_or_else(PoisonError::into_inner).recv().ok();
        std::iter::from_fn(next).map(|job| self.replay_one(&job)).collect()
    }

    fn replay_one(&self, job: &Job) -> Numbered {
        let machine = match &job.work {
            JobWork::End(_) => Cow::Borrowed(self.machine),
            // The frame's dynamic part is there: its building counts with the frame's end.
            JobWork::Window(_) => {
                let traffic = self.machine.traffic.without_build();
                Cow::Owned(MachineSpec { traffic, ..self.machine.clone() })
            }
        };
        (job.number, job::replay(self.engine(&machine).as_mut(), &machine, job))
    }

    /// The statistics of a run in which nothing happens.
    pub(crate) fn nothing(&self) -> MachineStats {
        self.engine(self.machine).tally(1).stats(self.machine)
    }

    /// A new engine of a machine.
    fn engine(&self, machine: &MachineSpec) -> Box<dyn Engine> {
        let engine = engine::engine(self.engine.into(), machine, self.header);
        engine.expect("all that replay samples have machines in motion")
    }
}

/// What a job found, and its number.
type Numbered = (usize, Result<Found, RunError>);

fn joined<T>(thread: ScopedJoinHandle<'_, T>) -> T {
    thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

fn in_order(mut found: Vec<Numbered>) -> Result<Vec<Found>, RunError> {
    found.sort_by_key(|(number, _)| *number);
    found.into_iter().map(|(_, found)| found).collect()
}
