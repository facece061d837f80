//! Boxes, and the box around the part of a triangle in a box.

use glam::{DVec3, Vec3};

use crate::scene::Triangle;

/// An axis-aligned box, closed on all sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    /// The lowest corner.
    pub low: Vec3,
    /// The highest corner.
    pub high: Vec3,
}

impl Bounds {
    /// The empty box.
    pub(crate) const EMPTY: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY };

    /// The box around a triangle.
    pub(crate) fn of(triangle: &Triangle) -> Self {
        let [a, b, c] = triangle.v;
        Self { low: a.min(b).min(c), high: a.max(b).max(c) }
    }

    /// The box around both boxes.
    pub(crate) fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// The common part of both boxes; empty if there is none.
    pub(crate) fn intersection(self, other: Self) -> Self {
        Self { low: self.low.max(other.low), high: self.high.min(other.high) }
    }

    /// The parts below and above a plane across `axis`.
    pub(crate) fn split(self, axis: usize, at: f32) -> [Self; 2] {
        let [mut left, mut right] = [self; 2];
        left.high[axis] = at;
        right.low[axis] = at;
        [left, right]
    }

    /// The area of the surface.
    pub(crate) fn area(self) -> f64 {
        let size = (self.high.as_dvec3() - self.low.as_dvec3()).max(DVec3::ZERO);
        2.0 * (size.x * size.y + size.y * size.z + size.z * size.x)
    }

    /// The box around the part of `triangle` that lies in this box; `None` if no part does. It is computed in `f64`
    /// and rounded outwards, so that it contains the whole part.
    pub(crate) fn clip(self, triangle: &Triangle) -> Option<Self> {
        let mut polygon = Polygon::new(triangle);
        for axis in 0..3 {
            polygon.clip(axis, f64::from(self.low[axis]), 1.0);
            polygon.clip(axis, f64::from(self.high[axis]), -1.0);
        }
        let points = polygon.points();
        let &first = points.first()?;
        let (low, high) = points.iter().fold((first, first), |(low, high), &p| (low.min(p), high.max(p)));
        let part = Self {
            low: Vec3::from_array(low.to_array().map(round_down)),
            high: Vec3::from_array(high.to_array().map(|x| -round_down(-x))),
        };
        Some(part.intersection(self))
    }
}

fn round_down(x: f64) -> f32 {
    let rounded = x as f32;
    if f64::from(rounded) > x { rounded.next_down() } else { rounded }
}

/// A triangle cut by up to six planes, each of which adds at most one corner.
struct Polygon {
    corners: [DVec3; 9],
    count: usize,
}

impl Polygon {
    fn new(triangle: &Triangle) -> Self {
        let mut corners = [DVec3::ZERO; 9];
        for (corner, v) in corners.iter_mut().zip(triangle.v) {
            *corner = v.as_dvec3();
        }
        Self { corners, count: 3 }
    }

    fn points(&self) -> &[DVec3] {
        &self.corners[..self.count]
    }

    /// Keeps the part in the plane across `axis` and on its side `sign` (Sutherland and Hodgman 1974).
    fn clip(&mut self, axis: usize, plane: f64, sign: f64) {
        let outside = |point: DVec3| (point[axis] - plane) * sign < 0.0;
        if !self.points().iter().any(|&point| outside(point)) {
            return;
        }
        let mut kept = Self { corners: [DVec3::ZERO; 9], count: 0 };
        let mut push = |point| {
            kept.corners[kept.count] = point;
            kept.count += 1;
        };
        let points = self.points();
        for (index, &from) in points.iter().enumerate() {
            let to = points[(index + 1) % points.len()];
            if !outside(from) {
                push(from);
            }
            if outside(from) != outside(to) && from[axis] != plane && to[axis] != plane {
                let mut crossing = from + (to - from) * ((plane - from[axis]) / (to[axis] - from[axis]));
                crossing[axis] = plane;
                push(crossing);
            }
        }
        *self = kept;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(corners: [[f32; 3]; 3]) -> Triangle {
        Triangle { v: corners.map(Vec3::from_array) }
    }

    fn bounds(low: [f32; 3], high: [f32; 3]) -> Bounds {
        Bounds { low: low.into(), high: high.into() }
    }

    #[test]
    fn clips_to_the_part_inside() {
        let slanted = triangle([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]);
        let cell = bounds([1.0, 1.0, -1.0], [4.0, 4.0, 1.0]);
        assert_eq!(cell.clip(&slanted), Some(bounds([1.0, 1.0, 0.0], [3.0, 3.0, 0.0])));
    }

    #[test]
    fn a_box_that_overlaps_the_box_of_a_triangle_alone_holds_nothing_of_it() {
        let slanted = triangle([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]);
        assert_eq!(bounds([3.0, 3.0, -1.0], [4.0, 4.0, 1.0]).clip(&slanted), None);
    }

    #[test]
    fn a_triangle_that_touches_counts() {
        let flat = triangle([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]]);
        let cell = bounds([0.0, 0.0, 0.0], [0.5, 0.5, 1.0]);
        assert_eq!(cell.clip(&flat), Some(bounds([0.0, 0.0, 1.0], [0.5, 0.5, 1.0])));
    }

    #[test]
    fn rounds_outwards() {
        let thin = triangle([[0.0, 0.0, 0.0], [3.0, 1.0, 0.0], [3.0, 1.0, 1.0]]);
        let part = bounds([1.0, 0.0, 0.0], [2.0, 1.0, 1.0]).clip(&thin).unwrap();
        assert!(f64::from(part.low.y) <= 1.0 / 3.0 && f64::from(part.low.y.next_up()) > 1.0 / 3.0);
        assert!(f64::from(part.high.y) >= 2.0 / 3.0 && f64::from(part.high.y.next_down()) < 2.0 / 3.0);
    }
}
