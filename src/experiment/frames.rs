//! Which frames of an animation are traced, and which of the traced frames are replayed, validated or drawn.

use std::fmt;
use std::str::FromStr;

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

/// Frames `FIRST`, `FIRST + STEP`, ... below `END`, written `FIRST..END:STEP`. Without `:STEP` the step is 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, JsonSchema)]
#[schemars(inline, with = "String")]
pub struct FrameRange {
    first: u32,
    end: u32,
    step: u32,
}

/// The most frames of a range: at 24 frames per second, twelve hours.
const MAX_FRAMES: u32 = 1 << 20;

impl FrameRange {
    /// The frames' numbers; at least one.
    pub fn numbers(self) -> Vec<u32> {
        (self.first..self.end).step_by(self.step as usize).collect()
    }

    /// The exclusive end of the range.
    pub fn end(self) -> u32 {
        self.end
    }
}

impl FromStr for FrameRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parse = || {
            let (range, step) = text.split_once(':').unwrap_or((text, "1"));
            let (first, end) = range.split_once("..")?;
            Some((first.parse().ok()?, end.parse().ok()?, step.parse().ok()?))
        };
        match parse() {
            Some((first, end, step)) if first < end && step > 0 => {
                let count = u32::div_ceil(end - first, step);
                if count > MAX_FRAMES {
                    return Err(format!("`{text}` are {count} frames: up to {MAX_FRAMES} are allowed"));
                }
                Ok(Self { first, end, step })
            }
            _ => Err(format!(
                "`{text}` is no range of frames: write FIRST..END:STEP, such as 0..800:16, with FIRST below END; END is \
                 not included, and :STEP may be left out for 1"
            )),
        }
    }
}

impl fmt::Display for FrameRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}..{}:{}", self.first, self.end, self.step)
    }
}

impl Serialize for FrameRange {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for FrameRange {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        String::deserialize(from)?.parse().map_err(D::Error::custom)
    }
}

/// The frames that machines replay, in ascending order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Replayed {
    /// All replayed frames.
    pub frames: Vec<u32>,
    /// The warm-up frames: replayed, but not measured.
    pub warmup: Vec<u32>,
}

impl Replayed {
    /// Whether machines replay `frame`.
    pub fn contains(&self, frame: u32) -> bool {
        self.frames.contains(&frame)
    }

    /// Whether machines replay and measure `frame`.
    pub fn measures(&self, frame: u32) -> bool {
        self.contains(frame) && !self.warmup.contains(&frame)
    }

    /// The measured frames.
    pub fn measured(&self) -> impl Iterator<Item = u32> {
        self.frames.iter().copied().filter(|&frame| self.measures(frame))
    }
}

/// A subset of the traced frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum FrameChoice {
    /// All traced frames.
    All,
    /// Every n-th traced frame, starting with the first: `Every(5)` takes one frame in five.
    Every(std::num::NonZeroU32),
    /// No frame.
    Never,
}

impl FrameChoice {
    /// The frames of `traced` that machines replay, with `warmup` frames before each measured one.
    pub fn replayed(self, traced: &[u32], warmup: usize) -> Replayed {
        let mut replayed = Replayed::default();
        let measures = |index: usize| index >= warmup && self.takes(index);
        for (index, &frame) in traced.iter().enumerate() {
            let is_measured = measures(index);
            let is_before = (index..traced.len().min(index + warmup + 1)).any(measures);
            let is_first = index < warmup && self != Self::Never;
            if is_measured || is_before || is_first {
                replayed.frames.push(frame);
            }
            if !is_measured && (is_before || is_first) {
                replayed.warmup.push(frame);
            }
        }
        replayed
    }

    /// Whether the traced frame at `index`, counted from 0, is chosen.
    pub fn takes(self, index: usize) -> bool {
        match self {
            Self::All => true,
            Self::Every(step) => index.is_multiple_of(step.get() as usize),
            Self::Never => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_gives_its_frames() {
        assert_eq!("0..800:16".parse::<FrameRange>().unwrap().numbers().len(), 50);
        assert_eq!("3..6".parse::<FrameRange>().unwrap().numbers(), [3, 4, 5]);
        assert_eq!("0..800:16".parse::<FrameRange>().unwrap().numbers().last(), Some(&784));
    }

    #[test]
    fn warm_up_frames_come_first_and_before_measured_ones() {
        let traced: Vec<u32> = (0..12).collect();
        let of = |choice: FrameChoice, warmup: usize| {
            let replayed = choice.replayed(&traced, warmup);
            (replayed.measured().collect::<Vec<_>>(), replayed.warmup)
        };
        let every = FrameChoice::Every(3.try_into().unwrap());
        assert_eq!(of(every, 0), (vec![0, 3, 6, 9], vec![]));
        assert_eq!(of(every, 1), (vec![3, 6, 9], vec![0, 2, 5, 8]));
        assert_eq!(of(every, 4), (vec![6, 9], vec![0, 1, 2, 3, 4, 5, 7, 8]));
        assert_eq!(of(FrameChoice::All, 2), ((2..12).collect(), vec![0, 1]));
        assert_eq!(of(FrameChoice::Never, 2), (vec![], vec![]));
    }

    #[test]
    fn nonsense_is_refused() {
        for text in ["", "5", "5..5", "6..5", "0..9:0", "0-9", "a..b", "0..9:x", "-1..4", "0..4:1:1"] {
            assert!(text.parse::<FrameRange>().is_err(), "{text}");
        }
    }
}
