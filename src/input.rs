//! Reads the user's files: the only place that does. It accepts only regular files, each up to a largest size.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use xxhash_rust::xxh3::xxh3_128;

use crate::output::claims::refuse_output;

/// The largest config (RON file), in bytes.
pub(crate) const MAX_CONFIG_BYTES: u64 = 1 << 24;
/// The largest file of a scene, in bytes; the largest of the BART scenes has 3.3 MB.
pub(crate) const MAX_SCENE_FILE_BYTES: u64 = 1 << 28;

/// The largest file of a report, in bytes.
pub(crate) const MAX_REPORT_FILE_BYTES: u64 = 1 << 28;

/// The largest sum of the sizes of a scene's files, in bytes.
const MAX_SCENE_BYTES: u64 = 1 << 30;

/// Opens the regular file at `path`.
///
/// # Errors
/// The path is missing, not readable, or an output of the command; or it is a folder, pipe or device, whose end may
/// never come.
pub(crate) fn open(path: &Path) -> io::Result<File> {
    // The kind is checked before the file is opened, since opening a pipe waits for its writer.
    check_regular(&path.metadata()?)?;
    let file = File::open(path)?;
    // Another file may have taken the name in the meantime.
    check_regular(&file.metadata()?)?;
    refuse_output(&file)?;
    Ok(file)
}

/// Reads the bytes of the regular file at `path`, at most `most` of them.
///
/// # Errors
/// As [`open`], or the file is larger than `most`.
pub(crate) fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let file = open(path)?;
    let mut bytes = Vec::new();
    let told = file.metadata()?.len();
    if told <= most {
        // Some files report a length of 0 and have bytes: reading one byte more than allowed shows an excess.
        file.take(most + 1).read_to_end(&mut bytes)?;
    }
    let length = told.max(bytes.len() as u64);
    if length > most {
        return Err(refused(format!("the file has {length} bytes: at most {most} are allowed")));
    }
    Ok(bytes)
}

/// Reads the text of the regular file at `path`, at most `most` bytes, without a byte order mark.
///
/// # Errors
/// As [`read`], or the bytes are not UTF-8; the error names the line.
pub(crate) fn read_text(path: &Path, most: u64) -> io::Result<String> {
    let text = String::from_utf8(read(path, most)?).map_err(|error| {
        let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = valid.iter().filter(|&&byte| byte == b'\n').count() + 1;
        refused(format!("line {line} is not UTF-8 text"))
    })?;
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}

fn check_regular(metadata: &std::fs::Metadata) -> io::Result<()> {
    if metadata.is_file() {
        return Ok(());
    }
    let kind = if metadata.is_dir() { "a folder" } else { "a pipe or a device" };
    Err(refused(format!("{kind}: a regular file is needed")))
}

fn refused(what: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, what)
}

/// A file that was read, and the hash of its bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// The path by which the file was first read.
    pub path: PathBuf,
    /// XXH3 (128 bits) of the file's bytes.
    pub hash: u128,
}

/// The files of one scene. Each is read once and kept, however often it is named.
#[derive(Debug, Default)]
pub(crate) struct Files {
    /// Bytes, by canonical path.
    held: BTreeMap<PathBuf, Rc<[u8]>>,
    sources: Vec<Source>,
    bytes: u64,
}

impl Files {
    /// Reads the file at `path`, or returns its bytes if they are kept.
    ///
    /// # Errors
    /// As [`read`] with [`MAX_SCENE_FILE_BYTES`], or all files together are too large.
    pub(crate) fn read(&mut self, path: &Path) -> io::Result<Rc<[u8]>> {
        let real = path.canonicalize()?;
        if let Some(bytes) = self.held.get(&real) {
            return Ok(bytes.clone());
        }
        let bytes: Rc<[u8]> = read(path, MAX_SCENE_FILE_BYTES)?.into();
        self.bytes += bytes.len() as u64;
        if self.bytes > MAX_SCENE_BYTES {
            let sum = self.bytes;
            return Err(refused(format!(
                "with it the scene's files have {sum} bytes: at most {MAX_SCENE_BYTES} are allowed"
            )));
        }
        self.sources.push(Source { path: path.into(), hash: xxh3_128(&bytes) });
        self.held.insert(real, bytes.clone());
        Ok(bytes)
    }

    /// The files that were read, in the order of their first use.
    pub(crate) fn into_sources(self) -> Vec<Source> {
        self.sources
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_regular_files_are_read() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a");
        std::fs::write(&path, b"\xF6 text").unwrap();
        assert_eq!(read(&path, 6).unwrap(), b"\xF6 text");
        assert!(read(&path, 5).unwrap_err().to_string().contains("6 bytes: at most 5"));
        assert!(read(dir.path(), 9).unwrap_err().to_string().contains("a folder"));
        assert_eq!(read(&dir.path().join("missing"), 9).unwrap_err().kind(), io::ErrorKind::NotFound);
        let large = File::create(dir.path().join("large")).unwrap();
        large.set_len(1 << 40).unwrap();
        assert!(read(&dir.path().join("large"), 1 << 20).unwrap_err().to_string().contains("at most 1048576"));
    }

    #[cfg(unix)]
    #[test]
    fn pipes_and_devices_are_refused_without_waiting() {
        let dir = tempfile::tempdir().unwrap();
        let pipe = dir.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        for path in [pipe.as_path(), Path::new("/dev/zero")] {
            assert!(open(path).unwrap_err().to_string().contains("a regular file is needed"), "{path:?}");
        }
    }

    #[test]
    fn text_has_no_byte_order_mark_and_is_utf8() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a");
        std::fs::write(&path, "\u{feff}text").unwrap();
        assert_eq!(read_text(&path, 100).unwrap(), "text");
        std::fs::write(&path, b"a\nb\n\xFF").unwrap();
        assert_eq!(read_text(&path, 100).unwrap_err().to_string(), "line 3 is not UTF-8 text");
    }

    #[test]
    fn a_file_is_held_once_whatever_its_name() {
        let dir = tempfile::tempdir().unwrap();
        std::fs::write(dir.path().join("a"), b"bytes").unwrap();
        let mut files = Files::default();
        let first = files.read(&dir.path().join("a")).unwrap();
        let again = files.read(&dir.path().join("./a")).unwrap();
        assert!(Rc::ptr_eq(&first, &again));
        let sources = files.into_sources();
        assert_eq!((sources.len(), sources[0].hash), (1, xxh3_128(b"bytes")));
    }
}
