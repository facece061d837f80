//! The last blocker of each light and direction, tested first. Each light has a cube of cells around it, as in the
//! light buffer (Haines and Greenberg 1986), with one blocker per cell.

use glam::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::facts::SceneFacts;
use super::knowledge::Knowledge;
use super::policy::SurfaceHit;
use super::retest::{Key, Retest};
use crate::accel::Ray;
use crate::quantity::LightId;
use crate::ranged::Within;

/// The last static blocker of each light and cell of directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct OccluderGridSpec {
    /// Cells along each edge of a cube face. Each light has a cube of six faces around it.
    pub cells: Within<1, 1024>,
    /// Which learned data a decision can read.
    pub knowledge: Knowledge,
}

impl Default for OccluderGridSpec {
    /// 20 x 20 cells per face.
    fn default() -> Self {
        Self { cells: Within::new(20).expect("20 is within the range"), knowledge: Knowledge::default() }
    }
}

impl OccluderGridSpec {
    /// The policy at the start of an animation.
    pub fn build(self, facts: SceneFacts) -> Retest<ByDirection> {
        Retest::new(ByDirection { cells: self.cells.get() as u32, lights: facts.lights }, self.knowledge, facts)
    }
}

/// An entry for each light and cell of a cube around it.
pub struct ByDirection {
    cells: u32,
    lights: u32,
}

impl ByDirection {
    /// The cell that `direction` from a light goes through.
    fn cell(&self, direction: Vec3) -> u32 {
        let size = direction.abs();
        let axis = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let face = 2 * axis as u32 + u32::from(direction[axis] < 0.0);
        // From 0 to `cells`; a direction of length zero belongs to cell 0.
        let across = |along: usize| {
            let at = (direction[along] / size[axis] + 1.0) * 0.5 * self.cells as f32;
            (at as u32).min(self.cells - 1)
        };
        (face * self.cells + across((axis + 1) % 3)) * self.cells + across((axis + 2) % 3)
    }
}

impl Key for ByDirection {
    fn entries(&self) -> u32 {
        6 * self.cells * self.cells * self.lights
    }

    fn entry(&self, _: SurfaceHit, light: LightId, ray: &Ray) -> u32 {
        6 * self.cells * self.cells * u32::from(light.0) + self.cell(-ray.direction)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_cell_has_its_own_directions() {
        let key = ByDirection { cells: 4, lights: 1 };
        let mut seen = std::collections::BTreeSet::new();
        for face in 0..6 {
            for (u, v) in (0..4).flat_map(|u| (0..4).map(move |v| (u, v))) {
                let mut direction = Vec3::ZERO;
                direction[face / 2] = if face % 2 == 0 { 1.0 } else { -1.0 };
                direction[(face / 2 + 1) % 3] = (u as f32 + 0.5) / 2.0 - 1.0;
                direction[(face / 2 + 2) % 3] = (v as f32 + 0.5) / 2.0 - 1.0;
                for length in [1e-6, 1.0, 1e6] {
                    assert_eq!(key.cell(direction), key.cell(direction * length));
                }
                assert!(key.cell(direction) < key.entries());
                assert!(seen.insert(key.cell(direction)), "{direction}");
            }
        }
        for direction in [Vec3::ZERO, Vec3::ONE, -Vec3::ONE, Vec3::new(1.0, -1.0, 1.0)] {
            assert!(key.cell(direction) < key.entries());
        }
    }
}
