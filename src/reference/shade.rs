//! Surfaces, shadows and colours.

use glam::{DVec2, DVec3, Vec3};

use super::frame::{Hit, ReferenceFrame};
use crate::quantity::PrimitiveId;
use crate::scene::{Material, PixelRay, RenderSpec, ShadowBits, ShadowRays, Texture};

/// Shades the pixels of a frame.
pub(super) struct Shader<'a> {
    pub frame: &'a ReferenceFrame<'a>,
    pub spec: &'a RenderSpec,
    /// Distance from its surface at which a ray starts, in world units.
    pub offset: f64,
}

/// A hit point and its surface.
struct Surface<'a> {
    point: DVec3,
    /// The ray's direction, of unit length.
    incoming: DVec3,
    /// The geometric normal, turned to the viewer.
    normal: DVec3,
    /// The normal to shade with, on the same side.
    shading: DVec3,
    /// Whether the ray meets the counter-clockwise side.
    entering: bool,
    material: &'a Material,
    /// The texture's colour, white without one.
    tint: DVec3,
}

/// Directions and weights of secondary rays.
struct Secondary {
    direction: DVec3,
    weight: DVec3,
}

impl Shader<'_> {
    /// The colour, the hit and the shadows of a primary ray.
    pub(super) fn pixel(&self, ray: PixelRay) -> (Vec3, Option<PrimitiveId>, ShadowBits) {
        let Some(hit) = self.frame.closest(ray.origin, ray.direction) else {
            return (self.frame.scene.background, None, ShadowBits::default());
        };
        let surface = self.surface(ray.origin, ray.direction, &hit);
        let shadows = self.shadows(&surface);
        let color = self.shade(&surface, shadows, 1, DVec3::ONE);
        (color.as_vec3(), Some(hit.primitive), shadows)
    }

    /// The light that a secondary ray brings. The ray is the last of `depth` in a row; `weight` is its share of the
    /// pixel.
    fn radiance(&self, origin: DVec3, direction: DVec3, depth: u32, weight: DVec3) -> DVec3 {
        match self.frame.closest(origin, direction) {
            Some(hit) => {
                let surface = self.surface(origin, direction, &hit);
                self.shade(&surface, self.shadows(&surface), depth, weight)
            }
            None => self.frame.scene.background.as_dvec3(),
        }
    }

    fn surface(&self, origin: DVec3, direction: DVec3, hit: &Hit) -> Surface<'_> {
        let ReferenceFrame { scene, frame, .. } = self.frame;
        let [a, b, c] = scene.triangle(frame, hit.primitive).v.map(|corner| corner.as_dvec3());
        let attributes = scene.attributes(frame, hit.primitive);
        let material = &scene.materials[attributes.material.0 as usize];
        let outward = (b - a).cross(c - a).normalize();
        let entering = outward.dot(direction) < 0.0;
        let normal = if entering { outward } else { -outward };
        let mix = |corners: [DVec3; 3]| -> DVec3 { corners.into_iter().zip(hit.weights).map(|(c, w)| c * w).sum() };
        let smooth = attributes.normals.and_then(|normals| mix(normals.map(|n| n.as_dvec3())).try_normalize());
        let shading = smooth.map_or(normal, |smooth| if smooth.dot(normal) < 0.0 { -smooth } else { smooth });
        let uv = attributes.uv.iter().zip(hit.weights).map(|(corner, weight)| corner.as_dvec2() * weight).sum();
        let tint = material.texture.map_or(DVec3::ONE, |texture| texel(&scene.textures[texture.0 as usize], uv));
        let point = origin + hit.t * direction;
        Surface { point, incoming: direction.normalize(), normal, shading, entering, material, tint }
    }

    fn shadows(&self, surface: &Surface) -> ShadowBits {
        let start = surface.point + self.offset * surface.normal;
        let mut bits = ShadowBits::default();
        if surface.material.is_perfect_mirror() {
            return bits;
        }
        for (light, bit) in self.frame.frame.lights.iter().zip((0..).map(|light| 1u64 << light)) {
            let position = light.position.as_dvec3();
            if self.spec.shadow_rays == ShadowRays::Always || surface.faces(position) {
                bits.asked |= bit;
                if self.frame.occluded(start, position) {
                    bits.dark |= bit;
                }
            }
        }
        bits
    }

    fn shade(&self, surface: &Surface, shadows: ShadowBits, depth: u32, weight: DVec3) -> DVec3 {
        let mut color = self.direct(surface, shadows);
        if depth < self.spec.depth {
            let lift = self.offset * surface.normal;
            let (reflected, refracted) = surface.secondary();
            for (ray, start) in [(Some(reflected), surface.point + lift), (refracted, surface.point - lift)] {
                let Some(ray) = ray else { continue };
                let share = weight * ray.weight;
                if share.max_element() > 0.0 && share.max_element() >= f64::from(self.spec.min_weight) {
                    color += ray.weight * self.radiance(start, ray.direction, depth + 1, share);
                }
            }
        }
        color
    }

    fn direct(&self, surface: &Surface, shadows: ShadowBits) -> DVec3 {
        let Surface { point, incoming, shading, material, tint, .. } = *surface;
        let mut color = self.frame.scene.ambient.as_dvec3() * material.ambient.as_dvec3() * tint;
        let lit = shadows.asked & !shadows.dark;
        for (index, light) in self.frame.frame.lights.iter().enumerate() {
            let position = light.position.as_dvec3();
            if lit >> index & 1 == 0 || !surface.faces(position) {
                continue;
            }
            let to_light = (position - point).normalize();
            let cosine = shading.dot(to_light);
            if cosine > 0.0 {
                let mirrored = 2.0 * cosine * shading - to_light;
                let highlight = mirrored.dot(-incoming).max(0.0).powf(f64::from(material.shininess));
                let sent_back = material.diffuse.as_dvec3() * tint * cosine + material.specular.as_dvec3() * highlight;
                color += light.color.as_dvec3() * sent_back;
            }
        }
        color
    }
}

