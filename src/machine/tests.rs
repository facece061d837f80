//! The addresses of store entries in the layout of a machine.

use super::MachineSpec;
use super::layout::{Layout, TRIANGLE_BYTES};
use super::stores::StoreLayout;
use super::word_traffic::LatchedCopy;
use crate::quantity::{NodeId, Resolution, TriangleSlot};
use crate::ranged::PowerOfTwoSize;
use crate::stream::{FrameInfo, Header, Step, Stop, Store, StoreEntries, Structure};

const LAYOUTS: [StoreLayout; 5] =
    [StoreLayout::Dense, StoreLayout::Packed, StoreLayout::Beside, StoreLayout::Record, StoreLayout::Tagged];

fn header(lights: u32) -> Header {
    let words_per_primitive = 1 + lights.saturating_sub(15).div_ceil(16);
    Header {
        scene: String::new(),
        frames: Vec::new(),
        warmup: Vec::new(),
        resolution: Resolution { width: 1, height: 1 },
        policy: String::new(),
        structure: Structure::Bvh2,
        lights,
        static_primitives: 40,
        primitives: 50,
        static_nodes: 3,
        static_slots: 40,
        static_list_entries: 0,
        stores: StoreEntries {
            mode_words: 50 * words_per_primitive + 7,
            word_owners: 50,
            words_per_primitive,
            pixel_counters: 50,
            occluder_ids: 9,
        },
        unjudged_updates: false,
        input_hash: 0,
        records: (0..40).map(|primitive| TriangleSlot(primitive * 7 % 40)).collect(),
    }
}

fn layout(header: &Header, stores: StoreLayout, line: u64) -> Layout {
    layout_with(header, stores, LatchedCopy::Free, line)
}

fn layout_with(header: &Header, stores: StoreLayout, copy: LatchedCopy, line: u64) -> Layout {
    let mut machine = MachineSpec { line_bytes: PowerOfTwoSize::new(line).unwrap(), ..MachineSpec::default() };
    (machine.shadow_cache.layout, machine.shadow_cache.latched) = (stores, copy);
    Layout::new(header, &machine)
}

/// All entries of a store, as ranges of bytes.
fn ranges(layout: &Layout, header: &Header, store: Store) -> Vec<(u64, u64)> {
    let range = |index| {
        let element = layout.entry(store, index, false);
        (element.addr.0, element.addr.0 + element.bytes)
    };
    (0..header.stores.of(store)).map(range).collect()
}

#[test]
fn entries_lie_in_one_line_and_apart() {
    let copies = [LatchedCopy::Free, LatchedCopy::Wide, LatchedCopy::Buffers];
    for (stores, copy) in LAYOUTS.into_iter().flat_map(|stores| copies.map(|copy| (stores, copy))) {
        for lights in [0, 1, 3, 7, 8, 9, 15, 16, 40, 64, 256] {
            for line in [32, 64, 128] {
                let header = header(lights);
                let layout = layout_with(&header, stores, copy, line);
                let all = [Store::ModeWord, Store::PixelCounter, Store::OccluderId];
                let mut all: Vec<_> = all.iter().flat_map(|&store| ranges(&layout, &header, store)).collect();
                let learns = |index| layout.stores().learns(Step::Update { store: Store::ModeWord, index });
                let learned = (0..header.stores.mode_words).filter_map(learns).filter_map(Step::entry);
                all.extend(learned.map(|(store, index)| {
                    let bits = layout.entry(store, index, true);
                    (bits.addr.0, bits.addr.0 + bits.bytes)
                }));
                for slot in (0..40).map(TriangleSlot) {
                    let plane = layout.plane(slot).addr.0;
                    all.push((plane, plane + TRIANGLE_BYTES));
                }
                all.sort_unstable();
                // Words of less than a byte share a byte, and tagged words also hold the counters.
                all.dedup();
                let what = || format!("{stores:?}, {copy:?}, {lights} lights, lines of {line} B");
                for pair in all.windows(2) {
                    let within = stores == StoreLayout::Tagged && pair[0].0 == pair[1].0;
                    assert!(pair[0].1 <= pair[1].0 || within, "{}: {pair:?}", what());
                }
                for &(begin, end) in all.iter().filter(|(begin, end)| end - begin < TRIANGLE_BYTES) {
                    assert_eq!(begin / line, (end - 1) / line, "{}", what());
                }
            }
        }
    }
}

