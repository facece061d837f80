//! Whitted's tree of rays of one pixel: traced once, recorded in every lane.

use glam::Vec3;
use smallvec::SmallVec;

use super::lane::Lane;
use super::shade::{Shader, ShadowRay};
use crate::accel::{Hit, Order, Path, Ray, Scope, Trail, World};
use crate::culling::{Evidence, Primary, Probe, SurfaceHit, Verdict};
use crate::quantity::{LightId, PixelId};
use crate::stream::{Decision, Outcome, RayHead, RayKind};

/// A traced primary or secondary ray, before it is recorded.
pub(super) struct Traced<'a> {
    pub kind: RayKind,
    pub ray: &'a Ray,
    pub hit: Option<Hit>,
    pub path: Path<'a>,
    /// Index of the parent in the chunk.
    pub parent: Option<usize>,
    /// 1 for a primary ray.
    pub depth: u32,
    /// Weight in the picture.
    pub weight: Vec3,
}

/// A hit that is lit by shadow rays.
struct Lit {
    at: SurfaceHit,
    pixel: PixelId,
    /// Index of its ray in the chunk.
    place: usize,
    /// Weight in the picture.
    weight: Vec3,
    is_primary: bool,
}

/// Traces pixel groups of a band.
pub(super) struct Whitted<'a> {
    pub world: &'a World<'a>,
    pub shader: &'a Shader<'a>,
    pub lanes: Vec<Lane<'a>>,
    /// A shadow ray's path without culling.
    pub full: Trail,
    /// A shadow ray's path in a lane that traces it differently.
    pub own: Trail,
}

impl Whitted<'_> {
    /// Records a ray and all rays that follow from it; adds its contribution to each lane's colour.
    pub(super) fn follow(
        &mut self,
        pixel: PixelId,
        ray: &Traced<'_>,
        primary: Option<&Primary<'_>>,
        colors: &mut [Vec3],
    ) {
        let place = self.lanes.first().map_or(0, |lane| lane.chunk.len());
        let head = RayHead {
            kind: ray.kind,
            light: LightId(0),
            decision: Decision::Trace,
            outcome: ray.hit.map_or(Outcome::Miss, |hit| Outcome::Hit(hit.primitive)),
            pixel,
            parent: ray.parent.map_or(0, |parent| (place - parent) as u32),
        };
        let Some(hit) = ray.hit else {
            for (lane, color) in self.lanes.iter_mut().zip(colors) {
                lane.push(head, ray.path);
                *color += ray.weight * self.shader.background();
            }
            return;
        };
        let surface = self.shader.surface(ray.ray, &hit);
        let shadow_rays: SmallVec<[_; 8]> = self.shader.shadow_rays(&surface).collect();
        let at = SurfaceHit {
            primitive: hit.primitive,
            depth: ray.depth,
            barycentric: hit.barycentric,
            outside: surface.outside,
        };

        // The policies decide on all lights before the first shadow ray starts.
        let mut verdicts = SmallVec::<[_; 32]>::new();
        for (lane, color) in self.lanes.iter_mut().zip(colors.iter_mut()) {
            let mut probe = Probe::new(self.world, &mut lane.policy, self.shader.offset);
            lane.worker.hit(at, primary, &mut probe);
            verdicts.extend(shadow_rays.iter().map(|it| lane.worker.decide(at, it.light, &it.ray, &mut probe)));
            lane.record.occlusion_tests += probe.occlusion_tests;
            lane.push(head, ray.path);
            *color += ray.weight * self.shader.ambient(&surface);
        }

        let lit = Lit { at, pixel, place, weight: ray.weight, is_primary: primary.is_some() };
        for (asked, shadow) in shadow_rays.iter().enumerate() {
            self.shadow(&lit, shadow, verdicts.iter().skip(asked).step_by(shadow_rays.len()), colors);
        }

        if ray.depth < self.shader.spec.depth {
            let secondary = self.shader.secondary_rays(&surface, ray.weight);
            let kinds = [(RayKind::Reflection, secondary.reflection), (RayKind::Refraction, secondary.refraction)];
            for (kind, leaving) in kinds {
                let Some(leaving) = leaving else { continue };
                let mut path = Trail::default();
                let hit = self.world.closest(&leaving.ray, &mut path);
                let (parent, depth) = (Some(place), ray.depth + 1);
                let next =
                    Traced { kind, ray: &leaving.ray, hit, path: path.path(), parent, depth, weight: leaving.weight };
                self.follow(pixel, &next, None, colors);
            }
        }
    }

    /// Traces one of a hit's shadow rays and records it in every lane, by the lanes' `verdicts`.
    fn shadow<'v>(
        &mut self,
        hit: &Lit,
        shadow: &ShadowRay,
        verdicts: impl Iterator<Item = &'v Verdict>,
        colors: &mut [Vec3],
    ) {
        self.full.clear();
        let blocker = self.world.occluded(&shadow.ray, Scope::All, &mut self.full);
        for ((lane, color), &verdict) in self.lanes.iter_mut().zip(colors).zip(verdicts) {
            self.own.clear();
            let (found, path) = match verdict.scope() {
                Some(Scope::All) if lane.order == Order::NearestFirst => (blocker, self.full.path()),
                Some(scope) => {
                    let found = self.world.occluded_in_order(&shadow.ray, scope, lane.order, &mut self.own);
                    (found, self.own.path())
                }
                None => (None, self.own.path()),
            };
            let dark = found.is_some() || verdict.scope().is_none();
            let mut probe = Probe::new(self.world, &mut lane.policy, self.shader.offset);
            let evidence = Evidence { ray: shadow.ray, verdict, blocker: found };
            lane.worker.learn(hit.at, shadow.light, evidence, &mut probe);
            let head = RayHead {
                kind: RayKind::Shadow,
                light: shadow.light,
                decision: verdict.decision(),
                outcome: if dark { Outcome::Dark } else { Outcome::Lit },
                pixel: hit.pixel,
                parent: (lane.chunk.len() - hit.place) as u32,
            };
            lane.push_shadow(head, path, blocker.is_some(), hit.is_primary);
            if !dark {
                *color += hit.weight * shadow.color;
            }
        }
    }
}
