//! The points of a sweep: every replay that its report needs, once each, and what each is expected to cost.

use std::collections::HashSet;

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
pub(super) struct Point {
    pub(super) key: Key,
    pub(super) policy: usize,
    pub(super) machine: usize,
    pub(super) role: Role,
    /// Expected cost, in rays that a replay without culling takes as long for.
    pub(super) cost: u64,
}

/// All points of a sweep, in the order of its files. They depend on the sweep's inputs alone: every process that reads
/// the same files has the same plan.
pub(super) struct Plan {
    pub(super) points: Vec<Point>,
    identities: Vec<Identity>,
    off: usize,
}

impl Plan {
    /// The plan of a sweep whose policies have streams with these identities.
    ///
    /// # Errors
    /// A machine cannot be made.
    pub(super) fn new(sweep: &Sweep, identities: &[Identity]) -> Result<Self, SweepError> {
        let mut plan = Self { points: Vec::new(), identities: identities.to_vec(), off: sweep.experiment.off() };
        let rays = rays(sweep);
        let mut seen = HashSet::with_hasher(FxBuildHasher);
        for machine in 0..sweep.len() {
            let spec = sweep.machine(machine)?.spec;
            for (policy, role) in plan.replays() {
                let key = plan.key(sweep, &spec, policy, role);
                if seen.insert(key) {
                    plan.points.push(Point { key, policy, machine, role, cost: rays * weight(role) / 10 });
                }
            }
        }
        Ok(plan)
    }

    /// The key of a machine's replay.
    pub(super) fn key(&self, sweep: &Sweep, machine: &MachineSpec, policy: usize, role: Role) -> Key {
        Key::new(self.identities[policy], sweep.experiment.spec.fidelity, &role.machine(machine))
    }

    /// The policy that the others are measured against.
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

    /// What the plan is known by: eight digits of a hash of all its keys.
    pub(super) fn identity(&self) -> String {
        Key::of_all(self.points.iter().map(|point| point.key)).to_string().chars().take(8).collect()
    }

    /// The points of a shard, in the order of the plan.
    pub(super) fn share(&self, shard: Shard) -> Vec<Point> {
        let dealt = self.deal(shard.of());
        let mine = self.points.iter().zip(dealt).filter(|&(_, place)| place == shard.index());
        mine.map(|(point, _)| *point).collect()
    }

    /// Which of `of` shards has each point. The costliest points are dealt first, each to the shard that has the least;
    /// points of one cost are dealt in the order of their keys, which mixes machines and policies.
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

/// Rays of a stream without culling, secondary ones not counted.
fn rays(sweep: &Sweep) -> u64 {
    let experiment = &sweep.experiment;
    let pixels = experiment.spec.resolution.pixels() as u64 * experiment.frames.len() as u64;
    pixels * (1 + experiment.scene.light_count as u64)
}

/// What a replay costs, in tenths of one without culling: processor time of `Event`, BART kitchen, `Published`, mean of
/// the machines `small` and `desktop`.
fn weight(role: Role) -> u64 {
    match role {
        Role::WithoutUnit => 10,
        Role::FreeWords => 9,
        Role::AsItIs => 11,
    }
}
