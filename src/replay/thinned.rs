//! A share of a stream's rays, for scale models.

use std::sync::Arc;

use crate::engine::{Items, Source};
use crate::random::mix;
use crate::stream::{Chunk, Item, RayKind, Step, StreamError, Totals};

/// Entries of a store that are kept or dropped together at an end of frame: about a line.
const TOGETHER: u32 = 16;

/// One of every `share` pixels of a stream, with all rays of the pixel. Of the steps at an end of frame, one of every
/// `share` lines of entries.
///
/// A hash chooses one pixel of each run of `share` pixels, so that neither rows nor columns of a picture are left out.
#[derive(Clone, Copy)]
pub(crate) struct Thinned<'a> {
    /// The stream.
    pub source: &'a dyn Source,
    /// Pixels in a run, of which one is kept.
    pub share: u64,
}

impl Source for Thinned<'_> {
    fn open(&self, frame: usize) -> Result<Items<'_>, StreamError> {
        let mut thinning = Thinning { share: self.share, pixels: 0, counted: Totals::default() };
        Ok(Box::new(self.source.open(frame)?.filter_map(move |item| match item {
            Ok(item) => thinning.item(item).map(Ok),
            Err(error) => Some(Err(error)),
        })))
    }
}

/// A stream that is being thinned.
struct Thinning {
    share: u64,
    /// Pixels of the frame so far.
    pixels: u64,
    /// Totals of the kept rays.
    counted: Totals,
}

impl Thinning {
    /// The kept part of the next item.
    fn item(&mut self, item: Item) -> Option<Item> {
        match item {
            Item::Frame(_) => {
                (self.pixels, self.counted) = (0, Totals::default());
                Some(item)
            }
            Item::Rays(chunk) => {
                let left = self.chunk(&chunk);
                self.counted.count_chunk(&left);
                (!left.is_empty()).then(|| Item::Rays(Arc::new(left)))
            }
            Item::End { policy, .. } => {
                let left = policy.iter().copied().filter(|&word| self.keeps_step(word));
                let policy: Arc<Vec<u32>> = Arc::new(left.collect());
                self.counted.count_policy(Step::unpack_all(&policy));
                Some(Item::End { policy, totals: self.counted })
            }
        }
    }

    fn chunk(&mut self, chunk: &Chunk) -> Chunk {
        let is_primary = |&ray: &usize| chunk.head(ray).kind == RayKind::Primary;
        let mut left = Chunk::default();
        let mut first = 0;
        while first < chunk.len() {
            let end = (first + 1..chunk.len()).find(is_primary).unwrap_or(chunk.len());
            if self.keeps_pixel() {
                left.extend(chunk, first..end);
            }
            first = end;
        }
        left
    }

    /// Whether the next pixel is kept.
    fn keeps_pixel(&mut self) -> bool {
        let (run, place) = (self.pixels / self.share, self.pixels % self.share);
        self.pixels += 1;
        mix(run) % self.share == place
    }

    /// Whether a packed step of the end of frame is kept.
    fn keeps_step(&self, word: u32) -> bool {
        let entry = Step::unpack(word).and_then(Step::entry);
        let line = entry.map_or(0, |(_, index)| u64::from(index / TOGETHER));
        mix(line).is_multiple_of(self.share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::{LightId, NodeId, PixelId, PrimitiveId};
    use crate::stream::{Decision, FrameInfo, Outcome, RayHead, Store};

    /// A frame of `pixels` pixels, each with a primary and a shadow ray, in chunks of 100 pixels.
    fn frame(pixels: u32) -> Vec<Item> {
        let head = |kind, pixel, parent, outcome| RayHead {
            kind,
            light: LightId(0),
            decision: Decision::Trace,
            outcome,
            pixel: PixelId(pixel),
            parent,
        };
        let mut items = vec![Item::Frame(FrameInfo::default())];
        for first in (0..pixels).step_by(100) {
            let mut chunk = Chunk::default();
            for pixel in first..(first + 100).min(pixels) {
                let hit = Outcome::Hit(PrimitiveId(0));
                chunk.push(head(RayKind::Primary, pixel, 0, hit), &[Step::Node(NodeId(0)).pack()], &[]);
                chunk.push(head(RayKind::Shadow, pixel, 1, Outcome::Lit), &[Step::Node(NodeId(1)).pack()], &[]);
            }
            items.push(Item::Rays(Arc::new(chunk)));
        }
        let end = (0..640).map(|index| Step::Write { store: Store::ModeWord, index }.pack()).collect();
        items.push(Item::End { policy: Arc::new(end), totals: Totals::default() });
        items
    }

    #[test]
    fn one_pixel_of_each_run_is_left_with_its_rays_and_counted() {
        let stream = frame(1000);
        let left: Result<Vec<Item>, _> = Thinned { source: &stream, share: 8 }.open(0).unwrap().collect();
        let left = left.unwrap();
        let pixels: Vec<u32> = left
            .iter()
            .filter_map(|item| if let Item::Rays(chunk) = item { Some(chunk) } else { None })
            .flat_map(|chunk| chunk.rays().map(|ray| ray.head.pixel.0).collect::<Vec<_>>())
            .collect();
        let runs: Vec<u32> = pixels.iter().step_by(2).map(|pixel| pixel / 8).collect();
        assert_eq!(runs, (0..125).collect::<Vec<_>>(), "one of each run of eight");
        assert!(pixels.chunks(2).all(|rays| rays[0] == rays[1]), "a pixel's rays stay together");
        let Some(Item::End { policy, totals }) = left.last() else { panic!("the frame has no end") };
        assert_eq!((totals.primary_rays, totals.shadow_rays, totals.node_visits), (125, 125, 125));
        assert_eq!(totals.policy_writes, policy.len() as u64);
        assert!((2 * 16..10 * 16).contains(&policy.len()) && policy.len() % 16 == 0, "{} of 640", policy.len());
    }

    #[test]
    fn a_share_of_one_is_everything() {
        let stream = frame(10);
        let left: Result<Vec<Item>, _> = Thinned { source: &stream, share: 1 }.open(0).unwrap().collect();
        let left = left.unwrap();
        assert_eq!(left[..2], stream[..2]);
    }
}
