//! Cuts a stream into windows, piece by piece, and takes the pieces through the L1s' tags.

use std::mem::take;
use std::ops::Range;
use std::sync::Arc;

use super::known::Known;
use super::l1_tags::{L1Tags, Passed};
use super::l2_tags::Request;
use super::plan::Cut;
use crate::engine::warm::L1s;
use crate::machine::MachineSpec;
use crate::stream::{Chunk, FrameInfo, Header, Item, RayKind};

/// What a stream is cut into.
#[derive(Debug)]
pub(super) enum Portion {
    /// A frame begins.
    Frame(FrameInfo),
    /// A piece of it.
    Piece(Box<CutPiece>),
    /// It ends.
    End(FrameEnd),
}

/// Rays of a chunk.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    /// The chunk.
    pub chunk: Arc<Chunk>,
    /// Which of its rays.
    pub rays: Range<usize>,
    /// What is known of them.
    pub known: Known,
}

/// A piece, and where it lies among windows.
#[derive(Debug)]
pub(super) struct CutPiece {
    /// The piece; of which is not known yet what the L2 does.
    pub piece: Piece,
    /// What the L1s ask the L2 for.
    pub requests: Vec<Request>,
    /// Windows that begin to be put together with it, and what the L1s held before.
    pub begin: Vec<Lead>,
    /// What the L1s held before it, if windows begin.
    pub l1s: Option<Arc<L1s>>,
    /// Whether it is its window's last.
    pub is_last: bool,
}

/// How many pieces come before a window's first one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lead {
    /// The window's number in the stream.
    pub window: usize,
    /// Pieces.
    pub pieces: usize,
}

/// The steps of a frame's end.
#[derive(Debug)]
pub(super) struct FrameEnd {
    /// The steps.
    pub steps: Arc<Vec<u32>>,
    /// What the L1s ask the L2 for.
    pub requests: Vec<Request>,
    /// What the L1s held before.
    pub l1s: Arc<L1s>,
}

/// Cuts a stream.
#[derive(Debug)]
pub(super) struct Cutter {
    cut: Cut,
    tags: L1Tags,
    /// Chunks that are not cut yet, and their pixels.
    gathered: Vec<Arc<Chunk>>,
    pixels: usize,
    /// Windows of the stream up to now, and pieces of the frame.
    windows: usize,
    pieces: usize,
}

impl Cutter {
    /// Nothing yet of a stream on a machine.
    pub(super) fn new(machine: &MachineSpec, header: &Header, cut: Cut) -> Self {
        let tags = L1Tags::new(header, machine);
        Self { cut, tags, gathered: Vec::new(), pixels: 0, windows: 0, pieces: 0 }
    }

    /// The next item of the stream; what it completes.
    pub(super) fn add(&mut self, item: &Item) -> Vec<Portion> {
        match item {
            Item::Frame(info) => {
                self.tags.begin_frame(info);
                self.pieces = 0;
                vec![Portion::Frame(*info)]
            }
            Item::Rays(chunk) => {
                self.gathered.push(Arc::clone(chunk));
                self.pixels += chunk.rays().filter(|ray| ray.head.kind == RayKind::Primary).count();
                if self.pixels < self.cut.window() { Vec::new() } else { self.gathered() }
            }
            Item::End { policy, .. } => {
                let mut portions = self.gathered();
                let l1s = self.tags.snapshot();
                let Passed { requests, .. } = self.tags.frame_end(policy);
                portions.push(Portion::End(FrameEnd { steps: Arc::clone(policy), requests, l1s }));
                portions
            }
        }
    }

    /// Cuts the chunks that were gathered: one, or as many as make a window.
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
        // Whole windows of about the same number of pixels.
        let cut = self.cut;
        let windows = ((primaries.len() as f64 / cut.window() as f64).round() as usize).max(1);
        let pieces = (windows * cut.own).min(primaries.len());
        let firsts: Vec<u32> = (0..pieces).map(|piece| primaries[piece * primaries.len() / pieces]).collect();
        let piece = |(piece, &first): (usize, &u32)| {
            let rays = first as usize..firsts.get(piece + 1).map_or(chunk.len(), |&end| end as usize);
            let begin = self.begin_windows(piece);
            let l1s = (!begin.is_empty()).then(|| self.tags.snapshot());
            let Passed { known, requests } = self.tags.piece(chunk, rays.clone());
            let is_last = piece + 1 == pieces || (piece + 1) % cut.own == 0;
            self.windows += usize::from(is_last);
            self.pieces += 1;
            let piece = Piece { chunk: Arc::clone(chunk), rays, known };
            Portion::Piece(Box::new(CutPiece { piece, requests, begin, l1s, is_last }))
        };
        firsts.iter().enumerate().map(piece).collect()
    }

    /// Windows begin to be put together some pieces before their first one, or with the frame; the next piece is number
    /// `piece` of its chunk.
    fn begin_windows(&self, piece: usize) -> Vec<Lead> {
        let cut = self.cut;
        let left = (cut.own - piece % cut.own) % cut.own;
        let to_first = |window: usize| left + window * cut.own;
        let first = self.windows + usize::from(left > 0);
        let begin = (0..).take_while(|&window| to_first(window) <= cut.before);
        let begin = begin.filter(|&window| self.pieces == 0 || to_first(window) == cut.before);
        begin.map(|window| Lead { window: first + window, pieces: to_first(window) }).collect()
    }
}
