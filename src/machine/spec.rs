//! The spec of a whole machine: composes the specs of its parts and checks them together.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::dispatcher::DispatcherSpec;
use super::division::DivisionSpec;
use super::energy::EnergySpec;
use super::footprint::Footprint;
use super::intersection::IntersectionSpec;
use super::list::ListSpec;
use super::shadow_cache::{FrameEnd, Place, ShadowCacheSpec};
use super::stores::{StoreLayout, check_tag};
use super::traffic::TrafficSpec;
use super::traversal::TraversalSpec;
use super::word_traffic::{LatchedCopy, SilentUpdates};
use super::writes::WritePolicy;
use crate::memory::dram::spec::DramSpec;
use crate::memory::l2::L2Spec;
use crate::memory::tags::Contents;
use crate::ranged::{PowerOfTwoSize, Within};
use crate::stats::TrafficClass;
use crate::stream::{Header, Step};

/// A machine: the accelerator and its memory.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MachineSpec {
    /// The machine's name in reports.
    pub name: String,
    /// The clock of all units and caches, in MHz.
    #[schemars(extend("unit" = "MHz"))]
    pub clock_mhz: Within<1, 10_000>,
    /// Line size of all caches, in bytes.
    pub line_bytes: PowerOfTwoSize<32, 128>,
    /// Number of cores. Each core has its own units and L2; the dispatcher and the DRAM serve all cores.
    pub cores: Within<1, 64>,
    /// The dispatcher.
    pub dispatcher: DispatcherSpec,
    /// The traversal units.
    pub traversal: TraversalSpec,
    /// The list units.
    pub list: ListSpec,
    /// The intersection units.
    pub intersection: IntersectionSpec,
    /// The division units.
    pub division: DivisionSpec,
    /// The shadow-cache units.
    pub shadow_cache: ShadowCacheSpec,
    /// The L2.
    pub l2: L2Spec,
    /// The DRAM.
    pub dram: DramSpec,
    /// DRAM traffic of the host and of a builder.
    pub traffic: TrafficSpec,
    /// Energy constants of operations, accesses and leakage.
    pub energy: EnergySpec,
}

impl Default for MachineSpec {
    fn default() -> Self {
        Self {
            name: "default".into(),
            clock_mhz: const { Within::literal(500) },
            line_bytes: const { PowerOfTwoSize::literal(64) },
            cores: const { Within::literal(1) },
            dispatcher: DispatcherSpec::default(),
            traversal: TraversalSpec::default(),
            list: ListSpec::default(),
            intersection: IntersectionSpec::default(),
            division: DivisionSpec::default(),
            shadow_cache: ShadowCacheSpec::default(),
            l2: L2Spec::default(),
            dram: DramSpec::default(),
            traffic: TrafficSpec::default(),
            energy: EnergySpec::default(),
        }
    }
}

/// Fields of a machine's spec that do not fit each other.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct SpecError(String);

impl SpecError {
    /// The error that says `what`.
    pub fn new(what: impl Into<String>) -> Self {
        Self(what.into())
    }
}

impl MachineSpec {
    /// The policy of writes to entries of stores in the L1s of intersection units.
    pub fn triangle_writes(&self) -> WritePolicy {
        match self.shadow_cache.place {
            Place::Triangle => self.shadow_cache.writes,
            Place::Own | Place::L2 | Place::Free => WritePolicy::Back,
        }
    }

    /// Entries of the pool: of all cores together.
    pub fn pool(&self) -> u64 {
        self.cores.get() * self.dispatcher.rays.get()
    }

    /// Approximate bytes of memory that the simulator needs for the machine.
    pub fn footprint(&self) -> u128 {
        self.parts().bytes()
    }

    /// Memory that the parts need.
    fn parts(&self) -> Footprint {
        let (pool, traversal, list) = (&self.dispatcher, &self.traversal, &self.list);
        let (tests, division, words) = (&self.intersection, &self.division, &self.shadow_cache);
        let units = Footprint::new(self.cores.get(), self.line_bytes.get())
            .add("dispatcher", 1, &[pool.rays.get(), pool.in_fifo.get(), pool.out_fifo.get()], None)
            .add("traversal", traversal.count.get(), &[traversal.rays.get()], Some(&traversal.cache))
            .add("list", list.count.get(), &[list.lists.get(), list.queue.get()], Some(&list.cache))
            .add("intersection", tests.count.get(), &[tests.tests.get(), tests.queue.get()], Some(&tests.cache))
            .add("division", division.count.get(), &[division.queue.get()], None)
            .add("shadow_cache", words.count.get(), &[words.contexts.get()], Some(&words.cache))
            .add("dram", self.dram.channels.get(), &[self.dram.queue.get()], None);
        self.l2.caches().into_iter().fold(units, |units, (name, cache)| units.add_banked(name, cache))
    }

