//! Which steps of a policy's stores a machine performs: the recorded steps, or others, depending on the layout, the
//! frame end and the latched copies of its spec. Nothing here is timed.

use std::collections::BTreeSet;

use rustc_hash::FxHashSet;

use super::source::StoreWork;
use crate::machine::layout::Layout;
use crate::machine::shadow_cache::{FrameEnd, Place, ShadowCacheSpec};
use crate::stream::{Header, Step, Store, StoreEntries, Totals};

/// Chooses the store steps of a frame, and counts the changes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct StoreSteps {
    spec: ShadowCacheSpec,
    entries: StoreEntries,
    static_primitives: u32,
    /// Static primitives whose word or counters a ray has touched in this frame; kept if first touches set modes.
    touched: FxHashSet<u32>,
    /// Entries of learned bits that rays of this frame have updated, if such bits have words of their own.
    learned: BTreeSet<u32>,
}

impl StoreSteps {
    /// For a machine's units, before a stream begins.
    pub(crate) fn new(spec: &ShadowCacheSpec, header: &Header) -> Self {
        Self {
            spec: *spec,
            entries: header.stores,
            static_primitives: header.static_primitives,
            touched: FxHashSet::default(),
            learned: BTreeSet::new(),
        }
    }

    /// Replaces the policy's steps in `steps`, from index `policy` on, by the performed steps; counts the omitted
    /// ones.
    pub(crate) fn leave_out(
        &mut self,
        steps: &mut Vec<u32>,
        policy: usize,
        layout: &Layout,
        (work, replayed): (&mut StoreWork, &mut Totals),
    ) {
        if self.spec.performs_all() {
            return;
        }
        let mut kept = policy;
        for at in policy..steps.len() {
            match self.performed(steps[at], layout) {
                Some(word) => {
                    steps[kept] = word;
                    kept += 1;
                }
                None => self.count_left_out(steps[at], work, replayed),
            }
        }
        steps.truncate(kept);
    }

    /// The packed step that is performed for a policy's step of a ray; `None` if no step is.
    pub(crate) fn performed(&mut self, word: u32, layout: &Layout) -> Option<u32> {
        if !self.spec.performs(word) {
            return None;
        }
        let update = Step::effect(word).and_then(|_| Step::unpack(word));
        let learns = update.and_then(|step| layout.stores().learns(step));
        self.learned.extend(learns.and_then(Step::entry).map(|(_, index)| index));
        Some(learns.map_or(word, Step::pack))
    }

    /// Counts a step of the policy that is not performed: a dropped update, or an access to an entry that costs
    /// nothing.
    pub(super) fn count_left_out(&self, word: u32, work: &mut StoreWork, replayed: &mut Totals) {
        if self.spec.silent.drops(word) {
            work.dropped_writes += 1;
        } else {
            replayed.count_policy(Step::unpack(word).into_iter());
        }
    }

    /// Whether the first touch of a primitive in a frame sets its modes.
    pub(crate) fn sets_on_first_touch(&self) -> bool {
        self.spec.frame_end == FrameEnd::Epoch && self.entries.pixel_counters > 0
    }

    /// If step `next` of a ray is a first touch that sets modes, inserts the steps that set them at `next`. Drops the
    /// touch itself if one of them sets the same entry. Returns the number of inserted steps, or `None` if there is no
    /// such touch.
    pub(crate) fn first_touch(
        &mut self,
        steps: &mut Vec<u32>,
        next: usize,
        layout: &Layout,
        work: &mut StoreWork,
    ) -> Option<u8> {
        let step = Step::unpack(steps[next]).filter(|_| self.sets_on_first_touch())?;
        let (store, index) = step.entry()?;
        let primitive = layout.stores().owner(store, index).filter(|&owner| owner < self.static_primitives)?;
        if !self.touched.insert(primitive) {
            return None;
        }
        let addr = |step: &Step| step.entry().map(|(store, index)| layout.entry(store, index, false).addr);
        let setting: Vec<Step> = self.mode_setting(primitive, layout).collect();
        let own = setting.iter().any(|other| addr(other) == addr(&step));
        let raised = own && matches!(step, Step::Read { .. });
        work.added_writes += (setting.len() - usize::from(own)) as u64;
        work.raised_reads += u64::from(raised);
        steps.splice(next..next + usize::from(own), setting.iter().map(|step| step.pack()));
        Some(setting.len() as u8)
    }

    /// The steps performed at a frame's end, for the steps `recorded` there.
    pub(crate) fn end(
        &mut self,
        recorded: &[u32],
        layout: &Layout,
        (work, replayed): (&mut StoreWork, &mut Totals),
    ) -> Vec<Step> {
        self.touched.clear();
        let Self { spec, .. } = *self;
        let counted = self.entries.pixel_counters > 0;
        let mut steps = Vec::new();
        if spec.frame_end == FrameEnd::Sweep && counted && spec.place != Place::Free {
            (0..self.static_primitives).for_each(|primitive| steps.extend(self.mode_setting(primitive, layout)));
            work.added_writes += steps.len() as u64;
        }
        for step in Step::unpack_all(recorded) {
            let entry = step.entry();
            let set = entry.filter(|_| counted && matches!(step, Step::Update { .. }));
            if entry.is_some() && spec.place == Place::Free {
                replayed.count_policy(std::iter::once(step));
            } else if spec.frame_end == FrameEnd::List
                || set.is_none_or(|(store, index)| self.set_at_the_end(store, index, layout).is_none())
            {
                steps.push(step);
            } else if spec.frame_end == FrameEnd::Sweep {
                work.covered_writes += 1;
            } else {
                work.deferred_writes += 1;
            }
        }
        for learned in std::mem::take(&mut self.learned) {
            steps.extend(layout.stores().fold(learned));
            work.added_reads += 1;
            work.added_writes += 1;
        }
        steps
    }

    /// The static primitive whose counters or first word the entry is; `None` for any other entry.
    fn set_at_the_end(&self, store: Store, index: u32, layout: &Layout) -> Option<u32> {
        let owner = layout.stores().owner(store, index)?;
        let first = store == Store::PixelCounter || index == owner * self.entries.words_per_primitive;
        (first && owner < self.static_primitives).then_some(owner)
    }

    /// The updates that set a primitive's modes.
    fn mode_setting(&self, primitive: u32, layout: &Layout) -> impl Iterator<Item = Step> + use<> {
        let entries = &self.entries;
        let word = Step::Update { store: Store::ModeWord, index: primitive * entries.words_per_primitive };
        let counters = Step::Update { store: Store::PixelCounter, index: primitive };
        let has_word = primitive < entries.word_owners;
        let apart = primitive < entries.pixel_counters && !(has_word && layout.stores().counters_are_in_words());
        apart.then_some(counters).into_iter().chain(has_word.then_some(word))
    }
}
