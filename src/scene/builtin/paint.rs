//! Materials and textures of the built-in scenes, and lights of a shared strength.

use glam::Vec3;

use super::shapes::hash;
use crate::scene::light::Light;
use crate::scene::material::{Material, MaterialId, Texture, TextureId};

/// The materials and textures of a scene.
#[derive(Default)]
pub(super) struct Palette {
    pub materials: Vec<Material>,
    pub textures: Vec<Texture>,
}

impl Palette {
    pub(super) fn add(&mut self, material: Material) -> MaterialId {
        self.materials.push(material);
        MaterialId((self.materials.len() - 1) as u32)
    }

    /// A matt surface.
    pub(super) fn matt(&mut self, r: f32, g: f32, b: f32) -> MaterialId {
        self.add(matt(Vec3::new(r, g, b)))
    }

    /// A surface with a highlight and a faint reflection.
    pub(super) fn glossy(&mut self, r: f32, g: f32, b: f32) -> MaterialId {
        let base = matt(Vec3::new(r, g, b));
        self.add(Material { specular: Vec3::splat(0.15), shininess: 40.0, ..base })
    }

    /// A mirror of slightly tinted glass.
    pub(super) fn mirror(&mut self) -> MaterialId {
        let base = matt(Vec3::splat(0.05));
        self.add(Material { specular: Vec3::new(0.85, 0.88, 0.88), shininess: 200.0, ..base })
    }

    /// Clear glass.
    pub(super) fn glass(&mut self) -> MaterialId {
        let base = matt(Vec3::new(0.04, 0.06, 0.06));
        self.add(Material {
            specular: Vec3::splat(0.12),
            shininess: 120.0,
            transmittance: 0.8,
            index_of_refraction: 1.5,
            ..base
        })
    }

    /// A glowing surface: it reflects far more ambient light than falls on it.
    pub(super) fn glow(&mut self, r: f32, g: f32, b: f32) -> MaterialId {
        self.add(Material { ambient: 5.0 * Vec3::new(r, g, b), ..matt(Vec3::new(r, g, b)) })
    }

    /// A texture of `cells` x `cells` fields in two colours, each varied a little by a fixed pattern.
    pub(super) fn checker(&mut self, cells: u32, colors: [[u8; 3]; 2], specular: f32) -> MaterialId {
        const FIELD: u32 = 16;
        let width = cells * FIELD;
        let pixel = |i: u32| {
            let (x, y) = (i % width, i / width);
            let (column, row) = (x / FIELD, y / FIELD);
            let shade = 0.88 + 0.08 * hash(u64::from(row * cells + column)) + 0.04 * hash(u64::from(i));
            colors[((column + row) % 2) as usize].map(|channel| (f64::from(channel) * shade) as u8)
        };
        self.textures.push(Texture { width, height: width, rgb: (0..width * width).map(pixel).collect() });
        let texture = Some(TextureId((self.textures.len() - 1) as u32));
        self.add(Material { specular: Vec3::splat(specular), shininess: 60.0, texture, ..matt(Vec3::ONE) })
    }
}

fn matt(color: Vec3) -> Material {
    Material { ambient: color, diffuse: color, ..Material::default() }
}

/// The first `count` lights, which share `strength`: the brightness of a picture hardly depends on their number.
pub(super) fn share(lights: &[(Vec3, Vec3)], count: usize, strength: f32) -> Vec<Light> {
    let lights = lights[..count].iter();
    lights.map(|(position, color)| Light { position: *position, color: *color * strength / count as f32 }).collect()
}
