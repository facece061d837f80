//! The energy data in a DRAM part's file: data-sheet currents, or a published energy per bit.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::spread::Spread;

/// How the energy of a DRAM part is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum DramEnergy {
    /// As currents: they give the energy per command and the background power.
    Currents(Currents),
    /// As one figure per bit: all energy between the cells and the pins of the other side, background included.
    PerBit {
        /// Energy in picojoules per bit.
        #[schemars(extend("unit" = "pJ a bit"))]
        pj: Spread,
    },
}

/// The currents of one device, in mA, and the constants that turn them into energy. Idle power-down is not modelled.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("unit" = "mA"))]
pub struct Currents {
    /// Supply voltage in V.
    #[schemars(extend("unit" = "V"))]
    pub volt: f64,
    /// Devices per channel.
    #[schemars(extend("unit" = "devices"))]
    pub devices: u32,
    /// Current of repeated activates and precharges of one bank.
    pub idd0: f64,
    /// Current with all banks precharged.
    pub idd2n: f64,
    /// Current with an open bank.
    pub idd3n: f64,
    /// Current of back-to-back reads.
    pub idd4r: f64,
    /// Current of back-to-back writes.
    pub idd4w: f64,
    /// Current of back-to-back refreshes.
    pub idd5: f64,
    /// Factor on all currents: data sheets give maxima, and vendors differ.
    #[schemars(extend("unit" = "factor"))]
    pub factor: Spread,
    /// Energy of drivers and termination in picojoules per bit, which these currents do not include.
    #[schemars(extend("unit" = "pJ a bit"))]
    pub io_pj_per_bit: Spread,
}

/// `Currents::check` refuses values that are not finite.
impl Eq for Currents {}
