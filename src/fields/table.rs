//! The table of all fields.

use serde_json::Value;

use super::root::Root;
use super::schema::{Schemas, Shape, is_optional, paragraphs};
use super::text;

/// A field of a config file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Field {
    /// The field's path, such as `machine.traversal.cache.bytes`. The path leaves out names that users choose and
    /// positions in lists, and has the name of a variant with fields.
    pub path: String,
    /// The kind of its value.
    pub kind: String,
    /// The unit of a number.
    pub unit: Option<String>,
    /// The range of a number.
    pub range: Option<String>,
    /// The value if the field is left out; `None` if it is required.
    pub default: Option<String>,
    /// What it means.
    pub meaning: String,
    /// Where its default comes from.
    pub source: Option<String>,
    /// The variants of a choice, each with its meaning.
    pub choices: Vec<(String, String)>,
    /// Whether it has fields of its own.
    pub has_fields: bool,
}

/// All fields of a kind of file, each after its parent.
pub(crate) fn fields(root: Root) -> Vec<Field> {
    let schema = root.schema();
    let schemas = Schemas::new(&schema);
    let mut table = Table { schemas, found: Vec::new() };
    let (meaning, source) = paragraphs(&schema);
    let place = Place { path: root.name().into(), unit: None, source: source.clone(), whole: Vec::new() };
    table.found.push(Field {
        path: place.path.clone(),
        kind: text::kind(schemas, &schema),
        unit: None,
        range: None,
        default: None,
        meaning,
        source,
        choices: table.choices(&schema),
        has_fields: true,
    });
    table.inside(&place, &schema);
    table.found
}

struct Table<'a> {
    schemas: Schemas<'a>,
    found: Vec<Field>,
}

/// The default of a field whose fields have their own defaults.
const INSIDE: &str = "that of its fields";

/// The position of a type in a file.
#[derive(Clone)]
struct Place<'a> {
    path: String,
    /// The inherited unit and source, for fields without their own.
    unit: Option<String>,
    source: Option<String>,
    /// Paths of the enclosing fields, innermost first, each with this type's value if that field is left out.
    whole: Vec<(String, &'a Value)>,
}

impl<'a> Table<'a> {
    /// Adds all fields of a type.
    fn inside(&mut self, place: &Place<'a>, schema: &'a Value) {
        match self.schemas.shape(schema) {
            Shape::Fields(fields) => {
                let required = self.schemas.resolve(schema)["required"].as_array();
                for (name, of) in fields {
                    let is_required = required.is_some_and(|all| all.iter().any(|it| it == name));
                    self.field(place, name, of, is_required);
                }
            }
            Shape::Choice(variants) => {
                for variant in self.schemas.variants(variants) {
                    if let Some(payload) = variant.payload {
                        let path = format!("{}.{}", place.path, variant.name);
                        self.of_variant(Place { path, whole: Vec::new(), ..place.clone() }, payload, &variant.doc);
                    }
                }
            }
            Shape::List(of) | Shape::Map(of) => self.inside(&Place { whole: Vec::new(), ..place.clone() }, of),
            Shape::Plain => {}
        }
    }

    /// Adds a variant that has fields, and its fields.
    fn of_variant(&mut self, place: Place<'a>, payload: &'a Value, doc: &str) {
        let has_fields = self.has_fields(payload);
        self.found.push(Field {
            path: place.path.clone(),
            kind: text::kind(self.schemas, payload),
            unit: text_of(&self.schemas.resolve(payload)["unit"]),
            range: text::range(self.schemas, payload),
            default: None,
            meaning: doc.into(),
            source: None,
            choices: self.choices(payload),
            has_fields,
        });
        self.inside(&place, payload);
    }

    /// Adds a field and its own fields.
    fn field(&mut self, place: &Place<'a>, name: &str, schema: &'a Value, is_required: bool) {
        let resolved = self.schemas.resolve(schema);
        let (own, own_source) = paragraphs(schema);
        let (of_type, source_of_type) = paragraphs(resolved);
        let path = format!("{}.{name}", place.path);
        let unit = text_of(&schema["unit"]).or_else(|| text_of(&resolved["unit"]));
        let default = &schema["default"];
        let has_fields = self.has_fields(schema);
        // The field's values if an enclosing field is left out.
        let whole: Vec<_> = place.whole.iter().map(|(path, value)| (path.clone(), &value[name])).collect();
        let told = |value: &Value| text::value(self.schemas, schema, value);
        let mut left_out = (!is_required).then(|| told(default));
        if has_fields && !matches!(self.schemas.shape(schema), Shape::Choice(_)) {
            // Each of its fields shows its own default.
            left_out = (!is_required).then(|| if is_optional(schema) { "none" } else { INSIDE }.into());
        } else if let (Some(text), Some((outer, value))) =
            (&mut left_out, whole.iter().find(|(_, value)| !value.is_null() && *value != default))
        {
            *text = format!("{text}; {} where all of `{outer}` is left out", told(value));
        }
        let inner = place.unit.clone();
        self.found.push(Field {
            kind: text::kind(self.schemas, schema),
            unit: unit.clone().or(inner.clone()).filter(|_| !has_fields || unit.is_some()),
            range: text::range(self.schemas, schema).or_else(|| text::range(self.schemas, resolved)),
            default: left_out,
            meaning: if own.is_empty() { of_type } else { own },
            source: own_source.or_else(|| source_of_type.clone()).or_else(|| place.source.clone()),
            choices: self.choices(schema),
            has_fields,
            path: path.clone(),
        });
        let whole = std::iter::once((path.clone(), default)).filter(|(_, value)| value.is_object()).chain(whole);
        let whole = whole.filter(|(_, value)| value.is_object()).collect();
        self.inside(&Place { path, unit: unit.or(inner), source: source_of_type, whole }, schema);
    }

    /// Whether values of a type have fields, at any depth.
    fn has_fields(&self, schema: &'a Value) -> bool {
        match self.schemas.shape(schema) {
            Shape::Fields(_) => true,
            Shape::Choice(variants) => self.schemas.variants(variants).iter().any(|it| it.payload.is_some()),
            Shape::List(of) | Shape::Map(of) => self.has_fields(of),
            Shape::Plain => false,
        }
    }

    fn choices(&self, schema: &'a Value) -> Vec<(String, String)> {
        match self.schemas.shape(schema) {
            Shape::Choice(variants) => {
                let all = self.schemas.variants(variants);
                all.into_iter()
                    .map(|it| (format!("{}{}", it.name, if it.payload.is_some() { "(..)" } else { "" }), it.doc))
                    .collect()
            }
            Shape::List(of) | Shape::Map(of) => self.choices(of),
            Shape::Fields(_) | Shape::Plain => Vec::new(),
        }
    }
}

fn text_of(value: &Value) -> Option<String> {
    value.as_str().map(str::to_owned)
}
