//! Counters of a frame, kept by the tracer and derived from the records: both must be equal.

use super::chunk::{Chunk, Decision, Ray, RayHead, RayKind};
use super::step::{Effect, Step};
use crate::counters::counters;

counters! {
    /// Counters that the tracer keeps while it traces a frame. [`Totals::count`] derives the same numbers from the
    /// records: both must be equal. A file holds the counters in this order.
    pub struct Totals {
        primary_rays: "rays", "rays from the camera: one per pixel";
        secondary_rays: "rays", "reflected and refracted rays";
        shadow_rays: "rays", "shadow rays without culling: one for each hit and each light that needs one there";
        shadow_rays_skipped: "rays", "shadow rays whose answer was known: nothing was traced";
        shadow_rays_dynamic_only: "rays", "shadow rays traced among dynamic triangles only";
        node_visits: "visits", "nodes fetched by primary and secondary rays";
        triangle_tests: "tests", "triangles tested by primary and secondary rays";
        shadow_node_visits: "visits", "nodes fetched by shadow rays";
        shadow_triangle_tests: "tests", "triangles tested by shadow rays";
        list_reads: "reads", "entries of the kd-tree's primitive lists read by any ray or policy";
        policy_triangle_tests: "tests", "triangles tested by the policy itself, occlusion tests included";
        policy_node_visits: "visits", "nodes fetched by the policy itself (shaft queries, searches below a node)";
        policy_reads: "accesses", "reads of the policy's stores: mode words, counters, occluder ids";
        policy_writes: "accesses", "writes to the policy's stores, including read-modify-writes";
        repeated_updates: "accesses",
            "updates of rays, among policy_writes, with all bits already set by earlier updates of the frame";
        silent_updates: "accesses",
            "updates of rays, among policy_writes, that change no bit of the latched word";
    }
}

impl Totals {
    /// Counts a node that a ray of a kind visits.
    #[inline]
    pub fn count_visit(&mut self, ray: RayKind) {
        match ray {
            RayKind::Shadow => self.shadow_node_visits += 1,
            RayKind::Primary | RayKind::Reflection | RayKind::Refraction => self.node_visits += 1,
        }
    }

    /// Counts a policy's steps.
    pub fn count_policy(&mut self, steps: impl Iterator<Item = Step>) {
        steps.for_each(|step| self.count_policy_step(step, 1));
    }

    /// Counts `times` steps of a policy, all of the kind of `step`.
    #[inline]
    fn count_policy_step(&mut self, step: Step, times: u64) {
        match step {
            Step::Node(_) => self.policy_node_visits += times,
            Step::List(_) => self.list_reads += times,
            Step::Triangle { .. } => self.policy_triangle_tests += times,
            Step::Read { .. } => self.policy_reads += times,
            Step::Write { .. } | Step::Update { .. } => self.policy_writes += times,
        }
    }

    /// Counts a ray.
    pub fn count(&mut self, ray: &Ray<'_>) {
        self.count_ray(ray.head.kind, ray.head.decision);
        self.count_path(&ray.head, Step::count(ray.packed_path()));
        let mut tags = [0; Step::TAGS];
        ray.packed_policy().iter().for_each(|&word| tags[Step::tag(word) as usize] += 1);
        self.count_policy_tags(&tags);
    }

    /// Counts the policy's steps for rays, given their number for each tag, and the effects of updates among them.
    fn count_policy_tags(&mut self, tags: &[u64; Step::TAGS]) {
        for (tag, &times) in tags.iter().enumerate().filter(|&(_, &times)| times > 0) {
            if let Some(step) = Step::of_tag(tag) {
                self.count_policy_step(step, times);
            }
            match Step::effect(Step::packed(tag as u32, 0)) {
                Some(Effect::Repeats) => self.repeated_updates += times,
                Some(Effect::Silent) => self.silent_updates += times,
                Some(Effect::Changes) | None => {}
            }
        }
    }

    /// Counts the rays of a chunk, each as [`Totals::count`] does.
    pub fn count_chunk(&mut self, chunk: &Chunk) {
        let is_shadow = |ray: usize| chunk.head(ray).kind == RayKind::Shadow;
        let (mut next, mut tags) = (0, [0; Step::TAGS]);
        while next < chunk.len() {
            // The steps of a run of shadow rays, or of other rays, are counted together.
            let first = next;
            let [mut nodes, mut lists, mut policy] = [0; 3];
            while next < chunk.len() && is_shadow(next) == is_shadow(first) {
                let ray = chunk.ray(next);
                self.count_ray(ray.head.kind, ray.head.decision);
                for &word in ray.packed_policy() {
                    let tag = Step::tag(word);
                    tags[tag as usize] += 1;
                    nodes += u64::from(tag as i32 == Step::NODE);
                    lists += u64::from(tag as i32 == Step::LIST);
                    policy += 1;
                }
                next += 1;
            }
            let all = Step::count(chunk.packed_steps_of(first..next));
            self.count_path(&chunk.head(first), [all[0] - nodes, all[1] - lists, all[2] - (policy - nodes - lists)]);
        }
        self.count_policy_tags(&tags);
    }

    /// Counts a ray of `kind` with the policy's `decision`.
    #[inline]
    pub fn count_ray(&mut self, kind: RayKind, decision: Decision) {
        match kind {
            RayKind::Primary => self.primary_rays += 1,
            RayKind::Reflection | RayKind::Refraction => self.secondary_rays += 1,
            RayKind::Shadow => {
                self.shadow_rays += 1;
                match decision {
                    Decision::Trace => {}
                    Decision::DynamicOnly => self.shadow_rays_dynamic_only += 1,
                    Decision::Skip => self.shadow_rays_skipped += 1,
                }
            }
        }
    }

    /// Counts path steps of rays of the kind of `head`.
    fn count_path(&mut self, head: &RayHead, [nodes, lists, triangles]: [u64; 3]) {
        self.list_reads += lists;
        if head.kind == RayKind::Shadow {
            self.shadow_node_visits += nodes;
            self.shadow_triangle_tests += triangles;
        } else {
            self.node_visits += nodes;
            self.triangle_tests += triangles;
        }
    }
}
