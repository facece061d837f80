//! The host: keeps the rays of the stream that are known, and chooses the next ray to hand out. A dispatcher takes
//! rays from it and returns their results. [`super::cycle`] has its own host, on purpose.

use std::sync::Arc;

use super::families::Families;
use super::source::{StreamFault, check_step, is_sound, parents};
use crate::machine::layout::Layout;
use crate::memory::ring::Ring;
use crate::stream::{Chunk, Decision, FrameInfo, Item, Ray, RayKind, Totals};

/// A ray, by its chunk and its index there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Place {
    /// The host's number of the chunk.
    pub chunk: u32,
    /// The ray's index in the chunk.
    pub index: u32,
}

/// A chunk with rays that are not done.
#[derive(Clone, Debug)]
struct Active {
    chunk: Arc<Chunk>,
    families: Families,
    /// For each ray, the number of traced shadow rays that start on its hit.
    traced_shadows: Vec<u32>,
    left: usize,
    /// Whether all steps exist. If not, each ray is checked when it is handed over.
    sound: bool,
}

impl Active {
    fn new(chunk: Arc<Chunk>, layout: &Layout) -> Result<Self, StreamFault> {
        let parents = parents(&chunk)?;
        let mut traced_shadows = vec![0; parents.len()];
        for (head, &parent) in chunk.heads().zip(parents.iter()) {
            let is_traced = head.kind == RayKind::Shadow && head.decision != Decision::Skip;
            traced_shadows[parent as usize] += u32::from(is_traced);
        }
        let sound = is_sound(&chunk, layout);
        let families = Families::new(parents.iter().copied());
        Ok(Self { left: parents.len(), chunk, families, traced_shadows, sound })
    }
}

/// What [`Host::pull`] took from the stream.
#[derive(Clone, Debug)]
pub(super) enum Pulled {
    /// Rays: a primary ray can be handed out, unless the chunk was empty.
    Rays,
    /// A frame began.
    Frame(FrameInfo),
    /// The frame has no more rays; its end-of-frame steps follow when all rays are done.
    End(Arc<Vec<u32>>, Totals),
    /// The stream is at its end.
    Nothing,
}

/// The host.
#[derive(Clone, Debug, Default)]
pub(super) struct Host {
    chunks: Vec<Option<Active>>,
    /// The next primary ray.
    next_primary: Option<Place>,
    ready: Ring<Place>,
    /// Parents being shaded, each with the cycle in which its shading ends.
    shading: Ring<(u64, Place)>,
    in_frame: bool,
}

