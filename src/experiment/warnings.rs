//! Warns of valid settings that make an experiment useless.

use std::path::Path;

use super::load::Experiment;
use crate::culling::{PolicySpec, SceneFacts};
use crate::ron_file;
use crate::scene::camera::Projection;

/// Parts of a machine whose absence from its file deserves a warning, with the defaults that then apply.
const PARTS: [(&str, &str); 2] =
    [("l2", "one cache of 128 KiB for all classes"), ("dram", "one channel of LPDDR4-3200")];
/// Plausible vertical angles of view, in degrees.
const ANGLES: std::ops::RangeInclusive<f64> = 2.0..=150.0;

/// Warnings of what makes a run useless, or less useful than it seems.
pub(crate) fn warnings(experiment: &Experiment, with_machines: bool) -> Vec<String> {
    let mut found = Vec::new();
    let scene = &experiment.scene;
    if with_machines && experiment.machines.is_empty() {
        found.push("`machines` is empty: no machine is measured; name one, as in `--machine small`".into());
    }
    if scene.light_count == 0 {
        found.push(format!("`{}` has no lights: there is no shadow ray that could be culled", scene.name));
    }
    let learns = |(_, policy): &(&str, &PolicySpec)| policy.learns(SceneFacts::of(scene));
    if let Some((name, _)) = experiment.spec.policies.iter().find(learns).filter(|_| experiment.frames.len() == 1) {
        found.push(format!(
            "`{name}` learns from frame to frame, and there is one frame: at least two show what it saves"
        ));
    }
    if let Some(&first) = experiment.frames.first()
        && let Projection::Perspective { tan_half_fov } = scene.animation.frame(first).camera.projection
    {
        let degrees = 2.0 * tan_half_fov.atan().to_degrees();
        if !ANGLES.contains(&degrees) {
            found.push(format!(
                "the camera of `{}` sees {degrees:.1} degrees from bottom to top: `fov` is in degrees",
                scene.name
            ));
        }
    }
    found.extend(experiment.machine_files.iter().flat_map(|file| of_machine(file)));
    found
}

/// Warnings of parts that a machine's file leaves to a default.
pub(crate) fn of_machine(file: &Path) -> Vec<String> {
    let Ok(text) = ron_file::text(file) else { return Vec::new() };
    let names = ron_file::top_names(&text);
    let missing = PARTS.iter().filter(|(part, _)| !names.iter().any(|name| name == part));
    let told = |(part, default): &(&str, &str)| format!("{} has no `{part}`: {default} stands for it", file.display());
    missing.map(told).collect()
}
