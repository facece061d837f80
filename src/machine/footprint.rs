//! What the simulator takes in memory for a machine, before anything is allocated: each field is in its range, and their
//! products need not be payable.

use super::spec::MachineSpec;
use crate::memory::cache::CacheSpec;
use crate::memory::tags::Contents;

/// The most that the parts of a machine may take, in bytes: tags of 1 GB of caches with lines of 64 B, and as much again.
const MOST: u128 = 1 << 28;

/// Bytes of a line's tag.
const TAG: u128 = 8;
/// Bytes of a place in a queue, a context or a ray in flight, about.
const PLACE: u128 = 64;
/// Bytes of an access that waits in a miss register.
const TARGET: u128 = 8;

/// Refuses a machine whose parts take more memory than is payable; the error names the largest.
pub(super) fn check(spec: &MachineSpec) -> Result<(), String> {
    let (parts, all) = (parts(spec), bytes(spec));
    match parts.iter().max_by_key(|(_, bytes)| bytes) {
        Some((largest, bytes)) if all > MOST => Err(format!(
            "the machine's caches, queues and registers take {all} bytes of memory to simulate, {bytes} of them for \
             `{largest}`: up to {MOST} are allowed"
        )),
        _ => Ok(()),
    }
}

/// Bytes of all parts.
pub(super) fn bytes(spec: &MachineSpec) -> u128 {
    parts(spec).iter().map(|(_, bytes)| bytes).sum()
}

/// Bytes by field of the spec.
fn parts(spec: &MachineSpec) -> Vec<(String, u128)> {
    let cores = u128::from(spec.cores.get());
    let line = spec.line_bytes.get();
    let unit = |name: &str, count: u64, places: u64, cache: Option<&CacheSpec>| {
        let cache = cache.map_or(0, |cache| self::cache(cache, line));
        (name.to_owned(), cores * u128::from(count) * (cache + PLACE * u128::from(places)))
    };
    let (traversal, list, intersection) = (&spec.traversal, &spec.list, &spec.intersection);
    let (division, shadow_cache) = (&spec.division, &spec.shadow_cache);
    let places = |all: &[u64]| all.iter().sum::<u64>();
    let pool = places(&[spec.dispatcher.rays.get(), spec.dispatcher.in_fifo.get(), spec.dispatcher.out_fifo.get()]);
    let mut parts = vec![
        unit("dispatcher", 1, pool, None),
        unit("traversal", traversal.count.get(), traversal.rays.get(), Some(&traversal.cache)),
        unit("list", list.count.get(), places(&[list.lists.get(), list.queue.get()]), Some(&list.cache)),
        unit(
            "intersection",
            intersection.count.get(),
            places(&[intersection.tests.get(), intersection.queue.get()]),
            Some(&intersection.cache),
        ),
        unit("division", division.count.get(), division.queue.get(), None),
        unit("shadow_cache", shadow_cache.count.get(), shadow_cache.contexts.get(), Some(&shadow_cache.cache)),
        ("dram".into(), u128::from(spec.dram.channels.get()) * PLACE * u128::from(spec.dram.queue.get())),
    ];
    for (name, cache) in spec.l2.caches() {
        let registers = registers(cache.mshrs.get(), cache.targets.get(), cache.queue.get());
        let tags = TAG * u128::from(cache.bytes.get() / line);
        parts.push((name, cores * (tags + u128::from(cache.banks.get()) * registers)));
    }
    parts
}

fn cache(spec: &CacheSpec, line: u64) -> u128 {
    let tags = if spec.contents == Contents::Ideal { 0 } else { TAG * u128::from(spec.bytes.get() / line) };
    tags + registers(spec.mshrs.get(), spec.targets.get(), spec.queue.get())
}

/// Miss registers with their waiting accesses, and an out queue.
fn registers(count: u64, targets: u64, queue: u64) -> u128 {
    u128::from(count) * (PLACE + TARGET * u128::from(targets)) + PLACE * u128::from(queue)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ranged::{PowerOfTwo, Within};

    #[test]
    fn products_of_fields_are_bounded() {
        let plain = MachineSpec::default();
        assert_eq!(check(&plain), Ok(()));
        let told = |change: &dyn Fn(&mut MachineSpec)| {
            let mut spec = plain.clone();
            change(&mut spec);
            check(&spec).unwrap_err()
        };
        let l1s = told(&|spec| {
            spec.traversal.count = Within::literal(1024);
            spec.traversal.cache.bytes = Within::literal(0x1000_0000);
        });
        assert!(l1s.contains("34359") && l1s.contains("for `traversal`: up to 268435456 are allowed"), "{l1s}");
        let registers = told(&|spec| {
            spec.cores = Within::literal(64);
            spec.list.count = Within::literal(1024);
            spec.list.cache.mshrs = Within::literal(1024);
        });
        assert!(registers.contains("for `list`"), "{registers}");
        // Smaller lines are more tags.
        let mut spec = plain.clone();
        spec.line_bytes = PowerOfTwo::literal(32);
        assert!(parts(&spec).iter().map(|part| part.1).sum::<u128>() > parts(&plain).iter().map(|part| part.1).sum());
    }
}
