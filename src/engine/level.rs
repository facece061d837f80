//! Fidelity levels that replay a stream whole.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::contract::Engine;
use super::cycle::Cycle;
use super::event::Event;
use super::profile::Profile;
use super::retired::WithoutRetired;
use crate::machine::MachineSpec;
use crate::stream::Header;

/// A fidelity level that replays a stream whole, in one pass; from the fastest to the slowest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Closed-form bounds, which no machine can beat.
    Bound,
    /// Exact cache contents for an access order that approximates the machine's, and times from when resources are
    /// free.
    Profile,
    /// The rules of docs/model, fast: a part acts only in cycles in which it has something to do.
    Event,
    /// The rules of docs/model, plain and slow: every part acts in every cycle.
    Cycle,
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self, f)
    }
}

/// A level that follows the rules of docs/model cycle by cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exact {
    /// See [`Level::Event`].
    Event,
    /// See [`Level::Cycle`].
    Cycle,
}

impl From<Exact> for Level {
    fn from(exact: Exact) -> Self {
        match exact {
            Exact::Event => Self::Event,
            Exact::Cycle => Self::Cycle,
        }
    }
}

/// The fidelity level that replays the windows of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(remote = "Self")]
pub enum Sampled {
    /// As fidelity level `Profile`.
    Profile,
    /// As fidelity level `Event`.
    Event,
}

impl From<Sampled> for Level {
    fn from(sampled: Sampled) -> Self {
        match sampled {
            Sampled::Profile => Self::Profile,
            Sampled::Event => Self::Event,
        }
    }
}

impl Serialize for Sampled {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        Self::serialize(self, to)
    }
}

impl<'de> Deserialize<'de> for Sampled {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        Self::deserialize(WithoutRetired(from))
    }
}

/// An engine of `level` for a stream with `header`; `None` for [`Level::Bound`], which simulates nothing over time.
pub(crate) fn engine(level: Level, machine: &MachineSpec, header: &Header) -> Option<Box<dyn Engine>> {
    match level {
        Level::Bound => None,
        Level::Profile => Some(Box::new(Profile::new(machine, header))),
        Level::Event => Some(Box::new(Event::new(machine, header))),
        Level::Cycle => Some(Box::new(Cycle::new(machine, header))),
    }
}
