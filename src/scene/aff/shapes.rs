//! The shapes of an AFF file, read into triangles.

use std::iter;

use glam::{DVec2, DVec3, Vec2};

use super::animation::{Pose, Shape};
use super::builder::Face;
use super::lexer::Lexer;
use crate::scene::error::SceneError;
use crate::scene::limits::LENGTH;
use crate::scene::polygon::{Cut, Cutter, MAX_CORNERS};
use crate::scene::tessellate::{self, SmoothTriangle};

/// Triangles with one texture.
#[derive(Debug)]
pub(super) struct Shapes {
    /// The triangles.
    pub faces: Vec<Face>,
    /// The name of their texture's file.
    pub texture: Option<String>,
    /// Whether they come from a polygon that crosses itself.
    pub crosses_itself: bool,
}

impl Shapes {
    fn plain(faces: impl IntoIterator<Item = Face>) -> Self {
        Self { faces: faces.into_iter().collect(), texture: None, crosses_itself: false }
    }
}

fn rigid(v: [DVec3; 3], normals: Option<[DVec3; 3]>) -> Face {
    Face { shape: Shape::Rigid(Pose { v, normals }), uv: [Vec2::ZERO; 3] }
}

fn smooth(triangles: Vec<SmoothTriangle>) -> Shapes {
    Shapes::plain(triangles.into_iter().map(|SmoothTriangle { v, normals }| rigid(v, Some(normals))))
}

