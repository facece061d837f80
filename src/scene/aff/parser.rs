//! The commands of an AFF file.

use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};

use super::animation::{Lamp, ROOT, Times, View};
use super::builder::{Builder, Space};
use super::lexer::Lexer;
use super::shapes::{self, Shapes};
use crate::scene::error::SceneError;
use crate::scene::keyframes::{Key, Motion, RotationTrack, Tcb, TrackError, VectorTrack, VisibilityTrack};
use crate::scene::light::MAX_LIGHTS;
use crate::scene::limits::{REFRACTION, Range, SHARE, SHININESS, STRENGTH};
use crate::scene::material::Material;

/// The largest depth of includes; the BART scenes go 4 deep.
pub(super) const MAX_INCLUDE_DEPTH: usize = 32;
/// The largest number of includes in a scene; the BART robot has 835.
pub(super) const MAX_INCLUDES: usize = 1 << 16;
/// The words that can begin a command, for messages.
const COMMANDS: &str =
    "one of the commands v b l la am f fm s c p pp tt ttp tpa m i d xs x k a, or `}` after an open block,";

/// Reads files into a [`Builder`].
pub(super) struct Parser {
    /// The scene so far.
    pub builder: Builder,
    /// The material of the shapes that follow. Neither the end of a block nor of an include resets it.
    material: Material,
    /// The level of detail; includes of a higher level are skipped.
    detail: i64,
    /// The files that are being read, the outermost first.
    open: Vec<PathBuf>,
    includes: usize,
}

impl Parser {
    /// A parser of a scene whose files are in `folder`.
    pub(super) fn new(folder: PathBuf) -> Self {
        let builder = Builder::new(folder);
        Self { builder, material: Material::default(), detail: 0, open: Vec::new(), includes: 0 }
    }

    /// Reads the bytes of the file at `path`, whose shapes go to `space`.
    pub(super) fn parse(&mut self, path: &Path, bytes: &[u8], space: Space) -> Result<(), SceneError> {
        self.open.push(path.into());
        let mut lexer = Lexer::new(path, bytes);
        // The spaces around the open blocks.
        let mut outer: Vec<Space> = Vec::new();
        let mut space = space;
        while let Some(word) = lexer.next_word() {
            match word {
                b"xs" => {
                    let inner = Space { place: space.place * static_transform(&mut lexer)?, ..space };
                    lexer.expect("{")?;
                    outer.push(std::mem::replace(&mut space, inner));
                }
                b"x" => {
                    let name = lexer.name("the name of an animated transform")?;
                    lexer.expect("{")?;
                    let inner = self.builder.animate(space, name);
                    outer.push(std::mem::replace(&mut space, inner));
                }
                b"}" => match outer.pop() {
                    Some(around) => space = around,
                    None => return Err(lexer.error("found `}`: no block is open in this file")),
                },
                _ => self.command(&mut lexer, word, space)?,
            }
        }
        if !outer.is_empty() {
            return Err(lexer.error(format!("the file ends in {} open blocks: a `}}` for each is needed", outer.len())));
        }
        self.open.pop();
        Ok(())
    }

    fn command(&mut self, lexer: &mut Lexer<'_>, word: &[u8], space: Space) -> Result<(), SceneError> {
        match word {
            b"v" => {
                self.builder.view = Some(view(lexer)?);
                for part in ["hither", "resolution"] {
                    self.builder.loader.count_without_effect(lexer.path(), part);
                }
            }
            b"b" => self.builder.background = strength(lexer, "the background")?,
            b"am" => self.builder.ambient = strength(lexer, "the ambient light")?,
            b"l" => self.light(lexer, None)?,
            b"la" => {
                let name = lexer.name("the name of an animated light")?;
                self.light(lexer, Some(name))?;
            }
            b"f" => self.material = nff_material(lexer)?,
            b"fm" => self.material = material(lexer)?,
            b"a" => self.builder.times = times(lexer)?,
            b"d" => self.detail = lexer.whole("the level of detail", i64::MIN, i64::MAX)?,
            b"i" => self.include(lexer, space)?,
            b"k" => {
                let name = lexer.name("the name of an animation")?;
                // The newest keyframes of a name replace all earlier ones.
                self.builder.motions.insert(name, motion(lexer)?);
            }
            b"s" => self.shapes(lexer, space, shapes::sphere)?,
            b"c" => self.shapes(lexer, space, shapes::cone)?,
            b"p" => self.shapes(lexer, space, |lexer| shapes::polygon(lexer, false))?,
            b"pp" => self.shapes(lexer, space, |lexer| shapes::polygon(lexer, true))?,
            b"tt" => self.shapes(lexer, space, |lexer| shapes::textured_triangle(lexer, false))?,
            b"ttp" => self.shapes(lexer, space, |lexer| shapes::textured_triangle(lexer, true))?,
            b"tpa" => self.shapes(lexer, space, shapes::animated_triangle)?,
            b"m" => self.shapes(lexer, space, shapes::mesh)?,
            word => return Err(lexer.found(word, COMMANDS)),
        }
        Ok(())
    }

