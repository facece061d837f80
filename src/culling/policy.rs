//! The interface of a policy: its state from frame to frame, and its decisions within a frame.

use glam::Vec2;

use super::probe::Probe;
use crate::accel::{Order, Ray, Scope, Trail};
use crate::quantity::{LightId, PrimitiveId};
use crate::scene::Light;
use crate::stream::{Decision, StoreEntries};

/// What a policy requires from the tracer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Needs {
    /// It uses the pixels before the current one.
    pub references: bool,
    /// It reads what it learned earlier in the same frame: the frame must be traced as one band, in raster order.
    pub live: bool,
    /// It needs the number of pixels of each primitive before the first decision.
    pub census: bool,
}

/// A change of the policy's state; `kind` is the policy's own code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Change {
    /// The kind of change.
    pub kind: u32,
    /// The entry to change.
    pub index: u32,
    /// The new value.
    pub value: u32,
}

/// The state kept from frame to frame.
pub trait Policy: Send + Sync {
    /// What the policy requires from the tracer.
    fn needs(&self) -> Needs {
        Needs::default()
    }

    /// The order in which its shadow rays visit the children of a node.
    fn order(&self) -> Order {
        Order::NearestFirst
    }

    /// Starts a frame with these lights. `census` has the number of pixels of each primitive, if [`Needs::census`]
    /// asks for it.
    fn begin_frame(&mut self, _lights: &[Light], _census: Option<Vec<u32>>) {}

    /// A worker that decides for one band.
    fn worker(&self) -> Box<dyn Worker + '_>;

    /// Ends a frame: applies the changes of all workers, in the order of their bands, and records the memory accesses
    /// in `steps`.
    fn end_frame(&mut self, _changes: &[Change], _steps: &mut Trail) {}

    /// A primitive's mode word with the modes of the first fifteen lights, if the policy keeps one.
    fn word(&self, _primitive: PrimitiveId) -> Option<u32> {
        None
    }

    /// Sizes of the policy's stores.
    fn stores(&self) -> StoreEntries {
        StoreEntries::default()
    }
}

/// The hit that a shadow ray starts from.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceHit {
    /// The primitive.
    pub primitive: PrimitiveId,
    /// 1 for a primary ray's hit, 2 for the first secondary ray's hit, and so on.
    pub depth: u32,
    /// Barycentric coordinates of corners 1 and 2.
    pub barycentric: Vec2,
    /// Whether the ray starts on the counter-clockwise side.
    pub outside: bool,
}

/// A pixel before the current one.
#[derive(Clone, Copy, Debug)]
pub struct Reference {
    /// The primitive that the pixel shows.
    pub primitive: PrimitiveId,
    /// Its primary ray.
    pub ray: Ray,
}

/// Data that only a primary hit has.
#[derive(Clone, Copy, Debug)]
pub struct Primary<'a> {
    /// The pixel's ray.
    pub ray: &'a Ray,
    /// Whether the pixel is at the picture's edge.
    pub border: bool,
    /// The left, upper, upper left and upper right pixels; `None` outside the picture or where nothing is hit.
    pub references: &'a [Option<Reference>; 4],
}

/// A policy's decision on a shadow ray.
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
    /// The decision in the stream's form.
    pub fn decision(self) -> Decision {
        match self {
            Self::Trace => Decision::Trace,
            Self::DynamicOnly => Decision::DynamicOnly,
            Self::Dark => Decision::Skip,
        }
    }

    /// The triangles to trace the ray among, if it is traced.
    pub fn scope(self) -> Option<Scope> {
        match self {
            Self::Trace => Some(Scope::All),
            Self::DynamicOnly => Some(Scope::Dynamic),
            Self::Dark => None,
        }
    }
}

/// The answer of a shadow ray.
#[derive(Clone, Copy, Debug)]
pub struct Evidence {
    /// The shadow ray.
    pub ray: Ray,
    /// The policy's decision.
    pub verdict: Verdict,
    /// The blocker, if the ray was traced and is blocked. A dynamic blocker of a ray that was traced among all
    /// triangles proves that no static triangle blocks it.
    pub blocker: Option<PrimitiveId>,
}

/// Decides for one band of the picture.
pub trait Worker {
    /// A primary or secondary ray has hit a primitive.
    fn hit(&mut self, _hit: SurfaceHit, _primary: Option<&Primary<'_>>, _probe: &mut Probe<'_>) {}

    /// Whether the shadow ray `ray` from `hit` to `light` must be traced.
    fn decide(&mut self, hit: SurfaceHit, light: LightId, ray: &Ray, probe: &mut Probe<'_>) -> Verdict;

    /// Receives a shadow ray's answer.
    fn learn(&mut self, _hit: SurfaceHit, _light: LightId, _evidence: Evidence, _probe: &mut Probe<'_>) {}

    /// The changes to keep.
    fn finish(self: Box<Self>) -> Vec<Change> {
        Vec::new()
    }
}
