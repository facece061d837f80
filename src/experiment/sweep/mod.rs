//! Sweeps: the same ray streams on many machines, which differ in named fields of their specs.
//!
//! Frames are traced once; every point is a replay. Streams and points are kept in files named by all that they depend on, so
//! that a sweep that was stopped goes on where it was, and ends with the same bytes.

mod error;
mod points;
mod replay;
mod spec;
mod streams;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use rayon::prelude::*;

pub use self::error::SweepError;
use self::points::Key;
pub(super) use self::replay::replay;
use self::spec::Sweep;
pub(crate) use self::spec::SweepSpec;
pub(super) use self::streams::Streams;
use self::streams::{Recorded, Streams as Kept};
use super::progress;
use super::split::Role;
use crate::machine::MachineSpec;
use crate::output::ResultsFolder;
use crate::report::sweep::{SweepPoint, SweepSummary};
use crate::stats::MachineStats;

/// A replay of a policy's stream on a machine in a role.
#[derive(Clone, Copy)]
struct Replay {
    policy: usize,
    machine: usize,
    role: Role,
}

/// Runs or continues the sweep of the file `path`; its streams and points are kept in `folder`.
///
/// # Errors
/// A file is wrong or cannot be written, a replay fails, or `stop` was set.
pub(crate) fn sweep(path: &Path, folder: &ResultsFolder, stop: &AtomicBool) -> Result<SweepSummary, SweepError> {
    let sweep = Sweep::load(path)?;
    let [points, streams] = ["points", "streams"].map(|part| folder.path().join(part));
    folder.make()?;
    for part in [&points, &streams] {
        std::fs::create_dir_all(part).map_err(|source| SweepError::File { path: part.clone(), source })?;
    }
    let experiment = &sweep.experiment;
    let fidelity = experiment.spec.fidelity;
    let streams = Kept::new(experiment, &streams);
    let identities = streams.identities.clone();
    let key = |policy: usize, machine: &MachineSpec| Key::new(identities[policy], fidelity, machine);

    let off = experiment.off();
    let culling = || (0..identities.len()).filter(|&policy| policy != off);
    let mut replays: BTreeMap<Key, Replay> = BTreeMap::new();
    for machine in 0..sweep.len() {
        let spec = sweep.machine(machine)?.spec;
        let of_policies = culling().flat_map(|policy| [(policy, Role::AsItIs), (policy, Role::FreeWords)]);
        for (policy, role) in std::iter::once((off, Role::WithoutUnit)).chain(of_policies) {
            replays.insert(key(policy, &role.machine(&spec)), Replay { policy, machine, role });
        }
    }
    replays.retain(|&key, _| match points::read(&points, key) {
        Ok(there) => there.is_none(),
        Err(why) => {
            eprintln!("{}: {why}; the point is made again", key.file(&points).display());
            true
        }
    });
    let streams = streams.have(|policy| replays.values().any(|replay| replay.policy == policy), stop)?;
    run_all(&sweep, &streams, replays, &points, stop)?;

    let mut found = Vec::new();
    for machine in 0..sweep.len() {
        let machine = sweep.machine(machine)?;
        let stats = |policy: usize, role: Role| read_point(&points, key(policy, &role.machine(&machine.spec)));
        let baseline = stats(off, Role::WithoutUnit)?;
        for policy in culling() {
            found.push(SweepPoint::new(
                &machine.name,
                &streams[policy].header.policy,
                machine.changes.clone(),
                [&baseline, &stats(policy, Role::FreeWords)?, &stats(policy, Role::AsItIs)?],
                &streams[policy].totals,
            ));
        }
    }
    Ok(SweepSummary {
        experiment: experiment.spec.name.clone(),
        scene: experiment.scene.name.clone(),
        fidelity: Some(fidelity.to_string()),
        frames: experiment.frames.clone(),
        resolution: experiment.spec.resolution,
        points: found,
    })
}

/// Reads the sweep of the file `path` and all files that it names. Returns how many machines the sweep has.
///
/// # Errors
/// A file is wrong.
pub fn machine_count(path: &Path) -> Result<usize, SweepError> {
    Ok(Sweep::load(path)?.len())
}

/// A point that was made or found good.
fn read_point(folder: &Path, key: Key) -> Result<MachineStats, SweepError> {
    let point = points::read(folder, key).and_then(|point| point.ok_or_else(|| "it is gone".into()));
    point.map_err(|why| SweepError::File { path: key.file(folder), source: std::io::Error::other(why) })
}

/// Makes the replays and keeps their results in the folder `points`.
fn run_all(
    sweep: &Sweep,
    streams: &[Recorded],
    replays: BTreeMap<Key, Replay>,
    points: &Path,
    stop: &AtomicBool,
) -> Result<(), SweepError> {
    let fidelity = sweep.experiment.spec.fidelity;
    let bar = progress::bar("replaying", replays.len(), "replays");
    replays.into_par_iter().try_for_each(|(key, Replay { policy, machine, role })| {
        let machine = role.machine(&sweep.machine(machine)?.spec);
        let stats = replay(&machine, fidelity, &streams[policy], stop)?;
        let file = |source| SweepError::File { path: key.file(points), source };
        points::write(points, key, &stats).map_err(file)?;
        bar.inc(1);
        Ok::<_, SweepError>(())
    })?;
    drop(bar);
    Ok(())
}
