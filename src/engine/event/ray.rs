//! A ray in the machine: an entry of the dispatcher's pool.

use super::steps::Steps;
use crate::engine::host::Place;
use crate::machine::layout::{Element, Layout};
use crate::quantity::LineAddr;
use crate::stats::TrafficClass;
use crate::stream::{Decision, RayKind, Step, Stop};

/// The number of a pool entry. Steps of a frame's end have entries of their own, after the pool's.
pub(super) type RayId = u32;

/// Marks the number of a ray in a pipeline that is on its way to its traversal unit already: it leaves behind the place
/// that it had in the unit.
pub(super) const GONE: RayId = 1 << 31;
/// Marks the number of such a ray that leaves behind its context in a list unit, too.
pub(super) const FREES_LIST: RayId = 1 << 30;

/// Who works on a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Owner {
    /// Traversal unit so-and-so.
    Traversal(u32),
    /// Shadow-cache unit so-and-so.
    ShadowCache(u32),
}

/// A fetch under way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fetch {
    /// The next line to access.
    pub line: LineAddr,
    /// Lines to access from there on.
    pub left: u8,
    /// Lines accessed that have not come yet.
    pub missing: u8,
    /// Whether the element is written.
    pub write: bool,
    /// Whether it is fetched from the L2, past the L1.
    pub straight: bool,
    /// What it is for.
    pub class: TrafficClass,
    /// Its size.
    pub bytes: u32,
}

/// A ray of the pool. It fills two lines of the host's cache, which processors fetch together.
#[derive(Clone, Debug)]
#[repr(align(128))]
pub(crate) struct Ray {
    /// Its steps.
    pub steps: Steps,
    /// What it is for.
    pub kind: RayKind,
    /// What the policy decided.
    pub decision: Decision,
    /// Whether what it asks for is counted apart.
    pub marked: bool,
    /// Where it is in the stream.
    pub place: Place,
    /// The place of the hit that it starts on, and that hit's traced shadow rays; 0 where nobody asks.
    pub hit: u32,
    pub siblings: u32,
    /// When it was handed over.
    pub handed_over: u64,
    /// When it was done.
    pub done: u64,
    /// The least that it takes from being handed over on.
    pub unloaded: u64,
    /// Who works on it.
    pub owner: Owner,
    /// The list unit that has a context for it.
    pub list: Option<u32>,
    /// Whether the shadow-cache unit's decision is still to come.
    pub undecided: bool,
    /// Whether its triangle test is at the edges.
    pub at_edges: bool,
    /// How many of its next steps are those of a first touch.
    pub evaluating: u8,
    /// Whether an update goes down as an operand, so that no data is needed for it.
    pub operand: bool,
    /// Whether its entry has been accessed by an intersection unit, so that only the operation is left.
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
            marked: false,
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
                straight: false,
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

    /// Whether the ray, which has a context of a list unit, keeps it behind its next step.
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
    /// A fetch of `element`, not begun yet.
    #[inline]
    pub(crate) fn of(element: &Element, layout: &Layout) -> Self {
        let (line, lines) = layout.lines(element);
        Self {
            line,
            left: lines as u8,
            missing: 0,
            write: element.write,
            straight: false,
            class: element.class,
            bytes: element.bytes as u32,
        }
    }

    /// A fetch of a node that is a line, not begun yet.
    #[inline]
    pub(crate) fn of_node(line: LineAddr, bytes: u64) -> Self {
        let (class, bytes) = (TrafficClass::Node, bytes as u32);
        Self { line, left: 1, missing: 0, write: false, straight: false, class, bytes }
    }

    /// The line of an element that lies in one, whether it was accessed or not.
    pub(crate) fn only_line(&self) -> LineAddr {
        LineAddr(self.line.0 - u64::from(self.left == 0))
    }
}
