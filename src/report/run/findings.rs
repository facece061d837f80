//! A run's result in sentences.

use super::summary::{MachineRun, PolicySummary, Summary};
use super::tables::dram_bytes;
use crate::quantity::Bytes;
use crate::report::format::{bytes, change, counted, exact, or_absent, percent, short};
use crate::stats::TrafficClass;

/// What the run is of.
pub(super) fn setting(summary: &Summary) -> String {
    let scene = &summary.scene;
    format!(
        "{}: {} static and {} dynamic triangles, {}; {} at {}.",
        scene.name,
        exact(scene.triangles_static),
        exact(scene.triangles_dynamic),
        counted(scene.lights as usize, "light"),
        counted(summary.frames.len(), "frame"),
        summary.resolution,
    )
}

/// A policy's name and the sentences that go on from it, for each that culls: what it skipped, saved, got wrong, and
/// what that did to each machine.
pub(super) fn of_policies(summary: &Summary) -> Vec<(String, String)> {
    let culling = summary.policies.iter().filter(|&(name, _)| summary.baseline.as_deref() != Some(name));
    culling.map(|(name, policy)| (name.to_owned(), of_policy(summary, name, policy))).collect()
}

fn of_policy(summary: &Summary, name: &str, policy: &PolicySummary) -> String {
    let counts = &policy.counts;
    if counts.shadow_rays == 0 {
        return "had no shadow ray to decide.".into();
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
            text += &format!(", means of the frames; at most {} of the visits, in frame {frame}", percent(max));
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
    for (machine, found) in summary.machines.iter() {
        let off = summary.baseline.as_deref().and_then(|baseline| found.policies.get(baseline));
        if let (Some(off), Some(run)) = (off, found.policies.get(name)) {
            let all = found.frames.len() == summary.frames.len();
            let part = format!("{machine} ({} of {} frames)", found.frames.len(), summary.frames.len());
            text += &on_machine(if all { machine } else { &part }, off, run);
        }
    }
    text
}

fn on_machine(machine: &str, off: &MachineRun, run: &MachineRun) -> String {
    let moved = |run: &MachineRun| dram_bytes(run).unwrap_or_default();
    let changed = |before: f64, after: f64| or_absent(change(before, after), |change| change);
    let words = run.stats.bytes.get("dram").and_then(|classes| classes.get(&TrafficClass::ModeWord));
    let words = words
        .filter(|words| words.0 > 0)
        .map(|&words: &Bytes| format!(", of which mode words are {}", percent(words.0 as f64 / moved(run).0 as f64)));
    format!(
        " On {machine}, cycles went from {} to {} ({}) and DRAM traffic from {} to {} ({}){}.",
        short(off.stats.cycles.0 as f64),
        short(run.stats.cycles.0 as f64),
        changed(off.stats.cycles.0 as f64, run.stats.cycles.0 as f64),
        bytes(moved(off)),
        bytes(moved(run)),
        changed(moved(off).0 as f64, moved(run).0 as f64),
        words.unwrap_or_default(),
    )
}
