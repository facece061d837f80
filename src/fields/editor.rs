//! Makes schemas for editors: the files that ron2's language server reads.
//!
//! A file describes one type. ron2 has neither ranges nor a type for alternatives. So a size (a number or text) and a
//! part that may also be the name of a file refer to a type that no file describes, which accepts any value.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::{Map, Value};

use super::root::Root;
use super::schema::{Schemas, Shape, allows, paragraphs};

/// The package of all types, as `#![type = "umbrasim::Machine"]` names them.
const PACKAGE: &str = "umbrasim";

/// ron2's description of a type.
#[derive(Serialize)]
struct Schema {
    #[serde(skip_serializing_if = "Option::is_none")]
    doc: Option<String>,
    kind: TypeKind,
}

#[derive(Serialize)]
enum TypeKind {
    Bool,
    U64,
    F64,
    String,
    List(Box<TypeKind>),
    Map { key: Box<TypeKind>, value: Box<TypeKind> },
    Tuple(Vec<TypeKind>),
    Struct { fields: Vec<Field> },
    Enum { variants: Vec<Variant> },
    TypeRef(String),
}

#[derive(Serialize)]
struct Field {
    name: String,
    ty: TypeKind,
    #[serde(skip_serializing_if = "Option::is_none")]
    doc: Option<String>,
    optional: bool,
}

#[derive(Serialize)]
struct Variant {
    name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    doc: Option<String>,
    kind: VariantKind,
}

#[derive(Serialize)]
enum VariantKind {
    Unit,
    Tuple(Vec<TypeKind>),
    Struct(Vec<Field>),
}

/// The schema files by their paths in the folder of schemas.
pub(crate) fn schemas() -> BTreeMap<String, String> {
    let mut files = BTreeMap::new();
    for root in Root::ALL {
        let schema = root.schema();
        let schemas = Schemas::new(&schema);
        let mut add = |name: &str, of: &Value| {
            let described = Schema { doc: doc(of), kind: described(schemas, of) };
            let style = ron::ser::PrettyConfig::new().indentor("  ");
            let text =
                ron::ser::to_string_pretty(&described, style).expect("a schema is plain data, which RON can hold");
            files.insert(format!("{PACKAGE}/{name}.schema.ron"), text + "\n");
        };
        add(root.type_name(), &schema);
        for (name, of) in schema["$defs"].as_object().into_iter().flatten() {
            add(name, of);
        }
    }
    files
}

fn doc(schema: &Value) -> Option<String> {
    let (meaning, source) = paragraphs(schema);
    let source = source.map(|source| format!(" Source: {source}")).unwrap_or_default();
    (!meaning.is_empty()).then(|| format!("{meaning}{source}"))
}

/// A type by its name if it has one, else by its structure. `Option` does not show in files.
fn named(schemas: Schemas<'_>, schema: &Value) -> TypeKind {
    let reference = |schema: &Value| Some(schema["$ref"].as_str()?.strip_prefix("#/$defs/")?.to_owned());
    let present = |one: &&Value| one["type"] != "null";
    match schema["anyOf"].as_array() {
        Some(either) if either.iter().filter(present).count() == 1 => {
            either.iter().find(present).map_or_else(any, |one| named(schemas, one))
        }
        _ => match reference(schema) {
            Some(name) => TypeKind::TypeRef(format!("{PACKAGE}::{name}")),
            None => described(schemas, schema),
        },
    }
}

/// The type of any value.
fn any() -> TypeKind {
    TypeKind::TypeRef(format!("{PACKAGE}::Any"))
}

