//! A ray in flight.

use crate::engine::host::Place;
use crate::engine::work::Holder;
use crate::quantity::NodeId;
use crate::stream::{Decision, RayKind, Step, Totals};

/// A ray in flight, or an end-of-frame step.
#[derive(Clone, Debug)]
pub(crate) struct Flight {
    /// The packed steps of the path, then those of the policy, all checked.
    pub steps: Vec<u32>,
    /// Index of the policy's first step.
    pub path_end: usize,
    /// Index of the next step.
    pub next: usize,
    /// The kind of ray.
    pub kind: RayKind,
    /// The policy's decision.
    pub decision: Decision,
    /// Whether its misses are attributed.
    pub attributed: bool,
    /// The traversal unit that holds it.
    pub unit: u32,
    /// Number of its next steps that set modes at a first touch.
    pub evaluating: u8,
    /// Whether it is an update that waited in a register and so needs no data.
    pub operand: bool,
    /// Its position in the stream.
    pub(super) place: Place,
    /// The place of the hit where the ray starts, and the number of traced shadow rays of that hit; 0 if unused.
    pub hit: u32,
    pub siblings: u32,
}

impl Flight {
    pub(super) const IDLE: Self = Self {
        steps: Vec::new(),
        path_end: 0,
        next: 0,
        kind: RayKind::Primary,
        decision: Decision::Trace,
        attributed: false,
        unit: 0,
        evaluating: 0,
        operand: false,
        place: Place { chunk: 0, index: 0 },
        hit: 0,
        siblings: 0,
    };

    /// The node that the path's next step visits, if it visits one.
    #[inline]
    pub(super) fn visit(&self) -> Option<NodeId> {
        if self.next < self.path_end { Step::node(self.steps[self.next]) } else { None }
    }

    /// The next step of those that `holder` performs; `None` after the last.
    #[inline]
    pub(super) fn step(&self, holder: Holder) -> Option<Step> {
        let end = if holder == Holder::Traversal { self.path_end } else { self.steps.len() };
        (self.next < end).then(|| Step::unpack(self.steps[self.next]).expect("steps are checked at hand-over"))
    }

    /// Counts the performed steps.
    pub(super) fn count(&self, totals: &mut Totals) {
        let performed = &self.steps[..self.next];
        let (path, policy) = performed.split_at(self.path_end.min(self.next));
        let nodes = path.iter().filter(|&&word| matches!(Step::unpack(word), Some(Step::Node(_)))).count() as u64;
        let lists = path.iter().filter(|&&word| matches!(Step::unpack(word), Some(Step::List(_)))).count() as u64;
        let triangles = path.len() as u64 - nodes - lists;
        totals.list_reads += lists;
        let (visits, tests) = match self.kind {
            RayKind::Shadow => (&mut totals.shadow_node_visits, &mut totals.shadow_triangle_tests),
            _ => (&mut totals.node_visits, &mut totals.triangle_tests),
        };
        (*visits, *tests) = (*visits + nodes, *tests + triangles);
        totals.count_policy(Step::unpack_all(policy));
    }

    /// Whether the ray has policy steps.
    pub(super) fn has_policy(&self) -> bool {
        self.path_end < self.steps.len()
    }
}
