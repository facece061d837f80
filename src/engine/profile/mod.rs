//! The profile level: exact contents of all caches, accessed in an order that approximates the machine's. Timing
//! follows from the cycles in which resources are free.
//!
//! Each step of a ray is one event, which decides everything: when a unit is free, which levels have the line, when the
//! line comes, and so when the ray continues. Rays in flight are limited as in the machine. They overtake each other
//! while they wait for lines, which determines the order of accesses. Omitted from the rules: fills that wait
//! for room, one fill per cycle, and most of the order within a cycle. An operation takes its place in the pipeline
//! when it requests its data, not when the data comes. The DRAM serves requests to a bank nearly in arrival order.

mod advance;
mod agenda;
mod curves;
mod dispatch;
mod division;
mod dram;
mod engine;
mod entries;
mod flight;
mod issue_queues;
mod memory;
mod port;
mod slots;
mod timed_cache;
mod unit;
mod watch;
mod whereabouts;

pub(super) use self::curves::{Curves, Heat};
pub(super) use self::engine::Profile;
pub(super) use self::watch::Watch;