/// Reads `count` elements one by one: nothing is allocated for elements that are announced and missing.
fn many<T>(
    lexer: &mut Lexer<'_>,
    count: usize,
    mut read: impl FnMut(&mut Lexer<'_>) -> Result<T, SceneError>,
) -> Result<Vec<T>, SceneError> {
    (0..count).map(|_| read(lexer)).collect()
}

/// Three corners, one after the other.
fn three<T>(mut read: impl FnMut() -> Result<T, SceneError>) -> Result<[T; 3], SceneError> {
    Ok([read()?, read()?, read()?])
}

/// `s`: centre and radius; a negative radius shows the inside.
pub(super) fn sphere(lexer: &mut Lexer<'_>) -> Result<Shapes, SceneError> {
    let center = lexer.vector("the centre of a sphere")?;
    let radius = lexer.number("the radius of a sphere")?;
    LENGTH.check("the radius of a sphere, without its sign,", radius.abs()).map_err(|what| lexer.error(what))?;
    Ok(smooth(tessellate::sphere(center, radius)))
}

/// `c`: centre and radius at both ends; negative radii show the inside.
pub(super) fn cone(lexer: &mut Lexer<'_>) -> Result<Shapes, SceneError> {
    let base = lexer.vector("the base of a cone")?;
    let base_radius = lexer.number("the radius of a cone's base")?;
    let apex = lexer.vector("the apex of a cone")?;
    let apex_radius = lexer.number("the radius of a cone's apex")?;
    for radius in [base_radius, apex_radius].into_iter().filter(|radius| *radius != 0.0) {
        LENGTH.check("the radius of a cone, without its sign,", radius.abs()).map_err(|what| lexer.error(what))?;
    }
    if base == apex {
        return Err(lexer.error("a cone whose base and apex are at one point: two points are allowed"));
    }
    if base_radius * apex_radius < 0.0 || (base_radius == 0.0 && apex_radius == 0.0) {
        return Err(lexer.error(format!(
            "a cone with radii {base_radius} and {apex_radius}: radii of one sign, at most one of them 0, are allowed"
        )));
    }
    Ok(smooth(tessellate::cone(base, base_radius, apex, apex_radius)))
}

/// `p` and, with normals, `pp`: a polygon, counter-clockwise as seen from its front.
pub(super) fn polygon(lexer: &mut Lexer<'_>, with_normals: bool) -> Result<Shapes, SceneError> {
    let count = lexer.whole("the number of corners", 3, MAX_CORNERS as i64)? as usize;
    let corners = many(lexer, count, |lexer| {
        let corner = lexer.vector("a corner of a polygon")?;
        let normal = if with_normals { lexer.vector("a normal of a polygon")? } else { DVec3::ZERO };
        Ok((corner, normal))
    })?;
    // Rounded before the polygon is cut, as for every format.
    let points: Vec<_> = corners.iter().map(|corner| corner.0.as_vec3().as_dvec3()).collect();
    let mut cutter = Cutter::default();
    let (triangles, cut) = cutter.cut(&points);
    let faces = triangles.iter().map(|triangle| {
        let corners = triangle.map(|index| corners[index as usize]);
        rigid(corners.map(|corner| corner.0), with_normals.then(|| corners.map(|corner| corner.1)))
    });
    Ok(Shapes { crosses_itself: cut == Cut::CrossesItself, ..Shapes::plain(faces) })
}

/// `tt` and, with normals, `ttp`: a triangle with a texture.
pub(super) fn textured_triangle(lexer: &mut Lexer<'_>, with_normals: bool) -> Result<Shapes, SceneError> {
    let texture = lexer.name("the file of a texture")?;
    let corners = three(|| {
        let corner = lexer.vector("a corner of a triangle")?;
        let normal = if with_normals { lexer.vector("a normal of a triangle")? } else { DVec3::ZERO };
        Ok((corner, normal, lexer.pair("texture coordinates")?.as_vec2()))
    })?;
    let face = rigid(corners.map(|corner| corner.0), with_normals.then(|| corners.map(|corner| corner.1)));
    Ok(Shapes {
        faces: vec![Face { uv: corners.map(|corner| corner.2), ..face }],
        texture: Some(texture),
        crosses_itself: false,
    })
}

/// `tpa`: a triangle that moves from pose to pose.
pub(super) fn animated_triangle(lexer: &mut Lexer<'_>) -> Result<Shapes, SceneError> {
    let count = lexer.count("poses", 1)?;
    let keys = many(lexer, count, |lexer| {
        let time = lexer.number("the time of a pose")?;
        let corners = three(|| Ok((lexer.vector("a corner of a triangle")?, lexer.vector("a normal of a triangle")?)))?;
        Ok((time, Pose { v: corners.map(|corner| corner.0), normals: Some(corners.map(|corner| corner.1)) }))
    })?;
    Ok(Shapes::plain(iter::once(Face { shape: Shape::Morph(keys.into()), uv: [Vec2::ZERO; 3] })))
}

/// `m`: a mesh. Vertices, normals and texture coordinates are each numbered from 0.
pub(super) fn mesh(lexer: &mut Lexer<'_>) -> Result<Shapes, SceneError> {
    lexer.expect("vertices")?;
    let count = lexer.count("vertices", 1)?;
    let vertices = many(lexer, count, |lexer| lexer.vector("a vertex"))?;
    let mut normals: Option<Vec<DVec3>> = None;
    let mut texture: Option<(String, Vec<DVec2>)> = None;
    loop {
        match lexer.word("`triangles`")? {
            b"normals" if normals.is_none() && texture.is_none() => {
                let count = lexer.count("normals", 1)?;
                normals = Some(many(lexer, count, |lexer| lexer.vector("a normal"))?);
            }
            b"texturecoords" if texture.is_none() => {
                let count = lexer.count("texture coordinates", 1)?;
                let name = lexer.name("the file of a texture")?;
                texture = Some((name, many(lexer, count, |lexer| lexer.pair("texture coordinates"))?));
            }
            b"triangles" => break,
            word => {
                return Err(lexer.found(word, "`normals`, then `texturecoords`, each once at most, then `triangles`"));
            }
        }
    }
    let count = lexer.count("triangles", 0)?;
    let faces = many(lexer, count, |lexer| {
        let v = three(|| at(lexer, "a vertex", &vertices))?;
        let normals = normals.as_deref().map(|list| three(|| at(lexer, "a normal", list))).transpose()?;
        let coordinates =
            texture.as_ref().map(|(_, list)| three(|| at(lexer, "texture coordinates", list))).transpose()?;
        let uv = coordinates.map_or([Vec2::ZERO; 3], |uv| uv.map(|uv| uv.as_vec2()));
        Ok(Face { uv, ..rigid(v, normals) })
    })?;
    Ok(Shapes { faces, texture: texture.map(|(name, _)| name), crosses_itself: false })
}

/// Reads a number and returns that entry of `list`.
fn at<T: Copy>(lexer: &mut Lexer<'_>, what: &str, list: &[T]) -> Result<T, SceneError> {
    let index = lexer.whole(&format!("the number of {what}"), 0, list.len() as i64 - 1)?;
    Ok(list[index as usize])
}
