//! What an experiment takes in memory: bounded, and told before it begins.

use std::fmt;

use super::Experiment;

/// The most bytes that pictures, scene and machines may take together.
const MOST: u128 = 1 << 32;

/// Bytes of a pixel in a policy's frame: colour, hit and shadows.
const TRACED_PIXEL: u128 = 36;
/// Bytes of a pixel in a picture of the report.
const SHOWN_PIXEL: u128 = 3;
/// Bytes of a triangle with its attributes and its part of the tree, about.
const TRIANGLE: u128 = 400;

/// What an experiment is going to take.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Need {
    what: String,
    bytes: u128,
}

impl Need {
    /// The need of an experiment.
    pub(super) fn of(experiment: &Experiment) -> Self {
        let (spec, scene) = (&experiment.spec, &experiment.scene);
        let policies = spec.policies.len() as u128;
        // The reference renderer's frame is one more; pictures are kept of two frames.
        let shown = 2 * (1 + policies * (3 + scene.light_count as u128));
        let pixel = TRACED_PIXEL * (policies + 2) + SHOWN_PIXEL * shown;
        let replays = 2 * policies;
        let machines: u128 = experiment.machines.iter().map(|(_, machine)| replays * machine.footprint()).sum();
        let triangles = TRIANGLE * scene.primitive_count() as u128;
        let bytes = spec.resolution.pixels() as u128 * pixel + machines + triangles;
        let what = format!(
            "{} frames of {}, {policies} policies, {} machines",
            experiment.frames.len(),
            spec.resolution,
            experiment.machines.len()
        );
        Self { what, bytes }
    }

    /// Refuses what is not payable.
    pub(super) fn check(&self) -> Result<(), String> {
        if self.bytes <= MOST {
            return Ok(());
        }
        Err(format!("{} take about {} bytes of memory: up to {MOST} are allowed", self.what, self.bytes))
    }
}

impl fmt::Display for Need {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}; about {} MB of memory", self.what, self.bytes.div_ceil(1_000_000))
    }
}
