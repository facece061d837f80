//! The last blocker of each primitive and light, tested first: the shadow cache of ray tracers, kept across frames.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::facts::SceneFacts;
use super::knowledge::Knowledge;
use super::policy::SurfaceHit;
use super::retest::{Key, Retest};
use crate::accel::Ray;
use crate::quantity::LightId;

/// The last static blocker of each primitive and light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LastOccluderSpec {
    /// Which learned data a decision can read.
    pub knowledge: Knowledge,
}

impl LastOccluderSpec {
    /// The policy at the start of an animation.
    pub fn build(self, facts: SceneFacts) -> Retest<ByPrimitive> {
        Retest::new(ByPrimitive { facts }, self.knowledge, facts)
    }
}

/// An entry for each primitive and light.
pub struct ByPrimitive {
    facts: SceneFacts,
}

impl Key for ByPrimitive {
    fn entries(&self) -> u32 {
        self.facts.primitives * self.facts.lights
    }

    fn entry(&self, hit: SurfaceHit, light: LightId, _: &Ray) -> u32 {
        hit.primitive.0 * self.facts.lights + u32::from(light.0)
    }
}
