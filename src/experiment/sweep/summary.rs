//! Summarises a sweep from its points, which are read one after another to limit memory.

use std::collections::HashMap;
use std::path::Path;

use rustc_hash::FxBuildHasher;

use super::super::split::Role;
use super::error::SweepError;
use super::plan::Plan;
use super::points::{self, Key, Measured};
use super::spec::Sweep;
use crate::report::sweep::{SweepPoint, SweepSummary};
use crate::stats::MachineStats;

/// The summary of a sweep whose points are all in `folder`.
///
/// # Errors
/// A point is missing.
pub(super) fn summary(sweep: &Sweep, plan: &Plan, folder: &Path) -> Result<SweepSummary, SweepError> {
    let experiment = &sweep.experiment;
    let names: Vec<&str> = experiment.policy_names().collect();
    let mut found = Vec::new();
    // Measurements with the values of the machine's file, by machine of the experiment and policy.
    let mut own: HashMap<(usize, usize), MachineStats, FxBuildHasher> = HashMap::default();
    for at in (0..sweep.len()).filter(|&at| sweep.is_as_in_its_file(at)) {
        for policy in plan.culling() {
            let key = plan.key(sweep, (at, &sweep.machine(at)?.spec), policy, Role::AsItIs);
            own.insert((sweep.base(at), policy), read(folder, key)?.stats);
        }
    }
    for at in 0..sweep.len() {
        let machine = sweep.machine(at)?;
        let measured = |policy, role| read(folder, plan.key(sweep, (at, &machine.spec), policy, role));
        let baseline = measured(plan.off(), Role::WithoutUnit)?;
        for policy in plan.culling() {
            let real = measured(policy, Role::AsItIs)?;
            found.push(SweepPoint::new(
                &machine.name,
                names[policy],
                machine.changes.clone(),
                [&baseline.stats, &measured(policy, Role::FreeWords)?.stats, &real.stats],
                &real.totals,
                own.get(&(sweep.base(at), policy)).filter(|_| !machine.changes.is_empty()),
            ));
        }
    }
    Ok(SweepSummary {
        experiment: experiment.spec.name.clone(),
        scene: experiment.scene.name.clone(),
        fidelity: Some(experiment.spec.fidelity.to_string()),
        frames: experiment.frames.clone(),
        warmup: experiment.replayed.warmup.clone(),
        resolution: experiment.spec.resolution,
        own: sweep.own_values(),
        points: found,
    })
}

/// Reads a point that was made or checked before.
pub(in super::super) fn read(folder: &Path, key: Key) -> Result<Measured, SweepError> {
    let failed = |why: String| SweepError::File { path: key.file(folder), source: std::io::Error::other(why) };
    let point = points::read(folder, key).map_err(|why| failed(why.to_string()))?;
    point.ok_or_else(|| failed("the point is gone: run the same command again".into()))
}
