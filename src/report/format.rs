//! Numbers in a readable form.

use crate::quantity::Bytes;

/// The sign for a missing number.
pub(crate) const ABSENT: &str = "\u{2013}";

/// A whole number with separated thousands: `17,012`.
pub(crate) fn exact(value: u64) -> String {
    let digits = value.to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A number with about three digits and a decimal prefix: `63.0 M`, `812`, `0.203`.
pub(crate) fn short(value: f64) -> String {
    prefixed(value, &["", " k", " M", " G", " T", " P"])
}

/// A number on an axis, without trailing zeros: `5 M`.
pub(crate) fn tick(value: f64) -> String {
    let text = short(value);
    let (digits, prefix) = text.split_once(' ').map_or((text.as_str(), ""), |(digits, prefix)| (digits, prefix));
    let digits = if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { digits };
    format!("{digits} {prefix}").trim_end().to_owned()
}

/// A number for other programs, with at most six decimals.
pub(crate) fn number(value: f64) -> String {
    let text = format!("{value:.6}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// An amount of data, in decimal units: `1.24 GB`.
pub(crate) fn bytes(value: Bytes) -> String {
    prefixed(value.0 as f64, &[" B", " kB", " MB", " GB", " TB", " PB"])
}

fn prefixed(value: f64, units: &[&str]) -> String {
    // 999.5 is the least number that rounds up to a thousand at three digits.
    let mut rank = 0;
    let mut scaled = value;
    while scaled.abs() >= 999.5 && rank + 1 < units.len() {
        scaled /= 1000.0;
        rank += 1;
    }
    let whole = rank == 0 && scaled.fract() == 0.0;
    let digits = match scaled.abs() {
        _ if whole => 0,
        size if size < 0.9995 => 3,
        size if size < 9.995 => 2,
        size if size < 99.95 => 1,
        _ => 0,
    };
    format!("{scaled:.digits$}{}", units[rank])
}

/// A share as percent: `18.7 %`, and `0.027 %` where one decimal is too few.
pub(crate) fn percent(share: f64) -> String {
    let percent = share * 100.0;
    // Below 0.0005, all decimals are 0, and only the sign would remain.
    let (percent, digits) = match percent.abs() {
        size if size < 0.0005 => (0.0, 1),
        size if size < 0.0995 => (percent, 3),
        _ => (percent, 1),
    };
    format!("{percent:.digits$} %").replace('-', "\u{2212}")
}

/// A share on an axis.
pub(crate) fn percent_tick(share: f64) -> String {
    percent(share).replace(".0 ", " ")
}

/// The change from `before` to `after` as percent, with its sign; `None` if `before` is 0.
pub(crate) fn change(before: f64, after: f64) -> Option<String> {
    (before != 0.0).then(|| {
        let change = percent(after / before - 1.0);
        if after > before && !change.starts_with("0.0 ") { format!("+{change}") } else { change }
    })
}

/// A count and its noun: `1 light`, `3 lights`, `2 policies`.
pub(crate) fn counted(count: usize, noun: &str) -> String {
    let nouns = match noun.strip_suffix('y').filter(|stem| !stem.ends_with(['a', 'e', 'o', 'u'])) {
        Some(stem) if count != 1 => format!("{stem}ies"),
        _ if count != 1 => format!("{noun}s"),
        _ => noun.to_owned(),
    };
    format!("{} {nouns}", exact(count as u64))
}

/// A change as percent, with its sign.
pub(crate) fn signed(share: f64) -> String {
    if share > 0.0 { format!("+{}", percent(share)) } else { percent(share) }
}

/// Formats a number, or gives the sign for its absence.
pub(crate) fn or_absent<T>(value: Option<T>, show: impl FnOnce(T) -> String) -> String {
    value.map_or_else(|| ABSENT.into(), show)
}

/// A key of a file as words: `l1_traversal` becomes `L1 traversal`.
pub(crate) fn words(key: &str) -> String {
    const UPPER: [&str; 9] = ["l1", "l2", "dram", "trv", "ist", "ist1", "ist2", "scu", "ra"];
    let shown = |word: &str| match word {
        "fifos" => "FIFOs".to_owned(),
        word if UPPER.contains(&word) => word.to_uppercase(),
        word => word.to_owned(),
    };
    key.split('_').map(shown).collect::<Vec<String>>().join(" ")
}

/// Milliseconds with three digits.
pub(crate) fn milliseconds(value: f64) -> String {
    let digits = if value >= 100.0 {
        0
    } else if value >= 10.0 {
        1
    } else if value >= 1.0 {
        2
    } else {
        3
    };
    format!("{value:.digits$}")
}

/// Joules with a prefix and three digits.
pub(crate) fn joules(value: f64) -> String {
    let (factor, unit) = match value {
        value if value >= 1.0 => (1.0, "J"),
        value if value >= 1e-3 => (1e3, "mJ"),
        value if value >= 1e-6 => (1e6, "\u{b5}J"),
        _ => (1e9, "nJ"),
    };
    format!("{} {unit}", milliseconds(value * factor))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!([exact(0), exact(999), exact(17_012), exact(1_234_567)], ["0", "999", "17,012", "1,234,567"]);
        assert_eq!([short(0.0), short(812.0), short(0.203)], ["0", "812", "0.203"]);
        assert_eq!([short(999.6), short(63_012_345.0), short(9_996.0)], ["1.00 k", "63.0 M", "10.0 k"]);
        assert_eq!([tick(5e6), tick(1500.0), tick(0.25), tick(100.0)], ["5 M", "1.5 k", "0.25", "100"]);
        assert_eq!([bytes(Bytes(1_236_000_000)), bytes(Bytes(12))], ["1.24 GB", "12 B"]);
        assert_eq!([percent(0.187), percent(0.000_27), percent(-0.041)], ["18.7 %", "0.027 %", "\u{2212}4.1 %"]);
        assert_eq!([percent(-1e-12), percent(0.000_999_6)], ["0.0 %", "0.1 %"]);
        assert_eq!(change(100.0, 103.0).as_deref(), Some("+3.0 %"));
        assert_eq!(change(100.0, 100.0).as_deref(), Some("0.0 %"));
        assert_eq!(change(0.0, 1.0), None);
        assert_eq!([counted(1, "light"), counted(3, "light")], ["1 light", "3 lights"]);
        assert_eq!([words("l1_traversal"), words("mode_word"), words("dram")], ["L1 traversal", "mode word", "DRAM"]);
    }
}
