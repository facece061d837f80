//! Scenes in AFF, the Animated File Format of the BART benchmark for animated ray tracing.
//!
//! Choices where the description leaves the behaviour open:
//! - A triangle can move if it is inside an `x` block, with or without keyframes, or if it is a `tpa`. All others are
//!   static.
//! - File names are relative to the first file's folder; textures may also be in `../textures` beside it.
//! - A file closes the blocks that it opens, and no others.
//! - `hither` is read without effect, since rays have no near plane, and so is `resolution`, which an experiment sets.
//! - Lights are in world space, also inside blocks. Keyframes of an `la` add their translation.
//! - Shapes before the first `f` or `fm` have [`Material::default`](super::Material).
//! - Spheres and cones become triangles as `tessellate` says.

mod animation;
mod builder;
mod lexer;
mod parser;
mod shapes;

use std::path::Path;

use super::error::SceneError;
use super::frame::Scene;
use parser::{Parser, WORLD};

/// Reads the scene whose first file is at `path`. Its name is the file's stem in lower case.
///
/// # Errors
/// [`SceneError::Read`] if the file cannot be read, [`SceneError::Syntax`] with file and line for anything wrong in it
/// or in the files it names, [`SceneError::Content`] for a scene without camera or one that reaches too far from the
/// origin.
pub fn load(path: &Path) -> Result<Scene, SceneError> {
    let mut parser = Parser::new(path.parent().unwrap_or(Path::new("")).into());
    let bytes = parser.builder.loader.files.read(path);
    let bytes = bytes.map_err(|source| SceneError::Read { path: path.into(), source })?;
    parser.parse(path, &bytes, WORLD)?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy().to_lowercase();
    parser.builder.finish(name).map_err(|what| SceneError::Content { path: path.into(), what })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bart_scenes_have_their_animated_transforms() {
        // Number of transforms, number of distinct names, depth of nesting.
        for (file, count, names, depth) in [("kitchen/aff/kitchen.aff", 7, 5, 3), ("robot/aff/Robot.aff", 190, 190, 8)]
        {
            let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/scenes/bart")).join(file);
            let Ok(bytes) = std::fs::read(&path) else {
                println!("skipped: {} is absent", path.display());
                continue;
            };
            let mut parser = Parser::new(path.parent().unwrap().into());
            parser.parse(&path, &bytes, WORLD).unwrap();
            let nodes = &parser.builder.nodes;
            let mut depths = vec![0];
            for node in &nodes[1..] {
                depths.push(depths[node.parent] + 1);
            }
            let distinct: std::collections::BTreeSet<_> = nodes[1..].iter().map(|node| &node.name).collect();
            assert_eq!((nodes.len() - 1, distinct.len(), depths.iter().max()), (count, names, Some(&depth)), "{file}");
        }
    }
}
