//! A band of the picture: some rows, traced by one thread for all policies.

use std::ops::Range;

use glam::Vec3;

use super::lane::{BandRecord, Lane};
use super::shade::Shader;
use super::spec::{BAND_ROWS, PixelOrder};
use super::whitted::{Traced, Whitted};
use crate::accel::{Hit, Mark, Ray, Silent, Trail, World};
use crate::culling::{Needs, Policy, Primary, Reference};
use crate::quantity::{PrimitiveId, Resolution};
use crate::scene::Frame;
use crate::stream::{Chunk, RayKind};

/// Data that all bands of a frame share.
pub(super) struct Band<'a> {
    pub world: &'a World<'a>,
    pub shader: &'a Shader<'a>,
    pub frame: &'a Frame,
    pub resolution: Resolution,
    pub needs: Needs,
    pub order: PixelOrder,
}

/// The results of one policy in a band.
pub(super) struct BandLane {
    pub chunk: Chunk,
    pub record: BandRecord,
}

struct PrimaryRay {
    ray: Ray,
    hit: Option<Hit>,
    /// The ray's part of the band's trail of primary rays.
    start: Mark,
    end: Mark,
}

impl Band<'_> {
    fn ray(&self, x: u32, y: u32) -> Ray {
        let ray = self.frame.camera.ray(self.resolution, x, y);
        Ray::new(ray.origin.as_vec3(), ray.direction.as_vec3(), f32::INFINITY)
    }

    /// The primitives that the pixels of a row show.
    pub(super) fn row(&self, y: u32) -> Vec<Option<PrimitiveId>> {
        let show = |x| self.world.closest(&self.ray(x, y), &mut Silent).map(|hit| hit.primitive);
        (0..self.resolution.width).map(show).collect()
    }

    /// Traces the pixels of `rows` for all policies.
    pub(super) fn trace(&self, rows: Range<u32>, policies: &[Box<dyn Policy>]) -> Vec<BandLane> {
        let width = self.resolution.width;
        let mut trail = Trail::default();
        let primaries: Vec<_> = rows
            .clone()
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .map(|(x, y)| {
                let (ray, start) = (self.ray(x, y), trail.mark());
                let hit = self.world.closest(&ray, &mut trail);
                PrimaryRay { ray, hit, start, end: trail.mark() }
            })
            .collect();
        let above = (self.needs.references && rows.start > 0).then(|| self.row(rows.start - 1));
        let primary = |x: u32, y: u32| &primaries[((y - rows.start) * width + x) as usize];
        // The reference at a pixel, if it is inside the picture and shows a primitive.
        let reference = |x: Option<u32>, y: Option<u32>| -> Option<Reference> {
            let (x, y) = (x.filter(|&x| x < width)?, y?);
            if y < rows.start {
                let primitive = above.as_ref()?[x as usize]?;
                return Some(Reference { primitive, ray: self.ray(x, y) });
            }
            let PrimaryRay { ray, hit, .. } = primary(x, y);
            Some(Reference { primitive: hit.as_ref()?.primitive, ray: *ray })
        };

        let lights = self.shader.light_count();
        let mut whitted = Whitted {
            world: self.world,
            shader: self.shader,
            lanes: policies.iter().map(|policy| Lane::new(policy.as_ref(), lights)).collect(),
            full: Trail::default(),
            own: Trail::default(),
        };
        let mut colors = vec![Vec3::ZERO; policies.len()];
        for (x, y) in self.pixels(rows.clone()) {
            if x == 0 && y > rows.start && y % BAND_ROWS == 0 {
                // A live policy makes the whole picture one band. The other policies change workers at the usual
                // borders, so that their results do not depend on the live policy.
                for (lane, policy) in whitted.lanes.iter_mut().zip(policies).filter(|(_, policy)| !policy.needs().live)
                {
                    lane.change_worker(policy.worker());
                }
            }
            let (left, up) = (x.checked_sub(1), y.checked_sub(1));
            let references = if self.needs.references {
                [reference(left, Some(y)), reference(Some(x), up), reference(left, up), reference(Some(x + 1), up)]
            } else {
                [None; 4]
            };
            let &PrimaryRay { ref ray, hit, start, end } = primary(x, y);
            let path = trail.between(start, end);
            let border = x == 0 || y == 0 || x + 1 == width || y + 1 == self.resolution.height;
            let traced = Traced { kind: RayKind::Primary, ray, hit, path, parent: None, depth: 1, weight: Vec3::ONE };
            colors.fill(Vec3::ZERO);
            let pixel = self.resolution.pixel(x, y);
            whitted.follow(pixel, &traced, Some(&Primary { ray, border, references: &references }), &mut colors);
            for (lane, &color) in whitted.lanes.iter_mut().zip(&colors) {
                lane.end_pixel(pixel, color, hit.map(|hit| hit.primitive));
            }
        }
        let finish = |lane: Lane<'_>| {
            let (chunk, record) = lane.finish();
            BandLane { chunk, record }
        };
        whitted.lanes.into_iter().map(finish).collect()
    }

    /// The pixels of `rows`, in the order of the stream.
    fn pixels(&self, rows: Range<u32>) -> impl Iterator<Item = (u32, u32)> {
        let width = self.resolution.width;
        // A live policy needs raster order, as in the published algorithm.
        let tile = match self.order {
            PixelOrder::Tiles if !self.needs.live => BAND_ROWS,
            PixelOrder::Tiles | PixelOrder::Scanline => width,
        };
        (0..width).step_by(tile as usize).flat_map(move |first| {
            rows.clone().flat_map(move |y| (first..(first + tile).min(width)).map(move |x| (x, y)))
        })
    }
}
