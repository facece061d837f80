//! Finds names that are similar to a misspelt one.

/// The least similarity (Jaro-Winkler, from 0 to 1) for a name to be proposed in place of another. Assumed.
const ALIKE: f64 = 0.7;

/// The name among `names` that is most similar to `name`, if any is similar enough.
pub(crate) fn closest<'a>(name: &str, names: &[&'a str]) -> Option<&'a str> {
    let small = name.to_lowercase();
    let alike = names.iter().map(|other| (strsim::jaro_winkler(&small, &other.to_lowercase()), *other));
    let alike = alike.filter(|(alike, _)| *alike >= ALIKE);
    alike.max_by(|(one, _), (other, _)| one.total_cmp(other)).map(|(_, other)| other)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_with_a_slip_is_known_and_another_name_is_not() {
        let names = ["small", "desktop", "Event"];
        assert_eq!(closest("smal", &names), Some("small"));
        assert_eq!(closest("event", &names), Some("Event"));
        assert_eq!(closest("qqq", &names), None);
        assert_eq!(closest("small", &[]), None);
    }
}
