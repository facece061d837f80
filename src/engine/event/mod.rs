//! The event-driven engine: a part acts only in cycles for which it was woken; in all others it would do nothing.

mod causes;
mod dispatcher;
mod division;
mod engine;
mod intersection;
mod links;
mod list;
mod memory;
mod pipeline;
mod port;
mod ray;
mod routing;
mod shadow_cache;
mod steps;
mod traversal;
mod wheel;

pub(super) use engine::Event;
