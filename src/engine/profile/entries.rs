//! Entries of a policy's stores: which steps are performed, and what first touches and registers make of them.

use super::flight::Flight;
use crate::engine::register::{Kept, Register};
use crate::engine::source::StoreWork;
use crate::engine::store_steps::StoreSteps;
use crate::machine::MachineSpec;
use crate::machine::layout::Layout;
use crate::stream::{Header, Step, Store};

/// How the entry of a step is accessed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EntryAccess {
    /// Not at all: a register took the step.
    Taken,
    /// By an operation.
    Performed {
        /// Whether an update sets modes, and so needs the entry's data.
        sets_modes: bool,
    },
}

/// The entries of a frame.
#[derive(Clone, Debug)]
pub(super) struct Entries {
    /// Which steps are performed.
    pub steps: StoreSteps,
    /// What was done otherwise than recorded.
    pub work: StoreWork,
    /// Of each shadow-cache unit.
    registers: Vec<Register>,
}

impl Entries {
    /// Of a machine's units, before a stream begins.
    pub(super) fn new(machine: &MachineSpec, header: &Header) -> Self {
        let units = machine.cores.size() * machine.shadow_cache.count.size();
        Self {
            steps: StoreSteps::new(&machine.shadow_cache, header),
            work: StoreWork::default(),
            registers: vec![Register::new(machine.shadow_cache.register.size()); units],
        }
    }

    /// A frame ends: what waits in the registers, the oldest of each first.
    pub(super) fn drain(&mut self) -> impl Iterator<Item = Step> + '_ {
        self.registers.iter_mut().flat_map(Register::drain)
    }

    /// How an access to the entry of a flight's next step, at its owner `unit`, goes.
    pub(super) fn access(&mut self, flight: &mut Flight, is_ray: bool, unit: usize, layout: &Layout) -> EntryAccess {
        let Self { steps, work, registers } = self;
        let first = if is_ray { steps.first_touch(&mut flight.steps, flight.next, layout, work) } else { None };
        flight.evaluating = first.unwrap_or(flight.evaluating);
        let sets_modes = flight.evaluating > 0 || !is_ray && !flight.operand;
        let step = Step::unpack(flight.steps[flight.next]).expect("steps are checked at hand-over");
        let register = &mut registers[unit];
        let entry = step.entry().filter(|(store, _)| is_ray && *store != Store::OccluderId);
        let Some((store, index)) = entry.filter(|_| !sets_modes && register.is_there()) else {
            return EntryAccess::Performed { sets_modes };
        };
        let addr = layout.entry(store, index, false).addr;
        let taken = if matches!(step, Step::Read { .. }) {
            let answered = register.answers(addr);
            work.merged_reads += u64::from(answered);
            register.was_read(addr);
            answered
        } else {
            match register.keep(addr, step) {
                Kept::Merged => {
                    work.merged_writes += 1;
                    true
                }
                Kept::Waits => true,
                Kept::InPlaceOf(other) => {
                    flight.steps[flight.next] = other.pack();
                    false
                }
            }
        };
        if !taken {
            return EntryAccess::Performed { sets_modes };
        }
        flight.steps.remove(flight.next);
        EntryAccess::Taken
    }
}
