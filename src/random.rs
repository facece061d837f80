//! Random numbers that are the same in every run: hashes of the purpose of each number.

/// The increment of SplitMix64, the golden ratio's fraction in 64 bits.
pub(crate) const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// The output of SplitMix64 after state `state` (Steele, Lea and Flood 2014): uniform bits for any state.
pub(crate) const fn mix(state: u64) -> u64 {
    let x = state.wrapping_add(GOLDEN);
    let x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ x >> 31
}

/// A number in [0, 1) from the 53 upper bits, all that an `f64` holds.
pub(crate) fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first outputs of SplitMix64 from state 0, by the reference program of Vigna 2015.
    #[test]
    fn it_is_splitmix64() {
        assert_eq!([0, GOLDEN].map(mix), [0xe220_a839_7b1d_cdaf, 0x6e78_9e6a_a1b9_65f4]);
        assert_eq!(unit(u64::MAX), 1.0 - f64::EPSILON / 2.0);
    }
}
