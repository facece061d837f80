//! No comment and no prose is wider than 120 characters.

use std::fs;
use std::path::{Path, PathBuf};

const MOST: usize = 120;

/// Files with one of these endings below a folder, sorted.
fn files(folder: &Path, endings: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display())) {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path, endings));
        } else if endings.iter().any(|ending| path.extension().is_some_and(|it| it == *ending)) {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The lines of a page that are text: not a block of code or of output, a table or a heading.
fn prose(page: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut in_block = false;
    page.lines().enumerate().filter(move |(_, line)| {
        let is_fence = line.trim_start().starts_with("```");
        in_block ^= is_fence;
        !in_block && !is_fence && !line.starts_with("    ") && !line.trim_start().starts_with(['|', '#', '!'])
    })
}

fn too_wide<'a>(file: &Path, lines: impl Iterator<Item = (usize, &'a str)>) -> Vec<String> {
    let wide = lines.filter(|(_, line)| line.chars().count() > MOST && !line.contains("http"));
    wide.map(|(at, line)| format!("{}:{}: {line}", file.display(), at + 1)).collect()
}

#[test]
fn no_comment_and_no_prose_is_too_wide() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut wide = Vec::new();
    for folder in ["src", "tests", "benches", "examples", "configs"] {
        for file in files(&root.join(folder), &["rs", "ron"]) {
            let text = fs::read_to_string(&file).unwrap();
            let comments = text.lines().enumerate().filter(|(_, line)| line.trim_start().starts_with("//"));
            wide.extend(too_wide(&file, comments));
        }
    }
    let mut pages = files(&root.join("docs"), &["md"]);
    pages.extend(["README.md", "MODEL.md", "CHANGELOG.md"].map(|name| root.join(name)));
    for page in pages {
        wide.extend(too_wide(&page, prose(&fs::read_to_string(&page).unwrap())));
    }
    assert!(wide.is_empty(), "over {MOST} characters:\n{}", wide.join("\n"));
}

#[test]
fn tables_and_code_may_be_wide_and_text_may_not() {
    let wide = "word ".repeat(30);
    let page = format!("# {wide}\n\n| {wide} |\n\n    {wide}\n```text\n{wide}\n```\n{wide}\n- {wide}\n");
    let found = too_wide(Path::new("page.md"), prose(&page));
    let ends: Vec<bool> = [":9: ", ":10: "].iter().zip(&found).map(|(at, line)| line.contains(at)).collect();
    assert_eq!((found.len(), ends), (2, vec![true, true]), "{found:?}");
}
