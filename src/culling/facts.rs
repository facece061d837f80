//! What a policy must know of a scene.

use crate::quantity::PrimitiveId;
use crate::scene::{Lamps, Scene};

/// What a policy must know of a scene before the first frame.
#[derive(Clone, Copy, Debug)]
pub struct SceneFacts {
    /// Static primitives; dynamic ones count from here on.
    pub statics: u32,
    /// All primitives.
    pub primitives: u32,
    /// Lights.
    pub lights: u32,
    /// Which of them belong to one lamp.
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
