//! The file of `--json`.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use serde::Serialize;

use crate::json;
use crate::output::OutputFile;

/// The file for measurements, if the user wants one. It is created before the work, which would be lost if the file
/// could not be written.
pub(super) struct JsonFile(Option<(PathBuf, OutputFile)>);

impl JsonFile {
    pub(super) fn begin(path: Option<PathBuf>) -> Result<Self> {
        let begin = |path: PathBuf| {
            let file = OutputFile::create(&path).with_context(|| format!("cannot write {}", path.display()))?;
            anyhow::Ok((path, file))
        };
        Ok(Self(path.map(begin).transpose()?))
    }

    /// Whether the measurements go to standard output, where nothing else may go then.
    pub(super) fn is_alone(&self) -> bool {
        self.0.as_ref().is_some_and(|(path, _)| path == Path::new("-"))
    }

    pub(super) fn finish(self, measured: &impl Serialize) -> Result<()> {
        let Some((path, mut file)) = self.0 else { return Ok(()) };
        let text = json::pretty(measured)?;
        file.write_all(text.as_bytes())
            .and_then(|()| file.finish())
            .with_context(|| format!("cannot write {}", path.display()))
    }
}
