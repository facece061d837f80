//! The points of a sweep: every replay that its report needs, once each, with its expected cost.

use std::collections::{HashMap, HashSet};

use rustc_hash::FxBuildHasher;

use super::super::split::Role;
use super::error::SweepError;
use super::points::Key;
use super::shard::Shard;
use super::spec::Sweep;
use super::streams::Identity;
use crate::machine::MachineSpec;

/// A point: a replay of a policy's stream on a machine in a role.
#[derive(Clone, Copy)]
pub(in super::super) struct Point {
    pub(in super::super) key: Key,
    pub(in super::super) policy: usize,
    pub(in super::super) machine: usize,
    pub(in super::super) role: Role,
    /// Expected cost: the number of rays whose replay without culling takes as long.
    pub(in super::super) cost: u64,
    /// The point that is the baseline of this one, where samples have a target error. A baseline itself has none.
    pub(in super::super) baseline: Option<Key>,
}

/// All points of a sweep, in the order of its files; for a space, its first set. They depend on the sweep's inputs
/// alone, so every process that reads the same files has the same plan.
pub(in super::super) struct Plan {
    pub(in super::super) points: Vec<Point>,
    identities: Vec<Identity>,
    off: usize,
}

impl Plan {
    /// The plan of a sweep whose policies' streams have these identities.
    ///
    /// # Errors
    /// A machine cannot be made.
    pub(in super::super) fn new(sweep: &Sweep, identities: &[Identity]) -> Result<Self, SweepError> {
        let mut plan = Self { points: Vec::new(), identities: identities.to_vec(), off: sweep.experiment.off() };
        plan.points = match sweep.first_set() {
            None => plan.candidates(sweep, &plan.replays().collect::<Vec<_>>())?,
            Some(machines) => plan.first_set(sweep, machines)?,
        };
        Ok(plan)
    }

    /// The replays of all machines under these policies in these roles, each replay once.
    pub(in super::super) fn candidates(
        &self,
        sweep: &Sweep,
        replays: &[(usize, Role)],
    ) -> Result<Vec<Point>, SweepError> {
        let rays = rays(sweep);
        let mut seen = HashSet::with_hasher(FxBuildHasher);
        let mut points = Vec::new();
        for machine in 0..sweep.len() {
            let spec = sweep.machine(machine)?.spec;
            for &(policy, role) in replays {
                let (key, baseline) = self.keys(sweep, (machine, &spec), policy, role);
                if seen.insert(key) {
                    points.push(Point { key, policy, machine, role, cost: rays * weight(role) / 10, baseline });
                }
            }
        }
        Ok(points)
    }

    /// The first set of a space: for each machine of the experiment under each policy, the first `machines` variants.
    fn first_set(&self, sweep: &Sweep, machines: usize) -> Result<Vec<Point>, SweepError> {
        let mut taken: HashMap<(usize, usize), usize, FxBuildHasher> = HashMap::default();
        let mut is_first = |point: &Point| {
            let taken = taken.entry((sweep.base(point.machine), point.policy)).or_default();
            *taken += 1;
            *taken <= machines
        };
        Ok(self.candidates(sweep, &self.designs())?.into_iter().filter(|point| is_first(point)).collect())
    }

    /// The policies of a space's designs, each with the role of its machines.
    pub(in super::super) fn designs(&self) -> Vec<(usize, Role)> {
        let role = |policy| if policy == self.off { Role::WithoutUnit } else { Role::AsItIs };
        (0..self.identities.len()).map(|policy| (policy, role(policy))).collect()
    }

    /// The key of the replay of a machine, given by its number and spec.
    pub(in super::super) fn key(
        &self,
        sweep: &Sweep,
        (machine, spec): (usize, &MachineSpec),
        policy: usize,
        role: Role,
    ) -> Key {
        self.keys(sweep, (machine, spec), policy, role).0
    }

    /// The key of the replay of a machine, and the key of its baseline if that is another replay.
    fn keys(
        &self,
        sweep: &Sweep,
        (machine, spec): (usize, &MachineSpec),
        policy: usize,
        role: Role,
    ) -> (Key, Option<Key>) {
        let level = (sweep.experiment.spec.fidelity, sweep.cut(machine));
        let key =
            |spec: &MachineSpec, beside: Option<&MachineSpec>| Key::new(self.identities[policy], level, spec, beside);
        let own = role.machine(spec);
        let Some(baseline) = sweep.baseline(machine) else { return (key(&own, None), None) };
        let baseline = role.of_baseline().machine(baseline);
        let of_baseline = key(&baseline, None);
        match key(&own, None) {
            itself if itself == of_baseline => (itself, None),
            _ => (key(&own, Some(&baseline)), Some(of_baseline)),
        }
    }

    /// The index of the policy `Off`, the baseline of the others.
    pub(super) fn off(&self) -> usize {
        self.off
    }

    /// The other policies.
    pub(super) fn culling(&self) -> impl Iterator<Item = usize> + use<> {
        let off = self.off;
        (0..self.identities.len()).filter(move |&policy| policy != off)
    }

    /// The policies and roles in which every machine is replayed.
    fn replays(&self) -> impl Iterator<Item = (usize, Role)> + use<> {
        let of_policies = self.culling().flat_map(|policy| [(policy, Role::FreeWords), (policy, Role::AsItIs)]);
        std::iter::once((self.off, Role::WithoutUnit)).chain(of_policies)
    }

    /// The plan's identity: eight digits of a hash of all its keys.
    pub(in super::super) fn identity(&self) -> String {
        Key::of_all(self.points.iter().map(|point| point.key)).to_string().chars().take(8).collect()
    }

    /// The identities of all its streams.
    pub(in super::super) fn streams(&self) -> String {
        self.identities.iter().map(|identity| identity.to_string()).collect::<Vec<_>>().join(" ")
    }

    /// The points of a shard, in the order of the plan.
    pub(super) fn share(&self, shard: Shard) -> Vec<Point> {
        let dealt = self.deal(shard.of());
        let mine = self.points.iter().zip(dealt).filter(|&(_, place)| place == shard.index());
        mine.map(|(point, _)| *point).collect()
    }

    /// The shard of each point, with `of` shards. The costliest points are dealt first, each to the shard with the
    /// least cost so far. Points of equal cost are dealt in the order of their keys, which mixes machines and
    /// policies.
    pub(super) fn deal(&self, of: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.points.len()).collect();
        order.sort_by(|&a, &b| {
            let [a, b] = [a, b].map(|point| &self.points[point]);
            b.cost.cmp(&a.cost).then(a.key.cmp(&b.key))
        });
        let mut loads = vec![0; of];
        let mut dealt = vec![0; self.points.len()];
        for point in order {
            let least = (0..of).min_by_key(|&shard| loads[shard]).unwrap_or_default();
            loads[least] += self.points[point].cost;
            dealt[point] = least;
        }
        dealt
    }
}

/// Rays of a stream without culling, without secondary rays.
fn rays(sweep: &Sweep) -> u64 {
    let experiment = &sweep.experiment;
    let pixels = experiment.spec.resolution.pixels() as u64 * experiment.frames.len() as u64;
    pixels * (1 + experiment.scene.light_count as u64)
}

/// The cost of a replay, in tenths of the cost without culling: processor time of `Event`, BART kitchen, `Published`,
/// mean of the machines `small` and `desktop`.
fn weight(role: Role) -> u64 {
    match role {
        Role::WithoutUnit => 10,
        Role::FreeWords => 9,
        Role::AsItIs => 11,
    }
}
