//! Covariates: what is known of a part of a stream without replaying it, and which of them explain each figure.

use std::ops::AddAssign;

use super::figures::{Figure, MemoryLevel};
use crate::machine::MachineSpec;
use crate::machine::kinds::Kind;
use crate::stats::{CacheCounts, DramCounts, TrafficClass};

const KINDS: usize = Kind::ALL.len();
const CLASSES: usize = TrafficClass::ALL.len();
const CACHED: usize = TrafficClass::CACHED;

/// Columns of [`Covariates::columns`].
pub(crate) const COLUMNS: usize = KINDS + 3 + CACHED + CLASSES + KINDS + 2;

/// The column of all operations; columns of each kind of units but the first follow.
pub(crate) const OPERATIONS: usize = 0;
/// The column of all lines between L1s and L2.
const MOVED: usize = KINDS;
/// The column of all lines between L2 and DRAM.
const DRAM: usize = MOVED + 1;
/// The column of the minimum cycles of the busiest resource: a kind of units, an owner unit, or the DRAM's bus.
const BUSIEST: usize = DRAM + 1;
/// First columns of lines by class, between L1s and L2, and between L2 and DRAM.
const MOVED_OF_CLASS: usize = BUSIEST + 1;
const DRAM_OF_CLASS: usize = MOVED_OF_CLASS + CACHED;
/// First column of misses of the L1s of each kind of units.
const MISSED: usize = DRAM_OF_CLASS + CLASSES;
/// The columns of the busiest owner unit and of the busiest bank of an L2.
const OWNER: usize = MISSED + KINDS;
const BANK: usize = OWNER + 1;

/// Covariates of a part of a stream.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Covariates {
    /// Operations of each kind of units, times the cycles between operations.
    pub operations: [u64; KINDS],
    /// Lines of each class that tags move between L1s and L2.
    pub moved: [u64; CACHED],
    /// Lines of each class that tags move between L2 and DRAM.
    pub dram: [u64; CLASSES],
    /// Misses of the L1s' tags of each kind of units.
    pub missed: [u64; KINDS],
    /// Cycles of the busiest owner unit for operations on entries of the stores: the maximum of each piece, summed over
    /// pieces.
    pub owner: u64,
    /// Requests to the busiest bank of an L2: the maximum of each piece, summed over pieces.
    pub bank: u64,
}

impl AddAssign for Covariates {
    fn add_assign(&mut self, other: Self) {
        let add = |sums: &mut [u64], others: &[u64]| sums.iter_mut().zip(others).for_each(|(sum, other)| *sum += other);
        add(&mut self.operations, &other.operations);
        add(&mut self.moved, &other.moved);
        add(&mut self.dram, &other.dram);
        add(&mut self.missed, &other.missed);
        self.owner += other.owner;
        self.bank += other.bank;
    }
}

/// Covariates as columns of a regression.
pub(crate) type Columns = [f64; COLUMNS];

/// The capacity of a machine in a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Capacity {
    /// Operations that all units of each kind together can begin.
    operations: [f64; KINDS],
    /// Lines to or from the DRAM; `None` if unlimited.
    lines: Option<f64>,
    /// Cycles that a ray in a slot waits for an operation, over the unit's interval, and for a line that the L1 misses;
    /// for each kind of units in [`PATH`].
    stays: [f64; PATH.len()],
    fetches: [f64; PATH.len()],
}

/// Kinds of units that rays in slots of traversal units go to, and the class that they read.
const PATH: [(Kind, TrafficClass); 3] = [
    (Kind::Traversal, TrafficClass::Node),
    (Kind::List, TrafficClass::List),
    (Kind::Intersection, TrafficClass::Triangle),
];

impl Capacity {
    /// The capacity of `machine`.
    pub(crate) fn new(machine: &MachineSpec) -> Self {
        let bytes = machine.dram.peak_bytes_per_cycle(machine.clock_mhz.get());
        let lines = bytes.map(|bytes| bytes / machine.line_bytes.get() as f64);
        let caches = machine.l2.caches();
        let stay = |kind: Kind| {
            let spec = kind.spec(machine);
            (spec.latency + spec.cache.latency.get()) as f64 / spec.interval as f64
        };
        let fetch = |class| caches[machine.l2.home(class)].1.latency.get() as f64;
        Self {
            operations: Kind::ALL.map(|kind| (kind.spec(machine).count * kind.spec(machine).width) as f64),
            lines,
            stays: PATH.map(|(kind, _)| stay(kind)),
            fetches: PATH.map(|(_, class)| fetch(class)),
        }
    }

