//! A binary tree of boxes over triangles, built top down by the surface area heuristic over bins (Wald, "On fast
//! Construction of SAH-based Bounding Volume Hierarchies", 2007).

use glam::Vec3;

use super::ray::{Crossing, Ray};
use crate::quantity::PrimitiveId;
use crate::scene::Triangle;

const BINS: usize = 16;
/// Maximum size of leaves that are made without the heuristic.
const SMALL_LEAF: usize = 2;
/// Larger leaves are halved even where no plane separates their triangles.
const LARGE_LEAF: usize = 8;
/// Cost of a node visit, in triangle tests.
const VISIT_COST: f32 = 1.0;
/// Deeper nodes are halved, which bounds the depth: 32 levels by the heuristic, and 32 that halve at most 2^32
/// triangles.
const HEURISTIC_DEPTH: usize = 32;
const STACK: usize = HEURISTIC_DEPTH + 32;

/// The box of a part of the tree. Its sides are coordinates of corners, so they are exact in `f32`.
#[derive(Clone, Copy)]
struct Bounds {
    low: Vec3,
    high: Vec3,
}

impl Bounds {
    const EMPTY: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY };

    fn join(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    fn half_area(self) -> f32 {
        let side = self.high - self.low;
        side.x * side.y + side.y * side.z + side.z * side.x
    }
}

struct Node {
    bounds: Bounds,
    /// The first of the two children, or the first triangle of a leaf.
    first: u32,
    /// The number of triangles, 0 for an inner node.
    count: u32,
}

struct Item {
    bounds: Bounds,
    centre: Vec3,
    primitive: PrimitiveId,
    triangle: Triangle,
}

/// The tree. Triangles lie in leaf order.
pub(super) struct Tree {
    nodes: Vec<Node>,
    triangles: Vec<(PrimitiveId, Triangle)>,
}

impl Tree {
    /// A tree over the triangles that a ray can hit: those with an area and finite coordinates.
    pub(super) fn new(triangles: impl Iterator<Item = (PrimitiveId, Triangle)>) -> Self {
        let mut items: Vec<Item> = triangles
            .filter(|(_, triangle)| can_be_hit(triangle))
            .map(|(primitive, triangle)| {
                let [a, b, c] = triangle.v;
                let bounds = Bounds { low: a.min(b).min(c), high: a.max(b).max(c) };
                Item { bounds, centre: 0.5 * bounds.low + 0.5 * bounds.high, primitive, triangle }
            })
            .collect();
        let mut tree = Self { nodes: Vec::new(), triangles: Vec::with_capacity(items.len()) };
        if !items.is_empty() {
            tree.nodes.push(Node { bounds: Bounds::EMPTY, first: 0, count: 0 });
            tree.build(0, &mut items, 0);
        }
        tree
    }

    fn build(&mut self, node: usize, items: &mut [Item], depth: usize) {
        let bounds = items.iter().fold(Bounds::EMPTY, |all, item| all.join(item.bounds));
        self.nodes[node].bounds = bounds;
        let Some(middle) = cut(items, bounds, depth) else {
            self.nodes[node].first = self.triangles.len() as u32;
            self.nodes[node].count = items.len() as u32;
            self.triangles.extend(items.iter().map(|item| (item.primitive, item.triangle)));
            return;
        };
        let first = self.nodes.len();
        self.nodes[node].first = first as u32;
        self.nodes.extend([0, 1].map(|_| Node { bounds: Bounds::EMPTY, first: 0, count: 0 }));
        let (left, right) = items.split_at_mut(middle);
        self.build(first, left, depth + 1);
        self.build(first + 1, right, depth + 1);
    }

    /// The largest magnitude of a coordinate.
    pub(super) fn reach(&self) -> f64 {
        self.nodes
            .first()
            .map_or(0.0, |root| f64::from(root.bounds.low.abs().max(root.bounds.high.abs()).max_element()))
    }

    /// Calls `visit` for every triangle that the ray meets at 0 < t <= `limit`, and perhaps for others; near boxes
    /// come first. `visit` returns the new limit; a limit below 0 ends the walk.
    pub(super) fn walk(&self, ray: &Ray, mut limit: f64, mut visit: impl FnMut(PrimitiveId, Crossing) -> f64) {
        let enter = |child: u32, limit| {
            let Bounds { low, high } = self.nodes[child as usize].bounds;
            ray.enter(low, high, limit)
        };
        let mut stack = [(0, 0.0); STACK];
        let mut waiting = 0;
        let mut next = if self.nodes.is_empty() { None } else { enter(0, limit).map(|_| 0) };
        loop {
            let Some(node) = next else {
                if waiting == 0 {
                    return;
                }
                waiting -= 1;
                let (node, near) = stack[waiting];
                next = (near <= limit).then_some(node);
                continue;
            };
            let Node { first, count, .. } = self.nodes[node as usize];
            if count > 0 {
                for (primitive, triangle) in &self.triangles[first as usize..][..count as usize] {
                    if let Some(crossing) = ray.meet(triangle)
                        && crossing.t > 0.0
                        && crossing.t <= limit
                    {
                        limit = visit(*primitive, crossing);
                    }
                }
                next = None;
                continue;
            }
            next = match (enter(first, limit), enter(first + 1, limit)) {
                (Some(left), Some(right)) => {
                    let (near, far) =
                        if left <= right { (first, (first + 1, right)) } else { (first + 1, (first, left)) };
                    stack[waiting] = far;
                    waiting += 1;
                    Some(near)
                }
                (Some(_), None) => Some(first),
                (None, Some(_)) => Some(first + 1),
                (None, None) => None,
            };
        }
    }
}

