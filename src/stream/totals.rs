//! What the tracer counts in a frame, and what the records hold: the two must be equal.

use serde::{Deserialize, Serialize};

use super::chunk::{Chunk, Decision, Ray, RayHead, RayKind};
use super::step::{Effect, Step};

/// What the tracer counted while it traced a frame, by counters of its own. [`Totals::count`] derives the same from the
/// records: the two must be equal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Totals {
    /// Primary rays: one a pixel.
    pub primary_rays: u64,
    /// Reflected and refracted rays.
    pub secondary_rays: u64,
    /// Shadow rays that there would be without culling.
    pub shadow_rays: u64,
    /// Shadow rays whose answer was known: nothing was traced.
    pub shadow_rays_skipped: u64,
    /// Shadow rays traced among dynamic objects only.
    pub shadow_rays_dynamic_only: u64,
    /// Node visits of primary and secondary rays.
    pub node_visits: u64,
    /// Triangle tests of primary and secondary rays.
    pub triangle_tests: u64,
    /// Node visits of shadow rays.
    pub shadow_node_visits: u64,
    /// Triangle tests of shadow rays.
    pub shadow_triangle_tests: u64,
    /// Entries of primitive lists read by any ray.
    pub list_reads: u64,
    /// Triangle tests made by the policy (occlusion tests, occluders tested again).
    pub policy_triangle_tests: u64,
    /// Nodes visited by the policy (shaft queries).
    pub policy_node_visits: u64,
    /// Reads of the policy's stores.
    pub policy_reads: u64,
    /// Writes and read-modify-writes of the policy's stores.
    pub policy_writes: u64,
    /// Updates among them, on rays' account, of which an earlier one of the frame has set all bits
    /// ([`Effect::Repeats`]).
    pub repeated_updates: u64,
    /// Updates among them, on rays' account, that change no bit of the latched word ([`Effect::Silent`]).
    pub silent_updates: u64,
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
        for step in steps {
            match step {
                Step::Node(_) => self.policy_node_visits += 1,
                Step::List(_) => self.list_reads += 1,
                Step::Triangle { .. } => self.policy_triangle_tests += 1,
                Step::Read { .. } => self.policy_reads += 1,
                Step::Write { .. } | Step::Update { .. } => self.policy_writes += 1,
            }
        }
    }

    /// Counts a ray.
    pub fn count(&mut self, ray: &Ray<'_>) {
        self.count_head(&ray.head);
        self.count_path(&ray.head, Step::count(ray.packed_path()));
        self.count_policy_of(ray);
    }

    /// Counts the policy's steps on a ray's account, and what its updates change.
    fn count_policy_of(&mut self, ray: &Ray<'_>) {
        self.count_policy(ray.policy());
        let with = |effect| ray.packed_policy().iter().filter(|&&word| Step::effect(word) == Some(effect)).count();
        self.repeated_updates += with(Effect::Repeats) as u64;
        self.silent_updates += with(Effect::Silent) as u64;
    }

    /// Counts the rays of a chunk, each as [`Totals::count`] does.
    pub fn count_chunk(&mut self, chunk: &Chunk) {
        let is_shadow = |ray: usize| chunk.head(ray).kind == RayKind::Shadow;
        let mut next = 0;
        while next < chunk.len() {
            // The steps of rays of the same kind lie together, and are counted together.
            let first = next;
            let [mut nodes, mut lists, mut others] = [0; 3];
            while next < chunk.len() && is_shadow(next) == is_shadow(first) {
                let ray = chunk.ray(next);
                self.count_head(&ray.head);
                if !ray.packed_policy().is_empty() {
                    let policy = Step::count(ray.packed_policy());
                    [nodes, lists, others] = [nodes + policy[0], lists + policy[1], others + policy[2]];
                    self.count_policy_of(&ray);
                }
                next += 1;
            }
            let all = Step::count(chunk.packed_steps_of(first..next));
            self.count_path(&chunk.head(first), [all[0] - nodes, all[1] - lists, all[2] - others]);
        }
    }

    fn count_head(&mut self, head: &RayHead) {
        match head.kind {
            RayKind::Primary => self.primary_rays += 1,
            RayKind::Reflection | RayKind::Refraction => self.secondary_rays += 1,
            RayKind::Shadow => {
                self.shadow_rays += 1;
                match head.decision {
                    Decision::Trace => {}
                    Decision::DynamicOnly => self.shadow_rays_dynamic_only += 1,
                    Decision::Skip => self.shadow_rays_skipped += 1,
                }
            }
        }
    }

    /// Counts steps of paths of rays such as `head`.
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

impl std::ops::AddAssign for Totals {
    fn add_assign(&mut self, other: Self) {
        self.primary_rays += other.primary_rays;
        self.secondary_rays += other.secondary_rays;
        self.shadow_rays += other.shadow_rays;
        self.shadow_rays_skipped += other.shadow_rays_skipped;
        self.shadow_rays_dynamic_only += other.shadow_rays_dynamic_only;
        self.node_visits += other.node_visits;
        self.triangle_tests += other.triangle_tests;
        self.shadow_node_visits += other.shadow_node_visits;
        self.shadow_triangle_tests += other.shadow_triangle_tests;
        self.list_reads += other.list_reads;
        self.policy_triangle_tests += other.policy_triangle_tests;
        self.policy_node_visits += other.policy_node_visits;
        self.policy_reads += other.policy_reads;
        self.policy_writes += other.policy_writes;
        self.repeated_updates += other.repeated_updates;
        self.silent_updates += other.silent_updates;
    }
}

/// Names of the totals, in the order of [`totals_values`].
pub const TOTALS_NAMES: [&str; 16] = [
    "primary_rays",
    "secondary_rays",
    "shadow_rays",
    "shadow_rays_skipped",
    "shadow_rays_dynamic_only",
    "node_visits",
    "triangle_tests",
    "shadow_node_visits",
    "shadow_triangle_tests",
    "list_reads",
    "policy_triangle_tests",
    "policy_node_visits",
    "policy_reads",
    "policy_writes",
    "repeated_updates",
    "silent_updates",
];

/// The totals in the order of the file. Taken apart by name, so that a new total cannot be forgotten here.
pub fn totals_values(totals: &Totals) -> [u64; TOTALS_NAMES.len()] {
    let Totals {
        primary_rays,
        secondary_rays,
        shadow_rays,
        shadow_rays_skipped,
        shadow_rays_dynamic_only,
        node_visits,
        triangle_tests,
        shadow_node_visits,
        shadow_triangle_tests,
        list_reads,
        policy_triangle_tests,
        policy_node_visits,
        policy_reads,
        policy_writes,
        repeated_updates,
        silent_updates,
    } = *totals;
    [
        primary_rays,
        secondary_rays,
        shadow_rays,
        shadow_rays_skipped,
        shadow_rays_dynamic_only,
        node_visits,
        triangle_tests,
        shadow_node_visits,
        shadow_triangle_tests,
        list_reads,
        policy_triangle_tests,
        policy_node_visits,
        policy_reads,
        policy_writes,
        repeated_updates,
        silent_updates,
    ]
}