impl Host {
    /// Takes the stream's next item, in a frame with this layout. To be called when [`Host::wants_rays`].
    pub(super) fn pull<E: From<StreamFault>>(
        &mut self,
        next: &mut (impl FnMut() -> Result<Option<Item>, E> + ?Sized),
        layout: &Layout,
    ) -> Result<Pulled, E> {
        let item = next()?;
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
                    self.load(Active::new(chunk, layout)?);
                }
                Pulled::Rays
            }
            (true, Some(Item::End { policy, totals })) => {
                for &word in policy.iter() {
                    check_step(word, layout)?;
                }
                self.in_frame = false;
                Pulled::End(policy, totals)
            }
            (true, _) => return Err(StreamFault::Order { found, expected: "rays or a frame's end" }.into()),
        })
    }

    fn load(&mut self, active: Active) {
        let free = self.chunks.iter().position(Option::is_none);
        let place = free.unwrap_or(self.chunks.len());
        if free.is_some() {
            self.chunks[place] = Some(active);
        } else {
            self.chunks.push(Some(active));
        }
        self.next_primary = Some(Place { chunk: place as u32, index: 0 });
    }

    /// Whether the next primary ray needs another item of the stream.
    pub(super) fn wants_rays(&self) -> bool {
        self.next_primary.is_none()
    }

    #[inline]
    fn active(&self, place: Place) -> &Active {
        self.chunks[place.chunk as usize].as_ref().expect("a chunk stays while it has rays that are not done")
    }

    fn active_mut(&mut self, place: Place) -> &mut Active {
        self.chunks[place.chunk as usize].as_mut().expect("a chunk stays while it has rays that are not done")
    }

    /// A ray that is not done.
    #[inline]
    pub(super) fn ray(&self, place: Place) -> Ray<'_> {
        self.active(place).chunk.ray(place.index as usize)
    }

    /// The index of the hit that the ray at `place` starts on (the ray `back` places earlier has the hit), and the
    /// number of traced shadow rays that start there.
    pub(super) fn siblings(&self, place: Place, back: u32) -> (u32, u32) {
        let hit = place.index - back;
        (hit, self.active(place).traced_shadows[hit as usize])
    }

    /// The policy's decision for a ray that is not done.
    #[inline]
    pub(super) fn decision(&self, place: Place) -> Decision {
        self.active(place).chunk.head(place.index as usize).decision
    }

    /// Whether all steps of the ray's chunk are known to exist.
    pub(super) fn is_sound(&self, place: Place) -> bool {
        self.active(place).sound
    }

    /// Whether there is a ray to hand out.
    pub(super) fn has_rays(&self) -> bool {
        !self.ready.is_empty() || self.next_primary.is_some()
    }

    /// Hands out the next ray.
    pub(super) fn give(&mut self) -> Option<Place> {
        self.ready.pop_front().or_else(|| {
            let place = self.next_primary?;
            let next = self.active(place).families.sibling(place.index);
            self.next_primary = next.map(|index| Place { index, ..place });
            Some(place)
        })
    }

    /// The ray is done; its children, if any, are ready in cycle `at`.
    pub(super) fn done(&mut self, place: Place, at: u64) {
        if self.active(place).families.has_children(place.index) {
            self.shading.push_back((at, place));
        }
        self.are_done(place, 1);
    }

    /// `rays` rays of the chunk of `place` are done; drops the chunk after its last ray.
    fn are_done(&mut self, place: Place, rays: usize) {
        let active = self.active_mut(place);
        active.left -= rays;
        if active.left == 0 {
            self.chunks[place.chunk as usize] = None;
        }
    }

    /// Handles the children of parents whose shading is over in cycle `now`. A child for which `answered` is true is
    /// done at once, and its own children are ready in cycle `at`; other children are ready now. Returns the number of
    /// children done at once.
    pub(super) fn shade<E>(
        &mut self,
        now: u64,
        at: u64,
        mut answered: impl FnMut(&Chunk, usize) -> Result<bool, E>,
    ) -> Result<usize, E> {
        let mut all = 0;
        while let Some((_, parent)) = self.shading.front().copied().filter(|&(over, _)| over <= now) {
            self.shading.pop_front();
            let Self { chunks, ready, shading, .. } = self;
            let Some(active) = &chunks[parent.chunk as usize] else { unreachable!("a chunk stays while it has rays") };
            let mut done = 0;
            for index in active.families.children(parent.index) {
                let child = Place { index, ..parent };
                if !answered(&active.chunk, index as usize)? {
                    ready.push_back(child);
                    continue;
                }
                done += 1;
                if active.families.has_children(index) {
                    shading.push_back((at, child));
                }
            }
            self.are_done(parent, done);
            all += done;
        }
        Ok(all)
    }

    /// The cycle in which the next shading ends.
    pub(super) fn shading_ends(&self) -> Option<u64> {
        self.shading.front().map(|&(at, _)| at)
    }

    /// Whether all known rays have been handed out.
    pub(super) fn is_empty(&self) -> bool {
        !self.has_rays() && self.shading.is_empty()
    }

    /// The state of the queues, for the report of a deadlock.
    pub(super) fn queues(&self) -> String {
        format!("ready {}, being shaded {}", self.ready.len(), self.shading.len())
    }
}
