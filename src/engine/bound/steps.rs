//! The work of steps. Steps with the same tag differ only in their element: they are counted, and their work is
//! computed once per phase. Only an element's first use touches lines.

use fixedbitset::FixedBitSet;

use super::lines::{self, Lines};
use super::sums::Sums;
use crate::engine::work::{Holder, Work, stores_as_recorded};
use crate::machine::MachineSpec;
use crate::machine::kinds::{Kind, KindSpec};
use crate::machine::layout::{Element, Layout};
use crate::memory::tags::Contents;
use crate::quantity::Bytes;
use crate::stream::{FrameInfo, Header, RayKind, Step};

/// The origin of steps.
#[derive(Clone, Copy, Debug)]
pub(super) enum Steps {
    /// Steps of a path that needs the position of the hit.
    Path,
    /// Steps of a shadow ray's path.
    ShadowPath,
    /// Steps of a policy.
    Policy,
}

impl Steps {
    const ALL: [Self; 3] = [Self::Path, Self::ShadowPath, Self::Policy];

    /// The group of steps that share a set of touched elements.
    #[inline]
    fn group(self) -> usize {
        match self {
            Self::Path | Self::ShadowPath => 0,
            Self::Policy => 1,
        }
    }

    /// The work of a step.
    fn work(self, step: Step, layout: &Layout) -> Work {
        let (holder, ray) = match self {
            Self::Path => (Holder::Traversal, RayKind::Primary),
            Self::ShadowPath => (Holder::Traversal, RayKind::Shadow),
            Self::Policy => (Holder::ShadowCache, RayKind::Primary),
        };
        Work::of(step, holder, ray, layout)
    }
}

/// The group of entries, after the groups of [`Steps::group`].
const ENTRIES: usize = 2;

/// The largest line in bytes: the maximum number of elements after which positions in lines repeat.
const PERIOD: usize = 128;

/// The properties of all steps with a tag that every step needs.
#[derive(Clone, Copy, Debug)]
struct Tag {
    /// Minimum cycles of a ray in the step.
    stay: u64,
    /// Whether the number of accessed lines depends on the element's position.
    by_place: bool,
}

/// The other properties of all steps with a tag.
#[derive(Clone, Copy, Debug)]
struct Detail {
    /// The first element of the dynamic part.
    dynamic: u32,
    lines: LinesOf,
}

/// Number of lines of the array elements of a step.
#[derive(Clone, Copy, Debug)]
enum LinesOf {
    /// The same number for each element.
    All(u8),
    /// By the element's number in the static or dynamic part of its array.
    ByPlace([u8; PERIOD]),
    /// The tag does not determine it.
    Unknown,
}

/// The properties of a tag without steps, or whose steps are left out: each step must be examined.
const NOTHING: (Tag, Detail) =
    (Tag { stay: 0, by_place: false }, Detail { dynamic: u32::MAX, lines: LinesOf::Unknown });

impl Detail {
    /// Number of lines of element `index`, if it depends on the position.
    fn lines_at(&self, index: u32) -> u64 {
        let place = index - if index < self.dynamic { 0 } else { self.dynamic };
        if let LinesOf::ByPlace(lines) = &self.lines { lines[place as usize % PERIOD].into() } else { 0 }
    }
}

/// Work of a kind of units in a phase: operations, accesses to lines, and the minimum cycles for which rays hold
/// contexts.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct KindWork {
    pub operations: u64,
    pub accesses: u64,
    pub held: u64,
}

/// Number of steps of a phase with a tag, and of the lines that they access.
#[derive(Clone, Copy, Debug, Default)]
struct Count {
    steps: u64,
    lines: u64,
}

