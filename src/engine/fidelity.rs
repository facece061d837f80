//! How a machine is replayed: the fidelity levels.

use std::fmt;
use std::str::FromStr;

use schemars::JsonSchema;
use serde::de::{Deserializer, Error};
use serde::{Deserialize, Serialize, Serializer};

use super::retired::{self, WithoutRetired};

/// A share above 0, up to 1.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize, JsonSchema)]
#[serde(transparent)]
#[schemars(inline, extend("exclusiveMinimum" = 0, "maximum" = 1))]
pub struct Share(f64);

impl Share {
    /// The checked share; the error says what is allowed.
    pub fn new(share: f64) -> Result<Self, String> {
        if share > 0.0 && share <= 1.0 {
            Ok(Self(share))
        } else {
            Err(format!("{share} is not allowed here: a number above 0, up to 1, is"))
        }
    }

    /// The number.
    pub fn get(self) -> f64 {
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

/// What a sample is replayed with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(remote = "Self")]
pub enum Sampled {
    /// As [`Fidelity::Profile`].
    Profile,
    /// As [`Fidelity::Event`].
    Event,
}

impl Sampled {
    /// The rung that replays everything as this one does a sample.
    pub fn whole(self) -> Fidelity {
        match self {
            Self::Profile => Fidelity::Profile,
            Self::Event => Fidelity::Event,
        }
    }
}

/// How a machine is replayed, from the cheapest to the plainest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, remote = "Self")]
pub enum Fidelity {
    /// Closed forms that no machine can beat.
    Bound,
    /// Exact contents of caches in an order that stands for the machine's, and time by what is free when.
    Profile,
    /// A part acts only in cycles in which it has something to do: the rules of MODEL.md, fast.
    #[default]
    Event,
    /// Every part acts in every cycle: plain, slow, and what `Event` is held to. Both give the same numbers.
    Cycle,
    /// A sample of windows of pixels, each replayed by itself, with intervals.
    Sampled {
        /// What replays it.
        engine: Sampled,
        /// The share of the rays that is measured.
        rate: Share,
        /// Which rays.
        #[serde(default)]
        seed: u64,
        /// If it is set, sampling goes on until all intervals are within this share, and the rate is where it begins.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        target_error: Option<Share>,
    },
    /// The cheapest of the others that a pilot finds close enough, closed forms and simpler rungs without the parts that make no difference.
    Auto {
        /// The error that cycles and bytes may have.
        error: Share,
    },
}

impl Fidelity {
    /// The rungs that need no numbers.
    pub const RUNGS: [Self; 4] = [Self::Bound, Self::Profile, Self::Event, Self::Cycle];

    /// Whether it measures machines wherever their words are kept, and if they are free.
    pub fn knows_all_placements(self) -> bool {
        self.is_exact() || matches!(self, Self::Sampled { engine: Sampled::Event, .. } | Self::Auto { .. })
    }

    /// Where sampling towards a target begins.
    const FIRST_RATE: Share = Share(0.02);

    /// Whether its numbers are those of [`Fidelity::Cycle`].
    pub fn is_exact(self) -> bool {
        matches!(self, Self::Event | Self::Cycle)
    }

    /// The same, sampled until all intervals are within `target`; the error says what can be.
    pub fn with_target_error(self, target: Share) -> Result<Self, String> {
        let by = |engine| (engine, Self::FIRST_RATE, 0);
        let (engine, rate, seed) = match self {
            Self::Event => by(Sampled::Event),
            Self::Profile => by(Sampled::Profile),
            Self::Sampled { engine, rate, seed, .. } => (engine, rate, seed),
            Self::Bound | Self::Cycle | Self::Auto { .. } => {
                return Err(format!("`{self}` is not sampled: a target error goes with Event, Profile and Sampled"));
            }
        };
        Ok(Self::Sampled { engine, rate, seed, target_error: Some(target) })
    }

    /// Whether the stream is read more than once.
    pub fn takes_passes(self) -> bool {
        matches!(self, Self::Sampled { target_error: Some(_), .. } | Self::Auto { .. })
    }
}

/// As in files.
impl fmt::Display for Fidelity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bound => f.write_str("Bound"),
            Self::Profile => f.write_str("Profile"),
            Self::Event => f.write_str("Event"),
            Self::Cycle => f.write_str("Cycle"),
            Self::Sampled { engine, rate, seed, target_error } => {
                write!(f, "Sampled(engine: {engine:?}, rate: {}", rate.get())?;
                if *seed != 0 {
                    write!(f, ", seed: {seed}")?;
                }
                if let Some(target) = target_error {
                    write!(f, ", target_error: {}", target.get())?;
                }
                f.write_str(")")
            }
            Self::Auto { error } => write!(f, "Auto(error: {})", error.get()),
        }
    }
}

impl FromStr for Fidelity {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let options = ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME);
        options.from_str(text).map_err(|error| match error.code.to_string() {
            what if what == retired::FUNCTIONAL => what,
            what => format!(
                "`{text}` is no fidelity ({what}): Bound, Profile, Event, Cycle, Sampled(engine: Event, rate: 0.05) and \
                 Auto(error: 0.02) are"
            ),
        })
    }
}

impl Serialize for Fidelity {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        Self::serialize(self, to)
    }
}

impl<'de> Deserialize<'de> for Fidelity {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        Self::deserialize(WithoutRetired(from))
    }
}

impl Serialize for Sampled {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        Self::serialize(self, to)
    }
}

impl<'de> Deserialize<'de> for Sampled {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        Self::deserialize(WithoutRetired(from))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_as_they_are_written() {
        let sampled = |engine, seed, target_error| Fidelity::Sampled { engine, rate: Share(0.05), seed, target_error };
        let all = [sampled(Sampled::Event, 0, None), sampled(Sampled::Profile, 7, Some(Share(0.01)))];
        let all = all.into_iter().chain([Fidelity::Auto { error: Share(0.02) }]);
        for fidelity in Fidelity::RUNGS.into_iter().chain(all) {
            assert_eq!(fidelity.to_string().parse(), Ok(fidelity));
        }
        for text in ["", "event", "Sampled", "Sampled(engine: Cycle, rate: 0.1)", "Sampled(engine: Event, rate: 0)"] {
            assert!(text.parse::<Fidelity>().unwrap_err().contains("Bound, Profile, Event"), "{text}");
        }
    }

    #[test]
    fn a_level_that_is_gone_is_refused_with_what_takes_its_place() {
        for text in ["Functional", "Sampled(engine: Functional, rate: 0.1)"] {
            assert_eq!(text.parse::<Fidelity>(), Err(retired::FUNCTIONAL.to_owned()), "{text}");
        }
        let error = "event".parse::<Fidelity>().unwrap_err();
        assert!(!error.contains("Functional"), "{error}");
    }
}
