//! Cuts a stream into windows, and makes jobs of those that are measured.

use std::ops::Range;
use std::sync::Arc;

use super::estimate::Population;
use super::known::{Capacity, Known};
use super::plan::{PIECES, Plan};
use super::tags::Tags;
use crate::machine::MachineSpec;
use crate::stream::{Chunk, Decision, FrameInfo, Header, Item, RayKind};

/// A part of a window: rays of a chunk.
#[derive(Clone, Debug)]
pub struct Piece {
    /// The chunk.
    pub chunk: Arc<Chunk>,
    /// Which rays.
    pub rays: Range<usize>,
    /// What is known of them.
    pub known: Known,
}

/// What is to be replayed: by itself, behind caches that hold what `tags` do.
#[derive(Clone, Debug)]
pub struct Job {
    /// Its place among all jobs.
    pub number: usize,
    /// The frame.
    pub info: FrameInfo,
    /// What the caches hold.
    pub tags: Tags,
    /// What is measured.
    pub work: JobWork,
}

/// What a job measures.
#[derive(Clone, Debug)]
pub enum JobWork {
    /// A window.
    Window {
        /// Its stratum.
        stratum: usize,
        /// The piece before it, which fills what is in flight; none at a frame's beginning.
        before: Vec<Piece>,
        /// Its own.
        pieces: Vec<Piece>,
        /// The piece behind it, which keeps what is in flight full; none at a frame's end.
        behind: Vec<Piece>,
    },
    /// The steps of a frame's end.
    End(Arc<Vec<u32>>),
}

/// A window that is being put together.
struct Open {
    window: usize,
    tags: Tags,
    before: Vec<Piece>,
    pieces: Vec<Piece>,
}

/// Cuts a stream.
pub struct Windows {
    plan: Plan,
    capacity: Capacity,
    tags: Tags,
    info: FrameInfo,
    /// Chunks that are not cut yet, and their pixels.
    gathered: Vec<Arc<Chunk>>,
    pixels: usize,
    /// What is known of the window up to now.
    known: Known,
    /// Windows of the stream up to now, and up to which one it is known where they begin to be replayed.
    windows: usize,
    opened: usize,
    measures: Vec<bool>,
    open: Vec<Open>,
    jobs: usize,
    /// All windows, frames' ends left out.
    pub population: Population,
    /// Rays, skipped ones not counted.
    pub rays: u64,
}

impl Windows {
    /// Nothing yet of a stream on a machine.
    pub fn new(machine: &MachineSpec, header: &Header, plan: Plan) -> Self {
        Self {
            plan,
            capacity: Capacity::new(machine),
            tags: Tags::new(header, machine),
            info: FrameInfo::default(),
            gathered: Vec::new(),
            pixels: 0,
            known: Known::default(),
            windows: 0,
            opened: 0,
            measures: Vec::new(),
            open: Vec::new(),
            jobs: 0,
            population: Population::default(),
            rays: 0,
        }
    }

    /// The next item of the stream; the jobs that are complete.
    pub fn add(&mut self, item: &Item) -> Vec<Job> {
        match item {
            Item::Frame(info) => {
                self.tags.begin_frame(info);
                (self.info, self.opened) = (*info, self.windows);
                Vec::new()
            }
            Item::Rays(chunk) => {
                self.gathered.push(Arc::clone(chunk));
                let pixels = |chunk: &Arc<Chunk>| chunk.rays().filter(|ray| ray.head.kind == RayKind::Primary).count();
                self.pixels += pixels(chunk);
                if self.pixels < self.plan.pixels { Vec::new() } else { self.cut() }
            }
            Item::End { policy, .. } => {
                let mut jobs = self.cut();
                let open = std::mem::take(&mut self.open).into_iter().filter(|open| !open.pieces.is_empty());
                jobs.extend(open.map(|open| self.job(open, Vec::new())));
                if !policy.is_empty() {
                    let (info, tags, work) = (self.info, self.tags.clone(), JobWork::End(Arc::clone(policy)));
                    jobs.push(Job { number: self.jobs, info, tags, work });
                    self.jobs += 1;
                    self.tags.frame_end(policy);
                }
                jobs
            }
        }
    }

