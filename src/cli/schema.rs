//! `schema`: schema files for editors.

use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Args;

use super::outcome::Outcome;
use super::print::print;
use super::text_file::write;
use crate::fields;

/// Write schema files for editors, for completion and checks
///
/// The files are those of ron2's language server. A config names its type in its first line, as in
/// `#![type = "umbrasim::Machine"]`; the types are Experiment, Machine, Scene, Sweep, DramPart, Pareto, Identities and
/// PaperTable. The server looks in the folder that RON_SCHEMA_DIR names, or in ~/.local/share/ron-schemas.
#[derive(Args)]
pub(super) struct Schema {
    /// The folder that they go to
    #[arg(value_name = "DIR", default_value = "schemas")]
    folder: PathBuf,
}

impl Schema {
    pub(super) fn run(self) -> Result<Outcome> {
        let schemas = fields::schemas();
        for (path, text) in &schemas {
            let path = self.folder.join(path);
            let parent = path.parent().unwrap_or(&self.folder);
            std::fs::create_dir_all(parent).with_context(|| format!("cannot make the folder {}", parent.display()))?;
            write(&path, text)?;
        }
        print(format!("{} schemas in {}", schemas.len(), self.folder.display()))?;
        Ok(Outcome::Done)
    }
}
