//! Steady state and cold start: the cost of a policy's first frame, and the number of frames that repays it.

use super::machine_run::MachineRun;
use super::summary::{MachineSummary, Summary};
use crate::report::format::change;

/// The cost of a policy in the first frame, which starts cold.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ColdStart {
    /// The frame.
    pub(crate) frame: u32,
    /// Cycles without culling, and with the policy.
    pub(crate) cycles: [u64; 2],
    /// Mean number of cycles that a measured frame saves.
    pub(crate) saved: f64,
}

impl ColdStart {
    /// The cold start of `run` against `off`. `None` if the first replayed frame is a measured one, or if figures by
    /// frame are absent.
    pub(crate) fn of(off: &MachineRun, run: &MachineRun) -> Option<Self> {
        let (first, second) = (off.stats.frames.first()?, run.stats.frames.first()?);
        let measured = run.stats.frames.iter().filter(|frame| !frame.warmup).count();
        let saved = (off.stats.cycles.0 as f64 - run.stats.cycles.0 as f64) / measured as f64;
        let is_cold = first.warmup && first.frame == second.frame && measured > 0;
        is_cold.then_some(Self { frame: first.frame, cycles: [first.cycles.0, second.cycles.0], saved })
    }

    /// Number of measured frames whose savings repay the extra cost of the cold frame; `None` if they save nothing.
    pub(crate) fn repaid_after(&self) -> Option<u64> {
        let [off, with] = self.cycles.map(|cycles| cycles as f64);
        if with <= off {
            return Some(0);
        }
        (self.saved > 0.0).then(|| ((with - off) / self.saved).ceil() as u64)
    }

    /// In words: `+3.5 % in frame 0, repaid after 1 frame`.
    pub(crate) fn text(&self) -> Option<String> {
        let [off, with] = self.cycles.map(|cycles| cycles as f64);
        let repaid = match self.repaid_after() {
            Some(0) => String::new(),
            Some(1) => ", repaid after 1 frame".into(),
            Some(frames) => format!(", repaid after {frames} frames"),
            None => ", not repaid: measured frames save no cycles".into(),
        };
        Some(format!("{} in frame {}{repaid}", change(off, with)?, self.frame))
    }
}

/// The frames that a machine measured, in words.
fn measured(machine: &MachineSummary) -> String {
    let list = |frames: &[u32]| match frames {
        [] => "none".to_owned(),
        [one] => format!("frame {one}"),
        [first, .., last] if frames.len() > 6 => format!("{} frames from {first} to {last}", frames.len()),
        frames => format!("frames {}", frames.iter().map(u32::to_string).collect::<Vec<_>>().join(", ")),
    };
    match machine.warmup.as_slice() {
        [] => format!("{} measured, from a cold start on", list(&machine.frames)),
        warmup => format!("{} measured; warm-up, left out: {}", list(&machine.frames), list(warmup)),
    }
}

/// One sentence for each set of measured frames.
pub(crate) fn frames(summary: &Summary) -> Vec<String> {
    let mut sentences: Vec<String> = Vec::new();
    for (_, machine) in summary.machines.iter() {
        let sentence = format!("Machines: {}.", measured(machine));
        if !sentences.contains(&sentence) {
            sentences.push(sentence);
        }
    }
    sentences
}

/// One line for each machine with cold starts.
pub(crate) fn cold_starts(summary: &Summary) -> Vec<String> {
    let mut lines = Vec::new();
    for (name, machine) in summary.machines.iter() {
        let off = summary.baseline.as_deref().and_then(|baseline| machine.policies.get(baseline));
        let others = machine.policies.iter().filter(|&(policy, _)| summary.baseline.as_deref() != Some(policy));
        let starts = others.filter_map(|(policy, run)| Some((policy, ColdStart::of(off?, run)?.text()?)));
        let starts: Vec<String> = starts.map(|(policy, text)| format!("{policy} {text}")).collect();
        if !starts.is_empty() {
            lines.push(format!("Cold start, cycles on {name}: {}.", starts.join("; ")));
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cold_frame_is_repaid_by_what_measured_frames_save() {
        let start = |cycles, saved| ColdStart { frame: 0, cycles, saved };
        let text = |cycles, saved| start(cycles, saved).text().unwrap();
        assert_eq!(text([1000, 1035], 400.0), "+3.5 % in frame 0, repaid after 1 frame");
        assert_eq!(text([1000, 1500], 200.0), "+50.0 % in frame 0, repaid after 3 frames");
        assert_eq!(text([1000, 1500], -1.0), "+50.0 % in frame 0, not repaid: measured frames save no cycles");
        assert_eq!(start([1000, 900], 100.0).repaid_after(), Some(0));
    }
}
