//! What waits to be replayed, between the thread that cuts the stream and those that replay: jobs that are wanted, and, for who has nothing else to do,
//! jobs that may be wanted later.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use super::job::Numbered;
use super::kept::Kept;
use super::windows::Job;

/// Wanted jobs that may wait, which hold the tags of a machine each.
const WANTED: usize = 2;

/// The queue.
pub struct Queue {
    state: Mutex<State>,
    changed: Condvar,
}

struct State {
    wanted: VecDeque<Job>,
    kept: Kept,
    is_open: bool,
    workers: usize,
}

/// A job to do.
pub struct Task {
    /// The job.
    pub job: Job,
    /// Whether it may not be wanted.
    pub is_ahead: bool,
}

/// Who takes jobs: as long as there is someone, others wait for places.
pub struct Worker<'a>(&'a Queue);

impl Queue {
    /// An empty queue, with jobs for later in `kept`.
    pub fn new(kept: Kept) -> Self {
        let state = State { wanted: VecDeque::new(), kept, is_open: true, workers: 0 };
        Self { state: Mutex::new(state), changed: Condvar::new() }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Puts a job in, once there is a place. Should all workers have panicked, which comes out when they are joined, nobody waits.
    pub fn put(&self, job: Job, is_wanted: bool) {
        let mut state = self.state();
        if is_wanted {
            let is_full = |state: &mut State| state.wanted.len() >= WANTED && state.workers > 0;
            state = self.changed.wait_while(state, is_full).unwrap_or_else(PoisonError::into_inner);
            state.wanted.push_back(job);
        } else {
            state.kept.add(job);
        }
        self.changed.notify_all();
    }

    /// No more jobs come.
    pub fn close(&self) {
        self.state().is_open = false;
        self.changed.notify_all();
    }

    /// Someone who takes jobs.
    pub fn worker(&self) -> Worker<'_> {
        self.state().workers += 1;
        Worker(self)
    }

    /// The jobs for later.
    pub fn into_kept(self) -> Kept {
        self.state.into_inner().unwrap_or_else(PoisonError::into_inner).kept
    }
}

impl Worker<'_> {
    /// The next job; none when all wanted ones are taken and no more come.
    pub fn next(&self) -> Option<Task> {
        let nothing = |state: &mut State| state.wanted.is_empty() && state.is_open && !state.kept.has_jobs();
        let state = self.0.changed.wait_while(self.0.state(), nothing);
        let mut state = state.unwrap_or_else(PoisonError::into_inner);
        let task = match state.wanted.pop_front() {
            Some(job) => Some(Task { job, is_ahead: false }),
            None if state.is_open => state.kept.pop().map(|job| Task { job, is_ahead: true }),
            None => None,
        };
        self.0.changed.notify_all();
        task
    }

    /// A job was done that may not be wanted.
    pub fn done_ahead(&self, draw: usize, found: Numbered) {
        self.0.state().kept.done(draw, found);
    }
}

impl Drop for Worker<'_> {
    fn drop(&mut self) {
        self.0.state().workers -= 1;
        self.0.changed.notify_all();
    }
}
