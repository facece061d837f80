//! Quantities that cross module boundaries, each with its own type, so that a cycle is never added to a byte.

use std::fmt;
use std::iter::Sum;
use std::ops::{Add, AddAssign, Sub};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

macro_rules! quantity {
    ($(#[$doc:meta])* $name:ident($inner:ty)) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[serde(transparent)]
        pub struct $name(pub $inner);

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.0.fmt(f)
            }
        }
    };
}

macro_rules! amount {
    ($($name:ident),*) => {$(
        impl Add for $name {
            type Output = Self;
            fn add(self, other: Self) -> Self {
                Self(self.0 + other.0)
            }
        }
        impl Sub for $name {
            type Output = Self;
            fn sub(self, other: Self) -> Self {
                Self(self.0 - other.0)
            }
        }
        impl AddAssign for $name {
            fn add_assign(&mut self, other: Self) {
                self.0 += other.0;
            }
        }
        impl Sum for $name {
            fn sum<I: Iterator<Item = Self>>(items: I) -> Self {
                items.fold(Self::default(), Add::add)
            }
        }
    )*};
}

quantity! {
    /// A point in time or a length of time, in cycles of the machine's clock.
    Cycle(u64)
}
quantity! {
    /// An amount of data.
    Bytes(u64)
}
amount!(Cycle, Bytes);

quantity! {
    /// A byte address in the simulated machine's memory.
    Addr(u64)
}
quantity! {
    /// The number of a cache line: a byte address divided by the line's size.
    LineAddr(u64)
}
quantity! {
    /// A node of the acceleration structure: 0 is the root that joins the static and the dynamic tree, the static
    /// tree's nodes follow in depth-first order, then the dynamic tree's.
    NodeId(u32)
}
quantity! {
    /// An entry of the kd-tree's primitive lists.
    ListId(u32)
}
quantity! {
    /// The index of a triangle record in memory: leaf order, static slots first, then dynamic ones.
    TriangleSlot(u32)
}
quantity! {
    /// A triangle of the scene: static ones first, then dynamic ones. It is the same in every frame, for every
    /// acceleration structure.
    PrimitiveId(u32)
}
quantity! {
    /// A light of the scene.
    LightId(u8)
}
quantity! {
    /// A pixel, row by row from the top left.
    PixelId(u32)
}

/// Width and height of a picture in pixels, each from 1 to 8192.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "Sides")]
pub struct Resolution {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
}

/// Both sides, as written in a file.
#[derive(Deserialize, JsonSchema)]
#[serde(rename = "Resolution", deny_unknown_fields)]
struct Sides {
    /// Width in pixels.
    #[schemars(range(min = 1, max = 8192))]
    width: u32,
    /// Height in pixels.
    #[schemars(range(min = 1, max = 8192))]
    height: u32,
}

impl TryFrom<Sides> for Resolution {
    type Error = String;

    fn try_from(Sides { width, height }: Sides) -> Result<Self, String> {
        let allowed = 1..=8192;
        if allowed.contains(&width) && allowed.contains(&height) {
            Ok(Self { width, height })
        } else {
            Err(format!("a resolution of {width}x{height}: each side can be from 1 to 8192"))
        }
    }
}

impl Resolution {
    /// The number of pixels.
    pub fn pixels(self) -> usize {
        self.width as usize * self.height as usize
    }

    /// The pixel in column `x` of row `y`, counted from the top left.
    pub fn pixel(self, x: u32, y: u32) -> PixelId {
        PixelId(y * self.width + x)
    }
}

impl fmt::Display for Resolution {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

impl std::str::FromStr for Resolution {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let sides =
            text.split_once('x').and_then(|(w, h)| Some(Sides { width: w.parse().ok()?, height: h.parse().ok()? }));
        sides.ok_or_else(|| format!("`{text}` is not a resolution: write WIDTHxHEIGHT, such as 512x512"))?.try_into()
    }
}
