//! What a policy is: what it keeps from frame to frame, and how it decides in one.

use glam::Vec2;

use super::probe::Probe;
use crate::accel::{Order, Ray, Scope, Trail};
use crate::quantity::{LightId, PrimitiveId};
use crate::scene::Light;
use crate::stream::{Decision, StoreEntries};

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
    /// What blocks the ray, if it was traced and is blocked. A dynamic blocker of a ray that was traced among
    /// everything proves that no static triangle blocks.
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
