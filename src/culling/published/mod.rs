//! The published algorithm (GI09): shadow modes learned ray by ray, and trusted once a primitive was seen whole.

mod policy;
pub mod rules;

pub use self::policy::Published;
