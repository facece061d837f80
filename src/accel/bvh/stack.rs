//! The stack of a ray that walks a tree of boxes.

/// What a ray visits later, the next entry on top. The tree's depth bounds the height.
pub(crate) struct Stack<'a, R> {
    places: &'a mut [R],
    height: usize,
}

impl<'a, R: Copy> Stack<'a, R> {
    /// An empty stack in `places`.
    #[inline(always)]
    pub(super) fn new(places: &'a mut [R]) -> Self {
        Self { places, height: 0 }
    }

    /// Pushes an entry.
    #[inline(always)]
    pub(super) fn push(&mut self, rest: R) {
        self.places[self.height] = rest;
        self.height += 1;
    }

    /// The top entry.
    #[inline(always)]
    pub(super) fn top(&mut self) -> Option<&mut R> {
        self.places.get_mut(self.height.checked_sub(1)?)
    }

    /// Removes the top entry.
    #[inline(always)]
    pub(super) fn drop_top(&mut self) {
        self.height -= 1;
    }
}
