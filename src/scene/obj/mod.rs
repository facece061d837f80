//! Wavefront OBJ files: polygons with materials.
//!
//! The crate `tobj` does not suffice: its errors have no lines, it skips unknown statements, takes a polyline of three
//! points for a triangle, cuts concave polygons wrongly and holds materials of one library only.

mod corner;
mod libraries;
mod map;
mod mtl;
mod names;
mod statements;
#[cfg(test)]
mod tests;

use std::path::Path;
use std::rc::Rc;

use glam::{DVec3, Vec2, Vec3};
use smallvec::SmallVec;

use self::corner::{Corner, Counts};
use self::libraries::Failure;
use self::names::{Entry, Materials};
use super::error::SceneError;
use super::geometry::{Attributes, Geometry, Triangle};
use super::limits::{self, COORDINATE};
use super::loader::Loader;
use super::material::MaterialId;
use super::polygon::{Cut, MAX_CORNERS};
use super::text::{Line, each_line, number, shortened, without_comment, words};

pub(super) use self::libraries::Libraries;

/// The triangles of the OBJ file at `path`. Faces without a material get `plain`.
///
/// # Errors
/// A file that cannot be read, an unknown or unsupported statement, a number that is not finite or out of range, an
/// index without its vertex, a material that no library of the file defines, no face at all; any error of a library.
pub(super) fn read(
    path: &Path,
    plain: MaterialId,
    loader: &mut Loader,
    libraries: &mut Libraries,
) -> Result<Geometry, SceneError> {
    let bytes = loader.files.read(path).map_err(|source| SceneError::Read { path: path.to_owned(), source })?;
    parse(path, &bytes, plain, loader, libraries)
}

/// As [`read`], from the file's bytes.
///
/// Vertices and libraries are read before faces: an index may point forwards, and `usemtl` may precede the library.
fn parse(
    path: &Path,
    bytes: &[u8],
    plain: MaterialId,
    loader: &mut Loader,
    libraries: &mut Libraries,
) -> Result<Geometry, SceneError> {
    let failed = |(line, what)| SceneError::Syntax { path: path.to_owned(), line, what };
    let mut definitions = Definitions::default();
    // An error of a library names the library's own line.
    let mut in_library = None;
    let read = each_line(bytes, |line| {
        if line.word != "mtllib" {
            return definitions.read(line, path, loader);
        }
        match libraries.named_by(line, path, loader) {
            Ok(found) => definitions.materials.extend(found),
            Err(Failure::Line(what)) => return Err(what),
            Err(Failure::Library(error)) => {
                in_library = Some(error);
                return Err(String::new());
            }
        }
        Ok(())
    });
    if let Some(error) = in_library {
        return Err(error);
    }
    read.map_err(failed)?;
    let mut faces = Faces::new(&definitions, plain);
    each_line(bytes, |line| faces.read(line, path, loader)).map_err(failed)?;
    if faces.crossing > 0 {
        let what = format!("{} faces cross themselves: a fan from the first corner stands for each", faces.crossing);
        loader.notice(path, &what);
    }
    if faces.geometry.is_empty() {
        return Err(SceneError::Content { path: path.to_owned(), what: "there is no face (`f`) in it".into() });
    }
    Ok(faces.geometry)
}

/// The data that faces refer to.
#[derive(Default)]
struct Definitions {
    positions: Vec<Vec3>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    materials: Vec<Rc<Materials>>,
}

impl Definitions {
    fn read(&mut self, line: &Line<'_>, path: &Path, loader: &mut Loader) -> Result<(), String> {
        match line.word {
            "v" => {
                let numbers = numbers(line.rest, 7)?;
                match numbers[..] {
                    // A weight of a rational curve; as a corner of a face it can only be 1.
                    [.., weight] if numbers.len() == 4 && weight != 1.0 => {
                        return Err(format!("a vertex of weight {weight}: 1 or none is allowed"));
                    }
                    [_, _, _] | [_, _, _, _] => {}
                    [_, _, _, _, _, _] | [_, _, _, _, _, _, _] => loader.count_without_effect(path, "v with a colour"),
                    _ => {
                        return Err(format!(
                            "a vertex of {} numbers: x y z, with a weight or a colour, is",
                            numbers.len()
                        ));
                    }
                }
                let position = Vec3::from_slice(&numbers);
                limits::check_reach(position.as_dvec3())?;
                self.positions.push(position);
            }
            "vt" => {
                let numbers = numbers(line.rest, 3)?;
                let u = *numbers.first().ok_or("texture coordinates are u, u v or u v w")?;
                let uv = Vec2::new(u, numbers.get(1).copied().unwrap_or(0.0));
                COORDINATE.check_vector("a texture coordinate", uv.extend(0.0).as_dvec3())?;
                self.uvs.push(uv);
            }
            "vn" => {
                let numbers = numbers(line.rest, 3)?;
                let [x, y, z] = numbers[..] else {
                    return Err(format!("a normal of {} numbers: 3 are", numbers.len()));
                };
                COORDINATE.check_vector("a normal", DVec3::new(x.into(), y.into(), z.into()))?;
                self.normals.push(Vec3::new(x, y, z));
            }
            "f" | "fo" | "usemtl" => {}
            word if statements::WITHOUT_EFFECT.contains(&word) => loader.count_without_effect(path, word),
            word => return Err(statements::refusal(word)),
        }
        Ok(())
    }

