//! Rays of one kind, as in the tables of papers on ray-tracing hardware (Nah et al. 2011, table 11): no culling, no
//! other rays.

use std::sync::Arc;

use glam::DVec2;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_64_with_seed;

use super::frame::Tracer;
use super::lane::Lane;
use super::shade::Shader;
use super::spec::BAND_ROWS;
use crate::accel::{Ray, Scope, Trail};
use crate::culling::{PolicySpec, SceneFacts};
use crate::quantity::{LightId, PixelId};
use crate::scene::Frame;
use crate::stream::{Decision, Header, Item, Outcome, RayHead, RayKind, Totals};

/// A kind of rays. Primary rays start at the camera, all others at the points that pixels show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Alone {
    /// From the camera.
    Primary,
    /// To all lights on the viewer's side; the first blocker ends a ray.
    Shadow,
    /// One from each sample, with the cosine-weighted distribution of a diffuse surface; the first blocker within the
    /// reach ends a ray.
    Occlusion,
    /// One from each sample, with the cosine-weighted distribution of a diffuse surface.
    Diffuse,
}

/// Number and length of the rays of a kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Samples {
    /// Rays from the camera through each pixel. A single ray goes through the centre; several go through hashed
    /// points.
    pub a_pixel: u32,
    /// Length of [`Alone::Occlusion`] rays, in units of the scene.
    pub reach: f32,
    /// The directions of a sample's rays.
    pub directions: Directions,
}

/// Directions of ambient-occlusion rays and diffuse rays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Directions {
    /// Each sample of each pixel has its own direction, from a hash.
    #[default]
    Hashed,
    /// A sample has the same direction, relative to the surface normal, in all pixels: rays of neighbour pixels are
    /// parallel.
    Shared,
}

impl Alone {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Primary, Self::Shadow, Self::Occlusion, Self::Diffuse];
}

/// The purpose of a sample's two random numbers.
#[derive(Clone, Copy)]
enum Use {
    Direction,
    Lens,
}

/// Two numbers from 0 to 1, 1 excluded, from a hash.
fn numbers(pixel: PixelId, sample: u32, purpose: Use) -> [f32; 2] {
    let bits = xxh3_64_with_seed(&pixel.0.to_le_bytes(), 2 * u64::from(sample) + purpose as u64);
    // The largest 128 of the integers round up to 1.
    let unit = |bits: u64| ((bits as u32) as f32 / 4_294_967_296.0).min(1.0 - f32::EPSILON / 2.0);
    [unit(bits), unit(bits >> 32)]
}

impl Tracer<'_> {
    /// The stream of the rays of one kind in a frame. The parent of a ray that is not from the camera has no steps.
    pub fn alone(&self, frame: &Frame, number: u32, kind: Alone, samples: Samples) -> (Header, Vec<Item>) {
        let off = PolicySpec::Off.build(SceneFacts::of(self.scene));
        let world = self.accel.frame(self.scene, frame);
        let shader = Shader::new(self.scene, frame, self.spec.render, self.offset as f32);
        let (width, height) = (self.resolution.width, self.resolution.height);
        let rows: Vec<_> = (0..height).step_by(BAND_ROWS as usize).collect();
        let band = |&first: &u32| {
            let mut lane = Lane::new(off.as_ref(), shader.light_count());
            let (mut trail, nothing) = (Trail::default(), Trail::default());
            let pixels = (first..(first + BAND_ROWS).min(height)).flat_map(|y| (0..width).map(move |x| (x, y)));
            for (x, y, sample) in pixels.flat_map(|(x, y)| (0..samples.a_pixel).map(move |sample| (x, y, sample))) {
                let pixel = self.resolution.pixel(x, y);
                let mut camera = frame.camera;
                if samples.a_pixel > 1 {
                    let [right, up] = numbers(pixel, sample, Use::Lens);
                    camera.jitter += DVec2::new(f64::from(right) - 0.5, f64::from(up) - 0.5);
                }
                let ray = camera.ray(self.resolution, x, y);
                let ray = Ray::new(ray.origin.as_vec3(), ray.direction.as_vec3(), f32::INFINITY);
                trail.clear();
                let hit = world.closest(&ray, &mut trail);
                let head = |kind, light, outcome, parent: usize| RayHead {
                    kind,
                    light,
                    decision: Decision::Trace,
                    outcome,
                    pixel,
                    parent: parent as u32,
                };
                let outcome = hit.map_or(Outcome::Miss, |hit| Outcome::Hit(hit.primitive));
                let camera = head(RayKind::Primary, LightId(0), outcome, 0);
                let place = lane.chunk.len();
                let Some(hit) = hit.filter(|_| kind != Alone::Primary) else {
                    if kind == Alone::Primary {
                        lane.push(camera, trail.path());
                    }
                    continue;
                };
                lane.push(camera, nothing.path());
                let surface = shader.surface(&ray, &hit);
                if kind == Alone::Shadow {
                    for shadow in shader.shadow_rays(&surface) {
                        trail.clear();
                        let dark = world.occluded(&shadow.ray, Scope::All, &mut trail).is_some();
                        let outcome = if dark { Outcome::Dark } else { Outcome::Lit };
                        let head = head(RayKind::Shadow, shadow.light, outcome, lane.chunk.len() - place);
                        lane.push_shadow(head, trail.path(), dark, true);
                    }
                    continue;
                }
                let place = match samples.directions {
                    Directions::Hashed => pixel,
                    Directions::Shared => PixelId(0),
                };
                let mut ray = shader.diffuse_ray(&surface, numbers(place, sample, Use::Direction));
                trail.clear();
                if kind == Alone::Occlusion {
                    ray.reach = samples.reach;
                    let dark = world.occluded(&ray, Scope::All, &mut trail).is_some();
                    let outcome = if dark { Outcome::Dark } else { Outcome::Lit };
                    lane.push_shadow(head(RayKind::Shadow, LightId(0), outcome, 1), trail.path(), dark, true);
                } else {
                    let hit = world.closest(&ray, &mut trail);
                    let outcome = hit.map_or(Outcome::Miss, |hit| Outcome::Hit(hit.primitive));
                    lane.push(head(RayKind::Reflection, LightId(0), outcome, 1), trail.path());
                }
            }
            lane.finish()
        };
        let bands: Vec<_> = rows.par_iter().map(band).collect();
        let mut items = vec![Item::Frame(world.info())];
        let mut totals = Totals::default();
        for (chunk, record) in bands {
            totals += record.totals;
            items.push(Item::Rays(Arc::new(chunk)));
        }
        items.push(Item::End { policy: Arc::default(), totals });
        (self.header("Off", off.as_ref(), vec![number], "rays of one kind"), items)
    }
}
