//! Surfaces and light: the colour of a hit, and the rays that leave it.
//!
//! The rules are those of the reference renderer, in `f32`; docs/model/functional-side.md describes them.

use glam::{Vec2, Vec3};

use crate::accel::{Hit, Ray};
use crate::quantity::LightId;
use crate::scene::{Frame, Material, RenderSpec, Scene, ShadowRays, Texture};

/// Shades the hits of one frame.
pub(super) struct Shader<'a> {
    scene: &'a Scene,
    frame: &'a Frame,
    pub spec: RenderSpec,
    pub offset: f32,
}

/// A point that was hit.
pub(super) struct Surface<'a> {
    material: &'a Material,
    diffuse: Vec3,
    ambient: Vec3,
    point: Vec3,
    /// The geometric normal of unit length, turned to the ray's origin.
    geometric: Vec3,
    /// The interpolated normal, on the same side.
    shading: Vec3,
    /// Whether the ray meets the counter-clockwise side.
    pub outside: bool,
    direction: Vec3,
}

/// A shadow ray, and the light's contribution to the picture if it is visible.
pub(super) struct ShadowRay {
    pub light: LightId,
    pub ray: Ray,
    pub color: Vec3,
}

/// A secondary ray, and its weight in the colour of the hit.
pub(super) struct SecondaryRay {
    pub ray: Ray,
    pub weight: Vec3,
}

/// The rays that leave a hit, besides shadow rays.
#[derive(Default)]
pub(super) struct SecondaryRays {
    pub reflection: Option<SecondaryRay>,
    pub refraction: Option<SecondaryRay>,
}

impl<'a> Shader<'a> {
    pub(super) fn new(scene: &'a Scene, frame: &'a Frame, spec: RenderSpec, offset: f32) -> Self {
        Self { scene, frame, spec, offset }
    }

    pub(super) fn light_count(&self) -> usize {
        self.frame.lights.len()
    }

    pub(super) fn background(&self) -> Vec3 {
        self.scene.background
    }

