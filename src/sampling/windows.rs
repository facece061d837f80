//! Puts windows together of pieces, and makes jobs of those that are measured on a machine.

use std::mem::take;
use std::ops::Range;
use std::sync::Arc;

use super::cutter::{CutPiece, Lead};
use super::estimate::Population;
use super::known::{Capacity, Known};
use super::plan::Plan;
use super::strata::Point;
use super::window_rays::WindowRays;
use crate::engine::warm::WarmCaches;
use crate::machine::MachineSpec;
use crate::stream::{Chunk, FrameInfo, Header};

/// Rays that follow one another, and what is known of them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Part {
    /// The rays.
    pub rays: Arc<Chunk>,
    /// What is known.
    pub known: Known,
}

/// What is to be replayed: by itself, behind warm caches.
#[derive(Clone, Debug)]
pub(crate) struct Job {
    /// Its place among all jobs.
    pub number: usize,
    /// The first of the points that lie in it.
    pub draw: usize,
    /// The frame.
    pub info: FrameInfo,
    /// What the caches hold.
    pub warm: WarmCaches,
    /// What is measured.
    pub work: JobWork,
}

/// What a job measures.
#[derive(Clone, Debug)]
pub(crate) enum JobWork {
    /// A window.
    Window(Box<WindowWork>),
    /// The steps of a frame's end, and the building of its dynamic part, which no window does.
    End(Arc<Vec<u32>>),
}

/// A window and what is replayed beside it.
#[derive(Clone, Debug)]
pub(crate) struct WindowWork {
    /// The points that lie in it.
    pub hits: Vec<Point>,
    /// What comes before it, which fills what is in flight; less at a frame's beginning.
    pub before: Part,
    /// Its own rays.
    pub own: Part,
    /// What comes behind it, which keeps what is in flight full; less at a frame's end.
    pub behind: Part,
    /// The rays of all three, as all machines share them.
    pub rays: Arc<WindowRays>,
}

impl WindowWork {
    /// The three, in order.
    pub(super) fn parts_mut(&mut self) -> [&mut Part; 3] {
        [&mut self.before, &mut self.own, &mut self.behind]
    }
}

impl Job {
    /// What it takes in memory, about.
    pub(crate) fn bytes(&self) -> usize {
        let work = match &self.work {
            JobWork::Window(window) => {
                [&window.before, &window.own, &window.behind].iter().map(|part| part.rays.bytes()).sum()
            }
            JobWork::End(steps) => size_of_val(steps.as_slice()),
        };
        self.warm.bytes() + work
    }
}

/// Rays of a chunk, and what is known of them.
#[derive(Clone, Debug)]
struct Piece {
    chunk: Arc<Chunk>,
    rays: Range<usize>,
    known: Known,
}

/// The rays of pieces.
fn rays_of(pieces: &[Piece]) -> Chunk {
    let mut rays = Chunk::default();
    pieces.iter().for_each(|piece| rays.extend(&piece.chunk, piece.rays.clone()));
    rays
}

/// What is known of pieces.
fn known_of(pieces: &[Piece]) -> Known {
    let mut known = Known::default();
    pieces.iter().for_each(|piece| known += piece.known);
    known
}

/// A window that is being put together.
struct Open {
    window: usize,
    /// Its points.
    hits: Vec<Point>,
    /// Pieces that come before the window's first one.
    lead: usize,
    rays: Arc<WindowRays>,
    warm: WarmCaches,
    before: Vec<Piece>,
    own: Vec<Piece>,
    behind: Vec<Piece>,
}

impl Open {
    fn new(Lead { window, pieces: lead, hits, rays }: Lead, warm: WarmCaches) -> Self {
        let (before, own, behind) = (Vec::new(), Vec::new(), Vec::new());
        Self { window, hits, lead, rays, warm, before, own, behind }
    }
}

/// Puts a machine's windows together.
pub(super) struct Windows {
    plan: Plan,
    /// Windows whose first point is of this draw or a later one do not become jobs.
    unwanted: usize,
    /// Whether a frame's dynamic part is built when it begins.
    builds: bool,
    capacity: Capacity,
    info: FrameInfo,
    /// Frames that warm the tags alone, and whether this is one.
    warmup: Vec<u32>,
    warms_up: bool,
    /// What is known of the window up to now.
    known: Known,
    /// Windows of the stream up to now.
    windows: usize,
    open: Vec<Open>,
    jobs: usize,
    /// All windows, frames' ends left out.
    pub population: Population,
    /// Rays, skipped ones not counted.
    pub rays: u64,
}

