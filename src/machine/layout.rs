//! The memory layout: translates ids of the stream into addresses.
//!
//! Each array begins at a multiple of 4 KiB, from address 0 on: static nodes, static primitive lists, static triangle
//! records, the policy's stores ([`super::stores`]). The dynamic part follows: nodes, lists and triangle records of the
//! frame, from a base that is the same in every frame.

use super::shadow_cache::{FrameEnd, Place};
use super::spec::MachineSpec;
use super::stores::{StoreLayout, Stores};
use super::word_traffic::LatchedCopy;
use crate::quantity::{Addr, LineAddr, ListId, NodeId, TriangleSlot};
use crate::stats::TrafficClass;
use crate::stream::{FrameInfo, Header, Step, Stop, Store, StoreEntries};

const ALIGNMENT: u64 = 4096;
const LIST_ENTRY_BYTES: u64 = 4;

/// Bytes of a triangle: plane, then edges (Nah et al. 2011, section 4). A record can be larger
/// ([`StoreLayout::Record`]).
pub(crate) const TRIANGLE_BYTES: u64 = PLANE_BYTES + EDGE_BYTES;
/// Bytes of the plane, which a triangle test reads first.
pub(crate) const PLANE_BYTES: u64 = 16;
/// Bytes of the edges, which a triangle test reads if the ray hits the plane.
pub(crate) const EDGE_BYTES: u64 = 32;

/// A range of memory that one access reads or writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Element {
    /// Its first byte.
    pub addr: Addr,
    /// Its size in bytes.
    pub bytes: u64,
    /// The traffic class that it is counted under.
    pub class: TrafficClass,
    /// Whether the access is a write.
    pub write: bool,
}

/// An array with a static and a dynamic part.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Array {
    element: u64,
    static_count: u64,
    static_base: u64,
    dynamic_count: u64,
    dynamic_base: u64,
}

impl Array {
    fn len(&self) -> u64 {
        self.static_count + self.dynamic_count
    }

    #[inline]
    fn addr(&self, index: u32) -> Addr {
        let index = u64::from(index);
        Addr(match index.checked_sub(self.static_count) {
            None => self.static_base + index * self.element,
            Some(index) => self.dynamic_base + index * self.element,
        })
    }
}

/// The lines of nodes that are exactly one line long.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NodeLines {
    /// Bytes of a node, equal to the bytes of a line.
    pub bytes: u64,
    static_count: u64,
    static_first: u64,
    /// Line of the first dynamic node, minus the number of static nodes: a dynamic node's id is added to it.
    dynamic_first: u64,
}

impl NodeLines {
    /// The line of a node.
    #[inline]
    pub(crate) fn of(&self, NodeId(index): NodeId) -> LineAddr {
        let index = u64::from(index);
        let first = if index < self.static_count { self.static_first } else { self.dynamic_first };
        LineAddr(first.wrapping_add(index))
    }
}

/// The layout of a stream's current frame.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layout {
    nodes: Array,
    lists: Array,
    triangles: Array,
    stores: Stores,
    entries: StoreEntries,
    dynamic_base: u64,
    line_shift: u32,
    /// `None` before the first frame, and where a node is not one line long.
    node_lines: Option<NodeLines>,
}

/// The distance between the dynamic parts of two layouts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shift {
    /// The first line of the dynamic part.
    pub first: LineAddr,
    /// Lines from there to the same data in the other layout.
    pub by: i64,
}

impl Shift {
    /// The line with the same data in the other layout.
    #[inline]
    pub(crate) fn line(self, line: LineAddr) -> LineAddr {
        if line >= self.first { LineAddr(line.0.wrapping_add_signed(self.by)) } else { line }
    }
}

/// An id in the stream beyond what its header and frame announce.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{what} {index} does not exist: the stream's header and frame announce {len}")]
pub struct OutOfRange {
    what: &'static str,
    index: u32,
    len: u64,
}