    /// The surface that `ray` has hit.
    pub(super) fn surface(&self, ray: &Ray, hit: &Hit) -> Surface<'a> {
        let triangle = self.scene.triangle(self.frame, hit.primitive);
        let attributes = self.scene.attributes(self.frame, hit.primitive);
        let material = &self.scene.materials[attributes.material.0 as usize];
        let [a, b, c] = triangle.v;
        let Vec2 { x: u, y: v } = hit.barycentric;
        let counter_clockwise = triangle.normal().normalize();
        let outside = counter_clockwise.dot(ray.direction) < 0.0;
        let geometric = if outside { counter_clockwise } else { -counter_clockwise };
        let shading = attributes
            .normals
            .and_then(|[a, b, c]| (a * (1.0 - u - v) + b * u + c * v).try_normalize())
            .map_or(geometric, |normal| if normal.dot(geometric) >= 0.0 { normal } else { -normal });
        let texel = material.texture.map_or(Vec3::ONE, |texture| {
            let [a, b, c] = attributes.uv;
            texel(&self.scene.textures[texture.0 as usize], a * (1.0 - u - v) + b * u + c * v)
        });
        Surface {
            material,
            diffuse: material.diffuse * texel,
            ambient: self.scene.ambient * material.ambient * texel,
            // From the corners: this is nearer to the plane than origin + t * direction.
            point: a + (b - a) * u + (c - a) * v,
            geometric,
            shading,
            outside,
            direction: ray.direction.normalize(),
        }
    }

    /// The surface's colour without any light.
    pub(super) fn ambient(&self, surface: &Surface<'_>) -> Vec3 {
        surface.ambient
    }

    /// A ray from the surface, with a density proportional to the cosine of its angle to the normal (Malley's method,
    /// Pharr et al., "Physically Based Rendering"). `at` is two random numbers from 0 to 1.
    pub(super) fn diffuse_ray(&self, surface: &Surface<'_>, at: [f32; 2]) -> Ray {
        let normal = surface.geometric;
        let (tangent, other) = normal.any_orthonormal_pair();
        let (radius, (sin, cos)) = (at[0].sqrt(), (std::f32::consts::TAU * at[1]).sin_cos());
        let direction = tangent * (radius * cos) + other * (radius * sin) + normal * (1.0 - at[0]).max(0.0).sqrt();
        Ray::new(surface.point + normal * self.offset, direction, f32::INFINITY)
    }

    /// The shadow rays of the surface; none for a perfect mirror.
    pub(super) fn shadow_rays(&self, surface: &Surface<'_>) -> impl Iterator<Item = ShadowRay> {
        let start = surface.point + surface.geometric * self.offset;
        let asking = if surface.material.is_perfect_mirror() { &[] } else { &self.frame.lights[..] };
        asking.iter().enumerate().filter_map(move |(index, light)| {
            let to_light = light.position - surface.point;
            let on_viewer_side = to_light.dot(surface.geometric) > 0.0;
            if !on_viewer_side && self.spec.shadow_rays == ShadowRays::ViewerSide {
                return None;
            }
            let lambert = surface.shading.dot(to_light.normalize_or_zero());
            let color = if on_viewer_side && lambert > 0.0 {
                let mirrored = surface.shading * (2.0 * lambert) - to_light.normalize();
                let highlight = mirrored.dot(-surface.direction).max(0.0);
                let phong = if surface.material.specular == Vec3::ZERO {
                    Vec3::ZERO
                } else {
                    surface.material.specular * highlight.powf(surface.material.shininess)
                };
                light.color * (surface.diffuse * lambert + phong)
            } else {
                Vec3::ZERO
            };
            let ray = Ray::segment(start, light.position);
            Some(ShadowRay { light: LightId(index as u8), ray, color })
        })
    }

    /// The reflected and the refracted ray, if their weights are large enough; `weight` is the surface's weight in the
    /// picture.
    pub(super) fn secondary_rays(&self, surface: &Surface<'_>, weight: Vec3) -> SecondaryRays {
        let Surface { material, shading: normal, direction, geometric, point, .. } = *surface;
        let from =
            |side: f32, direction: Vec3| Ray::new(point + geometric * (side * self.offset), direction, f32::INFINITY);
        let cosine = -direction.dot(normal);
        let ior = material.index_of_refraction;
        let eta = if surface.outside { 1.0 / ior } else { ior };
        let under_root = 1.0 - eta * eta * (1.0 - cosine * cosine);
        let mut mirror = material.specular;
        let mut refraction = None;
        if material.transmittance > 0.0 {
            if under_root >= 0.0 {
                let direction = direction * eta + normal * (eta * cosine - under_root.sqrt());
                refraction = Some(SecondaryRay { ray: from(-1.0, direction), weight: weight * material.transmittance });
            } else {
                mirror += material.transmittance;
            }
        }
        let reflected = direction + normal * (2.0 * cosine);
        let reflection = Some(SecondaryRay { ray: from(1.0, reflected), weight: weight * mirror });
        let heavy_enough = |ray: &SecondaryRay| {
            let heaviest = ray.weight.max_element();
            heaviest > 0.0 && heaviest >= self.spec.min_weight
        };
        SecondaryRays { reflection: reflection.filter(heavy_enough), refraction: refraction.filter(heavy_enough) }
    }
}

/// The nearest texel; coordinates repeat, and v points upwards.
fn texel(texture: &Texture, uv: Vec2) -> Vec3 {
    let place = |coordinate: f32, size: u32| {
        let share = coordinate - coordinate.floor();
        ((share * size as f32) as u32).min(size - 1)
    };
    let (x, y) = (place(uv.x, texture.width), place(1.0 - uv.y, texture.height));
    let rgb = texture.rgb[(y * texture.width + x) as usize];
    Vec3::from_array(rgb.map(f32::from)) / 255.0
}
