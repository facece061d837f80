//! A run's result in sentences.

use super::machine_run::MachineRun;
use super::steady::{self, ColdStart};
use super::summary::{PolicySummary, Summary};
use super::tables::dram_bytes;
use crate::quantity::Bytes;
use crate::report::format::{bytes, change, counted, exact, joules, milliseconds, or_absent, percent, short};
use crate::stats::TrafficClass;

/// The scene, frames and resolution of the run.
pub(super) fn setting(summary: &Summary) -> String {
    let scene = &summary.scene;
    format!(
        "{}: {} static and {} dynamic triangles, {}; {} at {}.{}",
        scene.name,
        exact(scene.triangles_static),
        exact(scene.triangles_dynamic),
        counted(scene.lights as usize, "light"),
        counted(summary.frames.len(), "frame"),
        summary.resolution,
        steady::frames(summary).into_iter().map(|line| format!(" {line}")).collect::<String>(),
    )
}

/// For each culling policy its name and sentences about it: what it skipped, saved and got wrong, then its effect on
/// each machine.
pub(super) fn of_policies(summary: &Summary) -> Vec<(String, Vec<String>)> {
    let culling = summary.policies.iter().filter(|&(name, _)| summary.baseline.as_deref() != Some(name));
    culling.map(|(name, policy)| (name.to_owned(), of_policy(summary, name, policy))).collect()
}

/// Mean share of the shadow rays' node visits that is saved in the frames after the first.
fn after_the_first(policy: &PolicySummary) -> Option<f64> {
    let shares: Vec<f64> = policy.frames.iter().skip(1).filter_map(|frame| frame.traversal_saved).collect();
    (!shares.is_empty()).then(|| shares.iter().sum::<f64>() / shares.len() as f64)
}

fn of_policy(summary: &Summary, name: &str, policy: &PolicySummary) -> Vec<String> {
    let counts = &policy.counts;
    if counts.shadow_rays == 0 {
        return vec!["had no shadow ray to decide.".into()];
    }
    let of_shadow_rays = |rays: u64| percent(rays as f64 / counts.shadow_rays as f64);
    let mut text = format!(
        "answered {} of {} shadow rays without tracing them and traced another {} among dynamic objects only.",
        of_shadow_rays(counts.shadow_rays_skipped),
        short(counts.shadow_rays as f64),
        of_shadow_rays(counts.shadow_rays_dynamic_only),
    );
    let (traversal, intersection) = (&policy.traversal_saved, &policy.intersection_saved);
    if let (Some(mean), Some(max), Some(frame)) = (traversal.mean, traversal.max, traversal.max_frame) {
        text += &format!(" It saved {} of the node visits of shadow rays", percent(mean));
        if let Some(mean) = intersection.mean {
            text += &format!(" and {} of their triangle tests", percent(mean));
        }
        if policy.frames.len() > 1 {
            text += &format!(", means of all {} frames;", policy.frames.len());
            if let Some(others) = after_the_first(policy) {
                text += &format!(" without the first, which knows nothing yet, {} of the visits,", percent(others));
            }
            text += &format!(" at most {} in frame {frame}", percent(max));
        }
        text += ".";
    }
    if let Some(tests) = counts.occlusion_tests_per_pixel.filter(|&tests| tests > 0.0) {
        text += &format!(" It made {tests:.3} occlusion tests a pixel.");
    }
    text += &match (counts.false_dark, counts.false_lit) {
        (Some(0), Some(0)) => " No shadow decision was wrong.".into(),
        (Some(dark), Some(lit)) => format!(
            " The price: {} wrong shadow decisions ({}), {} false dark and {} false lit.",
            exact(dark + lit),
            of_shadow_rays(dark + lit),
            exact(dark),
            exact(lit),
        ),
        _ => " Whether its decisions were right was not checked.".into(),
    };
    let mut all = vec![text];
    for (machine, found) in summary.machines.iter() {
        let off = summary.baseline.as_deref().and_then(|baseline| found.policies.get(baseline));
        if let (Some(off), Some(run)) = (off, found.policies.get(name)) {
            all.push(on_machine(machine, off, run));
        }
    }
    all
}

/// The effect of a policy on a machine: mean of the measured frames, and cold start.
fn on_machine(machine: &str, off: &MachineRun, run: &MachineRun) -> String {
    let pair = |figure: fn(&MachineRun) -> Option<f64>, show: fn(f64) -> String| {
        let (before, after) = (figure(off)?, figure(run)?);
        Some(format!("{} instead of {} ({})", show(after), show(before), or_absent(change(before, after), |it| it)))
    };
    let moved = dram_bytes(run).unwrap_or_default();
    let words = run.stats.bytes.get("dram").and_then(|classes| classes.get(&TrafficClass::ModeWord));
    let words = words
        .filter(|words| words.0 > 0)
        .map(|&words: &Bytes| format!(" ({} of it for mode words)", percent(words.0 as f64 / moved.0 as f64)));
    let time = pair(|run| run.milliseconds_per_frame, |time| format!("{} ms", milliseconds(time)));
    let dram = pair(|run| run.dram_bytes_per_frame, |amount| bytes(Bytes(amount.round() as u64)));
    let energy = pair(|run| run.joules_per_frame, joules).map(|energy| format!(", and {energy} of energy"));
    let cold = ColdStart::of(off, run).and_then(|cold| cold.text());
    let cold = cold.map(|cold| format!(" Cold start: {cold}."));
    format!(
        "On {machine}, a frame takes {}, {} of DRAM traffic{}{}.{}",
        or_absent(time, |it| it),
        or_absent(dram, |it| it),
        words.unwrap_or_default(),
        energy.unwrap_or_default(),
        cold.unwrap_or_default(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::run::tests::sample::parts;

    #[test]
    fn what_is_saved_is_told_without_the_cold_first_frame_too() {
        let (summary, ..) = parts(&[320, 336, 352]);
        let told = |first: f64| {
            let mut policy = summary.policies.get("published").unwrap().clone();
            policy.frames[0].traversal_saved = Some(first);
            let text = of_policy(&summary, "published", &policy)[0].clone();
            text.split_once("means of all 3 frames; without the first, which knows nothing yet, ").unwrap().1.to_owned()
        };
        assert_eq!(told(0.0), told(0.9), "the first frame is not among the others");
        let (one, ..) = parts(&[320]);
        assert!(!of_policies(&one)[0].1[0].contains("means of"), "one frame has no others");
    }
}
