//! What a file imports: `use` trees, and paths in expressions, types, patterns and macros.

use std::collections::{BTreeMap, BTreeSet};

use proc_macro2::{TokenStream, TokenTree};
use syn::visit::{self, Visit};
use syn::{Attribute, ImplItemFn, Item, Macro, Meta, Path, UseTree, Visibility};

use crate::Source;

/// A path that a file names, from the crate's root.
pub struct Import {
    pub path: Vec<String>,
    /// Whether only tests name it.
    pub in_test: bool,
}

/// All paths of the crate that `source` names. `modules` are the paths of the crate's modules: a path may begin with
/// the name of a module beneath the file's own.
pub fn imports(source: &Source, modules: &BTreeSet<Vec<String>>) -> Vec<Import> {
    let parsed = syn::parse_file(&source.text).unwrap_or_else(|error| panic!("{}: {error}", source.file));
    let mut finder = Finder { modules, here: source.module(), aliases: BTreeMap::new(), tests: 0, found: Vec::new() };
    // Twice: names that `use` brings in are known to paths that stand before it, too.
    finder.visit_file(&parsed);
    finder.found.clear();
    finder.visit_file(&parsed);
    finder.found
}

struct Finder<'a> {
    modules: &'a BTreeSet<Vec<String>>,
    /// The module that is being read.
    here: Vec<String>,
    /// Modules that `use` brings in, by their names in the file.
    aliases: BTreeMap<String, Vec<String>>,
    /// How many items around the one that is being read are for tests alone.
    tests: usize,
    found: Vec<Import>,
}

impl Finder<'_> {
    /// The path from the crate's root, if it is one of the crate.
    fn resolve(&self, path: &[String]) -> Option<Vec<String>> {
        let (first, rest) = path.split_first()?;
        let mut base = match first.as_str() {
            "crate" => Vec::new(),
            "self" => self.here.clone(),
            "super" => {
                let supers = path.iter().take_while(|part| *part == "super").count();
                let base = self.here[..self.here.len().checked_sub(supers)?].to_vec();
                return Some([&base, &path[supers..]].concat());
            }
            _ => {
                let child = [&self.here[..], std::slice::from_ref(first)].concat();
                if self.modules.contains(&child) { child } else { self.aliases.get(first)?.clone() }
            }
        };
        base.extend_from_slice(rest);
        Some(base)
    }

    fn add(&mut self, path: &[String]) {
        if path.len() > 1
            && let Some(path) = self.resolve(path)
        {
            self.found.push(Import { path, in_test: self.tests > 0 });
        }
    }

    fn add_tree(&mut self, prefix: &[String], tree: &UseTree) {
        let joined = |name: &syn::Ident| [prefix, &[name.to_string()]].concat();
        let (leaf, name) = match tree {
            UseTree::Path(path) => return self.add_tree(&joined(&path.ident), &path.tree),
            UseTree::Group(group) => return group.items.iter().for_each(|tree| self.add_tree(prefix, tree)),
            UseTree::Glob(_) => (prefix.to_vec(), None),
            UseTree::Name(name) if name.ident == "self" => (prefix.to_vec(), prefix.last().cloned()),
            UseTree::Name(name) => (joined(&name.ident), Some(name.ident.to_string())),
            UseTree::Rename(rename) if rename.ident == "self" => (prefix.to_vec(), Some(rename.rename.to_string())),
            UseTree::Rename(rename) => (joined(&rename.ident), Some(rename.rename.to_string())),
        };
        let Some(path) = self.resolve(&leaf) else { return };
        if let Some(name) = name.filter(|_| self.modules.contains(&path)) {
            self.aliases.insert(name, path.clone());
        }
        self.found.push(Import { path, in_test: self.tests > 0 });
    }

    /// Paths among the tokens of a macro, which have no syntax of their own.
    fn add_tokens(&mut self, tokens: TokenStream) {
        let (mut path, mut colons): (Vec<String>, usize) = (Vec::new(), 0);
        for token in tokens {
            match token {
                TokenTree::Ident(name) => {
                    if colons != 2 {
                        self.add(&std::mem::take(&mut path));
                    }
                    path.push(name.to_string());
                    colons = 0;
                }
                TokenTree::Punct(punct) if punct.as_char() == ':' => colons += 1,
                TokenTree::Group(group) => {
                    self.add(&std::mem::take(&mut path));
                    self.add_tokens(group.stream());
                }
                _ => self.add(&std::mem::take(&mut path)),
            }
        }
        self.add(&path);
    }

    /// Reads with `read` what stands under `attributes`.
    fn under(&mut self, attributes: &[Attribute], read: impl FnOnce(&mut Self)) {
        let test = usize::from(attributes.iter().any(is_for_tests));
        self.tests += test;
        read(self);
        self.tests -= test;
    }
}

/// Whether an attribute is `#[cfg(test)]` or `#[test]`.
fn is_for_tests(attribute: &Attribute) -> bool {
    let names_test = |meta: &syn::MetaList| meta.tokens.clone().into_iter().any(|token| token.to_string() == "test");
    attribute.path().is_ident("test")
        || attribute.path().is_ident("cfg") && matches!(&attribute.meta, Meta::List(list) if names_test(list))
}

impl<'ast> Visit<'ast> for Finder<'_> {
    fn visit_item(&mut self, item: &'ast Item) {
        let attributes: &[Attribute] = match item {
            Item::Mod(item) => &item.attrs,
            Item::Fn(item) => &item.attrs,
            Item::Impl(item) => &item.attrs,
            Item::Use(item) => &item.attrs,
            Item::Struct(item) => &item.attrs,
            Item::Enum(item) => &item.attrs,
            Item::Const(item) => &item.attrs,
            _ => &[],
        };
        self.under(attributes, |finder| match item {
            Item::Use(item) => finder.add_tree(&[], &item.tree),
            Item::Mod(item) => {
                finder.here.push(item.ident.to_string());
                visit::visit_item_mod(finder, item);
                finder.here.pop();
            }
            _ => visit::visit_item(finder, item),
        });
    }

    fn visit_impl_item_fn(&mut self, method: &'ast ImplItemFn) {
        self.under(&method.attrs, |finder| visit::visit_impl_item_fn(finder, method));
    }

    fn visit_path(&mut self, path: &'ast Path) {
        let names: Vec<String> = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        self.add(&names);
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, used: &'ast Macro) {
        self.visit_path(&used.path);
        self.add_tokens(used.tokens.clone());
    }

    // `pub(in super)` names no import.
    fn visit_visibility(&mut self, _: &'ast Visibility) {}
}
