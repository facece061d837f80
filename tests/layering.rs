//! The rooms of the house: each uses only rooms below it, and the functional and the timing wing never see each other.

use std::fs;
use std::path::Path;

/// Rooms from the ground up, each with what it may use: whole rooms, or single things of them. New rooms go in here.
const ROOMS: &[(&str, &[&str])] = &[
    // Common ground.
    ("quantity", &[]),
    ("ranged", &[]),
    ("named", &[]),
    ("new_file", &[]),
    ("ron_file", &["ranged"]),
    ("counters", &[]),
    ("stats", &["quantity", "counters"]),
    ("stream", &["quantity", "new_file", "counters"]),
    // The functional wing.
    ("scene", &["quantity", "ranged"]),
    ("reference", &["quantity", "scene"]),
    ("accel", &["quantity", "ranged", "stream", "scene"]),
    ("culling", &["quantity", "ranged", "stream", "scene", "accel"]),
    ("tracer", &["quantity", "stream", "scene", "accel", "culling"]),
    // The timing wing.
    ("memory", &["quantity", "ranged", "named", "ron_file", "stats"]),
    ("machine", &["quantity", "ranged", "ron_file", "stats", "stream", "memory"]),
    ("engine", &["quantity", "ranged", "counters", "stats", "stream", "memory", "machine"]),
    // Above both.
    ("validate", &["quantity", "scene"]),
    ("report", &["quantity", "named", "new_file", "counters", "stats", "stream::Totals", "validate::PixelVerdict"]),
    (
        "experiment",
        &[
            "quantity",
            "ranged",
            "named",
            "new_file",
            "ron_file",
            "stats",
            "stream",
            "scene",
            "reference",
            "accel",
            "culling",
            "tracer",
            "memory",
            "machine",
            "engine",
            "validate",
            "report",
        ],
    ),
];

const FUNCTIONAL: [&str; 5] = ["scene", "reference", "accel", "culling", "tracer"];
const TIMING: [&str; 3] = ["memory", "machine", "engine"];

fn allowed(room: &str) -> Option<&'static [&'static str]> {
    ROOMS.iter().find(|(name, _)| *name == room).map(|(_, allowed)| *allowed)
}

/// Paths from the crate's root that `source` names, such as `stream::Totals`; `file` is its path in `src`.
fn used(file: &Path, source: &str) -> Vec<String> {
    // `super` once from `room/mod.rs` and `room.rs` is the root, twice from `room/file.rs` and `room/part/mod.rs`; a module
    // within a file, which is indented, is one deeper.
    let depth = file.components().count() - usize::from(file.ends_with("mod.rs"));
    let code: Vec<&str> = source.lines().filter(|line| !line.trim_start().starts_with("//")).collect();
    let code = code.join("\n");
    let mut found = Vec::new();
    for (at, _) in code.match_indices("crate::") {
        tree("", &code[at + "crate::".len()..], &mut found);
    }
    for (at, _) in code.match_indices("super::") {
        let line = code[..at].rfind('\n').map_or(0, |end| end + 1);
        let inner = usize::from(code[line..].starts_with(' '));
        let before = &code[line..at];
        let supers = 1 + (before.len() - before.trim_end_matches("super::").len()) / "super::".len();
        if supers == depth + inner && !code[at + "super::".len()..].starts_with("super") {
            tree("", &code[at + "super::".len()..], &mut found);
        }
    }
    found
}

/// Adds the paths of a use tree such as `a::{b, c::d}`; gives what stands behind it.
fn tree<'a>(prefix: &str, text: &'a str, found: &mut Vec<String>) -> &'a str {
    let mut text = text.trim_start();
    if let Some(mut list) = text.strip_prefix('{') {
        loop {
            list = list.trim_start_matches(|letter: char| letter.is_whitespace() || letter == ',');
            match list.strip_prefix('}') {
                Some(rest) => return rest,
                None if list.is_empty() => return list,
                None => list = tree(prefix, list, found),
            }
        }
    }
    let name =
        text.find(|letter: char| !letter.is_alphanumeric() && letter != '_' && letter != '*').unwrap_or(text.len());
    let path = if prefix.is_empty() { text[..name].to_owned() } else { format!("{prefix}::{}", &text[..name]) };
    text = &text[name..];
    match text.strip_prefix("::") {
        Some(rest) if name > 0 => tree(&path, rest, found),
        _ => {
            found.push(path);
            // `name as other` ends at the next comma or bracket.
            let end = text.find([',', '}', ';']).unwrap_or(text.len());
            &text[end..]
        }
    }
}

