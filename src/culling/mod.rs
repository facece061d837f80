//! Culling policies: state kept from frame to frame, which answers shadow rays without tracing them.
//!
//! A [`Policy`] holds the state as of the frame's start. A [`Worker`] decides for one band of the picture. It only
//! reads the policy; what it learns it returns as [`Change`]s, which the policy applies at the frame's end. So no
//! result depends on the order in which bands are traced, or on the number of threads.

pub mod cells;
pub(crate) mod certificates;
pub(crate) mod certified;
mod facts;
pub mod hash_predictor;
pub(crate) mod hints;
pub(crate) mod hybrid;
pub mod knowledge;
pub mod last_occluder;
pub(crate) mod mode_word;
pub mod occluder_grid;
pub(crate) mod off;
pub(crate) mod oracle;
mod policy;
mod probe;
pub mod published;
pub(crate) mod ray_counts;
pub(crate) mod retest;
pub(crate) mod sato;
mod spec;
pub mod symmetric;

pub use self::facts::SceneFacts;
pub use self::policy::{Change, Evidence, Needs, Policy, Primary, Reference, SurfaceHit, Verdict, Worker};
pub use self::probe::Probe;
pub use self::spec::PolicySpec;
