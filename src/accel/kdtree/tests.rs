//! Invariants of a built kd-tree.

use glam::Vec3;
use proptest::prelude::*;

use std::ops::Range;

use super::bounds::Bounds;
use super::build::{BuildSpec, build};
use super::node::{Node, Tree, View};
use crate::accel::spec::{KdLayout as Layout, Quality};
use crate::accel::structure::{Base, Item};
use crate::quantity::PrimitiveId;
use crate::scene::Triangle;

const BASE: Base = Base { node: 7, slot: 100, list: 1000 };

fn tree(triangles: &[Triangle], quality: Quality, layout: Layout, leaf: usize) -> Tree {
    let item = |(index, triangle)| Item { primitive: PrimitiveId(index as u32), triangle };
    let items: Vec<_> = triangles.iter().enumerate().map(item).collect();
    build(&items, BuildSpec { quality, layout, max_depth: None, leaf }, BASE)
}

impl Tree {
    fn view(&self, id: u32) -> View {
        self.nodes[(id - BASE.node) as usize].view(id)
    }

    /// All leaves under node `id`, with their cells. Checks that nodes and ranges of entries are consecutive, and the
    /// order of the children.
    fn leaves(&self, id: u32, cell: Bounds, layout: Layout, leaves: &mut Vec<(Bounds, Range<u32>)>) -> u32 {
        match self.view(id) {
            View::Leaf(entries) => {
                assert_eq!(entries.start, leaves.last().map_or(BASE.list, |(_, last)| last.end));
                leaves.push((cell, entries));
                id + 1
            }
            View::Split { axis, at, children } => {
                let cells = cell.split(axis, at);
                assert!(cell.low[axis] <= at && at <= cell.high[axis] && cell.low[axis] < cell.high[axis]);
                let first = children.iter().position(|&child| child == id + 1).unwrap();
                match layout {
                    Layout::DepthFirst => assert_eq!(first, 0),
                    Layout::Ordered => assert!(cells[first].area() >= cells[1 - first].area()),
                }
                let next = self.leaves(children[first], cells[first], layout, leaves);
                assert_eq!(next, children[1 - first]);
                self.leaves(next, cells[1 - first], layout, leaves)
            }
        }
    }
}