    /// The capacity of the units, with unlimited DRAM.
    pub(crate) fn of_units(machine: &MachineSpec) -> Self {
        Self { lines: None, ..Self::new(machine) }
    }

    /// Rays in traversal units at once, by Little's law (Little 1961): the sum of their waits for operations and for
    /// missed lines, over the minimum cycles of the busiest resource. `None` if nothing is done.
    pub(crate) fn in_flight(&self, covariates: &Covariates) -> Option<f64> {
        let waits = PATH.iter().zip(self.stays.iter().zip(&self.fetches)).map(|((kind, _), (stay, fetch))| {
            let kind = *kind as usize;
            covariates.operations[kind] as f64 * stay + covariates.missed[kind] as f64 * fetch
        });
        let busiest = self.busiest(covariates.operations, covariates.owner as f64, 0.0);
        (busiest > 0.0).then(|| waits.sum::<f64>() / busiest)
    }

    fn busiest(&self, operations: [u64; KINDS], owner: f64, dram: f64) -> f64 {
        let units =
            operations.into_iter().zip(self.operations).map(|(operations, at_once)| operations as f64 / at_once);
        units.chain(self.lines.map(|lines| dram / lines)).fold(owner, f64::max)
    }

    /// The columns with other operations.
    pub(crate) fn with_operations(&self, mut columns: Columns, operations: [u64; KINDS]) -> Columns {
        columns[OPERATIONS] = operations.iter().sum::<u64>() as f64;
        columns[OPERATIONS + 1..KINDS].iter_mut().zip(&operations[1..]).for_each(|(column, &it)| *column = it as f64);
        columns[BUSIEST] = self.busiest(operations, columns[OWNER], columns[DRAM]);
        columns
    }
}

impl Covariates {
    /// The covariates as columns.
    pub(crate) fn columns(&self, capacity: &Capacity) -> Columns {
        let mut columns = [0.0; COLUMNS];
        columns[MOVED] = self.moved.iter().sum::<u64>() as f64;
        columns[DRAM] = self.dram.iter().sum::<u64>() as f64;
        columns[MOVED_OF_CLASS..]
            .iter_mut()
            .zip(self.moved.iter().chain(&self.dram).chain(&self.missed))
            .for_each(|(column, &lines)| *column = lines as f64);
        (columns[OWNER], columns[BANK]) = (self.owner as f64, self.bank as f64);
        capacity.with_operations(columns, self.operations)
    }
}

/// Which activity is counted for a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Span {
    /// Between the window's marks, by any ray: for figures that depend on the number of rays in flight.
    Inside,
    /// Requests of the window's own rays, at any time.
    Own,
    /// The whole replay, of lead-in, window and tail: for what rays request whatever else is in flight. Misses of
    /// caches do not qualify: at both ends of the replay, fewer rays are in flight (living room, `Hybrid()`,
    /// `tni_engine`: 6 % too few bytes of mode words from the DRAM).
    Group,
}

impl Span {
    /// All spans.
    pub(crate) const ALL: [Self; 3] = [Self::Inside, Self::Own, Self::Group];
}

/// The explanation of a figure by covariates.
#[derive(Clone, Debug)]
pub(crate) struct Explanation {
    /// The explaining columns, best first: few windows allow only few columns.
    pub columns: Vec<usize>,
    /// The column of the lines that the figure counts in bytes: only the difference from it is estimated.
    pub lines: Option<usize>,
    /// Which activity is counted.
    pub span: Span,
}

