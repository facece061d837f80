//! The material libraries that OBJ files name.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use super::mtl;
use super::names::{Materials, beside};
use crate::scene::error::SceneError;
use crate::scene::loader::Loader;
use crate::scene::text::{Line, shortened, without_comment};

/// The libraries of a scene, each read once however often it is named.
#[derive(Debug, Default)]
pub(crate) struct Libraries(BTreeMap<PathBuf, Rc<Materials>>);

/// Why a statement `mtllib` fails.
pub(crate) enum Failure {
    /// The statement itself is wrong.
    Line(String),
    /// A library is wrong.
    Library(SceneError),
}

impl Libraries {
    /// The libraries that the statement `mtllib` of the file at `obj` names: one name, which may have spaces, or
    /// several names without spaces.
    pub(crate) fn named_by(
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
