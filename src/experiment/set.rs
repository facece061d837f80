//! Sets fields of specs by their paths.

use std::str::FromStr;

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::alike;
use crate::json;
use crate::named::twice;

/// A field's path and the value that it gets, written `PATH=VALUE`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setting {
    /// The field's path, such as `shadow_cache.cache.bytes`.
    pub path: String,
    /// The value, as in a file.
    pub value: String,
}

impl FromStr for Setting {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('=').map(|(path, value)| (path.trim(), value.trim()));
        match parts.filter(|(path, value)| !path.is_empty() && !value.is_empty()) {
            Some((path, value)) => Ok(Self { path: path.into(), value: value.into() }),
            None => Err(format!("`{text}` is no PATH=VALUE, such as traversal.cache.bytes=16KiB")),
        }
    }
}

impl std::fmt::Display for Setting {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}={}", self.path, self.value)
    }
}

/// Checks that no field is set twice; the error names it.
pub(crate) fn check_once(settings: &[Setting]) -> Result<(), String> {
    let path = twice(settings.iter().map(|setting| &setting.path));
    path.map_or(Ok(()), |path| Err(format!("`--set` sets `{path}` twice")))
}

/// The names of a spec's fields.
pub(super) fn names(spec: &impl Serialize) -> Vec<String> {
    match data(spec) {
        Value::Object(fields) => fields.keys().cloned().collect(),
        _ => Vec::new(),
    }
}

/// Returns `spec` with `value` in the field at `path`. The path may leave out the name of an enum's variant:
/// `l2.bytes` is `l2.Unified.bytes` where `l2` is `Unified`.
///
/// # Errors
/// There is no such field, or it cannot have the value; the error says what is allowed.
pub(super) fn field<T: Serialize + DeserializeOwned>(spec: &T, path: &str, value: &str) -> Result<T, String> {
    let mut all = data(spec);
    let mut place = &mut all;
    let mut known = Vec::new();
    let parts: Vec<&str> = path.split('.').collect();
    for (index, &name) in parts.iter().enumerate() {
        let parent = parts[..index].join(".");
        place = inside(place, name);
        let Value::Object(fields) = place else {
            return Err(format!("`{parent}` has no fields of its own"));
        };
        known = fields.keys().cloned().collect();
        let is_last = index + 1 == parts.len();
        if !fields.contains_key(name) && !is_last {
            return Err(missing(&parent, name, &known));
        }
        // An unset optional field is not in the data: reading the spec below checks whether it exists.
        place = fields.entry(name).or_insert(Value::Null);
    }
    let is_there = !place.is_null();
    *place = plain(value);
    serde_json::from_value(all).map_err(|error| {
        let (parent, name) = path.rsplit_once('.').unwrap_or(("", path));
        let what = error.to_string();
        if !is_there && what.starts_with("unknown field") { missing(parent, name, &known) } else { what }
    })
}

/// The value of the field at `path`, as [`field`] takes it; `None` if there is no such field.
pub(super) fn value(spec: &impl Serialize, path: &str) -> Option<Value> {
    let mut all = data(spec);
    let found = path.split('.').try_fold(&mut all, |place, name| inside(place, name).get_mut(name));
    found.map(Value::take)
}

fn data(spec: &impl Serialize) -> Value {
    json::value(spec).expect("a spec is plain data, which JSON can hold")
}

/// `place`, or the contents of its variant if it is an enum's.
fn inside<'a>(place: &'a mut Value, name: &str) -> &'a mut Value {
    let variant = match place {
        Value::Object(fields) if fields.len() == 1 && !fields.contains_key(name) => {
            fields.keys().next().filter(|key| key.starts_with(|letter: char| letter.is_ascii_uppercase())).cloned()
        }
        _ => None,
    };
    match variant {
        Some(variant) if place[&variant].is_object() => &mut place[&variant],
        _ => place,
    }
}

fn missing(parent: &str, name: &str, known: &[String]) -> String {
    let names: Vec<&str> = known.iter().map(String::as_str).collect();
    let alike = alike::closest(name, &names).map(|alike| format!("; did you mean `{alike}`?")).unwrap_or_default();
    let names = names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    let place = if parent.is_empty() { String::new() } else { format!(" in `{parent}`") };
    format!("there is no field `{name}`{place}{alike} Allowed: {names}").replace("` Allowed", "`; allowed")
}

/// Converts a value as in a file or on a command line to data. A bare name is a variant or a text, also within fields
/// and lists, where RON without types would read nothing.
fn plain(text: &str) -> Value {
    let text = text.trim();
    let is_word = |text: &str| text.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_');
    let is_variant = |name: &str| is_word(name) && name.starts_with(|letter: char| letter.is_ascii_uppercase());
    // A variant with a payload in brackets.
    if let Some((name, rest)) = text.split_once('(')
        && let Some(inner) = rest.strip_suffix(')')
        && is_variant(name)
    {
        let payload = || if inner.is_empty() { fields(inner) } else { fields(inner).or_else(|| Some(plain(inner))) };
        return match payload() {
            Some(payload) if name == "Some" => payload,
            Some(payload) => Value::Object([(name.to_owned(), payload)].into_iter().collect()),
            None => Value::String(text.into()),
        };
    }
    let within = |open: char, close: char| text.strip_prefix(open).and_then(|rest| rest.strip_suffix(close));
    let list = || Some(Value::Array(parts(within('[', ']')?)?.into_iter().map(plain).collect()));
    let found = within('(', ')').or_else(|| within('{', '}')).and_then(fields).or_else(list);
    found.unwrap_or_else(|| match text {
        "true" | "false" | "None" => ron::from_str(text).unwrap_or(Value::Null),
        _ if is_word(text) && text.starts_with(|letter: char| letter.is_alphabetic()) => Value::String(text.into()),
        _ => ron::from_str(text).unwrap_or_else(|_| Value::String(text.into())),
    })
}

