//! Reads JSON schemas: the structure of types.

use serde_json::{Map, Value};

/// The structure of a type, as far as config files need it.
#[derive(Clone, Copy)]
pub(super) enum Shape<'a> {
    /// Fields by name.
    Fields(&'a Map<String, Value>),
    /// One of several variants.
    Choice(&'a [Value]),
    /// A list of one type.
    List(&'a Value),
    /// Values of one type, by arbitrary names.
    Map(&'a Value),
    /// A number, a text, a truth value, or alternatives of these.
    Plain,
}

/// A variant of a choice.
pub(super) struct Variant<'a> {
    /// The variant's name.
    pub name: &'a str,
    /// What it means.
    pub doc: String,
    /// The variant's payload.
    pub payload: Option<&'a Value>,
}

/// A schema, with the schemas that it refers to.
#[derive(Clone, Copy)]
pub(super) struct Schemas<'a> {
    root: &'a Value,
}

impl<'a> Schemas<'a> {
    pub(super) fn new(root: &'a Value) -> Self {
        Self { root }
    }

    /// Follows references and strips `null`: the schema of a value that is present.
    pub(super) fn resolve(self, schema: &'a Value) -> &'a Value {
        if let Some(name) = schema["$ref"].as_str().and_then(|path| path.strip_prefix("#/$defs/")) {
            return self.resolve(&self.root["$defs"][name]);
        }
        let present = |one: &&Value| one["type"] != "null";
        match schema["anyOf"].as_array() {
            Some(either) if either.iter().filter(present).count() == 1 => {
                either.iter().find(present).map_or(schema, |one| self.resolve(one))
            }
            _ => schema,
        }
    }

    /// The structure of values of `schema`.
    pub(super) fn shape(self, schema: &'a Value) -> Shape<'a> {
        let schema = self.resolve(schema);
        if let Some(fields) = schema["properties"].as_object() {
            return Shape::Fields(fields);
        }
        if let Some(variants) = schema["oneOf"].as_array() {
            return Shape::Choice(variants);
        }
        if let Some(either) = schema["anyOf"].as_array() {
            // Either a text or fields: the structure has the fields.
            let values = either.iter().find(|one| self.resolve(one)["properties"].is_object());
            return values.map_or(Shape::Plain, |values| self.shape(values));
        }
        if schema["additionalProperties"].is_object() {
            return Shape::Map(&schema["additionalProperties"]);
        }
        if schema["items"].is_object() { Shape::List(&schema["items"]) } else { Shape::Plain }
    }

    /// The variants of a choice.
    pub(super) fn variants(self, variants: &'a [Value]) -> Vec<Variant<'a>> {
        variants.iter().flat_map(|variant| self.of_variant(variant)).collect()
    }

    fn of_variant(self, variant: &'a Value) -> Vec<Variant<'a>> {
        let doc = || paragraphs(variant).0;
        let unit = |name: &'a Value| Some(Variant { name: name.as_str()?, doc: doc(), payload: None });
        if let Some(names) = variant["enum"].as_array() {
            return names.iter().filter_map(unit).collect();
        }
        if let Some(fields) = variant["properties"].as_object() {
            let of = |(name, payload)| Variant { name, doc: doc(), payload: Some(payload) };
            return fields.iter().map(|(name, payload)| of((name.as_str(), payload))).collect();
        }
        unit(&variant["const"]).into_iter().collect()
    }
}

/// Whether a value of `schema` may be absent (`None`).
pub(super) fn is_optional(schema: &Value) -> bool {
    let null = |types: &Value| types == "null" || types.as_array().is_some_and(|all| all.iter().any(|it| it == "null"));
    null(&schema["type"]) || schema["anyOf"].as_array().is_some_and(|all| all.iter().any(|one| null(&one["type"])))
}

/// Whether `schema` allows values of JSON's type `kind`.
pub(super) fn allows(schema: &Value, kind: &str) -> bool {
    schema["type"] == kind || schema["type"].as_array().is_some_and(|types| types.iter().any(|it| it == kind))
}

/// The doc comment of a schema, split into its meaning and its `Source:` paragraph.
pub(super) fn paragraphs(schema: &Value) -> (String, Option<String>) {
    let text = schema["description"].as_str().unwrap_or_default();
    let plain = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let (source, meaning): (Vec<_>, Vec<_>) = text.split("\n\n").map(plain).partition(|it| it.starts_with(SOURCE));
    let source = source.first().map(|text| text.trim_start_matches(SOURCE).trim().to_owned());
    (meaning.join(" "), source)
}

/// The start of a doc comment's paragraph that gives the source of numbers.
const SOURCE: &str = "Source:";
