//! Machines side by side on one pass: those whose L1s' tags are equal share them, and those whose L2s' tags are equal
//! too share those.

use std::sync::Arc;

use super::cutter::{CutPiece, Lead, Portion};
use super::kept::Kept;
use super::l1_tags::{L1Tags, Passed};
use super::l2_tags::L2Tags;
use super::windows::{Job, Windows};
use crate::engine::warm::WarmCaches;
use crate::machine::MachineSpec;
use crate::stream::Header;

/// A machine that is sampled, by its place among all of the pass.
pub(super) struct OnLane {
    /// The place.
    pub index: usize,
    /// Its windows.
    pub windows: Windows,
    /// Jobs of later draws.
    pub kept: Kept,
}

impl OnLane {
    /// Keeps the jobs that later draws may want; the others go to `now`, with the machine's place.
    fn sort(&mut self, jobs: Vec<Job>, now: &mut Vec<(usize, Job)>) {
        for job in jobs {
            if self.windows.is_due(&job) {
                now.push((self.index, job));
            } else {
                self.kept.add(job);
            }
        }
    }
}

/// Machines whose L1s' tags are equal.
pub(super) struct Lane {
    l1: L1Tags,
    l2s: Vec<L2Lane>,
}

/// Those of them whose L2s' tags are equal too.
struct L2Lane {
    l2: L2Tags,
    machines: Vec<OnLane>,
}

/// Deals machines to lanes. Tags that are equal before a stream stay equal, so that nobody need say which fields of a
/// machine they hang on.
pub(super) fn lanes<'a>(header: &Header, machines: impl Iterator<Item = (&'a MachineSpec, OnLane)>) -> Vec<Lane> {
    let mut lanes: Vec<Lane> = Vec::new();
    for (machine, sampled) in machines {
        let (l1, l2) = (L1Tags::new(header, machine), L2Tags::new(header, machine));
        let lane = match lanes.iter_mut().position(|lane| lane.l1 == l1) {
            Some(at) => at,
            None => {
                lanes.push(Lane { l1, l2s: Vec::new() });
                lanes.len() - 1
            }
        };
        let l2s = &mut lanes[lane].l2s;
        match l2s.iter_mut().find(|lane| lane.l2 == l2) {
            Some(lane) => lane.machines.push(sampled),
            None => l2s.push(L2Lane { l2, machines: vec![sampled] }),
        }
    }
    lanes
}

impl Lane {
    /// The next portion of the stream; the jobs that are to be replayed, each with its machine's place.
    pub(super) fn add(&mut self, portion: &Portion) -> Vec<(usize, Job)> {
        match portion {
            Portion::Frame(info) => {
                self.l1.begin_frame(info);
                for L2Lane { l2, machines } in &mut self.l2s {
                    l2.begin_frame();
                    machines.iter_mut().for_each(|machine| machine.windows.frame(*info));
                }
                Vec::new()
            }
            Portion::Piece(piece) => self.piece(piece),
            Portion::End(steps) => {
                let warm = self.warm(|windows| windows.wants_end(steps));
                let Passed { requests, .. } = self.l1.frame_end(steps);
                let mut jobs = Vec::new();
                for (L2Lane { l2, machines }, warm) in self.l2s.iter_mut().zip(warm) {
                    l2.pass(&requests);
                    for machine in machines {
                        let complete = machine.windows.end(steps, warm.clone());
                        machine.sort(complete, &mut jobs);
                    }
                }
                jobs
            }
        }
    }

    fn piece(&mut self, piece: &CutPiece) -> Vec<(usize, Job)> {
        let begins = |windows: &Windows| piece.begin.iter().any(|lead: &Lead| windows.wants(lead));
        let warm = self.warm(begins);
        let Passed { known, requests } = self.l1.piece(&piece.chunk, piece.rays.clone());
        let mut jobs = Vec::new();
        for (L2Lane { l2, machines }, warm) in self.l2s.iter_mut().zip(warm) {
            // Of the host's own lines it is known already.
            let known = l2.pass(&requests).added_to(known);
            for machine in machines {
                let complete = machine.windows.piece(piece, known, warm.as_ref());
                machine.sort(complete, &mut jobs);
            }
        }
        jobs
    }

    /// What the caches of each L2's machines hold, where one of these wants to know.
    fn warm(&self, wants: impl Fn(&Windows) -> bool) -> Vec<Option<WarmCaches>> {
        let mut l1s = None;
        let warm = |lane: &L2Lane| {
            let is_wanted = lane.machines.iter().any(|machine| wants(&machine.windows));
            is_wanted.then(|| {
                let l1s = l1s.get_or_insert_with(|| self.l1.snapshot());
                WarmCaches::new(Arc::clone(l1s), lane.l2.snapshot())
            })
        };
        self.l2s.iter().map(warm).collect()
    }

    /// Its machines, the stream being over.
    pub(super) fn finish(self) -> impl Iterator<Item = OnLane> {
        self.l2s.into_iter().flat_map(|lane| lane.machines)
    }
}

/// Places of machines by what they share: those of one L2 in those of one set of L1s.
#[cfg(test)]
pub(super) fn machines_of_lanes(header: &Header, machines: &[MachineSpec]) -> Vec<Vec<Vec<usize>>> {
    use super::plan::{Cut, Plan};
    let on_lane = |(index, machine)| {
        let windows = Windows::new(machine, header, Plan::new(1.0, Cut::new(machine), 0), 0);
        (machine, OnLane { index, windows, kept: Kept::default() })
    };
    let lanes = lanes(header, machines.iter().enumerate().map(on_lane));
    let places = |lane: &L2Lane| lane.machines.iter().map(|machine| machine.index).collect();
    lanes.iter().map(|lane| lane.l2s.iter().map(places).collect()).collect()
}
