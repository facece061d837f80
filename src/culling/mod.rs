//! Culling policies: what is kept from frame to frame to answer shadow rays without tracing them.
//!
//! A [`Policy`] holds what is kept, as it was at the frame's start. A [`Worker`] decides for one band of the picture; it
//! only reads the policy, and hands in what it learned as [`Change`]s, which the policy takes in at the frame's end. So
//! no result depends on the order in which bands are traced, nor on the number of threads.

pub mod cells;
pub mod certificates;
pub mod certified;
pub mod hash_predictor;
pub mod hints;
pub mod hybrid;
pub mod knowledge;
pub mod last_occluder;
pub mod mode_word;
pub mod occluder_grid;
pub mod off;
pub mod oracle;
pub mod published;
pub mod ray_counts;
pub mod retest;
pub mod sato;
pub mod symmetric;

use glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};

use self::cells::Receiver;
use crate::accel::{Order, Ray, Relation, Scope, Shaft, Sight, Silent, Trail, World};
use crate::quantity::{LightId, NodeId, PrimitiveId};
use crate::scene::{Lamps, Light, Scene};
use crate::stream::{Decision, Effect, Store, StoreEntries};

/// A culling policy as a config names it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum PolicySpec {
    /// No culling: what every saving is measured against.
    Off,
    /// The published algorithm (GI09).
    Published(#[serde(default)] published::rules::PublishedSpec),
    /// The published algorithm with occlusion tests in both directions.
    Symmetric(#[serde(default)] symmetric::SymmetricSpec),
    /// The last blocker of each primitive and light, tested first.
    LastOccluder(#[serde(default)] last_occluder::LastOccluderSpec),
    /// The last blocker of each light and direction, tested first.
    OccluderGrid(#[serde(default)] occluder_grid::OccluderGridSpec),
    /// The part of the tree that blocked a similar ray, searched first.
    HashPredictor(#[serde(default)] hash_predictor::HashPredictorSpec),
    /// No culling, but larger boxes are visited first.
    Sato,
    /// Proofs for cells of receivers; exact.
    Certified(#[serde(default)] certificates::CertificateSpec),
    /// The proofs, and the last blocker tested again where there is none; exact.
    Hybrid(#[serde(default)] hybrid::HybridSpec),
    /// The limit of culling: every static answer known at no cost.
    Oracle,
}

/// What a policy must know of a scene before the first frame.
#[derive(Clone, Copy, Debug)]
pub struct SceneFacts {
    /// Static primitives; dynamic ones count from here on.
    pub statics: u32,
    /// All primitives.
    pub primitives: u32,
    /// Lights.
    pub lights: u32,
    /// Which of them belong to one lamp.
    pub lamps: Lamps,
}

impl SceneFacts {
    /// The facts of a scene.
    pub fn of(scene: &Scene) -> Self {
        Self {
            statics: scene.statics.len() as u32,
            primitives: scene.primitive_count() as u32,
            lights: scene.light_count as u32,
            lamps: scene.lamps,
        }
    }

    /// Whether a primitive can move.
    pub fn is_dynamic(&self, primitive: PrimitiveId) -> bool {
        primitive.0 >= self.statics
    }
}

impl PolicySpec {
    /// Whether it needs a tree of boxes (a BVH).
    pub fn needs_boxes(&self) -> bool {
        matches!(self, Self::HashPredictor(_) | Self::Sato)
    }

    /// The policy at the start of an animation.
    pub fn build(&self, facts: SceneFacts) -> Box<dyn Policy> {
        match self {
            Self::Off => Box::new(off::Off),
            Self::Published(spec) => Box::new(published::Published::new(spec.rules(), facts)),
            Self::Symmetric(spec) => Box::new(published::Published::new(spec.rules(), facts)),
            Self::LastOccluder(spec) => Box::new(spec.build(facts)),
            Self::OccluderGrid(spec) => Box::new(spec.build(facts)),
            Self::HashPredictor(spec) => Box::new(hash_predictor::HashPredictor::new(*spec, facts)),
            Self::Sato => Box::new(sato::Sato),
            Self::Certified(spec) => Box::new(certified::Certified::new(*spec, facts)),
            Self::Hybrid(spec) => Box::new(hybrid::Hybrid::new(*spec, facts)),
            Self::Oracle => Box::new(oracle::Oracle),
        }
    }

    /// Every policy with its defaults.
    pub fn all() -> Vec<(&'static str, Self)> {
        vec![
            ("Off", Self::Off),
            ("Published", Self::Published(Default::default())),
            ("Symmetric", Self::Symmetric(Default::default())),
            ("LastOccluder", Self::LastOccluder(Default::default())),
            ("OccluderGrid", Self::OccluderGrid(Default::default())),
            ("HashPredictor", Self::HashPredictor(Default::default())),
            ("Sato", Self::Sato),
            ("Certified", Self::Certified(Default::default())),
            ("Hybrid", Self::Hybrid(Default::default())),
            ("Oracle", Self::Oracle),
        ]
    }

    /// Whether it never decides wrongly. (A policy that does all the same is broken.)
    pub fn is_exact(&self) -> bool {
        match self {
            Self::Published(_) | Self::Symmetric(_) => false,
            Self::Off | Self::LastOccluder(_) | Self::OccluderGrid(_) | Self::HashPredictor(_) | Self::Sato => true,
            Self::Certified(_) | Self::Hybrid(_) | Self::Oracle => true,
        }
    }
}

/// What a policy needs the tracer to do for it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Needs {
    /// It looks at the pixels before the current one.
    pub references: bool,
    /// It reads what it learned earlier in the same frame: the frame must be traced as one band, in raster order.
    pub live: bool,
    /// It must know before the first decision how many pixels show each primitive.
    pub census: bool,
}

/// What a policy wants kept; `kind` is the policy's own code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Change {
    /// What is to be done.
    pub kind: u32,
    /// To which entry.
    pub index: u32,
    /// With which value.
    pub value: u32,
}

/// What is kept from frame to frame.
pub trait Policy: Send + Sync {
    /// What it needs of the tracer.
    fn needs(&self) -> Needs {
        Needs::default()
    }

    /// The order in which its shadow rays visit the children of a node.
    fn order(&self) -> Order {
        Order::NearestFirst
    }

    /// A frame begins with these lights; `census` has the pixels of each primitive if [`Needs::census`] asks for them.
    fn begin_frame(&mut self, _lights: &[Light], _census: Option<Vec<u32>>) {}

    /// Somebody to decide for a band.
    fn worker(&self) -> Box<dyn Worker + '_>;

    /// A frame ends: takes in what all workers learned, in the order of their bands, and records in `steps` the memory
    /// accesses of doing so.
    fn end_frame(&mut self, _changes: &[Change], _steps: &mut Trail) {}

    /// A primitive's mode word with the modes of the first fifteen lights, if the policy keeps one.
    fn word(&self, _primitive: PrimitiveId) -> Option<u32> {
        None
    }

    /// Sizes of the stores that it keeps.
    fn stores(&self) -> StoreEntries {
        StoreEntries::default()
    }
}

/// Where a shadow ray starts.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceHit {
    /// The primitive.
    pub primitive: PrimitiveId,
    /// 1 for a primary ray's hit, 2 for that of the first secondary ray, and so on.
    pub depth: u32,
    /// Barycentric coordinates of corners 1 and 2.
    pub barycentric: Vec2,
    /// Whether the ray starts on the counter-clockwise side.
    pub outside: bool,
}

/// A pixel before the current one.
#[derive(Clone, Copy, Debug)]
pub struct Reference {
    /// What it shows.
    pub primitive: PrimitiveId,
    /// Its primary ray.
    pub ray: Ray,
}

/// What only a primary hit has.
#[derive(Clone, Copy, Debug)]
pub struct Primary<'a> {
    /// The pixel's ray.
    pub ray: &'a Ray,
    /// Whether the pixel is at the picture's edge.
    pub border: bool,
    /// The left, the upper, the upper left and the upper right pixel, where there is one that shows something.
    pub references: &'a [Option<Reference>; 4],
}

/// What a policy says of a shadow ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Trace it.
    Trace,
    /// No static triangle blocks it: trace it among dynamic ones.
    DynamicOnly,
    /// It is blocked: trace nothing.
    Dark,
}

impl Verdict {
    /// How the stream records it.
    pub fn decision(self) -> Decision {
        match self {
            Self::Trace => Decision::Trace,
            Self::DynamicOnly => Decision::DynamicOnly,
            Self::Dark => Decision::Skip,
        }
    }

    /// What the ray is traced among, if it is traced.
    pub fn scope(self) -> Option<Scope> {
        match self {
            Self::Trace => Some(Scope::All),
            Self::DynamicOnly => Some(Scope::Dynamic),
            Self::Dark => None,
        }
    }
}

/// What a shadow ray showed.
#[derive(Clone, Copy, Debug)]
pub struct Evidence {
    /// The shadow ray.
    pub ray: Ray,
    /// What the policy had said.
    pub verdict: Verdict,
    /// What blocks the ray, if it was traced and is blocked. A dynamic blocker of a ray that was traced among everything
    /// proves that no static triangle blocks.
    pub blocker: Option<PrimitiveId>,
}

/// Decides for one band of the picture.
pub trait Worker {
    /// A primary or secondary ray has hit something.
    fn hit(&mut self, _hit: SurfaceHit, _primary: Option<&Primary<'_>>, _probe: &mut Probe<'_>) {}

    /// Whether the shadow ray `ray` from `hit` to `light` must be traced.
    fn decide(&mut self, hit: SurfaceHit, light: LightId, ray: &Ray, probe: &mut Probe<'_>) -> Verdict;

    /// The shadow ray's answer is known.
    fn learn(&mut self, _hit: SurfaceHit, _light: LightId, _evidence: Evidence, _probe: &mut Probe<'_>) {}

    /// What is to be kept.
    fn finish(self: Box<Self>) -> Vec<Change> {
        Vec::new()
    }
}

/// A worker's hands: tests triangles and touches the policy's stores, and records every access.
pub struct Probe<'a> {
    world: &'a World<'a>,
    trail: &'a mut Trail,
    offset: f32,
    /// Tests made to learn which primitives are occluded.
    pub occlusion_tests: u64,
}

impl<'a> Probe<'a> {
    /// Hands that record in `trail`; shadow rays start `offset` off their surface, in world units.
    pub fn new(world: &'a World<'a>, trail: &'a mut Trail, offset: f32) -> Self {
        Self { world, trail, offset, occlusion_tests: 0 }
    }

    /// Tests whether `primitive` lies on `ray`, to learn whether it is occluded.
    pub fn occlusion_test(&mut self, ray: &Ray, primitive: PrimitiveId) -> bool {
        self.occlusion_tests += 1;
        self.world.test(ray, primitive, self.trail).is_some()
    }

    /// Whether a static triangle blocks `ray`; recorded nowhere.
    pub(super) fn statically_blocked(&self, ray: &Ray) -> bool {
        self.world.occluded(ray, Scope::Static, &mut Silent).is_some()
    }

    /// Whether the static triangle `primitive` is certain to block `ray`.
    pub fn surely_blocked(&mut self, ray: &Ray, primitive: PrimitiveId) -> bool {
        self.world.surely_blocked(ray, primitive, self.trail)
    }

    /// A static primitive as a receiver of shadow. Nothing is recorded: the unit has just tested its triangle.
    pub fn receiver(&self, primitive: PrimitiveId) -> Receiver<'a> {
        Receiver { record: self.world.static_record(primitive), offset: self.offset }
    }

    /// Looks for static blockers of the rays of `shaft`.
    pub fn sight(&mut self, shaft: &Shaft) -> Sight {
        self.world.sight(shaft, self.trail)
    }

    /// What the static triangle `primitive` does to the rays of `shaft`.
    pub fn relation(&mut self, shaft: &Shaft, primitive: PrimitiveId) -> Relation {
        self.world.relation(shaft, primitive, self.trail)
    }

    /// Tests whether one visible primitive blocks a shadow ray: what the tracer would say of it.
    pub fn blocks(&mut self, ray: &Ray, primitive: PrimitiveId) -> bool {
        self.world.blocks(ray, primitive, self.trail)
    }

    /// Whether a static triangle below a static node blocks a shadow ray.
    pub fn blocked_below(&mut self, ray: &Ray, node: NodeId) -> bool {
        self.world.occluded_below(ray, node, self.trail).is_some()
    }

    /// The static node `levels` levels above a static primitive's leaf, or the root.
    pub fn ancestor(&self, primitive: PrimitiveId, levels: u32) -> NodeId {
        self.world.ancestor(primitive, levels)
    }

    /// The box around all static triangles; empty without any.
    pub fn static_bounds(&self) -> (Vec3, Vec3) {
        self.world.static_bounds()
    }

    /// Reads an entry of a store.
    pub fn read(&mut self, store: Store, index: u32) {
        self.trail.read(store, index);
    }

    /// Writes an entry of a store whole.
    pub fn write(&mut self, store: Store, index: u32) {
        self.trail.write(store, index);
    }

    /// Reads, changes and writes an entry of a store.
    pub fn update(&mut self, store: Store, index: u32) {
        self.trail.update(store, index);
    }

    /// Sets bits of a mode word, with this effect as far as the worker knows.
    pub fn set_bits(&mut self, word: u32, bits: u32, effect: Effect) {
        self.trail.set_bits(word, bits, effect);
    }
}
