//! The cycle engine: every part acts in every cycle, strictly by the rules of docs/model. It is slow, and the reference
//! for the event-driven engine. Both share specs, memory layout and tag arrays, but no scheduling and no units.
//!
//! A cycle has two phases: all parts act on the state at the beginning of the cycle; then all links settle.

mod cache;
mod dispatcher;
mod division;
mod dram;
mod engine;
mod flat;
mod gathering;
mod group;
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
