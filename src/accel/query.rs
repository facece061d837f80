//! What is asked of a structure, and what it answers.

use glam::Vec2;

use crate::quantity::PrimitiveId;

/// What a shadow ray is traced among.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// Everything, static triangles first.
    All,
    /// Dynamic triangles only.
    Dynamic,
    /// Static triangles only.
    Static,
}

/// In which order a shadow ray visits the children of a node that it meets. It changes what is visited before a blocker
/// is found, never whether one is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// By where the ray enters their boxes.
    #[default]
    NearestFirst,
    /// By the area of their boxes (SATO: Nah and Manocha 2014).
    LargestFirst,
}

/// The nearest hit of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// What is hit.
    pub primitive: PrimitiveId,
    /// Distance in units of the ray's direction.
    pub t: f32,
    /// Barycentric coordinates of corners 1 and 2.
    pub barycentric: Vec2,
}
