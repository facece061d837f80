//! Puts windows together of pieces, which it takes through the L2's tags, and makes jobs of those that are measured.

use std::mem::take;
use std::sync::Arc;

use super::axis::Axis;
use super::cutter::{CutPiece, FrameEnd, Lead, Piece, Portion};
use super::estimate::Population;
use super::known::{Capacity, Known};
use super::l2_tags::{L2Tags, Moved};
use super::plan::Plan;
use super::strata::Point;
use crate::engine::warm::WarmCaches;
use crate::machine::MachineSpec;
use crate::stream::{Chunk, Decision, FrameInfo, Header};

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
}

impl Job {
    /// The rays of a window and of what is beside it.
    pub(crate) fn rays_mut(&mut self) -> Vec<&mut Arc<Chunk>> {
        match &mut self.work {
            JobWork::Window(window) => {
                let WindowWork { before, own, behind, .. } = window.as_mut();
                vec![&mut before.rays, &mut own.rays, &mut behind.rays]
            }
            JobWork::End(_) => Vec::new(),
        }
    }

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

impl Part {
    /// Pieces, whose rays are marked if they are of the window itself.
    fn of(pieces: &[Piece], is_own: bool) -> Self {
        let (mut rays, mut known) = (Chunk::default(), Known::default());
        if is_own {
            rays.mark();
        }
        for piece in pieces {
            known += piece.known;
            rays.extend(&piece.chunk, piece.rays.clone());
        }
        Self { rays: Arc::new(rays), known }
    }
}

/// A window that is being put together.
struct Open {
    window: usize,
    /// Its points, once they are known.
    hits: Vec<Point>,
    /// Pieces that come before the window's first one.
    lead: usize,
    warm: WarmCaches,
    before: Vec<Piece>,
    own: Vec<Piece>,
    behind: Vec<Piece>,
}

impl Open {
    fn new(Lead { window, pieces: lead }: Lead, warm: WarmCaches) -> Self {
        let (before, own, behind) = (Vec::new(), Vec::new(), Vec::new());
        Self { window, hits: Vec::new(), lead, warm, before, own, behind }
    }
}

/// Puts windows together.
pub(super) struct Windows {
    plan: Plan,
    /// Whether a frame's dynamic part is built when it begins.
    builds: bool,
    capacity: Capacity,
    tags: L2Tags,
    info: FrameInfo,
    /// Frames that warm the tags alone, and whether this is one.
    warmup: Vec<u32>,
    warms_up: bool,
    /// What is known of the window up to now.
    known: Known,
    /// Windows of the stream up to now.
    windows: usize,
    axis: Axis,
    open: Vec<Open>,
    jobs: usize,
    /// Windows whose first point is of this draw or a later one do not become jobs.
    unwanted: usize,
    /// All windows, frames' ends left out.
    pub population: Population,
    /// Rays, skipped ones not counted.
    pub rays: u64,
}

impl Windows {
    /// Nothing yet of a stream on a machine. Points below `keep` are known; windows with those of `plan`, and of later
    /// draws below `unwanted`, become jobs.
    pub(super) fn new(machine: &MachineSpec, header: &Header, plan: Plan, keep: usize, unwanted: usize) -> Self {
        Self {
            builds: machine.traffic != machine.traffic.without_build(),
            capacity: Capacity::new(machine),
            tags: L2Tags::new(header, machine),
            info: FrameInfo::default(),
            warmup: header.warmup.clone(),
            warms_up: false,
            known: Known::default(),
            windows: 0,
            axis: Axis::new(plan.strata, plan.draws.end.max(keep)),
            open: Vec::new(),
            jobs: 0,
            unwanted,
            population: Population { strata: plan.strata, ..Population::default() },
            rays: 0,
            plan,
        }
    }

    /// The next portion of the stream; the jobs that are complete.
    pub(super) fn add(&mut self, portion: Portion) -> Vec<Job> {
        match portion {
            Portion::Frame(info) => {
                self.tags.begin_frame();
                self.info = info;
                self.warms_up = self.warmup.contains(&info.number);
                Vec::new()
            }
            Portion::Piece(piece) => self.piece(*piece),
            Portion::End(end) => self.end(end),
        }
    }

    fn piece(&mut self, CutPiece { mut piece, requests, begin, l1s, is_last }: CutPiece) -> Vec<Job> {
        if let Some(l1s) = l1s {
            let warm = WarmCaches::new(l1s, self.tags.snapshot());
            self.open.extend(begin.into_iter().map(|lead| Open::new(lead, warm.clone())));
        }
        let Moved { dram, bank } = self.tags.pass(&requests);
        // Of the host's own lines it is known already.
        piece.known.dram.iter_mut().zip(dram).for_each(|(known, lines)| *known += lines);
        piece.known.bank = bank;
        let traced = |&ray: &usize| piece.chunk.head(ray).decision != Decision::Skip;
        if !self.warms_up {
            self.rays += piece.rays.clone().filter(traced).count() as u64;
        }
        self.known += piece.known;
        let window = self.windows;
        if is_last {
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
            of.push(piece.clone());
            let behind = self.plan.cut.behind;
            if open.behind.len() == behind || behind == 0 && open.window == window && is_last {
                complete.push(at);
            }
        }
        let complete: Vec<Open> = complete.into_iter().rev().map(|at| self.open.remove(at)).collect();
        complete.into_iter().filter_map(|open| self.job(open)).collect()
    }

    fn end(&mut self, FrameEnd { steps, requests, l1s }: FrameEnd) -> Vec<Job> {
        self.population.windows = self.axis.windows();
        let open = take(&mut self.open);
        let mut jobs: Vec<Job> = open.into_iter().filter_map(|open| self.job(open)).collect();
        // All ends, and the building of all frames, are replayed by the first pass.
        if (!steps.is_empty() || self.builds) && self.plan.draws.start == 0 && !self.warms_up {
            let warm = WarmCaches::new(l1s, self.tags.snapshot());
            jobs.push(Job { number: self.jobs, draw: 0, info: self.info, warm, work: JobWork::End(steps) });
            self.jobs += 1;
        }
        self.tags.pass(&requests);
        jobs
    }

    /// It is known which points lie in the window: without any, it need not be kept.
    fn end_window(&mut self) {
        let known = take(&mut self.known).columns(&self.capacity);
        if self.warms_up {
            self.open.retain(|open| open.window != self.windows);
            self.windows += 1;
            return;
        }
        let hits = self.axis.next();
        let wanted = self.plan.draws.start..self.unwanted;
        let is_wanted = hits.iter().map(|hit| hit.draw).min().is_some_and(|draw| wanted.contains(&draw));
        let window = self.windows;
        if !is_wanted {
            self.open.retain(|open| open.window != window);
        } else if let Some(open) = self.open.iter_mut().find(|open| open.window == window) {
            open.hits = hits;
        }
        self.population.add(&known);
        self.windows += 1;
    }

    /// A job of a window that was put together, if it has points.
    fn job(&mut self, open: Open) -> Option<Job> {
        let Open { hits, warm, before, own, behind, .. } = open;
        let draw = hits.iter().map(|hit| hit.draw).min()?;
        let [before, own, behind] =
            [(before, false), (own, true), (behind, false)].map(|(pieces, is_own)| Part::of(&pieces, is_own));
        let work = JobWork::Window(Box::new(WindowWork { hits, before, own, behind }));
        self.jobs += 1;
        Some(Job { number: self.jobs - 1, draw, info: self.info, warm, work })
    }
}
