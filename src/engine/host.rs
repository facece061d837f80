//! The host: the stream's rays as they become known, and which one comes next. A dispatcher takes them from it, and
//! gives it their results. [`super::cycle`] has its own, on purpose.

use std::sync::Arc;

use super::families::Families;
use super::source::{StreamFault, check_step, is_sound, parents};
use crate::machine::layout::Layout;
use crate::memory::ring::Ring;
use crate::stream::{Chunk, Decision, FrameInfo, Item, Ray, RayKind, Totals};

/// A ray of a chunk in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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
    families: Families,
    /// Of each ray the traced shadow rays that start at its hit.
    traced_shadows: Vec<u32>,
    left: usize,
    /// Whether all steps exist. If not, the ray that has the first that does not is refused when it is handed over.
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

/// What the stream gave when no ray was left to hand out.
#[derive(Clone, Debug)]
pub(super) enum Pulled {
    /// A primary ray can be handed out, unless the chunk was empty.
    Rays,
    /// A frame began.
    Frame(FrameInfo),
    /// A frame has no more rays; its end's steps follow when all are done.
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
    /// Parents being shaded, and until when.
    shading: Ring<(u64, Place)>,
    in_frame: bool,
}

impl Host {
    /// Takes the stream's next item, in a frame with this layout. No primary ray is left to hand out.
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

    /// Whether more of the stream is needed for another primary ray.
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

    /// The place of the hit that a ray starts on, `back` rays back, and how many traced shadow rays start there.
    pub(super) fn siblings(&self, place: Place, back: u32) -> (u32, u32) {
        let hit = place.index - back;
        (hit, self.active(place).traced_shadows[hit as usize])
    }

    /// What the policy decided of a ray that is not done.
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

    /// The ray is done; if it has children, they are ready in cycle `at`.
    pub(super) fn done(&mut self, place: Place, at: u64) {
        if self.active(place).families.has_children(place.index) {
            self.shading.push_back((at, place));
        }
        self.are_done(place, 1);
    }

    /// So many rays of a ray's chunk are done.
    fn are_done(&mut self, place: Place, rays: usize) {
        let active = self.active_mut(place);
        active.left -= rays;
        if active.left == 0 {
            self.chunks[place.chunk as usize] = None;
        }
    }

    /// Children whose parents' shading is over in cycle `now` are ready, but for those that `answered` says are done at
    /// once: if those have children, they are ready in cycle `at`. Returns how many are done.
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

    /// When the next shading ends.
    pub(super) fn shading_ends(&self) -> Option<u64> {
        self.shading.front().map(|&(at, _)| at)
    }

    /// Whether no ray is known that was not handed out.
    pub(super) fn is_empty(&self) -> bool {
        !self.has_rays() && self.shading.is_empty()
    }

    /// The state of the lists, for the report of a deadlock.
    pub(super) fn queues(&self) -> String {
        format!("ready {}, being shaded {}", self.ready.len(), self.shading.len())
    }
}
