//! Writes plain data as JSON by one serializer for all types: a copy of it for each type and format would be a
//! seventeenth of all code to compile.

use erased_serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Error, Value};

/// The JSON of `data` in one line.
///
/// # Errors
/// JSON cannot represent `data`, such as a map whose keys are not text.
pub(crate) fn line(data: &dyn Serialize) -> Result<String, Error> {
    serde_json::to_string(data)
}

/// The JSON of `data`, indented.
///
/// # Errors
/// See [`line`].
pub(crate) fn pretty(data: &dyn Serialize) -> Result<String, Error> {
    serde_json::to_string_pretty(data)
}

/// `data` as a tree of values.
///
/// # Errors
/// See [`line`].
pub(crate) fn value(data: &dyn Serialize) -> Result<Value, Error> {
    serde_json::to_value(data)
}

/// Reads what [`line`] or [`pretty`] wrote.
///
/// # Errors
/// The text is not JSON, or does not fit `T`.
pub(crate) fn read<T: DeserializeOwned>(text: &[u8]) -> Result<T, Error> {
    serde_json::from_slice(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_that_of_a_serializer_made_for_the_type() {
        let data = (0.1_f32, [("a", Some(u64::MAX)), ("b", None)], "\u{7}");
        assert_eq!(line(&data).unwrap(), serde_json::to_string(&data).unwrap());
        assert_eq!(pretty(&data).unwrap(), serde_json::to_string_pretty(&data).unwrap());
        assert_eq!(value(&data).unwrap(), serde_json::to_value(data).unwrap());
        assert_eq!(read::<Value>(pretty(&data).unwrap().as_bytes()).unwrap()[2], "\u{7}");
    }
}
