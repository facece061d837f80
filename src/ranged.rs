//! Numbers of a config that carry their allowed range in their type: a value out of range is refused while the file is
//! read, so that the error can point at the line.

use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

use crate::size;

/// A whole number from `LO` to `HI`, both included.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Within<const LO: u64, const HI: u64>(u64);

/// A power of two from `LO` to `HI`, both included.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PowerOfTwo<const LO: u64, const HI: u64>(u64);

/// A number of bytes from `LO` to `HI`, both included. A file gives it as a number, or as text with a unit: `"16 KiB"`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Size<const LO: u64, const HI: u64>(u64);

/// A number of bytes that is a power of two from `LO` to `HI`, both included; given as a [`Size`] is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PowerOfTwoSize<const LO: u64, const HI: u64>(u64);

macro_rules! checked {
    ($name:ident, $what:literal, $read:path, $schema:ident, $value:ident => $ok:expr) => {
        impl<const LO: u64, const HI: u64> $name<LO, HI> {
            /// The checked number.
            ///
            /// # Errors
            /// The number is not allowed; the error says which numbers are.
            pub fn new($value: u64) -> Result<Self, String> {
                if LO <= $value && $value <= HI && $ok {
                    Ok(Self($value))
                } else {
                    Err(format!("{} is not allowed here: {} from {LO} to {HI} is", $value, $what))
                }
            }

            /// A number in the source, for defaults. Call it in a `const` block, so that a number out of range does
            /// not compile.
            pub const fn literal($value: u64) -> Self {
                assert!(LO <= $value && $value <= HI && $ok);
                Self($value)
            }

            /// The number.
            pub const fn get(self) -> u64 {
                self.0
            }

            /// The number as a size in memory.
            pub const fn size(self) -> usize {
                self.0 as usize
            }
        }

        impl<const LO: u64, const HI: u64> fmt::Display for $name<LO, HI> {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.0.fmt(f)
            }
        }

        impl<const LO: u64, const HI: u64> Serialize for $name<LO, HI> {
            fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
                self.0.serialize(to)
            }
        }

        impl<'de, const LO: u64, const HI: u64> Deserialize<'de> for $name<LO, HI> {
            fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
                Self::new($read(from)?).map_err(D::Error::custom)
            }
        }

        impl<const LO: u64, const HI: u64> JsonSchema for $name<LO, HI> {
            fn inline_schema() -> bool {
                true
            }

            fn schema_name() -> Cow<'static, str> {
                format!("{}_{LO}_to_{HI}", stringify!($name)).into()
            }

            fn json_schema(_: &mut SchemaGenerator) -> Schema {
                $schema($what, LO, HI)
            }
        }
    };
}

/// The schema of a number that is not a size.
fn number(what: &str, low: u64, high: u64) -> Schema {
    json_schema!({ "type": "integer", "minimum": low, "maximum": high, "kind": what })
}

/// The schema of a number of bytes.
fn bytes(what: &str, low: u64, high: u64) -> Schema {
    json_schema!({ "type": ["integer", "string"], "minimum": low, "maximum": high, "kind": what, "unit": "bytes" })
}

checked!(Within, "a whole number", u64::deserialize, number, value => true);
checked!(PowerOfTwo, "a power of two", u64::deserialize, number, value => value.is_power_of_two());
checked!(Size, "a whole number", size::deserialize, bytes, value => true);
checked!(PowerOfTwoSize, "a power of two", size::deserialize, bytes, value => value.is_power_of_two());

/// A share above 0, up to 1.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize, JsonSchema)]
#[serde(transparent)]
#[schemars(inline, extend("exclusiveMinimum" = 0, "maximum" = 1))]
pub struct Share(f64);

impl Share {
    /// The checked share.
    ///
    /// # Errors
    /// The error says what is allowed.
    pub fn new(share: f64) -> Result<Self, String> {
        if share > 0.0 && share <= 1.0 {
            Ok(Self(share))
        } else {
            Err(format!("{share} is not allowed here: a number above 0, up to 1, is"))
        }
    }

    /// A share in the source: in a `const` block, a share out of range does not compile.
    pub const fn literal(share: f64) -> Self {
        assert!(share > 0.0 && share <= 1.0);
        Self(share)
    }

    /// The number.
    pub const fn get(self) -> f64 {
        self.0
    }
}

impl FromStr for Share {
    type Err = String;

    /// Reads `0.01` or `1%`.
    fn from_str(text: &str) -> Result<Self, String> {
        let number =
            |text: &str| text.trim().parse::<f64>().map_err(|_| format!("`{text}` is no number, such as 0.01 or 1%"));
        Self::new(match text.strip_suffix('%') {
            Some(percent) => number(percent)? / 100.0,
            None => number(text)?,
        })
    }
}

impl<'de> Deserialize<'de> for Share {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        Self::new(f64::deserialize(from)?).map_err(D::Error::custom)
    }
}
