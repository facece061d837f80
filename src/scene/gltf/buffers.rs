//! The buffers of a glTF file: the bytes of its accessors and pictures.

use std::path::{Path, PathBuf};
use std::rc::Rc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf_json::Root;

use crate::scene::loader::Loader;
use crate::scene::text::shortened;

/// The bytes of all buffers of a file.
pub(super) struct Buffers {
    buffers: Vec<Rc<[u8]>>,
}

impl Buffers {
    /// Reads the buffers from files and data URIs, and the first one of a GLB container from its binary chunk.
    pub(super) fn read(root: &Root, chunk: Option<&[u8]>, path: &Path, loader: &mut Loader) -> Result<Self, String> {
        let mut buffers = Vec::new();
        for (index, buffer) in root.buffers.iter().enumerate() {
            let bytes: Rc<[u8]> = match (&buffer.uri, chunk) {
                (Some(uri), _) => match data(uri) {
                    Some(bytes) => bytes.map_err(|what| format!("buffer {index}: {what}"))?.into(),
                    None => {
                        let file = beside(path, uri).map_err(|what| format!("buffer {index}: {what}"))?;
                        loader
                            .files
                            .read(&file)
                            .map_err(|error| format!("buffer {index}: cannot read {}: {error}", file.display()))?
                    }
                },
                (None, Some(chunk)) if index == 0 => chunk.into(),
                (None, _) => return Err(format!("buffer {index} has no URI")),
            };
            let told = buffer.byte_length.0;
            if (bytes.len() as u64) < told {
                return Err(format!("buffer {index} has {} bytes: {told} are told", bytes.len()));
            }
            buffers.push(bytes);
        }
        Ok(Self { buffers })
    }

    /// Number of bytes of all buffers.
    pub(super) fn size(&self) -> usize {
        self.buffers.iter().map(|buffer| buffer.len()).sum()
    }

    /// The bytes of a buffer view.
    pub(super) fn view(&self, root: &Root, index: usize) -> Result<&[u8], String> {
        let outside = || format!("buffer view {index} is not within its buffer");
        let view = root.buffer_views.get(index).ok_or_else(outside)?;
        let buffer = self.buffers.get(view.buffer.value()).ok_or_else(outside)?;
        let start = usize::try_from(view.byte_offset.map_or(0, |offset| offset.0)).map_err(|_| outside())?;
        let length = usize::try_from(view.byte_length.0).map_err(|_| outside())?;
        start.checked_add(length).and_then(|end| buffer.get(start..end)).ok_or_else(outside)
    }
}

/// The bytes of a data URI (RFC 2397, base64 as glTF asks), `None` for another URI.
pub(super) fn data(uri: &str) -> Option<Result<Vec<u8>, String>> {
    let rest = uri.strip_prefix("data:")?;
    let Some((_, text)) = rest.split_once(";base64,") else {
        return Some(Err(format!("the data URI {:?} is not base64", shortened(uri))));
    };
    Some(STANDARD.decode(text).map_err(|error| format!("its data URI is not base64: {error}")))
}

/// The path of the file that a relative URI names, from the folder of `path`; escapes such as `%20` are decoded.
pub(super) fn beside(path: &Path, uri: &str) -> Result<PathBuf, String> {
    // A single letter before a colon is a drive, not a scheme; it is no relative URI either.
    if uri.split(['/', '?', '#']).next().is_some_and(|first| first.contains(':')) {
        return Err(format!("the URI {:?} is not relative to the file", shortened(uri)));
    }
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        let hex = |digit: u8| char::from(digit).to_digit(16);
        let escaped = match tail {
            [high, low, ..] if *first == b'%' => hex(*high).zip(hex(*low)).map(|(high, low)| (16 * high + low) as u8),
            _ => None,
        };
        bytes.push(escaped.unwrap_or(*first));
        rest = if escaped.is_some() { &tail[2..] } else { tail };
    }
    let name = String::from_utf8(bytes).map_err(|_| format!("the URI {:?} is not UTF-8", shortened(uri)))?;
    Ok(path.parent().unwrap_or(Path::new("")).join(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uris_are_data_or_files_beside() {
        assert_eq!(data("data:application/octet-stream;base64,AQI="), Some(Ok(vec![1, 2])));
        assert!(data("data:text/plain,a").unwrap().is_err());
        assert!(data("data:;base64,?").unwrap().is_err());
        assert_eq!(data("a.bin"), None);
        assert_eq!(beside(Path::new("x/a.gltf"), "b%20c%.bin"), Ok("x/b c%.bin".into()));
        assert!(beside(Path::new("a.gltf"), "https://a/b.bin").is_err());
        assert!(beside(Path::new("a.gltf"), "%ff.bin").is_err());
    }
}
