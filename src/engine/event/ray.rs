//! A ray in the machine: an entry of the dispatcher's pool.

use super::steps::Steps;
use crate::engine::host::Place;
use crate::machine::layout::{Element, Layout};
use crate::quantity::LineAddr;
use crate::stats::TrafficClass;
use crate::stream::{Decision, RayKind, Step, Stop};

/// The number of a pool entry. Steps of a frame's end have entries of their own, after the pool's.
pub(super) type RayId = u32;

/// Flag in the number of a ray in a pipeline: the ray is already on its way back to its traversal unit, and only keeps
/// its place in this unit until its operation ends.
pub(super) const GONE: RayId = 1 << 31;
/// Flag beside [`GONE`]: the ray also keeps its context in a list unit until then.
pub(super) const FREES_LIST: RayId = 1 << 30;

/// The unit that works on a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Owner {
    /// The traversal unit with this number.
    Traversal(u32),
    /// The shadow-cache unit with this number.
    ShadowCache(u32),
}

/// A fetch under way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fetch {
    /// The next line to access.
    pub line: LineAddr,
    /// Number of lines still to access, from `line` on.
    pub left: u8,
    /// Number of lines accessed that have not arrived.
    pub missing: u8,
    /// Whether the element is written.
    pub write: bool,
    /// Whether the fetch bypasses the L1.
    pub bypass: bool,
    /// The traffic class.
    pub class: TrafficClass,
    /// Size in bytes.
    pub bytes: u32,
}

/// A ray of the pool. It fills two adjacent cache lines of the simulating processor, which fetches them together.
#[derive(Clone, Debug)]
#[repr(align(128))]
pub(crate) struct Ray {
    /// Its steps.
    pub steps: Steps,
    /// Its kind.
    pub kind: RayKind,
    /// The policy's decision.
    pub decision: Decision,
    /// Whether its requests are also counted separately.
    pub attributed: bool,
    /// Its chunk, and its index there.
    pub place: Place,
    /// The index of the hit that it starts on, and the number of traced shadow rays there; 0 without a gather table.
    pub hit: u32,
    pub siblings: u32,
    /// The cycle in which it was handed over.
    pub handed_over: u64,
    /// The cycle in which it was done.
    pub done: u64,
    /// Lower bound of its latency from hand-over on, in cycles.
    pub unloaded: u64,
    /// The unit that works on it.
    pub owner: Owner,
    /// The list unit that has a context for it.
    pub list: Option<u32>,
    /// Whether the shadow-cache unit's decision is still to be made.
    pub undecided: bool,
    /// Whether its triangle test has reached the edges.
    pub at_edges: bool,
    /// Number of its next steps that set modes on a first touch.
    pub evaluating: u8,
    /// Whether its update is sent down as an operand, which needs no data.
    pub operand: bool,
    /// Whether an intersection unit has accessed its entry, so that only the operation is left.
    pub fetched: bool,
    /// The fetch under way.
    pub fetch: Fetch,
}

const _: () = assert!(size_of::<Ray>() == 128, "two lines of 64 bytes");

impl Default for Ray {
    fn default() -> Self {
        Self {
            steps: Steps::default(),
            kind: RayKind::Primary,
            decision: Decision::Trace,
            attributed: false,
            place: Place::default(),
            hit: 0,
            siblings: 0,
            handed_over: 0,
            done: 0,
            unloaded: 0,
            owner: Owner::ShadowCache(0),
            list: None,
            evaluating: 0,
            operand: false,
            fetched: false,
            undecided: false,
            at_edges: false,
            fetch: Fetch {
                line: LineAddr(0),
                left: 0,
                missing: 0,
                write: false,
                bypass: false,
                class: TrafficClass::Node,
                bytes: 0,
            },
        }
    }
}

impl Ray {
    /// The next step; `None` after the last.
    #[inline]
    pub(crate) fn step(&self) -> Option<Step> {
        self.steps.step()
    }

    /// The next step of the path; `None` after its last.
    #[inline]
    pub(crate) fn path_step(&self) -> Option<Step> {
        self.steps.path_step()
    }

    /// Whether the ray, which has a context in a list unit, still needs it after its next step.
    #[inline]
    pub(crate) fn stays_in_list(&self) -> bool {
        matches!(self.steps.path_step_behind(), Some(Step::List(_) | Step::Triangle { .. }))
    }

    /// Whether a test that went as far as `stop` is followed by a division.
    #[inline]
    pub(crate) fn is_divided(&self, stop: Stop) -> bool {
        stop == Stop::Hit && self.kind != RayKind::Shadow && matches!(self.owner, Owner::Traversal(_))
    }
}

impl Fetch {
    /// A fetch of `element`, not begun.
    #[inline]
    pub(crate) fn of(element: &Element, layout: &Layout) -> Self {
        let (line, lines) = layout.lines(element);
        Self {
            line,
            left: lines as u8,
            missing: 0,
            write: element.write,
            bypass: false,
            class: element.class,
            bytes: element.bytes as u32,
        }
    }

    /// A fetch of a node that lies in one line, not begun.
    #[inline]
    pub(crate) fn of_node(line: LineAddr, bytes: u64) -> Self {
        let (class, bytes) = (TrafficClass::Node, bytes as u32);
        Self { line, left: 1, missing: 0, write: false, bypass: false, class, bytes }
    }

    /// The line of an element that lies in one line, before or after the access.
    pub(crate) fn only_line(&self) -> LineAddr {
        LineAddr(self.line.0 - u64::from(self.left == 0))
    }
}
