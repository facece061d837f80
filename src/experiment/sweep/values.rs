//! The values tried for a field: a list, or a range.

use std::fmt;

use ron::value::RawValue;
use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::Value;

use crate::ron_file;
use crate::size;

/// The most values of a range.
const MOST: usize = 4096;

/// Values to try for a field: a list or, in a space of machines, a range.
#[derive(JsonSchema)]
#[serde(untagged)]
pub(super) enum Values {
    /// The listed values.
    #[expect(dead_code, reason = "only the schema is made from it: values stay as the file has them")]
    List(Vec<Value>),
    /// All values of a range.
    #[expect(dead_code, reason = "see above")]
    Range(Range),
}

/// A range of values, ends included.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub(super) enum Range {
    /// Powers of two times the lower end, up to the upper end.
    Log(End, End),
    /// All whole numbers from the lower to the upper end.
    Integers(End, End),
}

/// An end of a range: a number, or text with a unit.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "an end of a range is a whole number, or a size in quotes such as \"64 KiB\"")]
pub(super) enum End {
    /// A whole number.
    Number(u64),
    /// A size, such as `"64 KiB"`.
    Size(String),
}

impl fmt::Display for End {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => number.fmt(f),
            Self::Size(text) => write!(f, "{text:?}"),
        }
    }
}

impl End {
    fn amount(&self) -> Result<u64, String> {
        match self {
            Self::Number(number) => Ok(*number),
            Self::Size(text) => size::parse(text),
        }
    }
}

/// The values of a field in `vary`, in a config file's syntax.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Tried {
    /// The values in order.
    pub(super) values: Vec<String>,
    /// Whether they were written as a range.
    pub(super) is_range: bool,
}

impl Tried {
    /// Reads the text `raw` of the field `path` in `vary`.
    ///
    /// # Errors
    /// The text is neither a list nor a range, or a range has no values; the error says what is allowed.
    pub(super) fn read(path: &str, raw: &RawValue) -> Result<Self, String> {
        let text = raw.get_ron().trim();
        let options = ron::Options::default().with_default_extension(ron_file::extensions());
        if text.starts_with('[') {
            let list: Vec<Box<RawValue>> = options.from_str(text).map_err(|error| unreadable(path, text, &error))?;
            if list.is_empty() {
                return Err(format!("`vary` has no value for `{path}`: at least one is needed"));
            }
            let values = list.iter().map(|value| value.get_ron().trim().to_owned()).collect();
            return Ok(Self { values, is_range: false });
        }
        if !text.starts_with(|letter: char| letter.is_ascii_uppercase()) {
            return Err(format!("`vary` has `{text}` for `{path}`, which is neither a list nor a range: {ALLOWED}"));
        }
        let range: Range = options.from_str(text).map_err(|error| unreadable(path, text, &error))?;
        let values = range.values().map_err(|what| format!("`vary` has `{text}` for `{path}`: {what}"))?;
        Ok(Self { values, is_range: true })
    }
}

const ALLOWED: &str = "a list such as [1, 2, 4] is allowed, and in a space Log(256, 65536) and Integers(1, 8)";

fn unreadable(path: &str, text: &str, error: &ron::error::SpannedError) -> String {
    format!("`vary` has `{text}` for `{path}`: {}; {ALLOWED}", error.code)
}

impl Range {
    /// All values.
    fn values(&self) -> Result<Vec<String>, String> {
        let (Self::Log(low, high) | Self::Integers(low, high)) = self;
        let [least, most] = [low.amount()?, high.amount()?];
        if least > most {
            return Err(format!("the lower end {low} is above the upper end {high}: the lower end comes first"));
        }
        let values: Vec<u64> = match self {
            Self::Log(..) if least == 0 => {
                return Err(
                    "no number of doublings leads from 0 to anywhere: a lower end of 1 or more is allowed".into()
                );
            }
            Self::Log(..) => {
                let next = |value: &u64| value.checked_mul(2).filter(|next| *next <= most);
                let all: Vec<u64> = std::iter::successors(Some(least), next).collect();
                let last = all.last().copied().unwrap_or(least);
                if last != most {
                    let above = last.checked_mul(2).map_or(String::new(), |above| format!(" or {above}"));
                    return Err(format!(
                        "doublings of {low} do not meet {high}: an upper end of {last}{above} is allowed"
                    ));
                }
                all
            }
            Self::Integers(..) if most - least >= MOST as u64 => {
                return Err(format!("it has {} values: up to {MOST} are allowed", u128::from(most - least) + 1));
            }
            Self::Integers(..) => (least..=most).collect(),
        };
        Ok(values.iter().map(u64::to_string).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<String>, String> {
        let raw: &RawValue = RawValue::from_ron(text).unwrap();
        Tried::read("a.b", raw).map(|tried| tried.values)
    }

    #[test]
    fn lists_and_ranges_have_their_values() {
        assert_eq!(read("[1, \"2 KiB\", Own]").unwrap(), ["1", "\"2 KiB\"", "Own"]);
        assert_eq!(read("Log(256, \"2 KiB\")").unwrap(), ["256", "512", "1024", "2048"]);
        assert_eq!(read("Log(3, 12)").unwrap(), ["3", "6", "12"]);
        assert_eq!(read("Integers(2, 4)").unwrap(), ["2", "3", "4"]);
        assert_eq!(read("Integers(7, 7)").unwrap(), ["7"]);
    }

    #[test]
    fn what_is_no_range_is_refused_with_what_is() {
        let refused = [
            "[]",
            "Log(0, 64)",
            "Log(64, 16)",
            "Log(256, 1000)",
            "Log(256)",
            "Logg(1, 2)",
            "Integers(8, 1)",
            "Integers(1, 100000)",
            "Log(1, \"6 miles\")",
            "7",
            "Integers(-1, 4)",
            "Log(1.5, 3)",
        ]
        .map(|text| read(text).unwrap_err());
        insta::assert_snapshot!(refused.join("\n"));
    }
}
