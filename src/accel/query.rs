//! Queries to a structure, and their results.

use glam::Vec2;

use crate::quantity::PrimitiveId;

/// The triangles among which a shadow ray is traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// Everything, static triangles first.
    All,
    /// Dynamic triangles only.
    Dynamic,
    /// Static triangles only.
    Static,
}

/// The order in which a shadow ray visits the children of a node that it meets. The order changes what is visited
/// before a blocker is found, never whether one is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// By the distance at which the ray enters their boxes.
    #[default]
    NearestFirst,
    /// By the area of their boxes (SATO: Nah and Manocha 2014).
    LargestFirst,
}

/// The nearest hit of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The primitive that is hit.
    pub primitive: PrimitiveId,
    /// Distance in units of the ray's direction.
    pub t: f32,
    /// Barycentric coordinates of corners 1 and 2.
    pub barycentric: Vec2,
}
