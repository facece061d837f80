//! The published algorithm (GI09): it learns shadow modes ray by ray, and trusts them once a primitive was seen whole.

mod policy;
pub mod rules;

pub use self::policy::Published;
