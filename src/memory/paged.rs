//! Values by line number. Memory: 64 values for each touched page, and 8 bytes for each page up to the largest line.

/// Values in a page.
const PAGE: usize = 64;

/// A value for each line; untouched lines have the value `empty`.
#[derive(Clone, Debug)]
pub(crate) struct Paged<T> {
    pages: Vec<Option<Box<[T; PAGE]>>>,
    empty: T,
}

impl<T: Copy> Paged<T> {
    /// An array in which no line has a value.
    pub(crate) fn new(empty: T) -> Self {
        Self { pages: Vec::new(), empty }
    }

    /// The mutable value of a line.
    #[inline]
    pub(crate) fn at(&mut self, line: usize) -> &mut T {
        let page = line / PAGE;
        if page >= self.pages.len() {
            self.pages.resize_with(page + 1, || None);
        }
        &mut self.pages[page].get_or_insert_with(|| Box::new([self.empty; PAGE]))[line % PAGE]
    }

    /// Lines on touched pages from `first` on, with their mutable values.
    pub(crate) fn from(&mut self, first: usize) -> impl Iterator<Item = (usize, &mut T)> {
        let pages = self.pages.iter_mut().enumerate().skip(first / PAGE);
        let values = pages.filter_map(|(number, page)| page.as_mut().map(|page| (number, page)));
        let lines = values.flat_map(|(number, page)| {
            page.iter_mut().enumerate().map(move |(line, value)| (number * PAGE + line, value))
        });
        lines.filter(move |&(line, _)| line >= first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_stay_with_their_lines() {
        let mut paged = Paged::new(0u32);
        let far = 1 << 24;
        for line in [3, 64, far] {
            *paged.at(line) += line as u32;
        }
        assert_eq!((*paged.at(3), *paged.at(4), *paged.at(64), *paged.at(far)), (3, 0, 64, 1 << 24));
        let found = |first| {
            let touched = paged.clone().from(first).filter(|(_, value)| **value > 0).map(|(line, _)| line).collect();
            let touched: Vec<usize> = touched;
            touched
        };
        assert_eq!((found(0), found(4), found(far)), (vec![3, 64, far], vec![64, far], vec![far]));
        assert_eq!(paged.pages.iter().flatten().count(), 3);
    }
}
