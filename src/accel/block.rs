//! Triangles of a leaf, tested several at once.

use std::array;

use glam::Vec3;

use super::lanes::Lanes;
use super::ray::Ray;
use super::triangle::{Record, TIE, TriangleHit};
use crate::quantity::PrimitiveId;
use crate::stream::Stop;

/// Number of triangles in a block.
pub(super) const LANES: usize = 4;

/// A vector for each lane.
type Vectors = [[f32; LANES]; 3];

/// Up to [`LANES`] consecutive triangles of a leaf: the parts of their records that the test reads.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Block {
    corner: Vectors,
    edges: [Vectors; 2],
    normal: Vectors,
    /// The primitive of each triangle.
    pub primitives: [PrimitiveId; LANES],
    /// Index of the first triangle among the tree's records.
    pub first: u32,
    /// Number of triangles; the remaining lanes are degenerate.
    pub count: u8,
    /// Whether the leaf continues in the next block.
    pub goes_on: bool,
}

/// Results of the tests of a block's triangles, by lane.
pub(super) struct Tested<L: Lanes<LANES>> {
    lanes: L,
    /// A bit for each triangle whose plane is hit within reach.
    pub in_plane: u32,
    /// A bit for each triangle whose edges the ray passes inside.
    pub inside: u32,
    distance: L::F,
    facing: L::F,
    u: L::F,
    v: L::F,
}

impl<L: Lanes<LANES>> Tested<L> {
    /// Stores the results, so that triangles can be looked at one by one.
    #[inline(always)]
    pub(super) fn each(self) -> Each {
        let Self { lanes, in_plane, inside, .. } = self;
        let [distance, facing, u, v] = [self.distance, self.facing, self.u, self.v].map(|it| lanes.store(it));
        Each { in_plane, inside, distance, facing, u, v }
    }
}

/// Results of the tests of a block's triangles, to be read one by one.
pub(super) struct Each {
    in_plane: u32,
    inside: u32,
    distance: [f32; LANES],
    facing: [f32; LANES],
    u: [f32; LANES],
    v: [f32; LANES],
}

impl Each {
    /// The result for one triangle; `reach` may be shorter than in the test of the block.
    #[inline(always)]
    pub(super) fn result(&self, at: usize, reach: f32) -> (Stop, Option<TriangleHit>) {
        let at = at % LANES;
        let (distance, facing) = (self.distance[at], self.facing[at]);
        if self.in_plane >> at & 1 == 0 || distance > facing * reach * TIE {
            (Stop::Plane, None)
        } else if self.inside >> at & 1 == 0 {
            (Stop::Edges, None)
        } else {
            (Stop::Hit, Some(TriangleHit::new(distance, facing, [self.u[at], self.v[at]])))
        }
    }
}

/// A ray in the form that the test of a block needs.
pub(super) struct Line<L: Lanes<LANES>> {
    lanes: L,
    origin: [L::F; 3],
    direction: [L::F; 3],
}

impl<L: Lanes<LANES>> Line<L> {
    /// Converts the ray.
    #[inline(always)]
    pub(super) fn new(lanes: L, ray: &Ray) -> Self {
        let splat = |vector: Vec3| vector.to_array().map(|number| lanes.splat(number));
        Self { lanes, origin: splat(ray.origin), direction: splat(ray.direction) }
    }
}

impl Block {
    /// Splits a leaf's records into blocks; the first of them is the tree's record `first`.
    pub(super) fn of_leaf(records: &[Record], first: u32) -> impl Iterator<Item = Self> {
        let last = records.len().div_ceil(LANES) - 1;
        (first..).step_by(LANES).zip(records.chunks(LANES)).enumerate().map(move |(number, (first, records))| {
            let vectors = |of: &dyn Fn(&Record) -> Vec3| {
                array::from_fn(|axis| array::from_fn(|lane| records.get(lane).map_or(0.0, |it| of(it)[axis])))
            };
            Self {
                corner: vectors(&|it| it.corner),
                edges: [0, 1].map(|edge| vectors(&|it| it.edges[edge])),
                normal: vectors(&|it| it.normal),
                primitives: array::from_fn(|lane| records.get(lane).map_or_else(Default::default, |it| it.primitive)),
                first,
                count: records.len() as u8,
                goes_on: number < last,
            }
        })
    }

    /// Runs [`Record::test`] on all triangles at once, with the same reach.
    #[inline(always)]
    pub(super) fn test<L: Lanes<LANES>>(&self, line: &Line<L>, reach: f32) -> Tested<L> {
        let Line { lanes, origin, direction } = line;
        let zero = lanes.splat(0.0);
        let load = |vectors: &Vectors| vectors.each_ref().map(|numbers| lanes.load(numbers));
        let dot = |a: &[L::F; 3], b: &[L::F; 3]| {
            lanes.add(lanes.add(lanes.mul(a[0], b[0]), lanes.mul(a[1], b[1])), lanes.mul(a[2], b[2]))
        };
        let negative = |a: L::F| lanes.flip(a, lanes.splat(-1.0));
        let normal = load(&self.normal);
        let towards = negative(dot(direction, &normal));
        let facing = lanes.flip(towards, towards);
        let corner = load(&self.corner);
        let from_corner = array::from_fn(|axis| lanes.sub(origin[axis], corner[axis]));
        let distance = lanes.flip(dot(&from_corner, &normal), towards);
        let within = lanes.mul(lanes.mul(facing, lanes.splat(reach)), lanes.splat(TIE));
        let in_plane = lanes.below(zero, distance) & lanes.at_most(distance, within);
        let cross = |y: usize, z: usize| {
            lanes.sub(lanes.mul(from_corner[y], direction[z]), lanes.mul(direction[y], from_corner[z]))
        };
        let moment = [cross(1, 2), cross(2, 0), cross(0, 1)];
        let u = lanes.flip(dot(&load(&self.edges[1]), &moment), towards);
        let v = lanes.flip(negative(dot(&load(&self.edges[0]), &moment)), towards);
        let inside = lanes.at_most(zero, u) & lanes.at_most(zero, v) & lanes.at_most(lanes.add(u, v), facing);
        Tested { lanes: *lanes, in_plane, inside, distance, facing, u, v }
    }
}
