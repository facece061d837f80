//! The 32-bit word of modes that each primitive keeps (GI09, "Required additional information" of the poster).
//!
//! Bits 1:0 hold the occlusion mode, followed by two bits for each light. Fifteen lights fit; the poster says "less
//! than ten". Further lights use further words, sixteen lights per word.

use crate::quantity::{LightId, PrimitiveId};

/// Whether a primitive was seen whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Occlusion {
    /// Nothing is known.
    Init,
    /// A part of it was hidden, or outside the picture.
    PartiallyOccluded,
    /// All of it was seen: its shadow bits can be trusted.
    FullyRendered,
    /// It can move: no mode is kept for it.
    Dynamic,
}

/// The answers seen for a light on a primitive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shadow {
    /// Nothing yet.
    Init,
    /// Only shadow.
    Full,
    /// Only light.
    Non,
    /// Both.
    Partial,
}

/// The bit for "a shadow was seen", before the shift to the light's position.
pub(crate) const SEEN_DARK: u32 = 0b01;
/// The bit for "the light was seen", before the shift to the light's position.
pub(crate) const SEEN_LIT: u32 = 0b10;

const OCCLUSION_BITS: u32 = 0b11;

/// A primitive's first word.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct ModeWord(pub u32);

impl ModeWord {
    /// The occlusion mode.
    pub(crate) fn occlusion(self) -> Occlusion {
        match self.0 & OCCLUSION_BITS {
            0b00 => Occlusion::Init,
            0b01 => Occlusion::PartiallyOccluded,
            0b10 => Occlusion::FullyRendered,
            _ => Occlusion::Dynamic,
        }
    }

    /// The word with another occlusion mode.
    pub(crate) fn with_occlusion(self, mode: Occlusion) -> Self {
        let bits = match mode {
            Occlusion::Init => 0b00,
            Occlusion::PartiallyOccluded => 0b01,
            Occlusion::FullyRendered => 0b10,
            Occlusion::Dynamic => 0b11,
        };
        Self(self.0 & !OCCLUSION_BITS | bits)
    }

    /// The word without its shadow modes.
    pub(crate) fn without_shadows(self) -> Self {
        Self(self.0 & OCCLUSION_BITS)
    }
}

/// The layout of a primitive's modes, for a number of lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct WordLayout {
    words: u32,
}

/// The position of a light's two bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ShadowPlace {
    /// Index of the word, counted over all primitives.
    pub word: u32,
    /// Position of the lower bit.
    pub shift: u32,
}

impl ShadowPlace {
    /// The mode that `word` holds here.
    pub(crate) fn mode(self, word: u32) -> Shadow {
        match word >> self.shift & 0b11 {
            0b00 => Shadow::Init,
            SEEN_DARK => Shadow::Full,
            SEEN_LIT => Shadow::Non,
            _ => Shadow::Partial,
        }
    }
}

impl WordLayout {
    /// The layout for `lights` lights.
    pub(crate) fn new(lights: usize) -> Self {
        Self { words: 1 + (lights.saturating_sub(15)).div_ceil(16) as u32 }
    }

    /// Number of words per primitive.
    pub(crate) fn words_per_primitive(self) -> u32 {
        self.words
    }

    /// Index of a primitive's first word, which holds the occlusion mode.
    pub(crate) fn first(self, primitive: PrimitiveId) -> u32 {
        primitive.0 * self.words
    }

    /// The position of a light's mode.
    pub(crate) fn shadow(self, primitive: PrimitiveId, light: LightId) -> ShadowPlace {
        let pair = u32::from(light.0) + 1;
        ShadowPlace { word: self.first(primitive) + pair / 16, shift: 2 * (pair % 16) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fifteen_lights_fit_one_word() {
        assert_eq!(WordLayout::new(0).words_per_primitive(), 1);
        assert_eq!(WordLayout::new(15).words_per_primitive(), 1);
        assert_eq!(WordLayout::new(16).words_per_primitive(), 2);
        assert_eq!(WordLayout::new(31).words_per_primitive(), 2);
        assert_eq!(WordLayout::new(32).words_per_primitive(), 3);
    }

    #[test]
    fn no_two_modes_share_a_bit() {
        for lights in [1, 15, 16, 40, 64] {
            let layout = WordLayout::new(lights);
            let mut used = std::collections::BTreeSet::from([(layout.first(PrimitiveId(3)), 0)]);
            for light in 0..lights {
                let place = layout.shadow(PrimitiveId(3), LightId(light as u8));
                assert!(place.word < layout.first(PrimitiveId(4)));
                assert!(used.insert((place.word, place.shift)), "{lights} lights, light {light}");
            }
        }
    }

    #[test]
    fn the_poster_s_example_holds() {
        // "11 (PARTIAL_SHADOW) = 01 (FULL_SHADOW) | 10 (NON_SHADOW)"
        let place = WordLayout::new(1).shadow(PrimitiveId(0), LightId(0));
        let word = SEEN_DARK << place.shift;
        assert_eq!(place.mode(word), Shadow::Full);
        assert_eq!(place.mode(word | SEEN_LIT << place.shift), Shadow::Partial);
        assert_eq!(ModeWord(word).with_occlusion(Occlusion::FullyRendered).0, 0b0110);
    }
}
