//! Where a command's results go, claimed before anything is read.

use std::path::Path;

use anyhow::Result;

use crate::output::{ResultsFolder, claim_file, claim_folder};

/// Claims the files that options name: all must differ, and the command may read none of them.
pub(super) fn claim_files<'a>(files: impl IntoIterator<Item = (&'static str, Option<&'a Path>)>) -> Result<()> {
    for (option, path) in files {
        if let Some(path) = path {
            claim_file(option, path)?;
        }
    }
    Ok(())
}

/// Claims the folder of a report, and checks before the work begins that it can be written.
pub(super) fn results_folder(out: &Path) -> Result<ResultsFolder> {
    claim_folder("--out", out)?;
    Ok(ResultsFolder::claim(out)?)
}
