//! Bounds compared with machines that reach them: no traffic is omitted, and none is counted twice.

use super::agreement::check_many;
use super::anomalies::{l1s, without_policy};
use super::random::{machines, streams};
use super::*;
use crate::machine::shadow_cache::ShadowCacheSpec;
use crate::memory::tags::Contents;

/// A machine with one unit per kind, whose caches hold the whole stream: each line is fetched once.
fn roomy(machine: &mut MachineSpec) {
    machine.cores = num(1);
    machine.shadow_cache = ShadowCacheSpec::default();
    let MachineSpec { traversal, list, intersection, .. } = machine;
    (traversal.count, list.count, intersection.count) = (num(1), num(1), num(1));
    let line = machine.line_bytes.get();
    for cache in l1s(machine) {
        (cache.contents, cache.ways, cache.bytes) = (Contents::Tags, num(64), size(64 * 64 * line));
        cache.no_allocate = Default::default();
    }
    machine.l2 = L2Spec::Unified(BankedSpec {
        contents: Contents::Tags,
        banks: pow(1),
        ways: num(64),
        bytes: size(64 * 64 * line),
        ..BankedSpec::DEFAULT
    });
}

/// Paths only: a policy's words are also written, and an end-of-frame update writes lines that no access requests.
#[test]
fn one_unit_with_caches_that_hold_everything_moves_the_least_bytes() {
    check_many(
        200,
        || (machines(), streams()),
        |(mut machine, stream)| {
            roomy(&mut machine);
            machine.check().map_err(|error| error.to_string())?;
            let stats = run(&machine, Level::Event, &header(), &without_policy(&stream)).map_err(|e| e.to_string())?;
            let bounds = stats.bounds.ok_or("no bounds")?;
            let moved = [stats.moved("l2"), stats.moved("dram")];
            let least = [bounds.l2_bytes.least, bounds.dram_bytes.least];
            if moved == least { Ok(()) } else { Err(format!("{moved:?} bytes moved, {least:?} at least")) }
        },
    );
}