    fn counts(&self) -> Counts {
        Counts([self.positions.len(), self.uvs.len(), self.normals.len()])
    }
}

/// The numbers of a statement, at most `most` of them.
fn numbers(text: &str, most: usize) -> Result<SmallVec<[f32; 7]>, String> {
    let numbers: SmallVec<[f32; 7]> = words(text).map(number).collect::<Result<_, _>>()?;
    if numbers.len() <= most {
        Ok(numbers)
    } else {
        Err(format!("{} numbers: at most {most} are allowed", numbers.len()))
    }
}

/// The faces so far.
struct Faces<'a> {
    definitions: &'a Definitions,
    /// Vertices, texture coordinates and normals that stand before the line.
    seen: Counts,
    plain: MaterialId,
    material: Entry,
    geometry: Geometry,
    corners: Vec<Corner>,
    points: Vec<DVec3>,
    /// Faces that cross themselves.
    crossing: usize,
}

impl<'a> Faces<'a> {
    fn new(definitions: &'a Definitions, plain: MaterialId) -> Self {
        let material = Entry::of(plain);
        let (geometry, corners, points) = Default::default();
        Self { definitions, seen: Counts::default(), plain, material, geometry, corners, points, crossing: 0 }
    }

    fn read(&mut self, line: &Line<'_>, path: &Path, loader: &mut Loader) -> Result<(), String> {
        match line.word {
            "v" => self.seen.0[0] += 1,
            "vt" => self.seen.0[1] += 1,
            "vn" => self.seen.0[2] += 1,
            "usemtl" => self.material = self.used(line, path, loader)?,
            // `fo` is the superseded spelling.
            "f" | "fo" => self.face(line, loader)?,
            _ => {}
        }
        Ok(())
    }

    fn used(&self, line: &Line<'_>, path: &Path, loader: &mut Loader) -> Result<Entry, String> {
        if self.definitions.materials.is_empty() {
            loader.count_without_effect(path, "usemtl without a mtllib");
            return Ok(Entry::of(self.plain));
        }
        // The first library that has the name counts (section "mtllib").
        let found = self.definitions.materials.iter().find_map(|library| library.find(line.rest));
        found.ok_or_else(|| format!("no material is named {:?}", shortened(without_comment(line.rest))))
    }

    fn face(&mut self, line: &Line<'_>, loader: &mut Loader) -> Result<(), String> {
        corner::read(line.rest, self.seen, self.definitions.counts(), &mut self.corners)?;
        if self.corners.len() > MAX_CORNERS {
            return Err(format!("a face of {} corners: at most {MAX_CORNERS} are allowed", self.corners.len()));
        }
        let Definitions { positions, uvs, normals, .. } = self.definitions;
        self.points.clear();
        self.points.extend(self.corners.iter().map(|corner| positions[corner.vertex].as_dvec3()));
        let (triangles, cut) = loader.cutter.cut(&self.points);
        self.crossing += usize::from(cut == Cut::CrossesItself);
        limits::check_count(self.geometry.len() + triangles.len())?;
        for triangle in triangles {
            let corners = triangle.map(|index| self.corners[index as usize]);
            let uv = corners.map(|corner| corner.uv.map_or(Vec2::ZERO, |index| self.material.map.apply(uvs[index])));
            let normals =
                corners.map(|corner| corner.normal.map_or(Vec3::ZERO, |index| normals[index].normalize_or_zero()));
            // A normal of length zero has no direction: the triangle shades flat.
            let normals = (!normals.contains(&Vec3::ZERO)).then_some(normals);
            let triangle = Triangle { v: corners.map(|corner| positions[corner.vertex]) };
            self.geometry.push(triangle, Attributes { normals, uv, material: self.material.id });
        }
        Ok(())
    }
}
