//! Jobs of points that a larger sample may need. They are kept as far as memory allows, so that the stream need not be
//! read again.

use std::mem::take;
use std::ops::Range;
use std::sync::Arc;

use super::window_rays::PackedRays;
use super::windows::{Job, JobWork};
use crate::stream::Chunk;

/// A job; the rays of a window are packed.
#[derive(Clone, Debug)]
pub(crate) struct CachedJob {
    job: Job,
    rays: Option<Arc<PackedRays>>,
}

impl CachedJob {
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

    /// Approximate bytes, where `machines` share the rays of the window.
    fn bytes(&self, machines: usize) -> usize {
        self.job.bytes() + self.rays.as_ref().map_or(0, |rays| rays.bytes() / machines)
    }
}

/// The jobs of a range of draws of all strata.
#[derive(Clone, Debug, Default)]
pub(crate) struct JobCache {
    draws: Range<usize>,
    jobs: Vec<CachedJob>,
    bytes: usize,
    /// Maximum bytes.
    most: usize,
    /// Machines on the pass.
    machines: usize,
}

impl JobCache {
    /// An empty store for these draws. The `machines` of the pass together may take `most` bytes.
    pub(crate) fn new(draws: Range<usize>, most: usize, machines: usize) -> Self {
        Self { draws, most: most / machines, machines, ..Self::default() }
    }

    /// Keeps `job`. Where memory is short, the jobs of the last draws are dropped.
    pub(crate) fn add(&mut self, job: Job) {
        if self.draws.contains(&job.draw) {
            let job = CachedJob::new(job);
            self.bytes += job.bytes(self.machines);
            self.jobs.push(job);
        }
        while self.bytes > self.most && !self.draws.is_empty() {
            self.draws.end -= 1;
            drop(self.take_from(self.draws.end));
        }
    }

    /// The jobs of `draws`; `None` unless all of them were kept.
    pub(crate) fn take(&mut self, draws: &Range<usize>) -> Option<Vec<CachedJob>> {
        if draws.start != self.draws.start || draws.end > self.draws.end {
            return None;
        }
        let later = self.take_from(draws.end);
        self.draws.start = draws.end;
        self.bytes = self.bytes_of(&later);
        Some(std::mem::replace(&mut self.jobs, later))
    }

    fn bytes_of(&self, jobs: &[CachedJob]) -> usize {
        jobs.iter().map(|job| job.bytes(self.machines)).sum()
    }

    /// Removes the jobs with draws from `first` on.
    fn take_from(&mut self, first: usize) -> Vec<CachedJob> {
        let (taken, left) = take(&mut self.jobs).into_iter().partition(|cached| cached.job.draw >= first);
        self.jobs = left;
        self.bytes = self.bytes_of(&self.jobs);
        taken
    }
}
