//! What steps ask for. Steps with one tag differ only in which element they name: how many there are is counted, and what they ask for
//! is worked out once a phase. Only an element that was not named yet touches lines.

use fixedbitset::FixedBitSet;

use super::lines::{self, Lines};
use crate::engine::work::{Holder, Work, stores_as_recorded};
use crate::machine::MachineSpec;
use crate::machine::kinds::{Kind, KindSpec};
use crate::machine::layout::{Element, Layout};
use crate::memory::tags::Contents;
use crate::quantity::Bytes;
use crate::stats::TrafficClass;
use crate::stream::{FrameInfo, Header, RayKind, Step, Store};

/// Bits of a packed step's element; the tag is above.
const INDEX_BITS: u32 = Step::MAX_INDEX.trailing_ones();
/// Tags that 4 bits can hold; some are of no step.
const TAGS: usize = 1 << (u32::BITS - INDEX_BITS);

/// Whose steps.
#[derive(Clone, Copy, Debug)]
pub enum Steps {
    /// Those of a ray's path that wants to know where a triangle is hit.
    Path,
    /// Those of a shadow ray's path.
    ShadowPath,
    /// A policy's.
    Policy,
}

impl Steps {
    const ALL: [Self; 3] = [Self::Path, Self::ShadowPath, Self::Policy];

    /// What a step asks for.
    fn work(self, step: Step, layout: &Layout) -> Work {
        let (holder, ray) = match self {
            Self::Path => (Holder::Traversal, RayKind::Primary),
            Self::ShadowPath => (Holder::Traversal, RayKind::Shadow),
            Self::Policy => (Holder::ShadowCache, RayKind::Primary),
        };
        Work::of(step, holder, ray, layout)
    }
}

/// Elements of one kind that were named.
#[derive(Clone, Copy, Debug)]
enum Named {
    Nodes,
    Lists,
    Planes,
    Edges,
    PolicyNodes,
    PolicyLists,
    ModeWords,
    PixelCounters,
    OccluderIds,
}

const NAMED: usize = Named::OccluderIds as usize + 1;

/// What each step with a tag asks for.
#[derive(Clone, Copy, Debug)]
struct Tag {
    /// Cycles that the ray stays at least.
    stay: u64,
    /// Whether each asks for as many lines: then how many that are is in `lines`, operation by operation.
    uniform: bool,
    lines: [u64; 2],
    named: Named,
}

/// A tag that is of no step, or of steps that are left out: nothing is known without looking at the step.
const NOTHING: Tag = Tag { stay: 0, uniform: false, lines: [0; 2], named: Named::Nodes };

/// What is counted of a kind of units.
#[derive(Clone, Copy, Debug, Default)]
pub struct KindWork {
    /// Of the phase: operations, accesses to lines, cycles that rays hold contexts at least.
    pub operations: u64,
    pub accesses: u64,
    pub held: u64,
    /// Of the run.
    pub all_operations: u64,
    pub all_accesses: u64,
}

/// Counts steps.
#[derive(Clone, Debug)]
pub struct StepWork {
    machine: MachineSpec,
    pub kinds: [KindSpec; Kind::ALL.len()],
    layout: Layout,
    pub lines: Lines,
    tags: [[Tag; TAGS]; Steps::ALL.len()],
    /// Steps of the phase with each tag.
    counts: [[u64; TAGS]; Steps::ALL.len()],
    named: [FixedBitSet; NAMED],
    /// Elements from which on the dynamic part begins.
    statics: [usize; NAMED],
    pub work: [KindWork; Kind::ALL.len()],
    /// Divisions of the phase.
    pub divisions: u64,
    /// Lines that were written.
    pub writes: u64,
    /// Whether steps of stores are performed as recorded; else they are left out of what must be done, and this many may be done.
    pub stores_count: bool,
    pub left_out: u64,
    pub requested: [[Bytes; TrafficClass::ALL.len()]; Kind::ALL.len()],
}

impl StepWork {
    /// Of a stream that has not begun.
    pub fn new(machine: &MachineSpec, header: &Header) -> Self {
        let kinds = Kind::ALL.map(|kind| kind.spec(machine));
        let (nodes, lists, slots) = (header.static_nodes, header.static_list_entries, header.static_slots);
        // Entries of stores may lie in records of the dynamic part.
        let statics = [nodes, lists, slots, slots, nodes, lists, 0, 0, 0].map(|count| count as usize);
        let mut work = Self {
            layout: Layout::new(header, machine),
            lines: Lines::new(machine, &kinds),
            tags: [[NOTHING; TAGS]; Steps::ALL.len()],
            counts: Default::default(),
            named: Default::default(),
            statics,
            work: Default::default(),
            divisions: 0,
            writes: 0,
            stores_count: stores_as_recorded(machine),
            left_out: 0,
            requested: Default::default(),
            kinds,
            machine: machine.clone(),
        };
        work.tags = Steps::ALL.map(|steps| std::array::from_fn(|tag| work.tag(steps, tag)));
        work
    }