    fn shapes(
        &mut self,
        lexer: &mut Lexer<'_>,
        space: Space,
        read: impl Fn(&mut Lexer<'_>) -> Result<Shapes, SceneError>,
    ) -> Result<(), SceneError> {
        // An error about the shape as a whole points to its command.
        let start = lexer.clone();
        let Shapes { faces, texture, crosses_itself } = read(lexer)?;
        if crosses_itself {
            let line = start.word_line();
            let what = format!("the polygon in line {line} crosses itself: a fan from its first corner stands for it");
            self.builder.loader.notice(lexer.path(), &what);
        }
        let texture = texture.map(|name| self.builder.texture(&name)).transpose().map_err(|what| start.error(what))?;
        let material = self.builder.material(Material { texture, ..self.material });
        self.builder.add(space, material, faces).map_err(|what| start.error(what))
    }

    fn include(&mut self, lexer: &mut Lexer<'_>, space: Space) -> Result<(), SceneError> {
        let level = lexer.whole("the level of an include", i64::MIN, i64::MAX)?;
        let name = lexer.name("the file to include")?;
        if level > self.detail {
            self.builder.loader.count_without_effect(lexer.path(), "i above the level of detail");
            return Ok(());
        }
        let path = self.builder.folder().join(&name);
        self.includes += 1;
        if self.open.contains(&path) {
            return Err(lexer.error(format!("`{name}` includes itself")));
        }
        if self.open.len() > MAX_INCLUDE_DEPTH {
            return Err(lexer.error(format!("`{name}`: includes are more than {MAX_INCLUDE_DEPTH} deep")));
        }
        if self.includes > MAX_INCLUDES {
            return Err(lexer.error(format!("`{name}`: more than {MAX_INCLUDES} includes")));
        }
        let bytes = self.builder.loader.files.read(&path);
        let bytes = bytes.map_err(|error| lexer.error(format!("cannot include `{name}`: {error}")))?;
        self.parse(&path, &bytes, space)
    }

    fn light(&mut self, lexer: &mut Lexer<'_>, name: Option<String>) -> Result<(), SceneError> {
        let position = lexer.vector("the position of a light")?;
        let color = if lexer.number_follows() { strength(lexer, "a light")? } else { Vec3::ONE };
        if self.builder.lamps.len() == MAX_LIGHTS {
            return Err(lexer.error(format!("too many lights: at most {MAX_LIGHTS} are allowed")));
        }
        self.builder.lamps.push(Lamp { position, color, name });
        Ok(())
    }
}

/// The space of a scene's first file: the world.
pub(super) const WORLD: Space = Space { node: ROOT, place: DAffine3::IDENTITY };

fn strength(lexer: &mut Lexer<'_>, of: &str) -> Result<Vec3, SceneError> {
    lexer.vector_within(&format!("the colour of {of}"), STRENGTH).map(|color| color.as_vec3())
}

fn share(lexer: &mut Lexer<'_>, what: &str) -> Result<Vec3, SceneError> {
    lexer.vector_within(what, SHARE).map(|color| color.as_vec3())
}

fn view(lexer: &mut Lexer<'_>) -> Result<View, SceneError> {
    let start = lexer.clone();
    lexer.expect("from")?;
    let eye = lexer.vector("the eye")?;
    lexer.expect("at")?;
    let direction = lexer.vector("a point to look at")? - eye;
    lexer.expect("up")?;
    let up = lexer.vector("the upward direction")?;
    lexer.expect("angle")?;
    let angle = lexer.number("the field of view")?;
    if angle <= 0.0 || angle >= 180.0 {
        return Err(
            lexer.error(format!("a field of view of {angle} degrees: more than 0 and less than 180 are allowed"))
        );
    }
    lexer.expect("hither")?;
    lexer.number("the distance of the near plane")?;
    lexer.expect("resolution")?;
    for what in ["the width of the picture", "the height of the picture"] {
        lexer.whole(what, 1, i64::from(u32::MAX))?;
    }
    // The sine of the angle between the two directions; below this limit the picture has no upright position.
    if direction.normalize_or_zero().cross(up.normalize_or_zero()).length() < 1e-9 {
        return Err(start.error("`at` must differ from `from`, and `up` must not run along the line between them"));
    }
    Ok(View { eye, direction, up, fov: angle.to_radians() })
}

/// `fm`: all terms are given.
fn material(lexer: &mut Lexer<'_>) -> Result<Material, SceneError> {
    let ambient = share(lexer, "a material's ambient term")?;
    let diffuse = share(lexer, "a material's diffuse term")?;
    let specular = share(lexer, "a material's specular term")?;
    // The BART robot has glass of index 0: no ray enters it, and the light that it would let through is reflected.
    surface(lexer, [ambient, diffuse, specular], WITH_ZERO)
}

/// `f`: one colour with shares, as in NFF.
fn nff_material(lexer: &mut Lexer<'_>) -> Result<Material, SceneError> {
    let color = share(lexer, "the colour of a material")?;
    let matt = color * lexer.number_within("a material's diffuse share", SHARE)? as f32;
    let specular = Vec3::splat(lexer.number_within("a material's specular share", SHARE)? as f32);
    surface(lexer, [matt, matt, specular], REFRACTION)
}

/// Indices of refraction, and 0.
const WITH_ZERO: Range = Range { low: 0.0, ..REFRACTION };

/// Reads a material after its colours; `refraction` is the range of its index of refraction if it lets light through.
fn surface(lexer: &mut Lexer<'_>, colors: [Vec3; 3], refraction: Range) -> Result<Material, SceneError> {
    let [ambient, diffuse, specular] = colors;
    let shininess = lexer.number_within("a material's shininess", SHININESS)? as f32;
    let transmittance = lexer.number_within("a material's transmittance", SHARE)? as f32;
    // Files give index 0 to opaque materials, which refract nothing.
    let range = if transmittance > 0.0 { refraction } else { WITH_ZERO };
    let index_of_refraction = lexer.number_within("a material's index of refraction", range)? as f32;
    Ok(Material { ambient, diffuse, specular, shininess, transmittance, index_of_refraction, texture: None })
}

fn times(lexer: &mut Lexer<'_>) -> Result<Times, SceneError> {
    let start = lexer.number("the time of the first frame")?;
    let end = lexer.number("the time of the last frame")?;
    let frames = lexer.whole("the number of frames", 1, i64::from(u32::MAX))? as u32;
    if end < start {
        return Err(lexer.error(format!("frames from {start} s to {end} s: the end must not be before the start")));
    }
    Ok(Times { start, end, frames })
}

/// The transform of `xs`: scale, then rotation, then translation.
fn static_transform(lexer: &mut Lexer<'_>) -> Result<DAffine3, SceneError> {
    let scale = lexer.vector("a scale")?;
    let axis = lexer.vector("the axis of a rotation")?;
    let unit = axis.normalize_or_zero();
    if unit == DVec3::ZERO {
        return Err(lexer.error(format!("the axis of a rotation is {axis}: a vector with a length is allowed")));
    }
    let rotation = DMat3::from_axis_angle(unit, lexer.number("the angle of a rotation")?.to_radians());
    let translation = lexer.vector("a translation")?;
    Ok(DAffine3 { matrix3: rotation * DMat3::from_diagonal(scale), translation })
}

/// Reads the tracks of `k` in their braces, each kind at most once.
fn motion(lexer: &mut Lexer<'_>) -> Result<Motion, SceneError> {
    let mut motion = Motion::default();
    lexer.expect("{")?;
    loop {
        let word = lexer.word("a track")?;
        let start = lexer.clone();
        let bad = |error: TrackError| start.error(error.to_string());
        match word {
            b"transl" if motion.translation.is_none() => {
                motion.translation =
                    Some(VectorTrack::new(&keys(lexer, |lexer| lexer.vector("a position"))?).map_err(bad)?);
            }
            b"scale" if motion.scale.is_none() => {
                motion.scale = Some(VectorTrack::new(&keys(lexer, |lexer| lexer.vector("a scale"))?).map_err(bad)?);
            }
            b"rot" if motion.rotation.is_none() => {
                motion.rotation = Some(RotationTrack::new(&keys(lexer, rotation)?).map_err(bad)?);
            }
            b"visibility" if motion.visibility.is_none() => motion.visibility = Some(visibility(lexer)?),
            b"}" => return Ok(motion),
            word => {
                return Err(lexer.found(word, "`transl`, `rot`, `scale` or `visibility`, each once at most, or `}`"));
            }
        }
    }
}

fn keys<V>(
    lexer: &mut Lexer<'_>,
    value: impl Fn(&mut Lexer<'_>) -> Result<V, SceneError>,
) -> Result<Vec<Key<V>>, SceneError> {
    let count = lexer.count("keys", 4)?;
    let key = |_| {
        Ok(Key {
            time: lexer.number("the time of a key")?,
            value: value(lexer)?,
            tcb: Tcb {
                tension: lexer.number("a tension")?,
                continuity: lexer.number("a continuity")?,
                bias: lexer.number("a bias")?,
            },
        })
    };
    (0..count).map(key).collect()
}

/// Axis and angle of a key. The axis is not normalised, as in the original program: 214 keys of the BART robot have an
/// axis that is not of unit length.
fn rotation(lexer: &mut Lexer<'_>) -> Result<DQuat, SceneError> {
    let axis = lexer.vector("the axis of a rotation")?;
    let (sine, cosine) = (0.5 * lexer.number("the angle of a rotation")?.to_radians()).sin_cos();
    let part = axis * sine;
    Ok(DQuat::from_xyzw(part.x, part.y, part.z, cosine))
}

fn visibility(lexer: &mut Lexer<'_>) -> Result<VisibilityTrack, SceneError> {
    let count = lexer.count("keys", 1)?;
    let key = |_| Ok((lexer.number("the time of a key")?, lexer.whole("a visibility", 0, 1)? == 1));
    Ok(VisibilityTrack { keys: (0..count).map(key).collect::<Result<_, SceneError>>()? })
}
