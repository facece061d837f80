//! Jobs that may be wanted once it is known how much windows differ: they are kept, as far as memory allows, so that the stream need not be read
//! again; and done, as far as threads have nothing else to do.

use std::ops::Range;

use super::job::Numbered;
use super::windows::Job;

/// Bytes of jobs that are kept at most.
const MOST_BYTES: usize = 1 << 30;

/// The jobs of some draws of all strata.
#[derive(Default)]
pub struct Kept {
    draws: Range<usize>,
    jobs: Vec<Job>,
    bytes: usize,
    /// Draws, and what was found.
    done: Vec<(usize, Numbered)>,
}

impl Kept {
    /// Nothing yet of these draws.
    pub fn new(draws: Range<usize>) -> Self {
        Self { draws, ..Self::default() }
    }

    /// Keeps `job`. Where memory does not allow for all draws, the last ones go.
    pub fn add(&mut self, job: Job) {
        if self.draws.contains(&job.draw) {
            self.bytes += job.bytes();
            self.jobs.push(job);
        }
        while self.bytes > MOST_BYTES && !self.draws.is_empty() {
            self.draws.end -= 1;
            drop(self.take_from(self.draws.end));
        }
    }

    /// Whether there is anything to do.
    pub fn has_jobs(&self) -> bool {
        !self.jobs.is_empty()
    }

    /// Takes out the job that is the likeliest to be wanted.
    pub fn pop(&mut self) -> Option<Job> {
        let next = (0..self.jobs.len()).min_by_key(|&at| (self.jobs[at].draw, self.jobs[at].number))?;
        let job = self.jobs.swap_remove(next);
        self.bytes -= job.bytes();
        Some(job)
    }

    /// A job that was taken out is done.
    pub fn done(&mut self, draw: usize, found: Numbered) {
        self.done.push((draw, found));
    }

    /// The jobs of `draws`, those that are done apart, if all of them were kept.
    pub fn take(&mut self, draws: &Range<usize>) -> Option<(Vec<Job>, Vec<Numbered>)> {
        if draws.start != self.draws.start || draws.end > self.draws.end {
            return None;
        }
        let later = self.take_from(draws.end);
        self.draws.start = draws.end;
        self.bytes = later.iter().map(Job::bytes).sum();
        let jobs = std::mem::replace(&mut self.jobs, later);
        let (done, later) = std::mem::take(&mut self.done).into_iter().partition(|(draw, _)| *draw < draws.end);
        self.done = later;
        let done: Vec<(usize, Numbered)> = done;
        Some((jobs, done.into_iter().map(|(_, found)| found).collect()))
    }

    /// Takes out the jobs of draw `first` and later ones.
    fn take_from(&mut self, first: usize) -> Vec<Job> {
        let (taken, left) = std::mem::take(&mut self.jobs).into_iter().partition(|job| job.draw >= first);
        self.jobs = left;
        self.bytes = self.jobs.iter().map(Job::bytes).sum();
        taken
    }
}
