//! Files that configs name.

use std::path::{Path, PathBuf};

use crate::machine::MachineSpec;
use crate::ron_file::{self, ConfigError};

/// Reads a machine's file and checks what single fields cannot.
///
/// # Errors
/// The file cannot be read, is no machine's, or its fields do not fit each other.
pub fn read_machine(path: &Path) -> Result<MachineSpec, ConfigError> {
    let machine: MachineSpec = ron_file::read(path)?;
    machine.check().map_err(|error| ConfigError::Content { path: path.into(), what: error.to_string() })?;
    Ok(machine)
}

/// `named`, seen from the folder of the file that names it.
pub(super) fn beside(file: &Path, named: &Path) -> PathBuf {
    file.parent().unwrap_or(Path::new("")).join(named)
}
