//! Waiting rays of a piece, in the order in which the host sends them: first the children of rays that are done, then
//! the next primary ray.

use std::collections::VecDeque;
use std::ops::Range;

use crate::engine::families::Families;
use crate::stream::Chunk;

/// The waiting rays.
pub(super) struct Waiting {
    families: Families,
    /// Index of the piece's first ray in its chunk.
    first: usize,
    next_primary: Option<u32>,
    children: VecDeque<u32>,
}

impl Waiting {
    /// All rays of a piece, which begins with a primary ray.
    pub(super) fn new(chunk: &Chunk, rays: Range<usize>) -> Self {
        let parent = |ray: usize| (ray - rays.start) as u32 - chunk.head(ray).parent;
        let families = Families::new(rays.clone().map(parent));
        Self { families, first: rays.start, next_primary: (!rays.is_empty()).then_some(0), children: VecDeque::new() }
    }

    /// Index of the next ray in the chunk.
    pub(super) fn next(&mut self) -> Option<usize> {
        let Self { families, next_primary, children, .. } = self;
        let next = children.pop_front().or_else(|| {
            let primary = (*next_primary)?;
            *next_primary = families.sibling(primary);
            Some(primary)
        });
        next.map(|ray| self.first + ray as usize)
    }

    /// A ray is done, so its children can begin. Shading takes no time here: with its time, windows predict L2 bytes up
    /// to a quarter worse (kitchen on `desktop` and `tni_engine`).
    pub(super) fn done(&mut self, ray: usize) {
        self.children.extend(self.families.children((ray - self.first) as u32));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::tests::synthetic::{SyntheticRay, frame};
    use crate::stream::{FrameInfo, Item, RayKind};

    #[test]
    fn children_of_rays_that_are_done_come_before_primary_rays() {
        let ray = |kind, parent| SyntheticRay { kind, parent, ..SyntheticRay::primary(Vec::new()) };
        let group =
            [ray(RayKind::Primary, 0), ray(RayKind::Shadow, 1), ray(RayKind::Reflection, 2), ray(RayKind::Shadow, 1)];
        let rays: Vec<SyntheticRay> = [group.clone(), group.clone(), group].concat();
        let items = frame(FrameInfo::default(), &rays, &[], rays.len());
        let Some(Item::Rays(chunk)) = items.get(1) else { panic!("one chunk") };
        // The piece has the last two groups.
        let mut waiting = Waiting::new(chunk, 4..12);
        let mut next = |done: Option<usize>| {
            done.into_iter().for_each(|ray| waiting.done(ray));
            waiting.next()
        };
        assert_eq!([next(None), next(None)], [Some(4), Some(8)]);
        assert_eq!([next(Some(8)), next(Some(4)), next(None)], [Some(9), Some(10), Some(5)]);
        assert_eq!([next(Some(10)), next(Some(6)), next(None), next(None)], [Some(6), Some(11), Some(7), None]);
    }
}
