//! Describes kinds, ranges and values of fields in words.

use serde_json::Value;

use super::schema::{Schemas, Shape, allows};
use crate::size;

/// The kind of a value, for a reader.
pub(super) fn kind(schemas: Schemas<'_>, schema: &Value) -> String {
    let schema = schemas.resolve(schema);
    match schemas.shape(schema) {
        Shape::Fields(_) if schema["anyOf"].is_array() => "text, or fields".into(),
        Shape::Fields(_) => "fields".into(),
        Shape::Choice(_) => "choice".into(),
        Shape::Map(of) => format!("map of names to {}", kind(schemas, of)),
        Shape::List(of) => match schema["maxItems"].as_u64() {
            Some(count) => format!("{count} numbers"),
            None => match kind(schemas, of).as_str() {
                "choice" => "list".into(),
                "fields" => "list of fields".into(),
                of => format!("list of {of}"),
            },
        },
        Shape::Plain => plain(schema).into(),
    }
}

fn plain(schema: &Value) -> &'static str {
    let is_power = schema["kind"] == "a power of two";
    match (allows(schema, "string"), allows(schema, "integer"), allows(schema, "number")) {
        (true, true, _) if is_power => "size, a power of two",
        (true, true, _) => "size",
        (true, ..) => "text",
        (_, true, _) if is_power => "power of two",
        (_, true, _) => "whole number",
        (.., true) => "number",
        _ if allows(schema, "boolean") => "true or false",
        _ => "value",
    }
}

/// The range of a number.
pub(super) fn range(schemas: Schemas<'_>, schema: &Value) -> Option<String> {
    let schema = schemas.resolve(schema);
    let is_size = schema["unit"] == "bytes";
    let number = |name: &str| schema[name].as_f64().map(|value| number(value, is_size));
    let low = number("minimum").or_else(|| Some(format!("above {}", number("exclusiveMinimum")?)));
    let high = number("maximum").or_else(|| Some(format!("below {}", number("exclusiveMaximum")?)));
    // An unsigned number without other limits shows no range.
    if schema["format"].is_string() && low.as_deref() == Some("0") && high.is_none() {
        return None;
    }
    match (low, high) {
        (Some(low), Some(high)) => Some(format!("{low} to {high}").replace("to below", "and below")),
        (Some(low), None) => Some(format!("at least {low}")),
        (None, high) => high.map(|high| format!("at most {high}")),
    }
}

fn number(value: f64, is_size: bool) -> String {
    if is_size {
        return size::told(value as u64);
    }
    let far = value != 0.0 && !(1e-4..1e7).contains(&value.abs());
    if far { format!("{value:e}") } else { value.to_string() }
}

/// A value in RON's syntax.
pub(super) fn value(schemas: Schemas<'_>, schema: &Value, value: &Value) -> String {
    let schema = schemas.resolve(schema);
    let is_choice = matches!(schemas.shape(schema), Shape::Choice(_));
    match value {
        Value::Null => "none".into(),
        Value::Bool(it) => it.to_string(),
        Value::Number(it) if schema["unit"] == "bytes" => it.as_u64().map_or_else(|| it.to_string(), size::told),
        Value::Number(it) => it.as_f64().map_or_else(|| it.to_string(), |it| number(it, false)),
        Value::String(name) if is_choice => name.clone(),
        Value::String(text) => format!("{text:?}"),
        Value::Array(all) => {
            let item = if let Shape::List(item) = schemas.shape(schema) { item } else { schema };
            let all: Vec<_> = all.iter().map(|it| self::value(schemas, item, it)).collect();
            if schema["maxItems"].is_u64() { format!("({})", all.join(", ")) } else { format!("[{}]", all.join(", ")) }
        }
        Value::Object(fields) => {
            let told = fields.iter().map(|(name, of)| match is_choice {
                true => format!("{name}({})", self::value(schemas, &Value::Null, of)),
                false => format!("{name}: {}", self::value(schemas, &Value::Null, of)),
            });
            let told = told.collect::<Vec<_>>().join(", ");
            if is_choice { told } else { format!("({told})") }
        }
    }
}
