//! Reads the geometry of a Wavefront OBJ file with tobj.
//!
//! tobj gives no line with its errors, takes a polyline of three points for a triangle, fills a missing normal with the
//! one before it, drops a name of an unknown material, and overflows on huge indices. So every line is looked at first:
//! what is wrong is refused with its line, and tobj sees faces only, in groups of one kind.

use std::path::{Path, PathBuf};

use glam::{Vec2, Vec3};

use super::mtl::{self, Library};
use crate::input;
use crate::scene::{Attributes, Geometry, MaterialId, SceneError, Triangle};

/// The triangles of the OBJ file at `path`; its materials and textures are added to `library`, and faces without one get
/// `plain`.
///
/// # Errors
/// A file that cannot be read, a line that is not OBJ, a number that is not finite, an index without its vertex, a
/// material that no library of the file defines, no face at all; and what [`mtl`] refuses.
pub fn read(path: &Path, plain: MaterialId, library: &mut Library) -> Result<Geometry, SceneError> {
    let bytes = input::read(path, input::MAX_SCENE_FILE_BYTES)
        .map_err(|source| SceneError::Read { path: path.to_owned(), source })?;
    parse(path, &bytes, plain, library)
}

/// As [`read`], of the file's bytes.
pub(super) fn parse(
    path: &Path,
    bytes: &[u8],
    plain: MaterialId,
    library: &mut Library,
) -> Result<Geometry, SceneError> {
    let scan = Scan::new(path, bytes, library)?;
    let options = tobj::LoadOptions { triangulate: true, single_index: true, ..Default::default() };
    // The text names no material: they are looked up by group.
    let (models, _) = tobj::load_obj_buf(&mut scan.text.as_bytes(), &options, |_| Ok(Default::default()))
        .map_err(|error| SceneError::Content { path: path.to_owned(), what: error.to_string() })?;

    let mut geometry = Geometry::default();
    for model in &models {
        // The scan names every group by its number.
        let material = model.name.parse().ok().and_then(|group: usize| *scan.groups.get(group)?).unwrap_or(plain);
        append(&mut geometry, &model.mesh, material);
    }
    Ok(geometry)
}

fn append(geometry: &mut Geometry, mesh: &tobj::Mesh, material: MaterialId) {
    let vec3 = |of: &[f32], i: u32| Vec3::from_slice(&of[3 * i as usize..]);
    for corners in mesh.indices.chunks_exact(3) {
        let corners = [corners[0], corners[1], corners[2]];
        let normals = (!mesh.normals.is_empty()).then(|| corners.map(|i| vec3(&mesh.normals, i).normalize_or_zero()));
        let uv = if mesh.texcoords.is_empty() {
            [Vec2::ZERO; 3]
        } else {
            corners.map(|i| Vec2::from_slice(&mesh.texcoords[2 * i as usize..]))
        };
        let triangle = Triangle { v: corners.map(|i| vec3(&mesh.positions, i)) };
        // A normal of length zero says nothing.
        let normals = normals.filter(|normals| normals.iter().all(|normal| *normal != Vec3::ZERO));
        geometry.push(triangle, Attributes { normals, uv, material });
    }
}

/// What the first look at a file gives.
struct Scan {
    /// Vertices and faces for tobj, each group of one material and one kind of corner, named by its number.
    text: String,
    /// The material of each group.
    groups: Vec<Option<MaterialId>>,
}

/// How often vertices, texture coordinates and normals have been seen or asked for, in the order of a corner's indices.
type Counts = [u64; 3];

const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

