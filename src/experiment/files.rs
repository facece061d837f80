//! Files that configs name.

use std::path::{Path, PathBuf};

use super::set::{self, Setting};
use crate::machine::MachineSpec;
use crate::memory::dram::part::DramPart;
use crate::ron_file::{self, ConfigError, Kind};
use crate::shipped;

/// Reads a machine's file and checks how its fields fit together.
///
/// # Errors
/// The file cannot be read, does not describe a machine, or its fields do not fit together.
pub fn read_machine(path: &Path) -> Result<MachineSpec, ConfigError> {
    let machine: MachineSpec = ron_file::read(path)?;
    machine.check().map_err(|error| ConfigError::Content { path: path.into(), what: error.to_string() })?;
    Ok(machine)
}

/// Reads a machine's file and sets some of its fields.
///
/// # Errors
/// As [`read_machine`], or a field does not exist or cannot have the value.
pub(crate) fn machine_with(path: &Path, settings: &[&Setting]) -> Result<MachineSpec, ConfigError> {
    let mut machine = read_machine(path)?;
    for setting in settings {
        let field = setting.path.strip_prefix("machine.").unwrap_or(&setting.path);
        machine = set::field(&machine, field, &setting.value).map_err(|what| not_set(setting, what))?;
        machine.check().map_err(|error| not_set(setting, error.to_string()))?;
    }
    Ok(machine)
}

/// The error of a field that cannot be set.
pub(super) fn not_set(setting: &Setting, what: String) -> ConfigError {
    ConfigError::Content { path: format!("--set {setting}").into(), what }
}

/// Reads the file of a part of DRAM.
///
/// # Errors
/// The file cannot be read, or does not describe a part.
pub(crate) fn read_dram_part(path: &Path) -> Result<DramPart, ConfigError> {
    ron_file::read(path)
}

/// The path of the config that `file` refers to as `name`: relative to the folder of `file`, or the name of a shipped
/// config.
pub(super) fn named(kind: Kind, file: &Path, name: &Path) -> PathBuf {
    shipped::named(kind, file.parent().unwrap_or(Path::new("")), name)
}
