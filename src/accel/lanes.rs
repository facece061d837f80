//! Several numbers at once: the vector instructions that a traversal needs.
//!
//! All operations follow IEEE 754, with one rounding each, so every implementation gives the same bits. A processor
//! without AVX2 uses arrays, which the compiler vectorizes as well as it can.

use std::array;

#[cfg(target_arch = "x86_64")]
use pulp::{cast, x86::V3};

/// All operations that a traversal needs.
pub(super) trait Processor: Lanes<8> + Lanes<4> + First {}

impl<P: Lanes<8> + Lanes<4> + First> Processor for P {}

/// Operations on `N` numbers of 32 bits, lane by lane. Comparisons give a bit for each lane; a comparison with a NaN
/// is false.
pub(super) trait Lanes<const N: usize>: Copy {
    /// `N` numbers.
    type F: Copy;

    /// Reads `N` numbers.
    fn load(self, numbers: &[f32; N]) -> Self::F;
    /// Writes `N` numbers to an array.
    fn store(self, numbers: Self::F) -> [f32; N];
    /// The same number in all lanes.
    fn splat(self, number: f32) -> Self::F;
    /// The sum.
    fn add(self, a: Self::F, b: Self::F) -> Self::F;
    /// The difference.
    fn sub(self, a: Self::F, b: Self::F) -> Self::F;
    /// The product.
    fn mul(self, a: Self::F, b: Self::F) -> Self::F;
    /// The smaller number; `b` if one is a NaN.
    fn smaller(self, a: Self::F, b: Self::F) -> Self::F;
    /// The larger number; `b` if one is a NaN.
    fn larger(self, a: Self::F, b: Self::F) -> Self::F;
    /// `a`, with the sign changed in lanes where `signs` is negative.
    fn flip(self, a: Self::F, signs: Self::F) -> Self::F;
    /// Whether `a < b`.
    fn below(self, a: Self::F, b: Self::F) -> u32;
    /// Whether `a <= b`.
    fn at_most(self, a: Self::F, b: Self::F) -> u32;
}

/// Lanes as arrays, for every processor.
#[derive(Clone, Copy)]
pub(super) struct Plain;

/// Applies `of` to each pair of numbers.
#[inline(always)]
fn each<const N: usize>(a: [f32; N], b: [f32; N], of: impl Fn(f32, f32) -> f32) -> [f32; N] {
    array::from_fn(|at| of(a[at], b[at]))
}

/// A bit for each pair of numbers: the result of `is`.
#[inline(always)]
fn bits<const N: usize>(a: [f32; N], b: [f32; N], is: impl Fn(f32, f32) -> bool) -> u32 {
    (0..N).fold(0, |bits, at| bits | u32::from(is(a[at], b[at])) << at)
}

impl<const N: usize> Lanes<N> for Plain {
    type F = [f32; N];

    #[inline(always)]
    fn load(self, numbers: &[f32; N]) -> [f32; N] {
        *numbers
    }

    #[inline(always)]
    fn store(self, numbers: [f32; N]) -> [f32; N] {
        numbers
    }

    #[inline(always)]
    fn splat(self, number: f32) -> [f32; N] {
        [number; N]
    }

    #[inline(always)]
    fn add(self, a: [f32; N], b: [f32; N]) -> [f32; N] {
        each(a, b, |a, b| a + b)
    }

    #[inline(always)]
    fn sub(self, a: [f32; N], b: [f32; N]) -> [f32; N] {
        each(a, b, |a, b| a - b)
    }

    #[inline(always)]
    fn mul(self, a: [f32; N], b: [f32; N]) -> [f32; N] {
        each(a, b, |a, b| a * b)
    }

