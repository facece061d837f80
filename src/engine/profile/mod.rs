//! The profile rung: exact contents of all caches, accessed in an order that stands for the machine's, and time by what
//! is free when.
//!
//! A ray's step is one event, at which everything is decided: when a unit is free, which levels have the line, when it
//! comes, and so when the ray goes on. Rays in flight are limited as in the machine and overtake each other where they
//! wait for lines, which is what the order of accesses hangs on. Left out of MODEL.md's rules: fills that wait for
//! room, one fill a cycle, and most of the order within a cycle. An operation takes its place in the pipeline when it
//! asks for data, not when it has them. The DRAM serves requests to a bank nearly in the order in which they come.

mod agenda;
mod crossing;
mod curves;
mod dispatch;
mod dram;
mod engine;
mod entries;
mod flight;
mod host;
mod level;
mod memory;
mod port;
mod slots;
mod unit;
mod watch;
mod whereabouts;

pub(super) use self::curves::{Curves, Heat};
pub(super) use self::engine::Profile;
pub(super) use self::watch::Watch;
