//! Cuts a stream into windows, and makes jobs of those that are measured.

use std::mem::take;
use std::ops::Range;
use std::sync::Arc;

use super::estimate::Population;
use super::known::{Capacity, Known};
use super::plan::Plan;
use super::tags::Tags;
use crate::machine::MachineSpec;
use crate::stream::{Chunk, Decision, FrameInfo, Header, Item, RayKind};

/// Rays that follow one another, and what is known of them.
#[derive(Clone, Debug, Default)]
pub struct Part {
    /// The rays.
    pub rays: Arc<Chunk>,
    /// What is known.
    pub known: Known,
}

/// What is to be replayed: by itself, behind caches that hold what `tags` do.
#[derive(Clone, Debug)]
pub struct Job {
    /// Its place among all jobs.
    pub number: usize,
    /// Which draw of its stratum it is.
    pub draw: usize,
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
    Window(Box<WindowWork>),
    /// The steps of a frame's end.
    End(Arc<Vec<u32>>),
}

/// A window and what is replayed beside it.
#[derive(Clone, Debug)]
pub struct WindowWork {
    /// Its stratum.
    pub stratum: usize,
    /// What comes before it, which fills what is in flight; less at a frame's beginning.
    pub before: Part,
    /// Its own rays.
    pub own: Part,
    /// What comes behind it, which keeps what is in flight full; less at a frame's end.
    pub behind: Part,
}

impl Job {
    /// What it takes in memory, about.
    pub fn bytes(&self) -> usize {
        let work = match &self.work {
            JobWork::Window(window) => {
                [&window.before, &window.own, &window.behind].iter().map(|part| part.rays.bytes()).sum()
            }
            JobWork::End(steps) => size_of_val(steps.as_slice()),
        };
        self.tags.bytes() + work
    }
}

/// Rays of a chunk.
#[derive(Clone, Debug)]
struct Piece {
    chunk: Arc<Chunk>,
    rays: Range<usize>,
    known: Known,
}

impl Part {
    fn of(pieces: &[Piece]) -> Self {
        let (mut rays, mut known) = (Chunk::default(), Known::default());
        for piece in pieces {
            known += piece.known;
            for ray in piece.rays.clone().map(|index| piece.chunk.ray(index)) {
                rays.push(ray.head, ray.packed_path(), ray.packed_policy());
            }
        }
        Self { rays: Arc::new(rays), known }
    }
}

/// A window that is being put together.
struct Open {
    window: usize,
    draw: usize,
    /// Pieces that come before the window's first one.
    lead: usize,
    tags: Tags,
    before: Vec<Piece>,
    own: Vec<Piece>,
    behind: Vec<Piece>,
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
    /// Windows of the stream up to now, and pieces of the frame.
    windows: usize,
    pieces: usize,
    /// Of each window, which draw of its stratum it is, of the first ones, which are of interest.
    drawn: Vec<Option<usize>>,
    most: usize,
    open: Vec<Open>,
    jobs: usize,
    /// All windows, frames' ends left out.
    pub population: Population,
    /// Rays, skipped ones not counted.
    pub rays: u64,
}

impl Windows {
    /// Nothing yet of a stream on a machine. Of each stratum the draws of `plan` become jobs, and later ones below `keep`.
    pub fn new(machine: &MachineSpec, header: &Header, plan: Plan, keep: usize) -> Self {
        Self {
            capacity: Capacity::new(machine),
            tags: Tags::new(header, machine),
            info: FrameInfo::default(),
            gathered: Vec::new(),
            pixels: 0,
            known: Known::default(),
            windows: 0,
            pieces: 0,
            drawn: Vec::new(),
            most: plan.draws.end.max(keep),
            open: Vec::new(),
            jobs: 0,
            population: Population::default(),
            rays: 0,
            plan,
        }
    }

