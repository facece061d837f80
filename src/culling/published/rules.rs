//! Everything that the text of GI09 leaves open, as options. MODEL.md lists the gaps by the numbers H1 to H10 used
//! here.

use schemars::JsonSchema;
use serde::ser::SerializeStruct;
use serde::{Deserialize, Serialize, Serializer};

/// Declares the answers once, for two types: the full set, and a config's departures from a preset.
macro_rules! answers {
    ($($(#[$doc:meta])* $field:ident: $kind:ty),* $(,)?) => {
        /// Answers to all that the text leaves open.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct PublishedRules { $($(#[$doc])* pub $field: $kind),* }

        /// A preset, and the answers that depart from it. It is written with all answers, the preset's included.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
        #[serde(default, deny_unknown_fields)]
        pub struct PublishedSpec {
            /// Gives all answers that are not given below.
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
    /// H1: what becomes of PARTIALLY_OCCLUDED.
    partial: Partial,
    /// H2: what becomes of shadow modes when zooming in takes FULLY_RENDERED away.
    reset_modes: ResetModes,
    /// H3: when the highest number of rendered pixels is set.
    highest: Highest,
    /// H4: which blockers count as shadow.
    evidence: EvidenceRule,
    /// H5: what secondary hits may do.
    secondary: Secondary,
    /// H6: what happens when a light moves.
    light_moves: LightMoves,
    /// H8: what becomes of a FULLY_RENDERED primitive that is seen occluded.
    occluded_full: OccludedFull,
    /// Which pixels the current one is compared with.
    references: References,
    /// Which rays are tested in a comparison.
    directions: Directions,
    /// Whether dynamic primitives are tested, whose mode no test changes.
    dynamic_tests: DynamicTests,
    /// Whether the picture's edge occludes.
    border: Border,
    /// How many times the highest number of rendered pixels takes FULLY_RENDERED away.
    reset_ratio: ResetRatio,
    /// When the number of rendered pixels is compared with the highest.
    reset_check: ResetCheck,
    /// Which words decisions read.
    words: Words,
}

/// A set of answers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Preset {
    /// What the text must have meant. In the failure cases C7, C7b and C13 it is wrong more often than `Literal`, whose
    /// live words no parallel machine can have (docs/model/algorithm.md).
    #[default]
    Sensible,
    /// The text read to the letter.
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
    /// What becomes of PARTIALLY_OCCLUDED (H1).
    Partial {
        /// It is INIT again when the frame is over.
        Returns,
        /// It stays for ever.
        Sticky,
    }
    /// What becomes of shadow modes at a reset (H2).
    ResetModes {
        /// They are kept.
        Keep,
        /// They are cleared.
        Clear,
    }
    /// When the highest number of rendered pixels is set (H3).
    Highest {
        /// When a primitive becomes FULLY_RENDERED, and at a reset.
        AtFull,
        /// At a reset only: it starts at 0.
        AtReset,
        /// In every frame, to the larger number.
        RunningMaximum,
    }
    /// Which blockers count as shadow (H4).
    EvidenceRule {
        /// Static ones; a dynamic blocker says that no static one blocks.
        StaticBlockers,
        /// All.
        AnyBlocker,
    }
    /// What secondary hits may do (H5).
    Secondary {
        /// Their shadow rays are culled and teach.
        Cull,
        /// That, and they count as rendered pixels.
        CullAndCount,
        /// Nothing: their shadow rays are traced and teach nothing.
        Ignore,
    }
    /// What happens when a light moves (H6).
    LightMoves {
        /// Nothing.
        Ignore,
        /// All modes of that light are cleared.
        Flush,
    }
    /// What becomes of a FULLY_RENDERED primitive that is seen occluded (H8).
    OccludedFull {
        /// It stays FULLY_RENDERED.
        StaysFull,
        /// It becomes PARTIALLY_OCCLUDED.
        BecomesPartial,
    }
    /// Which pixels the current one is compared with.
    References {
        /// The left and the upper one.
        LeftAndUpper,
        /// These, the upper left and the upper right one: with both directions, all eight neighbours.
        WithDiagonals,
    }
    /// Which rays are tested.
    Directions {
        /// The current pixel's ray against the reference's primitive.
        OneWay,
        /// And the reference's ray against the current pixel's primitive.
        BothWays,
    }
    /// Whether dynamic primitives are tested.
    DynamicTests {
        /// Whenever primitives differ, as the text says.
        Made,
        /// A primitive whose mode is DYNAMIC is not tested.
        Spared,
    }
    /// Whether the picture's edge occludes.
    Border {
        /// A primitive at the edge is PARTIALLY_OCCLUDED.
        Occludes,
        /// The edge is like any other place.
        Ignored,
    }
    /// When the number of rendered pixels is compared with the highest.
    ResetCheck {
        /// At the frame's end.
        FrameEnd,
        /// Before the first shadow ray of the frame: it takes a pass of primary rays alone, whose hits are then the
        /// ones that are counted, in this frame and in the highest number.
        BeforeShadows,
    }
    /// Which words decisions read.
    Words {
        /// As they were at the frame's start.
        Latched,
        /// As they are, in raster order.
        Live,
    }
}
