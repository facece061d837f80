//! What a machine does over time, in spans that grow with the frame.

#[cfg(test)]
mod tests;

use std::io;

use crate::replay::Observer;
use crate::report::run::Span;
use crate::stats::MachineStats;
use crate::stream::Header;

/// Cycles of a frame's first spans.
const FIRST: u64 = 1024;
/// A frame has fewer spans than this: where it gets as many, each two become one.
const MOST: usize = 32;

/// Watches a run; frames that warm up leave no spans.
pub(super) struct Recorder {
    warmup: Vec<u32>,
    /// Cycles of a span of the frame in work.
    interval: u64,
    /// The first cycle of that frame.
    begin: u64,
    /// Its spans.
    frame: Vec<Span>,
    /// Those of the frames before.
    done: Vec<Span>,
    before: MachineStats,
}

impl Recorder {
    /// Of a run of a stream with this header.
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