/// What a file uses and must not.
fn violations(file: &Path, source: &str) -> Vec<String> {
    let first = file.components().next().unwrap().as_os_str().to_str().unwrap();
    let room = first.trim_end_matches(".rs");
    // The library's list of rooms, and the program above them all; tests may look at a room from anywhere.
    let is_test = file.components().any(|part| part.as_os_str() == "tests" || part.as_os_str() == "tests.rs");
    if is_test || ["lib", "main", "cli"].contains(&room) {
        return Vec::new();
    }
    let Some(allowed) = allowed(room) else {
        return vec![format!("{}: the room `{room}` is not in the list of rooms", file.display())];
    };
    let fits = |path: &String| {
        let whole = path.split("::").next().unwrap_or_default();
        let single = |thing: &&str| path == thing || path.starts_with(&format!("{thing}::"));
        whole == room || allowed.contains(&whole) || allowed.iter().any(single)
    };
    let wrong = used(file, source).into_iter().filter(|path| !fits(path));
    wrong.map(|path| format!("{}: `{room}` must not use `{path}`", file.display())).collect()
}

fn walk(folder: &Path, src: &Path, wrong: &mut Vec<String>, files: &mut usize) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            walk(&path, src, wrong, files);
        } else if path.extension().is_some_and(|kind| kind == "rs") {
            *files += 1;
            let source = fs::read_to_string(&path).unwrap();
            wrong.extend(violations(path.strip_prefix(src).unwrap(), &source));
        }
    }
}

#[test]
fn every_file_keeps_to_its_room() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let (mut wrong, mut files) = (Vec::new(), 0);
    walk(&src, &src, &mut wrong, &mut files);
    assert!(files > 50, "only {files} files were found");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_list_of_rooms_is_a_house() {
    for (at, (room, uses)) in ROOMS.iter().enumerate() {
        for used in *uses {
            let used = used.split("::").next().unwrap();
            assert!(ROOMS[..at].iter().any(|(below, _)| *below == used), "{room} uses {used}, which is not below it");
            let crossed = |one: &[&str], other: &[&str]| one.contains(room) && other.contains(&used);
            assert!(!crossed(&FUNCTIONAL, &TIMING) && !crossed(&TIMING, &FUNCTIONAL), "{room} uses {used}: the wall");
        }
    }
}

#[test]
fn planted_violations_are_found() {
    let found = |file: &str, source: &str| violations(Path::new(file), source).join("; ");
    for (file, source, expected) in [
        (
            "culling/off.rs",
            "use crate::memory::cache::Cache;",
            "culling/off.rs: `culling` must not use `memory::cache::Cache`",
        ),
        ("memory/mod.rs", "use crate::stream::Ray;", "memory/mod.rs: `memory` must not use `stream::Ray`"),
        (
            "engine/mod.rs",
            "use crate::{\n    quantity::Cycle,\n    tracer::{Tracer, TracerSpec as Spec},\n};",
            "engine/mod.rs: `engine` must not use `tracer::Tracer`; engine/mod.rs: `engine` must not use `tracer::TracerSpec`",
        ),
        (
            "reference/bvh.rs",
            "fn f(node: crate::accel::Node) {}",
            "reference/bvh.rs: `reference` must not use `accel::Node`",
        ),
        (
            "report/page.rs",
            "use crate::stream::{Header, Totals};",
            "report/page.rs: `report` must not use `stream::Header`",
        ),
        ("stats.rs", "use super::report::Report;", "stats.rs: `stats` must not use `report::Report`"),
        ("scene/mod.rs", "use super::experiment;", "scene/mod.rs: `scene` must not use `experiment`"),
        ("scene/camera.rs", "use super::super::tracer::T;", "scene/camera.rs: `scene` must not use `tracer::T`"),
        (
            "scene/mod.rs",
            "mod tests {\n    use super::super::engine::E;",
            "scene/mod.rs: `scene` must not use `engine::E`",
        ),
        (
            "scene/aff/lexer.rs",
            "use super::super::super::machine::M;",
            "scene/aff/lexer.rs: `scene` must not use `machine::M`",
        ),
        ("attic/mod.rs", "", "attic/mod.rs: the room `attic` is not in the list of rooms"),
    ] {
        assert_eq!(found(file, source), expected, "{source}");
    }
    for (file, source) in [
        ("validate.rs", "//! As the [reference renderer](crate::reference) does.\nuse crate::scene::Picture;"),
        ("scene/mod.rs", "mod tests {\n    use super::*;\n    use super::camera::Camera;"),
        ("scene/aff/lexer.rs", "use super::super::fields::Field;"),
        ("report/page.rs", "use crate::stream::Totals;\nuse crate::validate::PixelVerdict::Same;"),
        ("machine/ray.rs", "use crate::machine::layout::{self, Layout};"),
    ] {
        assert_eq!(found(file, source), "", "{source}");
    }
}
