//! Jobs that may be wanted once it is known how much windows differ: they are kept, as far as memory allows, so that
//! the stream need not be read again.

use std::ops::Range;
use std::sync::Arc;

use super::windows::Job;
use crate::stream::{Chunk, PackedChunk};

/// A job whose rays are packed.
#[derive(Clone, Debug)]
pub(crate) struct KeptJob {
    job: Job,
    rays: Vec<PackedChunk>,
}

impl KeptJob {
    fn new(mut job: Job) -> Self {
        let rays =
            job.rays_mut().into_iter().map(|rays| PackedChunk::new(&std::mem::take::<Arc<Chunk>>(rays))).collect();
        Self { job, rays }
    }

    /// The job.
    pub(crate) fn unpack(self) -> Job {
        let Self { mut job, rays } = self;
        job.rays_mut().into_iter().zip(&rays).for_each(|(place, rays)| *place = Arc::new(rays.unpack()));
        job
    }

    fn bytes(&self) -> usize {
        self.job.bytes() + self.rays.iter().map(PackedChunk::bytes).sum::<usize>()
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
}

impl Kept {
    /// Nothing yet of these draws, which may take so many bytes.
    pub(crate) fn new(draws: Range<usize>, most: usize) -> Self {
        Self { draws, most, ..Self::default() }
    }

    /// Keeps `job`. Where memory does not allow for all draws, the last ones go.
    pub(crate) fn add(&mut self, job: Job) {
        if self.draws.contains(&job.draw) {
            let job = KeptJob::new(job);
            self.bytes += job.bytes();
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
        self.bytes = later.iter().map(KeptJob::bytes).sum();
        Some(std::mem::replace(&mut self.jobs, later))
    }

    /// Takes out the jobs of draw `first` and later ones.
    fn take_from(&mut self, first: usize) -> Vec<KeptJob> {
        let (taken, left) = std::mem::take(&mut self.jobs).into_iter().partition(|kept| kept.job.draw >= first);
        self.jobs = left;
        self.bytes = self.jobs.iter().map(KeptJob::bytes).sum();
        taken
    }
}