impl Surface<'_> {
    /// Whether a position is on the viewer's side of the surface.
    fn faces(&self, position: DVec3) -> bool {
        (position - self.point).dot(self.normal) > 0.0
    }

    /// The reflected ray and the refracted ray; no refracted ray on total internal reflection.
    fn secondary(&self) -> (Secondary, Option<Secondary>) {
        let (d, n) = (self.incoming, self.shading);
        let cosine = -d.dot(n);
        let transmittance = DVec3::splat(f64::from(self.material.transmittance));
        let index = f64::from(self.material.index_of_refraction);
        let ratio = if self.entering { 1.0 / index } else { index };
        // The squared cosine of the refracted ray, by Snell's law.
        let inside = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
        let mut reflected = Secondary { direction: d + 2.0 * cosine * n, weight: self.material.specular.as_dvec3() };
        if inside < 0.0 {
            reflected.weight += transmittance;
            return (reflected, None);
        }
        let direction = ratio * d + (ratio * cosine - inside.sqrt()) * n;
        (reflected, Some(Secondary { direction, weight: transmittance }))
    }
}

/// The texture's pixel at `uv`.
fn texel(texture: &Texture, uv: DVec2) -> DVec3 {
    let index = |at: f64, count: u32| ((at.rem_euclid(1.0) * f64::from(count)) as usize).min(count as usize - 1);
    let column = index(uv.x, texture.width);
    let row = texture.height as usize - 1 - index(uv.y, texture.height);
    let [red, green, blue] = texture.rgb[row * texture.width as usize + column].map(f64::from);
    DVec3::new(red, green, blue) / 255.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_repeat_and_rise() {
        // 1 2 at the top (v = 1), 3 4 at the bottom.
        let rgb = [1, 2, 3, 4].map(|gray| [gray; 3]).to_vec();
        let texture = Texture { width: 2, height: 2, rgb };
        let gray = |u: f64, v: f64| (texel(&texture, DVec2::new(u, v)).x * 255.0).round() as u8;
        assert_eq!([gray(0.2, 0.8), gray(0.8, 0.8), gray(0.2, 0.2), gray(0.8, 0.2)], [1, 2, 3, 4]);
        assert_eq!([gray(-0.8, 7.8), gray(3.8, -0.2), gray(-1e-20, 1.0), gray(0.0, -1e-20)], [1, 2, 4, 1]);
    }
}
