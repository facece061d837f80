//! Builds kd-trees, top down, by the surface area heuristic.

use super::bounds::Bounds;
use super::built::Built;
use super::layout::lay_out;
use super::node::Tree;
use super::split::{BINS, Plane, bins, leaf_cost, sweep};
use crate::accel::spec::{KdLayout, Quality};
use crate::accel::structure::{Base, Item};

/// The default level at which no cell is split any more: 8 + 1.3 log2 n (Pharr and Humphreys, "Physically Based
/// Rendering", the kd-tree). It bounds the stack. It also ends the trimming of empty slivers where triangles meet in a
/// point: the bonus for empty parts would pay for ever deeper splits, which make nodes and save hardly a triangle
/// test.
fn usual_depth(items: usize) -> u32 {
    (8.0 + 1.3 * f64::from(items.ilog2())).round() as u32
}

/// How a tree is built.
#[derive(Clone, Copy, Debug)]
pub(super) struct BuildSpec {
    /// How much work goes into the tree.
    pub quality: Quality,
    /// The order of its nodes.
    pub layout: KdLayout,
    /// The level at which no cell is split any more; `None` for 8 + 1.3 log2 n.
    pub max_depth: Option<u32>,
    /// A cell with this many items or fewer is not split.
    pub leaf: usize,
}

/// The part of an item that lies in a cell.
#[derive(Clone, Copy)]
struct Part {
    item: u32,
    bounds: Bounds,
}

struct Builder<'a> {
    items: &'a [Item<'a>],
    quality: Quality,
    max_depth: u32,
    leaf: usize,
    cells: Vec<Built>,
}

/// Builds the tree over `items`. [`Quality::Best`] clips triangles to their cells ("perfect splits") and considers
/// every plane. [`Quality::Medium`] cuts boxes instead of triangles. [`Quality::Fast`] also cuts boxes, and considers
/// only a few planes where there are many triangles. Events are sorted anew for each cell: O(n log^2 n) in all.
pub(super) fn build(items: &[Item<'_>], spec: BuildSpec, base: Base) -> Tree {
    let parts: Vec<_> = items
        .iter()
        .enumerate()
        .map(|(index, item)| Part { item: index as u32, bounds: Bounds::of(item.triangle) })
        .collect();
    let bounds = parts.iter().fold(Bounds::EMPTY, |all, part| all.union(part.bounds));
    if parts.is_empty() {
        return Tree { bounds, nodes: Vec::new(), lists: Vec::new(), records: Vec::new() };
    }
    let BuildSpec { quality, layout, max_depth, leaf } = spec;
    let max_depth = max_depth.unwrap_or_else(|| usual_depth(items.len()));
    let mut builder = Builder { items, quality, max_depth, leaf, cells: Vec::new() };
    builder.cell(bounds, parts, 0);
    lay_out(&builder.cells, bounds, items, layout, base)
}

impl Builder<'_> {
    fn cell(&mut self, cell: Bounds, parts: Vec<Part>, depth: u32) {
        let Some(plane) = self.plane(cell, &parts, depth) else {
            self.cells.push(Built::Leaf(parts.iter().map(|part| part.item).collect()));
            return;
        };
        let place = self.cells.len();
        self.cells.push(Built::Split { axis: plane.axis, at: plane.at, right: 0 });
        let [below, above] = cell.split(plane.axis, plane.at);
        let [left, right] = self.divide(plane, [below, above], &parts);
        drop(parts);
        self.cell(below, left, depth + 1);
        let right_place = self.cells.len();
        if let Built::Split { right, .. } = &mut self.cells[place] {
            *right = right_place;
        }
        self.cell(above, right, depth + 1);
    }

    /// The plane to split at, if the split is expected to cost less than a leaf (Wald and Havran 2006).
    fn plane(&self, cell: Bounds, parts: &[Part], depth: u32) -> Option<Plane> {
        if parts.len() <= self.leaf || depth == self.max_depth {
            return None;
        }
        let boxes = parts.iter().map(|part| part.bounds);
        // For fewer triangles, bins are no cheaper than the sweep.
        let (cost, plane) = if self.quality == Quality::Fast && parts.len() > 2 * BINS {
            bins(cell, boxes)
        } else {
            sweep(cell, boxes)
        }?;
        (cost < leaf_cost(parts.len())).then_some(plane)
    }

    /// The parts on either side. A part that only touches the plane belongs to its own side alone.
    fn divide(&self, plane: Plane, cells: [Bounds; 2], parts: &[Part]) -> [Vec<Part>; 2] {
        let mut sides = [Vec::new(), Vec::new()];
        for &part in parts {
            let (low, high) = (part.bounds.low[plane.axis], part.bounds.high[plane.axis]);
            if low == plane.at && high == plane.at {
                sides[usize::from(!plane.flat_left)].push(part);
            } else if high <= plane.at {
                sides[0].push(part);
            } else if low >= plane.at {
                sides[1].push(part);
            } else {
                let halves = part.bounds.split(plane.axis, plane.at);
                for ((side, half), cell) in sides.iter_mut().zip(halves).zip(cells) {
                    let bounds = if self.quality == Quality::Best {
                        let triangle = self.items[part.item as usize].triangle;
                        cell.clip(triangle).map(|clipped| clipped.intersection(half))
                    } else {
                        Some(half)
                    };
                    side.extend(bounds.map(|bounds| Part { bounds, ..part }));
                }
            }
        }
        sides
    }
}
