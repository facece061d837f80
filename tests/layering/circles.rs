//! No circles: in each folder, files and folders import each other in one direction only. `mod.rs` is a file like the
//! others: one that its folder's files import, and that imports them, closes a circle.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use crate::imports::imports;
use crate::{Source, sources};

/// Who imports what from whom: the importing file, the path, and the file that holds it.
struct Tie {
    from: String,
    path: String,
    to: String,
}

/// The imports of `sources` from each other, without those of tests.
fn ties(sources: &[Source]) -> Vec<Tie> {
    let files: BTreeMap<Vec<String>, &str> =
        sources.iter().map(|source| (source.module(), source.file.as_str())).collect();
    let modules: BTreeSet<Vec<String>> = files.keys().cloned().collect();
    let mut ties = Vec::new();
    for source in sources.iter().filter(|source| !source.is_test()) {
        for import in imports(source, &modules).into_iter().filter(|import| !import.in_test) {
            let holder = (0..=import.path.len()).rev().find_map(|end| files.get(&import.path[..end]));
            if let Some(to) = holder.filter(|to| **to != source.file) {
                ties.push(Tie { from: source.file.clone(), path: import.path.join("::"), to: (*to).into() });
            }
        }
    }
    ties
}

/// The circles of one folder: its entries (files, and folders as wholes) that reach each other, with the shortest way
/// round, told file by file.
struct Circle {
    folder: String,
    entries: BTreeSet<String>,
    way: String,
}

/// All circles among `sources`.
fn circles(sources: &[Source]) -> Vec<Circle> {
    let ties = ties(sources);
    let folders =
        |file: &str| -> Vec<String> { file.match_indices('/').map(|(at, _)| file[..=at].to_owned()).collect() };
    let mut all: BTreeSet<String> = sources.iter().flat_map(|source| folders(&source.file)).collect();
    all.insert(String::new());
    let mut found = Vec::new();
    for folder in all {
        // The folder's entry that `file` is in, if it is in one.
        let entry = |file: &str| -> Option<String> {
            let rest = file.strip_prefix(&folder)?;
            Some(rest.split_inclusive('/').next()?.to_owned())
        };
        let mut edges: BTreeMap<String, BTreeMap<String, &Tie>> = BTreeMap::new();
        for tie in &ties {
            if let (Some(from), Some(to)) = (entry(&tie.from), entry(&tie.to))
                && from != to
            {
                edges.entry(from).or_default().entry(to).or_insert(tie);
            }
        }
        let mut seen: BTreeSet<String> = BTreeSet::new();
        for start in edges.keys() {
            if seen.contains(start) {
                continue;
            }
            let Some(way) = way_back(start, &edges) else { continue };
            let reached = reachable(start, &edges);
            let entries: BTreeSet<String> =
                reached.into_iter().filter(|other| reachable(other, &edges).contains(start)).collect();
            seen.extend(entries.iter().cloned());
            let told: Vec<String> =
                way.iter().map(|tie| format!("    {} imports `{}` from {}", tie.from, tie.path, tie.to)).collect();
            found.push(Circle { folder: folder.clone(), entries, way: told.join("\n") });
        }
    }
    found
}

type Edges<'a> = BTreeMap<String, BTreeMap<String, &'a Tie>>;

/// Everything that `start` imports, itself or through others.
fn reachable(start: &str, edges: &Edges) -> BTreeSet<String> {
    let (mut reached, mut open) = (BTreeSet::new(), vec![start.to_owned()]);
    while let Some(entry) = open.pop() {
        for next in edges.get(&entry).into_iter().flat_map(BTreeMap::keys) {
            if reached.insert(next.clone()) {
                open.push(next.clone());
            }
        }
    }
    reached
}

/// The shortest chain of imports from `start` back to `start`.
fn way_back<'a>(start: &str, edges: &Edges<'a>) -> Option<Vec<&'a Tie>> {
    let mut ways: BTreeMap<&str, Vec<&Tie>> = BTreeMap::new();
    let mut open = VecDeque::from([start]);
    while let Some(entry) = open.pop_front() {
        let way = ways.get(entry).cloned().unwrap_or_default();
        for (next, tie) in edges.get(entry).into_iter().flatten() {
            let longer = [&way[..], &[*tie]].concat();
            if next == start {
                return Some(longer);
            }
            if !ways.contains_key(next.as_str()) {
                ways.insert(next, longer);
                open.push_back(next);
            }
        }
    }
    None
}