/// Whether a ray can hit a triangle: it has an area and finite corners.
pub(super) fn can_be_hit(triangle: &Triangle) -> bool {
    let [a, b, c] = triangle.v.map(|corner| corner.as_dvec3());
    let normal = (b - a).cross(c - a);
    // Infinite or undefined coordinates give an infinite or undefined normal.
    normal.is_finite() && normal.length_squared() > 0.0
}

/// Sorts items to two sides and returns the number on the left; `None` makes a leaf.
fn cut(items: &mut [Item], bounds: Bounds, depth: usize) -> Option<usize> {
    if items.len() <= SMALL_LEAF {
        return None;
    }
    let centres =
        items.iter().fold(Bounds::EMPTY, |all, item| all.join(Bounds { low: item.centre, high: item.centre }));
    let plane = if depth < HEURISTIC_DEPTH { best_plane(items, centres) } else { None };
    let leaf_cost = items.len() as f32 * bounds.half_area();
    match plane {
        Some(plane) if items.len() > LARGE_LEAF || plane.cost + VISIT_COST * bounds.half_area() < leaf_cost => {
            let mut middle = 0;
            for at in 0..items.len() {
                if bin(items[at].centre, centres, plane.axis) < plane.bin {
                    items.swap(at, middle);
                    middle += 1;
                }
            }
            Some(middle)
        }
        None if items.len() > LARGE_LEAF => Some(items.len() / 2),
        _ => None,
    }
}

struct Plane {
    axis: usize,
    /// The first bin on the right.
    bin: usize,
    cost: f32,
}

fn bin(centre: Vec3, centres: Bounds, axis: usize) -> usize {
    let share = (centre[axis] - centres.low[axis]) / (centres.high[axis] - centres.low[axis]);
    ((share * BINS as f32) as usize).min(BINS - 1)
}

/// The cheapest border between bins that has triangles on both sides.
fn best_plane(items: &[Item], centres: Bounds) -> Option<Plane> {
    let mut best: Option<Plane> = None;
    for axis in 0..3 {
        if centres.low[axis] >= centres.high[axis] {
            continue;
        }
        let mut bins = [(Bounds::EMPTY, 0usize); BINS];
        for item in items {
            let (bounds, count) = &mut bins[bin(item.centre, centres, axis)];
            *bounds = bounds.join(item.bounds);
            *count += 1;
        }
        let grow = |side: &mut (Bounds, usize), (bounds, count): (Bounds, usize)| {
            *side = (side.0.join(bounds), side.1 + count);
            Some(*side)
        };
        let mut from_right: Vec<_> = bins.iter().rev().copied().scan((Bounds::EMPTY, 0), grow).collect();
        from_right.reverse();
        for (border, left) in bins.iter().copied().scan((Bounds::EMPTY, 0), grow).take(BINS - 1).enumerate() {
            let right = from_right[border + 1];
            if left.1 == 0 || right.1 == 0 {
                continue;
            }
            let cost = left.0.half_area() * left.1 as f32 + right.0.half_area() * right.1 as f32;
            if best.as_ref().is_none_or(|best| cost < best.cost) {
                best = Some(Plane { axis, bin: border + 1, cost });
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn count(tree: &Tree, node: usize) -> (usize, usize) {
        let Node { first, count: triangles, .. } = tree.nodes[node];
        if triangles > 0 {
            return (triangles as usize, 0);
        }
        let [left, right] = [0, 1].map(|side| count(tree, first as usize + side));
        (left.0 + right.0, left.1.max(right.1) + 1)
    }

    /// No plane separates triangles in one place; ever larger triangles tempt the heuristic to cut them off one by
    /// one.
    #[test]
    fn depth_is_bounded() {
        let same = |_: u32| 1.0f32;
        let growing = |i: u32| (f32::from(i as u16) * 0.01).exp();
        for size in [&same as &dyn Fn(u32) -> f32, &growing] {
            let triangles = (0..4000)
                .map(|i| (PrimitiveId(i), Triangle { v: [Vec3::X * size(i), Vec3::Y * size(i), Vec3::Z * size(i)] }));
            let tree = Tree::new(triangles);
            let (triangles, depth) = count(&tree, 0);
            assert_eq!(triangles, 4000);
            assert!((9..=STACK).contains(&depth), "{depth}");
            let ray = Ray::new(DVec3::splat(-1.0), DVec3::ONE, tree.reach());
            let mut met = 0;
            tree.walk(&ray, f64::INFINITY, |_, _| {
                met += 1;
                f64::INFINITY
            });
            assert_eq!(met, 4000);
        }
    }

    #[test]
    fn leaves_out_what_no_ray_can_hit() {
        let at = |v| (PrimitiveId(0), Triangle { v });
        let nothing = [
            at([Vec3::ONE; 3]),
            at([Vec3::ZERO, Vec3::ONE, Vec3::splat(0.3)]),
            at([Vec3::ZERO, Vec3::X, Vec3::NAN]),
            at([Vec3::ZERO, Vec3::X, Vec3::INFINITY]),
        ];
        assert!(Tree::new(nothing.into_iter()).nodes.is_empty());
        assert_eq!(Tree::new([at([Vec3::ZERO, Vec3::X, Vec3::Y])].into_iter()).triangles.len(), 1);
    }
}
