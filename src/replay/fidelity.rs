//! How a machine is replayed: the fidelity levels.

use std::fmt;
use std::str::FromStr;

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::alike;
use crate::engine::retired::{self, WithoutRetired};
use crate::engine::{Exact, Level, Sampled};
use crate::machine::SpecError;
use crate::ranged::Share;

/// The fidelity level of a replay: how exactly the machine is simulated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, remote = "Self")]
pub enum Fidelity {
    /// Closed-form bounds that no machine can beat.
    Bound,
    /// Exact cache contents for an access order that approximates the machine's, and times from when resources are
    /// free.
    Profile,
    /// Exact by the rules of docs/model, and fast: a part acts only in cycles in which it has something to do.
    #[default]
    Event,
    /// Exact and slow: every part acts in every cycle. The reference for `Event`; both give the same numbers.
    Cycle,
    /// Replays a sample of windows of pixels, each on its own. Figures have confidence intervals.
    Sampled {
        /// The fidelity level that replays the windows.
        engine: Sampled,
        /// The share of the rays to measure.
        rate: Share,
        /// The seed of the random choice of windows.
        #[serde(default)]
        seed: u64,
        /// Target for the half-widths of all confidence intervals, as a share. Sampling begins at `rate` and continues
        /// until the target is met. Where replays are compared, the target also holds for their changes.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        target_error: Option<Share>,
    },
    /// Replays as much by `Event` as the allowed error needs: cache tags for the whole stream, and `Event` for a sample
    /// of windows. Where a sample would not pay, `Event` replays everything.
    Auto {
        /// The allowed error of cycles and bytes, at 95 % confidence. Where replays are compared, it also holds for
        /// their changes.
        error: Share,
    },
}

impl Fidelity {
    /// The levels without parameters.
    pub const RUNGS: [Self; 4] = [Self::Bound, Self::Profile, Self::Event, Self::Cycle];

    /// Whether it can replay machines with any `place` of words, `Free` included.
    pub fn knows_all_placements(self) -> bool {
        self != Self::Bound
    }

    /// The first rate of sampling with a target.
    const FIRST_RATE: Share = Share::literal(0.02);

    /// Whether its figures are those of [`Fidelity::Cycle`].
    pub fn is_exact(self) -> bool {
        matches!(self, Self::Event | Self::Cycle)
    }

    /// The same, sampled until all intervals are within `target`.
    ///
    /// # Errors
    /// The level cannot be sampled; the error names those that can.
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

    /// Whether it may sample a stream.
    pub fn samples(self) -> bool {
        matches!(self, Self::Sampled { .. } | Self::Auto { .. })
    }

    /// Whether samples grow until their intervals are within a target.
    pub fn has_target(self) -> bool {
        matches!(self, Self::Sampled { target_error: Some(_), .. } | Self::Auto { .. })
    }

    /// The same for replays that are compared with each other. Intervals are narrowed so that changes are within the
    /// target too: independent errors of two samples add up as squares, and those of samples of the same windows cancel
    /// in part.
    #[must_use]
    pub fn compared(self) -> Self {
        self.narrower(std::f64::consts::SQRT_2)
    }

    /// The same for a baseline: its error is part of the error of all replays beside it.
    #[must_use]
    pub fn of_baseline(self) -> Self {
        self.narrower(2.0)
    }

    /// The same with its target divided by `part`.
    fn narrower(self, part: f64) -> Self {
        let narrower = |target: Share| Share::new(target.get() / part).unwrap_or(target);
        match self {
            Self::Sampled { engine, rate, seed, target_error } => {
                Self::Sampled { engine, rate, seed, target_error: target_error.map(narrower) }
            }
            Self::Auto { error } => Self::Auto { error: narrower(error) },
            Self::Bound | Self::Profile | Self::Event | Self::Cycle => self,
        }
    }

    /// The same, if one pass over a stream suffices; otherwise `None`.
    pub fn one_pass(self) -> Option<OnePass> {
        Some(match self {
            Self::Bound => OnePass::Whole(Level::Bound),
            Self::Profile => OnePass::Whole(Level::Profile),
            Self::Event => OnePass::Whole(Level::Event),
            Self::Cycle => OnePass::Whole(Level::Cycle),
            Self::Sampled { engine, rate, seed, target_error: None } => OnePass::Sampled { engine, rate, seed },
            Self::Sampled { target_error: Some(_), .. } | Self::Auto { .. } => return None,
        })
    }

    /// The same, if it replays cycle by cycle, so that a run can be observed.
    ///
    /// # Errors
    /// It does not; the error names the levels that do.
    pub fn exact(self) -> Result<Exact, SpecError> {
        match self {
            Self::Event => Ok(Exact::Event),
            Self::Cycle => Ok(Exact::Cycle),
            other => Err(SpecError::new(format!(
                "`{other}` does not replay cycle by cycle, and cannot be watched: Event and Cycle can"
            ))),
        }
    }
}

/// How a machine is replayed in one pass over a stream.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OnePass {
    /// The whole stream.
    Whole(Level),
    /// A sample of windows; see [`Fidelity::Sampled`].
    Sampled {
        /// The engine that replays the windows.
        engine: Sampled,
        /// The share of the windows that is measured.
        rate: Share,
        /// The seed that draws the windows.
        seed: u64,
    },
}

/// As written in files.
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
            what => refused(text, &what),
        })
    }
}

/// The names of fidelities.
const NAMES: [&str; 6] = ["Bound", "Profile", "Event", "Cycle", "Sampled", "Auto"];

/// The message for a `text` that is no fidelity; `what` is the fault if its name is known.
fn refused(text: &str, what: &str) -> String {
    let name = text.split('(').next().unwrap_or_default().trim();
    let why = match NAMES.contains(&name) {
        true => format!("`{text}` is no fidelity: {what}"),
        false => {
            let proposal = alike::closest(name, &NAMES).map(|other| format!("; did you mean `{other}`?"));
            format!("unknown fidelity `{name}`{}", proposal.unwrap_or_default())
        }
    };
    let end = if why.ends_with('?') { "" } else { "." };
    format!("{why}{end} Allowed: Bound, Profile, Event, Cycle, Sampled(engine: Event, rate: 0.05), Auto(error: 0.02)")
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_as_they_are_written() {
        let sampled =
            |engine, seed, target_error| Fidelity::Sampled { engine, rate: Share::literal(0.05), seed, target_error };
        let all = [sampled(Sampled::Event, 0, None), sampled(Sampled::Profile, 7, Some(Share::literal(0.01)))];
        let all = all.into_iter().chain([Fidelity::Auto { error: Share::literal(0.02) }]);
        for fidelity in Fidelity::RUNGS.into_iter().chain(all) {
            assert_eq!(fidelity.to_string().parse(), Ok(fidelity));
        }
        for text in ["", "event", "Sampled", "Sampled(engine: Cycle, rate: 0.1)", "Sampled(engine: Event, rate: 0)"] {
            assert!(text.parse::<Fidelity>().unwrap_err().contains("Bound, Profile, Event"), "{text}");
        }
    }

    #[test]
    fn two_that_are_compared_are_each_closer_than_what_is_asked() {
        let auto = |error| Fidelity::Auto { error: Share::new(error).unwrap() };
        let Fidelity::Auto { error } = auto(0.02).compared() else { panic!("{:?}", auto(0.02).compared()) };
        assert!((2.0 * error.get() * error.get() - 0.02 * 0.02).abs() < 1e-9, "{error:?}");
        assert_eq!(auto(0.02).of_baseline(), auto(0.01), "what all others are off too");
        assert_eq!(Fidelity::Event.compared(), Fidelity::Event);
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
