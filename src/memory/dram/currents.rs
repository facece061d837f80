//! The energy data in a DRAM part's file: data-sheet currents, or a published energy per bit.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::spread::Spread;

/// How the energy of a part is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum DramEnergy {
    /// By currents: energy a command and background power.
    Currents(Currents),
    /// By a figure for all that a bit costs between the cells and the pins of the other side, background included.
    PerBit {
        /// Picojoules a bit.
        #[schemars(extend("unit" = "pJ a bit"))]
        pj: Spread,
    },
}

/// The currents of one device, in mA, and what else makes energy of them. Idle power-down is not modelled.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("unit" = "mA"))]
pub struct Currents {
    /// Supply voltage in V.
    #[schemars(extend("unit" = "V"))]
    pub volt: f64,
    /// Devices that make up a channel.
    #[schemars(extend("unit" = "devices"))]
    pub devices: u32,
    /// Activate and precharge of one bank, again and again.
    pub idd0: f64,
    /// All banks precharged.
    pub idd2n: f64,
    /// A bank open.
    pub idd3n: f64,
    /// Reads one after another.
    pub idd4r: f64,
    /// Writes one after another.
    pub idd4w: f64,
    /// Refreshes one after another.
    pub idd5: f64,
    /// Factors on all currents: data sheets give maxima, and those of vendors differ.
    #[schemars(extend("unit" = "factor"))]
    pub factor: Spread,
    /// Picojoules a bit for drivers and termination, which these currents leave out.
    #[schemars(extend("unit" = "pJ a bit"))]
    pub io_pj_per_bit: Spread,
}

/// `f64` fields allow `Eq` here: files hold finite values only.
impl Eq for Currents {}