    #[inline(always)]
    fn smaller(self, a: [f32; N], b: [f32; N]) -> [f32; N] {
        each(a, b, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    fn larger(self, a: [f32; N], b: [f32; N]) -> [f32; N] {
        each(a, b, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    fn flip(self, a: [f32; N], signs: [f32; N]) -> [f32; N] {
        each(a, signs, |a, sign| f32::from_bits(a.to_bits() ^ (sign.to_bits() & (1 << 31))))
    }

    #[inline(always)]
    fn below(self, a: [f32; N], b: [f32; N]) -> u32 {
        bits(a, b, |a, b| a < b)
    }

    #[inline(always)]
    fn at_most(self, a: [f32; N], b: [f32; N]) -> u32 {
        bits(a, b, |a, b| a <= b)
    }
}

/// Implements lanes by the instructions of a level of x86-64. The comparison numbers are the codes of `vcmpps` for
/// "less than" and for "less or equal, ordered, quiet".
macro_rules! x86_lanes {
    ($lanes:literal, $register:ident, $level:ident: $splat:ident, $add:ident, $sub:ident, $mul:ident, $min:ident,
        $max:ident, $and:ident, $xor:ident, $compare:ident, $bits:ident) => {
        #[cfg(target_arch = "x86_64")]
        impl Lanes<$lanes> for V3 {
            type F = std::arch::x86_64::$register;

            #[inline(always)]
            fn load(self, numbers: &[f32; $lanes]) -> Self::F {
                cast(*numbers)
            }

            #[inline(always)]
            fn store(self, numbers: Self::F) -> [f32; $lanes] {
                cast(numbers)
            }

            #[inline(always)]
            fn splat(self, number: f32) -> Self::F {
                self.$level.$splat(number)
            }

            #[inline(always)]
            fn add(self, a: Self::F, b: Self::F) -> Self::F {
                self.$level.$add(a, b)
            }

            #[inline(always)]
            fn sub(self, a: Self::F, b: Self::F) -> Self::F {
                self.$level.$sub(a, b)
            }

            #[inline(always)]
            fn mul(self, a: Self::F, b: Self::F) -> Self::F {
                self.$level.$mul(a, b)
            }

            #[inline(always)]
            fn smaller(self, a: Self::F, b: Self::F) -> Self::F {
                self.$level.$min(a, b)
            }

            #[inline(always)]
            fn larger(self, a: Self::F, b: Self::F) -> Self::F {
                self.$level.$max(a, b)
            }

            #[inline(always)]
            fn flip(self, a: Self::F, signs: Self::F) -> Self::F {
                self.$level.$xor(a, self.$level.$and(signs, self.$level.$splat(-0.0)))
            }

            #[inline(always)]
            fn below(self, a: Self::F, b: Self::F) -> u32 {
                self.$level.$bits(self.avx.$compare::<17>(a, b)) as u32
            }

            #[inline(always)]
            fn at_most(self, a: Self::F, b: Self::F) -> u32 {
                self.$level.$bits(self.avx.$compare::<18>(a, b)) as u32
            }
        }
    };
}

x86_lanes!(8, __m256, avx: _mm256_set1_ps, _mm256_add_ps, _mm256_sub_ps, _mm256_mul_ps, _mm256_min_ps, _mm256_max_ps,
    _mm256_and_ps, _mm256_xor_ps, _mm256_cmp_ps, _mm256_movemask_ps);
x86_lanes!(4, __m128, sse: _mm_set1_ps, _mm_add_ps, _mm_sub_ps, _mm_mul_ps, _mm_min_ps, _mm_max_ps, _mm_and_ps,
    _mm_xor_ps, _mm_cmp_ps, _mm_movemask_ps);

/// Finds the smallest of eight numbers.
pub(super) trait First: Lanes<8> {
    /// The lane of the smallest number among the lanes whose bits are set in `among` (at least one). Of equal numbers,
    /// the first lane.
    fn first(self, numbers: &[f32; 8], among: u32) -> usize;
}

impl First for Plain {
    #[inline(always)]
    fn first(self, numbers: &[f32; 8], among: u32) -> usize {
        let lanes = (0..8).filter(|lane| among >> lane & 1 == 1);
        lanes.reduce(|a, b| if numbers[b] < numbers[a] { b } else { a }).unwrap_or(0)
    }
}

#[cfg(target_arch = "x86_64")]
impl First for V3 {
    #[inline(always)]
    fn first(self, numbers: &[f32; 8], among: u32) -> usize {
        let V3 { avx, avx2, .. } = self;
        let bits = cast([1u32, 2, 4, 8, 16, 32, 64, 128]);
        let is_among = avx2._mm256_cmpeq_epi32(avx2._mm256_and_si256(avx._mm256_set1_epi32(among as i32), bits), bits);
        let infinity = avx._mm256_set1_ps(f32::INFINITY);
        let numbers = avx._mm256_blendv_ps(infinity, cast(*numbers), avx._mm256_castsi256_ps(is_among));
        let least = avx._mm256_min_ps(numbers, avx._mm256_permute2f128_ps::<1>(numbers, numbers));
        let least = avx._mm256_min_ps(least, avx._mm256_permute_ps::<0b01_00_11_10>(least));
        let least = avx._mm256_min_ps(least, avx._mm256_permute_ps::<0b10_11_00_01>(least));
        (among & Lanes::<8>::at_most(self, numbers, least)).trailing_zeros() as usize & 7
    }
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::*;

    const NUMBERS: [f32; 8] = [0.0, -0.0, 1.5, f32::INFINITY, -3.0, f32::NAN, 1.5, f32::MIN_POSITIVE];

    fn check<const N: usize>(processor: V3, a: [f32; N], b: [f32; N])
    where
        V3: Lanes<N>,
    {
        let [x, y] = [a, b].map(|it| processor.load(&it));
        let bits = |numbers: [f32; N]| numbers.map(|it| if it.is_nan() { f32::NAN.to_bits() } else { it.to_bits() });
        let same = |theirs, ours| assert_eq!(bits(processor.store(theirs)), bits(ours), "{a:?} {b:?}");
        same(processor.add(x, y), Plain.add(a, b));
        same(processor.sub(x, y), Plain.sub(a, b));
        same(processor.mul(x, y), Plain.mul(a, b));
        same(processor.smaller(x, y), Plain.smaller(a, b));
        same(processor.larger(x, y), Plain.larger(a, b));
        same(processor.flip(x, y), Plain.flip(a, b));
        same(processor.splat(a[0]), Plain.splat(a[0]));
        assert_eq!(processor.below(x, y), Plain.below(a, b));
        assert_eq!(processor.at_most(x, y), Plain.at_most(a, b));
    }

    #[test]
    fn vectors_give_what_arrays_give() {
        let Some(processor) = V3::try_new() else { return };
        for turn in 0..8 {
            let other = array::from_fn(|at| NUMBERS[(at + turn) % 8]);
            check::<8>(processor, NUMBERS, other);
            check::<4>(processor, array::from_fn(|at| NUMBERS[at]), array::from_fn(|at| other[at]));
        }
    }

    #[test]
    fn the_first_of_equal_numbers_is_found() {
        let Some(processor) = V3::try_new() else { return };
        let numbers = [2.0, 1.0, 3.0, 1.0, f32::INFINITY, -1.0, 0.0, -1.0];
        for among in 1..256 {
            assert_eq!(processor.first(&numbers, among), Plain.first(&numbers, among), "{among:b}");
        }
        assert_eq!([0b1111, 0b1000, 0b1010_0000, 0b1_0000].map(|among| Plain.first(&numbers, among)), [1, 3, 5, 4]);
    }
}
