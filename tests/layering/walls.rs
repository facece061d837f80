//! The walls between rooms.

use std::collections::BTreeSet;

use crate::imports::imports;
use crate::{FUNCTIONAL, ROOMS, Source, TIMING, sources};

fn allowed(room: &str) -> Option<&'static [&'static str]> {
    ROOMS.iter().find(|(name, _)| *name == room).map(|(_, allowed)| *allowed)
}

/// What a file uses and must not.
fn violations(source: &Source) -> Vec<String> {
    let module = source.module();
    // The library's face lists the rooms; tests may look at a room from anywhere.
    let Some(room) = module.first().filter(|_| !source.is_test()) else { return Vec::new() };
    let Some(allowed) = allowed(room) else {
        return vec![format!("{}: the room `{room}` is not in the list of rooms", source.file)];
    };
    let fits = |path: &Vec<String>| {
        let whole = path.first().map(String::as_str).unwrap_or_default();
        let path = path.join("::");
        let single = |thing: &&str| path == *thing || path.starts_with(&format!("{thing}::"));
        whole == room || allowed.contains(&whole) || allowed.iter().any(single)
    };
    let paths = imports(source, &BTreeSet::new()).into_iter().map(|import| import.path);
    let wrong = paths.filter(|path| !fits(path));
    wrong.map(|path| format!("{}: `{room}` must not use `{}`", source.file, path.join("::"))).collect()
}

#[test]
fn every_file_keeps_to_its_room() {
    let wrong: Vec<String> = sources().iter().flat_map(violations).collect();
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
    let found = |file: &str, text: &str| violations(&Source { file: file.into(), text: text.into() }).join("; ");
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
            "mod tests {\n    use super::super::engine::E;\n}",
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
        ("scene/mod.rs", "mod tests {\n    use super::*;\n    use super::camera::Camera;\n}"),
        ("scene/aff/lexer.rs", "use super::super::fields::Field;"),
        ("report/page.rs", "use crate::stream::Totals;\nuse crate::validate::PixelVerdict::Same;"),
        ("machine/ray.rs", "use crate::machine::layout::{self, Layout};"),
    ] {
        assert_eq!(found(file, source), "", "{source}");
    }
}
