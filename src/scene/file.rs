//! Reading a scene's files whole, with a bound on their size.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// The largest file that a scene may consist of, in bytes; the largest of the BART scenes has 3.3 MB.
pub const MAX_FILE_BYTES: u64 = 1 << 28;

/// The bytes of the regular file at `path`. Devices, pipes and files above [`MAX_FILE_BYTES`] are errors: their end
/// may never come.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    let refuse = |what: String| Err(io::Error::new(io::ErrorKind::InvalidInput, what));
    // Asked before opening: opening a pipe waits for its writer.
    let metadata = path.metadata()?;
    if !metadata.is_file() {
        return refuse("not a regular file".into());
    }
    if metadata.len() > MAX_FILE_BYTES {
        return refuse(format!("{} bytes: at most {MAX_FILE_BYTES} are allowed", metadata.len()));
    }
    let mut bytes = Vec::new();
    File::open(path)?.take(MAX_FILE_BYTES).read_to_end(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_regular_files_are_read() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a");
        std::fs::write(&path, b"\xF6 text").unwrap();
        assert_eq!(read(&path).unwrap(), b"\xF6 text");
        assert!(read(dir.path()).is_err());
        assert!(read(&dir.path().join("missing")).is_err());
        let large = File::create(dir.path().join("large")).unwrap();
        large.set_len(MAX_FILE_BYTES + 1).unwrap();
        assert!(read(&dir.path().join("large")).unwrap_err().to_string().contains("at most"));
    }
}
