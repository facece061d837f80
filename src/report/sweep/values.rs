//! Values of fields, as numbers and in readable form.

use crate::size;

/// A value without the quotes of a text.
fn plain(value: &str) -> &str {
    value.trim().trim_matches('"')
}

/// A value of a field in readable form: sizes have a unit.
pub(crate) fn shown(field: &str, value: &str) -> String {
    let is_size = field.rsplit('.').next().is_some_and(|name| name.contains("bytes"));
    let bytes = size::parse(plain(value)).ok().filter(|_| is_size);
    bytes.map_or_else(|| plain(value).to_owned(), size::told)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::size::amount;

    #[test]
    fn sizes_have_units() {
        assert_eq!([amount("16384"), amount("\"16 KiB\""), amount("Own")], [Some(16384.0), Some(16384.0), None]);
        assert_eq!([shown("l2.bytes", "65536"), shown("l2.bytes", "\"64 KiB\"")], ["64 KiB", "64 KiB"]);
        assert_eq!([shown("l2.ways", "4"), shown("place", "Own"), shown("rate", "0.5")], ["4", "Own", "0.5"]);
        assert_eq!(["1020", "1021"].map(|rays| shown("dispatcher.rays", rays)), ["1020", "1021"], "told apart");
    }
}
