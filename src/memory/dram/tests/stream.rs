//! Bandwidth of the shipped parts for a stream of consecutive lines.

use std::path::Path;

use super::Awake;
use crate::memory::dram::Dram;
use crate::memory::dram::mapping::{Field, Mapping};
use crate::memory::dram::part::DramPart;
use crate::memory::dram::spec::DramSpec;
use crate::memory::{PartId, Request};
use crate::quantity::{Bytes, LineAddr};
use crate::ron_file;
use crate::stats::TrafficClass;

const LINE: u64 = 64;

/// One channel with the address mapping of the shipped machines: groups in turn, two lines of a row, then the next
/// bank.
fn channel(part: DramPart) -> DramSpec {
    let bits = |count: u64| count.trailing_zeros();
    let [groups, banks, columns] =
        [part.bank_groups.get(), part.banks.get() / part.bank_groups.get(), part.row_bytes.get() / LINE].map(bits);
    let mapping =
        [Field::BankGroup(groups), Field::Column(1), Field::Bank(banks), Field::Column(columns - 1), Field::Row];
    DramSpec { part, mapping: Mapping(mapping.into()), ..DramSpec::default() }
}

/// Bytes per clock of a stream of reads that never leaves the queue empty.
fn streamed(spec: &DramSpec, clocks: u64) -> f64 {
    spec.check(LINE).unwrap();
    let mut dram = Dram::new(spec, spec.part.clock_mhz.get(), LINE, PartId(0));
    let mut line = 0;
    let read = |line| Request {
        line: LineAddr(line),
        class: TrafficClass::Node,
        write: false,
        bytes: Bytes(LINE),
        from: PartId(1),
        attributed: false,
    };
    for now in 0..clocks {
        while dram.put(read(line), now, &mut Awake) {
            line += 1;
        }
        dram.tick(0, now, &mut Awake, |_, _| {});
    }
    (dram.counts(0).reads * LINE) as f64 / clocks as f64
}

/// A refresh takes tRFC of every tREFI; its precharges and activates take a few percent besides.
#[test]
fn every_part_streams_at_its_peak_but_for_refreshes() {
    for file in std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/dram")).unwrap() {
        let spec = channel(ron_file::read(&file.unwrap().path()).unwrap_or_else(|error| panic!("{error}")));
        let (refi, rfc) = (spec.part.timing.refi.get(), spec.part.timing.rfc.get());
        let peak = spec.peak_bytes_per_cycle(spec.part.clock_mhz.get()).unwrap();
        let possible = peak * (1.0 - rfc as f64 / refi as f64);
        let share = streamed(&spec, 20 * refi) / possible;
        println!("{}: {:.1} % of what refreshes leave", spec.part.name, 100.0 * share);
        assert!((0.9..=1.0).contains(&share), "{}: {share}", spec.part.name);
    }
}