#[test]
fn layouts_take_the_memory_that_they_should() {
    let stride = |stores, lights, store| {
        let header = header(lights);
        let layout = layout(&header, stores, 64);
        let at = ranges(&layout, &header, store);
        let words = header.stores.words_per_primitive as usize;
        let step = if store == Store::ModeWord { words } else { 1 };
        // From the first primitive to the fifth: both lie in one line of 64 bytes.
        (at[4 * step].0 - at[0].0) as f64 / 4.0
    };
    use StoreLayout::{Beside, Dense, Packed, Tagged};
    assert_eq!(stride(Dense, 6, Store::ModeWord), 4.0);
    assert_eq!([1, 3, 6, 15].map(|lights| stride(Packed, lights, Store::ModeWord)), [0.5, 1.0, 2.0, 4.0]);
    assert_eq!(stride(Beside, 6, Store::ModeWord), 12.0);
    assert_eq!([8, 9].map(|lights| stride(Tagged, lights, Store::ModeWord)), [4.0, 8.0]);
    for (lights, record) in [(6, 64), (16, 64), (40, 80)] {
        let layout = layout(&header(lights), StoreLayout::Record, 64);
        assert_eq!(layout.plane(TriangleSlot(1)).addr.0 - layout.plane(TriangleSlot(0)).addr.0, record);
    }
}

/// Two copies of the modes and the frame's number fit into a word up to 6 lights; separate learned bits double the
/// number of words.
#[test]
fn latched_copies_take_the_memory_that_they_should() {
    let word = |lights, copy| {
        let header = header(lights);
        let layout = layout_with(&header, StoreLayout::Dense, copy, 64);
        let [first, second] = [0, 1].map(|index| layout.entry(Store::ModeWord, index, false));
        assert_eq!(second.addr.0 - first.addr.0, first.bytes);
        (first.bytes, layout.stores().learns(Step::Update { store: Store::ModeWord, index: 1 }))
    };
    assert_eq!([6, 7, 15].map(|lights| word(lights, LatchedCopy::Wide)), [(4, None), (8, None), (8, None)]);
    let learned = Step::Update { store: Store::ModeWord, index: 1 + 57 };
    assert_eq!(word(6, LatchedCopy::Buffers), (4, Some(learned)));
}

#[test]
fn a_record_holds_the_word_of_its_triangle() {
    let header = header(6);
    let layout = layout(&header, StoreLayout::Record, 64);
    let record = layout.plane(TriangleSlot(3 * 7)).addr.0;
    assert_eq!(layout.entry(Store::PixelCounter, 3, false).addr.0, record + 48);
    assert_eq!(layout.entry(Store::ModeWord, 3, false).addr.0, record + 56);
}

#[test]
fn lines_of_nodes_and_tests_are_those_of_their_elements() {
    for bytes in [32, 64, 128] {
        let machine = MachineSpec { line_bytes: PowerOfTwoSize::new(bytes).unwrap(), ..MachineSpec::default() };
        let header = header(1);
        let mut layout = Layout::new(&header, &machine);
        layout.begin_frame(&FrameInfo { dynamic_nodes: 100, dynamic_slots: 100, ..FrameInfo::default() });
        let lines = layout.node_lines();
        assert_eq!(lines.is_some(), bytes == header.structure.node_bytes());
        let (nodes, slots) = (header.static_nodes, header.static_slots);
        for node in [0, 1, nodes - 1, nodes, nodes + 99].map(NodeId) {
            let of = layout.lines(&layout.node(node));
            assert!(lines.is_none_or(|lines| (lines.of(node), 1) == of), "{node:?}");
        }
        for slot in [0, 1, 2, 3, slots - 1, slots, slots + 1, slots + 99].map(TriangleSlot) {
            let [plane, edges] = [layout.plane(slot), layout.edges(slot)].map(|part| layout.lines(&part));
            assert_eq!(layout.test_lines(slot, Stop::Plane), plane);
            assert!(edges.0.0 <= plane.0.0 + plane.1, "no line between them is left out");
            let both = (plane.0, edges.0.0 + edges.1 - plane.0.0);
            assert_eq!([Stop::Edges, Stop::Hit].map(|stop| layout.test_lines(slot, stop)), [both; 2]);
        }
    }
}
