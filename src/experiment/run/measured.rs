//! What the machines of a run measured.

use std::collections::BTreeMap;

use super::super::load::Experiment;
use super::super::replay::Finished;
use super::super::split::Role;
use super::failure::RunFailure;
use super::gathered::Gathered;
use super::stages::Stages;
use crate::machine::MachineSpec;
use crate::named::Named;
use crate::replay::{are_units_idle, with_other_units};
use crate::report::run::{Asked, MachineRun, MachineSummary, OverTime};
use crate::report::split::Split;
use crate::stats::{FrameReuse, MachineStats};
use crate::stream::{Header, Totals};

/// A machine's statistics on the stream of a policy.
struct Replay {
    policy: usize,
    role: Role,
    stats: MachineStats,
}

/// The replays of each machine, by name.
pub(super) struct Measured {
    replays: BTreeMap<String, Vec<Replay>>,
    /// The course of the replays that were recorded.
    pub over_time: OverTime,
}

impl Measured {
    /// Takes the results of all replays; adds the time of each to `stages`.
    ///
    /// # Errors
    /// A replay failed.
    pub(super) fn new(finished: Vec<Finished>, names: &[&str], stages: &mut Stages) -> Result<Self, RunFailure> {
        let mut measured = Self { replays: BTreeMap::new(), over_time: OverTime::new() };
        for Finished { policy, machine, role, result } in finished {
            let name = names[policy];
            let replayed = result.map_err(|source| RunFailure::Machine {
                machine: machine.clone(),
                policy: name.to_owned(),
                source: Box::new(source),
            })?;
            let stage = format!("{machine}, {name}, {}", role.name());
            stages.add(stage, replayed.wall, Some(rays(&replayed.stats)));
            if !replayed.over_time.is_empty() {
                measured.over_time.insert((machine.clone(), name.to_owned()), replayed.over_time);
            }
            measured.replays.entry(machine).or_default().push(Replay { policy, role, stats: replayed.stats });
        }
        Ok(measured)
    }

    /// The machines' summaries, in the experiment's order.
    pub(super) fn summaries(
        &self,
        experiment: &Experiment,
        headers: &[Header],
        gathered: &Gathered,
        reuse: &Named<FrameReuse>,
    ) -> Named<MachineSummary> {
        let asked = |policy: usize| {
            let totals = &gathered.totals[policy];
            let rays = totals.primary_rays + totals.secondary_rays + totals.shadow_rays;
            let asked = Asked { frames: gathered.measured.len(), rays };
            (asked.frames > 0).then_some(asked)
        };
        let summary = |(name, machine): (_, &MachineSpec)| {
            let replays = self.replays.get(name)?;
            let as_it_is = replays.iter().filter(|replay| replay.role == Role::AsItIs);
            let run = |replay: &Replay| {
                let run = MachineRun::new(replay.stats.clone(), asked(replay.policy));
                (headers[replay.policy].policy.clone(), run)
            };
            let summary = MachineSummary {
                fidelity: experiment.spec.fidelity.to_string(),
                frames: gathered.measured.clone(),
                warmup: gathered.warmup.clone(),
                policies: as_it_is.map(run).collect(),
                split: split(machine, (headers, experiment.off()), replays, &gathered.totals),
                reuse: reuse.get(name).cloned(),
            };
            Some((name, summary))
        };
        experiment.machines.iter().filter_map(summary).collect()
    }
}

/// Rays that a machine replayed, warm-up frames included.
fn rays(stats: &MachineStats) -> u64 {
    let all = stats.frames.iter().map(|frame| frame.rays).sum();
    if stats.frames.is_empty() { stats.rays } else { all }
}

/// What each culling policy saved and cost on `machine`; `off` is the policy without culling, and `totals` counts the
/// rays of each policy.
fn split(
    machine: &MachineSpec,
    (headers, off): (&[Header], usize),
    replays: &[Replay],
    totals: &[Totals],
) -> Named<Split> {
    let of = |policy: usize, role: Role| {
        replays.iter().find(|replay| (replay.policy, replay.role) == (policy, role)).map(|replay| &replay.stats)
    };
    let removed = |plain| with_other_units(&Role::WithoutUnit.machine(machine), &headers[off], plain);
    let without = match are_units_idle(machine) {
        true => of(off, Role::AsItIs).map(removed),
        false => of(off, Role::WithoutUnit).cloned(),
    };
    let split = |policy: usize| {
        let all = [without.as_ref()?, of(policy, Role::FreeWords)?, of(policy, Role::AsItIs)?];
        Some((headers[policy].policy.clone(), Split::new(all, &totals[policy])))
    };
    (0..headers.len()).filter(|&policy| policy != off).filter_map(split).collect()
}
