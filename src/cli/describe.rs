//! `describe`: the fields of config files.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

use super::outcome::Outcome;
use super::print::print;
use super::text_file::write_new;
use crate::fields::{self, Description, Field, Root};
use crate::report::{definitions, paragraph};

/// Say what a field of a config means: unit, range, default, source
///
/// A path names the kind of file first: experiment, machine, scene, sweep, dram, pareto, identities or paper_table.
/// Leave out names that you chose, and places in lists.
#[derive(Args)]
pub(super) struct Describe {
    /// A field, or one that has fields [default: the kinds of files] [example: machine.traversal.cache.bytes]
    path: Option<String>,
    /// Write the book's page of all fields to this file, in Markdown
    #[arg(long, value_name = "FILE", conflicts_with = "path")]
    book: Option<PathBuf>,
}

impl Describe {
    pub(super) fn run(self) -> Result<Outcome> {
        if let Some(book) = self.book {
            write_new(&book, &fields::page())?;
            return Ok(Outcome::Done);
        }
        let text = match self.path {
            None => kinds(),
            Some(path) => match fields::describe(&path).map_err(anyhow::Error::msg)? {
                Description::One(field) => one(&field),
                Description::Group(field, children) => group(&field, &children),
            },
        };
        print(text)?;
        Ok(Outcome::Done)
    }
}

fn kinds() -> String {
    let rows = Root::ALL.map(|root| {
        let meaning = fields::fields(root).into_iter().next().map(|field| field.meaning);
        (root.name().to_owned(), meaning.unwrap_or_default())
    });
    format!("Kinds of files; `umbrasim describe KIND` tells their fields.\n\n{}", definitions(&rows))
}

fn one(field: &Field) -> String {
    let mut rows = vec![("meaning", field.meaning.clone()), ("type", field.kind.clone())];
    rows.extend(field.unit.clone().map(|unit| ("unit", unit)));
    rows.extend(field.range.clone().map(|range| ("range", range)));
    rows.push(("default", field.default.clone().unwrap_or_else(|| "none: the field is required".into())));
    rows.extend(field.source.clone().map(|source| ("source", source)));
    let rows: Vec<_> = rows.into_iter().map(|(name, text)| (name.to_owned(), text)).collect();
    [field.path.clone(), definitions(&rows)].into_iter().chain(choices(field)).collect::<Vec<_>>().join("\n\n")
}

fn group(field: &Field, children: &[Field]) -> String {
    let source = field.source.as_ref().map(|source| format!("\nSource: {source}")).unwrap_or_default();
    let inside = |child: &Field| if child.has_fields { " >" } else { "" };
    let rows: Vec<_> = children
        .iter()
        .map(|child| (format!("{}{}", child.name(), inside(child)), format!("{}\n{}", child.meaning, child.facts())))
        .collect();
    let more = children.iter().find(|child| child.has_fields);
    let more = more.map(|child| format!("> has fields of its own: umbrasim describe {}", child.path));
    let head = paragraph(&format!("{}: {}{source}", field.path, field.meaning));
    let units = choices(field).filter(|_| children.len() < field.choices.len());
    let parts = [head, definitions(&rows)];
    parts.into_iter().chain(units).chain(more).collect::<Vec<_>>().join("\n\n")
}

fn choices(field: &Field) -> Option<String> {
    (!field.choices.is_empty()).then(|| format!("choices\n{}", definitions(&field.choices)))
}
