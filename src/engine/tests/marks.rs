//! Marks, between which windows are measured: compares the counts of a mark with those at the end of the same cycle.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::agreement::{check_many, far_ahead, without_lists};
use super::random::{machines, streams};
use super::*;
use crate::engine::feed::{CycleEnd, Feed};
use crate::engine::source::FrameCounts;
use crate::engine::tally::Tally;
use crate::engine::warm::WarmCaches;

/// When the counts of a run are taken.
#[derive(Clone, Copy)]
enum At {
    /// The cycle in which this number of rays is done, which is not known in advance.
    Mark(usize),
    /// A given cycle.
    Look(u64),
}

/// Takes the counts once.
struct Once {
    items: VecDeque<Item>,
    at: At,
    over: usize,
    found: Option<Tally>,
}

impl Feed for Once {
    fn next(&mut self) -> Result<Option<Item>, RunError> {
        Ok(self.items.pop_front())
    }

    fn frame_over(&mut self, _: &FrameCounts) -> Result<(), RunError> {
        Ok(())
    }

    fn rays_over(&mut self, rays: usize) {
        self.over += rays;
    }

    fn marks(&self) -> bool {
        matches!(self.at, At::Mark(rays) if self.over >= rays) && self.found.is_none()
    }

    fn mark(&mut self, tally: &Tally) -> Option<&WarmCaches> {
        self.found = Some(tally.clone());
        None
    }

    fn looks(&self) -> bool {
        matches!(self.at, At::Look(_))
    }

    fn look_at(&self) -> u64 {
        if let (At::Look(cycle), None) = (self.at, &self.found) { cycle } else { u64::MAX }
    }

    fn looked(&mut self, _: u64, end: CycleEnd<'_>) -> Result<(), RunError> {
        self.found = Some((end.tally)());
        Ok(())
    }
}

fn counts(machine: &MachineSpec, header: &Header, stream: &[Item], at: At) -> Result<Option<Tally>, String> {
    let mut feed = Once { items: stream.to_vec().into(), at, over: 0, found: None };
    Event::new(machine, header).run(&mut feed).map_err(|error| error.to_string())?;
    Ok(feed.found)
}

/// Number of units that are ahead of a mark in the middle of a stream. Banks and channels are never ahead. A unit may
/// be ahead by at most its work in the minimum latency of the L2, and has one cause for each of its cycles.
fn ahead(machine: &MachineSpec, header: &Header, stream: &[Item]) -> Result<usize, String> {
    let rays = |item: &Item| if let Item::Rays(chunk) = item { chunk.len() } else { 0 };
    let middle = stream.iter().map(rays).sum::<usize>().div_ceil(2).max(1);
    let Some(mark) = counts(machine, header, stream, At::Mark(middle))? else { return Ok(0) };
    // Units have not acted in the cycle of the mark.
    let Some(before) = mark.cycles.checked_sub(2) else { return Ok(0) };
    let look = counts(machine, header, stream, At::Look(before))?.ok_or("nothing to look at")?;
    let below = |tally: &Tally| {
        let channels: Vec<_> = tally.channels.iter().map(|channel| (channel.counts, channel.moved)).collect();
        (tally.banks.clone(), channels)
    };
    if below(&mark) != below(&look) {
        return Err(format!("marked {:#?}\nlooked at {:#?}", below(&mark), below(&look)));
    }
    let most = 1 + machine.l2.caches().iter().map(|(_, cache)| cache.latency.get()).min().unwrap_or(0);
    let mut ahead = 0;
    for (marked, exact) in mark.units.iter().flatten().zip(look.units.iter().flatten()) {
        let accesses = |unit: &UnitTally| unit.cache.iter().map(|counts| counts.accesses).sum::<u64>();
        let found = [accesses(marked), marked.operations, marked.causes.iter().sum()];
        let least = [accesses(exact), exact.operations, mark.cycles];
        if found.iter().zip(least).any(|(found, least)| !(least..=least + most).contains(found)) {
            return Err(format!("{found:?} for {least:?} and {most} more at most: {marked:#?}\n{exact:#?}"));
        }
        ahead += usize::from(found[0] > least[0]);
    }
    Ok(ahead)
}

#[test]
fn a_mark_counts_no_more_than_units_do_ahead_of_it() {
    let all = AtomicUsize::new(0);
    let add = |ahead: usize| {
        all.fetch_add(ahead, Ordering::Relaxed);
    };
    check_many(100, || (machines(), streams()), |(machine, stream)| ahead(&machine, &header(), &stream).map(add));
    check_many(100, far_ahead, |(machine, stream)| ahead(&machine, &without_lists(), &stream).map(add));
    let all = all.into_inner();
    assert!(all > 100, "{all} units were ahead");
}
