//! Files of text that commands write.

use std::io::Write;
use std::path::Path;

use anyhow::{Context, Result, bail};

use crate::output::OutputFile;

/// Writes `text` to the file at `path` and replaces an existing file.
pub(super) fn write(path: &Path, text: &str) -> Result<()> {
    let file = OutputFile::create(path).and_then(|mut file| {
        file.write_all(text.as_bytes())?;
        file.finish()
    });
    file.with_context(|| format!("cannot write {}", path.display()))
}

/// Writes `text` to a new file at `path`.
///
/// # Errors
/// The file exists: a user's file is never overwritten.
pub(super) fn write_new(path: &Path, text: &str) -> Result<()> {
    if path.symlink_metadata().is_ok() {
        bail!(
            "{} is there already: it is not overwritten; another name, or no file of that name, is needed",
            path.display()
        );
    }
    write(path, text)
}
