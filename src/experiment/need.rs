//! Estimates and limits the memory that an experiment takes, before it begins.

use std::fmt;

use crate::quantity::Resolution;
use crate::report::format::counted;

/// The limit for the bytes of pictures, policies, scene and machines together.
const MOST: u128 = 1 << 32;

/// Bytes of a pixel in a policy's frame: colour, hit and shadows.
const TRACED_PIXEL: u128 = 36;
/// Bytes of a pixel in a picture of the report.
const SHOWN_PIXEL: u128 = 3;
/// Approximate bytes of a triangle with its attributes and its part of the tree.
const TRIANGLE: u128 = 400;
/// Bytes of an entry of a policy's store.
const ENTRY: u128 = 8;
/// Bytes of a pixel's recorded rays, if a live policy makes the whole picture one band: 250 steps of 4 bytes, assumed
/// (kitchen with six lights: 146 steps).
const RECORDED_PIXEL: u128 = 1000;

/// The memory that an experiment is going to take.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Need {
    what: String,
    bytes: u128,
}

/// What an experiment consists of.
#[derive(Clone, Debug)]
pub(super) struct Amounts {
    pub resolution: Resolution,
    pub frames: usize,
    pub policies: usize,
    /// Entries of all policies' stores.
    pub entries: u64,
    /// Whether a policy reads what it has learned at once, so that the picture is one band.
    pub is_live: bool,
    pub lights: usize,
    pub triangles: usize,
    /// The bytes of each machine.
    pub machines: Vec<u128>,
}

impl Need {
    /// The need of an experiment.
    pub(super) fn of(amounts: &Amounts) -> Self {
        let &Amounts { resolution, frames, policies, entries, is_live, lights, triangles, ref machines } = amounts;
        let policies_told = if policies == 1 { "1 policy".into() } else { format!("{policies} policies") };
        let (frames, machines_told) = (counted(frames, "frame"), counted(machines.len(), "machine"));
        let what = format!("{frames} of {resolution}, {policies_told}, {machines_told}");
        let policies = policies as u128;
        // The reference renderer adds one frame; pictures of two frames are kept.
        let shown = 2 * (1 + policies * (3 + lights as u128));
        let recorded = if is_live { RECORDED_PIXEL * policies } else { 0 };
        let pixel = TRACED_PIXEL * (policies + 2) + SHOWN_PIXEL * shown + recorded;
        // Each machine replays each stream at most twice, as it is and for the split, and one stream for miss curves.
        let replays = (2 * policies + 1) * machines.iter().sum::<u128>();
        let rest = TRIANGLE * triangles as u128 + ENTRY * u128::from(entries);
        let bytes = resolution.pixels() as u128 * pixel + replays + rest;
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
        let amounts = |side, policies, machine| Amounts {
            resolution: Resolution { width: side, height: side },
            frames: 4,
            policies,
            entries: 0,
            is_live: false,
            lights: 2,
            triangles: 100,
            machines: vec![machine],
        };
        let need = |side, policies, machine| Need::of(&amounts(side, policies, machine));
        let small = need(64, 2, 1 << 20);
        assert_eq!(small.check(), Ok(()));
        assert_eq!(small.to_string(), "4 frames of 64x64, 2 policies, 1 machine; about 7 MB of memory");
        let live = Need::of(&Amounts { is_live: true, ..amounts(2048, 2, 0) });
        let entries = Need::of(&Amounts { entries: 1 << 30, ..amounts(64, 2, 0) });
        for large in [need(8192, 10, 0), need(64, 100, 1 << 28), live, entries] {
            let told = large.check().unwrap_err();
            assert!(told.contains(&large.bytes.to_string()) && told.contains("up to 4294967296"), "{told}");
        }
    }
}