    /// The next item of the stream; the jobs that are complete.
    pub fn add(&mut self, item: &Item) -> Vec<Job> {
        match item {
            Item::Frame(info) => {
                self.tags.begin_frame(info);
                (self.info, self.pieces) = (*info, 0);
                Vec::new()
            }
            Item::Rays(chunk) => {
                self.gathered.push(Arc::clone(chunk));
                let pixels = |chunk: &Arc<Chunk>| chunk.rays().filter(|ray| ray.head.kind == RayKind::Primary).count();
                self.pixels += pixels(chunk);
                if self.pixels < self.plan.cut.window() { Vec::new() } else { self.cut() }
            }
            Item::End { policy, .. } => {
                let mut jobs = self.cut();
                let open = take(&mut self.open).into_iter().filter(|open| !open.own.is_empty());
                jobs.extend(open.map(|open| self.job(open)));
                if !policy.is_empty() {
                    // All ends are replayed, by the first pass.
                    if self.plan.draws.start == 0 {
                        let (number, tags, work) = (self.jobs, self.tags.clone(), JobWork::End(Arc::clone(policy)));
                        jobs.push(Job { number, draw: 0, info: self.info, tags, work });
                        self.jobs += 1;
                    }
                    self.tags.frame_end(policy);
                }
                jobs
            }
        }
    }

    /// Which draw a window is, if it becomes a job.
    fn draw(&mut self, window: usize) -> Option<usize> {
        while self.drawn.len() <= window {
            self.drawn.extend(self.plan.drawn(self.drawn.len() / self.plan.stratum, self.most));
        }
        self.drawn[window].filter(|&draw| draw >= self.plan.draws.start)
    }

    /// Cuts the chunks that were gathered: one, or as many as make a window.
    fn cut(&mut self) -> Vec<Job> {
        self.pixels = 0;
        let gathered = take(&mut self.gathered);
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
        let cut = self.plan.cut;
        let windows = ((primaries.len() as f64 / cut.window() as f64).round() as usize).max(1);
        let pieces = (windows * cut.own).min(primaries.len());
        let firsts: Vec<u32> = (0..pieces).map(|piece| primaries[piece * primaries.len() / pieces]).collect();
        let mut jobs = Vec::new();
        for (piece, &first) in firsts.iter().enumerate() {
            let rays = first as usize..firsts.get(piece + 1).map_or(chunk.len(), |&end| end as usize);
            self.begin_windows(piece);
            let known = self.tags.piece(chunk, rays.clone());
            let part = Piece { chunk: Arc::clone(chunk), rays, known };
            self.known += known;
            let ends = piece + 1 == pieces || (piece + 1) % cut.own == 0;
            let mut complete = Vec::new();
            for (at, open) in self.open.iter_mut().enumerate() {
                let number = self.windows;
                let of = if open.lead > 0 {
                    open.lead -= 1;
                    &mut open.before
                } else if open.window == number {
                    &mut open.own
                } else {
                    &mut open.behind
                };
                of.push(part.clone());
                if open.behind.len() == cut.behind || cut.behind == 0 && open.window == number && ends {
                    complete.push(at);
                }
            }
            for at in complete.into_iter().rev() {
                let open = self.open.remove(at);
                jobs.push(self.job(open));
            }
            self.pieces += 1;
            if ends {
                let stratum = self.windows / self.plan.stratum;
                self.population.strata.resize(stratum + 1, 0);
                self.population.strata[stratum] += 1;
                self.population.add(&take(&mut self.known).columns(&self.capacity));
                self.windows += 1;
            }
        }
        jobs
    }

    /// Windows that are measured begin to be replayed some pieces before their first one, or with the frame; the next piece is number `piece`
    /// of its chunk.
    fn begin_windows(&mut self, piece: usize) {
        let cut = self.plan.cut;
        let left = (cut.own - piece % cut.own) % cut.own;
        let to_first = |window: usize| left + window * cut.own;
        let first = self.windows + usize::from(left > 0);
        let begin = (0..).take_while(|&window| to_first(window) <= cut.before);
        let begin = begin.filter(|&window| self.pieces == 0 || to_first(window) == cut.before);
        for (window, lead) in begin.map(|window| (first + window, to_first(window))).collect::<Vec<_>>() {
            if let Some(draw) = self.draw(window) {
                let (tags, before, own, behind) = (self.tags.clone(), Vec::new(), Vec::new(), Vec::new());
                self.open.push(Open { window, draw, lead, tags, before, own, behind });
            }
        }
    }

    fn job(&mut self, open: Open) -> Job {
        let Open { window, draw, tags, before, own, behind, .. } = open;
        let [before, own, behind] = [before, own, behind].map(|pieces| Part::of(&pieces));
        let window = WindowWork { stratum: window / self.plan.stratum, before, own, behind };
        self.jobs += 1;
        Job { number: self.jobs - 1, draw, info: self.info, tags, work: JobWork::Window(Box::new(window)) }
    }
}
