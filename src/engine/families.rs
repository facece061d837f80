//! Links between the rays of a chunk: from a primary ray to the next, and from a ray to its children.

/// No ray.
const NONE: u32 = u32::MAX;

/// The links of a chunk's rays, or of a part of a chunk that begins with a primary ray; rays are named by index.
#[derive(Clone, Debug)]
pub(crate) struct Families {
    first_child: Vec<u32>,
    /// For a primary ray, the next primary ray; for any other ray, the next child of the same parent.
    next_sibling: Vec<u32>,
}

impl Families {
    /// Takes the parent of each ray, in order; a primary ray is its own parent.
    pub(crate) fn new(parents: impl DoubleEndedIterator<Item = u32> + ExactSizeIterator) -> Self {
        let (mut first_child, mut next_sibling) = (vec![NONE; parents.len()], vec![NONE; parents.len()]);
        let mut next_primary = NONE;
        for (ray, parent) in (0..parents.len() as u32).zip(parents).rev() {
            let first = if parent == ray { &mut next_primary } else { &mut first_child[parent as usize] };
            next_sibling[ray as usize] = std::mem::replace(first, ray);
        }
        Self { first_child, next_sibling }
    }

    /// The next primary ray, or the next child of the same parent.
    #[inline]
    pub(crate) fn sibling(&self, ray: u32) -> Option<u32> {
        some(self.next_sibling[ray as usize])
    }

    /// The children of a ray, in order.
    #[inline]
    pub(crate) fn children(&self, ray: u32) -> impl Iterator<Item = u32> {
        std::iter::successors(some(self.first_child[ray as usize]), |&child| self.sibling(child))
    }

    /// Whether a ray has children.
    #[inline]
    pub(crate) fn has_children(&self, ray: u32) -> bool {
        self.first_child[ray as usize] != NONE
    }
}

fn some(ray: u32) -> Option<u32> {
    (ray != NONE).then_some(ray)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn siblings_are_in_order() {
        // Two groups; the second ray of the first has a child of its own.
        let families = Families::new([0, 0, 1, 0, 4, 4].into_iter());
        let children = |ray: u32| families.children(ray).collect::<Vec<_>>();
        assert_eq!([0, 1, 2, 4].map(children), [vec![1, 3], vec![2], vec![], vec![5]]);
        assert_eq!([0, 4].map(|ray| families.sibling(ray)), [Some(4), None], "the next primary ray");
        assert!(families.has_children(1) && !families.has_children(3));
    }
}
