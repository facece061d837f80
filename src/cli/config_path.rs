//! Configs on the command line: files, or names of shipped configs.

use std::path::{Path, PathBuf};

use anyhow::{Error, Result, anyhow, bail};

use crate::alike;
use crate::fields::{Root, kind_of};
use crate::ron_file;
use crate::shipped::{self, Kind};

/// The names at the top of a report's `config.ron`.
const RECORDED: [&str; 3] = ["experiment", "scene", "machines"];

/// The path of the config that `argument` names: a file, or the shipped config of that name. A folder of that name does
/// not count.
///
/// # Errors
/// `argument` looks like a name, and there is neither a file nor a shipped config of that kind and name.
pub(super) fn config_path(kind: Root, argument: &Path) -> Result<PathBuf> {
    let name = argument.to_str().filter(|text| shipped::is_name(text));
    let Some(name) = name.filter(|_| !argument.is_file()) else { return Ok(argument.into()) };
    let folder = match kind {
        Root::Machine => Kind::Machine,
        Root::Scene => Kind::Scene,
        Root::Dram => Kind::Dram,
        Root::Experiment | Root::Sweep | Root::Pareto | Root::Identities | Root::PaperTable => Kind::Experiment,
    };
    if let Some(path) = shipped::path(folder, name) {
        return Ok(path);
    }
    if let Some(path) = Kind::ALL.into_iter().find_map(|kind| shipped::path(kind, name)) {
        return Err(other_kind(&path, kind).unwrap_or_else(|| anyhow!("`{name}` is no {}", kind.title())));
    }
    let is_of_kind = |name: &&str| {
        let text = shipped::path(folder, name).and_then(|path| ron_file::text(&path).ok());
        text.and_then(|text| kind_of(&text)) == Some(kind)
    };
    let names: Vec<&str> = shipped::names(folder).into_iter().filter(is_of_kind).collect();
    let proposal = alike::closest(name, &names).map(|other| format!("; did you mean `{other}`?")).unwrap_or_default();
    let known = names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    bail!("there is no file and no shipped {} `{name}`{proposal}\nshipped ones: {known}", kind.short())
}

/// The path of the config of any kind that `argument` names: a file, or the first shipped config of that name.
///
/// # Errors
/// See [`config_path`].
pub(super) fn any_config_path(argument: &Path) -> Result<PathBuf> {
    let name = argument.to_str().filter(|text| shipped::is_name(text) && !argument.is_file());
    let Some(name) = name else { return Ok(argument.into()) };
    let shipped = Kind::ALL.into_iter().find_map(|kind| shipped::path(kind, name));
    shipped.ok_or_else(|| {
        let names: Vec<&str> = Kind::ALL.into_iter().flat_map(shipped::names).collect();
        let proposal = alike::closest(name, &names).map(|other| format!("; did you mean `{other}`?"));
        anyhow!("there is no file and no shipped config `{name}`{}", proposal.unwrap_or_default())
    })
}

/// `error`, unless the config is of another kind than `expected`: then an error that says so.
pub(super) fn or_other_kind(error: impl Into<Error>, path: &Path, expected: Root) -> Error {
    other_kind(path, expected).unwrap_or_else(|| error.into())
}

/// The error of the file of a report that tells what was run; none of other files.
pub(super) fn record(path: &Path, text: &str) -> Option<Error> {
    (ron_file::top_names(text) == RECORDED).then(|| {
        let path = path.display();
        anyhow!("{path} is a report's record of what was run, which no command runs: run the experiment's own file")
    })
}

/// The error of a config that is of another kind than `expected`; `None` if it is of that kind or of an unknown one.
pub(super) fn other_kind(path: &Path, expected: Root) -> Option<Error> {
    let text = ron_file::text(path).ok()?;
    if let Some(record) = record(path, &text) {
        return Some(record);
    }
    let kind = kind_of(&text).filter(|kind| *kind != expected)?;
    // A shipped config is named by its name.
    let shown = if shipped::text(path).is_some() { Path::new(path.file_stem()?) } else { path };
    let shown = shown.display();
    let option = match kind {
        Root::Machine => format!(": use --machine {shown}"),
        Root::Experiment => format!(": use umbrasim run {shown}"),
        Root::Scene => ", which an experiment names as its `scene`".into(),
        Root::Sweep => format!(": use umbrasim sweep {shown}"),
        Root::Pareto => format!(": use umbrasim pareto {shown}"),
        Root::Identities => format!(": use umbrasim identities {shown}"),
        Root::PaperTable => format!(": use umbrasim paper-table {shown}"),
        Root::Dram => ", which a machine names as its `dram.part`".into(),
    };
    Some(anyhow!("{shown} is {}{option}; {} is needed here", kind.title(), expected.title()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_a_shipped_config_or_an_error_with_a_proposal() {
        let path = config_path(Root::Experiment, Path::new("quickstart")).unwrap();
        assert!(shipped::text(&path).is_some());
        let error = config_path(Root::Machine, Path::new("smal")).unwrap_err().to_string();
        assert!(error.contains("no shipped machine `smal`; did you mean `small`?\nshipped ones: "), "{error}");
        assert!(!config_path(Root::Machine, Path::new("qqq")).unwrap_err().to_string().contains("did you mean"));
        let error = any_config_path(Path::new("quickstrt")).unwrap_err().to_string();
        assert_eq!(error, "there is no file and no shipped config `quickstrt`; did you mean `quickstart`?");
        let file = Path::new("no/such/file.ron");
        assert_eq!(config_path(Root::Machine, file).unwrap(), file, "a path is left to who reads it");
    }
}
