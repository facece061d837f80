//! Replays a ray stream on a machine, at the fidelity levels that replay a stream whole.
//!
//! Every level but `bound` implements [`contract::Engine`] and takes the stream from a [`feed::Feed`]. `event` and
//! `cycle` follow the rules of docs/model and give the same numbers. `profile` times units without stepping through
//! cycles. `bound` computes closed forms. [`whole`] runs a level and checks the identities that every run must keep.

mod bound;
pub(crate) mod check;
pub(crate) mod contract;
mod cycle;
mod demand;
mod error;
mod event;
pub(crate) mod families;
pub(crate) mod feed;
mod frame_log;
mod gathering;
mod horizon;
mod host;
mod items;
mod level;
mod lines;
mod observe;
mod part_set;
mod profile;
mod register;
pub(crate) mod retired;
mod reuse;
mod snapshot;
pub(crate) mod source;
pub(crate) mod store_steps;
pub(crate) mod tally;
#[cfg(test)]
pub(crate) mod tests;
pub(crate) mod turns;
mod unloaded;
pub(crate) mod warm;
mod watchdog;
pub(crate) mod whole;
pub(crate) mod work;

pub use self::demand::Estimate;
pub(crate) use self::demand::estimates;
pub use self::error::RunError;
pub(crate) use self::items::ItemStream;
pub use self::items::{Items, Source};
pub(crate) use self::level::engine;
pub use self::level::{Exact, Level, Sampled};
pub use self::lines::LineStream;
pub use self::observe::{Observer, Seen};
pub use self::reuse::ReuseOf;
pub(crate) use self::reuse::{reuse, reuse_of_frame};
pub use self::snapshot::{Place, Places};
