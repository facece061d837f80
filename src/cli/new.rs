//! `new`: a file to start from.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::{Args, ValueEnum};

use super::config_path::config_path;
use super::outcome::Outcome;
use super::print::print;
use super::text_file::write_new;
use crate::experiment::{check_name, scene_around};
use crate::fields::{Root, kind_of};
use crate::ron_file;
use crate::shipped;

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

    /// The kind of the shipped configs, and the one that is copied if none is named.
    fn usual(self) -> (Root, &'static str) {
        match self {
            Self::Machine => (Root::Machine, "small"),
            Self::Experiment => (Root::Experiment, "quickstart"),
            Self::Scene => (Root::Scene, "room"),
            Self::Sweep => (Root::Sweep, "sweep_words"),
        }
    }
}

impl New {
    pub(super) fn run(self) -> Result<Outcome> {
        let what = self.kind.name();
        if self.file.extension().is_none_or(|ending| ending != "ron") {
            bail!(
                "{}: the file's name needs the ending .ron; a file without one would stand for a shipped config",
                self.file.display()
            );
        }
        let (origin, text) = match &self.mesh {
            Some(_) if self.kind != What::Scene => bail!("`--mesh` is of a scene, and this is a {what}"),
            Some(mesh) => self.around(mesh)?,
            None => self.copy()?,
        };
        let article = if what.starts_with(['a', 'e', 'i', 'o', 'u']) { "An" } else { "A" };
        let note = format!("// {article} {what} {origin}. `umbrasim describe {what}` tells all fields.\n");
        // The first line tells the type.
        let typed = format!("#![type = \"umbrasim::{}\"]\n", self.kind.usual().0.type_name());
        let text = text.strip_prefix(&typed).unwrap_or(&text);
        write_new(&self.file, &format!("{typed}{note}{text}"))?;
        print(format!("{}: try it with `umbrasim check {}`", self.file.display(), self.file.display()))?;
        Ok(Outcome::Done)
    }

    /// A copy of a config: a note on its origin, and its text.
    fn copy(&self) -> Result<(String, String)> {
        let (kind, usual) = self.kind.usual();
        let from = config_path(kind, self.from.as_deref().unwrap_or(Path::new(usual)))?;
        let name = self.file.file_stem().and_then(|name| name.to_str());
        let name = name.with_context(|| format!("{} is no name of a file", self.file.display()))?;
        if self.kind == What::Experiment {
            check_name(name).map_err(anyhow::Error::msg).with_context(|| format!("{}", self.file.display()))?;
        }
        let source = from.file_stem().unwrap_or_default().to_string_lossy();
        let text = ron_file::text(&from)?;
        if let Some(found) = kind_of(&text).filter(|&found| found != kind) {
            bail!("`{source}` is of the kind {}: `new {}` cannot start from it", found.name(), kind.name());
        }
        let text = renamed(&standing(&text, &from)?, name)?;
        Ok((format!("that started as `{source}`"), text))
    }

    /// A scene of the file `mesh`: a note on its origin, and its text.
    fn around(&self, mesh: &Path) -> Result<(String, String)> {
        // A file beside the config is given by its name, another by its absolute path.
        let is_beside = mesh.parent() == self.file.parent();
        let named = if is_beside { mesh.file_name().map(PathBuf::from) } else { std::path::absolute(mesh).ok() };
        let named = named.with_context(|| format!("{} is no name of a file", mesh.display()))?;
        let name =
            named.to_str().with_context(|| format!("{} is not UTF-8: a config cannot name it", named.display()))?;
        let text = scene_around(mesh, name)?;
        Ok((format!("of {}", mesh.display()), text))
    }
}

/// `text` with `name` as the config's name, if it has one.
fn renamed(text: &str, name: &str) -> Result<String> {
    let (mut at, mut depth, mut is_name) = (0, 0, false);
    while at < text.len() {
        let part = &text[at..at + length_of_part(&text[at..])];
        if part.starts_with('"') && is_name {
            return Ok(format!("{}{}{}", &text[..at], ron::to_string(name)?, &text[at + part.len()..]));
        }
        if !part.starts_with(['"', '/']) && !part.trim().is_empty() {
            depth += part.matches(['(', '[', '{']).count() as i64 - part.matches([')', ']', '}']).count() as i64;
            let field = part.trim_end().strip_suffix(':').unwrap_or_default().trim_end();
            // The field of the outermost brackets, not one whose name only ends alike.
            is_name = depth == 1 && field.rsplit(|it: char| !it.is_alphanumeric() && it != '_').next() == Some("name");
        }
        at += part.len();
    }
    Ok(text.into())
}