    fn measures(&mut self, window: usize) -> bool {
        while self.measures.len() <= window {
            self.measures.extend(self.plan.measures(self.measures.len() / self.plan.stratum));
        }
        self.measures[window]
    }

    /// Cuts the chunks that were gathered: one, or as many as make a window.
    fn cut(&mut self) -> Vec<Job> {
        self.pixels = 0;
        let gathered = std::mem::take(&mut self.gathered);
        match gathered.as_slice() {
            [] => Vec::new(),
            [chunk] => self.chunk(chunk),
            chunks => {
                let mut all = Chunk::default();
                let rays = chunks.iter().flat_map(|chunk| chunk.rays());
                rays.for_each(|ray| all.push(ray.head, ray.packed_path(), ray.packed_policy()));
                self.chunk(&Arc::new(all))
            }
        }
    }

    fn chunk(&mut self, chunk: &Arc<Chunk>) -> Vec<Job> {
        let primaries: Vec<u32> =
            (0..chunk.len()).filter(|&ray| chunk.head(ray).kind == RayKind::Primary).map(|ray| ray as u32).collect();
        let traced = |&ray: &usize| chunk.head(ray).decision != Decision::Skip;
        self.rays += (0..chunk.len()).filter(traced).count() as u64;
        // Whole windows of about the same number of pixels.
        let windows = ((primaries.len() as f64 / self.plan.pixels as f64).round() as usize).max(1);
        let pieces = (windows * PIECES).min(primaries.len());
        let firsts: Vec<u32> = (0..pieces).map(|piece| primaries[piece * primaries.len() / pieces]).collect();
        let place = |piece: usize| (piece * windows / pieces, (piece + 1) * windows / pieces);
        // A window begins to be replayed with the piece before it, where there is one and it does not begin with another.
        let opens: Vec<Option<usize>> = (0..pieces)
            .map(|piece| {
                let (window, next) = place(piece);
                let number = self.windows + window;
                let chosen = if self.opened <= number { number } else { number + 1 };
                if chosen > number && next == window {
                    return None;
                }
                self.opened = chosen + 1;
                self.measures(chosen).then_some(chosen)
            })
            .collect();
        let mut jobs = Vec::new();
        for (piece, &first) in firsts.iter().enumerate() {
            let rays = first as usize..firsts.get(piece + 1).map_or(chunk.len(), |&end| end as usize);
            let tags = opens[piece].map(|_| self.tags.clone());
            let known = self.tags.piece(chunk, rays.clone());
            let part = Piece { chunk: Arc::clone(chunk), rays, known };
            self.known += known;
            let (window, next) = place(piece);
            let number = self.windows + window;
            // The piece is behind one window, in a second, and before a third.
            if let Some(done) = self.open.iter().position(|open| open.window < number && !open.pieces.is_empty()) {
                let open = self.open.remove(done);
                jobs.push(self.job(open, vec![part.clone()]));
            }
            if let (Some(tags), Some(window)) = (tags, opens[piece]) {
                let before = if window == number { Vec::new() } else { vec![part.clone()] };
                self.open.push(Open { window, tags, before, pieces: Vec::new() });
            }
            if let Some(open) = self.open.iter_mut().find(|open| open.window == number) {
                open.pieces.push(part);
            }
            if next > window {
                let stratum = number / self.plan.stratum;
                self.population.strata.resize(stratum + 1, 0);
                self.population.strata[stratum] += 1;
                self.population.add(&std::mem::take(&mut self.known).columns(&self.capacity));
            }
        }
        self.windows += windows.min(pieces);
        jobs
    }

    fn job(&mut self, open: Open, behind: Vec<Piece>) -> Job {
        let Open { window, tags, before, pieces } = open;
        let work = JobWork::Window { stratum: window / self.plan.stratum, before, pieces, behind };
        self.jobs += 1;
        Job { number: self.jobs - 1, info: self.info, tags, work }
    }
}
