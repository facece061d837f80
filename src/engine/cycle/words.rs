//! State of mode words and counters shared by shadow-cache units: owner units, first touches, the end-of-frame update.

use std::collections::BTreeSet;

use crate::engine::source::StoreWork;
use crate::machine::layout::Layout;
use crate::machine::shadow_cache::{FrameEnd, Place, ShadowCacheSpec};
use crate::stream::{Header, Step, Store};

pub(super) struct Words {
    pub spec: ShadowCacheSpec,
    /// Shadow-cache units of all cores.
    units: usize,
    header: Header,
    /// Static primitives that rays have touched in this frame.
    touched: BTreeSet<u32>,
    /// Entries of learned bits that rays have updated in this frame.
    pub learned: BTreeSet<u32>,
    pub work: StoreWork,
    /// Units whose part of the end-of-frame update is not done.
    pub ending: usize,
}

/// The address of a step's entry.
pub(super) fn address(step: Step, layout: &Layout) -> Option<u64> {
    let (store, index) = step.entry()?;
    Some(layout.entry(store, index, false).addr.0)
}

impl Words {
    pub(super) fn new(spec: &ShadowCacheSpec, units: usize, header: &Header) -> Self {
        let (touched, learned, work) = (BTreeSet::new(), BTreeSet::new(), StoreWork::default());
        Self { spec: *spec, units, header: header.clone(), touched, learned, work, ending: 0 }
    }

    /// The owner unit of a step's entry; `None` if any unit can perform the step.
    pub(super) fn home(&self, step: Step, layout: &Layout) -> Option<usize> {
        let (store, index) = step.entry()?;
        let (line, _) = layout.lines(&layout.entry(store, index, false));
        Some(line.0 as usize % self.units)
    }

    /// The static primitive of a word or of a pair of counters, and whether the step accesses the first word or the
    /// counters.
    fn of_static(&self, step: Step) -> Option<(u32, bool)> {
        let stores = &self.header.stores;
        let (primitive, part) = match step.entry()? {
            (Store::PixelCounter, index) => (index, 0),
            (Store::ModeWord, index) if index < stores.word_owners * stores.words_per_primitive => {
                (index / stores.words_per_primitive, index % stores.words_per_primitive)
            }
            _ => return None,
        };
        (primitive < self.header.static_primitives).then_some((primitive, part == 0))
    }

    /// The updates that set the modes of a primitive.
    fn setting(&self, primitive: u32, layout: &Layout) -> Vec<Step> {
        let stores = &self.header.stores;
        let mut updates = Vec::new();
        if primitive < stores.pixel_counters {
            updates.push(Step::Update { store: Store::PixelCounter, index: primitive });
        }
        if primitive < stores.word_owners {
            let word = Step::Update { store: Store::ModeWord, index: primitive * stores.words_per_primitive };
            updates.retain(|&counters| address(counters, layout) != address(word, layout));
            updates.push(word);
        }
        updates
    }

    /// If a ray's step is a first touch: the steps that replace it; all but `own` set modes.
    pub(super) fn first_touch(&mut self, step: Step, layout: &Layout) -> Option<FirstTouch> {
        if self.spec.frame_end != FrameEnd::Epoch || self.header.stores.pixel_counters == 0 {
            return None;
        }
        let (primitive, _) = self.of_static(step)?;
        if !self.touched.insert(primitive) {
            return None;
        }
        let setting = self.setting(primitive, layout);
        let one_of_them = setting.iter().any(|&update| address(update, layout) == address(step, layout));
        if one_of_them {
            self.work.added_writes += setting.len() as u64 - 1;
            self.work.raised_reads += u64::from(!step.writes());
        } else {
            self.work.added_writes += setting.len() as u64;
        }
        Some(FirstTouch { setting, own: (!one_of_them).then_some(step) })
    }

    /// Splits the policy's steps into those with cost and those without.
    pub(super) fn without_free<S: Default + Extend<Step> + IntoIterator<Item = Step>>(&self, steps: S) -> (S, S) {
        let free = self.spec.place == Place::Free;
        steps.into_iter().partition(|step| !free || step.entry().is_none())
    }

    /// Whether updates can wait in a register.
    pub(super) fn registers_are_there(&self) -> bool {
        self.spec.register.get() > 0 && self.spec.place != Place::Free
    }

    /// The steps of an end-of-frame update, from the recorded steps.
    pub(super) fn end(&mut self, recorded: &[u32], layout: &Layout) -> Vec<Step> {
        self.touched.clear();
        let free = self.spec.place == Place::Free;
        let mut all = Vec::new();
        let lists = self.spec.frame_end == FrameEnd::List || self.header.stores.pixel_counters == 0;
        if self.spec.frame_end == FrameEnd::Sweep && !lists && !free {
            for primitive in 0..self.header.static_primitives {
                all.extend(self.setting(primitive, layout));
            }
            self.work.added_writes += all.len() as u64;
        }
        for step in Step::unpack_all(recorded) {
            let sets = matches!(step, Step::Update { .. }) && self.of_static(step).is_some_and(|(_, first)| first);
            match self.spec.frame_end {
                FrameEnd::Sweep if sets && !lists && !free => self.work.covered_writes += 1,
                FrameEnd::Epoch if sets && !lists && !free => self.work.deferred_writes += 1,
                _ => all.push(step),
            }
        }
        while let Some(learned) = self.learned.pop_first() {
            all.extend(layout.stores().fold(learned));
            self.work.added_reads += 1;
            self.work.added_writes += 1;
        }
        all
    }
}

/// The steps of a first touch.
pub(super) struct FirstTouch {
    /// The updates that set modes.
    pub setting: Vec<Step>,
    /// The ray's own step, unless one of the updates accesses its entry.
    pub own: Option<Step>,
}
