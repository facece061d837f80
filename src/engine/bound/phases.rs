//! Frames and end-of-frame updates follow one another: each is a phase, and the bounds of phases add up.

use super::host::HostWork;
use super::steps::{StepWork, Steps};
use super::sums::Sums;
use crate::engine::source::parents;
use crate::machine::MachineSpec;
use crate::machine::kinds::Kind;
use crate::stream::{Chunk, Decision, Header, Item, RayKind};

/// Sums the bounds of a stream.
#[derive(Clone, Debug)]
pub(in crate::engine) struct Bound {
    pub(super) machine: MachineSpec,
    /// Whether the answers of all shadow rays are known at no cost.
    oracle: bool,
    pub(super) steps: StepWork,
    // Of the current phase:
    rays: u64,
    pool_held: u64,
    slots_held: u64,
    longest: u64,
    host: HostWork,
    primitives: u64,
    /// The number of the current frame; `frames` has the completed frames.
    number: u32,
    pub(super) frames: Vec<(u32, Sums)>,
}

impl Bound {
    /// The bounds of a stream before it begins.
    pub(in crate::engine) fn new(machine: &MachineSpec, header: &Header, oracle: bool) -> Self {
        Self {
            oracle,
            steps: StepWork::new(machine, header),
            rays: 0,
            pool_held: 0,
            slots_held: 0,
            longest: 0,
            host: HostWork::new(machine),
            primitives: header.primitives.into(),
            number: 0,
            frames: Vec::new(),
            machine: machine.clone(),
        }
    }

    /// Adds the stream's next item. Other parts report invalid items.
    pub(in crate::engine) fn add(&mut self, item: &Item) {
        match item {
            Item::Frame(info) => {
                self.steps.begin_frame(info);
                self.host.begin_frame(info, &self.steps.layout, &mut self.steps.sums);
                // A sweep sets the words and counters of all primitives.
                self.steps.sums.left_out += 2 * self.primitives;
                self.number = info.number;
            }
            Item::Rays(chunk) => self.chunk(chunk),
            Item::End { policy, .. } => {
                self.end_phase();
                for word in policy.chunks(1) {
                    let held = self.steps.add(word, Steps::Policy);
                    self.steps.work[Kind::ShadowCache as usize].held += held;
                    self.longest = self.longest.max(held);
                }
                self.end_phase();
                self.frames.push((self.number, std::mem::take(&mut self.steps.sums)));
            }
        }
    }

    fn chunk(&mut self, chunk: &Chunk) {
        let Ok(parents) = parents(chunk) else { return };
        let (latency, shading) = (self.machine.dispatcher.latency.get(), self.machine.dispatcher.shading_cycles.get());
        // Minimum cycles from the first hand-over in a ray's group to the ray's completion.
        let mut done = vec![0; chunk.len()];
        for index in 0..chunk.len() {
            let ray = chunk.ray(index);
            self.steps.sums.answered += 1;
            let known = self.oracle && ray.head.kind == RayKind::Shadow;
            let skipped = known || ray.head.decision == Decision::Skip;
            let mut slot = if skipped { 0 } else { latency };
            let mut policy = 0;
            if !skipped {
                let steps = if ray.head.kind == RayKind::Shadow { Steps::ShadowPath } else { Steps::Path };
                slot += self.steps.add(ray.packed_path(), steps);
                self.slots_held += slot;
                self.steps.sums.traced += 1;
            }
            let spec = &self.machine.shadow_cache;
            let performed = ray.packed_policy().iter().filter(|&&word| spec.performs(word));
            if !known && spec.decide.answers(ray.head.decision, performed.count()) {
                done[index] = done[parents[index] as usize] + shading;
                self.longest = self.longest.max(done[index]);
                continue;
            }
            if !known && spec.decide.takes_an_operation(ray.head.decision) {
                policy += self.steps.kinds[Kind::ShadowCache as usize].latency;
                self.steps.decide();
            }
            if !known {
                self.host.ray(&ray, &mut self.steps.sums);
                let kept = ray.packed_policy().split(|&word| spec.silent.drops(word));
                policy += kept.map(|words| self.steps.add(words, Steps::Policy)).sum::<u64>();
                self.steps.work[Kind::ShadowCache as usize].held += policy;
                self.rays += 1;
                self.pool_held += slot + policy;
            }
            let parent = parents[index] as usize;
            done[index] = slot + policy + if parent == index { 0 } else { done[parent] + shading };
            self.longest = self.longest.max(done[index]);
            // Serial time: some cycles from part to part in addition to the counted cycles.
            self.steps.sums.serial += slot + policy + latency + shading + 16;
        }
    }

    /// Ends a phase: no later work can overlap the rays of a frame or the steps of an end-of-frame update.
    fn end_phase(&mut self) {
        self.steps.settle();
        let mut least = self.longest;
        let StepWork { kinds, work, lines, divisions, .. } = &self.steps;
        let mut at_least = |work: u64, rate: u64| least = least.max(work.div_ceil(rate));
        let (cores, division) = (self.machine.cores.get(), &self.machine.division);
        at_least(self.rays, cores * self.machine.dispatcher.per_cycle.get());
        at_least(self.pool_held, self.machine.pool());
        at_least(self.slots_held, self.machine.traversal.rays.get() * kinds[Kind::Traversal as usize].count);
        at_least(divisions * division.interval.get(), cores * division.count.get());
        for (unit, work) in kinds.iter().zip(work) {
            at_least(work.operations * unit.interval, unit.count * unit.width);
            at_least(work.accesses, unit.count * unit.cache.accesses_per_cycle());
            if let Some(contexts) = unit.contexts {
                at_least(work.held, unit.count * contexts);
            }
        }
        lines.banks.iter().for_each(|&requests| at_least(requests, cores));
        if let Some((bytes, cycles)) = self.machine.dram.channel_peak(self.machine.clock_mhz.get()) {
            let line = self.machine.line_bytes.get();
            lines.channels.iter().for_each(|&lines| at_least(lines * line * cycles / bytes, 1));
        }
        // The frame's rays wait until its dynamic part is built; the host's lines do not.
        let building = self.host.building;
        self.steps.sums.cycles += self.host.least(&lines.channels).max(least + building);
        self.steps.sums.serial += building;
        self.host.end_phase();
        (self.rays, self.pool_held, self.slots_held, self.longest) = (0, 0, 0, 0);
        self.steps.end_phase();
    }
}
