//! Cuts a stream into windows, and makes jobs of those that are measured.

use std::mem::take;
use std::ops::Range;
use std::sync::Arc;

use super::axis::{Axis, Hit};
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
    /// The first of the points that lie in it.
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
    /// How long it is on the axis.
    pub size: f64,
    /// The points that lie in it.
    pub hits: Vec<Hit>,
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
    /// Pieces, whose rays are marked if they are of the window itself.
    fn of(pieces: &[Piece], is_own: bool) -> Self {
        let (mut rays, mut known) = (Chunk::default(), Known::default());
        if is_own {
            rays.mark();
        }
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
    /// How long it is and its points, once they are known.
    size: f64,
    hits: Vec<Hit>,
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
    axis: Axis,
    open: Vec<Open>,
    jobs: usize,
    /// All windows, frames' ends left out.
    pub population: Population,
    /// Rays, skipped ones not counted.
    pub rays: u64,
}

impl Windows {
    /// Nothing yet of a stream on a machine. Windows with points of `plan` become jobs, and those with later ones below `keep`.
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
            axis: Axis::new(plan.clone(), plan.draws.end.max(keep)),
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
                (self.population.strata, self.population.windows) = (self.axis.strata(), self.axis.windows());
                let open = take(&mut self.open);
                jobs.extend(open.into_iter().filter_map(|open| self.job(open)));
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
            let window = self.windows;
            let ends = piece + 1 == pieces || (piece + 1) % cut.own == 0;
            if ends {
                self.end_window();
            }
            let mut complete = Vec::new();
            for (at, open) in self.open.iter_mut().enumerate() {
                let of = if open.lead > 0 {
                    open.lead -= 1;
                    &mut open.before
                } else if open.window == window {
                    &mut open.own
                } else {
                    &mut open.behind
                };
                of.push(part.clone());
                if open.behind.len() == cut.behind || cut.behind == 0 && open.window == window && ends {
                    complete.push(at);
                }
            }
            for at in complete.into_iter().rev() {
                let open = self.open.remove(at);
                jobs.extend(self.job(open));
            }
            self.pieces += 1;
        }
        jobs
    }

    /// It is known how long the window is, and which points lie in it: without any, it need not be kept.
    fn end_window(&mut self) {
        let known = take(&mut self.known).columns(&self.capacity);
        let (size, hits) = self.axis.next(&known);
        let begin = self.plan.draws.start;
        let is_done = hits.iter().any(|hit| hit.draw < begin);
        let window = self.windows;
        if hits.is_empty() || is_done {
            self.open.retain(|open| open.window != window);
        } else if let Some(open) = self.open.iter_mut().find(|open| open.window == window) {
            (open.size, open.hits) = (size, hits);
        }
        self.population.add(&known);
        self.windows += 1;
    }

    /// Windows begin to be put together some pieces before their first one, or with the frame; the next piece is number `piece` of its chunk.
    fn begin_windows(&mut self, piece: usize) {
        let cut = self.plan.cut;
        let left = (cut.own - piece % cut.own) % cut.own;
        let to_first = |window: usize| left + window * cut.own;
        let first = self.windows + usize::from(left > 0);
        let begin = (0..).take_while(|&window| to_first(window) <= cut.before);
        let begin = begin.filter(|&window| self.pieces == 0 || to_first(window) == cut.before);
        for (window, lead) in begin.map(|window| (first + window, to_first(window))) {
            let tags = self.tags.clone();
            let (before, own, behind) = (Vec::new(), Vec::new(), Vec::new());
            self.open.push(Open { window, size: 0.0, hits: Vec::new(), lead, tags, before, own, behind });
        }
    }

    /// A job of a window that was put together, if it has points.
    fn job(&mut self, open: Open) -> Option<Job> {
        let Open { size, hits, tags, before, own, behind, .. } = open;
        let draw = hits.iter().map(|hit| hit.draw).min()?;
        let [before, own, behind] =
            [(before, false), (own, true), (behind, false)].map(|(pieces, is_own)| Part::of(&pieces, is_own));
        let work = JobWork::Window(Box::new(WindowWork { size, hits, before, own, behind }));
        self.jobs += 1;
        Some(Job { number: self.jobs - 1, draw, info: self.info, tags, work })
    }
}
