//! The stream's rays as they become known: which one comes next, without cycles.

use std::collections::VecDeque;
use std::sync::Arc;

use crate::engine::error::RunError;
use crate::engine::feed::Feed;
use crate::engine::source::{StreamFault, parents};
use crate::stream::{Chunk, Decision, FrameInfo, Item, Ray, RayKind, Totals};

/// No ray.
const NONE: u32 = u32::MAX;

/// A ray of a chunk in memory.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// The chunk, by the host's number.
    pub chunk: u32,
    /// The ray's place in it.
    pub index: u32,
}

/// A chunk of which some rays are not done.
#[derive(Clone, Debug)]
struct Active {
    chunk: Arc<Chunk>,
    /// Of each ray its first child, and its next sibling. A primary ray's next sibling is the next primary ray.
    first_child: Vec<u32>,
    next_sibling: Vec<u32>,
    left: usize,
}

impl Active {
    fn new(chunk: Arc<Chunk>) -> Result<Self, StreamFault> {
        let parents = parents(&chunk)?;
        let mut first_child = vec![NONE; parents.len()];
        let mut next_sibling = vec![NONE; parents.len()];
        let mut next_primary = NONE;
        for (index, &parent) in parents.iter().enumerate().rev() {
            let first = if parent as usize == index { &mut next_primary } else { &mut first_child[parent as usize] };
            next_sibling[index] = std::mem::replace(first, index as u32);
        }
        Ok(Self { left: parents.len(), chunk, first_child, next_sibling })
    }
}

/// What the stream gave when no ray was left to hand out.
#[derive(Clone, Debug)]
pub(super) enum Pulled {
    /// A primary ray can be handed out.
    Rays,
    /// A frame began.
    Frame(FrameInfo),
    /// A frame has no more rays; its end's steps follow when all are done.
    End(Arc<Vec<u32>>, Totals),
    /// The stream is at its end.
    Nothing,
}

/// The stream's rays that are known.
#[derive(Clone, Debug, Default)]
pub(super) struct Host {
    chunks: Vec<Option<Active>>,
    /// The next primary ray.
    next_primary: Option<Place>,
    ready: VecDeque<Place>,
    /// Parents being shaded, and until when.
    shading: VecDeque<(u64, Place)>,
    in_frame: bool,
    /// Rays that were done, to be told.
    pub rays_over: usize,
}

impl Host {
    /// Takes the stream's next item. There is no ray to hand out.
    pub(super) fn pull(&mut self, feed: &mut dyn Feed) -> Result<Pulled, RunError> {
        let item = feed.next()?;
        let found = match &item {
            None => "its end",
            Some(Item::Frame(_)) => "a frame's beginning",
            Some(Item::Rays(_)) => "rays",
            Some(Item::End { .. }) => "a frame's end",
        };
        Ok(match (self.in_frame, item) {
            (false, None) => Pulled::Nothing,
            (false, Some(Item::Frame(info))) => {
                self.in_frame = true;
                Pulled::Frame(info)
            }
            (false, _) => return Err(StreamFault::Order { found, expected: "a frame's beginning" }.into()),
            (true, Some(Item::Rays(chunk))) => {
                if !chunk.is_empty() {
                    let active = Some(Active::new(chunk)?);
                    let place = self.chunks.iter().position(Option::is_none).unwrap_or(self.chunks.len());
                    self.chunks.resize(self.chunks.len().max(place + 1), None);
                    self.chunks[place] = active;
                    self.next_primary = Some(Place { chunk: place as u32, index: 0 });
                }
                Pulled::Rays
            }
            (true, Some(Item::End { policy, totals })) => {
                self.in_frame = false;
                Pulled::End(policy, totals)
            }
            (true, _) => return Err(StreamFault::Order { found, expected: "rays or a frame's end" }.into()),
        })
    }

    /// Whether the next ray is a primary one that has not been pulled, or there is none.
    pub(super) fn wants_rays(&self) -> bool {
        self.next_primary.is_none()
    }

    fn active(&self, place: Place) -> &Active {
        self.chunks[place.chunk as usize].as_ref().expect("a chunk stays while it has rays that are not done")
    }

    /// The ray to be handed out next.
    pub(super) fn candidate(&self) -> Option<Place> {
        self.ready.front().copied().or(self.next_primary)
    }

    /// The chunk of a ray that is not done.
    pub(super) fn chunk(&self, place: Place) -> &Chunk {
        &self.active(place).chunk
    }

    /// The place of the hit that a ray starts on, `back` rays back, and how many traced shadow rays start there.
    pub(super) fn siblings(&self, place: Place, back: u32) -> (u32, u32) {
        let active = self.active(place);
        let hit = place.index - back;
        let some = |child: u32| (child != NONE).then_some(child);
        let first = some(active.first_child[hit as usize]);
        let children = std::iter::successors(first, |&child| some(active.next_sibling[child as usize]));
        let traced = |&child: &u32| {
            let head = active.chunk.head(child as usize);
            head.kind == RayKind::Shadow && head.decision != Decision::Skip
        };
        (hit, children.filter(traced).count() as u32)
    }

    /// The candidate was handed out.
    pub(super) fn handed_out(&mut self) {
        if self.ready.pop_front().is_none()
            && let Some(place) = self.next_primary
        {
            let next = self.active(place).next_sibling[place.index as usize];
            self.next_primary = (next != NONE).then_some(Place { index: next, ..place });
        }
    }

    /// The ray is done; whether it has children, which will be ready in cycle `at`.
    pub(super) fn done(&mut self, place: Place, at: u64) -> bool {
        let Some(active) = &mut self.chunks[place.chunk as usize] else {
            unreachable!("a chunk stays while it has rays that are not done")
        };
        active.left -= 1;
        self.rays_over += 1;
        let parent = active.first_child[place.index as usize] != NONE;
        if parent {
            self.shading.push_back((at, place));
        } else if active.left == 0 {
            self.chunks[place.chunk as usize] = None;
        }
        parent
    }

    /// Children whose parents' shading is over in cycle `now` are ready, but for those that `answered` says are
    /// done at once.
    pub(super) fn shaded(&mut self, now: u64, shading: u64, mut answered: impl FnMut(&Ray<'_>) -> bool) {
        while let Some(&(at, parent)) = self.shading.front()
            && at <= now
        {
            self.shading.pop_front();
            let Some(active) = &mut self.chunks[parent.chunk as usize] else {
                unreachable!("a chunk stays while it has rays that are not done")
            };
            let mut index = active.first_child[parent.index as usize];
            while index != NONE {
                let child = Place { index, ..parent };
                if answered(&active.chunk.ray(index as usize)) {
                    active.left -= 1;
                    self.rays_over += 1;
                    if active.first_child[index as usize] != NONE {
                        self.shading.push_back((now + shading, child));
                    }
                } else {
                    self.ready.push_back(child);
                }
                index = active.next_sibling[index as usize];
            }
            if active.left == 0 {
                self.chunks[parent.chunk as usize] = None;
            }
        }
    }

    /// When the next parent's shading ends.
    pub(super) fn next_shaded(&self) -> Option<u64> {
        self.shading.front().map(|&(at, _)| at)
    }

    /// Whether no ray is known that was not handed out.
    pub(super) fn is_empty(&self) -> bool {
        self.candidate().is_none() && self.shading.is_empty()
    }
}