/// Length in bytes of the comment, the string, or the text between these, that `text` begins with.
fn length_of_part(text: &str) -> usize {
    match text {
        _ if text.starts_with("//") => text.find('\n').unwrap_or(text.len()),
        _ if text.starts_with("/*") => text.find("*/").map_or(text.len(), |at| at + 2),
        _ if text.starts_with('"') => length_of_string(text),
        _ => text.char_indices().skip(1).find(|(_, it)| ['"', '/'].contains(it)).map_or(text.len(), |(at, _)| at),
    }
}

/// The `text` of the file `from`, changed so that its files are found from another folder: shipped configs by their
/// names, other files by their absolute paths.
fn standing(text: &str, from: &Path) -> Result<String> {
    let folder = from.parent().unwrap_or(Path::new(""));
    let (mut standing, mut rest) = (String::with_capacity(text.len()), text);
    while !rest.is_empty() {
        let (part, behind) = rest.split_at(length_of_part(rest));
        match ron::from_str::<PathBuf>(part).ok().filter(|_| part.starts_with('"')) {
            Some(named) => standing.push_str(&named_elsewhere(part, &folder.join(named))?),
            None => standing.push_str(part),
        }
        rest = behind;
    }
    Ok(standing)
}

/// Length in bytes of the string that `text` begins with, its quotes included.
fn length_of_string(text: &str) -> usize {
    let mut is_escaped = true;
    let end = text.find(|letter| {
        let ends = letter == '"' && !is_escaped;
        is_escaped = letter == '\\' && !is_escaped;
        ends
    });
    end.map_or(text.len(), |at| at + 1)
}

/// The string, changed so that it names the file `path` from another folder. A string that names no file stays.
fn named_elsewhere(string: &str, path: &Path) -> Result<String> {
    let is_config = path.extension().is_some_and(|ending| ending == "ron");
    let shipped = || shipped::text(path).filter(Result::is_ok).and_then(|_| path.file_stem()?.to_str());
    if let Some(name) = Some(path).filter(|_| is_config).and_then(|_| shipped()) {
        return Ok(ron::to_string(name)?);
    }
    if !is_config && !path.is_file() {
        return Ok(string.to_owned());
    }
    let whole = std::path::absolute(path).with_context(|| format!("cannot find {}", path.display()))?;
    Ok(ron::to_string(&whole)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copy_has_its_own_name_and_names_shipped_configs() {
        let text = "(\n    name: \"small\",\n    dram: (part: \"../dram/lpddr4_3200.ron\"),\n)";
        let from = shipped::path(shipped::Kind::Machine, "small").unwrap();
        let copy = renamed(&standing(text, &from).unwrap(), "mine").unwrap();
        assert_eq!(copy, "(\n    name: \"mine\",\n    dram: (part: \"lpddr4_3200\"),\n)");
        let other = standing(text, Path::new("/there/x.ron")).unwrap();
        assert!(other.contains("\"/there/../dram/lpddr4_3200.ron\""), "{other}");
    }

    #[test]
    fn a_name_is_found_however_the_file_is_laid_out() {
        let renamed = |text: &str| renamed(text, "mine").unwrap();
        assert_eq!(renamed(r#"(name:"a", x: 1)"#), r#"(name:"mine", x: 1)"#);
        assert_eq!(renamed("(\n\tname : \"a\",\n)"), "(\n\tname : \"mine\",\n)");
        let others = r#"(part: (name: "a"), file_name: "b", /* name: */ note: "name: ", // name: "c"
            name: /* its own */ "d")"#;
        assert_eq!(renamed(others), others.replace("\"d\"", "\"mine\""));
        assert_eq!(renamed("(x: \"a\")"), "(x: \"a\")");
    }

    #[test]
    fn files_that_a_copy_names_are_found_from_elsewhere() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("hall \"1\".obj"), "").unwrap();
        let text = r#"Files( // it's "hall
            files: "hall \"1\".obj", sky: "blue", wall: "none.obj", /* " */ a: 1 / 2)"#;
        let moved = standing(text, &folder.path().join("mine.ron")).unwrap();
        let whole = ron::to_string(&folder.path().join("hall \"1\".obj")).unwrap();
        assert_eq!(moved, text.replace("\"hall \\\"1\\\".obj\"", &whole));
    }

    #[test]
    fn a_name_is_written_as_ron() {
        assert_eq!(
            renamed("(\n    name: \"a \\\" b\", c: 1)", "it is \"x\"").unwrap(),
            "(\n    name: \"it is \\\"x\\\"\", c: 1)"
        );
    }
}
