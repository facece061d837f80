//! The host: reads the stream and shades. The dispatcher takes its rays from it, and gives it their results.

use std::sync::Arc;

use super::links::Links;
use crate::engine::source::{StreamFault, check_step, parents};
use crate::machine::layout::Layout;
use crate::memory::ring::Ring;
use crate::stream::{Chunk, Decision, Item, RayKind, Totals};

/// A ray of a chunk in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ChunkRay {
    /// The host's number of the chunk.
    pub chunk: u32,
    /// The ray's place in it.
    pub index: u32,
}

/// A chunk of which some rays are not done.
#[derive(Clone, Debug)]
struct ActiveChunk {
    chunk: Arc<Chunk>,
    /// Ray `i` has the children `children[first_child[i]..first_child[i + 1]]`.
    first_child: Vec<u32>,
    children: Vec<u32>,
    primaries: Vec<u32>,
    left: usize,
    /// Whether all steps exist. If not, the ray that has the first that does not is refused when it is handed over.
    sound: bool,
}

impl ActiveChunk {
    fn new(chunk: Arc<Chunk>, layout: &Layout) -> Result<Self, StreamFault> {
        let extent = chunk.extent();
        let exist = extent.outermost().all(|step| layout.check(step).is_ok());
        let sound = exist && extent.unknown().is_none() && !extent.strays();
        let count = chunk.len();
        let parents = parents(&chunk)?;
        let mut primaries = Vec::new();
        let mut first_child = vec![0u32; count + 2];
        for (index, &parent) in parents.iter().enumerate() {
            if index as u32 == parent {
                primaries.push(parent);
            } else {
                first_child[parent as usize + 2] += 1;
            }
        }
        // Counts become beginnings, shifted by one; filling moves each beginning to its end, the next one's beginning.
        for index in 1..first_child.len() {
            first_child[index] += first_child[index - 1];
        }
        let mut children = vec![0; count - primaries.len()];
        for (index, &parent) in parents.iter().enumerate().filter(|&(index, &parent)| index as u32 != parent) {
            let place = &mut first_child[parent as usize + 1];
            children[*place as usize] = index as u32;
            *place += 1;
        }
        Ok(Self { chunk, first_child, children, primaries, left: count, sound })
    }

    fn children(&self, index: u32) -> &[u32] {
        &self.children[self.first_child[index as usize] as usize..self.first_child[index as usize + 1] as usize]
    }
}

/// Where the host stands in the stream.
#[derive(Clone, Debug)]
pub(super) enum Phase {
    /// Before a frame.
    Between,
    /// In a frame.
    Open,
    /// All of the frame's rays are known.
    Closing(Arc<Vec<u32>>, Totals),
    /// The end's steps are under way, or done in this cycle.
    Ending(Totals),
    /// After the last frame.
    Finished,
}

/// The host.
#[derive(Clone, Debug)]
pub(super) struct Host {
    /// Where it stands in the stream.
    pub phase: Phase,
    /// The frame's number.
    pub frame: u32,
    shading_cycles: u64,
    chunks: Vec<Option<ActiveChunk>>,
    /// The chunk whose primary rays are given out, and how many were.
    current: Option<(u32, usize)>,
    ready: Ring<ChunkRay>,
    shading: Ring<(u64, ChunkRay)>,
}

impl Host {
    /// A host at the beginning of a stream.
    pub(super) fn new(shading_cycles: u64) -> Self {
        Self {
            phase: Phase::Between,
            frame: 0,
            shading_cycles,
            chunks: Vec::new(),
            current: None,
            ready: Ring::new(),
            shading: Ring::new(),
        }
    }

    /// Takes items from the stream until a primary ray can be given out, or the frame has no more; whether a frame
    /// began.
    pub(super) fn pull<E: From<StreamFault>>(
        &mut self,
        next: &mut impl FnMut() -> Result<Option<Item>, E>,
        links: &mut Links,
    ) -> Result<bool, E> {
        let mut began = false;
        while self.current.is_none() && matches!(self.phase, Phase::Between | Phase::Open) {
            let item = next()?;
            let found = match &item {
                None => "its end",
                Some(Item::Frame(_)) => "a frame's beginning",
                Some(Item::Rays(_)) => "rays",
                Some(Item::End { .. }) => "a frame's end",
            };
            match (&self.phase, item) {
                (Phase::Between, None) => self.phase = Phase::Finished,
                (Phase::Between, Some(Item::Frame(frame))) => {
                    links.begin_frame(&frame);
                    (self.phase, self.frame, began) = (Phase::Open, frame.number, true);
                }
                (Phase::Between, _) => return Err(StreamFault::Order { found, expected: "a frame's beginning" }.into()),
                (_, Some(Item::Rays(chunk))) => self.load(chunk, &links.layout)?,
                (_, Some(Item::End { policy, totals })) => {
                    for &word in policy.iter() {
                        check_step(word, &links.layout)?;
                    }
                    self.phase = Phase::Closing(policy, totals);
                }
                _ => return Err(StreamFault::Order { found, expected: "rays or a frame's end" }.into()),
            }
        }
        Ok(began)
    }

