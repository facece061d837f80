//! `new`: a file to start from.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::{Args, ValueEnum};

use super::config_path::config_path;
use super::outcome::Outcome;
use super::print::print;
use super::text_file::write_new;
use crate::experiment::scene_around;
use crate::ron_file;
use crate::shipped::{self, Kind};

/// Write a machine, experiment, scene or sweep file to start from
///
/// The file is a copy of a shipped one with its comments: change it, and run it where it is. A file that is there is
/// not overwritten.
#[derive(Args)]
pub(super) struct New {
    /// What it is
    kind: What,
    /// The file to write; its name without .ron becomes the config's own
    #[arg(value_name = "NAME.ron")]
    file: PathBuf,
    /// What it is copied from: a file, or the name of a shipped one [default: small, quickstart, room or sweep_words]
    #[arg(long, value_name = "NAME")]
    from: Option<PathBuf>,
    /// Of a scene: show this OBJ, PLY or glTF file, with a camera that goes round it
    #[arg(long, value_name = "FILE", conflicts_with = "from")]
    mesh: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum What {
    Machine,
    Experiment,
    Scene,
    Sweep,
}

impl What {
    fn name(self) -> &'static str {
        match self {
            Self::Machine => "machine",
            Self::Experiment => "experiment",
            Self::Scene => "scene",
            Self::Sweep => "sweep",
        }
    }

    /// Where shipped ones are, and which of them is copied if none is named.
    fn usual(self) -> (Kind, &'static str) {
        match self {
            Self::Machine => (Kind::Machine, "small"),
            Self::Experiment => (Kind::Experiment, "quickstart"),
            Self::Scene => (Kind::Scene, "room"),
            Self::Sweep => (Kind::Experiment, "sweep_words"),
        }
    }
}

impl New {
    pub(super) fn run(self) -> Result<Outcome> {
        let what = self.kind.name();
        let (origin, text) = match &self.mesh {
            Some(_) if self.kind != What::Scene => bail!("`--mesh` is of a scene, and this is a {what}"),
            Some(mesh) => self.around(mesh)?,
            None => self.copy()?,
        };
        let head = format!("// A {what} {origin}. `umbrasim describe {what}` tells all fields.\n");
        write_new(&self.file, &(head + &text))?;
        print(format!("{}: try it with `umbrasim check {}`", self.file.display(), self.file.display()))?;
        Ok(Outcome::Done)
    }

    /// A copy of a config: where it comes from, and its text.
    fn copy(&self) -> Result<(String, String)> {
        let (kind, usual) = self.kind.usual();
        let from = config_path(kind, self.from.as_deref().unwrap_or(Path::new(usual)))?;
        let name = self.file.file_stem().and_then(|name| name.to_str());
        let name = name.with_context(|| format!("{} is no name of a file", self.file.display()))?;
        let source = from.file_stem().unwrap_or_default().to_string_lossy();
        let text = renamed(&standing(&ron_file::text(&from)?, &from)?, name);
        Ok((format!("that started as `{source}`"), text))
    }

    /// A scene of the file `mesh`: where it comes from, and its text.
    fn around(&self, mesh: &Path) -> Result<(String, String)> {
        // Beside the config by its name, elsewhere by its whole path.
        let is_beside = mesh.parent() == self.file.parent();
        let named = if is_beside { mesh.file_name().map(PathBuf::from) } else { std::path::absolute(mesh).ok() };
        let named = named.with_context(|| format!("{} is no name of a file", mesh.display()))?;
        let text = scene_around(mesh, &named.to_string_lossy())?;
        Ok((format!("of {}", mesh.display()), text))
    }
}

/// `text` with `name` as the config's name, if it has one.
fn renamed(text: &str, name: &str) -> String {
    let Some(begin) = text.find("\n    name: \"").map(|at| at + "\n    name: \"".len()) else { return text.into() };
    let end = text[begin..].find('"').map_or(begin, |length| begin + length);
    format!("{}{name}{}", &text[..begin], &text[end..])
}

/// `text`, which stands in the file `from`, so that it can stand elsewhere: shipped configs are named by their names,
/// other files by their whole paths.
fn standing(text: &str, from: &Path) -> Result<String> {
    let folder = from.parent().unwrap_or(Path::new(""));
    let parts: Vec<&str> = text.split('"').collect();
    let named = |(at, part): (usize, &&str)| {
        if at % 2 == 0 || !part.ends_with(".ron") {
            return Ok((*part).to_owned());
        }
        let path = folder.join(part);
        let shipped = shipped::text(&path).filter(Result::is_ok).and_then(|_| path.file_stem()?.to_str());
        if let Some(name) = shipped {
            return Ok(name.to_owned());
        }
        let whole = std::path::absolute(&path).with_context(|| format!("cannot find {}", path.display()))?;
        Ok(whole.display().to_string())
    };
    Ok(parts.iter().enumerate().map(named).collect::<Result<Vec<_>>>()?.join("\""))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copy_has_its_own_name_and_names_shipped_configs() {
        let text = "(\n    name: \"small\",\n    dram: (part: \"../dram/lpddr4_3200.ron\"),\n)";
        let from = shipped::path(Kind::Machine, "small").unwrap();
        let copy = renamed(&standing(text, &from).unwrap(), "mine");
        assert_eq!(copy, "(\n    name: \"mine\",\n    dram: (part: \"lpddr4_3200\"),\n)");
        let other = standing(text, Path::new("/there/x.ron")).unwrap();
        assert!(other.contains("\"/there/../dram/lpddr4_3200.ron\""), "{other}");
    }
}
