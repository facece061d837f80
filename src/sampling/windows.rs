//! Joins pieces to windows, and makes jobs of a machine's measured windows.

use std::mem::take;
use std::ops::Range;
use std::sync::Arc;

use super::covariates::{Capacity, Covariates};
use super::cutter::{CutPiece, Lead};
use super::estimate::Population;
use super::plan::Plan;
use super::strata::Point;
use super::window_rays::WindowRays;
use crate::engine::warm::WarmCaches;
use crate::machine::MachineSpec;
use crate::stream::{Chunk, FrameInfo, Header};

/// Consecutive rays and their covariates.
#[derive(Clone, Debug, Default)]
pub(crate) struct Part {
    /// The rays.
    pub rays: Arc<Chunk>,
    /// Their covariates.
    pub covariates: Covariates,
}

/// A replay by itself, on warm caches.
#[derive(Clone, Debug)]
pub(crate) struct Job {
    /// Index among the machine's jobs.
    pub number: usize,
    /// The lowest draw of its points.
    pub draw: usize,
    /// The frame.
    pub info: FrameInfo,
    /// The contents of the caches before it.
    pub warm: WarmCaches,
    /// What is measured.
    pub work: JobWork,
}

/// What a job measures.
#[derive(Clone, Debug)]
pub(crate) enum JobWork {
    /// A window.
    Window(Box<WindowWork>),
    /// An end of frame: its steps, and the building of the dynamic part, which no window includes.
    End(Arc<Vec<u32>>),
}

/// A window with its lead-in and tail.
#[derive(Clone, Debug)]
pub(crate) struct WindowWork {
    /// The points that lie in the window.
    pub hits: Vec<Point>,
    /// The lead-in, which fills the machine; shorter at a frame's beginning.
    pub before: Part,
    /// The window's rays.
    pub own: Part,
    /// The tail, which keeps the machine full; shorter at a frame's end.
    pub behind: Part,
    /// The rays of all three, shared by all machines.
    pub rays: Arc<WindowRays>,
}

impl WindowWork {
    /// Lead-in, window and tail.
    pub(super) fn parts_mut(&mut self) -> [&mut Part; 3] {
        [&mut self.before, &mut self.own, &mut self.behind]
    }
}