fn triangle() -> impl Strategy<Value = Triangle> {
    let whole = prop::array::uniform3(prop::array::uniform3(-5..5i8))
        .prop_map(|v| Triangle { v: v.map(|corner| Vec3::from_array(corner.map(f32::from))) });
    let any = (prop::array::uniform3(prop::array::uniform3(-1.0f32..1.0)), 0.01f32..3.0)
        .prop_map(|(v, size)| Triangle { v: v.map(|corner| Vec3::from_array(corner) * size) });
    prop_oneof![whole, any]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn trees_are_whole(
        triangles in prop::collection::vec(triangle(), 1..150),
        quality in prop::sample::select(vec![Quality::Fast, Quality::Medium, Quality::Best]),
        layout in prop::sample::select(vec![Layout::DepthFirst, Layout::Ordered]),
        leaf in prop::sample::select(vec![0, 8]),
    ) {
        let tree = tree(&triangles, quality, layout, leaf);
        let mut leaves = Vec::new();
        let end = tree.leaves(BASE.node, tree.bounds, layout, &mut leaves);
        prop_assert_eq!(end as usize, BASE.node as usize + tree.nodes.len());
        prop_assert_eq!(tree.nodes.len(), 2 * leaves.len() - 1);
        prop_assert_eq!(leaves.last().unwrap().1.end as usize, BASE.list as usize + tree.lists.len());

        // Each primitive has one record; records are in the order in which the lists first name them.
        let mut primitives: Vec<_> = tree.records.iter().map(|record| record.primitive.0).collect();
        let mut seen = 0;
        for &slot in &tree.lists {
            let slot = slot - BASE.slot;
            prop_assert!(slot <= seen);
            seen = seen.max(slot + 1);
        }
        let listed = |slot: usize| tree.lists.contains(&(BASE.slot + slot as u32));
        for (slot, primitive) in primitives.iter().enumerate() {
            let bounds = Bounds::of(&triangles[*primitive as usize]);
            prop_assert!(listed(slot) || bounds.area() == 0.0);
        }

        // Sample points of each triangle: a leaf that holds the point lists the triangle.
        for (slot, primitive) in primitives.iter().enumerate() {
            let [a, b, c] = triangles[*primitive as usize].v;
            for (u, v) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.3, 0.3), (0.1, 0.7), (0.5, 0.5)] {
                let point = a + (b - a) * u + (c - a) * v;
                let slack = Vec3::splat(1e-5);
                let holds = |cell: &Bounds| point.cmpge(cell.low - slack).all() && point.cmple(cell.high + slack).all();
                let lists = |entries: &Range<u32>| {
                    entries.clone().any(|entry| tree.lists[(entry - BASE.list) as usize] == BASE.slot + slot as u32)
                };
                prop_assert!(leaves.iter().any(|(cell, entries)| holds(cell) && lists(entries)));
                // A point well inside a leaf belongs to this leaf only.
                let within = |cell: &Bounds| point.cmpgt(cell.low + slack).all() && point.cmplt(cell.high - slack).all();
                prop_assert!(leaves.iter().all(|(cell, entries)| !within(cell) || lists(entries)));
            }
        }
        // With clipping, every listed triangle reaches into the cell.
        if quality == Quality::Best {
            for (cell, entries) in &leaves {
                for entry in entries.clone() {
                    let slot = tree.lists[(entry - BASE.list) as usize] - BASE.slot;
                    let primitive = tree.records[slot as usize].primitive.0;
                    let wide = Bounds { low: cell.low - 1e-5, high: cell.high + 1e-5 };
                    prop_assert!(wide.clip(&triangles[primitive as usize]).is_some());
                }
            }
        }
        primitives.sort_unstable();
        prop_assert!(primitives.into_iter().eq(0..triangles.len() as u32));
    }
}

#[test]
fn a_node_keeps_what_it_is_made_of() {
    for axis in 0..3 {
        for at in [-0.0, 1.5, f32::MIN_POSITIVE, -3e38] {
            let plain = Node::split(axis, at, 123_456_789, false).view(41);
            assert_eq!(plain, View::Split { axis, at, children: [42, 123_456_789] });
            let reordered = Node::split(axis, at, 123_456_789, true).view(41);
            assert_eq!(reordered, View::Split { axis, at, children: [123_456_789, 42] });
        }
    }
    assert_eq!(Node::leaf(1 << 28..(1 << 28) + 70_000).view(3), View::Leaf(1 << 28..(1 << 28) + 70_000));
    assert_eq!(size_of::<Node>() as u64, crate::stream::Structure::KdTree.node_bytes());
}

#[test]
fn triangles_that_all_meet_in_a_point_make_a_tree() {
    let fan: Vec<_> = (0..500)
        .map(|index| {
            let angle = index as f32 * 0.1;
            let rim = |angle: f32| Vec3::new(angle.cos(), angle.sin(), (7.0 * angle).sin());
            Triangle { v: [Vec3::splat(0.1), rim(angle), rim(angle + 0.05)] }
        })
        .collect();
    let all = tree(&fan, Quality::Best, Layout::Ordered, 0);
    assert!(all.nodes.len() < 100 * fan.len(), "{} nodes", all.nodes.len());
    // Cells with few triangles are not split.
    let large = tree(&fan, Quality::Best, Layout::Ordered, 16);
    assert!(2 * large.nodes.len() < all.nodes.len(), "{} of {} nodes", large.nodes.len(), all.nodes.len());
    assert_eq!(tree(&fan, Quality::Best, Layout::Ordered, fan.len()).nodes.len(), 1);
}
