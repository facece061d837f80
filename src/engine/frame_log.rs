//! What a run counts frame by frame, and what is measured of that: all but the warm-up frames.

use super::tally::Tally;
use crate::machine::MachineSpec;
use crate::stats::{FrameStats, MachineStats};

/// Counts at the ends of frames.
pub(super) struct FrameLog<'a> {
    machine: &'a MachineSpec,
    /// The frame that is over and was not counted yet.
    over: Option<u32>,
    /// Frames that are over, each with all counts up to its end.
    ends: Vec<(u32, MachineStats)>,
}

impl<'a> FrameLog<'a> {
    /// No frame is over.
    pub fn new(machine: &'a MachineSpec) -> Self {
        Self { machine, over: None, ends: Vec::new() }
    }

    /// The machine.
    pub fn machine(&self) -> &'a MachineSpec {
        self.machine
    }

    /// A frame is over.
    pub fn over(&mut self, frame: u32) {
        self.over = Some(frame);
    }

    /// Whether a frame is over that was not counted.
    pub fn is_over(&self) -> bool {
        self.over.is_some()
    }

    /// The frame that is over ends with these counts of the run.
    pub fn add(&mut self, tally: &Tally) {
        if let Some(frame) = self.over.take() {
            self.ends.push((frame, tally.stats(self.machine)));
        }
    }

    /// What all frames of the run but those of `warmup` amount to, and each frame by itself. What the machine does after the last
    /// frame's end, until its memory is idle, counts as that frame's.
    ///
    /// # Errors
    /// The frames' sum is not what the `whole` run counted: an error in the simulator.
    pub fn finish(mut self, whole: MachineStats, warmup: &[u32]) -> Result<MachineStats, String> {
        let Some((_, last)) = self.ends.last_mut() else { return Ok(whole) };
        // Of the longest latencies each frame has its own.
        let latency = std::mem::take(&mut last.latency);
        *last = MachineStats { latency, ..whole.clone() };
        let nothing = whole.nothing();
        let (mut before, mut all, mut measured) = (nothing.clone(), nothing.clone(), nothing);
        let mut frames = Vec::new();
        for (frame, end) in self.ends {
            let own = end.since(&before);
            let warmup = warmup.contains(&frame);
            all.add(&own);
            if !warmup {
                measured.add(&own);
            }
            frames.push(FrameStats::new(frame, warmup, &own));
            before = end;
        }
        let summed = MachineStats { latency: whole.latency.clone(), ..all };
        if summed != whole {
            return Err(format!("the frames' counts do not sum to the run's: {summed:?} against {whole:?}"));
        }
        Ok(MachineStats { frames, ..measured })
    }
}