impl Job {
    /// Approximate bytes in memory.
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

/// Rays of a chunk and their covariates.
#[derive(Clone, Debug)]
struct Piece {
    chunk: Arc<Chunk>,
    rays: Range<usize>,
    covariates: Covariates,
}

/// The rays of pieces.
fn rays_of(pieces: &[Piece]) -> Chunk {
    let mut rays = Chunk::default();
    pieces.iter().for_each(|piece| rays.extend(&piece.chunk, piece.rays.clone()));
    rays
}

/// The covariates of pieces.
fn covariates_of(pieces: &[Piece]) -> Covariates {
    let mut covariates = Covariates::default();
    pieces.iter().for_each(|piece| covariates += piece.covariates);
    covariates
}

/// A window that is being joined.
struct Open {
    window: usize,
    /// Its points.
    hits: Vec<Point>,
    /// Pieces of the lead-in still to come.
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

/// Joins a machine's windows.
pub(super) struct Windows {
    plan: Plan,
    /// Windows whose lowest draw is not below `unwanted` do not become jobs.
    unwanted: usize,
    /// Whether the machine counts the building of a frame's dynamic part.
    builds: bool,
    capacity: Capacity,
    info: FrameInfo,
    /// Warm-up frames, and whether the current frame is one.
    warmup: Vec<u32>,
    warms_up: bool,
    /// Covariates of the current window so far.
    covariates: Covariates,
    /// Windows of the stream so far.
    windows: usize,
    open: Vec<Open>,
    jobs: usize,
    /// Covariates of all windows, without ends of frames.
    pub population: Population,
    /// Traced rays (skipped ones not counted).
    pub rays: u64,
}

impl Windows {
    /// A machine before the stream begins. Windows with points of `plan`, and of later draws below `unwanted`, become
    /// jobs.
    pub(super) fn new(machine: &MachineSpec, header: &Header, plan: Plan, unwanted: usize) -> Self {
        Self {
            unwanted,
            builds: machine.traffic != machine.traffic.without_build(),
            capacity: Capacity::new(machine),
            info: FrameInfo::default(),
            warmup: header.warmup.clone(),
            warms_up: false,
            covariates: Covariates::default(),
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

    /// Whether a window that begins may become a job, which needs the contents of the caches.
    pub(super) fn wants(&self, lead: &Lead) -> bool {
        let wanted = self.plan.draws.start..self.unwanted;
        lead.hits.iter().map(|hit| hit.draw).min().is_some_and(|draw| wanted.contains(&draw))
    }

    /// Whether a job is to be replayed now.
    pub(super) fn is_due(&self, job: &Job) -> bool {
        self.plan.draws.contains(&job.draw)
    }

    /// Whether an end of frame with these steps is replayed. The first pass replays all that have steps, and all
    /// frames' building.
    pub(super) fn wants_end(&self, steps: &[u32]) -> bool {
        (!steps.is_empty() || self.builds) && self.plan.draws.start == 0 && !self.warms_up
    }

    /// Adds the next piece and its covariates. `warm` is the contents of the caches before it, where a wanted window
    /// begins. Returns the completed jobs.
    pub(super) fn piece(&mut self, piece: &CutPiece, covariates: Covariates, warm: Option<&WarmCaches>) -> Vec<Job> {
        let CutPiece { chunk, rays, traced, begin, is_last } = piece;
        if let Some(warm) = warm {
            let begin: Vec<Lead> = begin.iter().filter(|lead| self.wants(lead)).cloned().collect();
            self.open.extend(begin.into_iter().map(|lead| Open::new(lead, warm.clone())));
        }
        let window = self.windows;
        self.covariates += covariates;
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
            of.push(Piece { chunk: Arc::clone(chunk), rays: rays.clone(), covariates });
            let behind = self.plan.cut.behind;
            if open.behind.len() == behind || behind == 0 && open.window == window && *is_last {
                complete.push(at);
            }
        }
        let complete: Vec<Open> = complete.into_iter().rev().map(|at| self.open.remove(at)).collect();
        complete.into_iter().map(|open| self.job(open)).collect()
    }

    /// Ends a frame with these steps. `warm` is the contents of the caches, where they are wanted. Returns the
    /// completed jobs.
    pub(super) fn end(&mut self, steps: &Arc<Vec<u32>>, warm: Option<WarmCaches>) -> Vec<Job> {
        // The lead-in of a window beyond the frame's end is dropped.
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
        let covariates = take(&mut self.covariates);
        if !self.warms_up {
            self.population.add(&covariates.columns(&self.capacity));
            self.population.windows += 1;
        }
        self.windows += 1;
    }

    /// The job of a joined window.
    fn job(&mut self, open: Open) -> Job {
        let Open { hits, rays, warm, before, own, behind, .. } = open;
        let draw = hits.iter().map(|hit| hit.draw).min().unwrap_or_default();
        let pieces = [before, own, behind];
        let chunks = rays.chunks(|| {
            let [before, mut own, behind] = pieces.each_ref().map(|pieces| rays_of(pieces));
            own.attribute();
            [before, own, behind]
        });
        let [before_rays, own_rays, behind_rays] = chunks;
        let [before, own, behind] = pieces.each_ref().map(|pieces| covariates_of(pieces));
        let part = |rays, covariates| Part { rays, covariates };
        let [before, own, behind] = [part(before_rays, before), part(own_rays, own), part(behind_rays, behind)];
        let work = JobWork::Window(Box::new(WindowWork { hits, before, own, behind, rays }));
        self.jobs += 1;
        Job { number: self.jobs - 1, draw, info: self.info, warm, work }
    }
}