    fn load(&mut self, chunk: Arc<Chunk>, layout: &Layout) -> Result<(), StreamFault> {
        if chunk.is_empty() {
            return Ok(());
        }
        let chunk = Some(ActiveChunk::new(chunk, layout)?);
        let free = self.chunks.iter().position(Option::is_none);
        let place = free.unwrap_or(self.chunks.len());
        if free.is_some() {
            self.chunks[place] = chunk;
        } else {
            self.chunks.push(chunk);
        }
        self.current = Some((place as u32, 0));
        Ok(())
    }

    /// The ray in its chunk.
    pub(super) fn ray(&self, which: ChunkRay) -> crate::stream::Ray<'_> {
        self.active(which.chunk).chunk.ray(which.index as usize)
    }

    /// The place of the hit that a ray starts on, `back` rays back, and how many traced shadow rays start there.
    pub(super) fn siblings(&self, which: ChunkRay, back: u32) -> (u32, u32) {
        let active = self.active(which.chunk);
        let hit = which.index - back;
        let traced = |&&index: &&u32| {
            let head = active.chunk.head(index as usize);
            head.kind == RayKind::Shadow && head.decision != Decision::Skip
        };
        (hit, active.children(hit).iter().filter(traced).count() as u32)
    }

    /// Whether all steps of the ray's chunk are known to exist.
    pub(super) fn is_sound(&self, which: ChunkRay) -> bool {
        self.active(which.chunk).sound
    }

    fn active(&self, place: u32) -> &ActiveChunk {
        self.chunks[place as usize].as_ref().expect("a chunk stays while it has rays that are not done")
    }

    /// Parents whose shading ends in cycle `now` have their children ready, but for those that are answered at once.
    /// Returns how many are.
    pub(super) fn shade(&mut self, now: u64, links: &mut Links) -> Result<usize, StreamFault> {
        let mut all = 0;
        while let Some(&(at, parent)) = self.shading.front()
            && at <= now
        {
            self.shading.pop_front();
            let Some(active) = &self.chunks[parent.chunk as usize] else {
                unreachable!("a chunk stays while it has rays")
            };
            let mut answered = 0;
            for &index in active.children(parent.index) {
                let child = ChunkRay { index, ..parent };
                if !links.answer(&active.chunk.ray(index as usize))? {
                    self.ready.push_back(child);
                    continue;
                }
                answered += 1;
                if !active.children(index).is_empty() {
                    self.shading.push_back((now + self.shading_cycles, child));
                }
            }
            self.are_done(parent.chunk, answered);
            all += answered;
        }
        Ok(all)
    }

    /// So many rays of a chunk are done.
    fn are_done(&mut self, chunk: u32, rays: usize) {
        if let Some(active) = &mut self.chunks[chunk as usize] {
            active.left -= rays;
            if active.left == 0 {
                self.chunks[chunk as usize] = None;
            }
        }
    }

    /// Gives out the next ray.
    pub(super) fn give(&mut self) -> Option<ChunkRay> {
        self.ready.pop_front().or_else(|| {
            let (chunk, given) = self.current?;
            let primaries = &self.active(chunk).primaries;
            let (index, more) = (primaries[given], given + 1 < primaries.len());
            self.current = more.then_some((chunk, given + 1));
            Some(ChunkRay { chunk, index })
        })
    }

    /// Whether there is a ray to give out.
    pub(super) fn has_rays(&self) -> bool {
        !self.ready.is_empty() || self.current.is_some()
    }

    /// When the next shading ends.
    pub(super) fn shading_ends(&self) -> Option<u64> {
        self.shading.front().map(|&(at, _)| at)
    }

    /// Takes a ray's results in cycle `now`.
    pub(super) fn take(&mut self, ray: ChunkRay, now: u64) {
        let Some(active) = &self.chunks[ray.chunk as usize] else { unreachable!("a chunk stays while it has rays") };
        if !active.children(ray.index).is_empty() {
            self.shading.push_back((now + self.shading_cycles, ray));
        }
        self.are_done(ray.chunk, 1);
    }

    /// The state of the lists, for the report of a deadlock.
    pub(super) fn queues(&self) -> String {
        format!("ready {}, being shaded {}", self.ready.len(), self.shading.len())
    }
}
