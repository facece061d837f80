//! The line stream of one kind of L1: the lines that a single cache would be asked for if each ray were done before
//! the next one began. It depends on the machine's memory layout, but not on caches or time.

use super::work::{Holder, Work, entries_as_recorded, stores_as_recorded};
use crate::machine::kinds::Kind;
use crate::machine::layout::Layout;
use crate::machine::word_traffic::SilentUpdates;
use crate::machine::{MachineSpec, SpecError};
use crate::quantity::LineAddr;
use crate::stream::{Decision, Header, Item, RayKind, Step};

/// The line stream for the L1s of one kind of units.
#[derive(Clone, Debug)]
pub struct LineStream {
    kind: Kind,
    layout: Layout,
    silent: SilentUpdates,
}

impl LineStream {
    /// The line stream for the L1s that reports call `cache`, before the stream begins.
    ///
    /// # Errors
    /// There are no such L1s, or the machine does not access stores as the stream records it.
    pub fn new(machine: &MachineSpec, header: &Header, cache: &str) -> Result<Self, SpecError> {
        machine.check_stream(header)?;
        let Some(kind) = Kind::ALL.into_iter().find(|kind| kind.names().1 == cache) else {
            let known = Kind::ALL.map(|kind| kind.names().1).join(", ");
            return Err(SpecError::new(format!("there is no L1 called `{cache}`: {known} are")));
        };
        let known = if kind == Kind::ShadowCache { stores_as_recorded(machine) } else { entries_as_recorded(machine) };
        if !known {
            let what = "lines are known in the order of the stream only with `place: Own`, `register: 0`, `frame_end: List` and \
                        no `latched: Buffers` of `shadow_cache`, those of l1_shadow_cache only with `gather: 0` besides";
            return Err(SpecError::new(what));
        }
        Ok(Self { kind, layout: Layout::new(header, machine), silent: machine.shadow_cache.silent })
    }

    /// Takes the next item of the stream. Calls `access` with each line requested, and whether it is written.
    pub fn item(&mut self, item: &Item, mut access: impl FnMut(LineAddr, bool)) {
        match item {
            Item::Frame(info) => self.layout.begin_frame(info),
            Item::Rays(chunk) => {
                for ray in chunk.rays() {
                    if ray.head.decision != Decision::Skip {
                        self.steps(ray.packed_path().iter(), Holder::Traversal, ray.head.kind, &mut access);
                    }
                    let policy = ray.packed_policy().iter().filter(|&&word| !self.silent.drops(word));
                    self.steps(policy, Holder::ShadowCache, ray.head.kind, &mut access);
                }
            }
            Item::End { policy, .. } => self.steps(policy.iter(), Holder::ShadowCache, RayKind::Primary, &mut access),
        }
    }

    fn steps<'a>(
        &self,
        words: impl Iterator<Item = &'a u32>,
        holder: Holder,
        ray: RayKind,
        access: &mut impl FnMut(LineAddr, bool),
    ) {
        let steps = words.filter_map(|&word| Step::unpack(word));
        for work in steps.map(|step| Work::of(step, holder, ray, &self.layout)).filter(|work| work.kind == self.kind) {
            for element in work.elements() {
                let (first, lines) = self.layout.lines(&element);
                (first.0..first.0 + lines).for_each(|line| access(LineAddr(line), element.write));
            }
        }
    }
}
