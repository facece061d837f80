//! Records a machine's behaviour over time, in spans whose length grows with the frame.

#[cfg(test)]
mod tests;

use std::io;

use crate::replay::Observer;
use crate::report::run::Span;
use crate::stats::MachineStats;
use crate::stream::Header;

/// Initial length of a frame's spans, in cycles.
const FIRST: u64 = 1024;
/// A frame has fewer spans than this: at this number, pairs of spans are merged.
const MOST: usize = 32;

/// Records a run; warm-up frames leave no spans.
pub(super) struct Recorder {
    warmup: Vec<u32>,
    /// Length of the current frame's spans, in cycles.
    interval: u64,
    /// The first cycle of the current frame.
    begin: u64,
    /// The spans of the current frame.
    frame: Vec<Span>,
    /// The spans of earlier frames.
    done: Vec<Span>,
    before: MachineStats,
}

impl Recorder {
    /// A recorder for a run of a stream with this header.
    pub(super) fn new(header: &Header) -> Self {
        let (warmup, before) = (header.warmup.clone(), MachineStats::default());
        Self { warmup, interval: FIRST, begin: 0, frame: Vec::new(), done: Vec::new(), before }
    }

    /// All spans, in the order of time.
    pub(super) fn finish(mut self) -> Vec<Span> {
        self.end_frame();
        self.done
    }

    fn end_frame(&mut self) {
        let frame = std::mem::take(&mut self.frame);
        self.begin += frame.iter().map(|span| span.cycles).sum::<u64>();
        self.interval = FIRST;
        self.done.extend(frame.into_iter().filter(|span| !self.warmup.contains(&span.frame)));
    }
}

impl Observer for Recorder {
    fn interval(&self) -> Option<u64> {
        Some(self.interval)
    }

    fn counted(&mut self, frame: u32, stats: MachineStats) -> io::Result<()> {
        if self.frame.first().is_some_and(|span| span.frame != frame) {
            self.end_frame();
        }
        let begin = self.before.cycles.0 - self.begin;
        self.frame.push(Span::new(frame, begin, &stats.since(&self.before)));
        self.before = stats;
        if self.frame.len() == MOST {
            self.frame = self.frame.chunks(2).map(Span::joined).collect();
            self.interval *= 2;
        }
        Ok(())
    }
}
