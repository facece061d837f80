//! Names of materials and of files.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::map::UvMap;
use crate::scene::material::MaterialId;
use crate::scene::text::without_comment;

/// A material of a library, and how its picture lies on the surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    /// The material.
    pub id: MaterialId,
    /// From a face's texture coordinates to the picture's.
    pub map: UvMap,
}

impl Entry {
    /// A material whose picture takes the texture coordinates unchanged.
    pub(crate) fn of(id: MaterialId) -> Self {
        Self { id, map: UvMap::default() }
    }
}

/// The materials of one library by name.
///
/// A name can have spaces and `#`, as in `Material #25`, and a comment can follow a name. So the whole text is looked
/// up first. If no material has that name, the part before the comment is looked up; it must identify one material.
#[derive(Debug, Default)]
pub(crate) struct Materials {
    whole: BTreeMap<String, Entry>,
    /// By the part before the comment; `None` if several materials share it.
    before_comment: BTreeMap<String, Option<Entry>>,
}

impl Materials {
    /// Adds a material; the text is what follows `newmtl`.
    pub(crate) fn insert(&mut self, name: &str, entry: Entry) {
        self.whole.insert(name.to_owned(), entry);
        let before_comment = without_comment(name);
        if before_comment != name {
            let found = self.before_comment.entry(before_comment.to_owned());
            found.and_modify(|shared| *shared = None).or_insert(Some(entry));
        }
    }

    /// The material of that name, if there is one.
    pub(crate) fn find(&self, name: &str) -> Option<Entry> {
        let [whole, before_comment] = [name, without_comment(name)];
        let exact = |name| self.whole.get(name).copied();
        exact(whole).or_else(|| exact(before_comment)).or_else(|| self.before_comment.get(before_comment).copied()?)
    }

    /// Whether a material has this whole text as its name.
    pub(crate) fn contains(&self, name: &str) -> bool {
        self.whole.contains_key(name)
    }
}

/// The path of a file that `file` names. If no file has a name with `\`, each `\` is taken as `/`.
pub(super) fn beside(file: &Path, name: &str) -> PathBuf {
    let folder = file.parent().unwrap_or(Path::new(""));
    let path = folder.join(name);
    if name.contains('\\') && !path.exists() { folder.join(name.replace('\\', "/")) } else { path }
}
