//! What a ray puts off.

/// What a ray comes to later, the next on top. The tree says how high it can get.
pub(crate) struct Stack<'a, R> {
    places: &'a mut [R],
    height: usize,
}

impl<'a, R: Copy> Stack<'a, R> {
    /// An empty stack of so many places.
    #[inline(always)]
    pub(super) fn new(places: &'a mut [R]) -> Self {
        Self { places, height: 0 }
    }

    /// Puts something on top.
    #[inline(always)]
    pub(super) fn push(&mut self, rest: R) {
        self.places[self.height] = rest;
        self.height += 1;
    }

    /// What is on top.
    #[inline(always)]
    pub(super) fn top(&mut self) -> Option<&mut R> {
        self.places.get_mut(self.height.checked_sub(1)?)
    }

    /// Takes away what is on top.
    #[inline(always)]
    pub(super) fn drop_top(&mut self) {
        self.height -= 1;
    }
}