/// Counts steps.
#[derive(Clone, Debug)]
pub(super) struct StepWork {
    machine: MachineSpec,
    pub kinds: [KindSpec; Kind::ALL.len()],
    pub layout: Layout,
    pub lines: Lines,
    tags: [[Tag; Step::TAGS]; Steps::ALL.len()],
    details: [[Detail; Step::TAGS]; Steps::ALL.len()],
    counts: [[Count; Step::TAGS]; Steps::ALL.len()],
    /// Elements whose lines were touched, by the tag of the step: of paths, of policies, and entries. Each step of an
    /// entry is examined.
    touched: [[FixedBitSet; Step::TAGS]; ENTRIES + 1],
    pub work: [KindWork; Kind::ALL.len()],
    /// Divisions of the phase.
    pub divisions: u64,
    /// Whether store steps are performed as recorded. If not, the lower bound omits them and the upper bound includes
    /// them.
    pub stores_count: bool,
    /// Sums of the frame.
    pub sums: Sums,
}

impl StepWork {
    /// The counters of a stream before it begins.
    pub(super) fn new(machine: &MachineSpec, header: &Header) -> Self {
        let kinds = Kind::ALL.map(|kind| kind.spec(machine));
        let mut work = Self {
            layout: Layout::new(header, machine),
            lines: Lines::new(machine, &kinds),
            tags: [[NOTHING.0; Step::TAGS]; Steps::ALL.len()],
            details: [[NOTHING.1; Step::TAGS]; Steps::ALL.len()],
            counts: Default::default(),
            touched: Default::default(),
            work: Default::default(),
            divisions: 0,
            stores_count: stores_as_recorded(machine),
            sums: Sums::default(),
            kinds,
            machine: machine.clone(),
        };
        let tags = Steps::ALL.map(|steps| std::array::from_fn(|tag| work.tag(steps, tag, header)));
        work.tags = tags.map(|tags| tags.map(|(tag, _)| tag));
        work.details = tags.map(|tags| tags.map(|(_, detail)| detail));
        work
    }

    fn tag(&self, steps: Steps, tag: usize, header: &Header) -> (Tag, Detail) {
        let is_there = |(store, _)| self.stores_count && header.stores.of(store) > 0;
        let first = Step::of_tag(tag).filter(|step| step.entry().is_none_or(is_there));
        let Some(first) = first else { return NOTHING };
        let dynamic = match first {
            Step::Node(_) => header.static_nodes,
            Step::List(_) => header.static_list_entries,
            Step::Triangle { .. } => header.static_slots,
            // Entries may lie in records of the dynamic part.
            Step::Read { .. } | Step::Write { .. } | Step::Update { .. } => 0,
        };
        let work = steps.work(first, &self.layout);
        // Arrays begin at page boundaries: the positions of elements in lines repeat after as many elements as a line
        // has bytes.
        let lines = |place: usize| {
            let of = |element: Element| self.layout.lines(&self.layout.places_on(&element, first, place as u64)).1;
            work.elements().map(of).sum::<u64>() as u8
        };
        let lines: [u8; PERIOD] = std::array::from_fn(lines);
        let lines = match first.entry() {
            Some(_) => LinesOf::Unknown,
            None if lines.iter().all(|&it| it == lines[0]) => LinesOf::All(lines[0]),
            None => LinesOf::ByPlace(lines),
        };
        // To the unit and back. A list entry's way on is counted with its triangle.
        let way = if work.kind == Kind::Intersection { 2 } else { 0 };
        let by_place = matches!(lines, LinesOf::ByPlace(_));
        (Tag { stay: self.held(&work) + way, by_place }, Detail { dynamic, lines })
    }

    /// Minimum cycles of a step at its unit, including a division.
    fn held(&self, work: &Work) -> u64 {
        let unit = &self.kinds[work.kind as usize];
        // A line that is about to come delivers its data one cycle after the access, also with a longer hit latency.
        let access = match unit.cache.contents {
            Contents::Tags => 1,
            Contents::Ideal => unit.cache.latency.get(),
        };
        let division = if work.divides { self.machine.division.latency.get() } else { 0 };
        work.operations() * (access + unit.latency) + division
    }

    /// A frame begins.
    pub(super) fn begin_frame(&mut self, info: &FrameInfo) {
        self.layout.begin_frame(info);
        self.lines.forget_from(self.layout.dynamic_part());
        for (steps, group) in
            [(Steps::Path, Steps::Path.group()), (Steps::Policy, Steps::Policy.group()), (Steps::Policy, ENTRIES)]
        {
            for (set, detail) in self.touched[group].iter_mut().zip(&self.details[steps as usize]) {
                lines::forget_from(set, detail.dynamic as usize);
            }
        }
    }

