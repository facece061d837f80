//! What a run counts frame by frame, and what is measured of that: all but the warm-up frames.

use super::source::FrameCounts;
use super::tally::Tally;
use crate::energy;
use crate::machine::MachineSpec;
use crate::stats::MachineStats;
use crate::stream::Header;

/// Counts at the ends of frames.
pub(super) struct FrameLog<'a> {
    machine: &'a MachineSpec,
    /// The frame that is over and was not counted yet.
    over: Option<FrameCounts>,
    /// Frames that are over, each with all counts of the run up to its end.
    ends: Vec<(FrameCounts, MachineStats)>,
}

impl<'a> FrameLog<'a> {
    /// No frame is over.
    pub(super) fn new(machine: &'a MachineSpec) -> Self {
        Self { machine, over: None, ends: Vec::new() }
    }

    /// The machine.
    pub(super) fn machine(&self) -> &'a MachineSpec {
        self.machine
    }

    /// A frame is over.
    pub(super) fn over(&mut self, counts: FrameCounts) {
        self.over = Some(counts);
    }

    /// Whether a frame is over that was not counted.
    pub(super) fn is_over(&self) -> bool {
        self.over.is_some()
    }

    /// The frame that is over ends with these counts of the run.
    pub(super) fn add(&mut self, tally: &Tally) {
        if let Some(counts) = self.over.take() {
            self.ends.push((counts, tally.stats(self.machine)));
        }
    }

    /// What all frames of the run but warm-up frames amount to, and each frame by itself. What the machine does after
    /// the last frame's end, until its memory is idle, counts as that frame's.
    ///
    /// # Errors
    /// The frames' sum is not what the `whole` run counted: an error in the simulator.
    pub(super) fn finish(mut self, whole: MachineStats, header: &Header) -> Result<MachineStats, String> {
        let with_energy =
            |stats: MachineStats| MachineStats { energy: energy::of(self.machine, header.structure, &stats), ..stats };
        let Some((_, last)) = self.ends.last_mut() else { return Ok(with_energy(whole)) };
        // Of the longest latencies each frame has its own.
        let latency = std::mem::take(&mut last.latency);
        *last = MachineStats { latency, ..whole.clone() };
        let nothing = whole.nothing();
        let (mut before, mut all, mut measured) = (nothing.clone(), nothing.clone(), nothing);
        let mut frames = Vec::new();
        for (FrameCounts { frame, tracer, .. }, end) in self.ends {
            let own = with_energy(end.since(&before));
            let warmup = header.warmup.contains(&frame);
            all.add(&own);
            if !warmup {
                measured.add(&own);
            }
            frames.push(own.as_frame(frame, warmup, tracer.primary_rays + tracer.secondary_rays + tracer.shadow_rays));
            before = end;
        }
        let summed = MachineStats { latency: whole.latency.clone(), ..all };
        if summed != whole {
            return Err(format!("the frames' counts do not sum to the run's: {summed:?} against {whole:?}"));
        }
        Ok(MachineStats { frames, ..with_energy(measured) })
    }
}
