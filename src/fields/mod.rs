//! The fields of all config files, in one table derived from the specs: types, ranges, defaults and doc comments come
//! from their JSON schemas. `describe`, the book's page of fields and the schemas for editors are views of the table.

mod book;
mod describe;
mod editor;
mod kind_of;
mod root;
mod schema;
mod table;
mod text;

pub(crate) use book::page;
pub(crate) use describe::{Description, describe};
pub(crate) use editor::schemas;
pub(crate) use kind_of::kind_of;
pub(crate) use root::Root;
pub(crate) use table::{Field, fields};
