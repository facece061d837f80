//! Names: which libraries an OBJ file names, and which materials they define.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use super::map::UvMap;
use super::mtl;
use crate::scene::error::SceneError;
use crate::scene::loader::Loader;
use crate::scene::material::MaterialId;
use crate::scene::text::{Line, shortened, without_comment};

/// A material of a library, and how its picture lies on the surface.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// The material.
    pub id: MaterialId,
    /// From a face's texture coordinates to the picture's.
    pub map: UvMap,
}

impl Entry {
    /// A material whose picture lies as the texture coordinates say.
    pub fn of(id: MaterialId) -> Self {
        Self { id, map: UvMap::default() }
    }
}

/// The materials of one library by name.
///
/// A name can have spaces and `#`, as in `Material #25`, and a comment can follow a name. So the whole text counts first;
/// if nothing has that name, the part before the comment does, if it tells one material from all others.
#[derive(Debug, Default)]
pub struct Materials {
    whole: BTreeMap<String, Entry>,
    /// By the part before the comment; `None` if several materials share it.
    before_comment: BTreeMap<String, Option<Entry>>,
}

impl Materials {
    /// Adds a material; the text is what follows `newmtl`.
    pub fn insert(&mut self, name: &str, entry: Entry) {
        self.whole.insert(name.to_owned(), entry);
        let before_comment = without_comment(name);
        if before_comment != name {
            let found = self.before_comment.entry(before_comment.to_owned());
            found.and_modify(|shared| *shared = None).or_insert(Some(entry));
        }
    }

    /// The material of that name, if there is one.
    pub fn find(&self, name: &str) -> Option<Entry> {
        let [whole, before_comment] = [name, without_comment(name)];
        let exact = |name| self.whole.get(name).copied();
        exact(whole).or_else(|| exact(before_comment)).or_else(|| self.before_comment.get(before_comment).copied()?)
    }

    /// Whether the text after a `newmtl` is taken.
    pub fn contains(&self, name: &str) -> bool {
        self.whole.contains_key(name)
    }
}

/// The libraries of a scene, each read once however often it is named.
#[derive(Debug, Default)]
pub struct Libraries(BTreeMap<PathBuf, Rc<Materials>>);

/// Why a statement `mtllib` fails.
pub enum Failure {
    /// The statement itself is wrong.
    Line(String),
    /// A library is.
    Library(SceneError),
}

impl Libraries {
    /// The libraries that the statement `mtllib` of the file at `obj` names: one whose name may have spaces, or several
    /// names without.
    pub fn named_by(
        &mut self,
        line: &Line<'_>,
        obj: &Path,
        loader: &mut Loader,
    ) -> Result<Vec<Rc<Materials>>, Failure> {
        let before_comment = without_comment(line.rest);
        if before_comment.is_empty() || before_comment.starts_with('#') {
            return Err(Failure::Line("`mtllib` needs the name of a file".into()));
        }
        let whole = [line.rest, before_comment].into_iter().find(|name| beside(obj, name).exists());
        let names: Vec<_> = match whole {
            Some(name) => vec![name],
            None => before_comment.split_ascii_whitespace().collect(),
        };
        names.into_iter().map(|name| self.library(name, &beside(obj, name), loader)).collect()
    }

    fn library(&mut self, name: &str, path: &Path, loader: &mut Loader) -> Result<Rc<Materials>, Failure> {
        let bytes = loader.files.read(path).map_err(|error| {
            Failure::Line(format!("mtllib {:?}: cannot read {}: {error}", shortened(name), path.display()))
        })?;
        let real = path.canonicalize().unwrap_or_else(|_| path.into());
        if let Some(found) = self.0.get(&real) {
            return Ok(found.clone());
        }
        let found = Rc::new(mtl::parse(path, &bytes, loader).map_err(Failure::Library)?);
        self.0.insert(real, found.clone());
        Ok(found)
    }
}

/// The path of a file that another one names. A name with `\` is one of another system if no file is called so.
pub fn beside(file: &Path, name: &str) -> PathBuf {
    let folder = file.parent().unwrap_or(Path::new(""));
    let path = folder.join(name);
    if name.contains('\\') && !path.exists() { folder.join(name.replace('\\', "/")) } else { path }
}