/// The object of `NAME: VALUE, ...`; a name may be quoted. `None` if the text is something else.
fn fields(text: &str) -> Option<Value> {
    let field = |part: &str| {
        let (name, value) = match part.strip_prefix('"') {
            Some(quoted) => {
                quoted.split_once('"').and_then(|(name, rest)| Some((name, rest.trim().strip_prefix(':')?)))?
            }
            None => part.split_once(':').filter(|(name, _)| !name.contains(['(', '[', '{', '"']))?,
        };
        (!value.trim().is_empty()).then(|| (name.trim().to_owned(), plain(value)))
    };
    parts(text)?.into_iter().map(field).collect::<Option<_>>().map(Value::Object)
}

/// The parts of `text` between commas outside of brackets and quotes; the last may be empty and is left out then.
/// `None` if a bracket or a quote is not closed.
fn parts(text: &str) -> Option<Vec<&str>> {
    let (mut all, mut from, mut depth, mut quoted) = (Vec::new(), 0, 0u32, false);
    for (at, letter) in text.char_indices() {
        match letter {
            '"' => quoted = !quoted,
            _ if quoted => {}
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => depth = depth.checked_sub(1)?,
            ',' if depth == 0 => {
                all.push(text[from..at].trim());
                from = at + 1;
            }
            _ => {}
        }
    }
    let last = text[from..].trim();
    all.extend((!last.is_empty()).then_some(last));
    (depth == 0 && !quoted && all.iter().all(|part| !part.is_empty())).then_some(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::MachineSpec;
    use crate::machine::shadow_cache::Place;

    /// Bare variants stand within fields and lists too.
    #[test]
    fn values_are_read_as_in_files() {
        let json = |text: &str| plain(text).to_string();
        let read = [
            ("Sampled(engine: Event, rate: 0.5)", r#"{"Sampled":{"engine":"Event","rate":0.5}}"#),
            ("Auto(error: 0.02)", r#"{"Auto":{"error":0.02}}"#),
            ("(a: Some(3), b: [X, Y(2)], c: None,)", r#"{"a":3,"b":["X",{"Y":2}],"c":null}"#),
            (r#"{"a, (b": Z}"#, r#"{"a, (b":"Z"}"#),
            (r#"{"a, b": "x, y: z"}"#, r#"{"a, b":"x, y: z"}"#),
            ("Published()", r#"{"Published":{}}"#),
            ("Unified((bytes: \"64 KiB\"))", r#"{"Unified":{"bytes":"64 KiB"}}"#),
            ("[Column(1), Row]", r#"[{"Column":1},"Row"]"#),
            ("()", "{}"),
            ("[]", "[]"),
            ("Random(seed: 7)", r#"{"Random":{"seed":7}}"#),
            ("64KiB", r#""64KiB""#),
            ("-3", "-3"),
            ("true", "true"),
            ("(a: [)", r#""(a: [)""#),
        ];
        for (text, expected) in read {
            assert_eq!(json(text), expected, "{text}");
        }
    }

    #[test]
    fn any_field_can_be_set_and_errors_say_what_is_allowed() {
        let base = MachineSpec::default();
        let set = |path, value| field(&base, path, value);
        for size in ["65536", "64KiB", "\"64 KiB\""] {
            assert_eq!(set("shadow_cache.cache.bytes", size).unwrap().shadow_cache.cache.bytes.get(), 65536, "{size}");
        }
        assert_eq!(set("shadow_cache.place", "L2").unwrap().shadow_cache.place, Place::L2);
        assert_eq!(set("traversal.cache.banks", "4").unwrap().traversal.cache.banks.map(|banks| banks.get()), Some(4));
        assert_eq!(set("l2.bytes", "256 KiB"), set("l2.Unified.bytes", "262144"));
        assert_eq!(set("dram.model", "Flat(latency: 50)").unwrap().dram.peak_bytes_per_cycle(500), None);
        let error = |path, value| set(path, value).unwrap_err();
        let known = "there is no field `cont` in `shadow_cache`; did you mean `count`? Allowed: `count`, `latency`,";
        assert!(error("shadow_cache.cont", "1").starts_with(known), "{}", error("shadow_cache.cont", "1"));
        assert!(error("shadow_cash.place", "L2").starts_with("there is no field `shadow_cash`; did you mean"));
        assert!(error("clock_mhz.x", "1").contains("`clock_mhz` has no fields of its own"));
        assert!(error("shadow_cache.place", "Onw").contains("expected one of `Own`, `Triangle`, `L2`, `Free`"));
        assert!(error("shadow_cache.count", "0").contains("0 is not allowed here: a whole number from 1 to 64 is"));
    }

    #[test]
    fn a_value_is_found_where_it_is_set() {
        let machine = field(&MachineSpec::default(), "l2.bytes", "256 KiB").unwrap();
        for path in ["l2.bytes", "l2.Unified.bytes"] {
            assert_eq!(value(&machine, path), Some(262_144.into()), "{path}");
        }
        assert_eq!(value(&machine, "shadow_cache.place"), Some("Own".into()));
        assert_eq!(value(&machine, "l2.byte"), None);
    }

    #[test]
    fn a_setting_is_a_path_and_a_value() {
        let setting: Setting = "dram.model = Flat(latency: 50)".parse().unwrap();
        assert_eq!((setting.path.as_str(), setting.value.as_str()), ("dram.model", "Flat(latency: 50)"));
        assert!("dram".parse::<Setting>().unwrap_err().contains("is no PATH=VALUE"));
    }
}
