//! The machine: specs of its parts with defaults and sources, the numbers of its parts, and the layout of memory. This
//! module does not depend on any engine. docs/model states the rules that engines follow.

pub mod dispatcher;
pub mod division;
pub(crate) mod energy;
mod footprint;
pub mod intersection;
pub(crate) mod kinds;
pub(crate) mod layout;
pub mod list;
pub(crate) mod parts;
mod scale_model;
pub mod shadow_cache;
pub mod spec;
pub mod stores;
#[cfg(test)]
mod tests;
pub mod traffic;
pub mod traversal;
pub(crate) mod word_traffic;
pub mod writes;

pub use spec::{MachineSpec, SpecError};
