//! What steps ask for. Steps with one tag differ only in which element they name: how many there are is counted, and
//! what they ask for is worked out once a phase. Only an element that was not named yet touches lines.

use fixedbitset::FixedBitSet;

use super::lines::{self, Lines};
use super::sums::Sums;
use crate::engine::work::{Holder, Work, stores_as_recorded};
use crate::machine::MachineSpec;
use crate::machine::kinds::{Kind, KindSpec};
use crate::machine::layout::{Element, Layout};
use crate::memory::tags::Contents;
use crate::quantity::Bytes;
use crate::stream::{FrameInfo, Header, RayKind, Step, Store};

/// Whose steps.
#[derive(Clone, Copy, Debug)]
pub(super) enum Steps {
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

/// The largest line, and so the most elements after which their places in lines repeat.
const PERIOD: usize = 128;

/// What each step with a tag asks for.
#[derive(Clone, Copy, Debug)]
struct Tag {
    /// Cycles that the ray stays at least.
    stay: u64,
    named: Named,
    /// The first element of the dynamic part.
    dynamic: u32,
    lines: LinesOf,
}

/// How many lines the elements of a step lie in that names an array's element.
#[derive(Clone, Copy, Debug)]
enum LinesOf {
    /// As many, whichever it names.
    All(u8),
    /// By the element's number from the beginning of its array's static or dynamic part on.
    ByPlace([u8; PERIOD]),
    /// The tag does not tell it.
    Unknown,
}

/// A tag that is of no step, or of steps that are left out: nothing is known without looking at the step.
const NOTHING: Tag = Tag { stay: 0, named: Named::Nodes, dynamic: u32::MAX, lines: LinesOf::Unknown };

/// What is counted of a kind of units in a phase: operations, accesses to lines, cycles that rays hold contexts at
/// least.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct KindWork {
    pub operations: u64,
    pub accesses: u64,
    pub held: u64,
}

/// Steps of a phase with a tag, and the lines that they access.
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
    counts: [[Count; Step::TAGS]; Steps::ALL.len()],
    named: [FixedBitSet; NAMED],
    pub work: [KindWork; Kind::ALL.len()],
    /// Divisions of the phase.
    pub divisions: u64,
    /// Whether steps of stores are performed as recorded; else they are left out of what must be done, and may be done.
    pub stores_count: bool,
    /// Of the frame.
    pub sums: Sums,
}

impl StepWork {
    /// Of a stream that has not begun.
    pub(super) fn new(machine: &MachineSpec, header: &Header) -> Self {
        let kinds = Kind::ALL.map(|kind| kind.spec(machine));
        let mut work = Self {
            layout: Layout::new(header, machine),
            lines: Lines::new(machine, &kinds),
            tags: [[NOTHING; Step::TAGS]; Steps::ALL.len()],
            counts: Default::default(),
            named: Default::default(),
            work: Default::default(),
            divisions: 0,
            stores_count: stores_as_recorded(machine),
            sums: Sums::default(),
            kinds,
            machine: machine.clone(),
        };
        work.tags = Steps::ALL.map(|steps| std::array::from_fn(|tag| work.tag(steps, tag, header)));
        work
    }

    fn tag(&self, steps: Steps, tag: usize, header: &Header) -> Tag {
        let is_there = |(store, _)| self.stores_count && header.stores.of(store) > 0;
        let first = Step::of_tag(tag).filter(|step| step.entry().is_none_or(is_there));
        let Some(first) = first else { return NOTHING };
        let by_policy = matches!(steps, Steps::Policy);
        let (named, dynamic) = match first {
            Step::Node(_) if by_policy => (Named::PolicyNodes, header.static_nodes),
            Step::Node(_) => (Named::Nodes, header.static_nodes),
            Step::List(_) if by_policy => (Named::PolicyLists, header.static_list_entries),
            Step::List(_) => (Named::Lists, header.static_list_entries),
            Step::Triangle { .. } if steps.work(first, &self.layout).second.is_none() => {
                (Named::Planes, header.static_slots)
            }
            Step::Triangle { .. } => (Named::Edges, header.static_slots),
            // Entries may lie in records of the dynamic part.
            Step::Read { store, .. } | Step::Write { store, .. } | Step::Update { store, .. } => match store {
                Store::ModeWord => (Named::ModeWords, 0),
                Store::PixelCounter => (Named::PixelCounters, 0),
                Store::OccluderId => (Named::OccluderIds, 0),
            },
        };
        let work = steps.work(first, &self.layout);
        // Arrays begin at multiples of a page: where their elements lie in lines repeats after as many as a line has
        // bytes.
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
        // There and back; of a list entry the way on is that of its triangle.
        let way = if work.kind == Kind::Intersection { 2 } else { 0 };
        Tag { stay: self.held(&work) + way, named, dynamic, lines }
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
    pub(super) fn begin_frame(&mut self, info: &FrameInfo) {
        self.layout.begin_frame(info);
        self.lines.forget_from(self.layout.dynamic_part());
        for tag in self.tags.as_flattened() {
            lines::forget_from(&mut self.named[tag.named as usize], tag.dynamic as usize);
        }
    }

    /// Counts packed steps; cycles that a ray takes for them at least.
    pub(super) fn add(&mut self, words: &[u32], steps: Steps) -> u64 {
        let mut stay = 0;
        for &word in words {
            let (at, index) = (Step::tag(word) as usize, word & Step::MAX_INDEX);
            let (tag, count) = (&self.tags[steps as usize][at], &mut self.counts[steps as usize][at]);
            stay += tag.stay;
            count.steps += 1;
            match &tag.lines {
                LinesOf::All(_) => {}
                LinesOf::ByPlace(lines) => {
                    let place = index - if index < tag.dynamic { 0 } else { tag.dynamic };
                    count.lines += u64::from(lines[place as usize % PERIOD]);
                }
                LinesOf::Unknown => {
                    self.look_at(word, steps);
                    continue;
                }
            }
            if !self.named[tag.named as usize].contains(index as usize) {
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
            self.sums.left_out += 3;
            return;
        }
        let Tag { named, lines, .. } = self.tags[steps as usize][Step::tag(word) as usize];
        let work = steps.work(step, &self.layout);
        if let LinesOf::Unknown = lines {
            let lines = work.elements().map(|element| self.layout.lines(&element).1).sum::<u64>();
            self.counts[steps as usize][Step::tag(word) as usize].lines += lines;
            // An entry's size may hang on where it lies.
            let requested = &mut self.sums.requested[work.kind as usize];
            work.elements().for_each(|element| requested[element.class as usize] += Bytes(element.bytes));
        }
        let (set, index) = (&mut self.named[named as usize], (word & Step::MAX_INDEX) as usize);
        if index >= set.len() {
            // Twice as much: growing copies.
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

    /// A shadow-cache unit decides, without data.
    pub(super) fn decide(&mut self) {
        self.work[Kind::ShadowCache as usize].operations += 1;
        self.sums.operations[Kind::ShadowCache as usize] += 1;
    }

    /// All steps of the phase are known: what their tags tell is worked out.
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
                let each = &self.tags[steps as usize][tag].lines;
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
