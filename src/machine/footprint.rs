//! Memory that the simulator needs for a machine, computed before anything is allocated. Each field of a spec is within
//! its range, but the product of several fields can exceed the host's memory.

use crate::memory::bank::BankedSpec;
use crate::memory::cache::CacheSpec;
use crate::memory::tags::Contents;

/// Upper limit for the parts of a machine, in bytes: twice the tags of 1 GB of caches with lines of 64 B.
const MOST: u128 = 1 << 28;

/// Bytes of a line's tag.
const TAG: u128 = 8;
/// Approximate bytes of a place in a queue, a context or a ray in flight.
const PLACE: u128 = 64;
/// Bytes of an access that waits in an MSHR.
const TARGET: u128 = 8;

/// Bytes of a machine's parts, by field of its spec.
pub(super) struct Footprint {
    cores: u128,
    line: u64,
    parts: Vec<(String, u128)>,
}

impl Footprint {
    /// An empty footprint of a machine with `cores` cores and lines of `line` bytes.
    pub(super) fn new(cores: u64, line: u64) -> Self {
        Self { cores: cores.into(), line, parts: Vec::new() }
    }

    /// Adds `count` units per core, each with these `places` in its queues and tables, and its L1.
    pub(super) fn add(mut self, name: &str, count: u64, places: &[u64], cache: Option<&CacheSpec>) -> Self {
        let places = PLACE * places.iter().map(|&places| u128::from(places)).sum::<u128>();
        let cache = cache.map_or(0, |cache| {
            let tags =
                if cache.contents == Contents::Ideal { 0 } else { TAG * u128::from(cache.bytes.get() / self.line) };
            tags + registers(cache.mshrs.get(), cache.targets.get(), cache.queue.get())
        });
        self.parts.push((name.into(), self.cores * u128::from(count) * (cache + places)));
        self
    }

    /// Adds a cache of the L2, once per core.
    pub(super) fn add_banked(mut self, name: String, cache: &BankedSpec) -> Self {
        let registers = registers(cache.mshrs.get(), cache.targets.get(), cache.queue.get());
        let tags = TAG * u128::from(cache.bytes.get() / self.line);
        self.parts.push((name, self.cores * (tags + u128::from(cache.banks.get()) * registers)));
        self
    }

    /// Bytes of all parts.
    pub(super) fn bytes(&self) -> u128 {
        self.parts.iter().map(|(_, bytes)| bytes).sum()
    }

    /// Checks the sum against [`MOST`].
    pub(super) fn check(&self) -> Result<(), String> {
        let all = self.bytes();
        match self.parts.iter().max_by_key(|(_, bytes)| bytes) {
            Some((largest, bytes)) if all > MOST => Err(format!(
                "the machine's caches, queues and registers take {all} bytes of memory to simulate, {bytes} of them for \
                 `{largest}`: up to {MOST} are allowed"
            )),
            _ => Ok(()),
        }
    }
}

/// Bytes of MSHRs with their waiting accesses, and of an out queue.
fn registers(count: u64, targets: u64, queue: u64) -> u128 {
    u128::from(count) * (PLACE + TARGET * u128::from(targets)) + PLACE * u128::from(queue)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ranged::{Size, Within};

    #[test]
    fn products_of_fields_are_bounded() {
        let cache = CacheSpec::DEFAULT;
        let of = |count, cache: &CacheSpec| Footprint::new(1, 64).add("list", count, &[8], Some(cache));
        assert_eq!(of(4, &cache).check(), Ok(()));
        let large = CacheSpec { bytes: Size::literal(0x1000_0000), ..cache };
        let told = of(1024, &large).check().unwrap_err();
        // 2^35 bytes of tags, and 1024 times 1,536 bytes for a unit's MSHRs and queue places.
        assert!(
            told.contains("34361311232 of them") && told.contains("for `list`: up to 268435456 are allowed"),
            "{told}"
        );
        let registers = CacheSpec { mshrs: Within::literal(1024), targets: Within::literal(1024), ..cache };
        assert!(of(64, &registers).check().is_err() && of(4, &registers).check().is_ok());
        // Smaller lines need more tags; an ideal cache has none.
        assert!(Footprint::new(1, 32).add("list", 1, &[8], Some(&cache)).bytes() > of(1, &cache).bytes());
        assert_eq!(of(1024, &CacheSpec { contents: Contents::Ideal, ..large }).check(), Ok(()));
        assert!(Footprint::new(64, 64).add_banked("l2".into(), &BankedSpec::DEFAULT).check().is_ok());
    }
}
