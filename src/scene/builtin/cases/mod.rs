//! Small scenes to test culling: cases in which culling is known to fail, and cases that stress a renderer's
//! arithmetic.

mod failures;
mod film;
mod stress;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use self::stress::{CameraPath, Pieces, Recipe};
use crate::quantity::Resolution;
use crate::scene::frame::Scene;
use crate::scene::render::{Offset, RenderSpec, ShadowRays};

/// Declares the cases once.
macro_rules! cases {
    (failures { $($failure:ident $data:ident $failure_title:literal,)* }
     stress { $($stress:ident $stress_title:literal $recipe:expr,)* }) => {
        /// A small scene for tests of culling.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
        pub enum Case {
            $(#[doc = $failure_title] $failure,)*
            $(#[doc = $stress_title] $stress,)*
        }

        impl Case {
            /// The failure cases and their controls.
            pub const FAILURES: &'static [Self] = &[$(Self::$failure),*];
            /// The other cases.
            pub const STRESS: &'static [Self] = &[$(Self::$stress),*];

            /// The case's name in configs and reports.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$failure => stringify!($failure),)*
                    $(Self::$stress => stringify!($stress),)*
                }
            }

            /// A description of the case.
            pub fn title(self) -> &'static str {
                match self {
                    $(Self::$failure => $failure_title,)*
                    $(Self::$stress => $stress_title,)*
                }
            }

            /// The scene.
            pub fn scene(self) -> Scene {
                match self {
                    $(Self::$failure => failures::$data.scene(self.name()),)*
                    $(Self::$stress => $recipe.scene(self.name()),)*
                }
            }
        }
    };
}

cases! {
    failures {
        C1 C1 "a shadow thinner than the samples' distance, half a pixel of pan",
        C1b C1B "the same, camera still, samples jittered",
        C2 C2 "zoom by 1.9, below the quadruple area: no reset",
        C3 C3 "zoom by 3 in one frame: the reset comes a frame late",
        C4 C4 "an occluder on the left of what is visible, the view tilts",
        C4b C4B "an occluder above what is visible, the view tilts",
        C4m C4M "control: C4 mirrored, the occluder is on the right",
        C5 C5 "a sliver whose samples are no neighbours, the occluder leaves",
        C6 C6 "a primitive of one pixel, 0.2 pixels of pan",
        C7 C7 "clipped at the left edge, behind an occluder that lies there",
        C7b C7B "a sliver leaves the picture between two samples of the edge",
        C8 C8 "a dynamic blocker leaves: a stale FULL_SHADOW",
        C9 C9 "the light moves",
        C10 C10 "seen in a planar mirror only",
        C11 C11 "the back of a lit triangle, which shadows itself",
        C12 C12 "grazing, then face on: the area grows by less than four",
        C13 C13 "triangles that cut each other, the visible part on the right",
        C14 C14 "the highest number of pixels is taken while the primitive is clipped",
    }
    stress {
        Plain "ground and pieces, a camera that pans" Recipe::default(),
        MovingLights "lights that move" Recipe { lights_move: true, ..Recipe::default() },
        JumpingCamera "a camera that jumps" Recipe { camera: CameraPath::Jump, ..Recipe::default() },
        Jitter "a camera that stands still, samples that do not" Recipe { camera: CameraPath::Jitter, ..Recipe::default() },
        Slivers "needles, a ten-thousandth as wide as long" Recipe { pieces: Pieces::Slivers, ..Recipe::default() },
        Degenerate "triangles without area among others" Recipe { pieces: Pieces::Degenerate, ..Recipe::default() },
        Coplanar "triangles in the plane of the ground, some of them twice" Recipe { pieces: Pieces::Coplanar, ..Recipe::default() },
        FarAway "a million units from the origin, where coordinates are a sixteenth apart" Recipe { centre: [1e6, -1e6, 1e6], ..Recipe::default() },
        NoLight "no light" Recipe { lights: 0, ..Recipe::default() },
        Lights15 "15 lights: as many as one word holds" Recipe { lights: 15, ..Recipe::default() },
        Lights16 "16 lights: one more" Recipe { lights: 16, ..Recipe::default() },
        Lights40 "40 lights" Recipe { lights: 40, ..Recipe::default() },
        OneTriangle "one triangle" Recipe { ground: 0, count: 1, moving: 0, ..Recipe::default() },
        OnlyMoving "moving triangles only" Recipe { ground: 0, count: 0, moving: 12, ..Recipe::default() },
        Nothing "no triangle at all" Recipe { ground: 0, count: 0, moving: 0, ..Recipe::default() },
    }
}

impl Case {
    /// All cases.
    pub fn all() -> impl Iterator<Item = Self> {
        Self::FAILURES.iter().chain(Self::STRESS).copied()
    }

    /// Whether it is a failure case or a control of one.
    pub fn is_failure(self) -> bool {
        Self::FAILURES.contains(&self)
    }

    /// The resolution that the case is made for.
    pub fn resolution(self) -> Resolution {
        let side = if self.is_failure() { 16 } else { 32 };
        Resolution { width: side, height: side }
    }

    /// How the case's pictures are traced.
    pub fn render(self) -> RenderSpec {
        if self.is_failure() {
            let offset = Offset::Absolute(1e-4);
            RenderSpec { depth: 2, shadow_rays: ShadowRays::Always, offset, ..RenderSpec::default() }
        } else {
            RenderSpec { depth: 3, ..RenderSpec::default() }
        }
    }
}