impl Scan {
    fn new(path: &Path, bytes: &[u8], library: &mut Library) -> Result<Self, SceneError> {
        let mut scan = Self { text: String::with_capacity(bytes.len()), groups: Vec::new() };
        let mut seen: Counts = [0; 3];
        // The largest index of each kind and its line.
        let mut asked: [(u64, usize); 3] = [(0, 0); 3];
        let (mut named, mut material) = (mtl::Names::default(), None);
        // The material and the kind of corner of the group in work.
        let mut group = None;
        let folder = path.parent().map(PathBuf::from).unwrap_or_default();

        for (index, line) in bytes.split(|byte| *byte == b'\n').enumerate() {
            let number = index + 1;
            let wrong = |what: String| SceneError::Syntax { path: path.to_owned(), line: number, what };
            // Names may be in any encoding, numbers are ASCII.
            let line = String::from_utf8_lossy(line);
            let line = line.trim();
            let (word, name) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
            let name = name.trim();
            let rest = name.split('#').next().unwrap_or_default();
            match word {
                "v" | "vt" | "vn" => {
                    let (kind, least) = match word {
                        "v" => (0, 3),
                        "vt" => (1, 2),
                        _ => (2, 3),
                    };
                    let numbers = numbers(rest, least).map_err(wrong)?;
                    if word == "v" && numbers.len() == 4 && numbers[3] != 1.0 {
                        return Err(wrong(format!("a vertex of weight {}: 1 or none is allowed", numbers[3])));
                    }
                    seen[kind] += 1;
                    scan.text.push_str(word);
                    for number in &numbers[..least] {
                        scan.text.push_str(&format!(" {number}"));
                    }
                    scan.text.push('\n');
                }
                "f" => {
                    let corners = corners(rest, seen).map_err(wrong)?;
                    for corner in &corners {
                        for (index, most) in corner.iter().zip(&mut asked) {
                            *most = (*most).max((index.unwrap_or(0), number));
                        }
                    }
                    let kind = (material, corners[0].map(|index| index.is_some()));
                    if group != Some(kind) {
                        group = Some(kind);
                        scan.text.push_str(&format!("g {}\n", scan.groups.len()));
                        scan.groups.push(material);
                    }
                    scan.text.push('f');
                    for [v, vt, vn] in corners {
                        let text = |index: Option<u64>| index.map(|index| index.to_string()).unwrap_or_default();
                        scan.text.push_str(&format!(" {}/{}/{}", text(v), text(vt), text(vn)));
                    }
                    scan.text.push('\n');
                }
                "mtllib" => library.read(&folder.join(name), &mut named)?,
                "usemtl" if named.is_empty() => {}
                "usemtl" => {
                    let id = named.get(name).ok_or_else(|| wrong(format!("no material is named {name:?}")))?;
                    material = Some(*id);
                }
                // Names, smoothing groups, points, lines, curves: nothing that a ray meets.
                _ => {}
            }
        }
        for ((most, line), (count, kind)) in asked.into_iter().zip(seen.into_iter().zip(KINDS)) {
            if most > count {
                let what = format!("{kind} {most} is asked for, and there are {count}");
                return Err(SceneError::Syntax { path: path.to_owned(), line, what });
            }
        }
        if scan.groups.is_empty() {
            return Err(SceneError::Content { path: path.to_owned(), what: "there is no face (`f`) in it".into() });
        }
        Ok(scan)
    }
}

/// The finite numbers of a line, at least `least` of them.
pub(super) fn numbers(text: &str, least: usize) -> Result<Vec<f32>, String> {
    let mut numbers = Vec::new();
    for word in text.split_whitespace() {
        match word.parse::<f32>() {
            Ok(number) if number.is_finite() => numbers.push(number),
            _ => return Err(format!("{word:?} is not a finite number")),
        }
    }
    if numbers.len() < least {
        return Err(format!("{} numbers: at least {least} are needed", numbers.len()));
    }
    Ok(numbers)
}

/// The corners of a face: of each the index of its vertex, texture coordinate and normal, counted from 1. A negative
/// index counts backwards from the last one seen.
fn corners(text: &str, seen: Counts) -> Result<Vec<[Option<u64>; 3]>, String> {
    let mut corners = Vec::new();
    for word in text.split_whitespace() {
        let mut corner = [None; 3];
        let mut parts = word.split('/');
        for ((index, part), count) in corner.iter_mut().zip(&mut parts).zip(seen) {
            if !part.is_empty() {
                let found = part.parse::<i64>().ok().and_then(|asked| match asked.signum() {
                    1 => Some(asked.unsigned_abs()),
                    -1 => (count + 1).checked_sub(asked.unsigned_abs()).filter(|index| *index > 0),
                    _ => None,
                });
                *index = Some(found.ok_or_else(|| format!("{part:?} is not an index of a face's corner"))?);
            }
        }
        if corner[0].is_none() || parts.next().is_some() {
            return Err(format!("{word:?} is not a face's corner: v, v/vt, v//vn or v/vt/vn is"));
        }
        corners.push(corner);
    }
    if corners.len() < 3 {
        return Err(format!("a face of {} corners: at least 3 are needed", corners.len()));
    }
    let kind = |corner: &[Option<u64>; 3]| corner.map(|index| index.is_some());
    if corners.iter().any(|corner| kind(corner) != kind(&corners[0])) {
        return Err("the corners of a face give different kinds of index".into());
    }
    Ok(corners)
}
