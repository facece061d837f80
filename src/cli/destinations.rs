//! Where a command's results go, claimed before anything is read.

use std::path::Path;

use anyhow::Result;

use crate::output::{ResultsFolder, claim_file, claim_folder};

/// Claims the files that options name: each must be another one, and none may be read by the command.
pub(super) fn claim_files<'a>(files: impl IntoIterator<Item = (&'static str, Option<&'a Path>)>) -> Result<()> {
    for (option, path) in files {
        if let Some(path) = path {
            claim_file(option, path)?;
        }
    }
    Ok(())
}

/// Claims the folder of a report, which is tried before the work begins.
pub(super) fn results_folder(out: &Path) -> Result<ResultsFolder> {
    claim_folder("--out", out)?;
    Ok(ResultsFolder::claim(out)?)
}
