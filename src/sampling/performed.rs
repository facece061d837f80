//! The policy steps that a machine performs, ray by ray, without time: the same steps as in its engines.

use crate::engine::source::StoreWork;
use crate::engine::store_steps::StoreSteps;
use crate::machine::MachineSpec;
use crate::machine::layout::Layout;
use crate::machine::shadow_cache::ShadowCacheSpec;
use crate::stream::{Header, Step, Totals};

/// The fields that determine which steps are performed. Other fields get their defaults, so that machines can share
/// equal work. Registers and tables of hits, which merge some steps, are left out.
pub(super) fn spec_of(machine: &MachineSpec) -> ShadowCacheSpec {
    let ShadowCacheSpec { silent, decide, place, frame_end, latched, .. } = machine.shadow_cache;
    ShadowCacheSpec { silent, decide, place, frame_end, latched, ..ShadowCacheSpec::default() }
}

/// The policy steps of a stream.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Performed {
    steps: StoreSteps,
    /// The steps of a ray while they are changed.
    changed: Vec<u32>,
    /// Counts of steps performed otherwise than recorded; not used here.
    work: StoreWork,
    replayed: Totals,
}

impl Performed {
    /// The steps of a machine, before a stream begins.
    pub(super) fn new(machine: &MachineSpec, header: &Header) -> Self {
        Self {
            steps: StoreSteps::new(&spec_of(machine), header),
            changed: Vec::new(),
            work: StoreWork::default(),
            replayed: Totals::default(),
        }
    }

    /// Calls `perform` for each performed step of a ray; `policy` are its recorded, packed steps.
    pub(super) fn of_ray(&mut self, policy: &[u32], layout: &Layout, perform: impl FnMut(Step)) {
        let Self { steps, changed, work, .. } = self;
        let unpacked = |word: u32| Step::unpack(word).expect("packed steps are valid");
        if !steps.sets_on_first_touch() {
            return policy.iter().filter_map(|&word| steps.performed(word, layout)).map(unpacked).for_each(perform);
        }
        changed.clear();
        changed.extend(policy.iter().filter_map(|&word| steps.performed(word, layout)));
        let mut next = 0;
        while next < changed.len() {
            next += steps.first_touch(changed, next, layout, work).map_or(1, usize::from);
        }
        changed.iter().copied().map(unpacked).for_each(perform);
    }

    /// The performed steps of an end of frame; `recorded` are its recorded, packed steps.
    pub(super) fn at_end(&mut self, recorded: &[u32], layout: &Layout) -> Vec<Step> {
        self.steps.end(recorded, layout, (&mut self.work, &mut self.replayed))
    }
}
