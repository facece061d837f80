//! The rooms of the house: each uses only rooms below it, the functional and the timing wing never see each other, and
//! neither files nor folders import each other in a circle. Files are parsed with [`syn::parse_file`].

#[path = "layering/circles.rs"]
mod circles;
#[path = "layering/imports.rs"]
mod imports;
#[path = "layering/walls.rs"]
mod walls;

use std::fs;
use std::path::Path;

/// Rooms from the ground up, each with what it may use: whole rooms, or single things of them. New rooms go in here.
const ROOMS: &[(&str, &[&str])] = &[
    // Common ground.
    ("quantity", &[]),
    ("alike", &[]),
    ("console", &[]),
    ("size", &[]),
    ("random", &[]),
    ("ranged", &["size"]),
    ("named", &[]),
    ("output", &[]),
    ("input", &["output"]),
    ("json", &[]),
    ("shipped", &[]),
    ("ron_file", &["alike", "ranged", "input", "shipped"]),
    ("counters", &[]),
    ("spread", &[]),
    ("student", &[]),
    ("surrogate", &["random", "student"]),
    ("stats", &["quantity", "counters", "student"]),
    ("stream", &["quantity", "output", "input", "json", "counters"]),
    // The functional wing.
    ("scene", &["quantity", "random", "ranged", "input"]),
    ("reference", &["quantity", "scene"]),
    ("accel", &["quantity", "ranged", "stream", "scene"]),
    ("culling", &["quantity", "random", "ranged", "stream", "scene", "accel"]),
    ("tracer", &["quantity", "stream", "scene", "accel", "culling"]),
    // The timing wing.
    ("memory", &["quantity", "random", "ranged", "named", "ron_file", "spread", "stats"]),
    ("machine", &["quantity", "ranged", "ron_file", "spread", "stats", "stream", "memory"]),
    ("energy", &["spread", "stats", "stream::Structure", "memory", "machine"]),
    ("engine", &["quantity", "ranged", "counters", "stats", "stream", "memory", "machine", "energy"]),
    (
        "sampling",
        &["quantity", "random", "ranged", "stats", "stream", "memory", "machine", "energy", "engine", "student"],
    ),
    (
        "replay",
        &[
            "alike", "quantity", "random", "ranged", "stats", "stream", "memory", "machine", "energy", "engine",
            "sampling",
        ],
    ),
    // Above both.
    ("validate", &["quantity", "scene"]),
    (
        "report",
        &[
            "size",
            "quantity",
            "named",
            "output",
            "input",
            "json",
            "counters",
            "stats",
            "student",
            "stream::Totals",
            "validate::PixelVerdict",
        ],
    ),
    (
        "experiment",
        &[
            "alike",
            "console",
            "quantity",
            "ranged",
            "named",
            "output",
            "input",
            "json",
            "ron_file",
            "shipped",
            "stats",
            "stream",
            "scene",
            "reference",
            "accel",
            "culling",
            "tracer",
            "memory",
            "machine",
            "replay",
            "size",
            "surrogate",
            "validate",
            "report",
        ],
    ),
    ("fields", &["alike", "size", "ron_file", "memory", "machine", "scene", "experiment"]),
    (
        "cli",
        &[
            "alike",
            "console",
            "quantity",
            "json",
            "shipped",
            "output",
            "ron_file",
            "stream",
            "machine",
            "named",
            "replay",
            "report",
            "experiment",
            "fields",
        ],
    ),
];

const FUNCTIONAL: [&str; 5] = ["scene", "reference", "accel", "culling", "tracer"];
const TIMING: [&str; 6] = ["memory", "machine", "energy", "engine", "sampling", "replay"];

/// A file of the library: its path in `src`, with `/`, and its text.
struct Source {
    file: String,
    text: String,
}

impl Source {
    /// Whether the file holds tests alone, which may look at anything.
    fn is_test(&self) -> bool {
        self.file.split('/').any(|part| part == "tests" || part == "tests.rs")
    }

    /// The path of the file's module, such as `["scene", "aff"]`; the crate's root is empty.
    fn module(&self) -> Vec<String> {
        let path = self.file.trim_end_matches(".rs");
        let path = path.strip_suffix("/mod").unwrap_or(if path == "lib" { "" } else { path });
        path.split('/').filter(|part| !part.is_empty()).map(str::to_owned).collect()
    }
}

/// All files of the library, in order of their paths. The program's `main.rs` is none of them.
fn sources() -> Vec<Source> {
    fn walk(folder: &Path, src: &Path, found: &mut Vec<Source>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(&path, src, found);
            } else if path.extension().is_some_and(|kind| kind == "rs") {
                let parts: Vec<_> = path.strip_prefix(src).unwrap().iter().map(|part| part.to_str().unwrap()).collect();
                found.push(Source { file: parts.join("/"), text: fs::read_to_string(&path).unwrap() });
            }
        }
    }
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = Vec::new();
    walk(&src, &src, &mut found);
    found.retain(|source| source.file != "main.rs");
    found.sort_by(|a, b| a.file.cmp(&b.file));
    assert!(found.len() > 50, "only {} files were found", found.len());
    found
}

/// Only `input` and `output` open files: so every read refuses outputs of the same command, pipes and huge files.
#[test]
fn files_are_read_in_one_place() {
    // Tests of the book's commands.
    const TESTS: &str = "cli/book.rs";
    let opens = |text: &str| {
        let own = text.split("mod tests {").next().unwrap_or_default();
        ["fs::read(", "fs::read_to_string(", "File::open("].iter().any(|call| own.contains(call))
    };
    assert!(opens("#[cfg(test)]\nuse x;\nlet text = std::fs::read(path);"), "the test finds what it looks for");
    for source in sources().iter().filter(|source| !source.is_test() && source.file != TESTS) {
        let may = source.file == "input.rs" || source.file.starts_with("output/");
        assert!(may || !opens(&source.text), "{} opens files by itself", source.file);
    }
}
