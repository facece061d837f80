//! One policy's share of a frame: its stream, its counts, its picture.

use glam::Vec3;

use crate::accel::{Fresh, Order, Path, Trail};
use crate::culling::{Change, Policy, Worker};
use crate::quantity::{LightId, PixelId, PrimitiveId, Resolution};
use crate::scene::{Picture, Scene, ShadowBits};
use crate::stream::{Chunk, Decision, Outcome, RayHead, RayKind, Totals};

/// Shadow decisions that differ from the same ray's traced without culling.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WrongDecisions {
    /// The light is seen, and the policy said that it is not.
    pub false_dark: u64,
    /// The light is not seen, and the policy said that it is.
    pub false_lit: u64,
}

/// What one policy did in a frame, besides its stream.
#[derive(Clone, Debug)]
pub struct LaneFrame {
    /// What the tracer counted.
    pub totals: Totals,
    /// Triangle tests made to learn which primitives are occluded.
    pub occlusion_tests: u64,
    /// Wrong decisions of all shadow rays, by light.
    pub wrong: Vec<WrongDecisions>,
    /// The picture with the policy's shadows.
    pub picture: Picture,
}

impl LaneFrame {
    pub(super) fn new(scene: &Scene, resolution: Resolution) -> Self {
        let pixels = resolution.pixels();
        Self {
            totals: Totals::default(),
            occlusion_tests: 0,
            wrong: vec![WrongDecisions::default(); scene.light_count],
            picture: Picture {
                resolution,
                rgb: vec![Vec3::ZERO; pixels],
                hits: vec![None; pixels],
                shadows: vec![ShadowBits::default(); pixels],
            },
        }
    }

    /// Takes in what was recorded in a band; gives back what the policy has to learn.
    pub(super) fn take(&mut self, record: BandRecord) -> Vec<Change> {
        self.totals += record.totals;
        self.occlusion_tests += record.occlusion_tests;
        for (all, here) in self.wrong.iter_mut().zip(&record.wrong) {
            all.false_dark += here.false_dark;
            all.false_lit += here.false_lit;
        }
        for pixel in record.pixels {
            let at = pixel.pixel.0 as usize;
            self.picture.rgb[at] = pixel.color;
            self.picture.hits[at] = pixel.hit;
            self.picture.shadows[at] = pixel.shadows;
        }
        record.changes
    }

    /// Counts what the policy did at the frame's end; gives the frame's totals.
    pub(super) fn end(&mut self, trail: &Trail) -> Totals {
        count_policy(&mut self.totals, trail);
        self.totals
    }
}

fn count_policy(totals: &mut Totals, trail: &Trail) {
    totals.policy_node_visits += trail.nodes;
    totals.policy_triangle_tests += trail.triangles;
    totals.list_reads += trail.lists;
    totals.policy_reads += trail.reads;
    totals.policy_writes += trail.writes;
    totals.repeated_updates += trail.repeated;
    totals.silent_updates += trail.silent;
}

/// A pixel of a band.
#[derive(Clone, Copy, Debug)]
pub(super) struct BandPixel {
    pub pixel: PixelId,
    pub color: Vec3,
    pub hit: Option<PrimitiveId>,
    pub shadows: ShadowBits,
}

/// What a lane counted and learned in a band.
#[derive(Debug, Default)]
pub(super) struct BandRecord {
    pub totals: Totals,
    pub occlusion_tests: u64,
    pub wrong: Vec<WrongDecisions>,
    pub pixels: Vec<BandPixel>,
    pub changes: Vec<Change>,
    /// Updates of mode words that change something, as far as the band knows, by their places in the band's chunk.
    pub fresh: Vec<Fresh>,
}

/// A policy at work in a band.
pub(super) struct Lane<'a> {
    pub worker: Box<dyn Worker + 'a>,
    /// The order in which its shadow rays visit nodes.
    pub order: Order,
    pub chunk: Chunk,
    pub record: BandRecord,
    /// The shadows of the current pixel's primary hit.
    pub shadows: ShadowBits,
    /// What the policy does on the current ray's account.
    pub policy: Trail,
}

impl<'a> Lane<'a> {
    pub fn new(policy: &'a dyn Policy, lights: usize) -> Self {
        let record = BandRecord { wrong: vec![WrongDecisions::default(); lights], ..BandRecord::default() };
        Self {
            worker: policy.worker(),
            order: policy.order(),
            chunk: Chunk::default(),
            record,
            shadows: ShadowBits::default(),
            policy: Trail::default(),
        }
    }

    /// Another worker goes on.
    pub fn change_worker(&mut self, worker: Box<dyn Worker + 'a>) {
        let done = std::mem::replace(&mut self.worker, worker);
        self.record.changes.extend(done.finish());
    }

    /// Records a primary or secondary ray, with what the policy has done since the last record.
    pub fn push(&mut self, head: RayHead, path: Path<'_>) {
        let totals = &mut self.record.totals;
        match head.kind {
            RayKind::Primary => totals.primary_rays += 1,
            _ => totals.secondary_rays += 1,
        }
        totals.node_visits += path.nodes;
        totals.triangle_tests += path.triangles;
        self.finish_ray(head, path);
    }

    /// Records a shadow ray, with what the policy has done since the last record.
    pub fn push_shadow(&mut self, head: RayHead, path: Path<'_>, truth_dark: bool, primary: bool) {
        let totals = &mut self.record.totals;
        totals.shadow_rays += 1;
        match head.decision {
            Decision::Trace => {}
            Decision::DynamicOnly => totals.shadow_rays_dynamic_only += 1,
            Decision::Skip => totals.shadow_rays_skipped += 1,
        }
        totals.shadow_node_visits += path.nodes;
        totals.shadow_triangle_tests += path.triangles;
        let dark = head.outcome == Outcome::Dark;
        let wrong = &mut self.record.wrong[usize::from(head.light.0)];
        match (dark, truth_dark) {
            (true, false) => wrong.false_dark += 1,
            (false, true) => wrong.false_lit += 1,
            _ => {}
        }
        if primary {
            self.shadows.asked |= bit(head.light);
            self.shadows.dark |= if dark { bit(head.light) } else { 0 };
        }
        self.finish_ray(head, path);
    }

    fn finish_ray(&mut self, head: RayHead, path: Path<'_>) {
        self.record.totals.list_reads += path.lists;
        count_policy(&mut self.record.totals, &self.policy);
        let before = self.chunk.steps() + path.steps.len();
        let fresh = self.policy.fresh.iter().map(|fresh| Fresh { at: before + fresh.at, ..*fresh });
        self.record.fresh.extend(fresh);
        self.chunk.push(head, path.steps, &self.policy.steps);
        self.policy.clear();
    }

    /// Ends a pixel.
    pub fn end_pixel(&mut self, pixel: PixelId, color: Vec3, hit: Option<PrimitiveId>) {
        let shadows = std::mem::take(&mut self.shadows);
        self.record.pixels.push(BandPixel { pixel, color, hit, shadows });
    }

    /// Ends the band.
    pub fn finish(mut self) -> (Chunk, BandRecord) {
        self.record.changes.extend(self.worker.finish());
        (self.chunk, self.record)
    }
}

fn bit(light: LightId) -> u64 {
    1 << light.0
}
