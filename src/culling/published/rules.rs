//! Everything that the text of GI09 leaves open, as options. `docs/model/algorithm.md` lists
//! the questions by the numbers O1 to O11 used here.

use schemars::JsonSchema;
use serde::ser::SerializeStruct;
use serde::{Deserialize, Serialize, Serializer};

/// Declares the answers once, for two types: the full set, and a config's departures from a preset.
macro_rules! answers {
    ($($(#[$doc:meta])* $field:ident: $kind:ty),* $(,)?) => {
        /// Answers to all that the text leaves open.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct PublishedRules { $($(#[$doc])* pub $field: $kind),* }

        /// A preset, and answers that override it. Output lists all answers, including those of the preset.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
        #[serde(default, deny_unknown_fields)]
        pub struct PublishedSpec {
            /// Gives every answer that is not set below.
            pub preset: Preset,
            $($(#[$doc])* pub $field: Option<$kind>),*
        }

        impl Serialize for PublishedSpec {
            fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
                let rules = self.rules();
                let fields = [$(stringify!($field)),*].len() + 1;
                let mut spec = to.serialize_struct("PublishedSpec", fields)?;
                spec.serialize_field("preset", &self.preset)?;
                $(spec.serialize_field(stringify!($field), &rules.$field)?;)*
                spec.end()
            }
        }

        impl PublishedSpec {
            /// All answers.
            pub fn rules(&self) -> PublishedRules {
                let preset = self.preset.rules();
                PublishedRules { $($field: self.$field.unwrap_or(preset.$field)),* }
            }
        }
    };
}

answers! {
    /// O1: whether a primitive stays PARTIALLY_OCCLUDED.
    partial: Partial,
    /// O2: what happens to shadow modes when zooming in resets FULLY_RENDERED.
    reset_modes: ResetModes,
    /// O3: when a primitive's highest number of rendered pixels is updated.
    highest: Highest,
    /// O4: which blockers are evidence of shadow.
    evidence: EvidenceRule,
    /// O5: whether shadow rays of secondary hits are culled.
    secondary: Secondary,
    /// O6: what happens to modes when a light moves.
    light_moves: LightMoves,
    /// O8: what happens to a FULLY_RENDERED primitive that an occlusion test finds occluded.
    occluded_full: OccludedFull,
    /// Which neighbour pixels the current pixel is compared with.
    references: References,
    /// Which rays an occlusion test of two pixels uses.
    directions: Directions,
    /// Whether dynamic primitives are tested, although no test changes their mode.
    dynamic_tests: DynamicTests,
    /// Whether the edge of the picture counts as an occluder.
    border: Border,
    /// FULLY_RENDERED is reset when the number of rendered pixels exceeds the highest number times this ratio.
    reset_ratio: ResetRatio,
    /// When the number of rendered pixels is compared with the highest number.
    reset_check: ResetCheck,
    /// Which values of mode words decisions read.
    words: Words,
}

/// A complete set of answers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Preset {
    /// The most plausible meaning of the paper's text. In the failure cases C7, C7b and C13 it is wrong more often than
    /// `Literal`, whose live mode words are impossible on a parallel machine (docs/model/algorithm.md).
    #[default]
    Sensible,
    /// The paper's text, taken literally.
    Literal,
}

impl Preset {
    /// The answers of the preset.
    pub fn rules(self) -> PublishedRules {
        match self {
            Self::Sensible => PublishedRules {
                partial: Partial::Returns,
                reset_modes: ResetModes::Keep,
                highest: Highest::AtFull,
                evidence: EvidenceRule::StaticBlockers,
                secondary: Secondary::Cull,
                light_moves: LightMoves::Ignore,
                occluded_full: OccludedFull::StaysFull,
                references: References::LeftAndUpper,
                directions: Directions::OneWay,
                dynamic_tests: DynamicTests::Made,
                border: Border::Occludes,
                reset_ratio: ResetRatio(4.0),
                reset_check: ResetCheck::FrameEnd,
                words: Words::Latched,
            },
            Self::Literal => PublishedRules {
                evidence: EvidenceRule::AnyBlocker,
                secondary: Secondary::CullAndCount,
                occluded_full: OccludedFull::BecomesPartial,
                words: Words::Live,
                ..Self::Sensible.rules()
            },
        }
    }
}

/// A number of at least 1; the paper says "more than the quadruple".
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(inline)]
pub struct ResetRatio(#[schemars(range(min = 1.0))] pub f64);

impl<'de> Deserialize<'de> for ResetRatio {
    fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let ratio = f64::deserialize(from)?;
        if ratio.is_finite() && ratio >= 1.0 {
            Ok(Self(ratio))
        } else {
            Err(serde::de::Error::custom(format!("a reset ratio of {ratio}: a number of at least 1 is allowed")))
        }
    }
}

macro_rules! choices {
    ($($(#[$doc:meta])* $name:ident { $($(#[$vdoc:meta])* $variant:ident),* $(,)? })*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
        pub enum $name { $($(#[$vdoc])* $variant),* }
    )*};
}

choices! {
    /// Whether a primitive stays PARTIALLY_OCCLUDED (O1).
    Partial {
        /// The primitive returns to INIT at the end of the frame.
        Returns,
        /// The primitive stays PARTIALLY_OCCLUDED for ever.
        Sticky,
    }
    /// What happens to shadow modes at a reset (O2).
    ResetModes {
        /// Shadow modes are kept.
        Keep,
        /// Shadow modes are cleared.
        Clear,
    }
    /// When the highest number of rendered pixels is updated (O3).
    Highest {
        /// When a primitive becomes FULLY_RENDERED, and at a reset.
        AtFull,
        /// At a reset only; the number starts at 0.
        AtReset,
        /// In every frame: the maximum so far.
        RunningMaximum,
    }
    /// Which blockers are evidence of shadow (O4).
    EvidenceRule {
        /// Static blockers only: a ray that a dynamic triangle blocks counts as lit.
        StaticBlockers,
        /// All blockers, static and dynamic.
        AnyBlocker,
    }
    /// Whether shadow rays of secondary hits are culled (O5).
    Secondary {
        /// Their shadow rays are culled, and the policy learns from them.
        Cull,
        /// As `Cull`, and secondary hits count as rendered pixels.
        CullAndCount,
        /// Their shadow rays are traced, and the policy learns nothing from them.
        Ignore,
    }
    /// What happens to modes when a light moves (O6).
    LightMoves {
        /// Modes are kept.
        Ignore,
        /// All shadow modes of this light are cleared.
        Flush,
    }
    /// What happens to a FULLY_RENDERED primitive that an occlusion test finds occluded (O8).
    OccludedFull {
        /// It stays FULLY_RENDERED.
        StaysFull,
        /// It becomes PARTIALLY_OCCLUDED.
        BecomesPartial,
    }
    /// Which neighbour pixels the current pixel is compared with.
    References {
        /// The left and the upper neighbour.
        LeftAndUpper,
        /// Also the upper left and the upper right neighbour. With `directions: BothWays`, all eight neighbours are
        /// compared.
        WithDiagonals,
    }
    /// Which rays an occlusion test uses.
    Directions {
        /// The current pixel's ray, against the neighbour's primitive.
        OneWay,
        /// Also the neighbour's ray, against the current pixel's primitive.
        BothWays,
    }
    /// Whether dynamic primitives are tested.
    DynamicTests {
        /// Dynamic primitives are tested whenever the two primitives differ, as the paper says.
        Made,
        /// A primitive whose mode is DYNAMIC is not tested.
        Spared,
    }
    /// Whether the edge of the picture counts as an occluder.
    Border {
        /// A primitive at the edge is PARTIALLY_OCCLUDED.
        Occludes,
        /// The edge has no effect.
        Ignored,
    }
    /// When the number of rendered pixels is compared with the highest number.
    ResetCheck {
        /// At the end of the frame.
        FrameEnd,
        /// Before the first shadow ray of the frame. This needs a separate pass of primary rays; only the hits of that
        /// pass count as rendered pixels.
        BeforeShadows,
    }
    /// Which values of mode words decisions read.
    Words {
        /// The values at the start of the frame.
        Latched,
        /// The current values, in raster order.
        Live,
    }
}
