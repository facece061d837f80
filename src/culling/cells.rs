//! Cells: a large receiver divided by its barycentric coordinates into 4^k triangles, the poster's "triangle
//! subdivision" without touching the geometry.
//!
//! A cell's number is its path from the whole triangle down, two bits a step: the corner 0, 1 or 2 that it keeps, or 3
//! for the middle triangle.

use glam::{Vec2, Vec3};

use crate::accel::Shaft;
use crate::quantity::PrimitiveId;
use crate::scene::Triangle;

/// The strip along the edges of a primitive that belongs to no cell, as a share of its height. A ray from the very edge
/// where two walls meet starts on the other wall, and rounding decides whether it is blocked: no proof can hold there.
const BORDER: f32 = 1.0 / 1024.0;

/// A cell of a primitive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Cell {
    /// Whose cell it is.
    pub primitive: PrimitiveId,
    /// Its path within the primitive.
    pub path: u32,
}

/// How all static primitives are divided.
#[derive(Clone, Debug)]
pub struct Cells {
    triangles: Vec<Triangle>,
    /// The number of the first cell of each primitive, and the total at the end.
    first: Vec<u32>,
    levels: Vec<u8>,
    offset: f32,
}

impl Cells {
    /// Divides each triangle until no edge of a cell is longer than `edge`, at most `deepest` times.
    pub fn new(triangles: &[Triangle], edge: f64, deepest: u8, offset: f32) -> Self {
        let level = |triangle: &Triangle| {
            let [a, b, c] = triangle.v;
            let longest = f64::from(a.distance(b).max(b.distance(c)).max(c.distance(a)));
            (0..deepest).find(|&level| longest <= edge * f64::from(1u32 << level)).unwrap_or(deepest)
        };
        let levels: Vec<_> = triangles.iter().map(level).collect();
        let mut first = vec![0];
        for &level in &levels {
            first.push(first[first.len() - 1] + (1 << (2 * level)));
        }
        Self { triangles: triangles.to_vec(), first, levels, offset }
    }

    /// The number of cells of all primitives.
    pub fn len(&self) -> u32 {
        self.first[self.first.len() - 1]
    }

    /// The number of a cell among all.
    pub fn number(&self, cell: Cell) -> u32 {
        self.first[cell.primitive.0 as usize] + cell.path
    }

    /// The level of a primitive's cells.
    pub fn level(&self, primitive: PrimitiveId) -> u8 {
        self.levels[primitive.0 as usize]
    }

    /// The cell with number `number`.
    pub fn cell(&self, number: u32) -> Cell {
        let primitive = self.first.partition_point(|&first| first <= number) - 1;
        Cell { primitive: PrimitiveId(primitive as u32), path: number - self.first[primitive] }
    }

    /// The cell of a static primitive that a point lies in; `None` on the strip along its edges.
    pub fn at(&self, primitive: PrimitiveId, barycentric: Vec2) -> Option<Cell> {
        let Vec2 { x: mut u, y: mut v } = (barycentric - BORDER) / (1.0 - 3.0 * BORDER);
        if !(u >= 0.0 && v >= 0.0 && u + v <= 1.0) {
            return None;
        }
        let mut path = 0;
        for _ in 0..self.levels[primitive.0 as usize] {
            (u, v) = (2.0 * u, 2.0 * v);
            let child = if u >= 1.0 {
                u -= 1.0;
                1
            } else if v >= 1.0 {
                v -= 1.0;
                2
            } else if u + v <= 1.0 {
                0
            } else {
                (u, v) = (1.0 - u, 1.0 - v);
                3
            };
            path = path << 2 | child;
        }
        Some(Cell { primitive, path })
    }

    /// All shadow rays from the cells of `cell`'s primitive whose path, without its last `up` steps, is `cell`'s.
    ///
    /// The tracer's point is `a + (b - a) u + (c - a) v` and its ray starts `offset` along the unit normal, all in `f32`:
    /// six roundings of at most the size of the result, and the cell was found with as many: together less than `16 u`
    /// of the largest coordinate and the edges.
    pub fn shaft(&self, cell: Cell, up: u8, outside: bool, light: Vec3) -> Shaft {
        let triangle = &self.triangles[cell.primitive.0 as usize];
        let [a, b, c] = triangle.v;
        let [ab, ac] = [b - a, c - a].map(|edge| edge.as_dvec3());
        let normal = triangle.normal().normalize() * if outside { 1.0 } else { -1.0 };
        let lifted = a.as_dvec3() + normal.as_dvec3() * f64::from(self.offset);
        let (near, far) = (f64::from(BORDER), 1.0 - 2.0 * f64::from(BORDER));
        let at = |u: f64, v: f64| lifted + ab * u + ac * v;
        let mut corners = [at(near, near), at(far, near), at(near, far)];
        for step in (up..self.level(cell.primitive)).rev() {
            let [a, b, c] = corners;
            let (ab, bc, ca) = ((a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5);
            corners = match cell.path >> (2 * step) & 3 {
                0 => [a, ab, ca],
                1 => [ab, b, bc],
                2 => [ca, bc, c],
                _ => [bc, ca, ab],
            };
        }
        let largest = triangle.v.into_iter().map(|corner| corner.as_dvec3().length()).fold(0.0, f64::max);
        let u = f64::from(f32::EPSILON) * 0.5;
        let spread = 16.0 * u * (largest + ab.length() + ac.length() + f64::from(self.offset));
        Shaft::new(corners, light, spread)
    }
}
