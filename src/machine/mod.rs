//! The units of the machine, and what lies between them. The rules are written down in MODEL.md.

pub mod causes;
pub mod dispatcher;
pub mod division;
pub mod host;
pub mod intersection;
pub mod layout;
pub mod links;
pub mod list;
pub mod pipeline;
pub mod ray;
pub mod register;
mod routing;
pub mod shadow_cache;
pub mod source;
pub mod spec;
pub mod stores;
pub mod traversal;
pub mod unloaded;
pub mod word_traffic;

pub use spec::{MachineSpec, SpecError};
