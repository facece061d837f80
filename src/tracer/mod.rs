//! The tracer: turns a frame into rays, once for all policies at the same time, and records what each policy leaves of
//! them.
//!
//! Which rays there are depends on no policy: only which shadow rays are traced does. So every ray is traced once
//! without culling, every policy's stream takes from it what that policy would have done, and the truth that culling is
//! judged by is at hand for each shadow ray.

mod alone;
mod band;
mod frame;
mod lane;
mod learned;
mod shade;
mod spec;
mod whitted;

pub use self::alone::{Alone, Directions, Samples};
pub use self::frame::Tracer;
pub use self::lane::{LaneFrame, WrongDecisions};
pub use self::spec::{PixelOrder, TracerSpec};
