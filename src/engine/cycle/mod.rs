//! The plain engine: every part acts in every cycle, as MODEL.md says, and nothing else. It is slow, and the truth that
//! the event-driven engine is held to: the two share specs, memory layout and tag arrays, no scheduling and no unit.
//!
//! A cycle has two phases: all parts act on what was there when the cycle began; then all links settle.

mod cache;
mod division;
mod dram;
mod engine;
mod flat;
mod gathering;
mod group;
mod host;
mod intersection;
mod l2;
mod link;
mod list;
mod port;
mod ray;
mod request;
mod shadow_cache;
mod traversal;
mod unit;
mod wires;
mod words;

pub(super) use self::engine::Cycle;
