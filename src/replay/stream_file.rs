//! A recorded stream in its file.

use std::path::Path;

use crate::engine::{Items, Source};
use crate::stream::{StreamError, StreamReader};

/// A recorded stream, by the path of its file.
#[derive(Clone, Copy, Debug)]
pub struct StreamFile<'a>(pub &'a Path);

impl Source for StreamFile<'_> {
    fn open(&self, frame: usize) -> Result<Items<'_>, StreamError> {
        let mut reader = StreamReader::open(self.0)?;
        reader.seek_frame(frame)?;
        Ok(Box::new(reader))
    }
}
