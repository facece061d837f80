//! Machines on one pass share equal tags: lanes share the paths' tags, within these word lanes share the shadow-cache
//! units' tags, and within these L2 lanes share the L2s' tags.

use std::mem::take;
use std::sync::Arc;

use super::cutter::{CutPiece, Lead, Portion};
use super::job_cache::JobCache;
use super::l2_tags::L2Tags;
use super::path_tags::PathTags;
use super::windows::{Job, Windows};
use super::word_tags::WordTags;
use crate::engine::warm::{L1s, WarmCaches};
use crate::machine::MachineSpec;
use crate::machine::layout::Shift;
use crate::stream::Header;

/// A sampled machine.
pub(super) struct OnLane {
    /// Its index among the machines of the pass.
    pub index: usize,
    /// Its windows.
    pub windows: Windows,
    /// Jobs of later draws.
    pub cached: JobCache,
}

impl OnLane {
    /// Adds jobs that are due to `now`, with the machine's index; keeps those of later draws.
    fn sort(&mut self, jobs: Vec<Job>, now: &mut Vec<(usize, Job)>) {
        for job in jobs {
            if self.windows.is_due(&job) {
                now.push((self.index, job));
            } else {
                self.cached.add(job);
            }
        }
    }
}

/// Machines with equal tags of the paths.
pub(super) struct Lane {
    path: PathTags,
    words: Vec<WordLane>,
}

/// Machines of a lane with equal tags of the shadow-cache units' L1s.
struct WordLane {
    tags: WordTags,
    /// Rays in flight that these machines need.
    in_flight: usize,
    l2s: Vec<L2Lane>,
}

/// Machines of a word lane with equal tags of the L2s.
struct L2Lane {
    l2: L2Tags,
    machines: Vec<OnLane>,
}

/// Distributes machines among lanes, if possible one for each thread: a lane runs on one thread. Tags that are equal
/// before a stream stay equal, so no list of the fields that they depend on is needed.
pub(super) fn lanes<'a>(
    header: &Header,
    machines: impl Iterator<Item = (&'a MachineSpec, OnLane)>,
    threads: usize,
) -> Vec<Lane> {
    let mut lanes: Vec<Lane> = Vec::new();
    for (machine, sampled) in machines {
        let new = Lane { path: PathTags::new(header, machine), words: Vec::new() };
        let lane = place(&mut lanes, new, |one, other| one.path.is_as(&other.path));
        let in_flight = lane.path.in_flight();
        let new = WordLane { tags: WordTags::new(header, machine), in_flight, l2s: Vec::new() };
        let words = place(&mut lane.words, new, |one, other| one.tags == other.tags);
        let new = L2Lane { l2: L2Tags::new(header, machine), machines: Vec::new() };
        place(&mut words.l2s, new, |one, other| one.l2 == other.l2).machines.push(sampled);
    }
    while lanes.len() < threads
        && let Some(widest) = lanes.iter_mut().max_by_key(|lane| lane.words.len())
        && widest.words.len() > 1
    {
        let words = widest.words.split_off(widest.words.len() / 2);
        let path = widest.path.with(words[0].in_flight, words[0].tags.layout());
        lanes.push(Lane { path, words });
    }
    lanes
}

/// The first of `all` that is equal to `new`; `new` is added if there is none.
fn place<T>(all: &mut Vec<T>, new: T, is_same: impl Fn(&T, &T) -> bool) -> &mut T {
    let at = all.iter().position(|one| is_same(one, &new)).unwrap_or(all.len());
    if at == all.len() {
        all.push(new);
    }
    &mut all[at]
}

/// The shift of the path's lines to the layout of `tags`.
fn shift(path: &PathTags, tags: &WordTags) -> Shift {
    path.shift_to(tags.layout()).expect("who needs another path has parted")
}

impl Lane {
    /// Takes the next portion of the stream; returns the jobs to replay now, each with its machine's index.
    pub(super) fn add(&mut self, portion: &Portion) -> Vec<(usize, Job)> {
        let Self { path, words } = self;
        let mut jobs = Vec::new();
        match portion {
            Portion::Frame(info) => {
                path.begin_frame(info);
                for WordLane { tags, l2s, .. } in words {
                    tags.begin_frame(info);
                    for L2Lane { l2, machines } in l2s {
                        l2.begin_frame();
                        machines.iter_mut().for_each(|machine| machine.windows.frame(*info));
                    }
                }
            }
            Portion::Piece(piece) => self.piece(piece, &mut jobs),
            Portion::End(steps) => {
                let warm = self.warm(|windows| windows.wants_end(steps));
                let outcome = self.path.frame_end(steps);
                let mut warm = warm.into_iter();
                for WordLane { tags, l2s, .. } in &mut self.words {
                    let requests = tags.frame_end(steps, &outcome, shift(&self.path, tags));
                    for (L2Lane { l2, machines }, warm) in l2s.iter_mut().zip(&mut warm) {
                        l2.pass(&requests.list);
                        for machine in machines {
                            let complete = machine.windows.end(steps, warm.clone());
                            machine.sort(complete, &mut jobs);
                        }
                    }
                }
            }
        }
        jobs
    }