/// Circles as text.
fn told(circles: &[Circle]) -> String {
    let tell = |circle: &Circle| {
        let entries: Vec<&str> = circle.entries.iter().map(String::as_str).collect();
        format!("src/{}: a circle of {}\n{}", circle.folder, entries.join(", "), circle.way)
    };
    circles.iter().map(tell).collect::<Vec<_>>().join("\n")
}

#[test]
fn no_file_and_no_folder_imports_itself_through_others() {
    let told = told(&circles(&sources()));
    assert!(told.is_empty(), "\n{told}\n");
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(files: &[(&str, &str)]) -> String {
        let source = |(file, text): &(&str, &str)| Source { file: (*file).into(), text: (*text).into() };
        told(&circles(&files.iter().map(source).collect::<Vec<_>>()))
    }

    #[test]
    fn planted_circles_are_found() {
        for (files, expected) in [
            // Two files.
            (
                vec![
                    ("a/mod.rs", "mod x; mod y;"),
                    ("a/x.rs", "use super::y::Y;"),
                    ("a/y.rs", "type X = super::x::X;"),
                ],
                "src/a/: a circle of x.rs, y.rs\n    \
                 a/x.rs imports `a::y::Y` from a/y.rs\n    a/y.rs imports `a::x::X` from a/x.rs",
            ),
            // A facade that a file of its folder imports, by its short name and in a macro.
            (
                vec![
                    ("a/mod.rs", "mod x; pub use x::X;"),
                    ("a/x.rs", "use crate::a; fn f() { println!(\"{}\", a::NUMBER) }"),
                ],
                "src/a/: a circle of mod.rs, x.rs\n    \
                 a/mod.rs imports `a::x::X` from a/x.rs\n    a/x.rs imports `a` from a/mod.rs",
            ),
            // Two folders without a circle of files.
            (
                vec![
                    ("a/x.rs", "fn f() { crate::b::x::g() }"),
                    ("a/y.rs", ""),
                    ("b/x.rs", ""),
                    ("b/y.rs", "use super::super::a::{y::Y};"),
                ],
                "src/: a circle of a/, b/\n    \
                 a/x.rs imports `b::x::g` from b/x.rs\n    b/y.rs imports `a::y::Y` from a/y.rs",
            ),
            // Three files in a ring, one tie of it in the body of a macro, one to a glob.
            (
                vec![
                    ("a.rs", "use crate::b::*;"),
                    ("b.rs", "macro_rules! m { () => { $crate::c::f() } }"),
                    ("c.rs", "use crate::a::A as Other;"),
                    ("d.rs", "use crate::a::A;"),
                ],
                "src/: a circle of a.rs, b.rs, c.rs\n    a.rs imports `b` from b.rs\n    \
                 b.rs imports `c::f` from c.rs\n    c.rs imports `a::A` from a.rs",
            ),
            // The library's face, imported from within.
            (
                vec![("lib.rs", "mod a; pub use a::A;"), ("a.rs", "use crate::A as Face;")],
                "src/: a circle of a.rs, lib.rs\n    a.rs imports `A` from lib.rs\n    lib.rs imports `a::A` from a.rs",
            ),
        ] {
            assert_eq!(found(&files), expected, "{files:?}");
        }
    }

    #[test]
    fn what_is_no_circle_is_left_alone() {
        let tests = "#[cfg(test)]\nmod tests { use crate::b::B; use super::A; }\npub(in crate::a) struct A;";
        assert_eq!(found(&[("a.rs", tests), ("b.rs", "use crate::a::A;\nuse serde::a::Z;")]), "");
        // A folder's common ground may stand in its `mod.rs`, if that imports none of the files.
        assert_eq!(found(&[("a/mod.rs", "mod x; pub struct A;"), ("a/x.rs", "use super::A;")]), "");
    }
}
