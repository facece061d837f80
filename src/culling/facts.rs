//! Scene properties that a policy needs.

use crate::quantity::PrimitiveId;
use crate::scene::{Lamps, Scene};

/// Scene properties that a policy needs before the first frame.
#[derive(Clone, Copy, Debug)]
pub struct SceneFacts {
    /// Number of static primitives; the ids of dynamic primitives start here.
    pub statics: u32,
    /// Number of all primitives.
    pub primitives: u32,
    /// Number of lights.
    pub lights: u32,
    /// Which lights belong to one lamp.
    pub lamps: Lamps,
}

impl SceneFacts {
    /// The facts of a scene.
    pub fn of(scene: &Scene) -> Self {
        Self {
            statics: scene.statics.len() as u32,
            primitives: scene.primitive_count() as u32,
            lights: scene.light_count as u32,
            lamps: scene.lamps,
        }
    }

    /// Whether a primitive can move.
    pub fn is_dynamic(&self, primitive: PrimitiveId) -> bool {
        primitive.0 >= self.statics
    }
}
