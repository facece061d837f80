//! PLY meshes: ASCII and both binary forms, with the crate `ply-rs-bw`.
//!
//! Source: Turk, "The PLY Polygon File Format", 1994. Of a vertex `x y z`, normals `nx ny nz` and texture coordinates
//! (`u v`, `s t` or `texture_u texture_v`) are read, of a face its list `vertex_indices` (or `vertex_index`). Other
//! properties and elements have no effect; notices list them. Triangle strips (`tristrips`) are refused.

mod face;
mod vertex;

use std::path::Path;

use glam::{DVec3, Vec2, Vec3};
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Header};

use self::face::Face;
use self::vertex::Vertex;
use super::error::SceneError;
use super::geometry::{Attributes, Geometry, Triangle};
use super::limits::{self, COORDINATE};
use super::loader::Loader;
use super::material::MaterialId;
use super::polygon::{Cut, MAX_CORNERS};

/// The triangles of the PLY file at `path`, all of the material `plain`.
///
/// # Errors
/// A file that cannot be read or is malformed, counts beyond the file's size, numbers that are not finite or out of
/// range, an index without its vertex, no face at all.
pub(super) fn read(path: &Path, plain: MaterialId, loader: &mut Loader) -> Result<Geometry, SceneError> {
    let bytes = loader.files.read(path).map_err(|source| SceneError::Read { path: path.to_owned(), source })?;
    parse(path, &bytes, plain, loader)
}

/// As [`read`], from the file's bytes.
fn parse(path: &Path, bytes: &[u8], plain: MaterialId, loader: &mut Loader) -> Result<Geometry, SceneError> {
    let content = |what: String| SceneError::Content { path: path.to_owned(), what };
    let failed = |error: ParseError| match error.line() {
        Some(line) => SceneError::Syntax { path: path.to_owned(), line, what: one_line(&error) },
        None => content(one_line(&error)),
    };
    let mut reader = Reader::new(bytes);
    let header = Parser::<Face>::new().read_header(&mut reader).map_err(failed)?;
    check_header(&header, bytes.len()).map_err(content)?;
    let (mut vertices, mut geometry) = (Vec::new(), Geometry::default());
    let mut crossing = 0;
    for element in header.elements.values() {
        match element.name.as_str() {
            "vertex" => {
                tell_ignored(element, vertex::PROPERTIES, path, loader);
                vertices =
                    Parser::<Vertex>::new().read_payload_for_element(&mut reader, element, &header).map_err(failed)?;
                for (at, vertex) in vertices.iter().enumerate() {
                    check(vertex).map_err(|what| content(format!("vertex {at}: {what}")))?;
                }
            }
            "face" => {
                tell_ignored(element, face::PROPERTIES, path, loader);
                let faces =
                    Parser::<Face>::new().read_payload_for_element(&mut reader, element, &header).map_err(failed)?;
                for (at, face) in faces.iter().enumerate() {
                    let cut = add(face, &vertices, plain, &mut geometry, loader);
                    let cut = cut.map_err(|what| content(format!("face {at}: {what}")))?;
                    crossing += usize::from(cut == Cut::CrossesItself);
                }
            }
            name => {
                loader.count_without_effect(path, &format!("element {name}"));
                Parser::<vertex::Ignored>::new()
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(failed)?;
            }
        }
    }
    if crossing > 0 {
        loader.notice(path, &format!("{crossing} faces cross themselves: a fan from the first corner stands for each"));
    }
    if geometry.is_empty() { Err(content("there is no face in it".into())) } else { Ok(geometry) }
}

/// The first line of an error: the crate quotes the whole line of the file after it.
fn one_line(error: &ParseError) -> String {
    let text = error.to_string();
    super::text::shortened_to(text.lines().next().unwrap_or_default(), 200).to_owned()
}

fn check_header(header: &Header, size: usize) -> Result<(), String> {
    for element in header.elements.values() {
        // Every element takes at least one byte, so a count above the file's size is forged. Elements without
        // properties would take no bytes.
        if element.count > size || (element.properties.is_empty() && element.count > 0) {
            return Err(format!("{} elements `{}` are told, more than the file can hold", element.count, element.name));
        }
        if element.name == "tristrips" {
            return Err("triangle strips (`tristrips`) are not read: faces are".into());
        }
    }
    let places = ["vertex", "face"].map(|name| header.elements.get_index_of(name));
    let [Some(vertex), Some(face)] = places else { return Err("it needs the elements `vertex` and `face`".into()) };
    if face < vertex {
        return Err("`face` stands before `vertex`: the other order is allowed".into());
    }
    let has = |element: &str, name: &str| header.elements[element].properties.contains_key(name);
    if !["x", "y", "z"].into_iter().all(|name| has("vertex", name)) {
        return Err("`vertex` needs the properties `x`, `y` and `z`".into());
    }
    if face::PROPERTIES.iter().filter(|name| has("face", name)).count() != 1 {
        return Err("`face` needs the property `vertex_indices` or `vertex_index`".into());
    }
    Ok(())
}

fn tell_ignored(element: &ElementDef, read: &[&str], path: &Path, loader: &mut Loader) {
    for name in element.properties.keys().filter(|name| !read.contains(&name.as_str())) {
        loader.count_without_effect(path, &format!("{} {name}", element.name));
    }
}

fn check(vertex: &Vertex) -> Result<(), String> {
    limits::check_reach(DVec3::from(vertex.position))?;
    COORDINATE.check_vector("a normal", DVec3::from(vertex.normal))?;
    COORDINATE.check_vector("a texture coordinate", DVec3::new(vertex.uv[0], vertex.uv[1], 0.0)).map(|_| ())
}

/// Adds the triangles of a face.
fn add(
    face: &Face,
    vertices: &[Vertex],
    material: MaterialId,
    geometry: &mut Geometry,
    loader: &mut Loader,
) -> Result<Cut, String> {
    let corners = face.indices.iter().map(|&index| {
        let found = usize::try_from(index).ok().and_then(|index| vertices.get(index));
        found.ok_or_else(|| format!("vertex {index} is asked for, and there are {}", vertices.len()))
    });
    let corners: Vec<&Vertex> = corners.collect::<Result<_, _>>()?;
    if !(3..=MAX_CORNERS).contains(&corners.len()) {
        return Err(format!("{} corners: from 3 to {MAX_CORNERS} are allowed", corners.len()));
    }
    // Rounded before the polygon is cut, as for every format.
    let points: Vec<DVec3> = corners.iter().map(|corner| DVec3::from(corner.position).as_vec3().as_dvec3()).collect();
    let (triangles, cut) = loader.cutter.cut(&points);
    limits::check_count(geometry.len() + triangles.len())?;
    for triangle in triangles {
        let corners = triangle.map(|index| corners[index as usize]);
        let normals = corners.map(|corner| DVec3::from(corner.normal).normalize_or_zero().as_vec3());
        // A normal of length zero has no direction: the triangle shades flat.
        let normals = (!normals.contains(&Vec3::ZERO)).then_some(normals);
        let uv = corners.map(|corner| Vec2::new(corner.uv[0] as f32, corner.uv[1] as f32));
        let v = triangle.map(|index| points[index as usize].as_vec3());
        geometry.push(Triangle { v }, Attributes { normals, uv, material });
    }
    Ok(cut)
}

#[cfg(test)]
mod tests;
