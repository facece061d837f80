//! The interface of the timing side: a machine replays a stream at a fidelity level.
//!
//! [`Replay::new`] checks the machine and the stream once. Types exclude wrong use: a [`Fidelity`] may take several
//! passes and needs a [`Source`] that can be opened again; a [`OnePass`] needs items once; an [`Exact`] level can be
//! observed.

mod face;
mod fidelity;
mod grown;
mod idle_units;
mod stream_file;
mod thinned;
mod together;

pub use self::face::{Observed, Replay};
pub use self::fidelity::{Fidelity, OnePass};
pub(crate) use self::grown::energy_by_model;
pub(crate) use self::idle_units::{are_units_idle, with_other_units};
pub use self::stream_file::StreamFile;
pub(crate) use self::thinned::Thinned;
pub(crate) use self::together::Together;
pub use crate::engine::{
    Estimate, Exact, Items, Level, LineStream, Observer, Place, Places, ReuseOf, RunError, Sampled, Seen, Source,
};
pub use crate::ranged::Share;
pub(crate) use crate::sampling::{Cut, Lengths, Verdict};