    fn tag(&self, steps: Steps, tag: usize) -> Tag {
        let step = |index: u64| Step::unpack((tag as u32) << INDEX_BITS | index as u32);
        let Some(first) = step(0).filter(|step| step.entry().is_none() || self.stores_count) else { return NOTHING };
        let by_policy = matches!(steps, Steps::Policy);
        let named = match first {
            Step::Node(_) if by_policy => Named::PolicyNodes,
            Step::Node(_) => Named::Nodes,
            Step::List(_) if by_policy => Named::PolicyLists,
            Step::List(_) => Named::Lists,
            Step::Triangle { .. } if steps.work(first, &self.layout).second.is_none() => Named::Planes,
            Step::Triangle { .. } => Named::Edges,
            Step::Read { store, .. } | Step::Write { store, .. } | Step::Update { store, .. } => match store {
                Store::ModeWord => Named::ModeWords,
                Store::PixelCounter => Named::PixelCounters,
                Store::OccluderId => Named::OccluderIds,
            },
        };
        // Arrays begin at multiples of a page: where their elements lie in lines repeats after as many as a line has bytes.
        let lines = |step: Step| {
            let work = steps.work(step, &self.layout);
            let of = |element| self.layout.lines(element).1;
            [of(&work.first), work.second.as_ref().map_or(0, of)]
        };
        let period = self.machine.line_bytes.get();
        let is_like_first = |index| step(index).is_none_or(|step| lines(step) == lines(first));
        let uniform = first.entry().is_none() && (0..period).all(is_like_first);
        let work = steps.work(first, &self.layout);
        // There and back; of a list entry the way on is that of its triangle.
        let way = if work.kind == Kind::Intersection { 2 } else { 0 };
        Tag { stay: self.held(&work) + way, uniform, lines: lines(first), named }
    }

    /// Cycles that a step holds who performs it at least.
    fn held(&self, work: &Work) -> u64 {
        let unit = &self.kinds[work.kind as usize];
        // An access to a line that is about to come has its data a cycle later, however long a hit takes.
        let access = match unit.cache.contents {
            Contents::Tags => 1,
            Contents::Ideal => unit.cache.latency.get(),
        };
        let division = if work.divides { self.machine.division.latency.get() } else { 0 };
        work.operations() * (access + unit.latency) + division
    }

    /// A frame begins.
    pub fn begin_frame(&mut self, info: &FrameInfo) {
        self.layout.begin_frame(info);
        self.lines.forget_from(self.layout.dynamic_part());
        self.named.iter_mut().zip(self.statics).for_each(|(set, first)| lines::forget_from(set, first));
    }

    /// Counts packed steps; cycles that a ray takes for them at least.
    pub fn add(&mut self, words: &[u32], steps: Steps) -> u64 {
        let mut stay = 0;
        for &word in words {
            let tag = (word >> INDEX_BITS) as usize;
            let Tag { stay: of_step, uniform, named, .. } = self.tags[steps as usize][tag];
            stay += of_step;
            self.counts[steps as usize][tag] += 1;
            if !(uniform && self.named[named as usize].contains((word & Step::MAX_INDEX) as usize)) {
                self.look_at(word, steps);
            }
        }
        stay
    }

    /// Counts what the tag of a step does not tell.
    #[inline(never)]
    fn look_at(&mut self, word: u32, steps: Steps) {
        let Some(step) = Step::unpack(word) else { return };
        if step.entry().is_some() && !self.stores_count {
            // Learned bits may be read and taken over beside it.
            self.left_out += 3;
            return;
        }
        let Tag { uniform, named, .. } = self.tags[steps as usize][(word >> INDEX_BITS) as usize];
        let work = steps.work(step, &self.layout);
        if !uniform {
            for element in work.elements() {
                let lines = self.layout.lines(&element).1;
                self.count(work.kind, &element, 1, lines);
            }
        }
        let (set, index) = (&mut self.named[named as usize], (word & Step::MAX_INDEX) as usize);
        if index >= set.len() {
            // Twice as much: growing copies.
            set.grow((index + 1).next_power_of_two());
        }
        if !set.put(index) {
            for element in work.elements() {
                let (first, count) = self.layout.lines(&element);
                self.lines.touch(&self.machine, work.kind, element.class, first, count);
            }
        }
    }

    /// Counts `times` accesses to elements like `element`, each of which lies in so many lines.
    fn count(&mut self, kind: Kind, element: &Element, times: u64, lines: u64) {
        let work = &mut self.work[kind as usize];
        (work.accesses, work.all_accesses) = (work.accesses + times * lines, work.all_accesses + times * lines);
        self.requested[kind as usize][element.class as usize] += Bytes(times * element.bytes);
        self.writes += u64::from(element.write) * times * lines;
    }

    /// A shadow-cache unit decides, without data.
    pub fn decide(&mut self) {
        let work = &mut self.work[Kind::ShadowCache as usize];
        (work.operations, work.all_operations) = (work.operations + 1, work.all_operations + 1);
    }

    /// All steps of the phase are known: what their tags tell is worked out.
    pub fn settle(&mut self) {
        for steps in Steps::ALL {
            for (tag, times) in std::mem::take(&mut self.counts[steps as usize]).into_iter().enumerate() {
                let Some(step) = Step::unpack((tag as u32) << INDEX_BITS).filter(|_| times > 0) else { continue };
                if step.entry().is_some() && !self.stores_count {
                    continue;
                }
                let work = steps.work(step, &self.layout);
                let (operations, held) = (times * work.operations(), times * self.held(&work));
                let counted = &mut self.work[work.kind as usize];
                counted.operations += operations;
                counted.all_operations += operations;
                if matches!(work.kind, Kind::List | Kind::Intersection) {
                    counted.held += held;
                }
                self.divisions += if work.divides { times } else { 0 };
                let Tag { uniform, lines, .. } = self.tags[steps as usize][tag];
                if uniform {
                    work.elements()
                        .zip(lines)
                        .for_each(|(element, lines)| self.count(work.kind, &element, times, lines));
                }
            }
        }
    }

    /// Another phase begins.
    pub fn end_phase(&mut self) {
        self.divisions = 0;
        for work in &mut self.work {
            (work.operations, work.accesses, work.held) = (0, 0, 0);
        }
        self.lines.end_phase();
    }
}
