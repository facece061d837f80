//! A shard: one of several shares of a sweep's points, of about equal cost.

use std::fmt;
use std::str::FromStr;

/// The most shards of a sweep.
const MAX_SHARDS: usize = 100_000;

/// Shard `I` of `N`, written `I/N`, with `I` from 1 to `N`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Shard {
    index: usize,
    of: usize,
}

impl Shard {
    /// The only shard: everything.
    pub(super) const WHOLE: Self = Self { index: 0, of: 1 };

    /// All shards of a division into `of`.
    pub(super) fn all(of: usize) -> impl Iterator<Item = Self> {
        (0..of).map(move |index| Self { index, of })
    }

    /// The shard's index, from 0.
    pub(super) fn index(self) -> usize {
        self.index
    }

    /// The number of shards.
    pub(super) fn of(self) -> usize {
        self.of
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(number, of)| Some((number.parse().ok()?, of.parse().ok()?)));
        match numbers {
            Some((number, of)) if (1..=of).contains(&number) && of <= MAX_SHARDS => Ok(Self { index: number - 1, of }),
            _ => Err(format!(
                "`{text}` is no shard: write I/N, such as 3/16, with I from 1 to N, and N up to {MAX_SHARDS}"
            )),
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index + 1, self.of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shard_is_written_as_it_is_read() {
        for text in ["1/1", "3/16", "16/16"] {
            assert_eq!(text.parse::<Shard>().unwrap().to_string(), text);
        }
        for wrong in ["", "3", "0/4", "5/4", "a/4", "1/-4", "1/4/4", "1/100001"] {
            assert!(wrong.parse::<Shard>().unwrap_err().contains("write I/N"), "{wrong}");
        }
    }
}
