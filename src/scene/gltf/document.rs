//! A glTF file's container and JSON, checked.

use std::path::Path;

use gltf_json::Root;
use gltf_json::validation::Validate;

use crate::scene::loader::Loader;

/// Extensions that change the triangles or their positions: without them the scene would be wrong.
const GEOMETRY: &[&str] = &[
    "KHR_draco_mesh_compression",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
    "KHR_mesh_quantization",
    "EXT_mesh_gpu_instancing",
    "KHR_node_visibility",
    "KHR_animation_pointer",
];
/// The extensions of `GEOMETRY` without a fallback in the file: a file that uses one is refused, even if it does not
/// require it.
const WITHOUT_FALLBACK: &[&str] = &["EXT_mesh_gpu_instancing", "KHR_node_visibility", "KHR_animation_pointer"];
/// Extensions that are read.
const READ: &[&str] = &["KHR_lights_punctual"];

/// The JSON and the binary chunk of the file with these bytes.
pub(super) fn read<'a>(bytes: &'a [u8], path: &Path, loader: &mut Loader) -> Result<(Root, Option<&'a [u8]>), String> {
    let (json, chunk) = if bytes.starts_with(b"glTF") { chunks(bytes)? } else { (bytes, None) };
    let json = json.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(json);
    let mut root = Root::from_slice(json).map_err(|error| format!("not a glTF 2.0 document: {error}"))?;
    if root.asset.version.split('.').next() != Some("2") {
        return Err(format!("it is of glTF version {:?}: 2.0 is read", root.asset.version));
    }
    check_extensions(&root, path, loader)?;
    // The crate refuses every required extension that it does not read itself.
    root.extensions_required.clear();
    let mut first = None;
    root.validate(&root, gltf_json::Path::new, &mut |place, error| {
        first.get_or_insert_with(|| format!("not a valid glTF document: {}: {error}", place()));
    });
    match first {
        Some(what) => Err(what),
        None => Ok((root, chunk)),
    }
}

fn check_extensions(root: &Root, path: &Path, loader: &mut Loader) -> Result<(), String> {
    let required = root.extensions_required.iter().filter(|name| GEOMETRY.contains(&name.as_str()));
    let used = root.extensions_used.iter().filter(|name| WITHOUT_FALLBACK.contains(&name.as_str()));
    if let Some(name) = required.chain(used).next() {
        return Err(format!("it needs the extension {name}, which changes its triangles: it is not read"));
    }
    let all: std::collections::BTreeSet<_> = root.extensions_required.iter().chain(&root.extensions_used).collect();
    for name in all.into_iter().filter(|name| !READ.contains(&name.as_str())) {
        loader.count_without_effect(path, &format!("extension {name}"));
    }
    Ok(())
}

/// JSON and binary chunk of a GLB container (section "GLB File Format Specification").
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    let number = |at: usize| -> Option<usize> {
        let four = bytes.get(at..at.checked_add(4)?)?;
        Some(u32::from_le_bytes(four.try_into().ok()?) as usize)
    };
    if number(4) != Some(2) {
        return Err("it is a GLB container of another version than 2".into());
    }
    let whole = number(8).filter(|length| *length <= bytes.len()).ok_or("its GLB container ends too early")?;
    let (mut json, mut binary, mut at) = (None, None, 12);
    while at < whole {
        let length = number(at).ok_or("a chunk of its GLB container ends too early")?;
        let end = (at + 8).checked_add(length).filter(|end| *end <= whole);
        let end = end.ok_or("a chunk of its GLB container ends too early")?;
        let chunk = &bytes[at + 8..end];
        match &bytes[at + 4..at + 8] {
            b"JSON" if json.is_none() => json = Some(chunk),
            b"BIN\0" if binary.is_none() => binary = Some(chunk),
            // Chunks of other kinds are skipped, as the specification requires.
            _ => {}
        }
        at = end;
    }
    Ok((json.ok_or("its GLB container has no JSON")?, binary))
}

/// A node's number and name, for messages.
pub(super) fn name(root: &Root, index: usize) -> String {
    match root.nodes.get(index).and_then(|node| node.name.as_deref()) {
        Some(name) => format!("{index} ({name:?})"),
        None => index.to_string(),
    }
}
