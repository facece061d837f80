//! A pass over a stream for all sampled machines. One thread reads and cuts the stream; others pass the pieces through
//! the machines' tags and replay measured windows.

use std::borrow::Cow;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, ScopedJoinHandle};

use super::cutter::{Cutter, Portion};
use super::estimate::Population;
use super::job::{self, Found};
use super::job_cache::{CachedJob, JobCache};
use super::lane::{self, Lane, OnLane};
use super::plan::Plan;
use super::windows::{Job, JobWork, Windows};
use crate::engine::contract::Engine;
use crate::engine::{self, ItemStream, RunError, Sampled};
use crate::machine::MachineSpec;
use crate::stats::MachineStats;
use crate::stream::Header;

/// Channel capacities: cut items that wait for the tags, and jobs that wait for replay. Each job holds the tags of a
/// machine.
const CUT: usize = 4;
const JOBS: usize = 2;

/// Jobs of later draws are kept up to 32 times the measured draws: enough for five doublings. Of a long stream, a share
/// of the windows is kept where that is more: this costs little, and another pass costs much.
const KEPT: usize = 32;
const KEPT_SHARE: f64 = 1.0 / 64.0;
/// Maximum bytes of kept jobs, of all machines together.
const MOST_BYTES: usize = 1 << 30;

/// Samples streams. Results do not depend on the number of threads.
#[derive(Clone, Copy)]
pub(crate) struct Sampler<'a> {
    /// The engine that replays windows.
    pub engine: Sampled,
    /// The stream's header.
    pub header: &'a Header,
    /// Number of threads.
    pub threads: usize,
}

/// A machine, and which of its windows are measured. All members of a pass have the same cut and the same strata.
#[derive(Clone, Debug)]
pub(crate) struct Member<'a> {
    /// The machine.
    pub machine: &'a MachineSpec,
    /// Its windows.
    pub plan: Plan,
}

/// A machine's result of a pass.
#[derive(Debug)]
pub(crate) struct Pass {
    /// Covariates of all windows.
    pub population: Population,
    /// Traced rays of the stream (skipped ones not counted).
    pub rays: u64,
    /// Results of the measured jobs, in the stream's order.
    pub found: Vec<Found>,
    /// Jobs of later draws, not replayed yet.
    pub cached: JobCache,
}

/// A job's result, with the machine's index and the job's number.
type Numbered = (usize, usize, Result<Found, RunError>);
type ToReplay = (usize, Job);

/// A result for each machine, or that machine's error; an error of the stream concerns all.
pub(crate) type PerMachine<T> = Result<Vec<Result<T, RunError>>, RunError>;

impl<'a> Sampler<'a> {
    /// A sampler with rayon's number of threads, which `--threads` sets.
    pub(crate) fn new(engine: Sampled, header: &'a Header) -> Self {
        Self { engine, header, threads: rayon::current_num_threads() }
    }

