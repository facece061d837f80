//! Sizes in bytes with their units, as users write them. kB, MB and GB are powers of 1000; KiB, MiB and GiB of 1024.

use std::fmt;

use serde::Deserializer;
use serde::de::{Error, Visitor};

/// Units by name, each with its bytes.
const UNITS: [(&str, u64); 7] = [
    ("B", 1),
    ("kB", 1000),
    ("MB", 1_000_000),
    ("GB", 1_000_000_000),
    ("KiB", 1 << 10),
    ("MiB", 1 << 20),
    ("GiB", 1 << 30),
];

/// The bytes of a size such as `16384`, `16 KiB`, `16KiB` or `1.5 MB`.
///
/// # Errors
/// `text` is not a size, has an unknown unit, or is not a whole number of bytes; the error says what is allowed.
pub(crate) fn parse(text: &str) -> Result<u64, String> {
    let text = text.trim();
    let digits = text.find(|letter: char| !letter.is_ascii_digit() && !matches!(letter, '.' | '_'));
    let (number, unit) = text.split_at(digits.unwrap_or(text.len()));
    let wrong = |why: &str| {
        format!("`{text}` is no size{why}: a number of B, kB, MB, GB (of 1000), KiB, MiB or GiB (of 1024) is")
    };
    let unit = match unit.trim() {
        "" => 1,
        unit => UNITS.iter().find(|(name, _)| *name == unit).ok_or_else(|| wrong(""))?.1,
    };
    let (whole, fraction) = number.split_once('.').unwrap_or((number, ""));
    let plain: String = whole.chars().chain(fraction.chars()).filter(|letter| *letter != '_').collect();
    let number: u128 = plain.parse().map_err(|_| wrong(""))?;
    let places = fraction.chars().filter(|letter| *letter != '_').count();
    let parts = u32::try_from(places).ok().and_then(|places| 10u128.checked_pow(places));
    let bytes = parts.and_then(|parts| Some((number.checked_mul(u128::from(unit))?, parts)));
    let (bytes, parts) = bytes.ok_or_else(|| wrong(""))?;
    if !bytes.is_multiple_of(parts) {
        return Err(wrong(" in whole bytes"));
    }
    u64::try_from(bytes / parts).map_err(|_| wrong(""))
}

/// `bytes` in the largest binary unit that divides it: `16 KiB`, `100 B`.
pub(crate) fn told(bytes: u64) -> String {
    let unit = UNITS.iter().rev().filter(|(name, _)| name.ends_with("iB"));
    let whole = unit.clone().find(|(_, unit)| bytes > 0 && bytes.is_multiple_of(*unit));
    whole.map_or_else(|| format!("{bytes} B"), |(name, unit)| format!("{} {name}", bytes / unit))
}

/// The value of a config's field as a number: `16384`, or `"16 KiB"`; `None` for a name.
pub(crate) fn amount(value: &str) -> Option<f64> {
    let text = value.trim().trim_matches('"');
    text.parse().ok().or_else(|| parse(text).ok().map(|bytes| bytes as f64))
}

/// Reads a size: a number of bytes, or text with a unit.
pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<u64, D::Error> {
    struct Bytes;

    impl Visitor<'_> for Bytes {
        type Value = u64;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a number of bytes, or a size with its unit such as \"16 KiB\"")
        }

        fn visit_u64<E: Error>(self, bytes: u64) -> Result<u64, E> {
            Ok(bytes)
        }

        fn visit_i64<E: Error>(self, bytes: i64) -> Result<u64, E> {
            u64::try_from(bytes).map_err(|_| E::custom(format!("{bytes} is no size: at least 0 is allowed")))
        }

        fn visit_str<E: Error>(self, text: &str) -> Result<u64, E> {
            parse(text).map_err(E::custom)
        }
    }

    from.deserialize_any(Bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_of_1000_or_1024_as_their_names_say() {
        for (text, bytes) in [
            ("16384", 16_384),
            ("16 KiB", 16_384),
            ("16KiB", 16_384),
            (" 16 kB ", 16_000),
            ("1.5 MB", 1_500_000),
            ("0.5KiB", 512),
            ("4GiB", 1 << 32),
            ("1_024 B", 1024),
            ("1.50_0 MB", 1_500_000),
        ] {
            assert_eq!(parse(text), Ok(bytes), "{text}");
        }
        for text in ["", "KiB", "16 KB", "16 kib", "0.3 KiB", "-1", "1.2.3", "99999999999 GiB", "16 KiB/s"] {
            let error = parse(text).unwrap_err();
            assert!(error.contains("KiB, MiB or GiB (of 1024)"), "{text}: {error}");
        }
    }

    #[test]
    fn sizes_are_told_in_units_of_1024() {
        assert_eq!(
            [0, 100, 1024, 16_384, 1536, 1 << 20].map(told),
            ["0 B", "100 B", "1 KiB", "16 KiB", "1536 B", "1 MiB"]
        );
        assert_eq!(parse(&told(3 << 20)), Ok(3 << 20));
    }
}
