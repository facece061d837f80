//! One policy's results in a frame: its stream, its counts, its picture.

use glam::Vec3;

use crate::accel::{Fresh, Order, Path, Trail};
use crate::culling::{Change, Policy, Worker};
use crate::quantity::{LightId, PixelId, PrimitiveId, Resolution};
use crate::scene::{Picture, Scene, ShadowBits};
use crate::stream::{Chunk, Decision, Outcome, RayHead, RayKind, Totals};

/// Number of shadow decisions that differ from the answer without culling.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WrongDecisions {
    /// The light is visible, but the policy said shadow.
    pub false_dark: u64,
    /// The light is hidden, but the policy said light.
    pub false_lit: u64,
}

/// The results of one policy in a frame, besides its stream.
#[derive(Clone, Debug)]
pub struct LaneFrame {
    /// The tracer's counts.
    pub totals: Totals,
    /// Number of triangle tests made to learn which primitives are occluded.
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

    /// Adds the record of a band; returns the changes for the policy.
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

    /// Counts the policy's end-of-frame accesses; returns the frame's totals.
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

/// Counts and changes of a lane in a band.
#[derive(Debug, Default)]
pub(super) struct BandRecord {
    pub totals: Totals,
    pub occlusion_tests: u64,
    pub wrong: Vec<WrongDecisions>,
    pub pixels: Vec<BandPixel>,
    pub changes: Vec<Change>,
    /// Updates of mode words that change bits, as far as the band knows, with their positions in the band's chunk.
    pub fresh: Vec<Fresh>,
}

/// A policy at work in a band.
pub(super) struct Lane<'a> {
    pub worker: Box<dyn Worker + 'a>,
    /// The order in which the policy's shadow rays visit nodes.
    pub order: Order,
    pub chunk: Chunk,
    pub record: BandRecord,
    /// The shadows of the current pixel's primary hit.
    pub shadows: ShadowBits,
    /// The policy's accesses for the current ray.
    pub policy: Trail,
}

impl<'a> Lane<'a> {
    pub(super) fn new(policy: &'a dyn Policy, lights: usize) -> Self {
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

    /// Continues with another worker.
    pub(super) fn change_worker(&mut self, worker: Box<dyn Worker + 'a>) {
        let done = std::mem::replace(&mut self.worker, worker);
        self.record.changes.extend(done.finish());
    }

    /// Records a primary or secondary ray, with the policy's accesses since the last record.
    pub(super) fn push(&mut self, head: RayHead, path: Path<'_>) {
        let totals = &mut self.record.totals;
        match head.kind {
            RayKind::Primary => totals.primary_rays += 1,
            _ => totals.secondary_rays += 1,
        }
        totals.node_visits += path.nodes;
        totals.triangle_tests += path.triangles;
        self.finish_ray(head, path);
    }

    /// Records a shadow ray, with the policy's accesses since the last record.
    pub(super) fn push_shadow(&mut self, head: RayHead, path: Path<'_>, truth_dark: bool, primary: bool) {
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
    pub(super) fn end_pixel(&mut self, pixel: PixelId, color: Vec3, hit: Option<PrimitiveId>) {
        let shadows = std::mem::take(&mut self.shadows);
        self.record.pixels.push(BandPixel { pixel, color, hit, shadows });
    }

    /// Ends the band.
    pub(super) fn finish(mut self) -> (Chunk, BandRecord) {
        self.record.changes.extend(self.worker.finish());
        (self.chunk, self.record)
    }
}

fn bit(light: LightId) -> u64 {
    1 << light.0
}