impl Windows {
    /// Nothing yet of a stream on a machine. Windows with points of `plan`, and of later draws below `unwanted`, become
    /// jobs.
    pub(super) fn new(machine: &MachineSpec, header: &Header, plan: Plan, unwanted: usize) -> Self {
        Self {
            unwanted,
            builds: machine.traffic != machine.traffic.without_build(),
            capacity: Capacity::new(machine),
            info: FrameInfo::default(),
            warmup: header.warmup.clone(),
            warms_up: false,
            known: Known::default(),
            windows: 0,
            open: Vec::new(),
            jobs: 0,
            population: Population { strata: plan.strata, ..Population::default() },
            rays: 0,
            plan,
        }
    }

    /// A frame begins.
    pub(super) fn frame(&mut self, info: FrameInfo) {
        self.info = info;
        self.warms_up = self.warmup.contains(&info.number);
    }

    /// Whether a window that begins is wanted: then it must be known what the caches hold.
    pub(super) fn wants(&self, lead: &Lead) -> bool {
        let wanted = self.plan.draws.start..self.unwanted;
        lead.hits.iter().map(|hit| hit.draw).min().is_some_and(|draw| wanted.contains(&draw))
    }

    /// Whether a job is to be replayed now.
    pub(super) fn is_due(&self, job: &Job) -> bool {
        self.plan.draws.contains(&job.draw)
    }

    /// Whether a frame's end with these steps is replayed: all are, by the first pass, and the building of all frames.
    pub(super) fn wants_end(&self, steps: &[u32]) -> bool {
        (!steps.is_empty() || self.builds) && self.plan.draws.start == 0 && !self.warms_up
    }

    /// The next piece, what is known of it, and what the caches held before it, if a window begins that is wanted; the
    /// jobs that are complete.
    pub(super) fn piece(&mut self, piece: &CutPiece, known: Known, warm: Option<&WarmCaches>) -> Vec<Job> {
        let CutPiece { chunk, rays, traced, begin, is_last } = piece;
        if let Some(warm) = warm {
            let begin: Vec<Lead> = begin.iter().filter(|lead| self.wants(lead)).cloned().collect();
            self.open.extend(begin.into_iter().map(|lead| Open::new(lead, warm.clone())));
        }
        let window = self.windows;
        self.known += known;
        if *is_last {
            self.end_window();
        }
        if !self.warms_up {
            self.rays += traced;
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
            of.push(Piece { chunk: Arc::clone(chunk), rays: rays.clone(), known });
            let behind = self.plan.cut.behind;
            if open.behind.len() == behind || behind == 0 && open.window == window && *is_last {
                complete.push(at);
            }
        }
        let complete: Vec<Open> = complete.into_iter().rev().map(|at| self.open.remove(at)).collect();
        complete.into_iter().map(|open| self.job(open)).collect()
    }

    /// A frame ends with these steps; what the caches hold, if that is wanted. The jobs that are complete.
    pub(super) fn end(&mut self, steps: &Arc<Vec<u32>>, warm: Option<WarmCaches>) -> Vec<Job> {
        // A window that was to begin may lie beyond the frame.
        let open = take(&mut self.open).into_iter().filter(|open| !open.own.is_empty());
        let mut jobs: Vec<Job> = open.map(|open| self.job(open)).collect();
        if let Some(warm) = warm.filter(|_| self.wants_end(steps)) {
            let work = JobWork::End(Arc::clone(steps));
            jobs.push(Job { number: self.jobs, draw: 0, info: self.info, warm, work });
            self.jobs += 1;
        }
        jobs
    }

    fn end_window(&mut self) {
        let known = take(&mut self.known);
        if !self.warms_up {
            self.population.add(&known.columns(&self.capacity));
            self.population.windows += 1;
        }
        self.windows += 1;
    }

    /// A job of a window that was put together.
    fn job(&mut self, open: Open) -> Job {
        let Open { hits, rays, warm, before, own, behind, .. } = open;
        let draw = hits.iter().map(|hit| hit.draw).min().unwrap_or_default();
        let pieces = [before, own, behind];
        let chunks = rays.chunks(|| {
            let [before, mut own, behind] = pieces.each_ref().map(|pieces| rays_of(pieces));
            own.mark();
            [before, own, behind]
        });
        let [before_rays, own_rays, behind_rays] = chunks;
        let [before, own, behind] = pieces.each_ref().map(|pieces| known_of(pieces));
        let part = |rays, known| Part { rays, known };
        let [before, own, behind] = [part(before_rays, before), part(own_rays, own), part(behind_rays, behind)];
        let work = JobWork::Window(Box::new(WindowWork { hits, before, own, behind, rays }));
        self.jobs += 1;
        Job { number: self.jobs - 1, draw, info: self.info, warm, work }
    }
}