    fn piece(&mut self, piece: &CutPiece, jobs: &mut Vec<(usize, Job)>) {
        let begins = |windows: &Windows| piece.begin.iter().any(|lead: &Lead| windows.wants(lead));
        let mut warm = self.warm(begins).into_iter();
        let outcome = self.path.piece(&piece.chunk, piece.rays.clone());
        for WordLane { tags, in_flight, l2s } in &mut self.words {
            let shift = shift(&self.path, tags);
            let requests = tags.piece(&piece.chunk, piece.rays.clone(), &outcome, shift);
            if let Some(rays) = tags.in_flight(&requests.covariates) {
                *in_flight = self.path.limited(rays);
            }
            for (L2Lane { l2, machines }, warm) in l2s.iter_mut().zip(&mut warm) {
                // Requests do not include the host's own lines: their DRAM lines are in the covariates already.
                let covariates = l2.pass(&requests.list).added_to(requests.covariates);
                for machine in machines {
                    let complete = machine.windows.piece(piece, covariates, warm.as_ref());
                    machine.sort(complete, jobs);
                }
            }
        }
    }

    /// The contents of the caches of each L2 lane, in order, where one of its machines wants them.
    fn warm(&self, wants: impl Fn(&Windows) -> bool) -> Vec<Option<WarmCaches>> {
        let mut paths: Vec<(Shift, Arc<L1s>)> = Vec::new();
        let mut all = Vec::new();
        for WordLane { tags, l2s, .. } in &self.words {
            let (shift, mut words) = (shift(&self.path, tags), None);
            for L2Lane { l2, machines } in l2s {
                if !machines.iter().any(|machine| wants(&machine.windows)) {
                    all.push(None);
                    continue;
                }
                let path = match paths.iter().find(|(of, _)| *of == shift) {
                    Some((_, path)) => Arc::clone(path),
                    None => {
                        let path = self.path.snapshot(shift);
                        paths.push((shift, Arc::clone(&path)));
                        path
                    }
                };
                let words = Arc::clone(words.get_or_insert_with(|| tags.snapshot()));
                all.push(Some(WarmCaches { path, words, banks: l2.snapshot() }));
            }
        }
        all
    }

    /// Continues with the number of rays in flight that the first word lane needs. Word lanes that need another number,
    /// or whose layout the path cannot be shifted to, get lanes of their own, with a copy of the tags.
    pub(super) fn split_off(&mut self) -> Vec<Self> {
        let mut lanes: Vec<Self> = Vec::new();
        let Some(in_flight) = self.words.first().map(|first| first.in_flight) else { return lanes };
        for words in take(&mut self.words) {
            let fits = |path: &PathTags, in_flight| {
                words.in_flight == in_flight && path.shift_to(words.tags.layout()).is_some()
            };
            if fits(&self.path, in_flight) {
                self.words.push(words);
                continue;
            }
            match lanes.iter_mut().find(|lane| fits(&lane.path, lane.path.in_flight())) {
                Some(lane) => lane.words.push(words),
                None => {
                    let path = self.path.with(words.in_flight, words.tags.layout());
                    lanes.push(Self { path, words: vec![words] });
                }
            }
        }
        self.path.set_in_flight(in_flight);
        lanes
    }

    /// The machines, at the end of the stream.
    pub(super) fn finish(self) -> impl Iterator<Item = OnLane> {
        let l2s = self.words.into_iter().flat_map(|lane| lane.l2s);
        l2s.flat_map(|lane| lane.machines)
    }
}

/// Indices of machines by what they share: lanes, word lanes, L2 lanes.
#[cfg(test)]
pub(super) fn machines_of_lanes(header: &Header, machines: &[MachineSpec]) -> Vec<Vec<Vec<Vec<usize>>>> {
    use super::plan::{Cut, Plan};
    let on_lane = |(index, machine)| {
        let windows = Windows::new(machine, header, Plan::new(1.0, Cut::new(machine), 0), 0);
        (machine, OnLane { index, windows, cached: JobCache::default() })
    };
    let lanes = lanes(header, machines.iter().enumerate().map(on_lane), 1);
    let places = |lane: &L2Lane| lane.machines.iter().map(|machine| machine.index).collect();
    let l2s = |lane: &WordLane| lane.l2s.iter().map(places).collect();
    lanes.iter().map(|lane| lane.words.iter().map(l2s).collect()).collect()
}
