//! The configs inside the program itself, so that `umbrasim run quickstart` works in any folder.

use std::io;
use std::path::{Component, Path, PathBuf};

use include_dir::{Dir, include_dir};

static CONFIGS: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/configs");

/// The prefix of shipped configs' paths.
const ROOT: &str = "shipped:";

/// Kinds of configs: the folders of `configs/`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Experiment,
    Machine,
    Scene,
    Dram,
}

impl Kind {
    /// All kinds.
    pub(crate) const ALL: [Self; 4] = [Self::Experiment, Self::Machine, Self::Scene, Self::Dram];

    fn folder(self) -> &'static str {
        match self {
            Self::Experiment => "experiments",
            Self::Machine => "machines",
            Self::Scene => "scenes",
            Self::Dram => "dram",
        }
    }
}

/// Names of the shipped configs of a kind, in alphabetical order.
pub(crate) fn names(kind: Kind) -> Vec<&'static str> {
    let files = CONFIGS.get_dir(kind.folder()).into_iter().flat_map(Dir::files);
    let mut names: Vec<_> = files.filter_map(|file| file.path().file_stem()?.to_str()).collect();
    names.sort_unstable();
    names
}

/// The path by which [`text`] finds the shipped config `name`; `None` if there is none.
pub(crate) fn path(kind: Kind, name: &str) -> Option<PathBuf> {
    names(kind).contains(&name).then(|| Path::new(ROOT).join(kind.folder()).join(format!("{name}.ron")))
}

/// The path of a config that a config in `folder` refers to as `name`: a file relative to `folder`, or a shipped
/// config.
pub(crate) fn named(kind: Kind, folder: &Path, name: &Path) -> PathBuf {
    let there = folder.join(name);
    let plain = name.to_str().filter(|name| is_name(name) && !there.is_file());
    plain.and_then(|name| path(kind, name)).unwrap_or(there)
}

/// Whether a text can be the name of a shipped config, and is not a path.
pub(crate) fn is_name(text: &str) -> bool {
    !text.contains(['.', '/', '\\'])
}

/// The text of the shipped config at `path`; `None` if the path is not in the program.
pub(crate) fn text(path: &Path) -> Option<io::Result<&'static str>> {
    let inside = path.strip_prefix(ROOT).ok()?;
    // Configs refer to each other with `..`, as on a disk.
    let mut plain = PathBuf::new();
    for part in inside.components() {
        match part {
            Component::ParentDir => {
                plain.pop();
            }
            part => plain.push(part),
        }
    }
    let missing = || io::Error::new(io::ErrorKind::NotFound, "the program ships no such config");
    Some(CONFIGS.get_file(plain).and_then(|file| file.contents_utf8()).ok_or_else(missing))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shipped_configs_are_found_by_name_and_name_each_other() {
        assert!(names(Kind::Machine).contains(&"small") && names(Kind::Experiment).contains(&"quickstart"));
        let small = path(Kind::Machine, "small").unwrap();
        assert!(text(&small).unwrap().unwrap().contains("name: \"small\""));
        let part = small.parent().unwrap().join("../dram/lpddr4_3200.ron");
        assert!(text(&part).unwrap().unwrap().contains("LPDDR4"));
        assert_eq!(path(Kind::Machine, "large"), None);
        assert_eq!(text(&small.with_file_name("large.ron")).unwrap().unwrap_err().kind(), io::ErrorKind::NotFound);
        assert!(text(Path::new("configs/machines/small.ron")).is_none());
        let named = |name: &str| named(Kind::Scene, Path::new("there"), Path::new(name));
        assert!(text(&named("room")).is_some_and(|text| text.is_ok()));
        assert_eq!(named("room.ron"), Path::new("there/room.ron"));
    }
}
