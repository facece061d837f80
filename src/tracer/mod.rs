//! The tracer: turns a frame into rays, once for all policies, and records the rays that each policy leaves to trace.
//!
//! Policies do not change which rays exist, only which shadow rays are traced. So every ray is traced once without
//! culling, and each policy's stream takes its part of that result. The true answer of each shadow ray is then known,
//! to judge the policy by.

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
