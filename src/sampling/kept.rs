//! Jobs that may be wanted once it is known how much windows differ: they are kept, as far as memory allows, so that
//! the stream need not be read again.

use std::mem::take;
use std::ops::Range;
use std::sync::Arc;

use super::window_rays::PackedRays;
use super::windows::{Job, JobWork};
use crate::stream::Chunk;

/// A job whose rays are packed, if it has some.
#[derive(Clone, Debug)]
pub(crate) struct KeptJob {
    job: Job,
    rays: Option<Arc<PackedRays>>,
}

impl KeptJob {
    fn new(mut job: Job) -> Self {
        let rays = match &mut job.work {
            JobWork::Window(window) => {
                let shared = take(&mut window.rays);
                let chunks = window.parts_mut().map(|part| take::<Arc<Chunk>>(&mut part.rays));
                Some(shared.packed(chunks.each_ref().map(|chunk| chunk.as_ref())))
            }
            JobWork::End(_) => None,
        };
        Self { job, rays }
    }

    /// The job.
    pub(crate) fn unpack(self) -> Job {
        let Self { mut job, rays } = self;
        if let (JobWork::Window(window), Some(rays)) = (&mut job.work, rays) {
            window.parts_mut().into_iter().zip(rays.unpack()).for_each(|(part, rays)| part.rays = rays);
        }
        job
    }

    /// What it takes in memory, about, where so many machines have the rays of its window in common.
    fn bytes(&self, machines: usize) -> usize {
        self.job.bytes() + self.rays.as_ref().map_or(0, |rays| rays.bytes() / machines)
    }
}

/// The jobs of some draws of all strata.
#[derive(Clone, Debug, Default)]
pub(crate) struct Kept {
    draws: Range<usize>,
    jobs: Vec<KeptJob>,
    bytes: usize,
    /// Bytes at most.
    most: usize,
    /// Machines on the pass.
    machines: usize,
}

impl Kept {
    /// Nothing yet of these draws, on a pass of so many machines, which all together may take `most` bytes.
    pub(crate) fn new(draws: Range<usize>, most: usize, machines: usize) -> Self {
        Self { draws, most: most / machines, machines, ..Self::default() }
    }

    /// Keeps `job`. Where memory does not allow for all draws, the last ones go.
    pub(crate) fn add(&mut self, job: Job) {
        if self.draws.contains(&job.draw) {
            let job = KeptJob::new(job);
            self.bytes += job.bytes(self.machines);
            self.jobs.push(job);
        }
        while self.bytes > self.most && !self.draws.is_empty() {
            self.draws.end -= 1;
            drop(self.take_from(self.draws.end));
        }
    }

    /// The jobs of `draws`, if all of them were kept.
    pub(crate) fn take(&mut self, draws: &Range<usize>) -> Option<Vec<KeptJob>> {
        if draws.start != self.draws.start || draws.end > self.draws.end {
            return None;
        }
        let later = self.take_from(draws.end);
        self.draws.start = draws.end;
        self.bytes = self.bytes_of(&later);
        Some(std::mem::replace(&mut self.jobs, later))
    }

    fn bytes_of(&self, jobs: &[KeptJob]) -> usize {
        jobs.iter().map(|job| job.bytes(self.machines)).sum()
    }

    /// Takes out the jobs of draw `first` and later ones.
    fn take_from(&mut self, first: usize) -> Vec<KeptJob> {
        let (taken, left) = take(&mut self.jobs).into_iter().partition(|kept| kept.job.draw >= first);
        self.jobs = left;
        self.bytes = self.bytes_of(&self.jobs);
        taken
    }
}
