//! Estimates and limits the memory that an experiment takes, before it begins.

use std::fmt;

use crate::quantity::Resolution;
use crate::report::format::counted;

/// The limit for the bytes of pictures, scene and machines together.
const MOST: u128 = 1 << 32;

/// Bytes of a pixel in a policy's frame: colour, hit and shadows.
const TRACED_PIXEL: u128 = 36;
/// Bytes of a pixel in a picture of the report.
const SHOWN_PIXEL: u128 = 3;
/// Approximate bytes of a triangle with its attributes and its part of the tree.
const TRIANGLE: u128 = 400;

/// The memory that an experiment is going to take.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Need {
    what: String,
    bytes: u128,
}

impl Need {
    /// The need of `frames` frames of `resolution` for the given numbers of policies, lights and triangles. `machines`
    /// holds the bytes of each machine.
    pub(super) fn new(
        resolution: Resolution,
        frames: usize,
        policies: usize,
        lights: usize,
        triangles: usize,
        machines: &[u128],
    ) -> Self {
        let policies_told = if policies == 1 { "1 policy".into() } else { format!("{policies} policies") };
        let (frames, machines_told) = (counted(frames, "frame"), counted(machines.len(), "machine"));
        let what = format!("{frames} of {resolution}, {policies_told}, {machines_told}");
        let policies = policies as u128;
        // The reference renderer adds one frame; pictures of two frames are kept.
        let shown = 2 * (1 + policies * (3 + lights as u128));
        let pixel = TRACED_PIXEL * (policies + 2) + SHOWN_PIXEL * shown;
        // Each machine replays each stream at most twice, as it is and for the split, and one stream for miss curves.
        let replays = (2 * policies + 1) * machines.iter().sum::<u128>();
        let bytes = resolution.pixels() as u128 * pixel + replays + TRIANGLE * triangles as u128;
        Self { what, bytes }
    }

    /// Refuses an experiment that needs more than [`MOST`].
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_bounded_and_told() {
        let need = |side, policies, machine| {
            Need::new(Resolution { width: side, height: side }, 4, policies, 2, 100, &[machine])
        };
        let small = need(64, 2, 1 << 20);
        assert_eq!(small.check(), Ok(()));
        assert_eq!(small.to_string(), "4 frames of 64x64, 2 policies, 1 machine; about 7 MB of memory");
        for large in [need(8192, 10, 0), need(64, 100, 1 << 28)] {
            let told = large.check().unwrap_err();
            assert!(told.contains(&large.bytes.to_string()) && told.contains("up to 4294967296"), "{told}");
        }
    }
}