/// The structure of a type.
fn described(schemas: Schemas<'_>, schema: &Value) -> TypeKind {
    if schema["anyOf"].is_array() {
        return any();
    }
    match schemas.shape(schema) {
        Shape::Fields(fields) => TypeKind::Struct { fields: of_struct(schemas, schema, fields) },
        Shape::Choice(variants) => {
            let variant = |it: super::schema::Variant<'_>| Variant {
                name: it.name.into(),
                doc: Some(it.doc).filter(|doc| !doc.is_empty()),
                kind: it.payload.map_or(VariantKind::Unit, |payload| of_variant(schemas, payload)),
            };
            TypeKind::Enum { variants: schemas.variants(variants).into_iter().map(variant).collect() }
        }
        Shape::Map(of) => TypeKind::Map { key: Box::new(TypeKind::String), value: Box::new(named(schemas, of)) },
        Shape::List(of) => match schema["maxItems"].as_u64() {
            Some(count) => TypeKind::Tuple((0..count).map(|_| named(schemas, of)).collect()),
            None => TypeKind::List(Box::new(named(schemas, of))),
        },
        Shape::Plain => plain(schema),
    }
}

/// A variant's payload; files leave out the brackets of the payload's own type.
fn of_variant(schemas: Schemas<'_>, payload: &Value) -> VariantKind {
    match schemas.shape(payload) {
        Shape::Fields(fields) if !schemas.resolve(payload)["anyOf"].is_array() => {
            VariantKind::Struct(of_struct(schemas, payload, fields))
        }
        _ if payload["prefixItems"].is_array() => {
            let all = payload["prefixItems"].as_array().into_iter().flatten();
            VariantKind::Tuple(all.map(|of| named(schemas, of)).collect())
        }
        _ => VariantKind::Tuple(vec![named(schemas, payload)]),
    }
}

fn of_struct(schemas: Schemas<'_>, schema: &Value, fields: &Map<String, Value>) -> Vec<Field> {
    let required = schemas.resolve(schema)["required"].as_array();
    let field = |(name, of): (&String, &Value)| Field {
        name: name.clone(),
        ty: if may_be_named(of) { any() } else { named(schemas, of) },
        doc: doc(of),
        optional: !required.is_some_and(|all| all.iter().any(|it| it == name)),
    };
    fields.iter().map(field).collect()
}

/// Whether a field may have the name of a file in place of values.
fn may_be_named(schema: &Value) -> bool {
    schema["or_file"] == true
}

fn plain(schema: &Value) -> TypeKind {
    match (allows(schema, "string"), allows(schema, "integer"), allows(schema, "number")) {
        (true, true, _) => any(),
        (true, ..) => TypeKind::String,
        (_, true, _) => TypeKind::U64,
        (.., true) => TypeKind::F64,
        _ if allows(schema, "boolean") => TypeKind::Bool,
        _ => any(),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use ron2::Value;
    use ron2::schema::validation::StorageResolver;
    use ron2::schema::{read_schema, validate_with_resolver};

    use super::*;

    #[test]
    fn ron2_reads_the_schemas_and_finds_shipped_configs_right() {
        let folder = tempfile::tempdir().unwrap();
        for (path, text) in schemas() {
            let path = folder.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(&path, text).unwrap();
            read_schema(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        }
        let resolver = StorageResolver::with_search_dir(folder.path().to_path_buf());
        let check = |type_name: &str, text: &str| {
            let schema = read_schema(&folder.path().join(format!("umbrasim/{type_name}.schema.ron"))).unwrap();
            let value: Value = text.parse().unwrap_or_else(|error| panic!("{text}: {error}"));
            validate_with_resolver(&value, &schema, &resolver).map_err(|error| error.to_string())
        };
        for (kind, of) in [("machines", "Machine"), ("dram", "DramPart"), ("scenes", "Scene")] {
            let configs = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs").join(kind);
            for file in std::fs::read_dir(configs).unwrap() {
                let path = file.unwrap().path();
                let text = std::fs::read_to_string(&path).unwrap();
                check(of, &text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
            }
        }
        assert!(check("Machine", "(traversal: (cout: 3))").unwrap_err().contains("cout"));
        assert!(check("Machine", "(shadow_cache: (place: Onw))").is_err());
    }
}
