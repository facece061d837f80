//! Hints: the last static blocker of rays from a cell to a light, to be tested first.
//!
//! A hint is tested with the ray itself before it is believed, so nothing depends on it but work. Hence the table needs
//! no tags: two cells that share an entry spoil each other's hint, never the picture.

use rustc_hash::FxHashMap;

use super::cells::Cell;
use super::{Change, Probe};
use crate::accel::{Ray, Trail};
use crate::quantity::{LightId, PrimitiveId};
use crate::stream::Store;

/// An entry without a hint.
const NONE: u32 = u32::MAX;

/// The table, as it was at the frame's start.
pub struct Hints {
    entries: Vec<u32>,
    lights: usize,
}

/// The kind of [`Change`] that carries a hint.
pub const HINT: u32 = 1 << 17;

impl Hints {
    /// A table of a power of two of entries.
    pub fn new(entries: usize, lights: usize) -> Self {
        Self { entries: vec![NONE; entries], lights }
    }

    /// Multiplicative hashing (Knuth, TAOCP 3, section 6.4): the upper bits of a product with an odd number.
    fn index(&self, cell: Cell, light: LightId) -> u32 {
        let key = u64::from(cell.primitive.0) << 32 ^ u64::from(cell.place) << 6 ^ u64::from(light.0);
        let product = key.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (product >> (64 - self.entries.len().trailing_zeros())) as u32
    }

    /// Somebody to use it in a band.
    pub fn worker(&self) -> HintWorker<'_> {
        HintWorker { hints: self, changed: FxHashMap::default(), last: vec![None; self.lights] }
    }

    /// Takes in the hints of a frame, the last band's last.
    pub fn end_frame(&mut self, changes: &[Change], trail: &mut Trail) {
        for change in changes.iter().filter(|change| change.kind == HINT) {
            self.entries[change.index as usize] = change.value;
            trail.update(Store::OccluderId, change.index);
        }
    }

    /// The number of entries.
    pub fn len(&self) -> u32 {
        self.entries.len() as u32
    }
}

/// Uses hints in a band.
pub struct HintWorker<'a> {
    hints: &'a Hints,
    changed: FxHashMap<u32, u32>,
    /// The blocker of the last ray to each light, whichever cell it came from.
    last: Vec<Option<PrimitiveId>>,
}

impl HintWorker<'_> {
    /// A triangle that is certain to block `ray`, if the hint names one.
    pub fn blocker(&mut self, cell: Cell, light: LightId, ray: &Ray, probe: &mut Probe<'_>) -> Option<PrimitiveId> {
        let index = self.hints.index(cell, light);
        probe.read(Store::OccluderId, index);
        let hint = self.changed.get(&index).copied().unwrap_or(self.hints.entries[index as usize]);
        let own = (hint != NONE).then_some(PrimitiveId(hint));
        let hint = own.or(self.last[usize::from(light.0)])?;
        probe.surely_blocked(ray, hint).then_some(hint)
    }

    /// A ray from a cell to a light had this static blocker, or none.
    pub fn learn(&mut self, cell: Cell, light: LightId, blocker: Option<PrimitiveId>, drop: bool) {
        let index = self.hints.index(cell, light);
        self.last[usize::from(light.0)] = blocker;
        let hint = self.changed.get(&index).copied().unwrap_or(self.hints.entries[index as usize]);
        let new = match blocker {
            Some(b) => b.0,
            None if drop => NONE,
            None => hint,
        };
        if new != hint {
            self.changed.insert(index, new);
        }
    }

    /// What was learned.
    pub fn finish(self) -> impl Iterator<Item = Change> {
        self.changed.into_iter().map(|(index, value)| Change { kind: HINT, index, value })
    }
}
