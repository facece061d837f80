//! Hints: the last static blocker of rays from a cell to a light, to be tested first.
//!
//! A hint is trusted only after a test with the ray itself, so hints change the work but no result. Hence the table
//! needs no tags: two cells that share an entry spoil each other's hint, never the picture.

use rustc_hash::FxHashMap;

use super::cells::Cell;
use super::policy::Change;
use super::probe::Probe;
use crate::accel::{Ray, Trail};
use crate::quantity::{LightId, PrimitiveId};
use crate::random::GOLDEN;
use crate::ranged::PowerOfTwo;
use crate::stream::Store;

/// An entry without a hint.
const NONE: u32 = u32::MAX;

/// The kind of [`Change`] that carries a hint.
const HINT: u32 = 1 << 17;

/// The table, as of the frame's start.
pub(crate) struct Hints {
    entries: Vec<u32>,
    lights: u32,
}

impl Hints {
    /// An empty table.
    pub(crate) fn new<const LO: u64, const HI: u64>(entries: PowerOfTwo<LO, HI>, lights: u32) -> Self {
        Self { entries: vec![NONE; entries.size()], lights }
    }

    /// Multiplicative hashing: the upper bits of a product with an odd number near 2^64 over the golden ratio (Knuth,
    /// TAOCP 3, section 6.4).
    fn index(&self, cell: Cell, light: LightId) -> u32 {
        let key = u64::from(cell.primitive.0) << 32 ^ u64::from(cell.place) << 6 ^ u64::from(light.0);
        let product = key.wrapping_mul(GOLDEN);
        (product >> (64 - self.entries.len().trailing_zeros())) as u32
    }

    /// A worker that uses the table in a band.
    pub(crate) fn worker(&self) -> HintWorker<'_> {
        HintWorker { hints: self, changed: FxHashMap::default(), last: vec![Last::default(); self.lights as usize] }
    }

    /// Applies the changes of a frame; where two bands changed an entry, the later band wins.
    pub(crate) fn end_frame(&mut self, changes: &[Change], trail: &mut Trail) {
        let mut hints: Vec<_> = changes.iter().filter(|change| change.kind == HINT).collect();
        // The sort is stable, so bands stay in order. The changes of one band have any order, but name each entry only
        // once.
        hints.sort_by_key(|change| change.index);
        for change in hints {
            self.entries[change.index as usize] = change.value;
            trail.update(Store::OccluderId, change.index);
        }
    }

    /// The number of entries.
    pub(crate) fn entries(&self) -> u32 {
        self.entries.len() as u32
    }
}

/// The latest rays to a light that no certificate answered, from any cell.
#[derive(Clone, Copy, Debug, Default)]
struct Last {
    /// The last blocker.
    blocker: Option<PrimitiveId>,
    /// Whether the last ray was blocked.
    dark: bool,
}

/// Uses hints in a band.
pub(crate) struct HintWorker<'a> {
    hints: &'a Hints,
    changed: FxHashMap<u32, u32>,
    last: Vec<Last>,
}

impl HintWorker<'_> {
    fn hint(&self, index: u32) -> u32 {
        self.changed.get(&index).copied().unwrap_or(self.hints.entries[index as usize])
    }

    /// A triangle that is certain to block `ray`, if a hint names one. The cell's own hint is tested first, then the
    /// light's last blocker. A cell without a hint is new, or its last ray was lit; then the last blocker is tested
    /// only if the light's last ray was dark.
    pub(crate) fn blocker(&self, cell: Cell, light: LightId, ray: &Ray, probe: &mut Probe<'_>) -> Option<PrimitiveId> {
        let index = self.hints.index(cell, light);
        probe.read(Store::OccluderId, index);
        let hint = self.hint(index);
        let own = (hint != NONE).then_some(PrimitiveId(hint));
        let last = self.last[usize::from(light.0)];
        let next = last.blocker.filter(|&next| own != Some(next) && (own.is_some() || last.dark));
        own.into_iter().chain(next).find(|&primitive| probe.surely_blocked(ray, primitive))
    }

    /// Learns the static blocker of a ray from a cell to a light, or that there is none. After a lit ray the cell has
    /// no hint.
    pub(crate) fn learn(&mut self, cell: Cell, light: LightId, blocker: Option<PrimitiveId>) {
        let last = &mut self.last[usize::from(light.0)];
        *last = Last { blocker: blocker.or(last.blocker), dark: blocker.is_some() };
        let index = self.hints.index(cell, light);
        let hint = blocker.map_or(NONE, |blocker| blocker.0);
        if hint != self.hint(index) {
            self.changed.insert(index, hint);
        }
    }

    /// The changes of the band.
    pub(crate) fn finish(self) -> impl Iterator<Item = Change> {
        self.changed.into_iter().map(|(index, value)| Change { kind: HINT, index, value })
    }
}
