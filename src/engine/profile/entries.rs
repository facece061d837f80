//! Entries of a policy's stores: which steps are performed, and the effects of first touches and registers.

use super::flight::Flight;
use crate::engine::register::{Kept, Register};
use crate::engine::source::StoreWork;
use crate::engine::store_steps::StoreSteps;
use crate::machine::MachineSpec;
use crate::machine::layout::Layout;
use crate::stream::{Header, Step, Store};

/// The result of an access to a step's entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EntryAccess {
    /// No access: a register took the step.
    Taken,
    /// An operation performs the access.
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
    /// Differences from the recorded steps.
    pub work: StoreWork,
    /// One register per shadow-cache unit.
    registers: Vec<Register>,
}

impl Entries {
    /// The entries of a machine's units, before a stream begins.
    pub(super) fn new(machine: &MachineSpec, header: &Header) -> Self {
        let units = machine.cores.size() * machine.shadow_cache.count.size();
        Self {
            steps: StoreSteps::new(&machine.shadow_cache, header),
            work: StoreWork::default(),
            registers: vec![Register::new(machine.shadow_cache.register.size()); units],
        }
    }

    /// A frame ends: returns the updates that wait in the registers, oldest first per register.
    pub(super) fn drain(&mut self) -> impl Iterator<Item = Step> + '_ {
        self.registers.iter_mut().flat_map(Register::drain)
    }

    /// Result of an access to the entry of a flight's next step, at its owner `unit`.
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
