//! Energy constants of a machine's operations, accesses and leakage, with their sources and ranges.
//!
//! Sources. H: Horowitz, "Computing's energy problem", ISSCC 2014, figure 1.1.9 (45 nm, 0.9 V): an FP32 addition takes
//! 0.9 pJ, a multiplication 3.7 pJ, a read of 64 bits from a cache of 8 KB, 32 KB and 1 MB takes 10, 20 and 100 pJ. A:
//! Arches (University of Utah), `dual-streaming.hpp`: blocks of 128 bytes cost 31.1 pJ a read in an L1 of 64 KB and 379
//! pJ in an L2 of 4 MB, tags 0.66 and 7.6 pJ; they leak 7.2 and 185 mW a bank. TI: Nah et al., "T&I Engine", SIGGRAPH
//! Asia 2011, table 4, operators a unit. Constants without a source are marked as assumed.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::spread::Spread;
use crate::stream::Structure;

/// Constants of a machine's energy, each with the lowest, a typical and the highest value.
///
/// Source: docs/model/energy.md has a table of all constants with their sources.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(extend("unit" = "pJ"))]
pub struct EnergySpec {
    /// An operation of a traversal unit on a node of a BVH2, in pJ.
    pub bvh2_node: Spread,
    /// An operation of a traversal unit on a node of a CwBVH, in pJ.
    pub cwbvh_node: Spread,
    /// An operation of a traversal unit on a node of a kd-tree, in pJ.
    pub kd_node: Spread,
    /// An operation of a list unit, in pJ.
    pub list: Spread,
    /// A pass of an intersection unit, in pJ.
    pub intersection: Spread,
    /// An operation of a division unit, in pJ.
    pub division: Spread,
    /// An operation of a shadow-cache unit, in pJ.
    pub shadow_cache: Spread,
    /// A ray that the dispatcher hands over, in pJ.
    pub dispatcher: Spread,
    /// A byte that goes through a FIFO from or to the host, in pJ.
    pub fifo_byte: Spread,
    /// Energy of caches: reads and writes of lines, and leakage.
    pub cache: CacheEnergy,
    /// Leakage of a unit of any kind, in mW.
    #[schemars(extend("unit" = "mW"))]
    pub unit_leakage: Spread,
}

/// The model of a cache's energy. An access costs `byte_pj x bytes of a line x (size / 64 KB) ^ exponent`, plus one tag
/// per way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct CacheEnergy {
    /// A byte of a line in a cache of 64 KB, in pJ.
    #[schemars(extend("unit" = "pJ"))]
    pub byte_pj: Spread,
    /// Exponent of the growth of the energy per byte with the cache's size.
    pub exponent: Spread,
    /// A tag of one way in a cache of 64 KB, in pJ. It grows with the size as a byte does.
    #[schemars(extend("unit" = "pJ"))]
    pub tag_pj: Spread,
    /// Leakage per KB, in mW.
    #[schemars(extend("unit" = "mW"))]
    pub leakage: Spread,
}

/// Energy in pJ of `additions` and `multiplications` (H) and of compares and integer operations, a tenth of an addition
/// each. Low: the bare operators. Typical: with pipeline registers and control (twice as much, assumed). High: with all
/// of a wide ray state moved from stage to stage (four times as much, assumed).
const fn operators(additions: f64, multiplications: f64, others: f64) -> Spread {
    let bare = 0.9 * additions + 3.7 * multiplications + 0.09 * others;
    Spread::new(bare, 2.0 * bare, 4.0 * bare)
}

impl Default for EnergySpec {
    fn default() -> Self {
        Self {
            // Two boxes: 12 subtractions, 12 multiplications, 14 compares, and the order of the children.
            bvh2_node: operators(12.0, 12.0, 16.0),
            // Eight boxes as Ylitie et al. 2017 test them: 48 multiply-adds, 56 compares.
            cwbvh_node: operators(48.0, 48.0, 64.0),
            // TI: an addition, a multiplication and 3 compares; the stack (assumed: 8 integer operations).
            kd_node: operators(1.0, 1.0, 11.0),
            // TI, table 4: a list unit has no FP operators; 8 integer operations are assumed.
            list: operators(0.0, 0.0, 8.0),
            // TI: 7 additions, 7 multiplications, 3 compares a pass.
            intersection: operators(7.0, 7.0, 3.0),
            // TI: 3 multiplications and a reciprocal, taken as 4 multiplications and 4 additions (two Newton steps).
            division: operators(4.0, 7.0, 0.0),
            // A mask, a shift and a compare of 32-bit words: 8 integer operations are assumed.
            shadow_cache: operators(0.0, 0.0, 8.0),
            // TI, table 4: 6 additions, 9 multiplications, a reciprocal and 12 compares a ray.
            dispatcher: operators(10.0, 13.0, 12.0),
            // H: 64 bits of 8 KB to 32 KB in 10 to 20 pJ, a write and a read; the low end is A's byte.
            fifo_byte: Spread::new(0.5, 2.5, 5.0),
            cache: CacheEnergy::default(),
            // Assumed: 20 to 50 mW a mm2 at 28 nm; GauTracer (2026), table III, has units of 0.036 to 0.075 mm2.
            unit_leakage: Spread::new(0.7, 1.8, 3.7),
        }
    }
}

impl Default for CacheEnergy {
    fn default() -> Self {
        Self {
            // A: 31.1 pJ a block of 128 B; H: 28 pJ for 8 B, from its law that energy grows with the size's root.
            byte_pj: Spread { low: 0.243, typical: 0.92, high: 3.5 },
            // H: 10, 20, 100 pJ for 8, 32, 1024 KB; A: 31.1 and 379 pJ for 64 KB and 4 MB.
            exponent: Spread { low: 0.46, typical: 0.5, high: 0.6 },
            // A: 0.66 pJ for all ways of a set, taken as four (assumed).
            tag_pj: Spread { low: 0.1, typical: 0.165, high: 0.66 },
            // A: 185 mW for 4 MB and 7.2 mW for 64 KB.
            leakage: Spread { low: 0.045, typical: 0.071, high: 0.1125 },
        }
    }
}

impl EnergySpec {
    /// An operation of a traversal unit, in pJ.
    pub fn node(&self, structure: Structure) -> Spread {
        match structure {
            Structure::Bvh2 => self.bvh2_node,
            Structure::CwBvh => self.cwbvh_node,
            Structure::KdTree => self.kd_node,
        }
    }
}

impl CacheEnergy {
    /// Energy in pJ of a read or write of a line in a cache (or a bank) of `bytes` bytes.
    pub fn access(&self, bytes: u64, ways: u64, line_bytes: u64) -> Spread {
        let line = self.byte_pj * line_bytes as f64 + self.tag_pj * ways as f64;
        let size = bytes as f64 / 65_536.0;
        let Spread { low, typical, high } = self.exponent;
        // Below 64 KB a larger exponent makes an access cheaper.
        let [low, high] = if size < 1.0 { [high, low] } else { [low, high] };
        Spread::new(line.low * size.powf(low), line.typical * size.powf(typical), line.high * size.powf(high))
    }

    /// Leakage in mW of a cache of `bytes` bytes.
    pub fn leakage(&self, bytes: u64) -> Spread {
        self.leakage * (bytes as f64 / 1024.0)
    }
}