    /// Counts packed steps; returns the minimum cycles of a ray for them.
    pub(super) fn add(&mut self, words: &[u32], steps: Steps) -> u64 {
        let mut stay = 0;
        for &word in words {
            let (at, index) = (Step::tag(word) as usize, word & Step::MAX_INDEX);
            let tag = &self.tags[steps as usize][at];
            stay += tag.stay;
            self.counts[steps as usize][at].steps += 1;
            if tag.by_place {
                self.counts[steps as usize][at].lines += self.details[steps as usize][at].lines_at(index);
            }
            if !self.touched[steps.group()][at].contains(index as usize) {
                self.look_at(word, steps);
            }
        }
        stay
    }

    /// Counts what the tag of a step does not determine.
    #[inline(never)]
    fn look_at(&mut self, word: u32, steps: Steps) {
        let Some(step) = Step::unpack(word) else { return };
        if step.entry().is_some() && !self.stores_count {
            // The machine may also read and fold learned bits.
            self.sums.left_out += 3;
            return;
        }
        let Detail { lines, .. } = self.details[steps as usize][Step::tag(word) as usize];
        let work = steps.work(step, &self.layout);
        if let LinesOf::Unknown = lines {
            let lines = work.elements().map(|element| self.layout.lines(&element).1).sum::<u64>();
            self.counts[steps as usize][Step::tag(word) as usize].lines += lines;
            // The size of an entry can depend on its position.
            let requested = &mut self.sums.requested[work.kind as usize];
            work.elements().for_each(|element| requested[element.class as usize] += Bytes(element.bytes));
        }
        let group = if let LinesOf::Unknown = lines { ENTRIES } else { steps.group() };
        let (set, index) = (&mut self.touched[group][Step::tag(word) as usize], (word & Step::MAX_INDEX) as usize);
        if index >= set.len() {
            // Doubles the size: growing copies the set.
            set.grow((index + 1).next_power_of_two());
        }
        if !set.put(index) {
            for element in work.elements() {
                let (first, count) = self.layout.lines(&element);
                let lines = first.0..first.0 + count;
                self.lines.touch(&self.machine, (work.kind, element.class), lines, &mut self.sums);
            }
        }
    }

    /// A shadow-cache unit makes a decision, without data.
    pub(super) fn decide(&mut self) {
        self.work[Kind::ShadowCache as usize].operations += 1;
        self.sums.operations[Kind::ShadowCache as usize] += 1;
    }

    /// Computes the work of all steps of the phase from the counts per tag.
    pub(super) fn settle(&mut self) {
        for steps in Steps::ALL {
            let counts = std::mem::take(&mut self.counts[steps as usize]);
            for (tag, Count { steps: times, lines }) in counts.into_iter().enumerate() {
                let Some(step) = Step::of_tag(tag).filter(|_| times > 0) else { continue };
                if step.entry().is_some() && !self.stores_count {
                    continue;
                }
                let work = steps.work(step, &self.layout);
                let kind = work.kind as usize;
                let each = &self.details[steps as usize][tag].lines;
                let lines = if let LinesOf::All(each) = each { times * u64::from(*each) } else { lines };
                let (operations, held) = (times * work.operations(), times * self.held(&work));
                let counted = &mut self.work[kind];
                counted.operations += operations;
                counted.accesses += lines;
                if matches!(work.kind, Kind::List | Kind::Intersection) {
                    counted.held += held;
                }
                self.divisions += if work.divides { times } else { 0 };
                self.sums.operations[kind] += operations;
                self.sums.accesses[kind] += lines;
                self.sums.writes += u64::from(work.first.write) * lines;
                if !matches!(each, LinesOf::Unknown) {
                    let requested = &mut self.sums.requested[kind];
                    work.elements().for_each(|it| requested[it.class as usize] += Bytes(times * it.bytes));
                }
            }
        }
    }

    /// Another phase begins.
    pub(super) fn end_phase(&mut self) {
        self.divisions = 0;
        self.work = Default::default();
        self.lines.end_phase();
    }
}
