//! Follows symbolic links.

use std::io;
use std::path::{Path, PathBuf};

/// Links that are followed before they count as a circle, as in Linux.
const MAX_LINKS: usize = 40;

/// The path that a write to `path` reaches: follows symbolic links at its end, also a link to nothing.
pub(super) fn follow(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_owned();
    for _ in 0..MAX_LINKS {
        match path.read_link() {
            Ok(target) => path = folder_of(&path).join(target),
            // Not a link, or the path does not exist.
            Err(_) => return Ok(path),
        }
    }
    Err(io::Error::new(io::ErrorKind::InvalidInput, "its symbolic links lead in a circle"))
}

/// Removes `path` if it is a symbolic link. A later write then makes a file in this folder, and the link's target
/// stays unchanged.
pub(crate) fn unlink(path: &Path) -> io::Result<()> {
    match path.read_link() {
        Ok(_) => std::fs::remove_file(path),
        // Not a link, or the path does not exist.
        Err(_) => Ok(()),
    }
}

/// The folder that holds `path`.
pub(super) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    #[test]
    fn links_are_followed_to_their_end() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        symlink("b", at("a")).unwrap();
        symlink(at("c"), at("b")).unwrap();
        assert_eq!(follow(&at("a")).unwrap(), at("c"));
        assert_eq!(follow(Path::new("plain")).unwrap(), Path::new("plain"));
        symlink("circle", at("circle")).unwrap();
        assert!(follow(&at("circle")).unwrap_err().to_string().contains("circle"));
    }
}
