//! The text about fields that `describe` and the book's page show.

use std::fmt::Write as _;

use super::root::Root;
use super::table::{Field, fields};
use crate::alike;

/// What `describe` shows.
pub(crate) enum Description {
    /// A single field.
    One(Field),
    /// A field with fields of its own, and these.
    Group(Field, Vec<Field>),
}

/// The field at `path`, such as `machine.traversal.cache.bytes`.
///
/// # Errors
/// There is no such field; the error names a similar one, and the allowed ones.
pub(crate) fn describe(path: &str) -> Result<Description, String> {
    let name = path.split('.').next().unwrap_or_default();
    let Some(root) = Root::ALL.into_iter().find(|root| root.name() == name) else {
        let all: Vec<Field> = Root::ALL.into_iter().flat_map(fields).collect();
        let ending = all.iter().find(|field| field.path.ends_with(&format!(".{path}"))).map(|field| &field.path);
        let roots = Root::ALL.map(Root::name);
        let alike = ending.map(String::as_str).or_else(|| alike::closest(name, &roots));
        return Err(unknown(&format!("there is no kind of file `{name}`"), alike, roots.iter().copied()));
    };
    let all = fields(root);
    let Some(at) = all.iter().position(|field| field.path == path) else {
        return Err(missing(&all, path));
    };
    let field = all[at].clone();
    let children: Vec<Field> = all.into_iter().filter(|it| parent(&it.path) == Some(path)).collect();
    Ok(if children.is_empty() { Description::One(field) } else { Description::Group(field, children) })
}

fn parent(path: &str) -> Option<&str> {
    path.rsplit_once('.').map(|(parent, _)| parent)
}

/// The error for an unknown path: names its first wrong part.
fn missing(all: &[Field], path: &str) -> String {
    let has = |path: &str| all.iter().any(|field| field.path == path);
    let mut known = path;
    while !has(known) {
        known = parent(known).unwrap_or_default();
    }
    let wrong = path[known.len()..].trim_start_matches('.');
    let wrong = wrong.split('.').next().unwrap_or_default();
    let names: Vec<&str> = all.iter().filter(|it| parent(&it.path) == Some(known)).map(Field::name).collect();
    // The field may be deeper: in `machine.l2.bytes` the name of a variant is missing.
    let inside = format!("{known}.");
    let deeper = all.iter().find(|it| it.path.starts_with(&inside) && it.path.ends_with(&path[known.len()..]));
    let alike = deeper.map(|field| field.path.as_str()).or_else(|| alike::closest(wrong, &names));
    if names.is_empty() && alike.is_none() {
        return format!("`{known}` has no fields of its own");
    }
    unknown(&format!("`{known}` has no `{wrong}`"), alike, names.into_iter())
}

fn unknown<'a>(what: &str, alike: Option<&str>, allowed: impl Iterator<Item = &'a str>) -> String {
    let alike = alike.map(|alike| format!("; did you mean `{alike}`?")).unwrap_or_default();
    let allowed = allowed.map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    format!("{what}{alike}\nallowed: {allowed}")
}

impl Field {
    /// The last part of the field's path.
    pub(crate) fn name(&self) -> &str {
        self.path.rsplit('.').next().unwrap_or_default()
    }

    /// Kind, unit, range and default in one line: `whole number of cycles, 1 to 1000; default 8`.
    pub(crate) fn facts(&self) -> String {
        let names: Vec<&str> = self.choices.iter().map(|(name, _)| name.as_str()).collect();
        let is_short = self.kind == "choice" && names.len() <= 8;
        let mut text = if is_short { names.join(" | ") } else { self.kind.clone() };
        match &self.unit {
            Some(unit) if !self.kind.starts_with("size") && !self.has_fields => {
                let _ = write!(text, " of {unit}");
            }
            Some(unit) if self.has_fields => {
                let _ = write!(text, " in {unit}");
            }
            _ => {}
        }
        if let Some(range) = &self.range {
            let _ = write!(text, ", {range}");
        }
        match &self.default {
            Some(default) if self.kind == "fields" && default != "none" => {}
            Some(default) => {
                let _ = write!(text, "; default {default}");
            }
            None if self.path.contains('.') => text += "; required",
            None => {}
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(path: &str) -> Field {
        match describe(path) {
            Ok(Description::One(field) | Description::Group(field, _)) => field,
            Err(error) => panic!("{path}: {error}"),
        }
    }

    #[test]
    fn a_field_has_unit_range_default_and_source_of_its_spec() {
        let bytes = one("machine.traversal.cache.bytes");
        assert_eq!((bytes.unit.as_deref(), bytes.range.as_deref()), (Some("bytes"), Some("32 B to 256 MiB")));
        assert_eq!((bytes.default.as_deref(), bytes.kind.as_str()), (Some("8 KiB"), "size"));
        assert!(bytes.source.as_ref().is_some_and(|it| it.contains("Nah et al. 2011")), "{bytes:?}");
        assert_eq!(one("machine.list.latency").facts(), "whole number of cycles, 1 to 1000; default 2");
        let words = one("machine.shadow_cache.cache.bytes").default.unwrap_or_default();
        assert_eq!(words, "8 KiB; 4 KiB where all of `machine.shadow_cache.cache` is left out");
        assert_eq!(one("dram.timing.cl").facts(), "whole number of clocks of the DRAM, 1 to 1000; required");
        assert_eq!(one("experiment.tracer.render.depth").facts(), "whole number, 1 to 32; default 1");
        let place = one("machine.shadow_cache.place");
        assert_eq!(
            place.choices.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(),
            ["Own", "Triangle", "L2", "Free"]
        );
        assert!(place.choices.iter().all(|(_, meaning)| !meaning.is_empty()));
    }

    #[test]
    fn every_field_has_a_meaning() {
        for field in Root::ALL.into_iter().flat_map(fields) {
            assert!(!field.meaning.is_empty(), "`{}` has no meaning", field.path);
            assert!(field.choices.iter().all(|(_, meaning)| !meaning.is_empty()), "{field:?}");
        }
    }

    #[test]
    fn a_path_that_is_not_there_is_told_with_one_that_is() {
        let error = |path| describe(path).err().unwrap_or_default();
        assert!(
            error("machine.traversal.cach")
                .starts_with("`machine.traversal` has no `cach`; did you mean `cache`?\nallowed: `count`")
        );
        assert!(error("machin").starts_with("there is no kind of file `machin`; did you mean `machine`?"));
        assert!(error("shadow_cache.cache").contains("did you mean `machine.shadow_cache.cache`?"));
        assert!(
            error("machine.l2.bytes").contains("did you mean `machine.l2.Unified.bytes`?"),
            "{}",
            error("machine.l2.bytes")
        );
        assert_eq!(error("machine.clock_mhz.x"), "`machine.clock_mhz` has no fields of its own");
    }
}
