//! Where the items of a stream come from.

use crate::stream::{Item, StreamError};

/// The items of a stream, in order.
pub type Items<'a> = Box<dyn Iterator<Item = Result<Item, StreamError>> + 'a>;

/// The items of a stream that is read once.
pub(crate) type ItemStream<'a> = dyn Iterator<Item = Result<Item, StreamError>> + 'a;

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
        Ok(from_frame(self, frame))
    }
}

/// A stream in memory.
impl Source for Vec<Item> {
    fn open(&self, frame: usize) -> Result<Items<'_>, StreamError> {
        Ok(from_frame(self, frame))
    }
}

fn from_frame(items: &[Item], frame: usize) -> Items<'_> {
    let mut frames = items.iter().enumerate().filter(|(_, item)| matches!(item, Item::Frame(_)));
    let first = frames.nth(frame).map_or(items.len(), |(at, _)| at);
    Box::new(items[first..].iter().cloned().map(Ok))
}
