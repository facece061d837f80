//! The steps of a policy that a machine performs, ray by ray: as its engines perform them, without time.

use crate::engine::source::StoreWork;
use crate::engine::store_steps::StoreSteps;
use crate::machine::MachineSpec;
use crate::machine::layout::Layout;
use crate::machine::shadow_cache::ShadowCacheSpec;
use crate::stream::{Header, Step, Totals};

/// What tells which steps are performed: other fields are the defaults, so that machines can share what they do alike.
/// Registers and tables of hits, which merge some, are left out.
pub(super) fn spec_of(machine: &MachineSpec) -> ShadowCacheSpec {
    let ShadowCacheSpec { silent, decide, place, frame_end, latched, .. } = machine.shadow_cache;
    ShadowCacheSpec { silent, decide, place, frame_end, latched, ..ShadowCacheSpec::default() }
}

/// Steps of a stream's policy.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Performed {
    steps: StoreSteps,
    /// What was done otherwise than recorded, which nobody asks for here.
    work: StoreWork,
    replayed: Totals,
}

impl Performed {
    /// Of a machine, before a stream begins.
    pub(super) fn new(machine: &MachineSpec, header: &Header) -> Self {
        Self {
            steps: StoreSteps::new(&spec_of(machine), header),
            work: StoreWork::default(),
            replayed: Totals::default(),
        }
    }

    /// Puts into `steps` the packed steps that are performed of those that the stream has of a ray.
    pub(super) fn of_ray(&mut self, policy: &[u32], layout: &Layout, steps: &mut Vec<u32>) {
        steps.clear();
        steps.extend_from_slice(policy);
        self.steps.leave_out(steps, 0, layout, (&mut self.work, &mut self.replayed));
        let mut next = if self.steps.sets_on_first_touch() { 0 } else { steps.len() };
        while next < steps.len() {
            next += self.steps.first_touch(steps, next, layout, &mut self.work).map_or(1, usize::from);
        }
    }

    /// Steps that are performed at the end of a frame for which the stream has these.
    pub(super) fn at_end(&mut self, recorded: &[u32], layout: &Layout) -> Vec<Step> {
        self.steps.end(recorded, layout, (&mut self.work, &mut self.replayed))
    }
}
