//! The shadow-cache unit: does what the culling policy recorded (reads and writes of its stores, occlusion tests), and the
//! decisions for skipped rays.

use std::collections::VecDeque;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::links::{Links, Parts, take};
use super::pipeline::{Pipeline, WritePolicy};
use super::ray::{Owner, RayId};
use crate::memory::Wake;
use crate::memory::cache::CacheSpec;
use crate::ranged::Within;
use crate::stream::Step;

/// The shadow-cache unit. No such hardware is published: all defaults are assumed, sized like the T&I engine's list unit (4 KB
/// of 2 ways).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ShadowCacheSpec {
    /// Stages of the pipeline.
    pub latency: Within<1, 1000>,
    /// Rays that the unit works on at once.
    pub contexts: Within<1, 4096>,
    /// What becomes of writes.
    pub writes: WritePolicy,
    /// The unit's L1.
    pub cache: CacheSpec,
}

impl Default for ShadowCacheSpec {
    fn default() -> Self {
        Self {
            latency: const { Within::literal(2) },
            contexts: const { Within::literal(8) },
            writes: WritePolicy::Back,
            cache: const { CacheSpec { bytes: Within::literal(4 << 10), ..CacheSpec::DEFAULT } },
        }
    }
}

/// The steps of a frame's end under way.
#[derive(Clone, Debug)]
struct FrameEnd {
    steps: Arc<Vec<u32>>,
    begun: usize,
    done: usize,
}

/// The shadow-cache unit.
#[derive(Clone, Debug)]
pub struct ShadowCache {
    /// The common part.
    pub pipeline: Pipeline,
    /// Rays that wait to go to an intersection unit.
    leaving: VecDeque<RayId>,
    contexts: usize,
    free: usize,
    /// The first entry after the pool's: steps of a frame's end use the entries from here on.
    first_entry: RayId,
    free_entries: VecDeque<RayId>,
    frame_end: Option<FrameEnd>,
}

impl ShadowCache {
    /// The unit, empty, of a machine whose pool has `pool` entries.
    pub fn new<W: Wake>(spec: &ShadowCacheSpec, line: u64, pool: u64, links: &Links<W>) -> Self {
        let part = links.parts.shadow_cache();
        let first_entry = pool as RayId;
        Self {
            pipeline: Pipeline::new(part, &spec.cache, spec.latency.get(), line, spec.writes),
            leaving: VecDeque::new(),
            contexts: spec.contexts.size(),
            free: spec.contexts.size(),
            first_entry,
            free_entries: (first_entry..first_entry + spec.contexts.get() as RayId).collect(),
            frame_end: None,
        }
    }

    /// Cycle `now`.
    pub fn tick(&mut self, now: u64, links: &mut Links<impl Wake>) {
        let free_at_start = self.free > 0;
        self.pipeline.arrive(now, links);
        if let Some(id) = self.pipeline.leave(now) {
            self.passed(id, now, links);
        }
        while let Some(id) = take(&mut links.tested, now) {
            self.route(id, now, links);
        }
        if free_at_start {
            self.take_on(now, links);
        }
        let began = self.pipeline.begin(now, &links.rays);
        let part = self.pipeline.part();
        let sent = match self.leaving.front() {
            Some(&id) => links.send_to_test(id, id.checked_sub(self.first_entry).unwrap_or(id), part, now),
            None => false,
        };
        if sent {
            self.leaving.pop_front();
        }
        self.pipeline.end(now, links, began, !self.leaving.is_empty(), false);
        let more = self.free > 0 && (!links.retired.is_empty() || self.next_of_end().is_some());
        if sent && !self.leaving.is_empty() || more {
            links.clock.wake(part, now + 1);
        }
    }

    fn next_of_end(&self) -> Option<u32> {
        self.frame_end.as_ref().and_then(|end| end.steps.get(end.begun)).copied()
    }

    fn take_on(&mut self, now: u64, links: &mut Links<impl Wake>) {
        if links.frame_end.as_ref().is_some_and(|(at, _)| *at <= now) {
            self.frame_end = links.frame_end.take().map(|(_, steps)| FrameEnd { steps, begun: 0, done: 0 });
        }
        if let Some(id) = take(&mut links.retired, now) {
            self.free -= 1;
            let ray = &mut links.rays[id as usize];
            ray.owner = Owner::ShadowCache;
            if ray.undecided { self.pipeline.ready(id, links) } else { self.route(id, now, links) }
        } else if let Some(step) = self.next_of_end()
            && let Some(id) = self.free_entries.pop_front()
        {
            self.free -= 1;
            self.frame_end.iter_mut().for_each(|end| end.begun += 1);
            let ray = &mut links.rays[id as usize];
            (ray.path_end, ray.next, ray.undecided, ray.owner) = (0, 0, false, Owner::ShadowCache);
            ray.steps.clear();
            ray.steps.push(step);
            self.route(id, now, links);
        }
    }

    /// An operation of the ray has ended.
    fn passed(&mut self, id: RayId, now: u64, links: &mut Links<impl Wake>) {
        let ray = &mut links.rays[id as usize];
        if ray.undecided {
            ray.undecided = false;
        } else {
            links.replayed.count_policy(ray.step().into_iter());
            ray.next += 1;
        }
        self.route(id, now, links);
    }

    fn route(&mut self, id: RayId, now: u64, links: &mut Links<impl Wake>) {
        let element = match links.rays[id as usize].step() {
            Some(Step::Triangle { .. }) => return self.leaving.push_back(id),
            Some(Step::Node(node)) => links.layout.node(node),
            Some(Step::List(entry)) => links.layout.list_entry(entry),
            Some(Step::Read { store, index }) => links.layout.entry(store, index, false),
            Some(Step::Write { store, index } | Step::Update { store, index }) => {
                links.layout.entry(store, index, true)
            }
            None => return self.finish(id, now, links),
        };
        self.pipeline.fetch(id, &element, links);
    }

    fn finish(&mut self, id: RayId, now: u64, links: &mut Links<impl Wake>) {
        self.free += 1;
        if id < self.first_entry {
            return links.done(id, now);
        }
        self.free_entries.push_back(id);
        let Some(end) = &mut self.frame_end else {
            unreachable!("only a frame's end uses the entries after the pool's")
        };
        end.done += 1;
        if end.done == end.steps.len() {
            self.frame_end = None;
            links.frame_over = true;
            links.clock.wake(Parts::DISPATCHER, now + 1);
        }
    }

    /// The state of the queues, for the report of a deadlock.
    pub fn queues<W>(&self, links: &Links<W>) -> String {
        format!(
            "{}, to come {}, contexts {}/{}, leaving for intersection {}",
            self.pipeline.queues(),
            links.retired.len(),
            self.contexts - self.free,
            self.contexts,
            self.leaving.len()
        )
    }
}
