//! The counts of a run frame by frame, and their sum over all frames but warm-up frames.

use super::source::FrameCounts;
use super::tally::Tally;
use crate::energy;
use crate::machine::MachineSpec;
use crate::stats::MachineStats;
use crate::stream::Header;

/// Counts at the ends of frames.
pub(super) struct FrameLog<'a> {
    machine: &'a MachineSpec,
    /// The counts of the frame that is over, until [`FrameLog::add`] takes the run's counts.
    over: Option<FrameCounts>,
    /// Frames that are over, each with the run's counts up to its end.
    ends: Vec<(FrameCounts, MachineStats)>,
}

impl<'a> FrameLog<'a> {
    /// An empty log.
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

    /// Whether a frame is over for which [`FrameLog::add`] was not called.
    pub(super) fn is_over(&self) -> bool {
        self.over.is_some()
    }

    /// Receives the run's counts at the end of the frame that is over.
    pub(super) fn add(&mut self, tally: &Tally) {
        if let Some(counts) = self.over.take() {
            self.ends.push((counts, tally.stats(self.machine)));
        }
    }

    /// The sum over all frames of the run but warm-up frames, and the counts of each frame. What the machine does
    /// after the last frame's end, until its memory is idle, counts for the last frame.
    ///
    /// # Errors
    /// The frames' sum differs from the counts of the `whole` run: an error in the simulator.
    pub(super) fn finish(mut self, whole: MachineStats, header: &Header) -> Result<MachineStats, String> {
        let with_energy =
            |stats: MachineStats| MachineStats { energy: energy::of(self.machine, header.structure, &stats), ..stats };
        let Some((_, last)) = self.ends.last_mut() else { return Ok(with_energy(whole)) };
        // Each frame has a longest latency of its own.
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
