//! Cuts a stream into windows, piece by piece, for all machines with the same cut.

use std::collections::VecDeque;
use std::mem::take;
use std::ops::Range;
use std::sync::Arc;

use super::axis::Axis;
use super::plan::{Cut, Plan};
use super::strata::Point;
use super::window_rays::WindowRays;
use crate::engine::source::{StreamFault, check_chunk, check_step};
use crate::machine::MachineSpec;
use crate::machine::layout::Layout;
use crate::stream::{Chunk, Decision, FrameInfo, Header, Item, RayKind};

/// A portion of the cut stream.
#[derive(Debug)]
pub(super) enum Portion {
    /// The beginning of a frame.
    Frame(FrameInfo),
    /// A piece of a frame.
    Piece(CutPiece),
    /// The end of a frame, with its steps.
    End(Arc<Vec<u32>>),
}

/// Rays of a chunk, and their place among windows.
#[derive(Debug)]
pub(super) struct CutPiece {
    /// The chunk.
    pub chunk: Arc<Chunk>,
    /// The piece's rays.
    pub rays: Range<usize>,
    /// Number of rays that are not skipped.
    pub traced: u64,
    /// Windows with points whose lead-in begins at this piece.
    pub begin: Vec<Lead>,
    /// Whether it is the last piece of its window.
    pub is_last: bool,
}

/// The beginning of a window's lead-in.
#[derive(Clone, Debug)]
pub(super) struct Lead {
    /// The window's number in the stream.
    pub window: usize,
    /// Pieces before the window's first one.
    pub pieces: usize,
    /// The points that lie in it.
    pub hits: Vec<Point>,
    /// The window's rays, once a machine has joined them.
    pub rays: Arc<WindowRays>,
}

/// Cuts a stream.
#[derive(Debug)]
pub(super) struct Cutter {
    /// The frame's contents, equal on all machines.
    layout: Layout,
    cut: Cut,
    /// Chunks not cut yet, and their pixels.
    gathered: Vec<Arc<Chunk>>,
    pixels: usize,
    /// Windows of the stream so far, and pieces of the frame so far.
    windows: usize,
    pieces: usize,
    /// Warm-up frames, and whether the current frame is one.
    warmup: Vec<u32>,
    warms_up: bool,
    axis: Axis,
    /// Points of the next windows, as far as drawn.
    ahead: VecDeque<Vec<Point>>,
}

impl Cutter {
    /// A cutter before the stream begins, with the cut and strata of `plan`. Points with draws below `most` are wanted.
    /// Any machine of the pass will do.
    pub(super) fn new(header: &Header, machine: &MachineSpec, plan: &Plan, most: usize) -> Self {
        Self {
            layout: Layout::new(header, machine),
            cut: plan.cut,
            gathered: Vec::new(),
            pixels: 0,
            windows: 0,
            pieces: 0,
            warmup: header.warmup.clone(),
            warms_up: false,
            axis: Axis::new(plan.strata, most),
            ahead: VecDeque::new(),
        }
    }

    /// Takes the stream's next item; returns the portions that it completes.
    ///
    /// # Errors
    /// A ray or a step is invalid: tags would misread it.
    pub(super) fn add(&mut self, item: &Item) -> Result<Vec<Portion>, StreamFault> {
        Ok(match item {
            Item::Frame(info) => {
                self.layout.begin_frame(info);
                self.pieces = 0;
                self.warms_up = self.warmup.contains(&info.number);
                vec![Portion::Frame(*info)]
            }
            Item::Rays(chunk) => {
                check_chunk(chunk, &self.layout)?;
                self.gathered.push(Arc::clone(chunk));
                self.pixels += chunk.rays().filter(|ray| ray.head.kind == RayKind::Primary).count();
                if self.pixels < self.cut.window() { Vec::new() } else { self.gathered() }
            }
            Item::End { policy, .. } => {
                policy.iter().try_for_each(|&word| check_step(word, &self.layout).map(drop))?;
                let mut portions = self.gathered();
                portions.push(Portion::End(Arc::clone(policy)));
                portions
            }
        })
    }

    /// Cuts the gathered chunks, joined to one.
    fn gathered(&mut self) -> Vec<Portion> {
        self.pixels = 0;
        let gathered = take(&mut self.gathered);
        match gathered.as_slice() {
            [] => Vec::new(),
            [chunk] => self.chunk(chunk),
            chunks => {
                let mut all = Chunk::default();
                chunks.iter().for_each(|chunk| all.extend(chunk, 0..chunk.len()));
                self.chunk(&Arc::new(all))
            }
        }
    }

    fn chunk(&mut self, chunk: &Arc<Chunk>) -> Vec<Portion> {
        let primaries: Vec<u32> =
            (0..chunk.len()).filter(|&ray| chunk.head(ray).kind == RayKind::Primary).map(|ray| ray as u32).collect();
        // Whole windows of about equally many pixels.
        let cut = self.cut;
        let windows = ((primaries.len() as f64 / cut.window() as f64).round() as usize).max(1);
        let pieces = (windows * cut.own).min(primaries.len());
        let firsts: Vec<u32> = (0..pieces).map(|piece| primaries[piece * primaries.len() / pieces]).collect();
        let piece = |(piece, &first): (usize, &u32)| {
            let rays = first as usize..firsts.get(piece + 1).map_or(chunk.len(), |&end| end as usize);
            let begin = self.begin_windows(piece);
            let is_last = piece + 1 == pieces || (piece + 1) % cut.own == 0;
            if is_last {
                self.end_window();
            }
            self.pieces += 1;
            let traced = rays.clone().filter(|&ray| chunk.head(ray).decision != Decision::Skip).count() as u64;
            Portion::Piece(CutPiece { chunk: Arc::clone(chunk), rays, traced, begin, is_last })
        };
        firsts.iter().enumerate().map(piece).collect()
    }

    /// The windows whose lead-in begins at the next piece, which has index `piece` in its chunk. At the beginning of a
    /// frame, these are all windows within reach of a lead-in.
    fn begin_windows(&mut self, piece: usize) -> Vec<Lead> {
        let cut = self.cut;
        let left = (cut.own - piece % cut.own) % cut.own;
        let to_first = |window: usize| left + window * cut.own;
        let first = self.windows + usize::from(left > 0);
        let begin = (0..).take_while(|&window| to_first(window) <= cut.before);
        let frame_begins = self.pieces == 0;
        let begin = begin.filter(|&window| frame_begins || to_first(window) == cut.before);
        let begin = begin.map(|window| Lead {
            window: first + window,
            pieces: to_first(window),
            hits: self.points(first + window),
            rays: Arc::default(),
        });
        begin.filter(|lead| !lead.hits.is_empty()).collect()
    }

    /// The points of a window that is not over; none in warm-up frames.
    fn points(&mut self, window: usize) -> Vec<Point> {
        if self.warms_up {
            return Vec::new();
        }
        let place = window - self.windows;
        while self.ahead.len() <= place {
            self.ahead.push_back(self.axis.next());
        }
        self.ahead[place].clone()
    }

    fn end_window(&mut self) {
        if !self.warms_up && self.ahead.pop_front().is_none() {
            self.axis.next();
        }
        self.windows += 1;
    }
}
