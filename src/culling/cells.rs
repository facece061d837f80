//! Cells: a receiver divided by its barycentric coordinates into triangles, each into four, to the requested depth.
//! This is the poster's "triangle subdivision" without a change of the geometry.

use glam::{Vec2, Vec3};

use crate::accel::{Record, Shaft};
use crate::quantity::PrimitiveId;

/// Width of the strip along a primitive's edges that belongs to no cell, as a share of its height. A ray from the very
/// edge where two walls meet starts on the other wall, and rounding decides whether it is blocked: no proof can hold
/// there.
const BORDER: f32 = 1.0 / 1024.0;

/// The deepest level that [`Cell::place`] has bits for.
pub const DEEPEST: u64 = 15;

/// A cell of a primitive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Cell {
    /// The primitive that the cell is a part of.
    pub primitive: PrimitiveId,
    /// A leading one, then two bits for each level: the corner (0 to 2) that the cell shares with its parent, or 3 for
    /// the middle cell. A cell has a larger place than all cells around it.
    pub place: u32,
}

impl Cell {
    /// The whole primitive except the strip along its edges.
    pub fn whole(primitive: PrimitiveId) -> Self {
        Self { primitive, place: 1 }
    }

    /// One of the four child cells.
    pub fn child(self, at: u32) -> Self {
        Self { place: self.place << 2 | at, ..self }
    }

    /// How many times the primitive is divided to get this cell.
    pub fn level(self) -> u32 {
        (31 - self.place.leading_zeros()) / 2
    }

    /// The child numbers on the way down from the whole primitive.
    pub fn path(self) -> impl Iterator<Item = u32> {
        (0..self.level()).rev().map(move |level| self.place >> (2 * level) & 3)
    }
}

/// A position in a cell: the weights of corners 1 and 2.
#[derive(Clone, Copy, Debug)]
pub struct Inside {
    u: f32,
    v: f32,
}

impl Inside {
    /// The position of a hit in the whole primitive's cell; `None` on the strip along the edges.
    pub fn whole(barycentric: Vec2) -> Option<Self> {
        let Vec2 { x: u, y: v } = (barycentric - BORDER) / (1.0 - 3.0 * BORDER);
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then_some(Self { u, v })
    }

    /// The child cell that contains the point, and the point's position in it.
    pub fn descend(self) -> (u32, Self) {
        let (u, v) = (2.0 * self.u, 2.0 * self.v);
        if u >= 1.0 {
            (1, Self { u: u - 1.0, v })
        } else if v >= 1.0 {
            (2, Self { u, v: v - 1.0 })
        } else if u + v <= 1.0 {
            (0, Self { u, v })
        } else {
            (3, Self { u: 1.0 - u, v: 1.0 - v })
        }
    }
}

/// A static primitive that shadow falls on.
#[derive(Clone, Copy, Debug)]
pub struct Receiver<'a> {
    /// Its record.
    pub record: &'a Record,
    /// Distance from its surface at which shadow rays start, in world units.
    pub offset: f32,
}

impl Receiver<'_> {
    /// All shadow rays from one side of a cell to the points of a lamp.
    ///
    /// The tracer's point is `a + (b - a) u + (c - a) v`, and its ray starts `offset` along the unit normal, all in
    /// `f32`. Together with the rounding in the search for the point's cell, it deviates from the exact start by less
    /// than 16 u times the sum of the largest coordinate, the edges and the offset, where u = 2^-24.
    pub fn shaft(&self, cell: Cell, outside: bool, lights: &[Vec3]) -> Shaft {
        let Record { corner, edges, normal, .. } = *self.record;
        let [ab, ac] = edges.map(|edge| edge.as_dvec3());
        // The tracer's own unit normal, with the same rounding.
        let normal = normal.normalize() * if outside { 1.0 } else { -1.0 };
        let lifted = corner.as_dvec3() + normal.as_dvec3() * f64::from(self.offset);
        let (near, far) = (f64::from(BORDER), 1.0 - 2.0 * f64::from(BORDER));
        let at = |u: f64, v: f64| lifted + ab * u + ac * v;
        let mut corners = [at(near, near), at(far, near), at(near, far)];
        for step in cell.path() {
            let [a, b, c] = corners;
            let (ab, bc, ca) = ((a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5);
            corners = match step {
                0 => [a, ab, ca],
                1 => [ab, b, bc],
                2 => [ca, bc, c],
                _ => [bc, ca, ab],
            };
        }
        let size = corner.as_dvec3().length() + 2.0 * (ab.length() + ac.length()) + f64::from(self.offset);
        Shaft::new(corners, lights, 16.0 * 0.5 * f64::from(f32::EPSILON) * size)
    }
}
