//! Energy, as data.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::traffic::TrafficClass;

/// Energy of the measured frames.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Energy {
    /// The typical value in J: the sum of [`Energy::by`].
    pub joules: f64,
    /// With every constant at the low end of its range.
    pub low: f64,
    /// With every constant at the high end of its range.
    pub high: f64,
    /// Energy of each part of the machine.
    pub by: BTreeMap<String, f64>,
    /// Of caches and DRAM commands, by class of traffic; units, background and leakage have no class.
    pub classes: BTreeMap<TrafficClass, f64>,
}
