//! The L2: one cache for all traffic classes, or several caches with some classes each.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::bank::{Bank, BankedSpec};
use super::{PartId, Request, Wake};
use crate::named::Named;
use crate::quantity::LineAddr;
use crate::stats::TrafficClass;

/// The L2.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum L2Spec {
    /// One cache for all classes of traffic.
    Unified(BankedSpec),
    /// Several named caches; each class of traffic goes to one of them.
    Split(Named<HomeSpec>),
}

/// A cache of a split L2.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HomeSpec {
    /// The classes of traffic that use this cache.
    pub classes: Vec<TrafficClass>,
    /// The cache.
    pub cache: BankedSpec,
}

impl Default for L2Spec {
    fn default() -> Self {
        Self::Unified(BankedSpec::DEFAULT)
    }
}

impl L2Spec {
    /// The caches with their report names.
    pub fn caches(&self) -> Vec<(String, &BankedSpec)> {
        match self {
            Self::Unified(cache) => vec![("l2".into(), cache)],
            Self::Split(homes) => homes.iter().map(|(name, home)| (format!("l2_{name}"), &home.cache)).collect(),
        }
    }

    /// The index in [`L2Spec::caches`] of the class's cache. Classes that bypass all caches get 0, which is never used.
    pub fn home(&self, class: TrafficClass) -> usize {
        match self {
            Self::Unified(_) => 0,
            Self::Split(homes) => {
                let home = homes.iter().position(|(_, home)| home.classes.contains(&class));
                home.or(class.goes_past_caches().then_some(0))
                    .expect("a spec that leaves a class without a home is refused when it is checked")
            }
        }
    }

    /// Banks of all caches together.
    pub fn banks(&self) -> u64 {
        self.caches().iter().map(|(_, cache)| cache.banks.get()).sum()
    }

    /// Checks what single fields cannot; `line` is the line size in bytes.
    ///
    /// # Errors
    /// A class without a cache or with two, names that no report can hold, caches without a whole set.
    pub fn check(&self, line: u64) -> Result<(), String> {
        if let Self::Split(homes) = self {
            for (name, _) in homes.iter() {
                let allowed = |letter: char| letter.is_ascii_lowercase() || letter.is_ascii_digit() || letter == '_';
                if name.is_empty() || !name.chars().all(allowed) {
                    return Err(format!("`l2` has a cache `{name}`: small letters, digits and `_` are allowed"));
                }
            }
            for class in TrafficClass::ALL {
                let home = |(name, home): (&str, &HomeSpec)| {
                    let times = home.classes.iter().filter(|&&other| other == class).count();
                    std::iter::repeat_n(name.to_owned(), times)
                };
                let homes: Vec<_> = homes.iter().flat_map(home).collect();
                let goes_past = class.goes_past_caches();
                let class = class.name();
                match homes.as_slice() {
                    [home, ..] if goes_past => {
                        let why = format!("`l2` has a home for `{class}` ({home}), which goes past all caches");
                        return Err(format!("{why}: take it out of `classes`"));
                    }
                    [] if goes_past => {}
                    [_] => {}
                    [] => return Err(format!("`l2` has no home for `{class}`: one cache must list it in `classes`")),
                    more => {
                        let more = more.join(", ");
                        return Err(format!("`l2` has more than one home for `{class}` ({more}): one is allowed"));
                    }
                }
            }
        }
        self.caches().iter().try_for_each(|(name, cache)| cache.check(name, line))
    }

    /// The banks of each class's cache.
    pub fn homes(&self) -> [Home; TrafficClass::ALL.len()] {
        let mut first = 0;
        let range = |(_, cache): (String, &BankedSpec)| {
            let home = Home { first, mask: cache.banks.get() - 1 };
            first += cache.banks.size();
            home
        };
        let ranges: Vec<_> = self.caches().into_iter().map(range).collect();
        TrafficClass::ALL.map(|class| ranges[self.home(class)])
    }

    /// The empty L2s of `cores`; their banks' numbers in the machine begin with `first`.
    pub fn build(&self, first: PartId, cores: u32, line: u64) -> L2 {
        let mut banks = Vec::new();
        for (_, cache) in (0..cores).flat_map(|_| self.caches()) {
            let bank = |index| cache.bank(PartId(first.0 + index as u32), line);
            banks.extend((banks.len()..banks.len() + cache.banks.size()).map(bank));
        }
        L2 { banks, of_core: self.banks() as usize, homes: self.homes() }
    }
}

/// The banks of the cache that serves a class.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Home {
    first: usize,
    /// The number of banks minus one.
    mask: u64,
}

impl Home {
    /// The bank of a line.
    pub fn bank(&self, line: LineAddr) -> usize {
        self.first + (line.0 & self.mask) as usize
    }
}

/// All L2 banks of all cores.
#[derive(Clone, Debug)]
pub struct L2 {
    /// Ordered by core, then by cache, then by bank.
    pub banks: Vec<Bank>,
    /// Banks per core.
    of_core: usize,
    homes: [Home; TrafficClass::ALL.len()],
}

impl L2 {
    /// Puts a request of a core into the queue of its bank in cycle `now`. Without a place, it returns false and wakes
    /// the requester later.
    #[inline]
    pub fn put(&mut self, core: u32, request: Request, now: u64, wake: &mut impl Wake) -> bool {
        self.banks[core as usize * self.of_core + self.homes[request.class as usize].bank(request.line)]
            .put(request, now, wake)
    }
}