/// The explanation of `figure`.
pub(crate) fn explanation(figure: &Figure) -> Explanation {
    const MISSES: usize = CacheCounts::place("misses");
    const REFRESHES: usize = DramCounts::place("refreshes");
    let operations_of = |kind: Kind| OPERATIONS + kind as usize;
    let by = |first: &[usize], lines: Option<usize>, span: Span| {
        let columns = first.iter().copied().chain(OPERATIONS..KINDS).collect();
        Explanation { columns, lines, span }
    };
    let moved = |class: TrafficClass| MOVED_OF_CLASS + class as usize;
    let dram = |class: TrafficClass| DRAM_OF_CLASS + class as usize;
    match figure {
        Figure::L2Bytes => {
            let (tests, words) = (operations_of(Kind::Intersection), moved(TrafficClass::ModeWord));
            by(&[MOVED, moved(TrafficClass::Triangle), BANK, tests, OWNER, words, DRAM], Some(MOVED), Span::Own)
        }
        Figure::DramBytes => {
            let triangle = TrafficClass::Triangle;
            by(&[DRAM, dram(triangle), OWNER, moved(triangle), BANK], Some(DRAM), Span::Own)
        }
        Figure::Bytes(MemoryLevel::L2(_), class) => by(&[moved(*class)], Some(moved(*class)), Span::Own),
        Figure::Bytes(MemoryLevel::Dram, class) => by(&[dram(*class)], Some(dram(*class)), Span::Own),
        Figure::Bytes(MemoryLevel::L1(_) | MemoryLevel::Fifos | MemoryLevel::RayBuffer, _) => {
            by(&[], None, Span::Group)
        }
        Figure::Cache(MemoryLevel::L2(_), class, MISSES) => by(&[dram(*class)], None, Span::Own),
        Figure::Cache(_, class, _) | Figure::L1(_, class, _) => by(&[moved(*class), dram(*class)], None, Span::Inside),
        Figure::Dram(place) if *place != REFRESHES => by(&[DRAM], None, Span::Inside),
        Figure::Cycles
        | Figure::Rays
        | Figure::Unit(..)
        | Figure::Operations(_)
        | Figure::Queue(..)
        | Figure::Latency(..)
        | Figure::Dram(_) => {
            // Where all rays wait for few shadow-cache units, the misses of these units and the share of the busiest
            // one matter most. These orders, here and above, left the smallest residuals on kitchen, robot, staircase
            // and living room (`tni_engine`, `desktop`, robot on `small`).
            let missed = |kind| MISSED + kind as usize;
            let (words, tests) = (Kind::ShadowCache, Kind::Intersection);
            let few = [BUSIEST, missed(words), operations_of(tests), OPERATIONS, BANK, operations_of(words)];
            let columns =
                few.into_iter().chain([OWNER, MOVED, missed(Kind::Traversal), DRAM, operations_of(Kind::List)]);
            Explanation { columns: columns.collect(), lines: None, span: Span::Inside }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn covariates(operations: [u64; KINDS], owner: u64) -> Covariates {
        Covariates { operations, owner, ..Covariates::default() }
    }

    #[test]
    fn the_busiest_is_a_kind_an_owner_or_the_bus() {
        let capacity =
            Capacity { operations: [4.0, 1.0, 2.0, 4.0], lines: Some(0.5), ..Capacity::new(&MachineSpec::default()) };
        let busiest = |covariates: Covariates| covariates.columns(&capacity)[BUSIEST];
        assert_eq!(busiest(covariates([400, 0, 100, 100], 25)), 100.0, "traversal units");
        assert_eq!(busiest(covariates([400, 0, 100, 200], 140)), 140.0, "one shadow-cache unit has most of what 4 do");
        let read = Covariates { dram: [0, 0, 60, 0, 20, 0, 0, 0, 0, 0], ..covariates([400, 0, 100, 200], 140) };
        assert_eq!(busiest(read), 160.0, "the bus");
    }

    /// Little 1961: 100 operations of 9 cycles each, and ten lines of 20, in 200 cycles.
    #[test]
    fn as_many_rays_are_in_flight_as_the_busiest_lets_through() {
        let capacity =
            Capacity { operations: [4.0; KINDS], lines: None, stays: [9.0, 3.0, 5.0], fetches: [20.0, 7.0, 7.0] };
        let one = Covariates { missed: [10, 0, 0, 99], ..covariates([100, 0, 0, 99], 200) };
        assert_eq!(capacity.in_flight(&one), Some((900.0 + 200.0) / 200.0));
        assert_eq!(
            capacity.in_flight(&covariates([100, 0, 0, 0], 0)),
            Some(36.0),
            "all four units are busy for 25 cycles"
        );
        assert_eq!(capacity.in_flight(&Covariates::default()), None);
    }
}
