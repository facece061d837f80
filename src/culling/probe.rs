//! A policy's access to the scene and to its stores: every access is recorded.

use glam::Vec3;

use super::cells::Receiver;
use crate::accel::{Ray, Relation, Scope, Shaft, Sight, Silent, Trail, World};
use crate::quantity::{NodeId, PrimitiveId};
use crate::stream::{Effect, Store};

/// Tests triangles and accesses the policy's stores for a worker, and records every access.
pub struct Probe<'a> {
    world: &'a World<'a>,
    trail: &'a mut Trail,
    offset: f32,
    /// Number of tests made to learn which primitives are occluded.
    pub occlusion_tests: u64,
}

impl<'a> Probe<'a> {
    /// A probe that records in `trail`; shadow rays start `offset` off their surface, in world units.
    pub fn new(world: &'a World<'a>, trail: &'a mut Trail, offset: f32) -> Self {
        Self { world, trail, offset, occlusion_tests: 0 }
    }

    /// Tests whether `primitive` lies on `ray`, to learn whether it is occluded.
    pub fn occlusion_test(&mut self, ray: &Ray, primitive: PrimitiveId) -> bool {
        self.occlusion_tests += 1;
        self.world.test(ray, primitive, self.trail).is_some()
    }

    /// Whether a static triangle blocks `ray`; not recorded.
    pub(super) fn statically_blocked(&self, ray: &Ray) -> bool {
        self.world.occluded(ray, Scope::Static, &mut Silent).is_some()
    }

    /// Whether the static triangle `primitive` is certain to block `ray`.
    pub fn surely_blocked(&mut self, ray: &Ray, primitive: PrimitiveId) -> bool {
        self.world.surely_blocked(ray, primitive, self.trail)
    }

    /// A static primitive as a receiver of shadow. Nothing is recorded, because the unit has just tested its triangle.
    pub fn receiver(&self, primitive: PrimitiveId) -> Receiver<'a> {
        Receiver { record: self.world.static_record(primitive), offset: self.offset }
    }

    /// Looks for static blockers of the rays of `shaft`.
    pub fn sight(&mut self, shaft: &Shaft) -> Sight {
        self.world.sight(shaft, self.trail)
    }

    /// The relation of the static triangle `primitive` to the rays of `shaft`.
    pub fn relation(&mut self, shaft: &Shaft, primitive: PrimitiveId) -> Relation {
        self.world.relation(shaft, primitive, self.trail)
    }

    /// Tests whether one visible primitive blocks a shadow ray, with the tracer's own test.
    pub fn blocks(&mut self, ray: &Ray, primitive: PrimitiveId) -> bool {
        self.world.blocks(ray, primitive, self.trail)
    }

    /// Whether a static triangle below a static node blocks a shadow ray.
    pub fn blocked_below(&mut self, ray: &Ray, node: NodeId) -> bool {
        self.world.occluded_below(ray, node, self.trail).is_some()
    }

    /// The static node `levels` levels above a static primitive's leaf; at most the root.
    pub fn ancestor(&self, primitive: PrimitiveId, levels: u32) -> NodeId {
        self.world.ancestor(primitive, levels)
    }

    /// The box around all static triangles; empty if there are none.
    pub fn static_bounds(&self) -> (Vec3, Vec3) {
        self.world.static_bounds()
    }

    /// Reads an entry of a store.
    pub fn read(&mut self, store: Store, index: u32) {
        self.trail.read(store, index);
    }

    /// Writes a whole entry of a store.
    pub fn write(&mut self, store: Store, index: u32) {
        self.trail.write(store, index);
    }

    /// Reads, changes and writes an entry of a store.
    pub fn update(&mut self, store: Store, index: u32) {
        self.trail.update(store, index);
    }

    /// Sets bits of a mode word; `effect` is what the worker knows of the effect.
    pub fn set_bits(&mut self, word: u32, bits: u32, effect: Effect) {
        self.trail.set_bits(word, bits, effect);
    }
}