impl Layout {
    /// The layout of a stream on a machine, before the first frame.
    pub(crate) fn new(header: &Header, spec: &MachineSpec) -> Self {
        let line = spec.line_bytes.get();
        let unit = &spec.shadow_cache;
        // Words that cost nothing take no memory: triangle records have no room for them.
        let layout = if unit.place == Place::Free { StoreLayout::Dense } else { unit.layout };
        let copy = if unit.place == Place::Free { LatchedCopy::Free } else { unit.latched };
        let mut stores = Stores::new(header, layout, copy, unit.frame_end == FrameEnd::Epoch, line);
        let mut end = 0u64;
        let mut array = |element: u64, count: u64| {
            let static_base = end;
            end = (end + element * count).next_multiple_of(ALIGNMENT);
            Array { element, static_count: count, static_base, dynamic_count: 0, dynamic_base: 0 }
        };
        let nodes = array(header.structure.node_bytes(), header.static_nodes.into());
        let lists = array(LIST_ENTRY_BYTES, header.static_list_entries.into());
        let triangles = array(stores.record_bytes(TRIANGLE_BYTES), header.static_slots.into());
        stores.set_records(triangles.static_base, triangles.element, TRIANGLE_BYTES);
        stores.place(header, |bytes| array(1, bytes).static_base);
        let line_shift = line.trailing_zeros();
        let (entries, dynamic_base) = (header.stores, end);
        Self { nodes, lists, triangles, stores, entries, dynamic_base, line_shift, node_lines: None }
    }

    /// Places the frame's dynamic arrays one after the other, from the base of the dynamic part on.
    pub(crate) fn begin_frame(&mut self, frame: &FrameInfo) {
        let mut end = self.dynamic_base;
        let arrays = [
            (&mut self.nodes, frame.dynamic_nodes),
            (&mut self.lists, frame.dynamic_list_entries),
            (&mut self.triangles, frame.dynamic_slots),
        ];
        for (array, count) in arrays {
            (array.dynamic_base, array.dynamic_count) = (end, count.into());
            end = (end + array.element * u64::from(count)).next_multiple_of(ALIGNMENT);
        }
        let Array { element, static_count, static_base, dynamic_base, .. } = self.nodes;
        let [static_first, dynamic_first] = [static_base, dynamic_base].map(|base| base >> self.line_shift);
        let dynamic_first = dynamic_first.wrapping_sub(static_count);
        let lines = NodeLines { bytes: element, static_count, static_first, dynamic_first };
        self.node_lines = (element == 1 << self.line_shift).then_some(lines);
    }

    /// The frame's dynamic nodes, lists and triangle records: first line and number of lines of each.
    pub(crate) fn dynamic_arrays(&self) -> [(LineAddr, u64); 3] {
        [&self.nodes, &self.lists, &self.triangles].map(|array| {
            let bytes = array.element * array.dynamic_count;
            (LineAddr(array.dynamic_base >> self.line_shift), bytes.div_ceil(1 << self.line_shift))
        })
    }

    /// The shift from this layout's dynamic part to that of `other`; `None` if the layouts differ in more than this
    /// shift.
    pub(crate) fn shift_to(&self, other: &Self) -> Option<Shift> {
        // Dynamic bases relative to the dynamic part; an array without dynamic elements is left out of the comparison.
        let places = |it: &Self| {
            let base = |array: Array| if array.dynamic_count > 0 { array.dynamic_base - it.dynamic_base } else { 0 };
            [it.nodes, it.lists, it.triangles].map(|array| Array { dynamic_base: base(array), ..array })
        };
        let same = places(self) == places(other) && self.line_shift == other.line_shift;
        let is_there = [self.nodes, self.lists, self.triangles].iter().any(|array| array.dynamic_count > 0);
        let (first, to) = (self.dynamic_part(), other.dynamic_part());
        let by = if is_there { to.0.wrapping_sub(first.0) as i64 } else { 0 };
        same.then_some(Shift { first, by })
    }

    /// Whether the structure has list entries.
    pub(crate) fn has_lists(&self) -> bool {
        self.lists.len() > 0
    }

    /// The lines of the frame's nodes, if a node is exactly one line long.
    #[inline]
    pub(crate) fn node_lines(&self) -> Option<&NodeLines> {
        self.node_lines.as_ref()
    }

