//! Cells: a receiver divided by its barycentric coordinates into triangles, each into four, as deep as asked: the
//! poster's "triangle subdivision" without touching the geometry.

use glam::{Vec2, Vec3};

use crate::accel::{Record, Shaft};
use crate::quantity::PrimitiveId;

/// The strip along the edges of a primitive that belongs to no cell, as a share of its height. A ray from the very edge
/// where two walls meet starts on the other wall, and rounding decides whether it is blocked: no proof can hold there.
const BORDER: f32 = 1.0 / 1024.0;

/// The deepest level that [`Cell::place`] has bits for.
pub const DEEPEST: u64 = 15;

/// A cell of a primitive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Cell {
    /// Whose cell it is.
    pub primitive: PrimitiveId,
    /// A one, then two bits a level: the corner (0 to 2) that the cell shares with the one around it, or 3 for the
    /// middle one. A cell has a larger place than those around it.
    pub place: u32,
}

impl Cell {
    /// All of a primitive but the strip along its edges.
    pub fn whole(primitive: PrimitiveId) -> Self {
        Self { primitive, place: 1 }
    }

    /// One of the four cells within.
    pub fn child(self, at: u32) -> Self {
        Self { place: self.place << 2 | at, ..self }
    }

    /// How often the primitive is divided.
    pub fn level(self) -> u32 {
        (31 - self.place.leading_zeros()) / 2
    }

    /// The way down from the whole primitive.
    pub fn path(self) -> impl Iterator<Item = u32> {
        (0..self.level()).rev().map(move |level| self.place >> (2 * level) & 3)
    }
}

/// Where a point is in a cell: weights of corners 1 and 2.
#[derive(Clone, Copy, Debug)]
pub struct Inside {
    u: f32,
    v: f32,
}

impl Inside {
    /// Where a hit is in the whole primitive's cell; `None` on the strip along the edges.
    pub fn whole(barycentric: Vec2) -> Option<Self> {
        let Vec2 { x: u, y: v } = (barycentric - BORDER) / (1.0 - 3.0 * BORDER);
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then_some(Self { u, v })
    }

    /// Which of the four cells within has the point, and where in it.
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
    /// How far off its surface shadow rays start.
    pub offset: f32,
}

impl Receiver<'_> {
    /// All shadow rays from one side of a cell to the points of a lamp.
    ///
    /// The tracer's point is `a + (b - a) u + (c - a) v` and its ray starts `offset` along the unit normal, all in
    /// `f32`: with the roundings by which the point's cell was found, it strays from the exact one by less than 16 u of
    /// the largest coordinate, the edges and the offset together, where u = 2^-24.
    pub fn shaft(&self, cell: Cell, outside: bool, lights: &[Vec3]) -> Shaft {
        let Record { corner, edges, normal, .. } = *self.record;
        let [ab, ac] = edges.map(|edge| edge.as_dvec3());
        // The tracer's own unit normal, rounded as there.
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
