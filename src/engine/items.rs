//! Where the items of a stream come from.

use crate::stream::{Item, StreamError};

/// The items of a stream, in order.
pub type Items<'a> = Box<dyn Iterator<Item = Result<Item, StreamError>> + 'a>;

/// A stream that can be read more than once.
pub trait Source {
    /// Begins the stream at one of its frames, counted from 0.
    ///
    /// # Errors
    /// The stream cannot be read.
    fn open(&self, frame: usize) -> Result<Items<'_>, StreamError>;
}

/// A stream in memory.
impl Source for &[Item] {
    fn open(&self, frame: usize) -> Result<Items<'_>, StreamError> {
        let mut frames = self.iter().enumerate().filter(|(_, item)| matches!(item, Item::Frame(_)));
        let first = frames.nth(frame).map_or(self.len(), |(at, _)| at);
        Ok(Box::new(self[first..].iter().cloned().map(Ok)))
    }
}

/// A stream in memory.
impl Source for Vec<Item> {
    fn open(&self, frame: usize) -> Result<Items<'_>, StreamError> {
        self.as_slice().open(frame)
    }
}