    /// The lines that a triangle test reads up to `stop`: first line and number of lines. A line that plane and edges
    /// share is counted once.
    #[inline]
    pub(crate) fn test_lines(&self, slot: TriangleSlot, stop: Stop) -> (LineAddr, u64) {
        let bytes = if stop == Stop::Plane { PLANE_BYTES } else { TRIANGLE_BYTES };
        self.lines(&Element { bytes, ..self.plane(slot) })
    }

    /// The first line of the dynamic part.
    pub(crate) fn dynamic_part(&self) -> LineAddr {
        LineAddr(self.dynamic_base >> self.line_shift)
    }

    /// The lines of `element`: first line and number of lines.
    #[inline]
    pub(crate) fn lines(&self, element: &Element) -> (LineAddr, u64) {
        let first = element.addr.0 >> self.line_shift;
        let last = (element.addr.0 + element.bytes - 1) >> self.line_shift;
        (LineAddr(first), last - first + 1)
    }

    /// Checks that the element that `step` names exists.
    #[inline]
    pub(crate) fn check(&self, step: Step) -> Result<(), OutOfRange> {
        let (what, index, len) = match step {
            Step::Node(NodeId(index)) => ("node", index, self.nodes.len()),
            Step::List(ListId(index)) => ("list entry", index, self.lists.len()),
            Step::Triangle { slot, .. } => ("triangle slot", slot.0, self.triangles.len()),
            Step::Read { store, index } | Step::Write { store, index } | Step::Update { store, index } => {
                let what = match store {
                    Store::ModeWord => "mode word",
                    Store::PixelCounter => "pixel counter",
                    Store::OccluderId => "occluder id",
                };
                (what, index, self.entries.of(store).into())
            }
        };
        if u64::from(index) < len { Ok(()) } else { Err(OutOfRange { what, index, len }) }
    }

    /// The node.
    #[inline]
    pub(crate) fn node(&self, NodeId(index): NodeId) -> Element {
        self.element(&self.nodes, index, TrafficClass::Node, false)
    }

    /// The list entry.
    #[inline]
    pub(crate) fn list_entry(&self, ListId(index): ListId) -> Element {
        self.element(&self.lists, index, TrafficClass::List, false)
    }

    /// The plane of a triangle record.
    #[inline]
    pub(crate) fn plane(&self, TriangleSlot(index): TriangleSlot) -> Element {
        Element { bytes: PLANE_BYTES, ..self.element(&self.triangles, index, TrafficClass::Triangle, false) }
    }

    /// The edges of a triangle record.
    #[inline]
    pub(crate) fn edges(&self, TriangleSlot(index): TriangleSlot) -> Element {
        let record = self.element(&self.triangles, index, TrafficClass::Triangle, false);
        Element { addr: Addr(record.addr.0 + PLANE_BYTES), bytes: EDGE_BYTES, ..record }
    }

    /// The same part of the element `places` entries further on in the array of `step`; for a step on a store,
    /// `element`.
    pub(crate) fn places_on(&self, element: &Element, step: Step, places: u64) -> Element {
        let array = match step {
            Step::Node(_) => &self.nodes,
            Step::List(_) => &self.lists,
            Step::Triangle { .. } => &self.triangles,
            Step::Read { .. } | Step::Write { .. } | Step::Update { .. } => return *element,
        };
        Element { addr: Addr(element.addr.0 + places * array.element), ..*element }
    }

    /// An entry of a store.
    pub(crate) fn entry(&self, store: Store, index: u32, write: bool) -> Element {
        let class = match store {
            Store::ModeWord => TrafficClass::ModeWord,
            Store::PixelCounter => TrafficClass::PixelCounter,
            Store::OccluderId => TrafficClass::OccluderId,
        };
        let (addr, bytes) = self.stores.entry(store, index);
        Element { addr: Addr(addr), bytes, class, write }
    }

    /// The line of an entry of a store.
    pub(crate) fn line_of(&self, store: Store, index: u32) -> LineAddr {
        LineAddr(self.stores.entry(store, index).0 >> self.line_shift)
    }

    /// The policy's stores.
    pub(crate) fn stores(&self) -> &Stores {
        &self.stores
    }

    #[inline]
    fn element(&self, array: &Array, index: u32, class: TrafficClass, write: bool) -> Element {
        Element { addr: array.addr(index), bytes: array.element, class, write }
    }
}
