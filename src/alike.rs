//! Names that are nearly another name.

/// How alike two names must be for one to be proposed in place of the other, from 0 to 1.
const ALIKE: f64 = 0.7;

/// The name among `names` that is most like `name`, if one is alike.
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