    /// Checks the fields against each other.
    ///
    /// # Errors
    /// Fields that contradict each other; the error names them.
    pub fn check(&self) -> Result<(), SpecError> {
        let line = self.line_bytes.get();
        self.traversal
            .cache
            .check("traversal.cache", line)
            .and_then(|()| self.list.cache.check("list.cache", line))
            .and_then(|()| self.intersection.cache.check("intersection.cache", line))
            .and_then(|()| self.shadow_cache.cache.check("shadow_cache.cache", line))
            .and_then(|()| self.l2.check(line))
            .and_then(|()| self.parts().check())
            .and_then(|()| self.check_intervals())
            .and_then(|()| self.check_homes())
            .and_then(|()| self.check_writes())
            .and_then(|()| self.check_coherence())
            .and_then(|()| self.dram.check(line))
            .map_err(SpecError)
    }

    /// An interval is at most the latency, so that all cycles in which an operation occupies a unit lie within a run.
    fn check_intervals(&self) -> Result<(), String> {
        let units = [
            ("traversal", self.traversal.latency, self.traversal.interval),
            ("list", self.list.latency, self.list.interval),
            ("intersection", self.intersection.latency, self.intersection.interval),
            ("division", self.division.latency, self.division.interval),
            ("shadow_cache", self.shadow_cache.latency, self.shadow_cache.interval),
        ];
        let wrong = units.into_iter().find(|(_, latency, interval)| interval.get() > latency.get());
        wrong.map_or(Ok(()), |(unit, latency, interval)| {
            Err(format!("`{unit}.interval` is {interval}: up to `{unit}.latency`, which is {latency}, is allowed"))
        })
    }

    /// Classes that share lines must share a cache of the L2; otherwise two copies of such a line would exist.
    fn check_homes(&self) -> Result<(), String> {
        use TrafficClass::{ModeWord, PixelCounter, Triangle};
        let layout = self.shadow_cache.layout;
        let shared: &[_] = match layout {
            StoreLayout::Record => &[Triangle, ModeWord, PixelCounter],
            StoreLayout::Beside | StoreLayout::Tagged => &[ModeWord, PixelCounter],
            StoreLayout::Dense | StoreLayout::Packed => &[],
        };
        let apart = shared.windows(2).find(|pair| self.l2.home(pair[0]) != self.l2.home(pair[1]));
        apart.map_or(Ok(()), |pair| {
            let [one, other] = [pair[0], pair[1]].map(TrafficClass::name);
            Err(format!(
                "`l2` has different homes for `{one}` and `{other}`, which share lines with `shadow_cache.layout` \
                 {layout:?}: one home is allowed"
            ))
        })
    }

    /// An ideal cache sends nothing to the L2, so nothing can be written through it.
    fn check_writes(&self) -> Result<(), String> {
        let (field, cache) = match self.shadow_cache.place {
            Place::Own => ("shadow_cache.cache", &self.shadow_cache.cache),
            Place::Triangle => ("intersection.cache", &self.intersection.cache),
            Place::L2 | Place::Free => return Ok(()),
        };
        if self.shadow_cache.writes != WritePolicy::Back && cache.contents == Contents::Ideal {
            return Err(format!("`shadow_cache.writes` is not Back: with `{field}.contents: Ideal`, Back is allowed"));
        }
        Ok(())
    }

    /// A line that is written may be in one L2 only, since no protocol keeps the L2s of several cores coherent.
    fn check_coherence(&self) -> Result<(), String> {
        if self.cores.get() > 1 && self.shadow_cache.layout == StoreLayout::Record {
            return Err(
                "`shadow_cache.layout` is Record, which puts words into the lines of triangles, with more than one of \
                        `cores`, which all read triangles: another layout, or `cores: 1`, is allowed"
                    .into(),
            );
        }
        Ok(())
    }