    /// Passes over a stream, measures the plans' windows and keeps jobs of later draws below `keep`. `keep` must be the
    /// same for all passes whose findings are added: a window measured for its first point must list its later ones.
    /// The result of a machine does not depend on the other members.
    ///
    /// # Errors
    /// The stream cannot be read. Per machine: a replay fails.
    pub(crate) fn pass(&self, members: &[Member<'_>], keep: usize, items: &mut ItemStream<'_>) -> PerMachine<Pass> {
        let Some(first) = members.first() else { return Ok(Vec::new()) };
        let ends = members.iter().map(|member| member.plan.draws.end);
        let mut cutter = Cutter::new(self.header, first.machine, &first.plan, ends.fold(keep, usize::max));
        let on_lanes = members.iter().enumerate().map(|(index, Member { machine, plan })| {
            let most = (KEPT * plan.draws.end).max((KEPT_SHARE * plan.strata.length) as usize);
            let later = plan.draws.end..keep.min(most).max(plan.draws.end);
            let windows = Windows::new(machine, self.header, plan.clone(), later.end);
            (*machine, OnLane { index, windows, cached: JobCache::new(later, MOST_BYTES, members.len()) })
        });
        let mut by_thread: Vec<Vec<Lane>> = Vec::new();
        for (at, lane) in lane::lanes(self.header, on_lanes, self.threads).into_iter().enumerate() {
            match by_thread.get_mut(at % self.threads) {
                Some(lanes) => lanes.push(lane),
                None => by_thread.push(vec![lane]),
            }
        }
        let mut read = Ok(());
        let (lanes, found) = thread::scope(|scope| {
            let (jobs, received) = sync_channel(JOBS);
            // Owned by the threads alone: if all of them panic, sending fails instead of blocking.
            let received = Arc::new(Mutex::new(received));
            let workers = self.threads.saturating_sub(by_thread.len());
            let workers: Vec<_> = (0..workers)
                .map(|_| Arc::clone(&received))
                .map(|received| scope.spawn(move || self.work(members, &received)))
                .collect();
            let mut pieces: Vec<SyncSender<Arc<Vec<Portion>>>> = Vec::new();
            let mut passing = Vec::new();
            for lanes in by_thread {
                let (cut, portions) = sync_channel(CUT);
                pieces.push(cut);
                let (jobs, received) = (jobs.clone(), Arc::clone(&received));
                passing.push(scope.spawn(move || self.pass_lanes(members, lanes, &portions, (jobs, &received))));
            }
            drop((jobs, received));
            for item in items {
                match item.map_err(RunError::from).and_then(|item| Ok(cutter.add(&item)?)) {
                    Ok(portions) => {
                        let portions = Arc::new(portions);
                        if pieces.iter().any(|to| to.send(Arc::clone(&portions)).is_err()) {
                            // A thread has panicked; joining it raises the panic.
                            break;
                        }
                    }
                    Err(error) => {
                        read = Err(error);
                        break;
                    }
                }
            }
            drop(pieces);
            let (lanes, found): (Vec<_>, Vec<_>) = passing.into_iter().map(joined).unzip();
            let found = found.into_iter().chain(workers.into_iter().map(joined)).flatten().collect::<Vec<_>>();
            (lanes, found)
        });
        read?;
        let mut on_lanes: Vec<OnLane> = lanes.into_iter().flatten().flat_map(Lane::finish).collect();
        on_lanes.sort_by_key(|machine| machine.index);
        let passes = on_lanes.into_iter().zip(in_order(found, members.len()));
        Ok(passes
            .map(|(OnLane { windows: Windows { population, rays, .. }, cached, .. }, found)| {
                Ok(Pass { population, rays, found: found?, cached })
            })
            .collect())
    }

    /// Passes the cut stream through the tags of `lanes`, then replays jobs that are left. Where the job queue is full,
    /// this thread replays the job itself.
    fn pass_lanes(
        &self,
        members: &[Member<'_>],
        mut lanes: Vec<Lane>,
        portions: &Receiver<Arc<Vec<Portion>>>,
        (jobs, received): (SyncSender<ToReplay>, &Mutex<Receiver<ToReplay>>),
    ) -> (Vec<Lane>, Vec<Numbered>) {
        let mut found = Vec::new();
        for portions in portions {
            for portion in portions.iter() {
                let new: Vec<Lane> = lanes.iter_mut().flat_map(Lane::split_off).collect();
                lanes.extend(new);
                for job in lanes.iter_mut().flat_map(|lane| lane.add(portion)) {
                    if let Err(TrySendError::Full(job) | TrySendError::Disconnected(job)) = jobs.try_send(job) {
                        found.push(self.replay_one(members, &job));
                    }
                }
            }
        }
        drop(jobs);
        found.extend(self.work(members, received));
        (lanes, found)
    }

    /// Replays kept jobs, each with its machine's index; returns the results of each machine.
    pub(crate) fn replay(
        &self,
        members: &[Member<'_>],
        jobs: Vec<(usize, CachedJob)>,
    ) -> Vec<Result<Vec<Found>, RunError>> {
        let jobs = Mutex::new(jobs.into_iter());
        let work = || {
            let next = || jobs.lock().unwrap_or_else(PoisonError::into_inner).next();
            let replay = |(index, job): (usize, CachedJob)| self.replay_one(members, &(index, job.unpack()));
            std::iter::from_fn(next).map(replay).collect::<Vec<_>>()
        };
        let found = thread::scope(|scope| {
            let workers: Vec<_> = (0..self.threads).map(|_| scope.spawn(work)).collect();
            workers.into_iter().flat_map(joined).collect()
        });
        in_order(found, members.len())
    }

    fn work(&self, members: &[Member<'_>], jobs: &Mutex<Receiver<ToReplay>>) -> Vec<Numbered> {
        let next = || jobs.lock().unwrap_or_else(PoisonError::into_inner).recv().ok();
        std::iter::from_fn(next).map(|job| self.replay_one(members, &job)).collect()
    }

    fn replay_one(&self, members: &[Member<'_>], (index, job): &ToReplay) -> Numbered {
        let machine = members[*index].machine;
        let machine = match &job.work {
            JobWork::End(_) => Cow::Borrowed(machine),
            // The frame's dynamic part is built already: its building is counted with the end of frame.
            JobWork::Window(_) => {
                let traffic = machine.traffic.without_build();
                Cow::Owned(MachineSpec { traffic, ..machine.clone() })
            }
        };
        (*index, job.number, job::replay(self.engine(&machine).as_mut(), &machine, job))
    }

    /// The statistics of a run that did nothing.
    pub(crate) fn nothing(&self, machine: &MachineSpec) -> MachineStats {
        self.engine(machine).tally(1).stats(machine)
    }

    /// A new engine of a machine.
    fn engine(&self, machine: &MachineSpec) -> Box<dyn Engine> {
        let engine = engine::engine(self.engine.into(), machine, self.header);
        engine.expect("all that replay samples have machines in motion")
    }
}

fn joined<T>(thread: ScopedJoinHandle<'_, T>) -> T {
    thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

/// The results of each of `machines` machines, in the order of its jobs.
fn in_order(mut found: Vec<Numbered>, machines: usize) -> Vec<Result<Vec<Found>, RunError>> {
    found.sort_by_key(|&(index, number, _)| (index, number));
    let mut all: Vec<Result<Vec<Found>, RunError>> = (0..machines).map(|_| Ok(Vec::new())).collect();
    for (index, _, one) in found {
        let of = &mut all[index];
        match (of.as_mut(), one) {
            (Ok(found), Ok(one)) => found.push(one),
            (Ok(_), Err(error)) => *of = Err(error),
            (Err(_), _) => {}
        }
    }
    all
}