    /// Checks that the machine can replay a stream.
    ///
    /// # Errors
    /// The stream lacks what the machine needs, or holds more than it can address.
    pub fn check_stream(&self, header: &Header) -> Result<(), SpecError> {
        let unit = &self.shadow_cache;
        let words = header.stores.mode_words;
        if unit.latched == LatchedCopy::Buffers && words > Step::MAX_INDEX / 2 {
            return Err(SpecError(format!(
                "`shadow_cache.latched` is Buffers, with the stream's {words} mode words: up to {} are allowed",
                Step::MAX_INDEX / 2
            )));
        }
        if unit.silent != SilentUpdates::Sent && header.unjudged_updates && words > 0 {
            return Err(SpecError(format!(
                "`shadow_cache.silent` is {:?}, but the stream's updates do not say what they change (its file is of \
                 version 2): record the stream again, or replay it on a machine \
                 with `silent: Sent` (small_naive, desktop_naive)",
                unit.silent
            )));
        }
        match unit.frame_end {
            FrameEnd::Epoch if unit.place != Place::Free => check_tag(header, unit.layout).map_err(SpecError),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::ron_file;

    fn read(text: &str) -> Result<MachineSpec, String> {
        let machine: MachineSpec = ron_file::parse(text, Path::new("x.ron")).map_err(|error| error.to_string())?;
        machine.check().map_err(|error| error.to_string())?;
        Ok(machine)
    }

    #[test]
    fn the_shipped_machines_are_valid_and_come_back_from_ron() {
        let machines = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/machines");
        let mut count = 0;
        for file in std::fs::read_dir(machines).unwrap() {
            let machine: MachineSpec = ron_file::read(&file.unwrap().path()).unwrap_or_else(|error| panic!("{error}"));
            machine.check().unwrap_or_else(|error| panic!("{error}"));
            let style = ron::ser::PrettyConfig::new().extensions(ron_file::extensions());
            assert_eq!(read(&ron::ser::to_string_pretty(&machine, style).unwrap()), Ok(machine));
            count += 1;
        }
        assert!(count >= 2, "there are {count} machines");
        assert_eq!(read("()"), Ok(MachineSpec::default()));
    }

    #[test]
    fn errors_name_the_field_and_what_is_allowed() {
        let cases = [
            ("(clock: 5)", "clock_mhz"),
            ("(traversal: (count: 0))", "0 is not allowed here: a whole number from 1 to 1024 is"),
            ("(line_bytes: 48)", "48 is not allowed here: a power of two from 32 to 128 is"),
            ("(traversal: (cache: (bytes: 8000)))", "`traversal.cache.bytes` is 8000"),
            ("(l2: Unified(bytes: 393216))", "1024 times a power of two is allowed"),
            ("(l2: Split({\"node\": (classes: [node, list, triangle], cache: ())}))", "no home for `mode_word`"),
            (
                "(l2: Split({\"a\": (classes: [node], cache: ()), \"b\": (classes: [node], cache: ())}))",
                "more than one home for `node` (a, b)",
            ),
            (
                "(l2: Split({\"a\": (classes: [node, list, triangle, mode_word, pixel_counter, occluder_id, ray, texture], \
                 cache: ())}))",
                "a home for `texture` (a), which goes past all caches",
            ),
            ("(l2: Split({\"L2\": (classes: [node], cache: ())}))", "a cache `L2`: small letters"),
            (
                "(shadow_cache: (layout: Beside), l2: Split({\"a\": (classes: [mode_word], cache: ()), \"b\": (classes: [node, list, triangle, pixel_counter, occluder_id, ray], cache: ())}))",
                "different homes for `mode_word` and `pixel_counter`",
            ),
            ("(shadow_cache: (cache: (bytes: 12288, ways: 3, replacement: TreePlru)))", "a power of two is allowed"),
            (
                "(shadow_cache: (writes: Through, cache: (contents: Ideal)))",
                "with `shadow_cache.cache.contents: Ideal`, Back is allowed",
            ),
            ("(traversal: (cache: (no_allocate: (reads: [nodes]))))", "nodes"),
            ("(dram: (model: Flat(bytes_per_cycle: 8)))", "Unexpected missing field named `latency`"),
            ("(list: (interval: 3))", "`list.interval` is 3: up to `list.latency`, which is 2, is allowed"),
            ("(dram: (channels: 2))", "`dram.mapping` has 0 bit(s) of `Channel`: it needs 1"),
            ("(dram: (mapping: [Row, Column(4)]))", "`Row` before its end"),
            ("(dram: (mapping: [Column(5), Bank(3)]))", "does not end with `Row`"),
            ("(dram: (part: (name: \"x\")))", "Unexpected missing field named `clock_mhz`"),
            ("(dram: (part: 5))", "the name of a file, or its values in brackets"),
        ];
        for (text, expected) in cases {
            let error = read(text).unwrap_err();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
